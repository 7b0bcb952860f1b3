"""What the lessons on motion say and print, against formulas, many digits and brute force."""

from __future__ import annotations

import csv
import math
import re
from itertools import pairwise
from pathlib import Path

import mpmath as mp
import oracle
import pytest
from exact_curves import DIGITS, s_turn, u_turn, walked_chain
from lesson_runs import numbers, played

from pymunk_dragon.model.dragon import Dragon

DATA = Path(__file__).parent / "data"
K = 0.55 / (2 * math.pi)
SIZES = {"head_spacing": 2.86, "body_spacing": 1.65, "pitch": 0.55, "turns": 16, "speed": 1}


def said(name: str, part: str) -> str:
    return played(name).lesson.text(part)


def lines(name: str, pattern: str) -> list[list[float]]:
    """The numbers in those printed lines in which `pattern` is found."""
    found = [numbers(line) for line in played(name).printed.splitlines() if re.search(pattern, line)]
    assert found
    return found


def head_angle(time: float) -> float:
    return float(oracle.head_angle(time, mp.mpf("0.55"), 16, 1))


def degrees_cosine(angle: float) -> float:
    return math.cos(math.radians(angle))


# spiral


def test_turning_is_the_pace_over_the_root_and_the_walk_is_steady() -> None:
    table = lines("spiral", "^t =")
    assert [row[0] for row in table] == [0, 100, 200, 300, 400]
    for time, r, walking, turning, a_round in table:
        angle = head_angle(time)
        rate = 1 / (K * math.hypot(angle, 1))
        assert r == pytest.approx(K * angle, abs=5.1e-4)
        assert turning == pytest.approx(rate, abs=5.1e-5)
        assert a_round == pytest.approx(2 * math.pi / rate, abs=0.051)
        assert walking == 1


def test_spiral_tells_what_a_calculator_and_a_protractor_find() -> None:
    first, last = lines("spiral", "^t =")[0], lines("spiral", "^t =")[-1]
    assert {first[3], last[3]} == {0.1136, 0.3669} < set(numbers(said("spiral", "answer")))
    r, k, wide, radians, seconds = 2.724, 0.0875, 102, 1.78, 5
    assert {last[3], r, k, wide, radians, seconds} < set(numbers(said("spiral", "check")))
    assert round(1 / math.hypot(r, k), 4) == last[3]
    assert wide == round(math.degrees(head_angle(395) - head_angle(400)))
    assert radians == pytest.approx(math.radians(wide), abs=0.005)
    assert radians / seconds == pytest.approx(last[3], rel=0.05)
    [guess] = played("spiral").lesson.guesses
    assert {round(first[4]), round(last[4])} == {55, 17} < set(numbers(" ".join(guess.choices)))


# chain


def crossings(time: float, bench: float) -> int:
    """How often the distance from the head passes the bench's length along 22 turns, by small steps."""
    angle = head_angle(time)
    head = K * angle * complex(math.cos(angle), math.sin(angle))
    steps = (0.001 * i for i in range(round(22 * 2 * math.pi / 0.001)))
    beyond = [abs(K * a * complex(math.cos(a), math.sin(a)) - head) > bench for a in steps]
    return sum(one != other for one, other in pairwise(beyond))


def test_circle_meets_the_spiral_so_often() -> None:
    assert lines("chain", "points at")[0][0] == crossings(300, 2.86) == 22
    assert numbers(said("chain", "answer"))[0] == numbers(said("chain", "check"))[-1] == 22
    # What the student finds who changes the file as asked.
    assert crossings(300, 1.65) < 22
    assert crossings(400, 2.86) % 2 == 1


def test_next_handle_is_the_one_in_many_digits_and_its_arc_is_longer() -> None:
    positions, _ = oracle.solve(300, **SIZES, benches=2, difference=False)
    (_, arc, r, x, y), *_ = (row for row in lines("chain", "turns back") if 0 < row[0] < 0.5)
    expected = [float(part) for part in positions[1]]
    assert [x, y] == pytest.approx(expected, abs=1e-6)
    assert numbers(played("chain").printed.splitlines()[-1])[-2:] == pytest.approx(expected, abs=5.1e-7)
    before, after = (oracle.arc_length(mp.hypot(*place) / K, 0.55) for place in positions[:2])
    assert arc == pytest.approx(float(after - before), abs=5.1e-4)
    assert arc - 2.86 == pytest.approx(0.04, abs=0.001)
    # By hand.
    radius = (4.992 + 5.043) / 2
    assert round(2 * radius * math.asin(2.86 / (2 * radius)), 3) == arc == numbers(said("chain", "check"))[0]
    assert r == 5.043


# velocity


