"""A user's choice as plain numbers: from a mapping, from TOML, and back from a march."""

from __future__ import annotations

from dataclasses import asdict, fields

import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon.curves import Curve, Spiral
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.scenario import Scenario

NAMES = [f.name for f in fields(Scenario)]


def test_default_scenario_is_the_default_march():
    assert Scenario().march() == March() == March(Dragon(), Spiral(), turns=16, speed=1.0)


@given(st.integers(2, 30), st.floats(0.31, 2), st.floats(10, 40), st.floats(0.01, 20), st.floats(0.6, 3))
def test_march_and_scenario_give_each_other_back(benches, pitch, turns, speed, spacing):
    scenario = Scenario(benches=benches, pitch=pitch, turns=turns, speed=speed, body_spacing=spacing)
    assert Scenario.of(scenario.march()) == scenario
    assert Scenario.from_mapping(asdict(scenario)) == scenario
    assert scenario.march().at(0).positions.shape == (1, benches + 1, 2)


def test_what_a_mapping_does_not_name_keeps_its_default():
    assert Scenario.from_mapping({"pitch": 0.6}) == Scenario(pitch=0.6)
    assert Scenario.from_mapping({}) == Scenario()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
def test_impossible_value_is_refused_by_the_name_the_user_gave(name, value):
    for make in (lambda: Scenario(**{name: value}), lambda: Scenario.from_mapping({name: value})):
        with pytest.raises(ParameterError) as caught:
            make()
        assert caught.value.name == name
        assert_says(caught.value, f"{name} is ", "but must be a ")


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
        Scenario.from_mapping({name: 0.6})
    assert_says(caught.value, *NAMES)


def test_numpy_scalars_become_plain_numbers():
    scenario = Scenario(benches=np.int32(5), pitch=np.float32(0.5), speed=np.float64(2), turns=np.int64(12))
    assert scenario == Scenario(benches=5, pitch=0.5, speed=2.0, turns=12.0)
    assert [type(value) for value in asdict(scenario).values()] == [int] + [float] * 7


def test_toml_file_holds_names_and_values(tmp_path):
    file = tmp_path / "small.toml"
    file.write_text("# a small dragon\nbenches = 16\npitch = 0.6\nturns = 8\n", encoding="utf-8")
    assert Scenario.from_mapping(Scenario.read(file)) == Scenario(benches=16, pitch=0.6, turns=8)
    assert Scenario.read(str(file)) == {"benches": 16, "pitch": 0.6, "turns": 8}


BROKEN = {
    "no value": b"pitch =",
    "no TOML": b"pitch: 0.6",
    "twice": b"pitch = 0.6\npitch = 0.7",
    "no text": b"\xff\xfe\x00pitch",
    "a number of 5000 digits": b"benches = " + b"9" * 5000,
    "brackets in brackets": b"pitch = " + b"[" * 5000,
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
    "content", [b"benches = '16'", b"[dragon]\nbenches = 16", b"pitch = nan", b"turns = 1979-05-27"]
)
def test_toml_with_values_of_the_wrong_kind_is_refused(tmp_path, content):
    file = tmp_path / "wrong.toml"
    file.write_bytes(content)
    with pytest.raises(ParameterError) as caught:
        Scenario.from_mapping(Scenario.read(file))
    assert_says(caught.value, "but must be")


def test_missing_scenario_file_is_named(tmp_path):
    for path in (tmp_path / "none.toml", tmp_path):
        with pytest.raises(ParameterError) as caught:
            Scenario.read(path)
        assert caught.value.name == "scenario"
        assert str(path.name) in str(caught.value)


def test_march_on_another_curve_has_no_scenario():
    class Wide(Spiral):
        pass

    class Other:
        """A curve that is no Spiral, though it lies where one does."""

        def __init__(self):
            for name in (name for name in dir(Curve) if not name.startswith("_")):
                setattr(self, name, getattr(Spiral(), name))

    assert Scenario.of(March(Dragon(), Wide())) == Scenario()
    with pytest.raises(DragonError, match="on a Spiral, not on a Other"):
        Scenario.of(March(Dragon(), Other()))
