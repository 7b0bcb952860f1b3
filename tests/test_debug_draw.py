"""Debug drawing of spaces that no dragon is in."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pymunk
import pytest
import shapely
from conftest import refusal
from numpy.typing import NDArray
from PIL import Image
from pymunk import BB, SpaceDebugDrawOptions, Transform, Vec2d

from pymunk_dragon import PillowDrawOptions
from pymunk_dragon.drawing.debug_draw import DrawRecorder

BLACK, RED = (0, 0, 0, 255), (255, 0, 0, 255)
DYNAMIC = (52, 152, 219)
OUTLINE, CONSTRAINT, COLLISION = (44, 62, 80), (142, 68, 173), (231, 76, 60)


def white(width: int = 64, height: int = 64) -> Image.Image:
    return Image.new("RGB", (width, height), "white")


def coverage(image: Image.Image) -> NDArray[np.float64]:
    """How much of every pixel is black on white."""
    return 1 - np.asarray(image, dtype=float)[..., 0] / 255


def has(image: Image.Image, colour: tuple[int, ...]) -> bool:
    return bool((np.asarray(image)[..., :3] == colour[:3]).all(axis=-1).any())


def drawn(space: pymunk.Space, image: Image.Image | None = None, **settings: Any) -> Image.Image:
    """Picture of a space; settings of the constructor and attributes as keywords."""
    image = image or white()
    made = {name: settings.pop(name) for name in ("positive_y_is_up", "line_width") if name in settings}
    options = PillowDrawOptions(image, **made)
    for name, value in settings.items():
        setattr(options, name, value)
    space.debug_draw(options)
    return image


def painted(name: str, *arguments: Any, image: Image.Image | None = None, line_width: float = 1) -> Image.Image:
    """Picture of one call of a drawing method."""
    image = image or white()
    options = PillowDrawOptions(image, line_width=line_width)
    with options:
        getattr(options, name)(*arguments)
    return image


def with_body(make: Callable[[pymunk.Body], pymunk.Shape], position: Any = (0, 0), angle: float = 0.0) -> pymunk.Space:
    """A space with one body, and on it the shape that is made for it."""
    body = pymunk.Body(1, 1)
    body.position, body.angle = position, angle
    space = pymunk.Space()
    space.add(body, make(body))
    return space


def ball(x: float, y: float, radius: float, angle: float = 0.0) -> pymunk.Space:
    return with_body(lambda body: pymunk.Circle(body, radius), (x, y), angle)


def box(x: float, y: float, size: tuple[float, float], radius: float = 0.0, angle: float = 0.0) -> pymunk.Space:
    return with_body(lambda body: pymunk.Poly.create_box(body, size, radius), (x, y), angle)


def cradle() -> pymunk.Space:
    """Newton's cradle with the last ball drawn aside; the balls that hang touch."""
    space = pymunk.Space()
    for i in range(5):
        body = pymunk.Body()
        swing = 0.6 if i == 4 else 0.0
        body.position = i + 4 * math.sin(swing), -4 * math.cos(swing)
        circle = pymunk.Circle(body, 0.501)
        circle.mass = 1
        space.add(body, circle, pymunk.PinJoint(space.static_body, body, (i, 0)))
    space.step(1e-6)
    return space


def kinds_of_body() -> pymunk.Space:
    """Static, kinematic, moving, sleeping, and one of a colour of its own that can be seen through."""
    space = pymunk.Space()
    space.sleep_time_threshold = 1e-3
    floor = pymunk.Segment(space.static_body, (0, 10), (250, 10), 4)
    moving, sleeping, own = (pymunk.Body(1, 1) for _ in range(3))
    lift = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    for i, body in enumerate((lift, moving, sleeping, own)):
        body.position = 40 + 60 * i, 45
        body.angle = 0.4 * i
        space.add(body)
    translucent = pymunk.Circle(own, 24)
    translucent.color = (*RED[:3], 100)
    space.add(floor, pymunk.Poly.create_box(lift, (40, 30), 4), pymunk.Circle(moving, 20), translucent)
    space.add(
        pymunk.Poly(sleeping, [(-20, -15), (20, -15), (0, 20)], radius=3), pymunk.Segment(own, (-45, 0), (45, 0), 8)
    )
    sleeping.sleep()
    return space


