"""Debug drawing of spaces that no dragon is in."""

from __future__ import annotations

import gc
import math
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pymunk
import pytest
import shapely
from conftest import assert_says, not_under_coverage
from numpy.typing import NDArray
from PIL import Image
from pymunk import BB, SpaceDebugDrawOptions, Transform, Vec2d

import pymunk_dragon
from pymunk_dragon.drawing import debug_draw
from pymunk_dragon.drawing.debug_draw import CALLBACKS, PillowDrawOptions, compositing, convex, deferred_calls
from pymunk_dragon.drawing.debug_draw.convex import offset_polygon
from pymunk_dragon.errors import ParameterError

BLACK, RED, GREEN = (0, 0, 0, 255), (255, 0, 0, 255), (0, 255, 0, 255)
DYNAMIC, STATIC, KINEMATIC, SLEEPING = (52, 152, 219), (149, 165, 166), (39, 174, 96), (114, 148, 168)
OUTLINE, CONSTRAINT, COLLISION = (44, 62, 80), (142, 68, 173), (231, 76, 60)

Pixels = NDArray[np.float64]
Golden = Callable[..., None]


def white(width: int = 64, height: int = 64) -> Image.Image:
    return Image.new("RGB", (width, height), "white")


def coverage(image: Image.Image) -> Pixels:
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


def with_body(make: Callable[[pymunk.Body], pymunk.Shape], **attributes: Any) -> pymunk.Space:
    """A space with one body, and on it the shape that is made for it."""
    body = pymunk.Body(1, 1)
    for name, value in attributes.items():
        setattr(body, name, value)
    space = pymunk.Space()
    space.add(body, make(body))
    return space


def ball(x: float, y: float, radius: float, angle: float = 0.0) -> pymunk.Space:
    return with_body(lambda body: pymunk.Circle(body, radius), position=(x, y), angle=angle)


def box(x: float, y: float, size: tuple[float, float], radius: float = 0.0, angle: float = 0.0) -> pymunk.Space:
    return with_body(lambda body: pymunk.Poly.create_box(body, size, radius), position=(x, y), angle=angle)


# ------------------------------------------------------------------------------------------------------------ spaces


def pendulum() -> pymunk.Space:
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    body.position, body.angle = (1.2, -1.6), -0.9
    space.add(body, pymunk.Circle(body, 0.4), pymunk.PinJoint(space.static_body, body))
    return space


def cradle() -> pymunk.Space:
    """Newton's, with the last ball drawn aside; the balls that hang touch."""
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


def pile() -> pymunk.Space:
    """Rows of boxes, bricks with round corners between them, let settle a little."""
    space = pymunk.Space()
    space.gravity = 0, -10
    for a, b in (((-4, 0), (4, 0)), ((-4, 0), (-4, 4)), ((4, 0), (4, 4))):
        space.add(pymunk.Segment(space.static_body, a, b, 0.2))
    for row in range(4):
        for column in range(5 - row):
            body = pymunk.Body()
            body.position = 1.4 * (column - (4 - row) / 2), 0.7 + row
            shape = pymunk.Poly.create_box(body, (0.8, 0.6), 0.2) if row % 2 else pymunk.Poly.create_box(body, (1.2, 1))
            shape.mass, shape.friction = 1, 0.8
            space.add(body, shape)
    for _ in range(5):
        space.step(0.01)
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


# ------------------------------------------------------------------------------------------------- where pixels go


def shapes() -> list[Any]:
    """Shapes, drawn by hand, and what Shapely thinks of them."""
    random = np.random.default_rng(7)
    found = []
    for number in range(40):
        at = [Vec2d(*point) for point in random.uniform(14, 34, (5, 2)).tolist()]
        radius = float(random.uniform(1.5, 9))
        if number % 3 == 0:
            call, area = ("draw_circle", (at[0], 0.3, radius)), shapely.Point(at[0]).buffer(radius, 64)
        elif number % 3 == 1:
            call, area = ("draw_fat_segment", (*at[:2], radius)), shapely.LineString(at[:2]).buffer(radius, 64)
        else:
            radius = 0.0 if number % 2 else radius
            # With corners on the straight, which rounding errors turn one way or the other.
            hull = shapely.segmentize(shapely.MultiPoint(at).convex_hull, 5)
            corners = [Vec2d(*corner) for corner in hull.exterior.coords[:-1]]
            call, area = ("draw_polygon", (corners, radius)), hull.buffer(radius, 64)
        found.append(pytest.param(*call, area, id=f"{call[0]}-{number}"))
    return found


