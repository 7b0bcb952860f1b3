"""Readings of spaces: energies, forces, torques and normals against mechanics, and contacts."""

from __future__ import annotations

import math
import random
import re
from pathlib import Path

import numpy as np
import pymunk
import pytest

import pymunk_dragon
from pymunk_dragon import Dragon, Line, March, World
from pymunk_dragon.physics.readings import NO_ARROW, Readings, Touches, energies, impulse_of, units
from pymunk_dragon.sessions.scene import PlaySettings, Scene
from pymunk_dragon.sessions.scenes import march_scene, space_scene
from pymunk_dragon.sessions.session import Session

TOTAL = "Kinetic and potential energy"
# Lengths of steps, s.
ALTERNATING = [0.01, 0.005]
GRAVITY = 10.0


def empty(gravity=GRAVITY):
    space = pymunk.Space()
    space.gravity = 0, -gravity
    space.iterations = 50
    return space


def total_energies(space, steps, length=0.0005):
    """Energy after each of so many steps."""
    found = []
    for _ in range(steps):
        space.step(length)
        found.append(energies(space)[TOTAL])
    return np.array(found)


# ---- energies


def test_energy_of_a_pendulum_whose_mass_comes_from_its_shape_is_constant():
    space = empty(9.81)
    rod = pymunk.Body()
    shape = pymunk.Segment(rod, (0, 0), (1, 0), 0.02)
    shape.density = 10
    space.add(rod, shape, pymunk.PivotJoint(space.static_body, rod, (0, 0), (0, 0)))
    begin = energies(space)[TOTAL]
    assert total_energies(space, 2000) == pytest.approx(begin, abs=0.01)
    assert rod.angle < -3


def test_energy_of_a_body_in_free_flight_is_that_of_its_centre_of_mass():
    space = empty()
    body = pymunk.Body(2, 3)
    body.center_of_gravity = 0.5, 0.2
    body.position = 1, 1
    body.velocity, body.angular_velocity = (1, 4), 3
    space.add(body)
    begin = energies(space)
    assert begin["Kinetic energy"] == pytest.approx((2 * 17 + 3 * 9) / 2)
    assert begin[TOTAL] - begin["Kinetic energy"] == pytest.approx(2 * GRAVITY * 1.2)
    assert total_energies(space, 4000) == pytest.approx(begin[TOTAL], abs=0.11)


def spring_scale(max_force=math.inf):
    """A mass of 10 on a spring of stiffness 200 and rest length 100."""
    space = empty(981)
    body = pymunk.Body(10, 1)
    body.position = 0, -100
    spring = pymunk.DampedSpring(space.static_body, body, (0, 0), (0, 0), 100, 200, 0)
    spring.max_force = max_force
    space.add(body, spring)
    return space, body, spring


@pytest.mark.parametrize("max_force", [math.inf, 12_000.0])
def test_mass_on_a_spring_exchanges_its_energy_with_the_spring(max_force):
    """Also where the spring reaches its largest force."""
    space, body, _ = spring_scale(max_force)
    begin = energies(space)[TOTAL]
    found = total_energies(space, 2000, 2e-4)
    lowest = 10 * 981 * (body.position.y + 100)
    assert lowest < -3e5
    assert found == pytest.approx(begin, abs=1e-3 * abs(lowest))


def test_rotary_spring_exchanges_its_energy_with_the_rotation():
    space = empty(0)
    wheel = pymunk.Body(2, 3)
    wheel.angle = 1.0
    pivot = pymunk.PivotJoint(space.static_body, wheel, (0, 0), (0, 0))
    space.add(wheel, pivot, pymunk.DampedRotarySpring(space.static_body, wheel, 0, 50, 0))
    assert energies(space)[TOTAL] == 25
    assert total_energies(space, 4000) == pytest.approx(25, abs=0.03)


def test_springs_with_forces_of_the_users_and_rotation_of_infinite_moment_have_no_energy():
    space = empty(0)
    body = pymunk.Body(2, math.inf)
    body.angular_velocity, body.velocity = 3, (1, 0)
    spring = pymunk.DampedSpring(space.static_body, body, (0, 0), (0, 0), 5, 100, 0)
    spring.force_func = lambda spring, distance: 7.0
    space.add(body, spring)
    assert energies(space) == {"Kinetic energy": 1, TOTAL: 1, "Momentum": 2}


