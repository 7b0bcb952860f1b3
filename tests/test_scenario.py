"""A user's choice as plain numbers: from a mapping, from TOML, and back from a march."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon.errors import FileFormatError, ParameterError
from pymunk_dragon.model.curves import (
    Arc,
    Composite,
    Curve,
    Line,
    Reversed,
    Sampled,
    Section,
    Spiral,
    UTurn,
)
from pymunk_dragon.model.curves.base import MAX_DEPTH
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run, check_saveable
from pymunk_dragon.model.scenario import Scenario

NAMES = [f.name for f in fields(Scenario)]
NUMBERS = ["benches", "head_spacing", "body_spacing", "overhang", "width", "pitch", "turns", "speed"]
# A bend to the right and one to the left, m.
POINTS = ((0.0, 0.0), (10.0, 0.5), (20.0, -3.0), (30.0, -2.0), (40.0, 2.0), (52.0, 3.0))
TABLE = ((0.0, 1.0), (20.0, 2.5), (25.0, 0.5))
HAIRPIN = Composite(
    [
        Line(stop=(20, 0)),
        Arc(centre=(20, 3), radius=3, begin_angle=-math.pi / 2, sweep=math.pi),
        Line(start=(20, 6), stop=(4, 6)),
    ]
)
CURVES = {
    "a line": Line(start=(1, 2), stop=(40, -3)),
    "an arc": Arc(centre=(1, 2), radius=9, begin_angle=0.5, sweep=-6.5),
    "lines and an arc": HAIRPIN,
    "a composite in a composite": Composite([HAIRPIN, Line(start=(4, 6), stop=(-30, 6))]),
    "a part of a spiral": Section(Spiral(pitch=1.1, rotation=0.3), -math.inf, -30),
    "a part of a u-turn": Section(UTurn(ratio=0.5), -50.0, 20.5),
    "a u-turn backwards": Reversed(UTurn()),
    "a path backwards": Reversed(Sampled(POINTS)),
}
MARCHES = {
    "the paper's": {},
    "an outward spiral": {"outward": True, "turns": 20, "benches": 20},
    "a mirrored spiral": {"mirrored": True, "rotation": 0.7},
    "a start on a spiral": {"start_s": -400.0},
    "the u-turn": {"curve": "u-turn"},
    "another u-turn": {"curve": "u-turn", "pitch": 2.0, "radius": 5.0, "ratio": 1.0, "start_s": -3.0, "benches": 20},
    "a path": {"curve": "sampled", "points": POINTS, "benches": 5},
    "a path without its name": {"points": POINTS, "benches": 5, "start_s": 20.0},
    "a table of speeds": {"speed": TABLE},
    **{name: {"curve": curve, "benches": 5} for name, curve in CURVES.items()},
    "a part of a spiral": {"curve": CURVES["a part of a spiral"], "benches": 5, "start_s": -60.0},
    "lists": {"body_spacing": (3.0, 2.0), "overhang": (0.5, 0.3, 0.2), "width": (0.4, 0.5, 0.3)},
}

# No list of one size makes a dragon of two benches.
LONG = {"benches": 223}

every_march = pytest.mark.parametrize("values", MARCHES.values(), ids=MARCHES)


def test_default_scenario_is_the_default_march():
    assert Scenario().march() == March() == March(Dragon(), Spiral(), turns=16, speed=1.0)


@given(st.integers(2, 30), st.floats(0.31, 2), st.floats(10, 40), st.floats(0.01, 20), st.floats(0.6, 3))
def test_march_and_scenario_give_each_other_back(benches, pitch, turns, speed, spacing):
    scenario = Scenario(benches=benches, pitch=pitch, turns=turns, speed=speed, body_spacing=spacing)
    assert Scenario.of(scenario.march()) == scenario
    assert Scenario.from_dict(asdict(scenario)) == scenario
    assert scenario.march().at(0).positions.shape == (1, benches + 1, 2)


def test_what_a_mapping_does_not_name_keeps_its_default():
    assert Scenario.from_dict({"pitch": 0.6}) == Scenario(pitch=0.6)
    assert Scenario.from_dict({}) == Scenario()


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
def test_impossible_value_is_refused_by_the_name_the_user_gave(name, value):
    if name in ("pitch", "turns") and value is None:
        # What a curve may lack is left to its default by None.
        assert Scenario(**{name: None}) == Scenario()
        return
    for make in (lambda: Scenario(**LONG | {name: value}), lambda: Scenario.from_dict(LONG | {name: value})):
        with pytest.raises(ParameterError) as caught:
            make()
        assert caught.value.name == name
        assert_says(caught.value, f"{name} is ", "but must be a ")


@pytest.mark.parametrize("name", ["radius", "ratio"])
@pytest.mark.parametrize("value", [value for value in NO_NUMBERS if value is not None], ids=repr)
def test_impossible_value_of_a_u_turn_is_refused(name, value):
    with pytest.raises(ParameterError) as caught:
        Scenario(curve="u-turn", **{name: value})
    assert_says(caught.value, f"{name} is ", "but must be a number from")


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ({"pitch": 0.3}, "pitch"),
        ({"width": 0.6}, "pitch"),
        ({"benches": 1}, "benches"),
        ({"turns": 2}, "head_spacing"),
        ({"head_spacing": 20}, "head_spacing"),
        ({"body_spacing": 20}, "body_spacing"),
        ({"overhang": 0.9}, "overhang"),
        ({"ratio": 1.0}, "ratio"),
        ({"radius": 4.5}, "radius"),
        ({"points": POINTS, "pitch": 0.55}, "pitch"),
        ({"curve": "spiral", "points": POINTS}, "points"),
        ({"curve": "path.csv", "points": POINTS}, "points"),
        ({"curve": "sampled"}, "points"),
        ({"curve": "u-turn", "turns": 16}, "turns"),
        ({"curve": "u-turn", "outward": True}, "outward"),
        ({"turns": 16, "start_s": -400.0}, "turns"),
        ({"curve": "u-turn", "pitch": 0.0}, "pitch"),
        ({"curve": "circle"}, "curve"),
        ({"curve": ""}, "curve"),
        ({"curve": 3}, "curve"),
        ({"curve": ["u-turn"]}, "curve"),
        ({"speed": []}, "speed"),
        ({"speed": [1.0, 2.0]}, "speed"),
        ({"speed": [[0, 1], [1]]}, "speed"),
        ({"speed": [[0, 1], [1, 0]]}, "speeds[1]"),
        ({"speed": "fast"}, "speed"),
        ({"speed": "nowhere.csv"}, "speed"),
        ({"width": [0.3] * 3, "benches": 4}, "width"),
    ],
)
def test_numbers_that_do_not_go_together_are_refused(values, name):
    with pytest.raises(ParameterError) as caught:
        Scenario(**values)
    assert caught.value.name == name
    assert_says(caught.value, f"{name} is ", "must be")


@pytest.mark.parametrize("name", ["pich", "march", "", "Pitch", "a\nb"])
def test_unknown_name_is_refused_with_the_known_ones(name):
    with pytest.raises(ParameterError) as caught:
        Scenario.from_dict({name: 0.6})
    assert_says(caught.value, *NAMES)


def test_numpy_scalars_become_plain_numbers():
    scenario = Scenario(benches=np.int32(5), pitch=np.float32(0.5), speed=np.float64(2), turns=np.int64(12))
    assert scenario == Scenario(benches=5, pitch=0.5, speed=2.0, turns=12.0)
    values = [getattr(scenario, name) for name in NUMBERS]
    assert [type(value) for value in values] == [int] + [float] * 7


@every_march
def test_march_written_down_is_the_same_march(values):
    scenario = Scenario(**values)
    # As a file holds it: lists for tuples.
    written = json.loads(json.dumps(scenario.to_dict()))
    again = Scenario.from_dict(written)
    assert again.to_dict() == scenario.to_dict()
    assert (again, hash(again)) == (scenario, hash(scenario))
    assert Scenario.of(scenario.march()) == scenario
    times = [-0.5, 0.0, 0.7]
    one, other = scenario.march(), Scenario.from_dict(written).march()
    np.testing.assert_array_equal(one.handles_s_or_nan(times), other.handles_s_or_nan(times))
    np.testing.assert_array_equal(one.at(0.0).positions, other.at(0.0).positions)


@every_march
def test_run_is_saved_and_read_whatever_march_it_is_of(tmp_path, values):
    march = Scenario(**values).march()
    Run.exact(march, [0.0, 0.5]).save(tmp_path / "run.npz")
    back = Run.load(tmp_path / "run.npz")
    assert back == Run.exact(march, [0.0, 0.5])
    np.testing.assert_array_equal(back.march.at([0.0, 0.5]).poses, back.poses)
    back.save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "run.npz").read_bytes()


def test_the_papers_march_is_written_as_ever():
    sizes = {"benches": 223, "head_spacing": 2.86, "body_spacing": 1.65, "overhang": 0.275, "width": 0.3}
    spiral = {"kind": "spiral", "pitch": 0.55, "rotation": 0.0, "mirrored": False, "outward": False}
    expected = {"dragon": sizes, "curve": spiral, "turns": 16.0, "speed": 1.0}
    assert json.dumps(Scenario().to_dict()) == json.dumps(expected)
    numbers = [223, 2.86, 1.65, 0.275, 0.3, 0.55, 16.0, 1.0]
    assert Scenario.from_dict(dict(zip(NUMBERS, numbers, strict=True))) == Scenario()


def test_tables_of_a_toml_file_are_read_and_names_at_its_top_level_win():
    tables = {"dragon": {"benches": 16}, "curve": {"kind": "spiral", "pitch": 0.6}, "turns": 8}
    assert Scenario.from_dict(tables) == Scenario(benches=16, pitch=0.6, turns=8)
    assert Scenario.from_dict({**tables, "benches": 9, "pitch": 0.7}) == Scenario(benches=9, pitch=0.7, turns=8)
    for table, name in (({"dragon": {"pitch": 0.6}}, "dragon.pitch"), ({"dragon": 16}, "dragon")):
        with pytest.raises(ParameterError) as caught:
            Scenario.from_dict(table)
        assert caught.value.name == name


def test_u_turn_is_the_contests():
    march = Scenario(curve="u-turn").march()
    assert (march.curve.pitch, march.curve.radius, march.curve.ratio) == (1.7, 4.5, 2.0)
    assert np.hypot(*march.at(0.0).positions[0, 0]) == pytest.approx(4.5)


def test_curve_and_speed_may_be_files_beside_the_scenario(tmp_path):
    (tmp_path / "path.csv").write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in POINTS))
    (tmp_path / "speed.csv").write_text("".join(f"{t},{v}\n" for t, v in TABLE))
    (tmp_path / "s.toml").write_text('benches = 5\ncurve = "path.csv"\nspeed = "speed.csv"\n')
    scenario = Scenario.from_dict(Scenario.read(tmp_path / "s.toml"))
    assert scenario == Scenario(benches=5, points=POINTS, speed=TABLE)
    assert scenario.curve == "sampled"
    assert Scenario(benches=5, curve=str(tmp_path / "path.csv"), speed=TABLE) == scenario


def test_file_of_too_few_points_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("path.csv").write_text("0,0\n10,0\n20,1\n")
    with pytest.raises(ParameterError) as caught:
        Scenario(curve="path.csv")
    assert caught.value.name == "curve"
    assert_says(caught.value, "path.csv", "4 to 50000 points")


def test_lists_and_tables_stand_in_a_toml_file(tmp_path):
    (tmp_path / "s.toml").write_text(
        "body_spacing = [3, 2.0]\nwidth = [0.4, 0.5, 0.3]\nspeed = [[0, 1], [20, 2.5], [25, 0.5]]"
    )
    scenario = Scenario.from_dict(Scenario.read(tmp_path / "s.toml"))
    assert scenario == Scenario(body_spacing=(3.0, 2.0), width=(0.4, 0.5, 0.3), speed=TABLE)
    assert scenario.benches == 3


def test_toml_file_holds_names_and_values(tmp_path):
    file = tmp_path / "small.toml"
    file.write_text("# a small dragon\nbenches = 16\npitch = 0.6\nturns = 8\n", encoding="utf-8")
    assert Scenario.from_dict(Scenario.read(file)) == Scenario(benches=16, pitch=0.6, turns=8)
    assert Scenario.read(str(file)) == {"benches": 16, "pitch": 0.6, "turns": 8}


def test_flags_replace_single_values_of_nested_tables(tmp_path):
    (tmp_path / "s.toml").write_text('[dragon]\nbenches = 5\n[curve]\nkind = "u-turn"\nradius = 5\nratio = 1\n')
    read = Scenario.read(tmp_path / "s.toml")
    assert Scenario.from_dict(read | {"curve": "u-turn", "ratio": 3}) == Scenario(
        benches=5, curve="u-turn", radius=5, ratio=3
    )


def test_kind_of_a_table_is_no_file(tmp_path):
    (tmp_path / "s.toml").write_text('[curve]\nkind = "path.csv"\n')
    with pytest.raises(ParameterError) as caught:
        Scenario.from_dict(Scenario.read(tmp_path / "s.toml"))
    assert caught.value.name == "curve.kind"


def test_runs_with_the_former_names_of_arc_lengths_are_read(tmp_path, monkeypatch):
    march = March(Dragon(benches=5), Section(Spiral(), -400.0, -10.0), start_s=-60.0)
    run = Run.exact(march, [0.0, 0.5])
    table = {"kind": "section", "curve": {"kind": "spiral"}, "begin": -400.0, "end": -10.0}
    former = {"benches": 5, "curve": table, "start": -60.0, "speed": 1.0}
    monkeypatch.setattr(Scenario, "to_dict", lambda self: former)
    run.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz") == run


BROKEN = {
    "no value": b"pitch =",
    "no TOML": b"pitch: 0.6",
    "twice": b"pitch = 0.6\npitch = 0.7",
    "no text": b"\xff\xfe\x00pitch",
    "a number of 5000 digits": b"benches = " + b"9" * 5000,
    "brackets in brackets": b"pitch = " + b"[" * 5000,
    "a key of 100,000 parts": b"a." * 99_999 + b"a = 1",
    "a key of 100,000 parts between quotes": b"'a'. \"b\" ." * 50_000 + b"a = 1",
    "a table of 100,000 parts": b"[" + b"a." * 99_999 + b"a]",
    "a table in a table": b"pitch = {" + b"a." * 99_999 + b"a = 1}",
    "too large": b"# " + b"x" * 4_000_000,
}


@pytest.mark.parametrize("content", BROKEN.values(), ids=BROKEN.keys())
def test_broken_toml_is_named_in_one_line(tmp_path, content):
    file = tmp_path / "broken.toml"
    file.write_bytes(content)
    with pytest.raises(FileFormatError) as caught:
        Scenario.read(file)
    assert str(caught.value).startswith(f"{file}: no TOML file: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content", [b"benches = '16'", b"[dragon]\nbenches = '16'", b"pitch = nan", b"turns = 1979-05-27"]
)
def test_toml_with_values_of_the_wrong_kind_is_refused(tmp_path, content):
    file = tmp_path / "wrong.toml"
    file.write_bytes(content)
    with pytest.raises(ParameterError) as caught:
        Scenario.from_dict(Scenario.read(file))
    assert_says(caught.value, "but must be")


def test_scenario_without_end_is_refused():
    with pytest.raises(FileFormatError, match="/dev/zero: no TOML file: larger than 4 MB"):
        Scenario.read("/dev/zero")


def test_key_of_a_few_parts_and_long_lists_are_read(tmp_path):
    file = tmp_path / "s.toml"
    points = [[10.5 * x, 0.25] for x in range(50_000)]
    file.write_text(f"# See example.com/a.b.c.\npoints = {points}\ncurve.kind.of = 1\n")
    assert Scenario.read(file) == {"points": points, "curve": {"kind": {"of": 1}}}


def test_file_of_points_may_hold_4_to_50000(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = Path("path.csv")
    for count in (3, 50_001):
        file.write_text("".join(f"{x},0\n" for x in range(count)))
        with pytest.raises(ParameterError) as caught:
            Scenario(curve=str(file))
        assert caught.value.name == "curve"
        assert_says(caught.value, "path.csv", "4 to 50000 points")


def test_line_of_an_impossible_point_is_named(tmp_path):
    file = tmp_path / "path.csv"
    file.write_text("x,y\n0,0\n\n10,0\n1e9,0\n30,0\n")
    with pytest.raises(FileFormatError) as caught:
        Scenario(curve=str(file))
    assert_says(caught.value, "path.csv: line 5", "1000000000.0")


def test_missing_scenario_file_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("folder").mkdir()
    for path in (Path("none.toml"), Path("folder")):
        with pytest.raises(ParameterError) as caught:
            Scenario.read(path)
        assert caught.value.name == "scenario"
        assert str(path.name) in str(caught.value)


def test_speed_that_is_a_function_is_refused_before_a_run_is_made(tmp_path):
    march = March(speed=lambda t: 1 + 0 * t)
    run = Run.exact(march, [0.0])
    for refuse in (Scenario.of, check_saveable, lambda _: run.save(tmp_path / "run.npz")):
        with pytest.raises(ParameterError) as caught:
            refuse(march)
        assert caught.value.name == "speed"
        assert_says(caught.value, "a number or a table to be written down, not a function of time")
    assert list(tmp_path.iterdir()) == []


class Wide(Spiral):
    """A curve of a user's own, which may override anything."""