@pytest.mark.parametrize(("method", "arguments", "area"), shapes())
def test_each_pixel_is_covered_as_far_as_the_shape_reaches_into_it(method: str, arguments: Any, area: Any) -> None:
    image = white(48, 48)
    getattr(PillowDrawOptions(image), method)(*arguments, BLACK, BLACK)
    x, y = np.meshgrid(np.arange(48), np.arange(48))
    truth = shapely.area(shapely.intersection(shapely.box(x, y, x + 1, y + 1), area))
    assert np.abs(coverage(image) - truth).max() < 0.45  # a corner may be off by a quarter of a pixel, either way
    assert np.abs(coverage(image) - truth).mean() < 0.01
    # A tenth of a pixel all around would be seen as fat or thin.
    assert abs(coverage(image).sum() - truth.sum()) < 0.1 * area.length


@pytest.mark.parametrize("line_width", [1, 2, 5])
def test_the_outline_lies_inside_the_shape_and_is_as_wide_as_a_line(line_width: float) -> None:
    image = white()
    options = PillowDrawOptions(image, line_width=line_width)
    options.draw_polygon([Vec2d(10, 10), Vec2d(50, 10), Vec2d(50, 40), Vec2d(10, 40)], 4, BLACK, (255, 255, 255, 255))
    outer = shapely.box(10, 10, 50, 40).buffer(4, 64)
    assert coverage(image).sum() == pytest.approx(outer.area - outer.buffer(-line_width, 64).area, rel=0.06)


def test_fill_and_outline_meet_without_ground_between_them() -> None:
    image = Image.new("RGB", (64, 64), (0, 0, 255))
    PillowDrawOptions(image, line_width=2).draw_circle(Vec2d(32.3, 31.7), 0, 20, RED, RED)
    x, y = np.meshgrid(np.arange(64) + 0.5 - 32.3, np.arange(64) + 0.5 - 31.7)
    assert np.asarray(image)[np.hypot(x, y) < 19, 2].max() <= 2


def test_what_is_too_thin_for_an_outline_keeps_its_colour() -> None:
    image = white()
    options = PillowDrawOptions(image)
    options.draw_fat_segment(Vec2d(5, 10.5), Vec2d(60, 10.5), 0, BLACK, RED)
    options.draw_polygon([Vec2d(5, 30), Vec2d(60, 30), Vec2d(60, 32), Vec2d(5, 32)], 0, BLACK, RED)
    options.draw_circle(Vec2d(30, 50), 0, 0.1, BLACK, GREEN)
    assert image.getpixel((30, 10)) == image.getpixel((30, 31)) == RED[:3]
    red, green, blue = image.getpixel((30, 50))
    assert red == blue < green == 255


@pytest.mark.parametrize("up", [False, True])
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5, -1.3])
def test_the_line_in_a_circle_points_where_the_body_does(up: bool, angle: float) -> None:
    image = drawn(ball(32, 32, 28, angle), positive_y_is_up=up, shape_outline_color=BLACK, shape_dynamic_color=RED)
    assert needle(image, 28) == pytest.approx((math.cos(angle), math.sin(angle) * (-1 if up else 1)), abs=0.03)


@pytest.mark.parametrize(
    "matrix",
    [
        Transform.rotation(0.5),
        Transform(-1, 0, 0, 1, 0, 0),
        Transform(1, 0, 0, -1, 0, 0),
        Transform(0, 1, 1, 0, 0, 0),
        Transform.rotation(2.0) @ Transform(1, 0, 0, -1, 0, 0),
        Transform(1, 0, 0.8, 1, 0, 0),
    ],
)
def test_the_line_in_a_circle_follows_turns_mirrors_and_shears(matrix: Transform) -> None:
    space = ball(0, 0, 20, 0.7)
    image = drawn(
        space,
        transform=Transform.translation(32, 32) @ matrix,
        shape_outline_color=BLACK,
        shape_dynamic_color=RED,
    )
    assert needle(image, 20) == pytest.approx((matrix @ Vec2d(1, 0).rotated(0.7)).normalized(), abs=0.04)


def needle(image: Image.Image, radius: float) -> tuple[float, float]:
    """Direction of what is black in a red disc in the middle, but for its rim."""
    height, width = image.height, image.width
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    weight = (255 - np.asarray(image, dtype=float)[..., 0]) * (np.hypot(x, y) < radius - 3)
    x0, y0 = (weight * x).sum(), (weight * y).sum()
    return float(x0 / math.hypot(x0, y0)), float(y0 / math.hypot(x0, y0))


