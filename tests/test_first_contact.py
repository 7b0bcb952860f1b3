"""The first contact, against many digits, Shapely, and samples that miss it."""

import math
from dataclasses import FrozenInstanceError, replace

import mpmath as mp
import numpy as np
import oracle
import pytest
import shapely
from chain_follower import random_path
from conftest import NO_NUMBERS, examples, refusal
from hypothesis import assume, given, reject
from hypothesis import strategies as st
from marches import DRAWN, bent

from pymunk_dragon import (
    Contact,
    Dragon,
    March,
    SpeedTable,
    first_contact,
    max_speed,
    outlines,
    scan,
    simulate,
)
from pymunk_dragon.collision.bounds import UNPROVEN_ROUNDING, Intervals, MotionBounds
from pymunk_dragon.errors import DragonError, ParameterError, UnreachableError
from pymunk_dragon.model.curves import (
    Arc,
    Composite,
    Line,
    Reversed,
    Sampled,
    Section,
    Spiral,
    UTurn,
    sampled,
)
from pymunk_dragon.physics.substep import Motion

SIZES = ("head_spacing", "body_spacing", "overhang", "width")
TIGHT = March(Dragon(benches=30), Spiral(pitch=0.31), turns=8)


@pytest.mark.thorough
@pytest.mark.parametrize(("width", "benches"), [(0.3, (0, 8)), (0.301, (0, 11))])
def test_ipc_toolkit_finds_the_same_first_contact(width, benches):
    pytest.importorskip("ipctk", reason="ipctk is in the extra test")
    import outside_judge as judge

    march = March(Dragon(width=width))
    cleared, closest = judge.cleared_by_ipc_toolkit(march, 400.0, 413.0)
    found = first_contact(march)
    assert found.benches == closest == benches
    # It clears all but its last steps; the certified time itself is accurate to 1e-11 s.
    assert -1e-11 < found.time - cleared < 1e-9


@pytest.fixture(scope="module")
def seed_impact(seed_march):
    return first_contact(seed_march)


def polygons(march, times, handles=None):
    """Benches (T, N) as Shapely has them."""
    poses = march.at(times, handles).poses
    return shapely.polygons(
        outlines(poses, march.dragon.lengths[: poses.shape[1]], march.dragon.width)
    )


def gaps(march, times):
    """Gaps (T, P) of all pairs that are not neighbours, and the pairs (P, 2)."""
    benches = polygons(march, times)
    first, second = np.triu_indices(march.dragon.benches, 2)
    return shapely.distance(benches[:, first], benches[:, second]), np.stack(
        [first, second], axis=-1
    )


def assert_first(march, found, samples, tolerance):
    """Nothing touches before the contact found; the times of samples, and gaps of pairs there."""
    times = np.linspace(0, found.time, samples)
    apart, pairs = gaps(march, times)
    assert apart[:-1].min() > 0
    if found.status == "contact":
        assert apart[-1, (pairs == found.benches).all(axis=1)] < tolerance
    elif found.status == "clear":
        assert found.time == march.end
        assert apart[-1].min() > 0
    else:
        assert np.isnan(march.motion_or_nan(found.time + 1e-9).handles_s).any()
    return times, apart, pairs


def exact_gap(march, time, pair):
    """The gap of two benches in 50 digits."""
    sizes = {name: oracle.exact(getattr(march.dragon, name)) for name in SIZES}
    with mp.workdps(oracle.DIGITS):
        return oracle.gap(
            oracle.exact(time), pair, sizes | {"pitch": oracle.exact(march.curve.pitch)}
        )


def test_seed_meets_bench_8_at_the_time_of_many_digits(seed_march, seed_impact):
    assert seed_impact.status == "contact"
    assert seed_impact.benches == (0, 8)
    time = seed_impact.time
    assert 412 < time < 413
    gap, later = exact_gap(seed_march, time, (0, 8)), exact_gap(seed_march, time + 2**-20, (0, 8))
    rate = (later - gap) / mp.mpf(2) ** -20
    assert -0.04 < rate < -0.02
    assert abs(gap / rate) < 1e-11