class Other(Curve):
    """A curve that is no Spiral, though it lies where one does."""

    begin_s, end_s = -np.inf, 0.0

    def point(self, s):
        return Spiral().point(s)

    def tangent(self, s):
        return Spiral().tangent(s)

    def curvature(self, s):
        return Spiral().curvature(s)

    def max_curvature(self, s, other):
        return Spiral().max_curvature(s, other)


@pytest.mark.parametrize(
    ("curve", "where", "kind"),
    [
        (Wide(), "curve", "Wide"),
        (Other(), "curve", "Other"),
        (Reversed(Other()), "curve.curve", "Other"),
        (Composite([Section(Other(), -400, -100)]), "curve.pieces[0].curve", "Other"),
    ],
)
def test_curve_of_a_users_own_class_is_refused_before_a_run_is_made(curve, where, kind):
    march = March(Dragon(benches=3), curve, start_s=max(curve.begin_s, -450) + 50)
    with pytest.raises(ParameterError) as caught:
        check_saveable(march)
    assert (caught.value.name, caught.value.value) == (where, kind)
    assert_says(caught.value, "must be a curve of the package")


def test_registered_curve_of_a_users_own_is_saved_and_read(tmp_path, monkeypatch):
    monkeypatch.setattr(Curve, "kinds", dict(Curve.kinds))

    @dataclass(frozen=True)
    class Axis(Curve, kind="axis"):
        """The x axis."""

        end_s: float
        begin_s: ClassVar[float] = 0.0

        def point(self, s):
            return np.stack([np.asarray(s), np.zeros(np.shape(s))], axis=-1)

        def tangent(self, s):
            return np.stack([np.ones(np.shape(s)), np.zeros(np.shape(s))], axis=-1)

        def curvature(self, s):
            return np.zeros(np.shape(s))

        def max_curvature(self, s, other):
            return 0.0

    (tmp_path / "s.toml").write_text('dragon = {benches = 4}\ncurve = {kind = "axis", end_s = 50}\n')
    march = Scenario.from_dict(Scenario.read(tmp_path / "s.toml")).march()
    assert march == March(Dragon(benches=4), Axis(50))
    Run.exact(march, [0.0, 1.0]).save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz").march == march