# ------------------------------------------------------------------------------------------------------- transforms


def test_a_translation_moves_the_picture() -> None:
    space = box(20, 22, (21, 13), 3, 0.4)
    stays = np.asarray(drawn(space))
    moved = np.asarray(drawn(space, transform=Transform.translation(17, 9)))
    np.testing.assert_array_equal(moved[9:, 17:], stays[:-9, :-17])
    assert (moved[:9] == 255).all()


def test_a_scaling_scales_sizes_and_radii() -> None:
    for space in (
        ball(20, 20, 8),
        box(20, 20, (10, 6), 4),
        with_body(lambda body: pymunk.Segment(body, (9, 9), (25, 20), 3)),
    ):
        areas = [
            coverage(
                drawn(
                    space,
                    white(128, 128),
                    transform=Transform.scaling(s),
                    shape_outline_color=BLACK,
                    color_for_shape=black,
                )
            ).sum()
            for s in (1, 3)
        ]
        assert areas[1] == pytest.approx(9 * areas[0], rel=0.04)


def black(shape: pymunk.Shape) -> tuple[int, ...]:
    return BLACK


def test_a_quarter_turn_turns_the_picture() -> None:
    space = box(20, 22, (21, 13), 3, 0.4)
    quarter = Transform(0, 1, -1, 0, 64, 0)
    assert quarter @ (20, 22) == (42, 20)
    turned = np.asarray(drawn(space, transform=quarter), dtype=float)
    stays = np.rot90(np.asarray(drawn(space), dtype=float), -1)
    assert np.abs(turned - stays).mean() < 0.6


def test_y_grows_downwards_unless_told_otherwise() -> None:
    space = box(20, 10, (30, 12), 2, 0.3)
    down, up = drawn(space), drawn(space, positive_y_is_up=True)
    assert has(down.crop((0, 0, 64, 24)), DYNAMIC)
    assert not has(down.crop((0, 24, 64, 64)), DYNAMIC)
    flipped = np.asarray(up.transpose(Image.Transpose.FLIP_TOP_BOTTOM), dtype=float)
    assert np.abs(flipped - np.asarray(down)).mean() < 0.6


def test_lines_dots_and_marks_keep_their_size_when_a_space_is_magnified() -> None:
    space = cradle()
    marks = []
    for scale in (20, 40):
        image = white(400, 300)
        options = PillowDrawOptions(image, positive_y_is_up=True)
        options.flags = SpaceDebugDrawOptions.DRAW_COLLISION_POINTS
        options.collision_point_color = BLACK
        options.transform = Transform(scale, 0, 0, scale, 30, 220)
        space.debug_draw(options)
        marks.append(coverage(image).sum())
    assert marks[0] == pytest.approx(3 * 11, rel=0.2)  # three contacts, marks of 10 x 1 pixels with round ends
    assert marks[1] == pytest.approx(marks[0], rel=0.1)


def test_dots_of_constraints_grow_with_the_width_of_lines() -> None:
    space = ball(32, 32, 10)
    space.add(pymunk.PivotJoint(space.static_body, next(iter(space.bodies)), (32, 32)))
    for width in (1, 2):
        only = {"flags": SpaceDebugDrawOptions.DRAW_CONSTRAINTS, "constraint_color": BLACK}
        image = drawn(space, line_width=width, **only)
        assert coverage(image).sum() == pytest.approx(math.pi * (5 * width) ** 2, rel=0.1)


@pytest.mark.parametrize("up", [False, True])
@pytest.mark.parametrize("size", [(200, 100), (80, 160)])
def test_fit_shows_all_of_a_space_as_large_as_it_can(size: tuple[int, int], up: bool) -> None:
    space = box(1003.0, -7.5, (0.06, 0.03))
    image = white(*size)
    options = PillowDrawOptions(image, positive_y_is_up=up)
    options.fit(space, margin=15)
    space.debug_draw(options)
    rows, columns = (np.flatnonzero((np.asarray(image) < 255).any(axis=(axis, 2))) for axis in (1, 0))
    left, top, right, bottom = columns[0], rows[0], columns[-1] + 1, rows[-1] + 1
    assert min(left, top) == pytest.approx(15, abs=1.01)
    assert (left + right, top + bottom) == pytest.approx(size, abs=1.01)
    assert (right - left) / (bottom - top) == pytest.approx(2, rel=0.05)


def test_fit_leaves_room_for_anchors_of_constraints() -> None:
    image = white(120, 120)
    options = PillowDrawOptions(image, positive_y_is_up=True)
    options.fit(pendulum())
    x, y = options.transform @ (0, 0)
    assert 9 <= x <= 111
    assert y == pytest.approx(110)