@pytest.mark.thorough
def test_speeds_are_those_in_many_digits_and_the_papers() -> None:
    _, velocities = oracle.solve(300, **SIZES, benches=223)
    with (DATA / "table2.csv").open() as file:
        paper = {int(row["handle"]): float(row["300"]) for row in csv.DictReader(file)}
    table = lines("velocity", "^handle")
    assert [int(handle) for handle, _ in table] == list(paper)
    for handle, speed in table:
        assert speed == pytest.approx(float(mp.hypot(*velocities[int(handle)])), abs=5.1e-7)
        assert math.floor(1000 * speed) / 1000 == paper[int(handle)]
    tail = table[-1][1]
    assert tail in numbers(said("velocity", "answer"))
    assert 1000 * (1 - tail) == pytest.approx(3.5, abs=0.05)


def test_speed_of_handle_1_is_the_ratio_of_the_cosines() -> None:
    positions, velocities = oracle.solve(300, **SIZES, benches=2)
    (x, y), (u, v) = positions[:2]
    bench = mp.atan2(y - v, x - u)
    angles = [abs(float(mp.degrees(mp.atan2(way[1], way[0]) - bench))) for way in velocities[:2]]
    front, rear, ratio = lines("velocity", "^head bench")[0]
    assert [front, rear] == pytest.approx(angles, abs=5.1e-5)
    assert front > rear
    speed, front, rear = numbers(said("velocity", "check"))[1:4]
    assert speed == ratio == lines("velocity", "^handle   1")[0][1]
    assert round(degrees_cosine(front) / degrees_cosine(rear), 6) == speed


def test_error_of_the_difference_is_half_the_step_times_the_heads_angular_acceleration() -> None:
    angle = head_angle(300)
    for step, error in lines("velocity", "^step"):
        expected = step / 2 * angle / (K * (angle**2 + 1) ** 1.5)
        assert error == pytest.approx(expected, rel=0.05)


# u-turn


def test_turn_has_the_length_and_the_angles_of_many_digits_whatever_the_ratio() -> None:
    rows = lines("u-turn", "^radii")
    ratios = [first / second for first, second, *_ in rows]
    assert ratios == pytest.approx([0.5, 1, 1.5, 2, 4], rel=1e-3)
    for ratio, row in zip((0.5, 1, 1.5, 2, 4), rows, strict=True):
        with mp.workdps(DIGITS):
            radii, _, sweeps, _, length = s_turn(mp.mpf("1.7"), mp.mpf("4.5"), mp.mpf(ratio))
            exact = [*radii, *(mp.degrees(abs(sweep)) for sweep in sweeps), length]
        assert row[:4] == pytest.approx([float(part) for part in exact[:4]], abs=5.1e-4)
        assert row[4] == pytest.approx(float(exact[4]), abs=5.1e-7)


def test_length_of_the_turn_follows_from_one_angle() -> None:
    length, angle = lines("u-turn", "^radii")[0][-1], numbers(said("u-turn", "check"))[-3]
    half = math.atan(2 * math.pi * 4.5 / 1.7)
    assert angle == round(half, 6)
    assert round(9 * half / math.sin(half), 6) == length == numbers(said("u-turn", "check"))[0]
    assert numbers(said("u-turn", "answer"))[:2] == [length, round(math.degrees(2 * half), 3)]


# speed-limit


def test_limit_is_the_one_in_many_digits() -> None:
    limit, ratio, speed = lines("speed-limit", "largest speed")[0]
    time = lines("speed-limit", "^t =")[0][0]
    with mp.workdps(DIGITS):
        truth, tiny, spacings = u_turn(), mp.mpf("1e-15"), Dragon().spacings[:8]
        way = mp.mpf(time) * mp.mpf(speed)
        before, after = (walked_chain(truth, way + sign * tiny, spacings) for sign in (-1, 1))
        ratios = [float((b - a) / (2 * tiny)) for a, b in zip(before, after, strict=True)]
    # The time is printed to 0.1 ms, and close to a top the speed hardly depends on it.
    assert ratios[3:8] == pytest.approx([ratio] * 5, abs=1e-6)
    assert max(ratios[:3] + ratios[8:]) < ratio - 0.01
    assert speed == pytest.approx(limit / ratio, abs=1e-10)
    assert [1.6048, speed] == numbers(said("speed-limit", "answer"))[2:4]


def test_fastest_handles_run_as_the_cosines_say() -> None:
    product = lines("speed-limit", "^product")[0][0]
    check = numbers(said("speed-limit", "check"))
    assert check[0] == product
    angles = check[1:5]
    levers = [degrees_cosine(angles[i]) / degrees_cosine(angles[i + 1]) for i in (0, 2)]
    assert round(math.prod(levers), 4) == product
    benches = {int(row[0]): row[1:] for row in lines("speed-limit", "^bench")}
    assert benches[0][:2] + benches[2][:2] == angles
    assert [benches[0][2], benches[2][2]] == pytest.approx(levers, abs=5e-6)
    assert [round(angles[0]), math.floor(angles[1]), round(levers[0], 2)] == [46, 63, 1.55]