# ---- forces and torques of joints


def stepped(space, joints, lengths):
    """Sizes of forces and torques in each of some steps."""
    readings, found = Readings(space), []
    for length in lengths:
        readings.before_step(length)
        space.step(length)
        found.append(readings.joints(joints)[:, 4])
    return np.array(found)


def test_spring_at_rest_carries_the_weight():
    space, _, spring = spring_scale()
    spring.damping = 20
    (*_, last) = stepped(space, [spring], 5000 * [0.01])
    assert last == pytest.approx(9810)
    # It pulls as well as it pushes.
    space.gravity = 0, 981
    (*_, last) = stepped(space, [spring], 5000 * [0.01])
    assert last == pytest.approx(9810)


def lever(space):
    """A lever of 1 kg whose centre of mass is 1 m beside its pivot."""
    body = pymunk.Body(1, 1)
    body.center_of_gravity = 1, 0
    body.position = 0, 0
    space.add(body, pymunk.PivotJoint(space.static_body, body, (0, 0), (0, 0)))
    return body


def bob(space):
    body = pymunk.Body(1, 1)
    body.position = 0, -1
    space.add(body)
    return body


JOINTS = {
    "pivot": lambda space, ground: pymunk.PivotJoint(ground, bob(space), (0, 0), (0, 1)),
    "pin": lambda space, ground: pymunk.PinJoint(ground, bob(space), (0, 0), (0, 0)),
    "slide": lambda space, ground: pymunk.SlideJoint(ground, bob(space), (0, 0), (0, 0), 0, 1),
    "groove": lambda space, ground: pymunk.GrooveJoint(
        ground, bob(space), (-1, -1), (1, -1), (0, 0)
    ),
    "motor": lambda space, ground: pymunk.SimpleMotor(ground, lever(space), 0),
    "gear": lambda space, ground: pymunk.GearJoint(ground, lever(space), 0, 1),
    "limit": lambda space, ground: pymunk.RotaryLimitJoint(ground, lever(space), 0, 1),
    "ratchet": lambda space, ground: pymunk.RatchetJoint(ground, lever(space), 0, math.pi),
    "spring": lambda space, ground: pymunk.DampedSpring(
        ground, bob(space), (0, 0), (0, 0), 0.9, 100, 50
    ),
    "rotary spring": lambda space, ground: pymunk.DampedRotarySpring(
        ground, lever(space), 0.01, 1000, 90
    ),
}
TORQUES = {"motor", "gear", "limit", "ratchet", "rotary spring"}


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize(
    "lengths",
    [ALTERNATING * 10, [0.01, 0.005, 0.007, 0.012] * 5, [0.04] * 10, [0.0025] * 10],
    ids=["alternating", "four", "longer", "shorter"],
)
def test_joint_that_carries_10_newtons_says_so_in_steps_of_any_length(name, lengths):
    space = empty()
    joint = JOINTS[name](space, space.static_body)
    space.add(joint)
    for _ in range(4000):
        space.step(0.01)
    found = stepped(space, [joint], lengths)
    assert found == pytest.approx(GRAVITY, rel=2e-3)
    assert Readings(space).joints([joint])[0, 5] == (name in TORQUES)


def test_joint_of_a_body_that_sleeps_keeps_its_force_when_the_step_changes():
    space = empty()
    space.sleep_time_threshold, space.idle_speed_threshold = 0.1, 1.0
    joint = JOINTS["pin"](space, space.static_body)
    space.add(joint)
    readings = Readings(space)
    for length in [0.01] * 100 + [0.02] * 10 + [0.005] * 10:
        readings.before_step(length)
        space.step(length)
    assert joint.b.is_sleeping
    assert readings.joints([joint])[0, 4] == pytest.approx(GRAVITY, rel=1e-3)
    # Pymunk 7.3.1 reads freed memory where a space goes in which a body with a joint sleeps.
    joint.b.activate()


def on_floor(space, shapes):
    """Bodies on a floor, with the shapes that functions make of them."""
    floor = pymunk.Segment(space.static_body, (-9, 0), (9, 0), 0.1)
    bodies = [pymunk.Body(1, 1) for _ in shapes]
    for x, body in enumerate(bodies):
        body.position = 3 * x, 0.59
    space.add(floor, *bodies, *(make(body) for make, body in zip(shapes, bodies, strict=True)))
    return bodies