def test_fit_takes_a_part_of_the_ground() -> None:
    options = PillowDrawOptions(white(120, 80))
    options.fit(BB(left=1, bottom=2, right=3, top=4), margin=0)
    assert options.transform == Transform(40, 0, 0, 40, -20, -80)


def test_fit_leaves_out_what_is_nowhere() -> None:
    space = box(0, 0, (4, 4))
    lost = pymunk.Body(
        1,
        1,
    )
    space.add(lost, pymunk.Circle(lost, 1, (math.nan, 0)))
    options = PillowDrawOptions(white(120, 120))
    options.fit(space)
    assert options.transform == Transform(25, 0, 0, 25, 60, 60)


def test_fit_says_what_is_wrong() -> None:
    options = PillowDrawOptions(white())
    with pytest.raises(ParameterError) as caught:
        options.fit(pymunk.Space())
    assert_says(caught.value, "area", "something in it")
    with pytest.raises(ParameterError) as caught:
        options.fit(BB(1, 1, 1, 1))
    assert_says(caught.value, "area", "a size")
    with pytest.raises(ParameterError) as caught:
        options.fit(pendulum(), margin=32)
    assert_says(caught.value, "margin", "32", "pixels")


# ---------------------------------------------------------------------------------------------- colours and flags


@pytest.mark.parametrize(
    ("x", "colour"), [(40, KINEMATIC), (92, DYNAMIC), (160, SLEEPING)], ids=["kinematic", "dynamic", "sleeping"]
)
def test_colours_tell_the_kinds_of_body(x: int, colour: tuple[int, ...]) -> None:
    image = drawn(kinds_of_body(), white(260, 80))
    assert image.getpixel((x, 50)) == colour
    assert image.getpixel((125, 10)) == STATIC
    assert has(image, OUTLINE)


def test_a_shape_can_have_its_own_colour_and_options_other_ones() -> None:
    space = ball(32, 32, 10)
    (circle,) = space.shapes
    assert drawn(space, shape_dynamic_color=(1, 2, 3, 255)).getpixel((32, 38)) == (1, 2, 3)
    circle.color = (250.6, 300, -4, 300)
    image = drawn(space, shape_dynamic_color=(1, 2, 3, 255), shape_outline_color=(9, 8, 7, 255))
    assert image.getpixel((32, 38)) == (251, 255, 0)
    assert has(image, (9, 8, 7))


FLAGS = {
    OUTLINE: SpaceDebugDrawOptions.DRAW_SHAPES,
    CONSTRAINT: SpaceDebugDrawOptions.DRAW_CONSTRAINTS,
    COLLISION: SpaceDebugDrawOptions.DRAW_COLLISION_POINTS,
}


@pytest.mark.parametrize("colours", [(), (OUTLINE,), (CONSTRAINT,), (COLLISION,), (OUTLINE, COLLISION), tuple(FLAGS)])
def test_flags_say_what_is_drawn(colours: tuple[tuple[int, ...], ...]) -> None:
    image = white(300, 240)
    options = PillowDrawOptions(image, positive_y_is_up=True, line_width=2)
    options.fit(cradle(), margin=20)
    options.flags = sum(FLAGS[colour] for colour in colours)
    cradle().debug_draw(options)
    assert {colour for colour in FLAGS if has(image, colour)} == set(colours)


@pytest.mark.parametrize("alpha", [0, 1, 100, 254, 255])
@pytest.mark.parametrize("mode", ["RGB", "RGBA"])
def test_alpha_lets_the_background_through(mode: str, alpha: int) -> None:
    noise = np.random.default_rng(1).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    image = Image.fromarray(noise).convert(mode)
    PillowDrawOptions(image).draw_circle(Vec2d(32, 32), 0, 20, (*RED[:3], 0), (10, 200, 90, alpha))
    x, y = np.meshgrid(np.arange(64) - 31.5, np.arange(64) - 31.5)
    inside, outside = np.hypot(x, y) < 18, np.hypot(x, y) > 21.5
    mixed = (np.array([10, 200, 90]) * alpha + noise.astype(float) * (255 - alpha)) / 255
    pixels = np.asarray(image.convert("RGB"))
    assert np.abs(pixels[inside] - mixed[inside]).max() <= 1
    np.testing.assert_array_equal(pixels[outside], noise[outside])


