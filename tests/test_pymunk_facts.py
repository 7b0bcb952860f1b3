"""What the guides and docstrings say about Pymunk, each once, by Pymunk alone.

A test that fails with a new version of Pymunk names the sentence that has to be changed.
"""

import gc
import math
import pickle
import random
import re
import sys

import pymunk
import pytest
from documents import GUIDES
from pymunk import batch

PHASES = ("begin", "pre_solve", "post_solve", "separate")
STEP = 0.01  # s


def circle(body):
    return pymunk.Circle(body, 1)


def box(body):
    return pymunk.Poly.create_box(body, (2, 1))


def pair(types=(0, 0), distance=1.8, shape=circle):
    """Two bodies side by side, which overlap unless they are 2 m or more apart."""
    space = pymunk.Space()
    bodies = [pymunk.Body(1, 1), pymunk.Body(1, 1)]
    for number, (body, kind) in enumerate(zip(bodies, types, strict=True)):
        body.position = distance * number, 0
        part = shape(body)
        part.collision_type = kind
        space.add(body, part)
    return space, *bodies


def steps(space, count):
    for _ in range(count):
        space.step(STEP)


def phases_of(space):
    """A list to which all callbacks of all pairs add their names."""
    found = []
    for phase in PHASES:
        space.on_collision(**{phase: lambda arbiter, space, data: found.append(data)}, data=phase)
    return found


@pytest.fixture
def printed(monkeypatch):
    """Errors that Python can only print."""
    errors = []
    monkeypatch.setattr(sys, "unraisablehook", lambda lost: errors.append(lost.exc_value))
    return errors


# Callbacks: which, in which order, with which shapes


@pytest.mark.parametrize("types", [(1, 2), (2, 1)])
def test_handlers_of_both_orders_and_of_each_type_and_of_all_run_with_shapes_in_their_order(types):
    space, *_ = pair(types)
    calls = []

    def called(arbiter, space, handler):
        calls.append((handler, tuple(shape.collision_type for shape in arbiter.shapes)))

    for handler in ((1, 2), (2, 1), (1, None), (2, None), (None, None)):
        space.on_collision(*handler, begin=called, data=handler)
    space.step(STEP)
    both = calls[:2]
    single = calls[2:4]
    (of_all,) = calls[4:]
    assert sorted(both) == [((1, 2), (1, 2)), ((2, 1), (2, 1))]
    assert sorted(single) == [((1, None), (1, 2)), ((2, None), (2, 1))]
    assert of_all[0] == (None, None)


def test_two_shapes_of_one_type_call_its_callback_twice_each_time_with_another_one_first():
    space, body, _ = pair((1, 1))
    first = []
    space.on_collision(1, begin=lambda arbiter, *_: first.append(arbiter.bodies[0] is body))
    space.step(STEP)
    assert sorted(first) == [False, True]


@pytest.mark.parametrize("shape", [circle, box])
def test_shapes_of_equal_types_change_their_order_and_the_normal_during_a_contact(shape):
    space, body, other = pair(distance=1.9, shape=shape)
    body.velocity = other.velocity = 5, 5
    calls = phases_of(space)
    first = []
    normals = []

    def noted(arbiter, space, data):
        first.append(arbiter.bodies[0] is body)
        normals.append(arbiter.normal.x > 0)

    space.on_collision(0, 0, pre_solve=noted)
    steps(space, 100)
    assert calls.count("begin") == 1
    assert "separate" not in calls
    assert {True, False} == set(first)
    assert first == normals


def test_value_that_a_callback_returns_has_no_effect():
    space, body, other = pair(distance=2.5)
    body.velocity = 2, 0
    space.on_collision(begin=lambda *_: False, pre_solve=lambda *_: False)
    steps(space, 100)
    assert other.velocity.x == pytest.approx(1)


@pytest.mark.parametrize("phase", ["begin", "pre_solve"])
def test_process_collision_stays_false_until_the_shapes_separate_and_then_is_true_again(phase):
    space, body, other = pair(distance=2.5)
    body.velocity = 2, 0
    calls = phases_of(space)
    refusals = [False]

    def refused(arbiter, space, data):
        if refusals:
            arbiter.process_collision = refusals.pop()

    space.on_collision(0, 0, **{phase: refused})
    steps(space, 300)
    assert other.velocity == (0, 0)
    assert calls.count("pre_solve") > 100
    assert "post_solve" not in calls
    assert calls[-1] == "separate"
    body.velocity = -2, 0
    steps(space, 300)
    assert other.velocity.x == pytest.approx(-1)