def test_seed_point_and_normal_are_where_the_two_touch(seed_march, seed_impact):
    (benches,) = polygons(seed_march, [seed_impact.time], 10)
    point = shapely.Point(seed_impact.point)
    assert shapely.distance(benches[[0, 8]], point).max() < 1e-11
    assert np.hypot(*seed_impact.normal) == pytest.approx(1, abs=1e-15)
    parted = shapely.transform(benches[8], lambda xy: xy + 1e-6 * np.array(seed_impact.normal))
    assert shapely.distance(benches[0], parted) == pytest.approx(1e-6, abs=1e-11)


def test_seed_passes_benches_9_and_11_without_touching(seed_march, seed_impact):
    assert [miss.benches for miss in seed_impact.near_misses] == [(0, 9), (0, 11)]
    for miss, begin in zip(seed_impact.near_misses, (406.5, 409.5), strict=True):
        times = np.union1d(
            np.linspace(begin, begin + 0.7, 701), miss.time + np.linspace(-2e-3, 2e-3, 401)
        )
        benches = polygons(seed_march, times, 13)
        apart = shapely.distance(benches[:, 0], benches[:, miss.benches[1]])
        assert miss.gap == pytest.approx(apart.min(), abs=1e-9)
        assert miss.gap <= apart.min() + 1e-12
        assert miss.time == pytest.approx(times[apart.argmin()], abs=1e-4)


def test_answer_is_a_value_from_which_a_run_gets_its_contact(seed_march, seed_impact):
    later = first_contact(seed_march, start=410)
    assert later.benches == (0, 8)
    assert later.near_misses == ()
    assert later.time == pytest.approx(seed_impact.time, abs=1e-11)
    assert first_contact(seed_march, start=410) == later
    with pytest.raises(FrozenInstanceError):
        seed_impact.time = 0.0
    contact = seed_impact.contact
    assert contact.time == seed_impact.time
    assert contact.benches == (0, 8)
    assert contact.depth == 0
    assert contact.point == seed_impact.point
    assert contact.normal == seed_impact.normal


def test_contact_of_four_milliseconds_is_found_though_a_scan_misses_it():
    # A bench that is 1 mm wider touches bench 11 where the seed's passes it.
    march = March(Dragon(width=0.3009741))
    found = first_contact(march)
    assert found.benches == (0, 11)
    assert 409.8 < found.time < 409.9
    times = np.arange(found.time - 0.005, found.time + 0.005, 1e-5)
    benches = polygons(march, times, 13)
    touching = times[shapely.intersects(benches[:, 0], benches[:, 11])]
    assert touching[0] == pytest.approx(found.time, abs=1.1e-5)
    assert 0.003 < np.ptp(touching) < 0.005
    # The paper's way, looking ten times a second, names another pair almost three seconds later.
    missed = scan(march, start=405, step=0.1)
    assert missed.benches == (0, 8)
    assert missed.time > found.time + 2.5


def test_gap_or_overlap_of_a_hundredth_of_a_nanometre_is_told_apart():
    dragons = Dragon(width=0.30097406879), Dragon(width=0.3009740688)
    apart, touching = (first_contact(March(dragon), start=409, until=410) for dragon in dragons)
    assert apart.status == "clear"
    assert touching.status == "contact"
    (miss,) = apart.near_misses
    assert 0 < miss.gap < 2e-11