def test_on_a_transparent_image_coverage_becomes_alpha_and_colours_stay_pure() -> None:
    image = Image.new("RGBA", (64, 64))
    PillowDrawOptions(image).draw_circle(Vec2d(32, 32), 0, 20, RED, RED)
    pixels = np.asarray(image)
    assert pixels[..., 3].sum() / 255 == pytest.approx(math.pi * 20**2, rel=0.01)
    assert (pixels[pixels[..., 3] > 0][:, :3] == RED[:3]).all()


def test_on_a_translucent_image_alpha_is_that_of_two_layers() -> None:
    image = Image.new("RGBA", (64, 64), (0, 0, 200, 100))
    PillowDrawOptions(image).draw_circle(Vec2d(32, 32), 0, 20, RED, (200, 0, 0, 150))
    upper, lower = 150 / 255, 100 / 255 * (1 - 150 / 255)
    alpha = upper + lower
    assert image.getpixel((32, 20)) == pytest.approx((200 * upper / alpha, 0, 200 * lower / alpha, 255 * alpha), abs=1)


def test_translucent_outlines_do_not_darken_twice() -> None:
    image = white()
    PillowDrawOptions(image, line_width=6).draw_polygon(
        [Vec2d(10, 10), Vec2d(50, 10), Vec2d(50, 50), Vec2d(10, 50)], 0, (0, 0, 0, 128), (0, 0, 0, 0)
    )
    values = set(np.asarray(image)[30, 12:15, 0].tolist())
    assert values == {127}


@pytest.mark.parametrize("mode", ["L", "P", "1", "CMYK", "RGBa", "F", "LA"])
def test_other_modes_are_refused_in_one_line(mode: str) -> None:
    with pytest.raises(ParameterError) as caught:
        PillowDrawOptions(Image.new(mode, (4, 4)))
    assert_says(caught.value, "image.mode", mode, "RGB or RGBA")


def test_only_images_and_sound_line_widths_are_taken() -> None:
    for image in (None, "image.png", np.zeros((4, 4, 3))):
        with pytest.raises(ParameterError) as caught:
            PillowDrawOptions(image)
        assert_says(caught.value, "image", "PIL.Image.Image")
    for width in (0, -1, math.nan, 101, "1"):
        with pytest.raises(ParameterError) as caught:
            PillowDrawOptions(white(), line_width=width)
        assert_says(caught.value, "line_width", "0.25", "100")


def test_the_image_can_be_changed_between_frames() -> None:
    options = PillowDrawOptions(white())
    options.image = frame = white()
    ball(32, 32, 10).debug_draw(options)
    assert has(frame, DYNAMIC)
    with pytest.raises(ParameterError):
        options.image = Image.new("L", (4, 4))


def test_a_picture_from_a_file_can_be_drawn_on(tmp_path: Path) -> None:
    white().save(tmp_path / "ground.png")
    with Image.open(tmp_path / "ground.png") as image:
        assert has(drawn(ball(32, 32, 10), image), DYNAMIC)


def test_the_same_space_gives_the_same_bytes() -> None:
    pictures = {drawn(pile(), white(200, 120), transform=Transform(20, 0, 0, 20, 100, 10)).tobytes() for _ in range(2)}
    assert len(pictures) == 1


# ------------------------------------------------------------------------------------------- what is out of sight


