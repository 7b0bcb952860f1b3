"""What the engine does, held against the exact model and against Shapely."""

import signal
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pymunk
import pytest
import shapely
from conftest import NO_NUMBERS, assert_says, refusal
from marches import DRAWN, HAIRPIN, TABLE
from sharing import shared_run

from pymunk_dragon import (
    Arc,
    Dragon,
    EngineSettings,
    Line,
    March,
    PathGuide,
    Run,
    Section,
    Spiral,
    UTurn,
    World,
    simulate,
)
from pymunk_dragon.errors import DragonError, UnreachableError
from pymunk_dragon.physics import Rails
from pymunk_dragon.physics.contacts import Recorder

# s: when benches 0 and 8 of the exact march first touch (test_first_contact.py).
TRUE_TIME = 412.473838
# m: drift of benches on rails at the default settings.
MAX_DRIFT = 50e-6
# The start of a world takes a time that grows with the benches, and few meet as many do.
SIXTEEN = March(Dragon(benches=16))


def polygons(march, pair, poses):
    """Outlines of two benches."""
    return [shapely.Polygon(march.dragon.outlines(poses)[bench]) for bench in pair]


def of_phase(run, phase):
    """The events of one phase."""
    return [event for event in run.events if event.phase == phase]


def shapely_gap(march, time, pair, poses=None):
    """Distance of two benches with given poses, or those of the exact march, by Shapely, m."""
    first, second = polygons(march, pair, march.at(time).poses[0] if poses is None else poses)
    return first.distance(second)


@pytest.fixture(scope="module", params=["late", pytest.param("whole", marks=pytest.mark.thorough)])
def any_march(request, seed_march, late_run):
    """The paper's dragon to its first contact at the default settings, from 400 s, and from 0 s."""
    return (
        late_run if request.param == "late" else shared_run("whole", lambda: simulate(seed_march))
    )


@pytest.fixture(scope="module")
def reported():
    """The last second before the contact and the time in which it opens again, only recorded."""
    return simulate(SIXTEEN, start=411.5, until=415.2, contacts="report")


def test_march_ends_with_benches_0_and_8_at_the_true_time(any_march):
    assert any_march.outcome == "contact"
    assert any_march.first_contact.benches == (0, 8)
    assert any_march.first_contact.time == pytest.approx(TRUE_TIME, abs=0.5e-3)
    # Nothing touches on the way, although the head passes two benches closely.
    assert {event.benches for event in any_march.events} == {(0, 8)}
    assert min(event.time for event in any_march.events) == any_march.first_contact.raw_time


def test_march_keeps_to_the_exact_model_to_50_micrometres(any_march, seed_march):
    assert any_march.max_drift <= MAX_DRIFT
    # The drift once more, from the definition.
    frame = len(any_march.times) // 2
    holes = seed_march.at(any_march.times[frame]).positions[0]
    front, rear = seed_march.dragon.holes(any_march.poses[frame])
    worse = np.maximum(np.hypot(*(front - holes[:-1]).T), np.hypot(*(rear - holes[1:]).T))
    np.testing.assert_allclose(any_march.drift[frame], worse, atol=1e-12)


def test_contact_lies_inside_the_substep_where_the_outlines_touch(any_march, seed_march):
    contact = any_march.first_contact
    assert contact.raw_time - any_march.substep <= contact.time <= contact.raw_time
    assert any_march.times[-1] == contact.time
    head, eighth = polygons(seed_march, contact.benches, any_march.poses[-1])
    assert head.distance(eighth) < 1e-9
    assert head.distance(shapely.Point(contact.point)) < 1e-6
    assert eighth.distance(shapely.Point(contact.point)) < 1e-6
    # The normal is one of the edges' and points from bench 0 to bench 8.
    assert np.hypot(*contact.normal) == pytest.approx(1.0)
    assert np.dot(contact.normal, any_march.poses[-1, 8, :2] - any_march.poses[-1, 0, :2]) > 0
    assert 0 < contact.depth < 0.03 * any_march.substep * 2