def test_pre_solve_can_let_a_collision_be_processed_that_begin_refused():
    space, body, other = pair(distance=2.5)
    body.velocity = 2, 0
    space.on_collision(
        begin=lambda arbiter, *_: setattr(arbiter, "process_collision", False),
        pre_solve=lambda arbiter, *_: setattr(arbiter, "process_collision", True),
    )
    steps(space, 100)
    assert other.velocity.x == pytest.approx(1)


def sensor(space, body, other):
    next(iter(body.shapes)).sensor = True


def kinematic(space, body, other):
    body.body_type = other.body_type = pymunk.Body.KINEMATIC


@pytest.mark.parametrize("change", [sensor, kinematic])
def test_pairs_that_are_not_solved_call_all_but_post_solve(change):
    space, body, other = pair()
    change(space, body, other)
    calls = phases_of(space)
    steps(space, 2)
    other.position = 9, 0
    space.step(STEP)
    assert calls == ["begin", "pre_solve", "pre_solve", "separate"]


def in_one_group(space, body, other):
    for shape in space.shapes:
        shape.filter = pymunk.ShapeFilter(group=1)


def masked(space, body, other):
    next(iter(body.shapes)).filter = pymunk.ShapeFilter(mask=0)


def joined(space, body, other):
    joint = pymunk.PivotJoint(body, other, (0.9, 0))
    joint.collide_bodies = False
    space.add(joint)


@pytest.mark.parametrize("change", [in_one_group, masked, joined])
def test_pairs_that_are_filtered_call_nothing(change):
    space, body, other = pair()
    change(space, body, other)
    calls = phases_of(space)
    steps(space, 3)
    assert calls == []


def test_empty_callback_removes_one_and_data_belongs_to_each_callback():
    space, _, other = pair()
    found = []
    for phase in ("begin", "pre_solve", "separate"):
        space.on_collision(**{phase: lambda arbiter, space, data: found.append(data)}, data=phase)
    space.on_collision(pre_solve=pymunk.empty_callback)
    space.step(STEP)
    other.position = 9, 0
    space.step(STEP)
    assert found == ["begin", "separate"]


# Callbacks: what can be read in them


@pytest.mark.parametrize("removed", [False, True])
def test_impulse_is_zero_in_begin_and_separate_and_in_pre_solve_that_of_the_step_before(removed):
    space, body, _ = pair(distance=2.05)
    body.velocity = 10, 0
    for shape in space.shapes:
        shape.elasticity = 1
    found = {phase: [] for phase in PHASES}

    def noted(arbiter, space, data):
        data.append(arbiter.total_impulse.length)

    for phase in PHASES:
        space.on_collision(**{phase: noted}, data=found[phase])
    if removed:
        steps(space, 2)
        space.remove(*space.shapes)
    else:
        steps(space, 50)
    assert found["begin"] == [0]
    assert found["post_solve"][0] == pytest.approx(10)
    assert found["pre_solve"] == [0, *found["post_solve"][:-1]]
    assert found["separate"] == [0]


def test_impulse_of_a_pair_that_touches_again_at_once_counts_the_earlier_one_too():
    space, body = pymunk.Space(), pymunk.Body(1, 1)
    space.collision_slop = 0
    space.add(body, pymunk.Circle(body, 1), pymunk.Segment(space.static_body, (-9, -1), (9, -1), 0))
    found = []
    space.on_collision(
        post_solve=lambda arbiter, space, data: found.append(arbiter.total_impulse.length)
    )
    gained = []
    for velocity in (-1, 5, 0, -10):
        body.velocity = 0, velocity
        space.step(STEP)
        gained.append(body.velocity.y - velocity)
    assert (gained[0], gained[3]) == pytest.approx((1, 10), abs=0.1)
    assert found[-1] == pytest.approx(gained[0] + gained[3])


def test_step_of_0_s_does_nothing():
    space, body, _ = pair()
    found = phases_of(space)
    body.velocity = 1, 0
    steps(space, 1)
    before, called = body.position, found[:]
    space.step(0)
    assert (body.position, found, space.current_time_step) == (before, called, STEP)