@pytest.fixture
def worked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Pixels of all coverage masks that are made."""
    pixels: list[int] = []

    class Counted:
        def __getattr__(self, name: str) -> Any:
            return getattr(Image, name)

        def new(self, mode: str, size: tuple[int, int], colour: Any = 0) -> Image.Image:
            pixels.append(size[0] * size[1])
            return Image.new(mode, size, colour)

    monkeypatch.setattr(compositing, "Image", Counted())
    return pixels


@pytest.mark.parametrize(
    "at", [(-1e3, 0), (1e5, 1e5), (32, 1e11), (math.nan, 3), (3, math.inf), (1e300, 0), (-1e13, 3)]
)
def test_what_is_out_of_sight_or_nowhere_is_not_worked_on(worked: list[int], at: tuple[float, float]) -> None:
    image = white()
    options = PillowDrawOptions(image)
    a = Vec2d(*at)
    b, c = a + Vec2d(5, 5), a + Vec2d(0, 7)
    options.draw_circle(a, 0.3, 20, BLACK, RED)
    options.draw_fat_segment(a, b, 3, BLACK, RED)
    options.draw_segment(a, b, BLACK)
    options.draw_polygon([a, b, c], 2, BLACK, RED)
    options.draw_dot(5, a, BLACK)
    assert worked == []
    assert image.tobytes() == white().tobytes()


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, 1e13, -3.0])
def test_impossible_radii_and_angles_neither_crash_nor_fill_the_picture(number: float) -> None:
    image = white()
    options = PillowDrawOptions(image)
    options.draw_circle(Vec2d(-30, 32), 0, number, BLACK, RED)
    options.draw_polygon([Vec2d(-30, 0), Vec2d(-20, 0), Vec2d(-20, 9)], number, BLACK, RED)
    options.draw_fat_segment(Vec2d(-30, 0), Vec2d(-20, 0), number, BLACK, RED)
    options.draw_dot(number, Vec2d(-30, 0), BLACK)
    assert image.tobytes() == white().tobytes()
    options.draw_circle(Vec2d(32, 32), number, 10, BLACK, RED)
    assert has(image, RED)


@pytest.mark.parametrize("radius", [1e3, 1e6, 1e9, 1e11])
def test_a_planet_is_drawn_as_exactly_and_as_cheaply_as_a_wall(worked: list[int], radius: float) -> None:
    planet, wall = white(400, 400), white(400, 400)
    slope = Vec2d(math.cos(0.4), math.sin(0.4))
    PillowDrawOptions(planet).draw_circle(Vec2d(200, 200) - slope * radius, 2, radius, RED, BLACK)
    cost = sum(worked)
    side = slope.perpendicular() * 900
    corners = [Vec2d(200, 200) + side, Vec2d(200, 200) - side]
    PillowDrawOptions(wall).draw_polygon([*corners, corners[1] - slope * 900, corners[0] - slope * 900], 0, RED, BLACK)
    if radius >= 1e6:  # where the circle is a pixel's hundredth from straight
        assert np.abs(np.asarray(planet, dtype=float) - np.asarray(wall)).mean() < 0.3
    assert cost < 40 * 400 * 400
    assert len(offset_polygon([(200 - radius * slope.x, 200 - radius * slope.y)], radius, (0, 0, 400, 400))) < 200


def test_shapes_far_larger_than_the_picture_cover_it_whole(worked: list[int]) -> None:
    for radius in (0, 5e8):
        image = white(300, 300)
        options = PillowDrawOptions(image)
        options.draw_polygon([Vec2d(-1e9, -1e9), Vec2d(1e9, -1e9), Vec2d(0, 2e9)], radius, BLACK, RED)
        assert (np.asarray(image) == RED[:3]).all()
    # Where nothing but fill is seen, no coverage mask is finer than the picture.
    assert sum(worked) == 2 * 300 * 300


def test_a_line_across_the_picture_costs_little_more_than_its_own_pixels(worked: list[int]) -> None:
    image = white(2000, 2000)
    PillowDrawOptions(image).draw_segment(Vec2d(-1e9, -1e9), Vec2d(1e9, 1e9), BLACK)
    assert coverage(image).sum() == pytest.approx(2000 * math.sqrt(2), rel=0.1)
    assert sum(worked) < 16 * 2000 * 2000 / 10


@pytest.mark.parametrize("scene", [joints, pile], ids=lambda scene: scene.__name__)
def test_a_space_far_away_leaves_the_picture_alone(worked: list[int], scene: Callable[[], pymunk.Space]) -> None:
    for nowhere in (Transform.translation(1e6, 0), Transform(math.nan, 0, 0, 1, 0, 0), Transform.scaling(1e300)):
        assert drawn(scene(), transform=Transform.translation(9, 9) @ nowhere).tobytes() == white().tobytes()
    assert worked == []


@pytest.mark.parametrize("scene", [joints, pile], ids=lambda scene: scene.__name__)
def test_a_space_that_is_squeezed_flat_is_drawn(scene: Callable[[], pymunk.Space]) -> None:
    for flat in (Transform(1, 0, 0, 0, 0, 30), Transform(0, 0, 0, 0, 30, 30)):
        assert drawn(scene(), transform=flat).tobytes() != white().tobytes()


# ---------------------------------------------------------------------------------------------------- exceptions


class MistakeError(Exception):
    pass


def everything() -> pymunk.Space:
    """A space for whose picture every callback is called."""
    space = kinds_of_body()
    a, b = space.static_body, next(body for body in space.bodies if body.body_type == pymunk.Body.DYNAMIC)
    space.add(pymunk.PinJoint(a, b))
    return space


def failing(name: str, error: type[BaseException]) -> type[PillowDrawOptions]:
    def method(self: PillowDrawOptions, *arguments: Any) -> None:
        raise error(name)

    return type("Failing", (PillowDrawOptions,), {name: method})


@pytest.mark.parametrize("error", [MistakeError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("name", CALLBACKS)
def test_what_an_overridden_method_raises_arrives(
    name: str, error: type[BaseException], capfd: pytest.CaptureFixture[str]
) -> None:
    hook = sys.unraisablehook
    options = failing(name, error)(white())
    with pytest.raises(error, match=name) as caught:
        everything().debug_draw(options)
    assert caught.traceback[-1].name == "method"
    assert capfd.readouterr() == ("", "")
    assert sys.unraisablehook is hook


def test_nothing_is_drawn_after_an_exception() -> None:
    class Once(PillowDrawOptions):
        calls = 0

        def draw_polygon(self, *arguments: Any) -> None:
            self.calls += 1
            raise MistakeError

    options = Once(white())
    with pytest.raises(MistakeError):
        pile().debug_draw(options)
    assert options.calls == 1


def test_nothing_is_drawn_when_the_calling_itself_was_broken_off() -> None:
    options = PillowDrawOptions(white())
    with pytest.raises(MistakeError), options:  # noqa: PT012 # as in Space.debug_draw
        options.draw_dot(9, Vec2d(32, 32), BLACK)
        raise MistakeError
    assert options.image.tobytes() == white().tobytes()
    options.draw_dot(9, Vec2d(32, 32), BLACK)
    assert has(options.image, BLACK)


def test_options_can_be_used_again_after_an_exception() -> None:
    options = PillowDrawOptions(white())
    space = ball(32, 32, 10)
    (circle,) = space.shapes
    for wrong in ((1, 2, 3), "red", None, 7, (math.nan, 0, 0, 255)):
        circle.color = wrong
        with pytest.raises((TypeError, ValueError)):
            space.debug_draw(options)
    circle.color = RED
    space.debug_draw(options)
    assert has(options.image, RED)


def test_overridden_methods_are_called_with_what_the_picture_shows() -> None:
    class Noted(PillowDrawOptions):
        def __init__(self) -> None:
            super().__init__(white())
            self.noted: list[Any] = []

        def draw_circle(self, *arguments: Any) -> None:
            self.noted.append(arguments)
            super().draw_circle(*arguments)

        def color_for_shape(self, shape: pymunk.Shape) -> Any:
            return RED

    options = Noted()
    options.transform = Transform(2, 0, 0, -2, 10, 50)
    ball(10, 8, 5, 0.25).debug_draw(options)
    [(pos, angle, radius, outline, fill)] = options.noted
    assert (pos, radius) == (Vec2d(30, 34), 10)
    assert angle == pytest.approx(-0.25)
    assert outline == (*OUTLINE, 255)
    assert fill == RED
    assert fill.as_int() == RED
    assert has(options.image, RED)


def test_functions_set_on_the_options_are_called_too_and_stay() -> None:
    options = PillowDrawOptions(white())
    dots: list[float] = []
    call = options.draw_dot = lambda size, pos, color: dots.append(size)
    for _ in range(2):
        joints().debug_draw(options)
    assert options.draw_dot is call
    assert set(dots) == {5}
    assert len(dots) == 2 * 9  # two at every joint that has anchors, one on a groove


def test_options_are_left_as_they_were() -> None:
    options = PillowDrawOptions(white())
    before = set(vars(options))
    everything().debug_draw(options)
    assert set(vars(options)) == before


def test_an_exception_between_the_calls_arrives(capfd: pytest.CaptureFixture[str]) -> None:
    """Pymunk's own glue asks the options to convert colours, which stands for wherever Ctrl-C may strike."""

    class Struck(PillowDrawOptions):
        def _c(self, color: Any) -> Any:
            raise KeyboardInterrupt

    hook = sys.unraisablehook
    image = white()
    with pytest.raises(KeyboardInterrupt):
        everything().debug_draw(Struck(image))
    assert capfd.readouterr() == ("", "")
    assert sys.unraisablehook is hook
    assert image.tobytes() == white().tobytes()