def test_frames_have_the_exact_poses_and_velocities_up_to_the_contact(late_run, seed_march):
    exact = seed_march.at(late_run.times)
    np.testing.assert_allclose(late_run.poses[0], exact.poses[0], atol=1e-12)
    np.testing.assert_allclose(late_run.poses[:-1, 0, :2], exact.poses[:-1, 0, :2], atol=1e-12)
    np.testing.assert_allclose(late_run.pose_velocities[:-1], exact.pose_velocities[:-1], atol=2e-4)
    # The last frame stands inside a substep, and its velocities have no blow in them. On even
    # motion, without acceleration, the head would be 17 µm beside its pose in the middle of a
    # substep of 20 ms.
    np.testing.assert_allclose(late_run.pose_velocities[-1], exact.pose_velocities[-1], atol=2e-3)
    assert late_run.drift[-1, 0] < 1e-6
    assert late_run.drift[-1].max() <= late_run.drift[:-1].max()
    # A near miss between two frames has the exact gap.
    assert 409.832 not in late_run.times
    gap = shapely_gap(seed_march, 409.832, (0, 11), late_run.poses_at(409.832)[0])
    assert gap == pytest.approx(shapely_gap(seed_march, 409.832, (0, 11)), abs=3e-6)


def test_engine_takes_nothing_but_the_heads_pose_from_the_exact_model(monkeypatch):
    asked, exact = [], March.at

    def watched(march, times, handles=None):
        asked.append((np.max(times), handles))
        return exact(march, times, handles)

    with monkeypatch.context() as patch:
        patch.setattr(March, "at", watched)
        simulate(SIXTEEN, start=400.0, until=401.0)
    # The last states are for the drift.
    assert all(handles == 2 for time, handles in asked[:-1] if time > 400.0)


@pytest.mark.parametrize(
    ("march", "settings", "bound"),
    [
        # The curvature jumps.
        (March(Dragon(benches=40), UTurn()), {"start": 10.0, "until": 20.0}, 150e-6),
        (March(), {"start": 412.2, "until": 412.5, "substep": 1 / 400, "iterations": 60}, 1e-6),
        # A motor pulls the head.
        (SIXTEEN, {"start": 405.0, "until": 406.0, "contacts": "resolve"}, 5e-6),
        (March(Dragon(benches=3)), {"until": 20.0, "contacts": "resolve", "substep": 0.02}, 100e-6),
        (
            March(Dragon(benches=9, head_spacing=1.4, body_spacing=1), DRAWN, speed=TABLE),
            {"until": 9.0},
            2e-3,
        ),
        (
            March(Dragon(benches=12, head_spacing=0.9, body_spacing=0.8, overhang=0.1), HAIRPIN),
            {"until": 9.0},
            2e-3,
        ),
    ],
)
def test_engine_keeps_to_the_model(march, settings, bound):
    run = simulate(march, **settings)
    assert run.max_drift < bound
    assert run.first_contact is None or run.first_contact.time == pytest.approx(
        TRUE_TIME, abs=10e-6
    )


def test_benches_of_their_own_sizes_weigh_and_reach_what_they_should():
    dragon = Dragon(
        body_spacing=[1.65, 2.5, 1.65], overhang=[0.2, 0.4, 0.1, 0.3], width=[0.2, 0.5, 0.3, 0.4]
    )
    march = March(dragon, turns=10)
    assert simulate(march, until=4.0).max_drift <= MAX_DRIFT
    head, *others = World(march, "none").bodies
    assert head.body_type == pymunk.Body.KINEMATIC
    for body, length, width in zip(others, dragon.lengths[1:], dragon.width[1:], strict=True):
        assert body.mass == pytest.approx(500 * 0.04 * length * width)
        assert body.moment == pytest.approx(body.mass * (length**2 + width**2) / 12)
        (shape,) = body.shapes
        assert shape.area == pytest.approx(length * width)
        assert shape.radius == 0