def ball(body):
    return pymunk.Circle(body, 0.5)


def box(body):
    return pymunk.Poly.create_box(body, (1, 1))


@pytest.mark.parametrize("shape", [ball, box])
def test_floor_carries_10_newtons_in_steps_of_any_length(shape):
    space = empty()
    space.collision_slop = 0.01
    on_floor(space, [shape])
    readings, found = Readings(space), []
    lengths = [0.01] * 500 + ALTERNATING * 10 + [0.01, 0.02, 0.02, 0.005, 0.005]
    for length in lengths:
        readings.before_step(length)
        space.step(length)
        impulses = readings.contacts()[:, 4]
        found.append(impulses[impulses != NO_ARROW].sum() / length)
    assert np.array(found[500:]) == pytest.approx(GRAVITY, rel=2e-3)


def test_body_of_two_balls_has_impulses_that_change_its_momentum_in_steps_of_random_lengths():
    space, dice = empty(), random.Random(1)
    space.collision_slop = 0.01
    (body,) = on_floor(space, [lambda body: pymunk.Circle(body, 0.5, (-0.7, 0))])
    space.add(pymunk.Circle(body, 0.5, (0.7, 0)))
    readings = Readings(space)
    for _ in range(600):
        length, before = dice.uniform(0.008, 0.014), body.velocity.y
        readings.before_step(length)
        space.step(length)
        change = body.velocity.y - before + GRAVITY * length
        assert readings.contacts()[:, 4].sum() == pytest.approx(change, rel=1e-6, abs=1e-6)


def test_ball_that_touches_again_at_once_has_the_impulse_of_its_second_contact():
    """Pymunk would add that of the first one."""
    space = empty(0)
    space.collision_slop = 0
    (body,) = on_floor(space, [ball])
    readings = Readings(space)
    for velocity in (-1, 5, None, -10):
        body.velocity = body.velocity if velocity is None else (0, velocity)
        before = body.velocity.y
        readings.before_step(0.01)
        space.step(0.01)
        assert readings.contacts()[:, 4] == pytest.approx(
            body.velocity.y - before if velocity in (-1, -10) else []
        )


def test_impulse_in_post_solve_is_the_change_of_momentum_also_after_a_change_of_the_step():
    space = empty(0)
    space.collision_slop = 0
    (body,) = on_floor(space, [ball])
    before, found = [], []

    def pre_solve(arbiter, space, data):
        before.append(arbiter.total_impulse)

    def post_solve(arbiter, space, data):
        found.append(impulse_of(arbiter, before[-1], data[-1]).length)

    ratios = []
    space.on_collision(pre_solve=pre_solve)
    space.on_collision(post_solve=post_solve, data=ratios)
    # It touches, leaves, touches again, and is pressed down in steps of several lengths.
    for velocity, length in (
        (-1, 0.01),
        (5, 0.01),
        (-9, 0.01),
        (-2, 0.01),
        (-2, 0.005),
        (-1, 0.01),
    ):
        ratios.append(length / (space.current_time_step or length))
        body.velocity = 0, velocity
        found.clear()
        space.step(length)
        assert found == pytest.approx([body.velocity.y - velocity] if velocity < 0 else [])


def test_step_of_0_s_shows_no_forces_and_the_next_one_shows_them_again():
    space = empty()
    joint = JOINTS["pivot"](space, space.static_body)
    space.add(joint)
    on_floor(space, [ball])
    readings = Readings(space)
    for length in [0.01] * 300 + [0.0]:
        readings.before_step(length)
        space.step(length)
    assert np.isnan(readings.joints([joint])[0, 4])
    assert readings.contacts()[:, 4].tolist() == [NO_ARROW]
    readings.before_step(0.005)
    space.step(0.005)
    assert readings.joints([joint])[0, 4] == pytest.approx(GRAVITY, rel=1e-3)
    assert readings.contacts()[:, 4] == pytest.approx(0.005 * GRAVITY, rel=1e-3)


# ---- normals