def test_contact_point_set_raises_in_separate_and_the_error_is_only_printed(printed):
    space, _, other = pair()
    after = []

    def left(arbiter, space, data):
        after.append(arbiter.contact_point_set)

    space.on_collision(separate=left)
    space.step(STEP)
    other.position = 9, 0
    space.step(STEP)
    assert after == []
    assert [type(error) for error in printed] == [AssertionError]


def test_shapes_collide_raises_for_shapes_that_are_apart():
    space, body, other = pair()
    (first,), (second,) = body.shapes, other.shapes
    space.step(STEP)
    assert len(first.shapes_collide(second).points) == 1
    other.position = 9, 0
    second.cache_bb()
    with pytest.raises(AssertionError):
        first.shapes_collide(second)


def test_points_that_are_set_all_get_the_coordinates_of_the_first():
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    body.position = 0, 0.4
    space.add(body, box(body), pymunk.Segment(space.static_body, (-9, 0), (9, 0), 0))
    found = []

    def unchanged(arbiter, space, data):
        before = arbiter.contact_point_set
        arbiter.contact_point_set = before
        found.extend([before, arbiter.contact_point_set])

    space.on_collision(pre_solve=unchanged)
    space.step(STEP)
    before, after = ([point.point_a.x for point in points.points] for points in found)
    assert sorted(before) == [-1, 1]
    assert after == [before[0], before[0]]


def test_arbiter_that_is_kept_becomes_that_of_a_later_contact():
    space, body, other = pair()
    kept = []
    space.on_collision(begin=lambda arbiter, *_: kept.append(arbiter))
    space.step(STEP)
    assert set(kept[0].bodies) == {body, other}
    other.position = 9, 0
    steps(space, 5)
    late = pymunk.Body(1, 1)
    late.position = 7.5, 0
    space.add(late, circle(late))
    space.step(STEP)
    assert set(kept[0].bodies) == {late, other}


def test_shape_does_not_keep_its_body_alive():
    shape = pymunk.Circle(pymunk.Body(1, 1), 1)
    gc.collect()
    assert shape.body is None


# Bodies that pass through others


def ball(body, size):
    return pymunk.Circle(body, size / 2)


def square(body, size):
    return pymunk.Poly.create_box(body, (size, size))


def passed(size, wall, step, share, shape):
    """Whether a body that meets a wall at 30 m/s within a step passes, and is noticed."""
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    body.position = -2 - 30 * step * share, 0
    body.velocity = 30, 0
    space.add(body, shape(body, size))
    space.add(pymunk.Segment(space.static_body, (0, -1), (0, 1), wall / 2))
    calls = phases_of(space)
    for _ in range(20):
        space.step(step)
    return body.position.x > 0, "begin" in calls


@pytest.mark.parametrize("shape", [ball, square])
@pytest.mark.parametrize(
    ("size", "wall", "step"), [(0.2, 0.1, 1 / 60), (0.1, 0.1, 1 / 50), (0.6, 0.1, 1 / 50)]
)
def test_share_that_passes_a_wall_is_one_less_half_the_overlap_over_the_way_of_a_step(
    size, wall, step, shape
):
    phases = [(number + 0.5) / 100 for number in range(100)]
    flights = [passed(size, wall, step, share, shape) for share in phases]
    overlap, way = size + wall, 30 * step
    assert sum(behind for behind, _ in flights) / 100 == pytest.approx(
        1 - overlap / 2 / way, abs=0.01
    )
    missed = sum(not noticed for _, noticed in flights) / 100
    assert missed == pytest.approx(max(0, 1 - overlap / way), abs=0.01)
    assert all(behind for behind, noticed in flights if not noticed)


def test_table_of_the_guide_to_contacts_has_the_shares_of_both_formulas():
    rows = re.findall(
        r"^(\d+) m/s: +([\d.]+) % pass, +([\d.]+) % missed", GUIDES["contacts"].text, re.MULTILINE
    )
    assert len(rows) == 4
    for speed, passing, missed in rows:
        way = float(speed) / 60
        assert float(passing) == pytest.approx(100 * (1 - 0.3 / 2 / way))
        assert float(missed) == pytest.approx(100 * max(0, 1 - 0.3 / way))


# Joints, impulses, energies


def chain(space, links):
    """A chain of links of a metre, level at first, that hangs from the static body."""
    space.gravity = 0, -10
    before, joints = space.static_body, []
    for number in range(links):
        link = pymunk.Body(1, 0.1)
        link.position = number, 0
        joints.append(pymunk.PivotJoint(before, link, (number - 0.5, 0)))
        space.add(link)
        before = link
    return joints


