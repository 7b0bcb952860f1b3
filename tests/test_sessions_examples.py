"""Spaces of Pymunk's own examples, which `live` draws as Pymunk's debug drawing draws them."""

from __future__ import annotations

import json
import math
import re
import runpy
import sys
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pymunk
import pytest
from documents import GUIDES
from live_sessions import Listener, drawn_in
from PIL import Image
from test_sessions_input import keep_queries

from pymunk_dragon.sessions import Live
from pymunk_dragon.sessions.scene import PlaySettings, Scene

EXAMPLES = Path(pymunk.__file__).parent / "examples"


class ReachedStepError(BaseException):
    """The example makes its first step: it has built its space."""


class Drawn(pymunk.SpaceDebugDrawOptions):
    """What Pymunk draws: kind, points, radius, angle and colours of each call; contacts apart."""

    def __init__(self):
        super().__init__()
        self.found, self.contacts = [], 0

    def draw_circle(self, pos, angle, radius, outline_color, fill_color):
        self.found.append(("circle", [pos], radius, angle, fill_color, outline_color))

    def draw_fat_segment(self, a, b, radius, outline_color, fill_color):
        self.found.append(("segment", [a, b], radius, 0.0, fill_color, outline_color))

    def draw_polygon(self, verts, radius, outline_color, fill_color):
        self.found.append(("polygon", verts, radius, 0.0, fill_color, outline_color))

    def draw_segment(self, a, b, color):
        if color == self.collision_point_color:
            self.contacts += 1
        else:
            self.found.append(("line", [a, b], 0.0, 0.0, color, None))

    def draw_dot(self, size, pos, color):
        self.found.append(("dot", [pos], size, 0.0, color, None))


@pytest.fixture
def spaces(monkeypatch):
    """Space and step of each example that draws with pygame or not at all, at its first step."""
    pytest.importorskip("pygame", reason="pygame-ce is in the extra test")
    for name in ("SDL_VIDEODRIVER", "SDL_AUDIODRIVER"):
        monkeypatch.setenv(name, "dummy")

    def step(space, dt):
        raise ReachedStepError(space, dt)

    found = {}
    with monkeypatch.context() as patched:
        patched.setattr(pymunk.Space, "step", step)
        patched.syspath_prepend(EXAMPLES)
        patched.chdir(EXAMPLES)
        for path in sorted(EXAMPLES.glob("[!_]*.py")):
            patched.setattr(sys, "argv", [str(path)])
            try:
                runpy.run_path(str(path), run_name="__main__")
            except ReachedStepError as reached:
                found[path.stem] = reached.args
            except (Exception, SystemExit):
                # It needs pyglet, or is imported by others.
                continue
    return found


def single(call):
    """A call, or the parts of a spring, which is one line of several parts."""
    parts = pairwise(call[1]) if call[0] == "line" else [call[1]]
    return [(call[0], part, *call[2:]) for part in parts]


def in_order(calls):
    """Calls of shapes in their order, then those of joints, which all have one colour, in any."""
    shapes = [call for call in calls if call[0] not in ("line", "dot")]
    joints = [call for call in calls if call[0] in ("line", "dot")]
    rounded = [(call[0], np.round(call[1], 3).tolist()) for call in joints]
    return shapes + [joints[i] for i in sorted(range(len(joints)), key=lambda i: rounded[i])]


def assert_drawn_alike(scene, name):
    reference = Drawn()
    scene.space.debug_draw(reference)
    reference.found = in_order(reference.found)
    calls, frame = drawn_in(scene)
    calls = in_order([part for call in calls for part in single(call)])
    contacts = len(frame.contacts)
    assert len(calls) == len(reference.found), name
    for call, expected in zip(calls, reference.found, strict=True):
        assert call[0] == expected[0], name
        np.testing.assert_allclose(call[1], expected[1], rtol=1e-6, atol=1e-6, err_msg=name)
        np.testing.assert_allclose(call[2], expected[2], rtol=1e-6, err_msg=name)
        turned = math.remainder(float(call[3]) - expected[3], math.tau)
        assert abs(turned) < 1e-6, name
        assert [call[4], call[5]] == [
            None if each is None else list(each) for each in expected[4:]
        ], name
    assert contacts == reference.contacts, name
    return len(calls), contacts