def test_dragon_of_another_size_or_speed_does_the_same_at_its_scale(seed_impact):
    for scale in (0.01, 10):
        dragon = Dragon(**{name: scale * getattr(Dragon(), name) for name in SIZES})
        found = first_contact(March(dragon, Spiral(pitch=scale * 0.55)))
        assert found.benches == (0, 8)
        assert found.time == pytest.approx(scale * seed_impact.time, abs=1e-10 * max(scale, 1))
        gaps = [scale * miss.gap for miss in seed_impact.near_misses]
        assert [miss.gap for miss in found.near_misses] == pytest.approx(gaps, rel=1e-6)
    # After hours, doubles are coarser than a picosecond.
    for speed in (2.0, 0.04517336753736177, 0.0065220962981293324):
        found = first_contact(March(speed=speed))
        assert found.benches == (0, 8)
        assert found.time * speed == pytest.approx(seed_impact.time, abs=1e-10)


def test_march_without_a_contact_is_clear_until_the_end(seed_march):
    found = first_contact(seed_march, until=300)
    assert found.status == "clear"
    assert found.time == 300
    assert found.benches is None
    assert found.point is None
    assert found.normal is None
    assert found.contact is None
    wide = March(Dragon(benches=8), Spiral(pitch=5.8), turns=2.5)
    found = first_contact(wide)
    assert found.status == "clear"
    assert found.time == wide.end
    found = first_contact(seed_march, start=412.47, until=412.47 + 1e-9)
    assert found.status == "clear"
    assert found.near_misses == ()
    assert first_contact(March(Dragon(benches=2), turns=4), until=10).status == "clear"


STUCK = [
    March(Dragon(benches=benches), Spiral(pitch=pitch), turns=turns, speed=speed)
    for benches, pitch, turns, speed in ((3, 0.55, 8, 1.0), (8, 0.9, 5, 0.7))
]
# The hairpin is too tight for a bench of a metre: its rear handle is pushed back, and in the end
# off the path.
JACKKNIFED = Dragon(benches=2, head_spacing=1.0, body_spacing=0.5, overhang=0.05, width=0.05)
STUCK.append(March(JACKKNIFED, bent(3, 0.45, np.pi, 12)))


def test_march_past_the_last_place_is_unreachable_there(seed_impact):
    assert seed_impact.resolution < 1e-9
    for march in STUCK:
        found = first_contact(march)
        assert found.status == "unreachable"
        assert found.benches is None
        assert found.near_misses == ()
        assert found.resolution == UNPROVEN_ROUNDING * (march.dragon.benches > 2)
        # NumPy rounds in other ways for other numbers of times, and on other processors.
        for count in (1, 2, 7, 64):
            march.at(np.full(count, found.time + 5e-13 / march.speed))
        with pytest.raises(UnreachableError):
            march.at(found.time + 1e-11 / march.speed)
    last = first_contact(STUCK[0], until=1e6).time
    assert last == first_contact(STUCK[0]).time
    assert first_contact(March(Dragon(benches=2), turns=4)).status == "unreachable"


ENDING = [
    March(Dragon(benches=5), Line(stop=(40, 0))),
    March(Dragon(benches=5), Line(stop=(40, 0)), speed=SpeedTable([0, 9, 20], [0.7, 2, 1.1])),
    March(Dragon(benches=3, head_spacing=1.5, body_spacing=1.0), bent(9, 4.0, 2.0, 3.3)),
    March(Dragon(benches=4), DRAWN),
    March(Dragon(benches=4), Reversed(Section(Spiral(pitch=2.0), -60.0, -20.0))),
    March(Dragon(benches=6), Section(UTurn(), -30.0, 33.3), start_s=9.0),
]


@pytest.mark.parametrize("march", ENDING)
def test_a_curve_is_marched_to_its_end_and_no_further(march):
    """With one answer of the certificate, the scan and the engine."""
    end = march.end
    start = end - 2.0
    assert np.isfinite(march.at(end).positions).all()
    for until, status in (
        (None, "clear"),
        (end, "clear"),
        (np.nextafter(end, np.inf), "clear"),
        (end * (1 + 1e-13), "clear"),
        (end - 1e-3, "clear"),
        (end + 1e-3, "unreachable"),
        (end + 1e6, "unreachable"),
    ):
        run = simulate(march, start=start, until=until)
        found = [
            first_contact(march, start=start, until=until),
            scan(march, start=start, until=until),
        ]
        assert [run.outcome, *(each.status for each in found)] == 3 * [status], until
        assert end - run.settings.substep - 1e-9 <= run.times[-1] <= end + 1e-9


