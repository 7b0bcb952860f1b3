"""Frames of many shapes: the shapes once, then poses, and the calls of Pymunk's debug drawing."""

from __future__ import annotations

import math
import time

import pymunk
import pytest
from live_sessions import PATIENCE, Listener, Played, decoded, played
from test_sessions_examples import assert_drawn_alike

from pymunk_dragon.sessions.scene import PlaySettings, Scene

CORNERS = [(0, 0), (1, 0), (0.6, 0.7), (0.1, 0.5)]


def shape_on(body, kind):
    """A shape of a kind, which is not symmetrical."""
    if kind == "circle":
        return pymunk.Circle(body, 0.3, (0.1, 0.2))
    if kind == "segment":
        return pymunk.Segment(body, (-0.4, 0), (0.3, 0.2), 0.1)
    return pymunk.Poly(body, CORNERS, radius=0.05)


def crowd(count=60):
    """Shapes of all kinds on bodies of all types, some with two shapes, and springs."""
    space = pymunk.Space()
    space.gravity = 0, -10
    space.sleep_time_threshold = 0.3
    space.add(pymunk.Segment(space.static_body, (-20, 0), (20, 0), 0.2))
    step = pymunk.Body(body_type=pymunk.Body.STATIC)
    step.position = 3, 1
    step.angle = 0.3
    bar = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    bar.position = -3, 4
    bar.angular_velocity = 2
    space.add(step, bar)
    for body in (step, bar):
        space.add(*(shape_on(body, kind) for kind in ("circle", "segment", "polygon")))
    for i in range(count):
        body = pymunk.Body()
        body.position = -8 + 1.6 * (i % 10), 1 + 1.5 * (i // 10)
        body.angle = i
        shape = shape_on(body, ("circle", "segment", "polygon")[i % 3])
        shape.mass = 1
        space.add(body, shape)
        if i % 4 == 0:
            space.add(pymunk.Circle(body, 0.2, (0, 0.4)))
    space.add(pymunk.DampedSpring(space.static_body, body, (0, 9), (0, 0), 1, 20, 1))
    return space


def of_kind(space, kind):
    return next(each for each in space.shapes if isinstance(each, kind) and each.body.mass == 1)


def scene_of(space):
    return Scene(space, PlaySettings(step=1 / 60, units="px"))


@pytest.fixture
def drawn():
    """A scene after 30 steps, which was drawn before."""
    scene = scene_of(crowd())
    for _ in range(30):
        scene.advance()
    assert_drawn_alike(scene, "before")
    return scene


def test_bodies_that_move_turn_and_fall_asleep_are_drawn_as_pymunk_draws_them():
    scene = scene_of(crowd())
    asleep = set()
    for k in range(400):
        scene.advance()
        if k % 8 == 0:
            assert_drawn_alike(scene, k)
            asleep.add(sum(body.is_sleeping for body in scene.space.bodies))
    assert len(asleep) > 2


CHANGES = {
    "radius of a circle": lambda space: of_kind(space, pymunk.Circle).unsafe_set_radius(0.7),
    "centre of a circle": lambda space: of_kind(space, pymunk.Circle).unsafe_set_offset((0.4, 0)),
    "ends of a segment": lambda space: of_kind(space, pymunk.Segment).unsafe_set_endpoints(
        (-1, 0.2), (0.5, 0)
    ),
    "radius of a segment": lambda space: of_kind(space, pymunk.Segment).unsafe_set_radius(0.3),
    "a mirrored polygon": lambda space: of_kind(space, pymunk.Poly).unsafe_set_vertices(
        [(-x, y) for x, y in CORNERS]
    ),
    "a polygon with fewer corners": lambda space: of_kind(space, pymunk.Poly).unsafe_set_vertices(
        CORNERS[:3]
    ),
    "radius of a polygon": lambda space: of_kind(space, pymunk.Poly).unsafe_set_radius(0.2),
    "a colour": lambda space: setattr(of_kind(space, pymunk.Poly), "color", (1, 2, 3, 128)),
    "a kind of body": lambda space: setattr(
        of_kind(space, pymunk.Poly).body, "body_type", pymunk.Body.KINEMATIC
    ),
    "a removed shape": lambda space: space.remove(of_kind(space, pymunk.Circle)),
    "a moved body": lambda space: setattr(of_kind(space, pymunk.Poly).body, "position", (5, 9)),
    "many turns": lambda space: setattr(of_kind(space, pymunk.Poly).body, "angle", 1e7),
    "gravity that wakes": lambda space: setattr(space, "gravity", (0, 10)),
}


@pytest.mark.parametrize("change", CHANGES)
def test_change_is_drawn_at_once_as_pymunk_draws_it(drawn, change):
    CHANGES[change](drawn.space)
    # Pymunk itself draws moving shapes where the last step left them.
    drawn.shapes()
    assert_drawn_alike(drawn, change)
    drawn.advance()
    assert_drawn_alike(drawn, change)


def test_colour_that_is_a_list_may_be_changed_in_place(drawn):
    shape = of_kind(drawn.space, pymunk.Circle)
    shape.color = [10, 20, 30, 255]
    assert_drawn_alike(drawn, "a list")
    shape.color[0] = 200
    assert_drawn_alike(drawn, "another red")


def test_class_of_shapes_may_choose_their_colour(drawn):
    class Hot(pymunk.Circle):
        @property
        def color(self):
            return (min(255, 100 * self.body.position.y), 0, 0, 255)

    body = pymunk.Body(1, 1)
    body.position = 0, 12
    drawn.space.add(body, Hot(body, 0.5))
    for _ in range(20):
        drawn.advance()
        assert_drawn_alike(drawn, "hot")


def test_shapes_that_are_added_and_removed_in_turns_keep_the_order_of_pymunk(drawn):
    space = drawn.space
    for k in range(6):
        body = pymunk.Body(1, 1)
        body.position = k, 10
        space.add(body, *(shape_on(body, kind) for kind in ("polygon", "circle")))
        last = list(space.shapes)[7 * k % len(space.shapes)]
        space.remove(last)
        assert_drawn_alike(drawn, "one less")
        space.add(last)
        assert_drawn_alike(drawn, "added again")
        drawn.advance()


@pytest.mark.parametrize("kind", ["circle", "segment", "polygon"])
def test_static_body_is_drawn_where_it_collides(kind):
    space = pymunk.Space()
    floor = pymunk.Body(body_type=pymunk.Body.STATIC)
    space.add(floor, shape_on(floor, kind))
    scene = scene_of(space)
    assert_drawn_alike(scene, "new")
    for angle in (0.3, -0.3, math.pi):
        floor.angle = angle
        assert_drawn_alike(scene, "moved")
        space.reindex_shapes_for_body(floor)
        assert_drawn_alike(scene, "reindexed")


def test_page_gets_shapes_once_and_again_when_they_change():
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    circle = shape_on(body, "circle")
    space.add(body, circle)
    with played(space) as on:
        got, shapes = [], []

        class Page(Listener):
            def show(self, frame, outlines):
                got.append(outlines)

        on.session.join(Page(on.session, []))
        for radius in (0.9, 0.8):
            on.session.call(lambda radius=radius: circle.unsafe_set_radius(radius))
            on.settle()
            # Pictures that were made before the change are not counted.
            got.clear()
            while len(got) < 3:
                on.step(1)
            assert len(set(got)) == 1
            assert len({*map(id, got)}) == 1
            shapes.append(got[0])
        assert shapes[0] != shapes[1]


class Watcher(Listener):
    """A client that keeps the contacts of the newest frame."""

    def show(self, frame, outlines):
        found = decoded(frame)
        self.newest = found.step, len(found.contacts)


def test_frames_have_contacts_while_a_page_shows_them():
    with played(crowd()) as on:
        [first] = on.session.clients
        second = Watcher(on.session, [])
        second.controls = False
        on.session.join(second)
        found = {}
        for shown in [(True, True), (False, True), (False, False), (True, False)]:
            for page, contacts in zip((first, second), shown, strict=True):
                page.do("show", contacts=contacts)
            on.step(30)
            # The session's thread shows pages the last step in its next round.
            end = time.monotonic() + PATIENCE
            while second.newest[0] < on.scene.steps:
                assert time.monotonic() < end, "no frame of the last step"
                on.settle()
            found[shown] = second.newest[1]
        assert found.pop((False, False)) == 0
        assert all(found.values())


def test_frame_of_bodies_at_rest_is_short():
    scene = scene_of(crowd(300))
    frame = scene.frame({})
    assert len(frame) < len(scene.outlines) / 3


def test_wrong_colour_raises():
    scene = scene_of(crowd(3))
    scene.frame({})
    of_kind(scene.space, pymunk.Poly).color = 5
    for _ in range(2):
        with pytest.raises(TypeError):
            scene.frame({})


def test_dragon_has_no_outlines():
    with played("dragon") as on:
        assert isinstance(on, Played)
        on.step(1)
        assert on.frame().poses.size
        assert on.scene.outlines == b""