def test_force_in_the_last_pivot_is_what_changes_the_tails_momentum():
    """Newton's second law: nothing else acts on a tail that nobody guides but the ground's drag."""
    march = March(Dragon(benches=12), turns=6)
    world = World(march, "none", substep=0.01, iterations=50)
    tail = world.bodies[-1]
    before = tail.velocity
    kept = world.space.damping**world.substep
    # A constant force adds to the velocity while the drag reduces what was added.
    seconds = (1 - kept) / world.drag_rate
    for _ in steps(world, 99):
        change = tail.mass * (tail.velocity - before * kept)
        before = tail.velocity
        assert world.joint_forces[-1] == pytest.approx(change.length / seconds, rel=1e-9)
    run = simulate(march, until=1.0)
    assert run.joint_forces.shape == (len(run.times), 11)
    assert np.all(run.joint_forces >= 0)
    assert Run.exact(march, [0.0]).joint_forces is None


def steps(world, count):
    """Make steps of a world."""
    states = world.march.at(world.start + world.substep * np.arange(1, count + 1), handles=2)
    for row in range(count):
        world.prepare(states, row)
        world.space.step(world.substep)
        world.read()
        yield row


@pytest.mark.parametrize("contacts", ["stop", "resolve"])
def test_joints_begin_with_the_tension_that_the_drag_makes(contacts):
    """Each joint of a straight, unguided chain balances the drag on all benches behind it."""
    world = World(
        March(Dragon(benches=500), Line(stop=(2000, 0)), start_s=1000.0), "none", contacts=contacts
    )
    behind = np.cumsum(world.masses[:0:-1])[::-1]
    tension = behind * world.drag_rate
    np.testing.assert_allclose(world.joint_forces, tension, rtol=1e-6)


def test_joints_on_rails_begin_with_the_forces_of_a_converged_solver():
    world = World(March(Dragon(benches=40)), substep=1e-4, iterations=20_000, start=100.0)
    begin = world.joint_forces
    assert list(steps(world, 3)) == [0, 1, 2]
    np.testing.assert_allclose(begin, world.joint_forces, rtol=1e-3)


def test_unguided_head_pulls_the_whole_dragon_with_joints_that_hold():
    march = March(Dragon(benches=60))
    free = simulate(march, guide="none", until=2.0)
    front, rear = march.dragon.holes(free.poses[-1])
    assert np.hypot(*(front[1:] - rear[:-1]).T).max() < 0.01
    assert free.max_drift > 0.01
    run = simulate(march, guide="none", contacts="resolve", until=2.0, substep=free.substep)
    assert np.linalg.norm(run.poses[-1, 0, :2] - free.poses[-1, 0, :2]) < 1e-3
    assert run.settings.head_force == pytest.approx(2 * 11.5 * 500 * 0.04 * 0.3 * (3.41 + 59 * 2.2))


CIRCLE = March(Dragon(benches=8), Arc(centre=(0, 0), radius=5, begin_angle=0, sweep=6))


def test_settings_and_guides_play_the_same_run_again(tmp_path):
    guide = Rails()
    first, second = (simulate(CIRCLE, guide=guide, until=1.0) for _ in range(2))
    assert first == second == simulate(CIRCLE, until=1.0)
    run = simulate(CIRCLE, until=1.0, contacts="resolve", iterations=20, frame_interval=0.05)
    assert run.settings.head_force > 0
    assert simulate(CIRCLE, until=1.0, settings=run.settings) == run
    dragged = EngineSettings(drag=20.0)
    for name in ("run.npz", "same.npz"):
        simulate(CIRCLE, until=1.0, settings=dragged).save(tmp_path / name)
    assert (tmp_path / "run.npz").read_bytes() == (tmp_path / "same.npz").read_bytes()
    assert Run.load(tmp_path / "run.npz").settings.drag == 20.0