def test_page_gets_what_pymunk_draws_of_its_examples_at_the_start_and_after_2_s(spaces):
    assert len(spaces) >= 26
    drawn, contacts = 0, 0
    for name, (space, dt) in spaces.items():
        scene = Scene(space, PlaySettings(step=dt, units="px"))
        assert_drawn_alike(scene, name)
        for _ in range(round(min(2.0, 500 * dt) / dt)):
            scene.advance()
        more, touching = assert_drawn_alike(scene, name)
        drawn, contacts = drawn + more, contacts + touching
    assert drawn > 1000
    assert contacts > 100


def test_page_gets_what_pymunk_draws_of_every_kind_of_joint():
    space = pymunk.Space()
    a, b = pymunk.Body(1, 1), pymunk.Body(1, 1)
    a.position = 30, 40
    b.angle = 1
    space.add(a, b, pymunk.Circle(a, 2), pymunk.Circle(b, 2))
    ends = (b, a, (1, 2), (3, 0))
    b_in_a = a.world_to_local(b.position)
    springs = [
        pymunk.DampedSpring(*ends, 50, 1, 1),
        pymunk.DampedSpring(a, b, b_in_a, (0, 0), 1, 1, 1),
    ]
    turning = [pymunk.DampedRotarySpring(a, b, 0, 1, 1), pymunk.SimpleMotor(a, b, 1)]
    others = [pymunk.SlideJoint(*ends, 1, 99), pymunk.GrooveJoint(a, b, (1, 1), (9, 3), (0, 2))]
    joints = [*springs, *turning, *others, pymunk.PinJoint(*ends), pymunk.PivotJoint(*ends)]
    space.add(*joints)
    # One without a force is drawn, too.
    joints[-1].max_force = 0
    drawn, _ = assert_drawn_alike(Scene(space, PlaySettings(units="px")), "joints")
    assert drawn == 30


def test_spring_in_metres_is_as_wide_as_pymunk_draws_one_of_40_pixels():
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    space.add(body, pymunk.Circle(body, 0.1))
    space.add(pymunk.DampedSpring(space.static_body, body, (0, 2), (0, 0), 1, 1, 1))
    scene = Scene(space, PlaySettings())
    [spring] = [call for call in drawn_in(scene)[0] if call[0] == "line"]
    low, high = spring[1].min(axis=0), spring[1].max(axis=0)
    assert high - low == pytest.approx((12 / 40 * 2, 2))

    # So it is in the picture that a page shows before it plays.
    scene.view = {"centre": [0, 1], "size": [8, 8]}
    with Image.open(BytesIO(scene.picture())) as picture:
        pixels = np.asarray(picture.convert("RGB"))
    columns = np.flatnonzero((pixels == (142, 68, 173)).all(axis=-1).any(axis=0))
    assert np.ptp(columns) < len(pixels) / 8


# The lines that the guide adds to a program whose y points down.
[(IMPORT, ARGUMENTS)] = re.findall(
    r"^(from .* live)\n\nspace = .*\nsession = live\(space, (.*)\)$",
    GUIDES["live"].text,
    re.MULTILINE,
)
STEPS = 40
ROWS = re.findall(
    r"^\| ([\w, ]+) \| `(.+)` \| `(.+)` \| `(.+)` \| `(.+)` \| (up|down) \|$",
    GUIDES["live"].text,
    re.MULTILINE,
)
CHANGED = {name: others for names, *others in ROWS for name in names.split(", ")}


def changed(source, space_line, opening, step_line, steps, direction):
    """Source of an example with the lines of the guide's table, and how many lines changed."""
    lines = ["from __future__ import annotations", IMPORT]
    arguments = ARGUMENTS if direction == "down" else ARGUMENTS.replace("y_down=True, ", "")
    opening = opening.replace("...", arguments)
    count = 1
    for line in source.splitlines():
        indent = line[: len(line) - len(line.lstrip())]
        if line.strip() == space_line and indent + opening not in lines:
            lines += [line, indent + opening]
            count += 1
        elif line.strip().startswith(f"{step_line}("):
            lines.append(f"{indent}{steps}{line[line.index('(') :]}")
            count += 1
        elif not line.startswith("from __future__"):
            lines.append(line)
    return "\n".join(lines), count


