"""A user's choice as plain numbers: from a mapping, from TOML, and back from a march."""

import json
import math

import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says, linux_only, refusal
from test_curve_kinds import LONGER, PATH, LogarithmicSpiral

from pymunk_dragon import Dragon, March, Run, Scenario
from pymunk_dragon.errors import FileFormatError
from pymunk_dragon.model import curves
from pymunk_dragon.model.curves import (
    Arc,
    Composite,
    Curve,
    Reversed,
    Sampled,
    Section,
    Spiral,
    UTurn,
)

NUMBERS = [
    "benches",
    "head_spacing",
    "body_spacing",
    "overhang",
    "width",
    "pitch",
    "turns",
    "speed",
]
# A bend to the right and one to the left, m.
POINTS = ((0.0, 0.0), (10.0, 0.5), (20.0, -3.0), (30.0, -2.0), (40.0, 2.0), (52.0, 3.0))
TABLE = ((0.0, 1.0), (20.0, 2.5), (25.0, 0.5))
MARCHES = {
    "the paper's": {},
    "an outward spiral": {"outward": True, "turns": 20, "benches": 20},
    "a turned spiral": {"rotation": 0.7, "start_s": -400.0, "benches": 20},
    "the u-turn": {"curve": "u-turn", "benches": 20},
    "another u-turn": {
        "curve": "u-turn",
        "pitch": 2.0,
        "radius": 5.0,
        "ratio": 1.0,
        "start_s": -3.0,
        "benches": 20,
    },
    "a path": {"curve": "sampled", "points": POINTS, "benches": 5},
    "a path without its name": {"points": POINTS, "benches": 5, "start_s": 20.0},
    "a table of speeds": {"speed": TABLE, "benches": 20},
    "lists": {"body_spacing": (3.0, 2.0), "overhang": (0.5, 0.3, 0.2), "width": (0.4, 0.5, 0.3)},
    "an arc": {"curve": Arc(centre=(1, 2), radius=9, begin_angle=0.5, sweep=-6.5), "benches": 5},
    "a composite in a composite": {"curve": LONGER, "benches": 5},
    "a part of a spiral": {
        "curve": Section(Spiral(pitch=1.1), -math.inf, -30),
        "benches": 5,
        "start_s": -60.0,
    },
    "a part of a u-turn": {"curve": Section(UTurn(ratio=0.5), -50.0, 20.5), "benches": 5},
    "a path backwards": {"curve": Reversed(Sampled(POINTS)), "benches": 5},
}
LINE = {"kind": "line", "stop": [20, 0]}


def of_toml(folder, content):
    """The scenario in a TOML file."""
    file = folder / "s.toml"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return Scenario.from_dict(Scenario.read(file))


def test_default_scenario_is_the_papers_march_and_is_written_as_ever():
    assert Scenario().march() == March() == March(Dragon(), Spiral(), turns=16, speed=1.0)
    sizes = {
        "benches": 223,
        "head_spacing": 2.86,
        "body_spacing": 1.65,
        "overhang": 0.275,
        "width": 0.3,
    }
    spiral = {"kind": "spiral", "pitch": 0.55, "rotation": 0.0, "outward": False}
    expected = {"dragon": sizes, "curve": spiral, "turns": 16.0, "speed": 1.0}
    assert json.dumps(Scenario().to_dict()) == json.dumps(expected)
    numbers = [223, 2.86, 1.65, 0.275, 0.3, 0.55, 16.0, 1.0]
    assert (
        Scenario.from_dict(dict(zip(NUMBERS, numbers, strict=True)))
        == Scenario.from_dict({})
        == Scenario()
    )


@pytest.mark.parametrize("values", MARCHES.values(), ids=MARCHES)
def test_march_written_down_or_saved_is_the_same_march(tmp_path, values):
    scenario = Scenario(**values)
    # As a file holds it: lists for tuples.
    again = Scenario.from_dict(json.loads(json.dumps(scenario.to_dict())))
    assert again.to_dict() == scenario.to_dict()
    assert (again, hash(again)) == (scenario, hash(scenario))
    assert Scenario.of(scenario.march()) == scenario
    times = [-0.5, 0.0, 0.7]
    one, other = scenario.march(), again.march()
    np.testing.assert_array_equal(
        one.motion_or_nan(times).handles_s, other.motion_or_nan(times).handles_s
    )
    np.testing.assert_array_equal(one.at(0.0).positions, other.at(0.0).positions)
    run = Run.exact(one, [0.0, 0.5])
    run.save(tmp_path / "run.npz")
    back = Run.load(tmp_path / "run.npz")
    assert back == run
    np.testing.assert_array_equal(back.march.at([0.0, 0.5]).poses, back.poses)
    back.save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "run.npz").read_bytes()


