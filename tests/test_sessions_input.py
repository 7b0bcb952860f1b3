"""What a user of the page sees first, takes in hand and presses."""

from __future__ import annotations

import math

import numpy as np
import pymunk
import pytest
from conftest import assert_says
from live_sessions import Listener, drawn_in, played
from PIL import Image

from pymunk_dragon import Key, ParameterError, PillowDrawOptions, PygameEvents
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.sessions.scene import PlaySettings, Scene
from pymunk_dragon.sessions.scenes import march_scene, space_scene


def ball(space, place, radius=0.5, **about):
    """A body of 1 kg with a circle; `about` has attributes of the circle."""
    body = pymunk.Body(1, 1)
    body.position = place
    shape = pymunk.Circle(body, radius)
    for name, value in about.items():
        setattr(shape, name, value)
    space.add(body, shape)
    return body


# ---- the picture shows the space as it is


def moved(kind):
    """A space with a shape of 2 x 2 at (100, 50), whose body was moved or turned afterwards."""
    space = pymunk.Space()
    body = pymunk.Body(
        1, 1, body_type=pymunk.Body.KINEMATIC if kind == "kinematic" else pymunk.Body.DYNAMIC
    )
    shapes = {
        "circle": pymunk.Circle(body, 1),
        "box": pymunk.Poly.create_box(body, (2, 2)),
        "kinematic": pymunk.Poly.create_box(body, (1, 1), 0.5),
        "turned": pymunk.Poly.create_box(body, (math.sqrt(2), math.sqrt(2))),
        "segment": pymunk.Segment(body, (0, -0.5), (0, 0.5), 0.5),
    }
    space.add(body, shapes[kind])
    body.position = 100, 50
    body.angle = {"turned": math.pi / 4}.get(kind, 0.0)
    return space


@pytest.mark.parametrize("kind", ["circle", "box", "kinematic", "turned", "segment"])
def test_first_view_shows_bodies_that_were_moved_after_their_shapes_were_added(kind):
    assert Scene(moved(kind), PlaySettings()).view == {
        "centre": pytest.approx([100, 50]),
        "size": pytest.approx([1 if kind == "segment" else 2, 2]),
    }
    options = PillowDrawOptions(Image.new("RGB", (100, 100), "white"), positive_y_is_up=True)
    space = moved(kind)
    options.fit(space, margin=10)
    assert options.transform @ (100, 50) == pytest.approx((50, 50))
    assert options.transform @ (100, 51) == pytest.approx((50, 90))
    space.debug_draw(options)
    assert options.image.getpixel((50, 50)) != (255, 255, 255)


def test_body_that_is_moved_while_the_session_is_paused_is_drawn_and_taken_where_it_is():
    space = pymunk.Space()
    body = ball(space, (0, 0))
    with played(space) as on:
        on.step(3)
        on.session.call(lambda: setattr(body, "position", (7, -3)))
        on.settle()
        [(kind, points, radius, *_)], _ = drawn_in(on.scene)
        assert (kind, radius) == ("circle", 0.5)
        assert points == pytest.approx(np.array([[7, -3]]))
        assert on.do("grab", x=7.2, y=-3.0, slip=0.0) is None
        assert on.frame().held == pytest.approx([7.2, -3, 7.2, -3])


def test_static_body_that_is_moved_is_drawn_where_it_collides_until_it_is_reindexed():
    space = pymunk.Space()
    space.gravity = 0, -10
    floor = pymunk.Body(body_type=pymunk.Body.STATIC)
    space.add(floor, pymunk.Segment(floor, (-5, 0), (5, 0), 0.1))
    floor.position = 0, -3
    body = ball(space, (0, 2))
    scene = Scene(space, PlaySettings())
    for bottom in (-0.1, -3.1):
        scene.fit()
        assert scene.view["centre"][1] - scene.view["size"][1] / 2 == pytest.approx(bottom)
        for _ in range(300):
            scene.advance()
        assert body.position.y == pytest.approx(bottom + 0.7, abs=0.1)
        space.reindex_shapes_for_body(floor)