@not_under_coverage
@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="Windows has no timer that interrupts")
def test_no_interrupt_is_lost_whenever_it_comes() -> None:
    class InterruptError(Exception):
        pass

    def interrupt(number: int, frame: Any) -> None:
        raise InterruptError

    options, space = PillowDrawOptions(white(8, 8)), pile()
    # An interrupt that strikes a finalizer is lost, whoever it is that Python runs the finalizer in.
    gc.collect()
    gc.disable()
    before = signal.signal(signal.SIGALRM, interrupt)
    hook = sys.unraisablehook
    try:
        for delay in np.linspace(1e-4, 4e-3, 200).tolist():
            with pytest.raises(InterruptError):  # noqa: PT012 # the timer is part of what raises
                signal.setitimer(signal.ITIMER_REAL, delay)
                for _ in range(10_000):
                    space.debug_draw(options)
        # Whatever an interrupt left behind is gone after the next drawing.
        space.debug_draw(options)
    finally:
        gc.enable()
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert sys.unraisablehook is hook
    assert not set(vars(options)) & set(CALLBACKS)


def test_threads_draw_at_the_same_time() -> None:
    hook = sys.unraisablehook
    expected = drawn(pile(), white(200, 120), transform=Transform(20, 0, 0, 20, 100, 10)).tobytes()
    pictures: list[bytes] = []
    failures: list[BaseException] = []

    def draw() -> None:
        for _ in range(10):
            pictures.append(drawn(pile(), white(200, 120), transform=Transform(20, 0, 0, 20, 100, 10)).tobytes())
            try:
                everything().debug_draw(failing("draw_circle", MistakeError)(white()))
            except MistakeError as failure:
                failures.append(failure)

    threads = [threading.Thread(target=draw) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(pictures) == {expected}
    assert len(failures) == 40
    drawn(pile())
    assert sys.unraisablehook is hook


def test_exceptions_lost_elsewhere_go_where_they_went(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another thread's, and those of finalizers, are none of ours."""
    seen: list[Any] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda unraisable: seen.append(type(unraisable.exc_value)))

    class Dying:
        def __del__(self) -> None:
            raise MistakeError

    class Gone(PillowDrawOptions):
        def _c(self, color: Any) -> Any:
            Dying()
            return super()._c(color)

    options = Gone(white())
    ball(32, 32, 10).debug_draw(options)
    assert set(seen) == {MistakeError}
    assert has(options.image, DYNAMIC)


# ------------------------------------------------------------------------------------------------- what it hangs on


def test_pymunk_calls_every_callback_by_its_name() -> None:
    """And looks them up on the options themselves, where they can be hidden."""
    called: set[str] = set()
    options = PillowDrawOptions(white())
    for name in CALLBACKS:

        def note(*arguments: Any, name: str = name) -> tuple[int, int, int, int]:
            called.add(name)
            return BLACK

        setattr(options, name, note)
    everything().debug_draw(options)
    assert called == set(CALLBACKS)
    public = {name for name in dir(SpaceDebugDrawOptions) if name.startswith("draw_")}
    assert public - {"draw_shape"} == set(CALLBACKS) - {"color_for_shape"}


def test_no_private_name_of_pymunk_is_used() -> None:
    modules = (compositing, convex, debug_draw, deferred_calls)
    text = "".join(Path(module.__file__).read_text(encoding="utf-8") for module in modules)
    assert "pymunk._" not in text
    assert "._options" not in text


def test_it_is_offered_at_the_top_and_pymunk_does_not_come_with_every_picture() -> None:
    assert pymunk_dragon.PillowDrawOptions is PillowDrawOptions
    code = "import sys, pymunk_dragon.drawing; assert 'pymunk' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


# ---------------------------------------------------------------------------------------------- pictures looked at


@pytest.mark.parametrize("scene", [pendulum, cradle, pile], ids=lambda scene: scene.__name__)
def test_scenes_in_metres_look_as_they_did(scene: Callable[[], pymunk.Space], golden: Golden) -> None:
    image = white(320, 240)
    options = PillowDrawOptions(image, positive_y_is_up=True)
    space = scene()
    options.fit(space)
    space.debug_draw(options)
    golden(image, f"debug_draw/{scene.__name__}")


def test_all_kinds_of_constraint_look_as_they_did(golden: Golden) -> None:
    golden(drawn(joints(), white(480, 290)), "debug_draw/joints")


def test_bodies_over_a_background_look_as_they_did(golden: Golden) -> None:
    ramp = np.broadcast_to((np.arange(260) // 4 + 190)[None, :, None], (90, 260, 3))
    golden(drawn(kinds_of_body(), Image.fromarray(ramp.astype(np.uint8)), positive_y_is_up=True), "debug_draw/bodies")


def test_a_turned_and_mirrored_space_on_a_transparent_image_looks_as_it_did(golden: Golden) -> None:
    image = Image.new("RGBA", (320, 240))
    matrix = Transform.translation(170, 60) @ Transform.rotation(0.5) @ Transform(-30, 0, 0, 30, 0, 0)
    golden(drawn(pile(), image, transform=matrix, line_width=2), "debug_draw/mirrored")