# Curves as tables


def test_every_curve_of_the_package_has_a_table():
    from pymunk_dragon.model import curves

    own = {made for made in vars(curves).values() if isinstance(made, type) and made is not Curve}
    assert set(Curve.kinds.values()) == own


@pytest.mark.parametrize("curve", [*CURVES.values(), Spiral(), UTurn(), Sampled(POINTS)], ids=repr)
def test_curve_comes_back_from_its_table_to_the_last_bit(curve):
    again = Curve.from_dict(json.loads(json.dumps(curve.to_dict())))
    assert type(again) is type(curve)
    assert (again.begin_s, again.end_s) == (curve.begin_s, curve.end_s)
    middle = max(curve.begin_s, -40.0) / 2 + min(curve.end_s, 40.0) / 2
    places = middle + np.array([[-5.0, -0.3], [0.0, 4.0]])
    for method in ("point", "tangent", "curvature"):
        np.testing.assert_array_equal(getattr(again, method)(places), getattr(curve, method)(places))


def test_tables_of_a_curve_stand_in_a_toml_file(tmp_path):
    (tmp_path / "s.toml").write_text("""
        benches = 4
        start_s = 30
        [curve]
        kind = "composite"
        pieces = [
            {kind = "line", stop = [20, 0]},
            {kind = "arc", centre = [20, 3], radius = 3, begin_angle = -1.5707963267948966, sweep = 3.141592653589793},
            {kind = "line", start = [20, 6], stop = [4, 6]},
        ]
        """)
    scenario = Scenario.from_dict(Scenario.read(tmp_path / "s.toml"))
    assert scenario == Scenario(benches=4, start_s=30, curve=HAIRPIN)


