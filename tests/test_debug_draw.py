"""Debug drawing of spaces that no dragon is in."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pymunk
import pytest
import shapely
from conftest import assert_says
from numpy.typing import NDArray
from PIL import Image
from pymunk import BB, SpaceDebugDrawOptions, Transform, Vec2d

from pymunk_dragon import PillowDrawOptions
from pymunk_dragon.drawing.debug_draw import CALLBACKS
from pymunk_dragon.errors import ParameterError

BLACK, RED = (0, 0, 0, 255), (255, 0, 0, 255)
DYNAMIC, STATIC, KINEMATIC, SLEEPING = (52, 152, 219), (149, 165, 166), (39, 174, 96), (114, 148, 168)
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


def joints() -> pymunk.Space:
    """Every kind of constraint, each between two bodies beside each other."""
    kinds: list[Callable[[pymunk.Body, pymunk.Body], pymunk.Constraint]] = [
        lambda a, b: pymunk.PinJoint(a, b, (10, 0), (-10, 0)),
        lambda a, b: pymunk.SlideJoint(a, b, (0, 10), (0, 10), 10, 60),
        lambda a, b: pymunk.PivotJoint(a, b, (30, 0), (-30, 0)),
        lambda a, b: pymunk.GrooveJoint(a, b, (0, -20), (0, 20), (-60, 0)),
        lambda a, b: pymunk.DampedSpring(a, b, (10, 0), (-10, 0), 40, 1, 1),
        lambda a, b: pymunk.DampedRotarySpring(a, b, 0, 1, 1),
        lambda a, b: pymunk.RotaryLimitJoint(a, b, -1, 1),
        lambda a, b: pymunk.RatchetJoint(a, b, 0, 1),
        lambda a, b: pymunk.GearJoint(a, b, 0, 1),
        lambda a, b: pymunk.SimpleMotor(a, b, 1),
    ]
    space = pymunk.Space()
    for i, kind in enumerate(kinds):
        bodies = []
        for side in (-30, 30):
            body = pymunk.Body(1, 1)
            body.position = 160 * (i % 3) + 80 + side, 70 * (i // 3) + 40
            body.angle = 0.3 * side / 30
            space.add(body, pymunk.Poly.create_box(body, (30, 30)))
            bodies.append(body)
        space.add(kind(*bodies))
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


def everything() -> pymunk.Space:
    """A space for whose picture every callback is called."""
    space = kinds_of_body()
    a, b = space.static_body, next(body for body in space.bodies if body.body_type == pymunk.Body.DYNAMIC)
    space.add(pymunk.PinJoint(a, b))
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
        image = white(48, 48)
        getattr(PillowDrawOptions(image), name)(*arguments, BLACK, BLACK)
        truth = shapely.area(shapely.intersection(shapely.box(x, y, x + 1, y + 1), area))
        error = np.abs(coverage(image) - truth)
        assert error.max() < 0.45, (name, number)  # a corner may be off by a quarter of a pixel, either way
        assert error.mean() < 0.01, (name, number)
        # A tenth of a pixel all around would be seen as fat or thin.
        assert abs(coverage(image).sum() - truth.sum()) < 0.1 * area.length, (name, number)


def test_outline_lies_inside_the_shape_without_ground_between_it_and_the_fill() -> None:
    for line_width in (1, 2, 5):
        image = white()
        corners = [Vec2d(10, 10), Vec2d(50, 10), Vec2d(50, 40), Vec2d(10, 40)]
        PillowDrawOptions(image, line_width=line_width).draw_polygon(corners, 4, BLACK, (255, 255, 255, 255))
        outer = shapely.box(10, 10, 50, 40).buffer(4, 64)
        assert coverage(image).sum() == pytest.approx(outer.area - outer.buffer(-line_width, 64).area, rel=0.06)
    image = Image.new("RGB", (64, 64), (0, 0, 255))
    PillowDrawOptions(image, line_width=2).draw_circle(Vec2d(32.3, 31.7), 0, 20, RED, RED)
    x, y = np.meshgrid(np.arange(64) + 0.5 - 32.3, np.arange(64) + 0.5 - 31.7)
    assert np.asarray(image)[np.hypot(x, y) < 19, 2].max() <= 2


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
            assert found == pytest.approx((matrix @ Vec2d(1, 0).rotated(angle)).normalized(), abs=0.04), (matrix, angle)


def test_transforms_move_turn_and_scale_the_picture() -> None:
    space = box(20, 22, (21, 13), 3, 0.4)
    stays = np.asarray(drawn(space))
    moved = np.asarray(drawn(space, transform=Transform.translation(17, 9)))
    np.testing.assert_array_equal(moved[9:, 17:], stays[:-9, :-17])
    assert (moved[:9] == 255).all()
    turned = np.asarray(drawn(space, transform=Transform(0, 1, -1, 0, 64, 0)), dtype=float)
    assert np.abs(turned - np.rot90(stays.astype(float), -1)).mean() < 0.6
    up = np.asarray(drawn(space, positive_y_is_up=True), dtype=float)
    assert np.abs(up[::-1] - stays).mean() < 0.6
    segment = with_body(lambda body: pymunk.Segment(body, (9, 9), (25, 20), 3))
    for space in (ball(20, 20, 8), box(20, 20, (10, 6), 4), segment):
        colours = {"shape_outline_color": BLACK, "color_for_shape": lambda shape: BLACK}
        images = [drawn(space, white(128, 128), transform=Transform.scaling(s), **colours) for s in (1, 3)]
        assert coverage(images[1]).sum() == pytest.approx(9 * coverage(images[0]).sum(), rel=0.04)


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
    options = PillowDrawOptions(white(120, 120), positive_y_is_up=True)
    options.fit(cradle())
    # The anchors of the constraints are in the picture too.
    x, y = options.transform @ (0, 0)
    assert 9 <= x <= 111
    assert 9 <= y <= 111


def test_fit_takes_a_part_of_the_ground() -> None:
    options = PillowDrawOptions(white(120, 80))
    options.fit(BB(left=1, bottom=2, right=3, top=4), margin=0)
    assert options.transform == Transform(40, 0, 0, 40, -20, -80)


def test_colours_tell_the_kinds_of_body() -> None:
    image = drawn(kinds_of_body(), white(260, 80))
    for place, colour in (((40, 50), KINEMATIC), ((92, 50), DYNAMIC), ((160, 50), SLEEPING), ((125, 10), STATIC)):
        assert image.getpixel(place) == colour
    assert has(image, OUTLINE)
    space = ball(32, 32, 10)
    (circle,) = space.shapes
    assert drawn(space, shape_dynamic_color=(1, 2, 3, 255)).getpixel((32, 38)) == (1, 2, 3)
    circle.color = (250.6, 300, -4, 300)
    assert drawn(space, shape_dynamic_color=(1, 2, 3, 255)).getpixel((32, 38)) == (251, 255, 0)


def test_flags_say_what_is_drawn() -> None:
    flags = {
        OUTLINE: SpaceDebugDrawOptions.DRAW_SHAPES,
        CONSTRAINT: SpaceDebugDrawOptions.DRAW_CONSTRAINTS,
        COLLISION: SpaceDebugDrawOptions.DRAW_COLLISION_POINTS,
    }
    for colours in ((), (OUTLINE,), (CONSTRAINT,), (COLLISION,), (OUTLINE, COLLISION), tuple(flags)):
        image = white(300, 240)
        options = PillowDrawOptions(image, positive_y_is_up=True, line_width=2)
        options.fit(cradle(), margin=20)
        options.flags = sum(flags[colour] for colour in colours)
        cradle().debug_draw(options)
        assert {colour for colour in flags if has(image, colour)} == set(colours)


def test_alpha_lets_the_background_through() -> None:
    noise = np.random.default_rng(1).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    x, y = np.meshgrid(np.arange(64) - 31.5, np.arange(64) - 31.5)
    inside, outside = np.hypot(x, y) < 18, np.hypot(x, y) > 21.5
    for mode, alpha in (("RGB", 0), ("RGB", 100), ("RGB", 255), ("RGBA", 1), ("RGBA", 254)):
        image = Image.fromarray(noise).convert(mode)
        PillowDrawOptions(image).draw_circle(Vec2d(32, 32), 0, 20, (*RED[:3], 0), (10, 200, 90, alpha))
        mixed = (np.array([10, 200, 90]) * alpha + noise.astype(float) * (255 - alpha)) / 255
        pixels = np.asarray(image.convert("RGB"))
        assert np.abs(pixels[inside] - mixed[inside]).max() <= 1, (mode, alpha)
        np.testing.assert_array_equal(pixels[outside], noise[outside])


def test_on_a_transparent_image_coverage_becomes_alpha() -> None:
    image = Image.new("RGBA", (64, 64))
    PillowDrawOptions(image).draw_circle(Vec2d(32, 32), 0, 20, RED, RED)
    pixels = np.asarray(image)
    assert pixels[..., 3].sum() / 255 == pytest.approx(math.pi * 20**2, rel=0.01)
    assert (pixels[pixels[..., 3] > 0][:, :3] == RED[:3]).all()


def test_bad_images_line_widths_and_areas_are_refused() -> None:
    options = PillowDrawOptions(white())
    cases: list[tuple[str, Callable[[Any], Any], list[Any]]] = [
        ("area", options.fit, [pymunk.Space(), BB(1, 1, 1, 1)]),
        ("margin", lambda margin: options.fit(cradle(), margin), [32]),
        ("image", PillowDrawOptions, [None, "image.png", np.zeros((4, 4, 3))]),
        ("image.mode", lambda mode: PillowDrawOptions(Image.new(mode, (4, 4))), ["L", "P", "CMYK", "LA"]),
        ("image.mode", lambda mode: setattr(options, "image", Image.new(mode, (4, 4))), ["L"]),
        ("line_width", lambda width: PillowDrawOptions(white(), line_width=width), [0, -1, math.nan, 101, "1"]),
    ]
    for name, call, values in cases:
        for value in values:
            with pytest.raises(ParameterError) as caught:
                call(value)
            assert caught.value.name == name, value
            assert_says(caught.value)


def test_what_is_out_of_sight_or_nowhere_changes_nothing() -> None:
    image = white()
    options = PillowDrawOptions(image)
    for at in ((-1e3, 0), (1e5, 1e5), (32, 1e11), (math.nan, 3), (3, math.inf), (1e300, 0), (-1e13, 3)):
        a = Vec2d(*at)
        b, c = a + Vec2d(5, 5), a + Vec2d(0, 7)
        options.draw_circle(a, 0.3, 20, BLACK, RED)
        options.draw_fat_segment(a, b, 3, BLACK, RED)
        options.draw_segment(a, b, BLACK)
        options.draw_polygon([a, b, c], 2, BLACK, RED)
        options.draw_dot(5, a, BLACK)
    for number in (math.nan, math.inf, -math.inf, 1e13, -3.0):
        options.draw_circle(Vec2d(-30, 32), 0, number, BLACK, RED)
        options.draw_polygon([Vec2d(-30, 0), Vec2d(-20, 0), Vec2d(-20, 9)], number, BLACK, RED)
        options.draw_fat_segment(Vec2d(-30, 0), Vec2d(-20, 0), number, BLACK, RED)
        options.draw_dot(number, Vec2d(-30, 0), BLACK)
    for nowhere in (Transform.translation(1e6, 0), Transform(math.nan, 0, 0, 1, 0, 0), Transform.scaling(1e300)):
        drawn(joints(), image, transform=Transform.translation(9, 9) @ nowhere)
    assert image.tobytes() == white().tobytes()
    options.draw_circle(Vec2d(32, 32), math.nan, 10, BLACK, RED)
    assert has(image, RED)


def test_shapes_far_larger_than_the_picture_are_exact() -> None:
    slope = Vec2d(math.cos(0.4), math.sin(0.4))
    side = slope.perpendicular() * 900
    corners = [Vec2d(200, 200) + side, Vec2d(200, 200) - side]
    corners += [corners[1] - slope * 900, corners[0] - slope * 900]
    wall = white(400, 400)
    PillowDrawOptions(wall).draw_polygon(corners, 0, RED, BLACK)
    for radius in (1e6, 1e11):
        planet = white(400, 400)
        PillowDrawOptions(planet).draw_circle(Vec2d(200, 200) - slope * radius, 2, radius, RED, BLACK)
        assert np.abs(np.asarray(planet, dtype=float) - np.asarray(wall)).mean() < 0.3
    for radius in (0, 5e8):
        image = white(300, 300)
        PillowDrawOptions(image).draw_polygon([Vec2d(-1e9, -1e9), Vec2d(1e9, -1e9), Vec2d(0, 2e9)], radius, BLACK, RED)
        assert (np.asarray(image) == RED[:3]).all()
    image = white(800, 800)
    PillowDrawOptions(image).draw_segment(Vec2d(-1e9, -1e9), Vec2d(1e9, 1e9), BLACK)
    assert coverage(image).sum() == pytest.approx(800 * math.sqrt(2), rel=0.1)
    for flat in (Transform(1, 0, 0, 0, 0, 30), Transform(0, 0, 0, 0, 30, 30)):
        assert drawn(joints(), transform=flat).tobytes() != white().tobytes()


class MistakeError(Exception):
    pass


def failing(name: str, error: type[BaseException]) -> type[PillowDrawOptions]:
    def method(self: PillowDrawOptions, *arguments: Any) -> None:
        raise error(name)

    return type("Failing", (PillowDrawOptions,), {name: method})


def test_exception_of_an_overridden_method_arrives(capfd: pytest.CaptureFixture[str]) -> None:
    hook = sys.unraisablehook
    # Pymunk asks `_c` to convert colours between the calls, which stands for wherever Ctrl-C may strike.
    for name in (*CALLBACKS, "_c"):
        for error in (MistakeError, KeyboardInterrupt):
            image = white()
            with pytest.raises(error, match=name) as caught:
                everything().debug_draw(failing(name, error)(image))
            assert caught.traceback[-1].name == "method"
    assert image.tobytes() == white().tobytes()
    public = {name for name in dir(SpaceDebugDrawOptions) if name.startswith("draw_")}
    assert public - {"draw_shape"} == set(CALLBACKS) - {"color_for_shape"}
    assert capfd.readouterr() == ("", "")
    assert sys.unraisablehook is hook


def test_options_can_be_used_again_after_an_exception() -> None:
    options = PillowDrawOptions(white())
    before = set(vars(options))
    space = ball(32, 32, 10)
    (circle,) = space.shapes
    for wrong in ((1, 2, 3), "red", None, (math.nan, 0, 0, 255)):
        circle.color = wrong
        with pytest.raises((TypeError, ValueError)):
            space.debug_draw(options)
    circle.color = RED
    space.debug_draw(options)
    assert has(options.image, RED)
    assert set(vars(options)) == before


def test_pictures_look_as_they_did(golden: Callable[..., None]) -> None:
    image = white(320, 240)
    options = PillowDrawOptions(image, positive_y_is_up=True)
    options.fit(cradle())
    cradle().debug_draw(options)
    golden(image, "debug_draw/cradle")
    golden(drawn(joints(), white(480, 290)), "debug_draw/joints")
    ramp = np.broadcast_to((np.arange(260) // 4 + 190)[None, :, None], (90, 260, 3))
    golden(drawn(kinds_of_body(), Image.fromarray(ramp.astype(np.uint8)), positive_y_is_up=True), "debug_draw/bodies")