def largest_gap(joints):
    ends = [
        (joint.a.local_to_world(joint.anchor_a), joint.b.local_to_world(joint.anchor_b))
        for joint in joints
    ]
    return max((one - other).length for one, other in ends)


def load(space):
    """Reading, as an impulse, of 10 N on the static body, by a joint or a contact."""
    space.gravity = 0, -10
    body = pymunk.Body(1, 1)
    joint = pymunk.PivotJoint(space.static_body, body, (0, 0), (0, 0))
    space.add(body, joint)
    return lambda: joint.impulse


def weight(space):
    space.gravity = 0, -10
    body = pymunk.Body(1, 1)
    space.add(body, circle(body), pymunk.Segment(space.static_body, (-9, -0.95), (9, -0.95), 0))
    found = []
    space.on_collision(post_solve=lambda arbiter, *_: found.append(arbiter.total_impulse.length))
    return lambda: found[-1]


@pytest.mark.parametrize("build", [load, weight])
def test_impulse_is_wrong_after_a_change_of_the_step(build):
    space = pymunk.Space()
    impulse = build(space)
    forces = []
    for step in [0.01] * 5 + [0.005] * 3:
        space.step(step)
        forces.append(impulse() / step)
    assert forces[2:] == pytest.approx([10, 10, 10, 20, 10, 10])
    for step in [0.01, 0.005] * 40:
        space.step(step)
        forces.append(impulse() / step)
    assert forces[-2:] == pytest.approx([10 / 3, 40 / 3])


def test_impulses_of_springs_have_a_sign_and_those_of_other_joints_none():
    space = pymunk.Space()
    body = pymunk.Body(10, 10)
    body.position = 0, -2
    spring = pymunk.DampedSpring(space.static_body, body, (0, 0), (0, 0), 1, 100, 0)
    turned = pymunk.DampedRotarySpring(space.static_body, body, 1, 100, 0)
    motor = pymunk.SimpleMotor(space.static_body, body, 5)
    motor.max_force = 1
    space.add(body, spring, turned, motor)
    found = []
    for rest, angle, rate in ((1, 1, 5), (3, -1, -5)):
        spring.rest_length = rest
        turned.rest_angle = angle
        motor.rate = rate
        space.step(1e-3)
        found.append([joint.impulse / 1e-3 for joint in (spring, turned, motor)])
    assert found[0][0] == pytest.approx(-100, rel=0.01)
    assert found[1][0] == pytest.approx(100, rel=0.01)
    assert found[0][1] * found[1][1] < 0
    # N m: an impulse of torque.
    assert [found[0][2], found[1][2]] == pytest.approx([1, 1])


def test_velocity_is_that_of_the_centre_of_gravity_and_position_is_not():
    space, body = pymunk.Space(), pymunk.Body(2, 5)
    body.center_of_gravity = 1, 0
    body.position = 0, 0
    body.angular_velocity = 1
    space.add(body)
    centre = body.local_to_world(body.center_of_gravity)
    steps(space, 50)
    assert body.velocity == (0, 0)
    assert body.local_to_world(body.center_of_gravity).get_distance(centre) < 1e-12
    assert body.position.get_distance((0, 0)) > 0.4


def test_body_whose_centre_of_gravity_is_set_after_its_position_jumps_in_the_next_step():
    space, body = pymunk.Space(), pymunk.Body(2, 5)
    body.position = 3, 0
    body.center_of_gravity = 1, 0
    space.add(body)
    assert body.position == (3, 0)
    steps(space, 1)
    assert body.position == (2, 0)


def test_kinetic_energy_lacks_the_half():
    body = pymunk.Body(2, 5)
    body.velocity, body.angular_velocity = (3, 0), 1
    assert body.kinetic_energy == 2 * 3**2 + 5 * 1**2


def test_damping_and_error_bias_are_what_is_left_after_a_second():
    space = pymunk.Space()
    space.damping = 0.3
    free, held = pymunk.Body(1, 1), pymunk.Body(1, 1)
    free.velocity, held.position = (1, 0), (0.1, 0)
    joint = pymunk.PivotJoint(space.static_body, held, (0, 0), (0, 0))
    assert joint.error_bias == pytest.approx(0.9**60, rel=1e-5)
    joint.error_bias = 0.2
    space.add(free, held, joint)
    steps(space, 100)
    assert free.velocity.x == pytest.approx(0.3)
    # The correction begins to move the body one step later.
    space.step(STEP)
    assert held.position.x == pytest.approx(0.1 * 0.2)