def test_table_of_a_curve_with_a_short_form_is_the_short_form():
    assert Scenario(curve={"kind": "spiral", "pitch": 0.6}) == Scenario(pitch=0.6)
    assert Scenario(curve=UTurn(ratio=3)) == Scenario(curve="u-turn", ratio=3)


LINE_TABLE = {"kind": "line", "stop": [20, 0]}


@pytest.mark.parametrize(
    ("values", "name", "words"),
    [
        ({"curve": {}}, "curve.kind", "one of arc, composite, line"),
        ({"curve": {"kind": "circle"}}, "curve.kind", "one of arc, composite, line"),
        ({"curve": {"kind": ["line"]}}, "curve.kind", "one of arc, composite, line"),
        ({"curve": {"kind": "line"}}, "curve.stop", "given: the kind line has no default for it"),
        ({"curve": LINE_TABLE | {"end": 3}}, "curve.end", "absent on a line curve; its parameters are start, stop"),
        ({"curve": LINE_TABLE | {"start": 3}}, "curve.start", "two numbers x, y"),
        ({"curve": LINE_TABLE | {"start": LINE_TABLE}}, "curve.start", "two numbers x, y"),
        ({"curve": LINE_TABLE, "pitch": 0.5}, "pitch", "absent where the curve is a table"),
        ({"curve": {"kind": "reversed", "curve": 3}}, "curve.curve", "a Curve"),
        ({"curve": {"kind": "sampled", "points": "path.csv"}}, "curve.points", "each x and y in m"),
        ({"curve": {"kind": "composite", "pieces": [3]}}, "curve.pieces", "one Curve or more"),
        ({"curve": {"kind": "composite", "pieces": [LINE_TABLE, 3]}}, "curve.pieces", "one Curve or more"),
        ({"curve": {"kind": "composite", "pieces": [LINE_TABLE, {"kind": "arc"}]}}, "curve.pieces[1].radius", "given"),
        ({"curve": {"kind": "composite", "pieces": [LINE_TABLE, LINE_TABLE]}}, "curve.pieces", "joined smoothly"),
        ({"curve": {"kind": "arc", "radius": -1, "sweep": 1}}, "curve.radius", "a number from 0.001"),
    ],
)
def test_table_that_describes_no_curve_is_refused_by_the_way_to_its_fault(values, name, words):
    with pytest.raises(ParameterError) as caught:
        Scenario(benches=5, **values)
    assert caught.value.name == name
    assert_says(caught.value, words)


def test_curves_nest_as_deep_as_python_can_evaluate_them():
    table = LINE_TABLE
    for _ in range(MAX_DEPTH - 1):
        table = {"kind": "composite", "pieces": [table]}
    deepest = Curve.from_dict(table)
    assert deepest.point(4.0).tolist() == [4, 0]
    assert Curve.from_dict(deepest.to_dict()) == deepest
    deeper = Reversed(deepest)
    with pytest.raises(ParameterError) as caught:
        deeper.to_dict()
    assert_says(caught.value, "nested in at most 31 other curves")
    for _ in range(100_000):
        table = {"kind": "reversed", "curve": table}
    with pytest.raises(ParameterError) as caught:
        Curve.from_dict(table)
    assert_says(caught.value, "nested in at most 31 other curves")