def test_each_pixel_is_covered_as_far_as_the_shape_reaches_into_it() -> None:
    random = np.random.default_rng(7)
    x, y = np.meshgrid(np.arange(48), np.arange(48))
    for number in range(24):
        at = [Vec2d(*point) for point in random.uniform(14, 34, (5, 2)).tolist()]
        radius = float(random.uniform(1.5, 9))
        if number % 3 == 0:
            name, arguments, area = "draw_circle", (at[0], 0.3, radius), shapely.Point(at[0]).buffer(radius, 64)
        elif number % 3 == 1:
            area = shapely.LineString(at[:2]).buffer(radius, 64)
            name, arguments = "draw_fat_segment", (*at[:2], radius)
        else:
            radius = 0.0 if number % 2 else radius
            # With corners on the straight, which rounding errors turn one way or the other.
            hull = shapely.segmentize(shapely.MultiPoint(at).convex_hull, 5)
            corners = [Vec2d(*corner) for corner in hull.exterior.coords[:-1]]
            name, arguments, area = "draw_polygon", (corners, radius), hull.buffer(radius, 64)
        image = painted(name, *arguments, BLACK, BLACK, image=white(48, 48))
        truth = shapely.area(shapely.intersection(shapely.box(x, y, x + 1, y + 1), area))
        error = np.abs(coverage(image) - truth)
        assert error.max() < 0.6, (name, number)  # a corner may be off by half of a drawn pixel, either way
        assert error.mean() < 0.02, (name, number)
        # More than that all around would be seen as fat or thin.
        assert abs(coverage(image).sum() - truth.sum()) < 0.15 * area.length, (name, number)


def test_line_in_a_circle_points_where_the_body_does() -> None:
    x, y = np.meshgrid(np.arange(64) - 31.5, np.arange(64) - 31.5)
    flip = Transform(1, 0, 0, -1, 0, 0)
    matrices = [Transform.identity(), flip, Transform.rotation(0.5), Transform(0, 1, 1, 0, 0, 0)]
    for matrix in [*matrices, Transform.rotation(2.0) @ flip, Transform(1, 0, 0.8, 1, 0, 0)]:
        for angle in (0.0, 0.7, 2.5, -1.3):
            moved = Transform.translation(32, 32) @ matrix
            image = drawn(ball(0, 0, 20, angle), transform=moved, shape_outline_color=BLACK, shape_dynamic_color=RED)
            # What is black in the red disc, but for its rim.
            weight = (255 - np.asarray(image, dtype=float)[..., 0]) * (np.hypot(x, y) < 17)
            found = Vec2d((weight * x).sum(), (weight * y).sum()).normalized()
            assert found == pytest.approx((matrix @ Vec2d(1, 0).rotated(angle)).normalized(), abs=0.1), (matrix, angle)


def test_transforms_move_and_turn_the_picture() -> None:
    space = box(20, 22, (21, 13), 3, 0.4)
    stays = np.asarray(drawn(space), dtype=float)
    moved = np.asarray(drawn(space, transform=Transform.translation(17, 9)))
    np.testing.assert_array_equal(moved[9:, 17:], stays[:-9, :-17])
    turned = np.asarray(drawn(space, transform=Transform(0, 1, -1, 0, 64, 0)), dtype=float)
    assert np.abs(turned - np.rot90(stays, -1)).mean() < 1
    up = np.asarray(drawn(space, positive_y_is_up=True), dtype=float)
    assert np.abs(up[::-1] - stays).mean() < 0.6


def test_fit_shows_all_of_a_space_as_large_as_it_can() -> None:
    space = box(1003.0, -7.5, (0.06, 0.03))
    for size, up in (((200, 100), False), ((80, 160), True)):
        image = white(*size)
        options = PillowDrawOptions(image, positive_y_is_up=up)
        options.fit(space, margin=15)
        space.debug_draw(options)
        rows, columns = (np.flatnonzero((np.asarray(image) < 255).any(axis=(axis, 2))) for axis in (1, 0))
        left, top, right, bottom = columns[0], rows[0], columns[-1] + 1, rows[-1] + 1
        assert min(left, top) == pytest.approx(15, abs=1.01)
        assert (left + right, top + bottom) == pytest.approx(size, abs=1.01)
        assert (right - left) / (bottom - top) == pytest.approx(2, rel=0.05)
    options = PillowDrawOptions(white(120, 80))
    options.fit(BB(left=1, bottom=2, right=3, top=4), margin=0)
    assert options.transform == Transform(40, 0, 0, 40, -20, -80)
    options = PillowDrawOptions(white(120, 120), positive_y_is_up=True)
    options.fit(cradle())
    # The anchors of the constraints are in the picture too.
    x, y = options.transform @ (0, 0)
    assert 9 <= x <= 111
    assert 9 <= y <= 111


def test_flags_say_what_is_drawn() -> None:
    for name, colour in (("SHAPES", OUTLINE), ("CONSTRAINTS", CONSTRAINT), ("COLLISION_POINTS", COLLISION)):
        options = PillowDrawOptions(white(300, 240), positive_y_is_up=True, line_width=2)
        options.fit(cradle(), margin=20)
        options.flags = getattr(SpaceDebugDrawOptions, f"DRAW_{name}")
        cradle().debug_draw(options)
        assert [other for other in (OUTLINE, CONSTRAINT, COLLISION) if has(options.image, other)] == [colour]


def test_alpha_lets_the_background_through() -> None:
    for alpha in (0, 1, 100, 255):
        image = Image.new("RGB", (64, 64), (30, 40, 250))
        painted("draw_circle", Vec2d(32, 32), 0, 20, (*RED[:3], 0), (10, 200, 90, alpha), image=image)
        mixed = (np.array([10, 200, 90]) * alpha + np.array([30, 40, 250]) * (255 - alpha)) / 255
        assert np.abs(np.array(image.getpixel((32, 40))) - mixed).max() <= 1, alpha