def test_bodies_are_moved_by_the_velocities_of_the_step_before():
    space = pymunk.Space()
    space.gravity = 0, -10
    body = pymunk.Body(1, 1)
    space.add(body)
    space.step(STEP)
    assert (body.position.y, body.velocity.y) == (0, pytest.approx(-0.1))


def test_joints_added_along_a_chain_either_way_leave_half_the_gap_of_those_that_jump():
    def gap(order):
        space = pymunk.Space()
        space.damping, space.iterations = 1e-6, 30
        before, joints = pymunk.Body(body_type=pymunk.Body.KINEMATIC), []
        space.add(before)
        for number in range(80):
            link = pymunk.Body(1, 0.1)
            link.position = -number, 0
            joints.append(pymunk.PivotJoint(before, link, (0.5 - number, 0)))
            space.add(link)
            before = link
        space.add(*order(joints))
        for body in space.bodies:
            body.velocity = 1, 0
        gaps = []
        for _ in range(100):
            space.step(1 / 400)
            gaps.append(largest_gap(joints))
        return max(gaps)

    along = gap(lambda joints: joints)
    assert gap(lambda joints: joints[::-1]) == pytest.approx(along, rel=0.05)
    assert gap(lambda joints: joints[::2] + joints[1::2]) > 1.5 * along
    assert gap(lambda joints: random.Random(1).sample(joints, len(joints))) > 1.5 * along


@pytest.mark.skipif(sys.platform == "win32", reason="Pymunk has no threads there")
def test_two_threads_round_odd_iterations_up_where_there_are_more_than_fifty_joints():
    def gap(threads, iterations):
        space = pymunk.Space(threaded=True)
        space.threads, space.iterations = threads, iterations
        joints = chain(space, 60)
        space.add(*joints)
        steps(space, 30)
        return largest_gap(joints)

    odd = gap(1, 1)
    even = gap(1, 2)
    both = gap(2, 1)
    assert abs(both - even) < abs(both - odd) / 2


# What is listed and found


def listed(space):
    """Numbers of contact points of the pairs that the module batch lists."""
    buffer = batch.Buffer()
    batch.get_space_arbiters(space, batch.ArbiterFields.CONTACT_COUNT, buffer)
    return list(memoryview(buffer.int_buf()).cast("P"))


def test_batch_lists_pairs_that_have_come_apart_and_no_points_of_sensors():
    space, body, other = pair()
    space.step(STEP)
    assert listed(space) == [1]
    other.position = 9, 0
    counts = []
    for _ in range(5):
        space.step(STEP)
        counts.append(listed(space))
    stale = space.collision_persistence - 1
    assert counts == [[0]] * stale + [[]] * (5 - stale)
    other.position = 1.8, 0
    sensor(space, body, other)
    space.step(STEP)
    assert listed(space) == [0]


def test_nearest_point_of_a_query_on_the_edge_of_a_polygon_is_nan():
    polygon = pymunk.Poly.create_box(pymunk.Body(1, 1), (2, 2))
    polygon.cache_bb()
    on, beside = polygon.point_query((1, 0)), polygon.point_query((1.5, 0))
    assert (on.distance, beside.distance) == (0, 0.5)
    assert math.isnan(on.point.x)
    assert beside.point == (1, 0)


def test_query_with_a_radius_has_a_point_on_the_surface_and_the_share_of_the_way_of_the_centre():
    space = pymunk.Space()
    space.add(pymunk.Segment(space.static_body, (0, -1), (0, 1), 0.05))
    hit = space.segment_query_first((-1, 0), (1, 0), 0.1, pymunk.ShapeFilter())
    assert hit.point.x == pytest.approx(-0.05)
    assert -1 + 2 * hit.alpha == pytest.approx(-0.05 - 0.1)


def test_shapes_follow_a_body_that_was_moved_in_the_next_step_or_when_they_are_told_to():
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    shape = circle(body)
    space.add(body, shape)

    def found():
        return bool(space.point_query(body.position, 0, pymunk.ShapeFilter()))

    body.position = 100, 0
    assert (shape.bb.left, found()) == (-1, False)
    space.step(STEP)
    assert (shape.bb.left, found()) == (99, True)
    body.position = 200, 0
    shape.cache_bb()
    assert (shape.bb.left, found()) == (199, False)
    space.reindex_shapes_for_body(body)
    assert found()