def test_normals_point_from_the_floor_to_what_lies_on_it():
    space = empty()
    on_floor(space, [ball, box, lambda body: pymunk.Segment(body, (-0.5, 0), (0.5, 0), 0.5)])
    readings = Readings(space)
    for _ in range(100):
        readings.before_step(0.01)
        space.step(0.01)
    rows = readings.contacts()
    assert len(rows) == 5
    assert rows[:, 2:4] == pytest.approx(np.tile([0, 1], (5, 1)), abs=1e-6)


@pytest.mark.parametrize("shape", [ball, box])
def test_normal_of_two_equal_shapes_points_from_the_older_body_at_all_times(shape):
    space = empty(0)
    bodies = [pymunk.Body(1, 1) for _ in range(2)]
    for x, body in enumerate(bodies):
        body.position, body.velocity = (0.99 * x, 0), (5, 3)
    # The right one was added first.
    space.add(*bodies[::-1], *map(shape, bodies))
    readings, normals = Readings(space), []
    for _ in range(100):
        readings.before_step(0.01)
        space.step(0.01)
        normals += readings.contacts()[:, 2].tolist()
    assert len(normals) >= 100
    assert normals == pytest.approx([-1] * len(normals), abs=1e-6)


# ---- what touches


def kinematic(space, x):
    body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    body.position, body.velocity = (x, 0), (1, 0)
    space.add(body)
    return body


def dynamic(space, x):
    body = pymunk.Body(1, 1)
    body.position, body.velocity = (x, 0), (1, 0)
    space.add(body)
    return body


def first_touch(space, add_wall):
    """Time of the step after which a ball and a wall 1 m ahead touch; None within 2 s."""
    touches = Touches(space)
    for step in range(1, 201):
        space.step(0.01)
        if touches.begin():
            return step / 100
    return None


CASES = {
    "sensor": (dynamic, {"sensor": True}),
    "kinematic and static": (kinematic, {}),
    "kinematic sensor": (kinematic, {"sensor": True}),
    "dynamic and static": (dynamic, {}),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("refused", [False, True])
def test_every_pair_that_pymunk_reports_touches_when_it_begins_to(case, refused):
    """Also one that the user's `begin` switches off, which is called as before."""
    make, changes = CASES[case]
    space, begun = empty(0), []
    shape = pymunk.Circle(make(space, 0), 0.5)
    wall = pymunk.Segment(space.static_body, (1.5, -1), (1.5, 1), 0)
    for name, value in changes.items():
        setattr(wall, name, value)
    space.add(shape, wall)

    def begin(arbiter, space, data):
        begun.append(arbiter.shapes)
        arbiter.process_collision = not refused

    space.on_collision(begin=begin)
    assert first_touch(space, wall) == pytest.approx(1.0, abs=0.011)
    assert len(begun) == 1


def test_pairs_that_pymunk_does_not_report_never_touch():
    space = empty(0)
    body = dynamic(space, 0)
    mine = pymunk.Circle(body, 0.5)
    space.add(mine, pymunk.Circle(body, 0.5, (0.2, 0)))
    mine.filter = pymunk.ShapeFilter(group=1)
    filtered = pymunk.Segment(space.static_body, (1.5, -1), (1.5, 1), 0)
    filtered.filter = pymunk.ShapeFilter(mask=0)
    other = dynamic(space, 1.2)
    joint = pymunk.PivotJoint(body, other, (0.6, 0))
    joint.collide_bodies = False
    other_shape = pymunk.Circle(other, 0.5)
    other_shape.filter = pymunk.ShapeFilter(mask=pymunk.ShapeFilter.ALL_MASKS())
    space.add(filtered, other_shape, joint)
    assert first_touch(space, filtered) is None


def test_session_waits_for_a_sensor_and_pauses():
    def build():
        space = empty(0)
        space.add(pymunk.Circle(kinematic(space, 0), 0.5))
        gate = pymunk.Segment(space.static_body, (1.5, -1), (1.5, 1), 0)
        gate.sensor = True
        space.add(gate)
        return space

    scene = space_scene(build, PlaySettings(step=0.01)).build({})
    scene.waits_for_contact = True
    while not scene.stops:
        scene.advance()
    assert scene.time == pytest.approx(1.0, abs=0.011)
    assert not scene.waits_for_contact


# ---- changes of the step


def gap(world):
    """Largest gap of a joint, m."""
    ends = ((p.a.local_to_world(p.anchor_a), p.b.local_to_world(p.anchor_b)) for p in world.pivots)
    return max(one.get_distance(two) for one, two in ends)


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0])
def test_slider_of_the_step_does_not_jolt_a_dragon_that_only_the_head_pulls(factor):
    scene = march_scene(March(Dragon(benches=120))).build({})
    scene.contacts("report")
    scene.world.release(1)
    for _ in range(300):
        scene.advance()
    before = scene.world.joint_forces.max()
    assert before > 300
    chosen = factor * scene.values["step"]
    scene.set("step", chosen)
    forces, gaps = [], []
    for _ in range(20):
        scene.advance()
        forces.append(scene.world.joint_forces.max())
        gaps.append(gap(scene.world))
    assert np.array(forces) == pytest.approx(before, rel=0.02)
    assert max(gaps) < 5e-5
    assert scene.state()["values"]["step"] == chosen
    for _ in range(200):
        time = scene.time
        scene.advance()
        assert scene.time - time == pytest.approx(scene.space.current_time_step)
    assert scene.space.current_time_step == pytest.approx(chosen / 1000)


