"""The speed limit in the turn: against many digits, and against looking as often as patience allows."""

from __future__ import annotations

import json
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says
from exact_curves import DIGITS, u_turn, walked_chain
from PIL import Image

from pymunk_dragon.cli import main
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.curves import UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies import MaxSpeed, max_speed


@pytest.fixture(scope="module")
def answer() -> MaxSpeed:
    return max_speed()


def scanned(dragon: Dragon, curve: UTurn, begin: float, end: float, step: float) -> tuple[float, float]:
    """The largest speed over the head's that looking every `step` m sees, and where the head is then."""
    ways = np.arange(begin, end, step)
    fastest = np.concatenate(
        [March(dragon, curve).at(part).speeds.max(axis=1) for part in np.array_split(ways, max(1, ways.size // 500))]
    )
    return float(fastest.max()), float(ways[fastest.argmax()])


def test_the_ratio_at_the_limit_is_the_one_in_many_digits(answer: MaxSpeed) -> None:
    """And neither a nanometre before nor one after is it larger: the moment is right as well."""
    with mp.workdps(DIGITS):
        truth, spacings, tiny = u_turn(), answer.dragon.spacings[: answer.handle], mp.mpf("1e-15")

        def ratio(way: float) -> mp.mpf:
            before, after = (walked_chain(truth, mp.mpf(way) + sign * tiny, spacings)[-1] for sign in (-1, 1))
            return (after - before) / (2 * tiny)

        there = ratio(answer.distance)
        assert abs(there - mp.mpf(answer.ratio)) < 1e-11
        for away in (-1e-3, 1e-3):
            assert ratio(answer.distance + away) < there


def test_the_speed_is_the_limit_over_the_ratio(answer: MaxSpeed) -> None:
    assert answer.speed * answer.ratio == pytest.approx(2, rel=1e-15)
    fast = March(curve=UTurn(), speed=answer.speed).at(answer.time).speeds[0]
    assert fast.max() == pytest.approx(2, abs=1e-8)
    assert fast[list(answer.handles)] == pytest.approx(np.full(len(answer.handles), 2.0), abs=1e-8)
    assert max_speed(limit=1.0).speed == pytest.approx(answer.speed / 2, rel=1e-15)


def test_nobody_is_faster_however_long_one_looks(answer: MaxSpeed) -> None:
    coarse, way = scanned(answer.dragon, answer.curve, -10.0, 40.0, 0.02)
    assert coarse <= answer.ratio * (1 + 1e-12)
    assert way == pytest.approx(answer.distance, abs=0.02)
    fine, _ = scanned(answer.dragon, answer.curve, answer.distance - 2e-3, answer.distance + 2e-3, 4e-6)
    assert answer.ratio - 1e-9 < fine <= answer.ratio * (1 + 1e-12)
    # The whole dragon's way through the turn, and long after.
    later, _ = scanned(answer.dragon, answer.curve, 40.0, 500.0, 0.5)
    assert later < answer.ratio - 0.4


@pytest.mark.parametrize(
    ("dragon", "sizes"),
    [
        (Dragon(), {"ratio": 1.0}),
        (Dragon(), {"pitch": 1.2, "radius": 5.0, "ratio": 1.5}),
        (Dragon(benches=30, head_spacing=1.65), {"ratio": 0.6}),
        (Dragon(benches=8, head_spacing=1.0, body_spacing=2.0), {}),
        (Dragon(benches=2), {}),
        (Dragon(benches=40, head_spacing=1.0, body_spacing=0.6, overhang=0.1), {"radius": 12.0}),
    ],
    ids=str,
)
def test_other_dragons_and_turns_are_as_fast_as_a_scan_sees(dragon: Dragon, sizes: dict[str, float]) -> None:
    found = max_speed(dragon, **sizes)
    end = found.curve.joints[-1] + min(float(dragon.spacings.sum()), 60.0)
    _, way = scanned(dragon, found.curve, -3.0, end, 0.05)
    near, _ = scanned(dragon, found.curve, way - 0.06, way + 0.06, 1e-4)
    assert found.ratio * (1 - 1e-6) < max(near, 1.0) <= found.ratio * (1 + 1e-11)


def test_a_head_bench_little_longer_than_the_others_needs_few_moments() -> None:
    """With 2.0 m the whole dragon was followed through the turn, for a minute and a half."""
    found = max_speed(Dragon(head_spacing=2.0))
    assert found.evaluations < 5000
    seen, _ = scanned(found.dragon, found.curve, 14.0, 15.5, 0.001)
    assert found.ratio * (1 - 1e-6) < seen <= found.ratio * (1 + 1e-11)


def test_the_last_benches_may_be_the_fastest() -> None:
    """Where the head bench is no longer than the others, the benches on the way out add to the speed behind them."""
    found = max_speed(Dragon(benches=25, head_spacing=1.65))
    assert found.handle == 25
    assert found.excess <= 1e-11
    end = found.curve.joints[-1] + 40.0
    coarse, way = scanned(found.dragon, found.curve, 0.0, end, 0.05)
    fine, _ = scanned(found.dragon, found.curve, way - 0.06, way + 0.06, 1e-4)
    assert coarse <= found.ratio * (1 + 1e-11)
    assert found.ratio * (1 - 1e-6) < fine <= found.ratio * (1 + 1e-11)


@pytest.mark.parametrize("head_spacing", [1.0, 1.65, 1.9])
def test_a_long_dragon_of_like_benches_is_bounded_with_little_work(head_spacing: float) -> None:
    found = max_speed(Dragon(head_spacing=head_spacing))
    assert found.evaluations < 5000
    assert found.excess < 0.02
    seen, _ = scanned(found.dragon, found.curve, found.distance - 1.0, found.distance + 1.0, 0.05)
    assert seen <= found.ratio * (1 + found.excess)


def test_a_turn_gentler_than_the_way_out_says_how_much_it_leaves_open() -> None:
    """On a wide turn the bound for the way out is the larger one."""
    found = max_speed(Dragon(benches=20), radius=40.0)
    assert 1 <= found.ratio < 1.01
    seen, _ = scanned(found.dragon, found.curve, -10.0, found.curve.joints[-1] + 200.0, 0.25)
    assert seen <= found.ratio * (1 + found.excess)


@pytest.mark.parametrize("name", ["limit", "pitch", "radius", "ratio"])
@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
def test_impossible_numbers_are_refused(name: str, value: object) -> None:
    with pytest.raises(ParameterError) as caught:
        max_speed(**{name: value})
    assert_says(caught.value, f"{name} is ")


def test_a_dragon_that_cannot_be_asked_about_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        max_speed(Dragon(body_spacing=[1.65, 1.5, 1.65]))
    assert_says(caught.value, "alike")
    with pytest.raises(UnreachableError):
        max_speed(radius=4.2)
    for dragon, sizes in (
        (Dragon(), {"radius": 0.6}),
        # Handle 1 is pushed back all the way out.
        (Dragon(), {"radius": 4.0}),
        (
            Dragon(benches=4, head_spacing=0.51, body_spacing=0.47, overhang=0.01, width=0.05),
            {"pitch": 2.4, "radius": 0.632, "ratio": 0.185},
        ),
    ):
        with pytest.raises(ParameterError) as caught:
            max_speed(dragon, **sizes)
        assert_says(caught.value, f"radius is {sizes['radius']}", "must be large enough for")


def test_program_answers_in_words_and_in_json(answer: MaxSpeed, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["study", "max-speed", "--json"])
    assert ended.value.code == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["speed"], told["handle"], told["time"]) == (answer.speed, answer.handle, answer.time)
    with pytest.raises(SystemExit):
        main(["study", "max-speed", "--limit", "3"])
    assert "no handle exceeds 3 m/s" in capsys.readouterr().out


@pytest.mark.parametrize("value", ["0", "-1", "nan", "21"])
def test_program_refuses_an_impossible_limit_in_one_line(value: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["study", "max-speed", "--limit", value])
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_picture_is_written(answer: MaxSpeed, tmp_path: Path) -> None:
    answer.write_figure(tmp_path / "limit.png")
    with Image.open(tmp_path / "limit.png") as picture:
        assert picture.size == (1600, 900)
    answer.write_figure(tmp_path / "limit.svg")
    assert 'id="fastest"' in (tmp_path / "limit.svg").read_text()