@pytest.fixture
def asleep():
    """A space with a ball that sleeps on a floor: the space, the ball, the floor."""
    space = pymunk.Space()
    space.gravity, space.sleep_time_threshold = (0, -10), 0.1
    floor = pymunk.Segment(space.static_body, (-9, -1), (9, -1), 0)
    body = pymunk.Body(1, 1)
    space.add(floor, body, circle(body))
    steps(space, 50)
    assert body.is_sleeping
    return space, body, floor


def test_static_shape_over_a_body_that_sleeps_does_not_wake_it_and_a_kinematic_one_does(asleep):
    space, body, _ = asleep
    space.add(pymunk.Circle(space.static_body, 1, (0.2, 0.5)))
    steps(space, 20)
    assert body.is_sleeping
    guard = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    space.add(guard, circle(guard))
    steps(space, 20)
    assert not body.is_sleeping


def test_floor_that_is_moved_away_leaves_a_body_asleep_and_one_that_is_removed_wakes_it(asleep):
    space, body, floor = asleep
    floor.unsafe_set_endpoints((-9, -5), (9, -5))
    space.reindex_static()
    steps(space, 20)
    assert body.is_sleeping
    space.remove(floor)
    steps(space, 20)
    assert not body.is_sleeping


# Copies, and runs that are repeated


@pytest.mark.parametrize(
    "copied", [pymunk.Space.copy, lambda space: pickle.loads(pickle.dumps(space))]
)
class TestCopies:
    def test_joints_of_a_copy_have_lost_their_impulses(self, copied):
        space = pymunk.Space()
        space.add(*chain(space, 5))
        steps(space, 20)
        assert min(joint.impulse for joint in space.constraints) > 0
        assert {joint.impulse for joint in copied(space).constraints} == {0}

    def test_corners_of_a_box_are_numbered_from_another_one_on(self, copied):
        space, *_ = pair(shape=box, distance=3)
        [before, _], [after, _] = (
            [shape.get_vertices() for shape in each.shapes] for each in (space, copied(space))
        )
        assert set(before) == set(after)
        assert before != after

    def test_contacts_of_boxes_begin_without_their_impulses_and_those_of_balls_with_them(
        self, copied
    ):
        def step_after(shape):
            space = pymunk.Space()
            space.gravity, space.iterations = (0, -10), 1
            for number in range(3):
                body = pymunk.Body(1, 1)
                body.position = 0, number + 0.49 if shape is box else 1.98 * number + 0.99
                space.add(body, shape(body))
            space.add(pymunk.Segment(space.static_body, (-9, 0), (9, 0), 0))
            steps(space, 50)
            both = space, copied(space)
            for each in both:
                each.step(STEP)
            return [[body.velocity.y for body in each.bodies] for each in both]

        original, copy = step_after(circle)
        assert copy == pytest.approx(original, abs=1e-9)
        original, copy = step_after(box)
        assert max(map(abs, original)) < 0.01
        assert min(copy) < -0.05

    def test_pairs_of_a_copy_that_were_switched_off_collide(self, copied):
        space, *_ = pair()
        space.on_collision(begin=switched_off)
        steps(space, 2)
        copy = copied(space)
        steps(space, 10)
        steps(copy, 10)
        assert {body.position.x for body in space.bodies} == {0, 1.8}
        assert {body.position.x for body in copy.bodies} != {0, 1.8}


def switched_off(arbiter, space, data):
    arbiter.process_collision = False


def test_run_in_an_emptied_space_is_not_that_in_a_new_one():
    def positions(space):
        numbers = random.Random(1)
        space.gravity = 0, -10
        space.add(pymunk.Segment(space.static_body, (-9, 0), (9, 0), 0))
        for number in range(30):
            body = pymunk.Body(1, 0.4)
            body.position = numbers.uniform(-1, 1), number + 1
            space.add(body, box(body))
        steps(space, 300)
        return [body.position for body in space.bodies]

    space = pymunk.Space()
    first = positions(space)
    assert positions(pymunk.Space()) == first
    space.remove(*space.shapes, *space.bodies)
    assert positions(space) != first