def test_world_changes_its_substep_gradually_and_its_forces_are_those_that_change_momenta():
    world = World(
        March(Dragon(benches=30), Line(stop=(400, 0)), start_s=200.0), "none", contacts="resolve"
    )
    behind = np.cumsum(world.masses[:0:-1])[::-1]
    tail, wanted = world.bodies[-1], world.substep / 3
    world.change(substep=wanted)
    for _ in range(200):
        before = tail.velocity
        world.follow(0.1, 10.0)
        world.space.step(world.substep)
        length = world.substep
        kept = math.exp(-world.drag_rate * length)
        change = tail.mass * (tail.velocity - kept * before).length
        seconds = (1 - kept) / world.drag_rate
        assert world.joint_forces[-1] == pytest.approx(change / seconds, rel=1e-9)
        assert world.joint_forces == pytest.approx(behind * world.drag_rate, rel=0.03)
        world.read()
    assert world.substep == wanted


def hanging():
    """A space with a weight of 10 N on a pivot, at rest."""
    space = empty()
    space.add(JOINTS["pivot"](space, space.static_body))
    return space


def test_program_whose_clock_starts_with_0_s_goes_on():
    session = Session(space_scene(hanging, PlaySettings(step=None)))
    for length in (0.0, 0.01, 0.0, 0.005, 0.01):
        session.step(length)
        session.scene.frame({})
    assert session.clock.running
    assert session.scene.steps == 5
    assert session.scene.time == pytest.approx(0.025)


# ---- units and platforms


def test_page_gets_units_of_forces_torques_and_energies_in_the_lengths_of_the_space():
    assert units("m") == {"force": "N", "torque": "N m", "impulse": "N s", "energy": "J"}
    about = Scene(
        hanging(),
        PlaySettings(units="px", plots={"Momentum": lambda space: 0.0, "Height (px)": len}),
    ).to_dict()
    assert about["unit_of"] == {
        "force": "kg px/s²",
        "torque": "kg px²/s²",
        "impulse": "kg px/s",
        "energy": "kg px²/s²",
    }
    # A quantity of the user's takes the place of one of the same name, and has its unit in its
    # name.
    energy = "kg px²/s²"
    assert about["plots"] == [
        ("Momentum", ""),
        ("Height (px)", ""),
        ("Kinetic energy", energy),
        (TOTAL, energy),
    ]


def test_whole_numbers_have_64_bits_only_where_they_need_them_on_every_platform():
    """Counts and indices are `np.intp`, Pymunk's pointers `np.uintp`: 32 bits where Python has."""
    wanted = {
        # Products of numbers of cells.
        (
            "collision/grid.py",
            "rows, columns = (cells - cells.min(axis=0)).astype(np.int64, copy=False).T",
        ),
        # What a page subtracts, before it is wrapped to 32 bits.
        ("player/data.py", "counts = np.rint((vectors - origin) / step).astype(np.int64)"),
    }
    root = Path(pymunk_dragon.__file__).parent
    sources = {
        path.relative_to(root).as_posix(): path.read_text(encoding="utf-8")
        for path in root.rglob("*.py")
    }
    lines = {(name, line.strip()) for name, text in sources.items() for line in text.splitlines()}
    assert {
        (name, line) for name, line in lines if re.search(r"u?int64|longlong|\b[iu]8\b", line)
    } == wanted