def crowd():
    """Sleeping boxes, a heap, a kinematic bar, a static step that was moved, and a chain."""
    space = pymunk.Space()
    space.gravity, space.sleep_time_threshold = (0, -10), 0.3
    ground = pymunk.Segment(space.static_body, (-9, 0), (9, 0), 0.1)
    step = pymunk.Body(body_type=pymunk.Body.STATIC)
    bar = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    bar.position, bar.angular_velocity = (0, 4), 1
    space.add(
        ground,
        step,
        pymunk.Poly.create_box(step, (1, 1)),
        bar,
        pymunk.Segment(bar, (-2, 0), (2, 0), 0.1),
    )
    step.position = 3, 0.3
    for i in range(5):
        body = pymunk.Body(1, 0.1)
        body.position = 4.5 + 0.8 * i, 0.4
        space.add(body, pymunk.Poly.create_box(body, (0.5, 0.5)))
    before = space.static_body
    for i in range(30):
        body = ball(
            space, (0.7 * (i % 7) - 2, 1 + 0.9 * (i // 7)), 0.2 + 0.02 * (i % 5), friction=0.5
        )
        space.add(box := pymunk.Poly.create_box(body, (0.5, 0.3), 0.02))
        box.friction = 0.4
        if i % 6 == 0:
            space.add(pymunk.PivotJoint(before, body, body.position))
            before = body
    return space


def portal(space, time):
    """Move bodies without a step: each tenth step one to the top, and turned."""
    if round(60 * time) % 10 == 9:
        body = list(space.bodies)[6 + round(60 * time) % 29]
        body.position, body.angle = (0.01 * time, 7.0), 1.0


def test_run_that_is_watched_equals_one_that_is_not_to_the_bit():
    ends, sleepers = [], set()
    for watched in (False, True):
        scene = Scene(crowd(), PlaySettings(on_step=portal))
        for _ in range(400):
            sleepers |= {body for body in scene.space.bodies if body.is_sleeping}
            if watched:
                scene.fit()
                scene.frame({})
                with pytest.raises(ParameterError):
                    scene.grab(1e5, 1e5, 0.0)
            scene.advance()
        ends.append(scene.poses())
    assert len(sleepers) > 4
    assert (ends[0] == ends[1]).all()


# ---- the hand


def grabbed(scene, x, y, slip=0.1):
    """The joint with which the hand holds the body that it takes at a point."""
    before = set(scene.space.constraints)
    scene.grab(x, y, slip)
    [joint] = set(scene.space.constraints) - before
    return joint


def taken(space, x, y):
    """The body that the hand takes at a point, or None."""
    try:
        return grabbed(Scene(space, PlaySettings()), x, y).b
    except ValueError as error:
        assert_says(error, "body")
        return None


def test_hand_takes_the_ball_inside_a_sensor_and_none_on_empty_ground_inside_it():
    for guard_first in (True, False):
        space = pymunk.Space()
        bodies = [ball(space, (0, 0)), ball(space, (2, 0))][:: 1 if guard_first else -1]
        guard, inside = bodies
        zone = pymunk.Circle(guard, 3)
        zone.sensor = True
        space.add(zone)
        assert taken(space, *inside.position) is inside
        assert taken(space, *guard.position) is guard
        assert taken(space, 1, 1.5) is None
        assert taken(space, 1, -2.9) is None


def test_body_that_has_only_sensors_is_taken_where_no_other_is():
    space = pymunk.Space()
    inside = ball(space, (0, 0))
    ghosts = [ball(space, (0, 0), 2.0, sensor=True) for _ in range(5)]
    assert taken(space, 0.3, 0) is inside
    assert taken(space, 0.3, 1.5) in ghosts


def test_hand_takes_the_shape_that_is_drawn_last_and_outside_of_all_the_nearest():
    rng = np.random.default_rng(3)
    space = pymunk.Space()
    for i in range(40):
        body = pymunk.Body(1, 1)
        body.position, body.angle = rng.uniform(-2, 2, 2).tolist(), i
        space.add(
            body,
            pymunk.Poly.create_box(body, (0.7, 0.4), 0.05) if i % 2 else pymunk.Circle(body, 0.3),
        )
    found = set()
    for x, y in rng.uniform(-2.2, 2.2, (80, 2)):
        # Chipmunk's order of drawing, and a picture with a colour for each shape.
        image = Image.new("RGB", (3, 3), "white")
        options = PillowDrawOptions(image)
        options.transform = pymunk.Transform(1e3, 0, 0, 1e3, 1.5 - 1e3 * x, 1.5 - 1e3 * y)
        for number, shape in enumerate(space.shapes, 1):
            shape.color = (number, 0, 0, 255)
        options.shape_outline_color = options.shape_outline_color._replace(a=0)
        space.debug_draw(options)
        red, green, _ = image.getpixel((1, 1))
        expected = None if green else list(space.shapes)[red - 1].body
        if expected is None:
            near = [(shape.point_query((x, y)).distance, shape.body) for shape in space.shapes]
            distance, expected = min(near, key=lambda each: each[0])
            expected = expected if distance < 0.1 else None
        got = taken(space, x, y)
        assert got is expected, (x, y)
        found.add(got)
    assert len(found) > 20


@pytest.mark.parametrize("filtered", [{"mask": 0}, {"categories": 0}, {"group": 1}])
def test_hand_takes_bodies_that_touch_nothing(filtered):
    space = pymunk.Space()
    body = ball(space, (0, 0), filter=pymunk.ShapeFilter(**filtered))
    assert taken(space, 0.2, 0) is body


@pytest.mark.parametrize("radius", [0.0, 0.25])
def test_hand_takes_a_box_at_its_edge_where_the_click_was(radius):
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    space.add(body, pymunk.Poly.create_box(body, (2, 2), radius))
    for place in ((1.0, 0.5), (-0.5, 1.0), (1.0, 1.0), (1.0 + radius, 0.0)):
        scene = Scene(space, PlaySettings())
        assert grabbed(scene, *place).anchor_b == pytest.approx(place)
        scene.drop()


def test_where_two_benches_overlap_the_hand_takes_the_one_that_the_page_points_at():
    with played(march_scene(March(Dragon(benches=8), turns=3))) as on:
        world = on.scene.world
        for i in range(7):
            pivot = world.pivots[i]
            x, y = pivot.b.local_to_world(pivot.anchor_b)
            before = set(on.scene.space.constraints)
            assert on.do("grab", x=x, y=y, slip=0.0) is None
            [joint] = set(on.scene.space.constraints) - before
            assert joint.b is world.bodies[i]
            assert on.do("drop") is None


# ---- what a client holds is released when it leaves


class Clients:
    """Clients of a session by name, which are told nothing."""

    def __init__(self, session):
        self.session = session
        self.known = {}

    def send(self, client_name, action, /, **arguments):
        client = self.known.setdefault(client_name, Listener(self.session, []))
        client.do(action, **arguments)

    def leave(self, name):
        self.session.leave(self.known[name])


def test_key_is_released_when_the_last_client_that_holds_it_releases_it_or_leaves():
    told = []

    def noted(name):
        return Key(name, lambda space: told.append(name), lambda space: told.append(f"{name} up"))

    keys = [noted("a"), noted("b")]
    with played(space_scene(pymunk.Space, PlaySettings(controls=keys))) as on:
        clients = Clients(on.session)
        for name in ("one", "two"):
            clients.send(name, "press", name="a", down=True)
        clients.send("one", "press", name="b", down=True)
        on.settle()
        clients.send("one", "press", name="a", down=False)
        on.settle()
        assert told == ["a", "a", "b"]
        clients.leave("one")
        on.settle()
        assert told == ["a", "a", "b", "b up"]
        clients.leave("two")
        on.settle()
        assert told == ["a", "a", "b", "b up", "a up"]
        clients.send("three", "press", name="a", down=True)
        clients.send("three", "press", name="a", down=False)
        clients.leave("three")
        on.settle()
        assert told[5:] == ["a", "a up"]


def test_hand_of_a_client_that_leaves_is_dropped_unless_another_has_taken_it_over():
    space = pymunk.Space()
    ball(space, (0, 0))
    with played(space) as on:
        clients = Clients(on.session)
        clients.send("one", "grab", x=0.0, y=0.0, slip=0.1)
        clients.leave("one")
        assert on.frame().held is None
        for name in ("one", "two"):
            clients.send(name, "grab", x=0.0, y=0.0, slip=0.1)
        clients.leave("one")
        assert on.frame().held is not None
        clients.leave("two")
        assert on.frame().held is None


def test_release_by_a_client_that_leaves_is_an_input_of_the_recording():
    with played("pendulum") as on:
        x, y, _ = on.scene.poses()[0].tolist()
        clients = Clients(on.session)
        clients.send("one", "grab", x=x, y=y, slip=0.1)
        on.step(5)
        clients.leave("one")
        on.settle()
        assert [message["do"] for _, message in on.session.log()["inputs"]] == ["grab", "drop"]


# ---- pygame


def keep_queries(pygame, monkeypatch):
    """Have pygame's own functions back after the test: `PygameEvents` replaces them."""
    replaced = {
        pygame.key: ("get_pressed", "get_mods"),
        pygame.mouse: ("get_pos", "get_rel", "get_pressed"),
    }
    for module, queries in replaced.items():
        for query in queries:
            monkeypatch.setattr(module, query, getattr(module, query))


@pytest.fixture
def pygame(monkeypatch):
    """The library without a window, and with its own functions again afterwards."""
    found = pytest.importorskip("pygame", reason="pygame-ce is in the extra test")
    for name in ("SDL_VIDEODRIVER", "SDL_AUDIODRIVER"):
        monkeypatch.setenv(name, "dummy")
    keep_queries(found, monkeypatch)
    found.quit()
    yield found
    found.quit()


@pytest.fixture
def window(pygame):
    """The library with a window."""
    pygame.init()
    pygame.display.set_mode((300, 200))
    pygame.event.clear()
    return pygame


def told_to(pygame, clients, on, messages):
    """Events of pygame after a client's messages: names of their types, and the events."""
    for action, arguments in messages:
        clients.send("page", action, **arguments)
    on.settle()
    return [(pygame.event.event_name(event.type), event) for event in pygame.event.get()]


def pointer(x, y, kind, button=1):
    return "pointer", {"x": x, "y": y, "kind": kind, "button": button}


def steered():
    """A session of a pygame program whose y points down."""
    return played(space_scene(pymunk.Space, PlaySettings(controls=[PygameEvents()], y_down=True)))


def test_all_buttons_of_the_mouse_reach_a_pygame_program(window):
    with steered() as on:
        clients = Clients(on.session)
        events = told_to(window, clients, on, [pointer(20.0, 30.0, "move")])
        assert [(name, event.pos, event.buttons) for name, event in events] == [
            ("MouseMotion", (20, 30), (0, 0, 0))
        ]
        for button in (1, 2, 3):
            [(name, event)] = told_to(window, clients, on, [pointer(20.0, 30.0, "down", button)])
            assert (name, event.button, event.pos) == ("MouseButtonDown", button, (20, 30))
        assert window.mouse.get_pressed() == (True, True, True)
        [(name, event)] = told_to(window, clients, on, [pointer(20.0, 30.0, "up", 2)])
        assert (name, event.button) == ("MouseButtonUp", 2)
        assert window.mouse.get_pressed(num_buttons=5) == (True, False, True, False, False)
        [(name, event)] = told_to(window, clients, on, [pointer(25.0, 28.0, "move")])
        assert (name, event.buttons, event.rel) == ("MouseMotion", (1, 0, 1), (5, -2))
        assert window.mouse.get_rel() == (25, 28)
        assert window.mouse.get_rel() == (0, 0)
        # The pointer moves before a button goes down elsewhere, as on a touch screen.
        names = [name for name, _ in told_to(window, clients, on, [pointer(90.0, 90.0, "down", 2)])]
        assert names == ["MouseMotion", "MouseButtonDown"]
        clients.leave("page")
        on.settle()
        left = [
            (event.button, event.pos)
            for event in window.event.get()
            if event.type == window.MOUSEBUTTONUP
        ]
        assert sorted(left) == [(1, (90, 90)), (2, (90, 90)), (3, (90, 90))]
        assert window.mouse.get_pressed() == (False, False, False)
        for button in (0, 4):
            assert_says(
                ValueError(on.do("pointer", x=0.0, y=0.0, kind="down", button=button)), "button"
            )


def test_wheel_reaches_a_pygame_program_as_wheel_and_as_buttons_4_and_5(window):
    with steered() as on:
        clients = Clients(on.session)

        def turned(right, up):
            found = told_to(window, clients, on, [("wheel", {"right": right, "up": up})])
            return [
                (name, event.button if "Button" in name else (event.x, event.y))
                for name, event in found
            ]

        away = [("MouseButtonDown", 4), ("MouseButtonUp", 4)]
        near = [("MouseButtonDown", 5), ("MouseButtonUp", 5)]
        assert turned(0.0, 1.0) == [*away, ("MouseWheel", (0, 1))]
        assert turned(0.0, -2.0) == [*near, *near, ("MouseWheel", (0, -2))]
        assert turned(1.0, 0.0) == [("MouseWheel", (1, 0))]
        # A touchpad turns it by parts.
        assert [len(turned(0.0, 0.4)) for _ in range(5)] == [0, 0, 3, 0, 3]
        assert_says(ValueError(on.do("wheel", right=0.0, up=1e5)), "up")


def test_keys_have_the_codes_and_modifiers_of_pygame(window):
    names = {
        "ArrowLeft": "K_LEFT",
        "Enter": "K_RETURN",
        " ": "K_SPACE",
        "a": "K_a",
        "A": "K_a",
        "!": "K_EXCLAIM",
    }
    names |= {
        "Escape": "K_ESCAPE",
        "PageUp": "K_PAGEUP",
        "F5": "K_F5",
        "Delete": "K_DELETE",
        "Meta": "K_LMETA",
    }
    with steered() as on:
        clients = Clients(on.session)
        for name, code in names.items():
            for down in (True, False):
                [(kind, event)] = told_to(
                    window, clients, on, [("press", {"name": name, "down": down})]
                )
                assert (kind, event.key) == (
                    "KeyDown" if down else "KeyUp",
                    getattr(window, code),
                ), name
                assert window.key.get_pressed()[event.key] == down
        for name, mod in (("Shift", "KMOD_SHIFT"), ("Control", "KMOD_CTRL"), ("Alt", "KMOD_ALT")):
            told_to(window, clients, on, [("press", {"name": name, "down": True})])
            assert window.key.get_mods() & getattr(window, mod), name
        [(_, event)] = told_to(window, clients, on, [("press", {"name": "x", "down": True})])
        assert (event.mod & window.KMOD_SHIFT, event.unicode) == (window.KMOD_LSHIFT, "x")
        # Keys that pygame does not have are no errors.
        assert (
            told_to(window, clients, on, [("press", {"name": "Unidentified", "down": True})]) == []
        )
        clients.leave("page")
        on.settle()
        assert window.key.get_mods() == 0
        assert not window.key.get_pressed()[window.K_x]
        assert on.errors == []


def test_program_without_a_window_has_the_state_of_keys_and_mouse_and_is_not_paused(pygame):
    with steered() as on:
        on.do("play")
        for action, arguments in (
            ("press", {"name": "ArrowLeft", "down": True}),
            ("press", {"name": "Shift", "down": True}),
            pointer(3.0, 4.0, "down", 3),
            ("wheel", {"right": 0.0, "up": 1.0}),
        ):
            assert on.do(action, **arguments) is None
        assert pygame.key.get_pressed()[pygame.K_LEFT]
        assert pygame.key.get_mods() & pygame.KMOD_SHIFT
        assert (pygame.mouse.get_pos(), pygame.mouse.get_pressed()) == (
            (3, 4),
            (False, False, True),
        )
        assert on.session.clock.running
        assert on.errors == []


def test_program_that_reads_no_events_is_not_paused_when_pygames_queue_is_full(window):
    with steered() as on:
        try:
            while True:
                window.event.post(window.event.Event(window.USEREVENT))
        except window.error:
            pass
        assert on.do("press", name="x", down=True) is None
        assert window.key.get_pressed()[window.K_x]
        assert on.errors == []