def test_run_knows_which_benches_its_guide_does_not_hold(tmp_path):
    mine = [type("Mine", (PathGuide,), members)() for members in ({}, {"free_from": 3})]
    for guide, name, free_from in (
        ("rails", "rails", None),
        ("none", "none", 1),
        (mine[0], "Mine", None),
        (mine[1], "Mine", 3),
    ):
        run = simulate(CIRCLE, guide=guide, until=0.1)
        run.save(tmp_path / "run.npz")
        for each in (run, Run.load(tmp_path / "run.npz")):
            assert each.guide == name
            assert each.free_from == free_from
    world = World(CIRCLE, mine[1], contacts="resolve")
    assert world.free_from == 3
    world.release(5)
    assert world.free_from == 3
    world.release(2)
    assert world.free_from == 2


def test_stop_logs_the_three_phases_of_the_last_substep(late_run):
    assert [event.phase for event in late_run.events] == ["begin", "pre_solve", "post_solve"]
    begin, _, post = late_run.events
    assert begin.impulse is None
    assert np.dot(begin.relative_velocity, begin.normal) < 0
    # The engine pushes the second bench away from the first.
    assert np.dot(post.impulse, post.normal) > 0


def test_report_plays_on_without_pushing_and_shows_when_the_benches_part(reported, seed_march):
    # 16 benches meet as the long dragon does.
    assert reported.first_contact.time == pytest.approx(TRUE_TIME, abs=0.5e-3)
    assert reported.times[-1] == pytest.approx(415.2)
    (window,) = reported.events.windows()
    assert window.benches == (0, 8)
    assert window.begin == reported.first_contact.raw_time
    # The exact benches part at the same time, to a substep and the drift.
    assert shapely_gap(seed_march, window.end - 0.02, (0, 8)) == 0
    assert shapely_gap(seed_march, window.end + 0.02, (0, 8)) > 0
    assert {event.phase for event in reported.events} == {"begin", "pre_solve", "separate"}
    assert reported.max_drift <= MAX_DRIFT
    times = [event.time for event in reported.events]
    assert times == sorted(times)
    assert all(event.benches[1] - event.benches[0] > 1 for event in reported.events)
    assert all(
        len(event.points) in (1, 2) for event in reported.events if event.phase != "separate"
    )


def test_reported_depths_are_the_overlaps_of_the_outlines(reported, seed_march):
    events = of_phase(reported, "pre_solve")
    deepest = max(events, key=lambda event: event.depth)
    frame = np.argmin(np.abs(reported.times - deepest.time))
    near = min(events, key=lambda event: abs(event.time - reported.times[frame]))
    first, second = polygons(seed_march, near.benches, reported.poses[frame])
    for more, overlaps in ((1e-6, False), (-1e-6, True)):
        moved = shapely.affinity.translate(second, *(np.array(near.normal) * (near.depth + more)))
        assert (first.intersection(moved).area > 0) is overlaps


# m: how far the holes of a joint may be apart, and benches may be inside each other, where contacts
# are resolved.
PILE_UP = 1e-3


def assert_piles_up(run, march):
    """Joint gaps and depths in each frame after the contact, by definition and by Shapely."""
    after = run.times >= run.first_contact.time
    front, rear = march.dragon.holes(run.poses[after])
    assert np.linalg.norm(front[:, 1:] - rear[:, :-1], axis=-1).max() <= PILE_UP
    touched = {event.benches for event in run.events}
    assert max(event.depth for event in of_phase(run, "pre_solve")) <= PILE_UP
    for poses in run.poses[after][::50]:
        outlines = [shapely.Polygon(corners) for corners in march.dragon.outlines(poses)]
        pairs = shapely.STRtree(outlines).query(outlines, predicate="intersects").T
        assert {(int(i), int(j)) for i, j in pairs if i + 1 < j} <= touched
        for i, j in touched:
            common = outlines[i].intersection(outlines[j])
            # A corner inside the other bench is no wider than deep, twice over.
            assert common.area <= PILE_UP * 2 * np.sqrt(2) * max(common.length, PILE_UP)