def test_benches_that_overlap_at_the_start_are_said_to():
    found = first_contact(TIGHT)
    assert found.status == "overlapping"
    assert found.time == 0
    assert found.contact is None
    (benches,) = polygons(TIGHT, [0])
    assert shapely.intersects(*benches[list(found.benches)])


@st.composite
def marches(draw):
    """Marches on spirals on which the dragon can start."""
    lengths = {
        "head_spacing": (0.7, 4),
        "body_spacing": (0.7, 3),
        "overhang": (0.05, 0.3),
        "width": (0.05, 0.5),
    }
    sizes = {name: draw(st.floats(*ends)) for name, ends in lengths.items()}
    pitch = draw(st.one_of(st.floats(0.4, 1), st.floats(0.5, 6)))
    try:
        dragon = Dragon(benches=draw(st.integers(3, 20)), **sizes)
        return March(
            dragon,
            Spiral(pitch=pitch),
            turns=draw(st.floats(1.5, 7)),
            speed=draw(st.floats(0.5, 3)),
        )
    except DragonError:
        reject()


@examples(30)
@given(marches())
def test_nothing_touches_before_the_answer_and_every_near_miss_is_told(march):
    found = first_contact(march)
    if found.status == "overlapping":
        assert gaps(march, [0])[0].min() == 0
        return
    times, apart, pairs = assert_first(march, found, 800, 1e-11)
    # All smallest gaps below a thirtieth of the width are near misses; other benches repeat what
    # bench 1 did.
    near = march.dragon.width / 30
    told = {
        (*miss.benches, k)
        for miss in found.near_misses
        for k in [np.searchsorted(times, miss.time)]
    }
    smallest = (apart[1:-1] < apart[:-2]) & (apart[1:-1] <= apart[2:]) & (apart[1:-1] < near - 1e-6)
    for row, column in np.argwhere(smallest & (pairs[:, 0] < 2)):
        around = {(*pairs[column].tolist(), row + 1 + step) for step in (-1, 0, 1, 2)}
        assert told & around, (times[row + 1], pairs[column])
    for miss in found.near_misses:
        assert 0 < miss.gap < near
        step = 1e-4 / march.speed
        sides, _ = gaps(march, [max(miss.time - step, 0), min(miss.time + step, found.time)])
        assert sides[:, (pairs == miss.benches).all(axis=1)].min() >= miss.gap - 1e-9


@examples(150)
@given(marches(), st.floats(0, 1), st.floats(-4, 0.5))
def test_benches_stay_within_their_bounds(march, share, exponent):
    length = 10**exponent / march.speed
    begin = share * (march.end - length)
    assume(begin >= 0)
    times = np.linspace(begin, begin + length, 101)
    gone = march.motion_or_nan(times).handles_s
    assume(not np.isnan(gone).any())
    motion = MotionBounds(march, Intervals.between(march, times[[0, -1]]))
    assert np.all(np.abs(gone - gone[50]) <= motion.travel[0] + 1e-12)
    rows, pairs = motion.candidates(0.0, np.full(march.dragon.handles, np.inf))
    apart, all_pairs = gaps(march, times)
    columns = [all_pairs.tolist().index(pair) for pair in pairs.tolist()]
    for near in (-0.2, 0.0, 0.2):
        separated = ~motion.may_meet(np.zeros(len(all_pairs), dtype=int), all_pairs, near)
        assert np.all(apart[:, separated].min(initial=np.inf) > near)
    assert np.all(np.delete(apart, columns, axis=1) > 0)
    found = motion.separations(rows, pairs)
    open_ = found.distance > 0
    rows = rows[open_]
    pairs = pairs[open_]
    normals = found.normal[open_]
    columns = np.array(columns, dtype=int)[open_]
    for bound in (motion.smallest_gaps, motion.smallest_gaps_together):
        assert np.all(apart[:, columns].min(axis=0) >= bound(rows, pairs, normals) - 1e-12)