@pytest.fixture
def played_example(monkeypatch):
    """A function that plays an example of the guide's table: its scene, and its events.

    The inputs are lists of messages, of which one is sent before each step after the tenth.
    """
    pygame = pytest.importorskip("pygame", reason="pygame-ce is in the extra test")
    for variable in ("SDL_VIDEODRIVER", "SDL_AUDIODRIVER"):
        monkeypatch.setenv(variable, "dummy")
    monkeypatch.setattr("webbrowser.open", lambda address: True)
    # A clock that does not wait.
    monkeypatch.setattr(
        pygame.time, "Clock", lambda: SimpleNamespace(tick=lambda rate=0: 16, get_fps=lambda: 60.0)
    )
    keep_queries(pygame, monkeypatch)
    get, seen = pygame.event.get, []

    def noted(*args, **keywords):
        found = get(*args, **keywords)
        seen.extend(found)
        return found

    monkeypatch.setattr(pygame.event, "get", noted)
    init = Live.__init__
    step = Live.step
    running = []

    def begun(live, session, **options):
        init(live, session, **options)
        running.append(live)
        live.played = session
        session.clock.speed = 20.0

    monkeypatch.setattr(Live, "__init__", begun)

    def play(name, inputs, count=lambda space: len(space.shapes)):
        before = []

        def stepped(live, dt):
            session = live.played
            number = session.scene.steps - 10
            if number == 0:
                before.append(count(session.scene.space))
            for message in inputs[number] if 0 <= number < len(inputs) else ():
                Listener(session, []).take(json.dumps(message))
            step(live, dt)
            if session.scene.steps >= STEPS:
                raise ReachedStepError

        monkeypatch.setattr(Live, "step", stepped)
        monkeypatch.chdir(EXAMPLES)
        monkeypatch.syspath_prepend(EXAMPLES)
        monkeypatch.setattr(sys, "argv", [name, "/i"])
        path = EXAMPLES / f"{name}.py"
        source, changes = changed(path.read_text(), *CHANGED[name])
        assert changes <= 5
        with pytest.raises(ReachedStepError):
            exec(compile(source, name, "exec"), {"__name__": "__main__", "__file__": str(path)})
        scene = running[-1].played.scene
        return scene, seen, count(scene.space) - before[0]

    yield play
    for live in running:
        live.stop()


def key(name, down=True):
    return {"do": "press", "name": name, "down": down}


def click(x, y, button=1, to=None):
    """Messages of a button that goes down at a point of the page, and up at another."""
    down = {"do": "pointer", "x": x, "y": y, "kind": "down", "button": button}
    goal = to or (x, y)
    return [down | {"kind": "move"}, down, down | {"kind": "up", "x": goal[0], "y": goal[1]}]


@pytest.mark.thorough
@pytest.mark.parametrize("name", CHANGED)
def test_example_of_pymunk_plays_with_keys_and_mouse_after_five_changed_lines_at_most(
    name, played_example
):
    pygame = pytest.importorskip("pygame", reason="pygame-ce is in the extra test")
    inputs = [
        key("ArrowLeft"),
        *click(120.0, 130.0, to=(125.0, 130.0)),
        {"do": "wheel", "right": 0.0, "up": 1.0},
    ]
    scene, seen, _ = played_example(name, [inputs])
    assert_drawn_alike(scene, name)
    kinds = {pygame.event.event_name(event.type) for event in seen}
    assert {"KeyDown", "MouseButtonDown", "MouseButtonUp", "MouseMotion", "MouseWheel"} <= kinds
    [down] = [event for event in seen if event.type == pygame.MOUSEBUTTONDOWN and event.button == 1]
    height = scene.view["size"][1]
    assert down.pos == (120, 130 if CHANGED[name][-1] == "down" else height - 130)
    assert scene.steps == STEPS


def lines(space):
    return [shape for shape in space.shapes if isinstance(shape, pymunk.Segment)]


def angles(space):
    return [body.angle for body in space.bodies if body.body_type != pymunk.Body.DYNAMIC]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "inputs", "count"),
    [
        (
            "balls_and_lines",
            [click(300.0, 300.0, 3, to=(400.0, 320.0))],
            lambda space: len(lines(space)),
        ),
        (
            "collisions",
            [click(300.0, 300.0, 3)],
            lambda space: round(sum(angles(space)) / (math.pi / 8)),
        ),
        (
            "playground",
            [
                [key("Control")],
                click(100.0, 300.0, 3),
                click(200.0, 350.0, 3),
                [key("Control", False)],
            ],
            lambda space: len(lines(space)),
        ),
    ],
)
def test_right_button_does_in_examples_of_pymunk_what_it_does_there(
    name, inputs, count, played_example
):
    _, _, difference = played_example(name, inputs, count)
    assert difference == 1


def test_the_documentation_has_22_examples_of_pymunk():
    assert len(CHANGED) == 22