def test_bad_images_line_widths_and_areas_are_refused() -> None:
    options = PillowDrawOptions(white())
    cases: list[tuple[str, Callable[[Any], Any], list[Any]]] = [
        ("area", options.fit, [pymunk.Space(), BB(1, 1, 1, 1)]),
        ("margin", lambda margin: options.fit(cradle(), margin), [32]),
        ("image", PillowDrawOptions, [None, "image.png", np.zeros((4, 4, 3))]),
        ("image.mode", lambda mode: PillowDrawOptions(Image.new(mode, (4, 4))), ["L", "P", "CMYK", "RGBA"]),
        ("line_width", lambda width: PillowDrawOptions(white(), line_width=width), [0, -1, math.nan, 101, "1"]),
    ]
    for name, call, values in cases:
        for value in values:
            assert refusal(call, value).name == name, value


def test_what_is_out_of_sight_or_nowhere_changes_nothing() -> None:
    image = white()
    options = PillowDrawOptions(image)
    places = [(-1e3, 0), (1e5, 1e5), (32, 1e11), (math.nan, 3), (3, math.inf), (1e300, 0), (-1e13, 3)]
    with options:
        for place, radius in [*((place, 3.0) for place in places), *(((-30, 32), r) for r in (math.nan, math.inf, -3))]:
            a = Vec2d(*place)
            options.draw_circle(a, 0.3, radius, BLACK, RED)
            options.draw_fat_segment(a, a + Vec2d(5, 5), radius, BLACK, RED)
            options.draw_polygon([a, a + Vec2d(5, 5), a + Vec2d(0, 7)], radius, BLACK, RED)
            options.draw_segment(a, a + Vec2d(5, 5), BLACK)
            options.draw_dot(radius, a, BLACK)
    for nowhere in (Transform.translation(1e6, 0), Transform(math.nan, 0, 0, 1, 0, 0), Transform.scaling(1e300)):
        drawn(kinds_of_body(), image, transform=Transform.translation(9, 9) @ nowhere)
    assert image.tobytes() == white().tobytes()


def test_shapes_far_larger_than_the_picture_are_drawn() -> None:
    slope = Vec2d(math.cos(0.4), math.sin(0.4))
    planet = painted("draw_circle", Vec2d(200, 200) - slope * 1e5, 2, 1e5, RED, BLACK, image=white(400, 400))
    x, y = np.meshgrid(np.arange(400) - 199.5, np.arange(400) - 199.5)
    assert np.mean((np.asarray(planet)[..., 1] < 128) != (x * slope.x + y * slope.y < 0)) < 0.004
    far = [Vec2d(-1e7, -1e7), Vec2d(1e7, -1e7), Vec2d(0, 2e7)]
    for radius in (0, 5e6):
        assert (np.asarray(painted("draw_polygon", far, radius, BLACK, RED)) == RED[:3]).all()


def test_wrong_colour_of_a_shape_is_raised_and_the_options_can_be_used_again(capfd: pytest.CaptureFixture[str]) -> None:
    options = PillowDrawOptions(white())
    space = ball(32, 32, 10)
    (circle,) = space.shapes
    for wrong in ((1, 2, 3), "red", None):
        circle.color = wrong
        with pytest.raises((TypeError, ValueError)):
            space.debug_draw(options)
    assert options.image.tobytes() == white().tobytes()
    circle.color = (250.6, 300, -4, 300)
    space.debug_draw(options)
    assert has(options.image, (251, 255, 0))
    assert capfd.readouterr() == ("", "")


def test_recorder_has_every_call_in_the_coordinates_of_the_space() -> None:
    recorder = DrawRecorder()
    recorder.transform = Transform.scaling(7)
    kinds_of_body().debug_draw(recorder)
    assert {call.name for call in recorder.calls} == {"circle", "segment", "polygon"}
    moving = next(call for call in recorder.calls if call.name == "circle")
    assert (*moving.points[0], moving.radius, moving.angle) == pytest.approx((100, 45, 20, 0.4))
    assert (moving.fill[:3], moving.outline and moving.outline[:3]) == (DYNAMIC, OUTLINE)
    cradle().debug_draw(recorder)
    marks = Counter(call.name for call in recorder.calls if call.outline is None)
    assert marks == {"line": 5, "dot": 10, "contact": 3}
    assert recorder.transform == Transform.scaling(7)


def test_pictures_look_as_they_did(golden: Callable[..., None]) -> None:
    image = white(320, 240)
    options = PillowDrawOptions(image, positive_y_is_up=True)
    options.fit(cradle())
    cradle().debug_draw(options)
    golden(image, "debug_draw/cradle")
    ramp = np.broadcast_to((np.arange(260) // 4 + 190)[None, :, None], (90, 260, 3))
    golden(drawn(kinds_of_body(), Image.fromarray(ramp.astype(np.uint8)), positive_y_is_up=True), "debug_draw/bodies")