def test_head_is_stopped_by_what_it_runs_into(reported):
    run = simulate(SIXTEEN, start=412.3, until=413.1, contacts="resolve", frame_interval=0.005)
    assert run.first_contact.benches == (0, 8)
    assert_piles_up(run, SIXTEEN)
    speeds = np.linalg.norm(run.pose_velocities[..., :2], axis=-1)
    assert speeds[0].min() > 0.7
    assert speeds[-1].max() < 0.05
    # The engine pushes the benches apart.
    deepest = [
        max(event.depth for event in of_phase(each, "pre_solve")) for each in (run, reported)
    ]
    assert deepest[0] < 0.5 * deepest[1]
    assert max(np.dot(event.impulse, event.normal) for event in of_phase(run, "post_solve")) > 0


@pytest.mark.thorough
def test_dragon_comes_to_rest_in_the_pile_up(seed_march):
    run = simulate(seed_march, start=412.0, until=422.5, contacts="resolve", frame_interval=0.005)
    assert run.drift[run.times < 412.4].max() < 5e-6
    assert_piles_up(run, seed_march)
    # The motor still pushes, and the head slips by a tenth of a millimetre now and then.
    assert np.linalg.norm(run.pose_velocities[-200:, :, :2], axis=-1).max() < 0.05
    moved = np.linalg.norm(run.poses[-1, :, :2] - run.poses_at(417.5)[0, :, :2], axis=-1)
    assert moved.max() < 0.002


def test_head_with_a_weak_motor_stays_behind():
    weak = simulate(SIXTEEN, start=400.0, until=402.0, contacts="resolve", head_force=20.0)
    assert np.linalg.norm(weak.poses[-1, 0, :2] - weak.poses[0, 0, :2]) < 0.5


def test_callback_is_told_every_event_and_what_it_raises_comes_after_the_step(capfd):
    told = []
    run = simulate(SIXTEEN, start=412.4, on_event=told.append)
    assert told == list(run.events)
    for failure in (ValueError("seen"), KeyboardInterrupt()):

        def on_event(event, failure=failure):
            raise failure

        with pytest.raises(type(failure)) as caught:
            simulate(SIXTEEN, start=412.4, on_event=on_event)
        assert caught.value is failure
    assert capfd.readouterr() == ("", "")


def test_clear_run_ends_when_it_shall_and_tells_its_progress():
    told = []
    run = simulate(
        SIXTEEN,
        start=10.0,
        until=10.38,
        progress=lambda *told_now: told.append(np.round(told_now, 9)),
    )
    assert run.outcome == "clear"
    assert run.first_contact is None
    # An overlap at the start is a contact at the start.
    overlapping = simulate(SIXTEEN, start=413.0).first_contact
    assert overlapping.time == 413.0
    assert overlapping.benches == (0, 8)
    np.testing.assert_allclose(run.times, [10.0, 10.1, 10.2, 10.3, 10.38], atol=1e-9)
    assert np.array_equal(told, [(10.1, 10.38), (10.2, 10.38), (10.3, 10.38)])
    shortest = simulate(March(Dragon(benches=4)), until=1e-8)
    assert shortest.substeps == 1
    assert shortest.times.size == 2


def test_run_ends_where_the_curve_leaves_the_head_no_place():
    march = March(Dragon(benches=3, width=0.01))
    run = simulate(march, start=425.0)
    after = run.times[-1] + 1.1 * run.substep
    assert run.outcome == "unreachable"
    assert refusal(march.at, after, handles=2, error=UnreachableError).handle == 1
    assert np.all(np.isfinite(run.poses))
    # Long body benches stop fitting before the head does: the engine plays on, and their drift
    # cannot be known.
    run = simulate(
        March(Dragon(benches=3, head_spacing=1.0, body_spacing=2.6, width=0.02)), start=430.0
    )
    assert np.isnan(run.drift[-1]).tolist() == [False, True, True]
    assert np.isfinite(run.max_drift)