def test_impossible_values_are_refused_by_the_name_that_the_user_gave():
    for value in NO_NUMBERS:
        for name in NUMBERS:
            if name in ("benches", "pitch", "turns") and value is None:
                # What may be absent is left to its default by None.
                assert Scenario(**{name: None}) == Scenario()
            else:
                # No list of one size makes a dragon of 223 benches.
                assert refusal(Scenario.from_dict, {"benches": 223, name: value}).name == name
        for name in ("radius", "ratio") if value is not None else ():
            assert refusal(Scenario, curve="u-turn", **{name: value}).name == name
    for name in ("pich", "march", "", "a\nb"):
        assert_says(refusal(Scenario.from_dict, {name: 0.6}), *NUMBERS)
    for table, name in (({"dragon": {"pitch": 0.6}}, "dragon.pitch"), ({"dragon": 16}, "dragon")):
        assert refusal(Scenario.from_dict, table).name == name


def test_values_that_do_not_go_together_are_refused_by_name():
    for name, *cases in (
        (
            "pitch",
            {"pitch": 0.3},
            {"width": 0.6},
            {"points": POINTS, "pitch": 0.55},
            {"curve": LINE, "pitch": 0.5},
        ),
        ("head_spacing", {"turns": 2}, {"head_spacing": 20}),
        ("body_spacing", {"body_spacing": 20}),
        ("overhang", {"overhang": 0.9}),
        ("ratio", {"ratio": 1.0}),
        ("points", *({"curve": curve, "points": POINTS} for curve in ("spiral", "path.csv", LINE))),
        ("points", {"curve": "sampled"}),
        ("turns", {"curve": "u-turn", "turns": 16}, {"turns": 16, "start_s": -400.0}),
        ("outward", {"curve": "u-turn", "outward": True}),
        ("curve", {"curve": "circle"}, {"curve": ""}, {"curve": 3}),
        ("speed", *({"speed": each} for each in ([], [1.0, 2.0], [[0, 1], [1]], "fast", "no.csv"))),
        ("speeds[1]", {"speed": [[0, 1], [1, 0]]}),
        ("width", {"width": [0.3] * 3, "benches": 4}),
    ):
        for values in cases:
            assert refusal(Scenario, **values).name == name, values


def test_toml_file_holds_names_tables_and_lists(tmp_path):
    pieces = json.dumps(PATH.to_dict()["pieces"]).replace('": ', '" = ')
    for content, expected in (
        (
            "# a small dragon\nbenches = 16\npitch = 0.6\nturns = 8\n",
            {"benches": 16, "pitch": 0.6, "turns": 8},
        ),
        (
            "[dragon]\nbenches = 16\n[curve]\nkind = 'spiral'\npitch = 0.6\n",
            {"benches": 16, "pitch": 0.6},
        ),
        (
            "body_spacing = [3, 2.0]\nwidth = [0.4, 0.5, 0.3]",
            {"body_spacing": (3.0, 2.0), "width": (0.4, 0.5, 0.3)},
        ),
        ("speed = [[0, 1], [20, 2.5], [25, 0.5]]", {"speed": TABLE}),
        (
            f"benches = 4\n[curve]\nkind = 'composite'\npieces = {pieces}",
            {"benches": 4, "curve": PATH},
        ),
    ):
        assert of_toml(tmp_path, content) == Scenario(**expected)


def test_names_at_the_top_level_win_over_tables(tmp_path):
    tables = {"dragon": {"benches": 16}, "curve": {"kind": "spiral", "pitch": 0.6}, "turns": 8}
    assert Scenario.from_dict({**tables, "benches": 9, "pitch": 0.7}) == Scenario(
        benches=9, pitch=0.7, turns=8
    )
    (tmp_path / "s.toml").write_text(
        '[dragon]\nbenches = 5\n[curve]\nkind = "u-turn"\nradius = 5\nratio = 1\n'
    )
    read = Scenario.read(tmp_path / "s.toml") | {"curve": "u-turn", "ratio": 3}
    assert Scenario.from_dict(read) == Scenario(benches=5, curve="u-turn", radius=5, ratio=3)