def test_scan_agrees_with_the_certified_answer_and_knows_the_other_endings(seed_march, seed_impact):
    for step in (1.0, 0.3):
        found = scan(seed_march, start=405, step=step)
        assert found.status == "contact"
        assert found.benches == (0, 8)
        assert found.near_misses is None
        assert 0 <= found.time - seed_impact.time <= 1e-6 + 1e-11
    assert scan(seed_march, start=400, until=410, step=0.5).samples == 21
    clear = scan(STUCK[0], until=3)
    assert clear.status == "clear"
    assert clear.time == 3
    assert scan(STUCK[0]).status == "unreachable"
    assert scan(TIGHT).status == "overlapping"


def test_impossible_times_and_settings_are_refused_by_name(seed_march):
    for look in (first_contact, scan):
        # A march may start at 0 s or before, and None is no end.
        cases = [("start", value) for value in NO_NUMBERS if repr(value) not in ("0", "-1")]
        cases += [("until", value) for value in NO_NUMBERS if value is not None]
        if look is scan:
            cases += [("step", 1e-6), *(("step", value) for value in NO_NUMBERS)]
        for name, value in cases:
            assert refusal(look, seed_march, **{name: value}).name == name, value
        assert refusal(look, seed_march, start=10, until=10).name == "until"
        assert refusal(look, March(speed=2.0), start=220, error=UnreachableError).time == 220


@pytest.mark.parametrize(
    ("benches", "width"),
    [
        (2_000, 0.01),
        *(pytest.param(10_000, width, marks=pytest.mark.thorough) for width in (0.01, 0.015)),
    ],
)
def test_ten_thousand_short_benches_are_answered_in_seconds(benches, width):
    dragon = Dragon(benches=benches, head_spacing=0.1, body_spacing=0.1, overhang=0.01, width=width)
    march = March(dragon, Spiral(pitch=0.021))
    found = first_contact(march)
    assert found.status == "contact"
    assert found.benches[0] == 0
    # The first turns alone do the same.
    short = March(replace(dragon, benches=200), march.curve)
    assert first_contact(short).time == pytest.approx(found.time, abs=1e-9)
    assert found.tests < 1_000_000


@pytest.mark.parametrize(
    "seeds",
    [
        range(2),
        *(
            pytest.param(seeds, marks=pytest.mark.thorough)
            for seeds in (range(2, 16), range(16, 30))
        ),
    ],
)
def test_no_overlap_is_seen_before_the_first_contact_on_random_paths(seeds):
    """Against Shapely, with head benches long enough to jackknife."""
    for seed in seeds:
        rng = np.random.default_rng(seed)
        march = None
        while march is None:
            path = random_path(rng, pieces=6, tightest=0.6, straight=(8, 14))
            sizes = {"head_spacing": rng.uniform(1.5, 5), "body_spacing": rng.uniform(0.3, 0.6)}
            dragon = Dragon(
                benches=int(rng.integers(8, 25)),
                overhang=0.05,
                width=rng.uniform(0.05, 0.2),
                **sizes,
            )
            try:
                march = March(dragon, path, start_s=rng.uniform(0.5, 1) * path.end_s)
                found = first_contact(march)
            except ParameterError:
                march = None
        if found.status == "overlapping":
            continue
        assert_first(march, found, 400, 1e-9)


# Cases that gave wrong answers once