@pytest.mark.parametrize("contacts", ["report", "resolve"])
def test_no_run_is_longer_than_the_march_to_the_end_of_the_curve(contacts):
    # The head is held up by bench 8, and is not at the end of its curve by then.
    march = March(Dragon(benches=16), Section(Spiral(), -500.0, -28.0), start_s=-31.0)
    for until in (None, march.end, 1e9):
        run = simulate(march, contacts=contacts, until=until, frame_interval=0.1)
        assert march.end - 0.05 < run.times[-1] < march.end + 0.05
    straight = March(Dragon(benches=3), Line(stop=(12, 0)))
    run = simulate(straight, contacts=contacts, until=1e9)
    assert run.outcome == "unreachable"
    assert run.times[-1] == pytest.approx(straight.end, abs=0.05)


def test_signals_and_errors_during_a_step_are_raised_after_it(monkeypatch):
    # Within a callback from C they would be printed and forgotten.
    seen = []

    def interrupted(*_):
        signal.raise_signal(signal.SIGINT)
        seen.append("the end of the callback")

    for log, raised in ((interrupted, KeyboardInterrupt), (Dragon, TypeError)):
        with monkeypatch.context() as patch:
            patch.setattr(Recorder, "_log", log)
            with pytest.raises(raised):
                simulate(SIXTEEN, start=412.4)
    assert not seen
    seen.clear()
    # A callback of the user's own is ended.
    with pytest.raises(KeyboardInterrupt):
        simulate(SIXTEEN, start=412.4, on_event=interrupted)
    assert not seen
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(simulate, CIRCLE, until=0.1).result().times[-1] == pytest.approx(0.1)


def refused(**settings):
    """The name by which a run with these settings is refused."""
    return refusal(simulate, CIRCLE, **{"until": 1.0} | settings).name


@pytest.mark.parametrize("name", ["until", "substep", "iterations", "frame_interval"])
def test_settings_that_are_no_numbers_are_refused_by_name(name):
    for value in NO_NUMBERS:
        # None asks for the default.
        if value is not None:
            assert refused(**{name: value}) == name, value


def test_start_that_is_no_number_is_refused():
    for value in NO_NUMBERS:
        # None asks for the default, and a run may start at 0 s or before.
        if value is not None and not (type(value) is int and value in (0, -1)):
            assert refused(start=value) == "start", value


def test_head_force_that_is_no_number_or_without_contacts_is_refused():
    for value in NO_NUMBERS:
        if value is not None:
            assert refused(head_force=value, contacts="resolve") == "head_force", value
    assert refused(head_force=500.0) == "head_force"


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("contacts", {"contacts": "ignore"}),
        ("guide", {"guide": "ropes"}),
        ("guide", {"guide": Rails}),
        ("guide", {"guide": object()}),
        ("guide", {"guide": 3}),
        ("iterations", {"iterations": 2.5}),
        ("settings", {"settings": {}}),
        ("settings", {"settings": 0.01}),
        ("settings", {"settings": EngineSettings}),
        ("substep", {"substep": 1.0}),
        ("substep", {"substep": 1e-9}),
        ("until", {"start": 5.0, "until": 5.0}),
        ("until", {"start": 5.0, "until": 1e300}),
    ],
)
def test_settings_of_wrong_kinds_or_sizes_are_refused_by_name(name, settings):
    assert refused(**settings) == name


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("joints", lambda self, bench, body: None),
        ("anchors", 3),
        ("anchors", [3]),
        ("free_from", 0),
        ("free_from", 8),
        ("free_from", "tail"),
    ],
)
def test_wrong_attribute_of_a_guide_is_refused_by_its_name(name, value):
    class Mine(PathGuide):
        """A guide with one wrong attribute."""

    setattr(Mine, name, value)
    assert refused(guide=Mine()) == f"Mine.{name}"


def test_start_past_the_end_of_the_path_is_unreachable(seed_march):
    refusal(simulate, seed_march, start=441.0, until=442.0, error=UnreachableError)


def test_chain_that_flies_apart_is_an_error_not_a_run(monkeypatch):
    monkeypatch.setattr(
        World, "read", lambda world: setattr(world, "velocities", world.velocities * np.nan)
    )
    assert_says(refusal(simulate, CIRCLE, until=0.5, error=DragonError), "flew apart")