def test_curve_and_speed_may_be_files_beside_the_scenario(tmp_path):
    path = tmp_path / "path.csv"
    path.write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in POINTS))
    (tmp_path / "speed.csv").write_text("".join(f"{t},{v}\n" for t, v in TABLE))
    scenario = of_toml(tmp_path, 'benches = 5\ncurve = "path.csv"\nspeed = "speed.csv"\n')
    assert scenario == Scenario(benches=5, points=POINTS, speed=TABLE)
    assert Scenario(benches=5, curve=str(path), speed=TABLE) == scenario
    assert refusal(of_toml, tmp_path, '[curve]\nkind = "path.csv"\n').name == "curve.kind"
    for count in (3, 50_001):
        path.write_text("".join(f"{x},0\n" for x in range(count)))
        error = refusal(Scenario, curve=str(path))
        assert error.name == "curve"
        assert_says(error, "path.csv", "4 to 50000 points")
    path.write_text("x,y\n0,0\n\n10,0\n1e9,0\n30,0\n")
    assert_says(
        refusal(Scenario, curve=str(path), error=FileFormatError),
        "path.csv: line 5",
        "1000000000.0",
    )


@linux_only
def test_files_that_are_no_scenario_are_refused(tmp_path):
    for content in (
        b"pitch =",
        b"pitch: 0.6",
        b"pitch = 0.6\npitch = 0.7",
        b"\xff\xfe\x00pitch",
        b"benches = " + b"9" * 5000,
        b"pitch = " + b"[" * 5000,
        # Such keys take tomllib minutes.
        b"a." * 99_999 + b"a = 1",
        b"'a'. \"b\" ." * 50_000 + b"a = 1",
        b"[" + b"a." * 99_999 + b"a]",
        b"pitch = {" + b"a." * 99_999 + b"a = 1}",
        b"# " + b"x" * 4_000_000,
    ):
        assert_says(
            refusal(of_toml, tmp_path, content, error=FileFormatError), f"{tmp_path / 's.toml'}: "
        )
    for content in (
        "benches = '16'",
        "[dragon]\nbenches = '16'",
        "pitch = nan",
        "turns = 1979-05-27",
    ):
        assert refusal(of_toml, tmp_path, content).name in content
    for path in (tmp_path / "none.toml", tmp_path):
        assert refusal(Scenario.read, path).name == "scenario"
    refusal(Scenario.read, "/dev/zero", error=FileFormatError)
    # But long lists and keys of a few parts are read.
    points = [[10.5 * x, 0.25] for x in range(50_000)]
    (tmp_path / "s.toml").write_text(
        f"# See example.com/a.b.c.\npoints = {points}\ncurve.kind.of = 1\n"
    )
    assert Scenario.read(tmp_path / "s.toml") == {"points": points, "curve": {"kind": {"of": 1}}}


def test_what_cannot_be_written_down_is_refused_before_a_run_is_made(tmp_path):
    march = March(Dragon(benches=3), Composite([Section(LogarithmicSpiral(), 1, 100)]), start_s=50)
    run = Run.exact(march, [0.0])
    for refuse in (Scenario.of, lambda march: run.save(tmp_path / "run.npz")):
        error = refusal(refuse, march)
        assert error.name == "curve.pieces[0].curve"
        assert error.value == "LogarithmicSpiral"
    assert list(tmp_path.iterdir()) == []


def test_table_of_a_curve_with_a_short_form_is_the_short_form():
    own = {made for made in vars(curves).values() if isinstance(made, type) and made is not Curve}
    assert set(Curve.kinds.values()) >= own
    assert Scenario(curve={"kind": "spiral", "pitch": 0.6}) == Scenario(pitch=0.6)
    assert Scenario(curve=UTurn(ratio=3)) == Scenario(curve="u-turn", ratio=3)


def test_table_that_describes_no_curve_is_refused_by_the_way_to_its_fault():
    for table, name in (
        ({"kind": "circle"}, "kind"),
        ({"kind": "line"}, "stop"),
        (LINE | {"end": 3}, "end"),
        (LINE | {"start": LINE}, "start"),
        ({"kind": "reversed", "curve": 3}, "curve"),
        ({"kind": "sampled", "points": "path.csv"}, "points"),
        ({"kind": "composite", "pieces": [LINE, 3]}, "pieces"),
        ({"kind": "composite", "pieces": [LINE, {"kind": "arc"}]}, "pieces[1].radius"),
        ({"kind": "composite", "pieces": [LINE, LINE]}, "pieces"),
    ):
        assert refusal(Scenario, benches=5, curve=table).name == f"curve.{name}"


def test_curves_nest_as_deep_as_python_can_evaluate_them():
    table = LINE
    for _ in range(31):
        table = {"kind": "composite", "pieces": [table]}
    deepest = Curve.from_dict(table)
    assert deepest.point(4.0).tolist() == [4, 0]
    assert Curve.from_dict(deepest.to_dict()) == deepest
    refusal(Reversed(deepest).to_dict)
    for _ in range(100_000):
        table = {"kind": "reversed", "curve": table}
    refusal(Curve.from_dict, table)