def equal(benches, spacing, overhang, width=0.3):
    """A dragon of equal benches."""
    return Dragon(
        benches=benches, head_spacing=spacing, body_spacing=spacing, overhang=overhang, width=width
    )


# Benches in line, 0.279 mm apart, until the first ones reach the arc.
STRAIGHT = Line(start=(0, 0), stop=(6.951189646793137, -4.575222436887432))
BEND = Arc(
    centre=(5.750644158985496, -6.399225418265977),
    radius=2.1836429067897307,
    begin_angle=0.9886832665873433,
    sweep=-0.8897022307433354,
)
SHORT = equal(5, 1.3946210480004002, 0.6971710618954001, 0.9890491915732748)
ALIGNED = March(SHORT, Composite([STRAIGHT, BEND]), speed=0.3)


def test_contacts_that_pymunk_reports_of_benches_apart_are_ignored():
    """It reports one 5.6 m deep, and one without depth and normal."""
    run, exact = simulate(ALIGNED), first_contact(ALIGNED)
    assert run.first_contact.benches == exact.benches == (0, 2)
    assert run.first_contact.time == pytest.approx(exact.time, abs=1e-3)
    assert all(event.depth < 1e-3 for event in run.events)
    dragon = equal(5, 1.5647357088711662, 0.7286387054942967, 0.16926126905240985)
    angle = 2.480352102995642
    straight = Line(stop=(8.849066384190579 * math.cos(angle), 8.849066384190579 * math.sin(angle)))
    assert not simulate(March(dragon, straight)).events


def test_contact_by_rounding_only_is_at_the_end_of_the_substep():
    dragon = equal(3, 1.5, 0.5, 1.0)
    poses = np.array([[0.0, 0.0, 0.0], [9.0, 9.0, 0.0], [2.5 + 1e-15, 0.0, 0.0]])
    contact = Contact(
        time=1.1, raw_time=1.1, benches=(0, 2), point=(1.25, 0.0), normal=(1.0, 0.0), depth=0.0
    )
    assert Motion(poses, 0 * poses, 0 * poses).refined(dragon, contact, 1.0) == contact


def test_constant_gap_is_no_near_miss():
    bend = Arc(centre=(0, 5), radius=5, begin_angle=-math.pi / 2, sweep=1.0)
    march = March(
        equal(20, 1.65, 0.82), Composite([Line(start=(-60, 0), stop=(0, 0)), bend]), start_s=40.0
    )
    for hit in (first_contact(march), first_contact(ALIGNED)):
        assert hit.status == "contact"
        assert hit.benches == (0, 2)
        assert hit.near_misses == ()


@pytest.mark.thorough
def test_sharp_bends_and_unequal_benches_need_few_evaluations_of_the_curve(monkeypatch):
    calls = []
    solved = sampled._solved
    monkeypatch.setattr(
        sampled, "_solved", lambda *arguments: calls.append(0) or solved(*arguments)
    )
    points = [(-30, 0), (-20, 0), (-10, 0), (-4, 0)]
    for i in range(6):
        points += [(4 * i, 2.5 * (-1) ** i), (4 * i + 2, 0)]
    spacings = [1.65 * (1 + 0.05 * math.sin(1.7 * i)) for i in range(9)]
    assert (
        first_contact(March(Dragon(benches=10, body_spacing=spacings), Sampled(points))).status
        == "clear"
    )
    assert len(calls) < 20_000


@pytest.mark.parametrize("radius", [4.5, 2.5])
def test_excess_of_a_long_dragon_of_equal_benches_is_as_documented(radius):
    found = max_speed(equal(100, 1.65, 0.275), radius=radius)
    end = found.curve.end_s if math.isfinite(found.curve.end_s) else found.curve.joints[-1]
    assert (
        1e-11
        < found.excess
        <= 1 / math.sqrt(1 - (float(found.curve.curvature(end)) * 1.65 / 2) ** 2) - 1
    )
