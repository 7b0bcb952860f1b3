"""Debug drawing of spaces that no dragon is in."""

import math
from collections import Counter

import imageio.v3 as iio
import numpy as np
import pymunk
import pytest
import shapely
from conftest import refusal
from documents import GUIDES
from PIL import Image, ImageChops
from pymunk import BB, Transform, Vec2d
from pymunk.space_debug_draw_options import SpaceDebugColor

from pymunk_dragon import PillowDrawOptions
from pymunk_dragon.physics.draw_calls import DrawRecorder

BLACK = SpaceDebugColor(0, 0, 0, 255)
RED = SpaceDebugColor(255, 0, 0, 255)
WHITE = SpaceDebugColor(255, 255, 255, 255)


def white(width=64, height=64):
    return Image.new("RGB", (width, height), "white")


def has(image, colour):
    return bool((np.asarray(image) == colour[:3]).all(axis=-1).any())


def painted(name, *arguments, image=None):
    """Picture of one call of a drawing method."""
    options = PillowDrawOptions(image or white())
    with options:
        getattr(options, name)(*arguments)
    return options.image


def cradle():
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


def shapes():
    """A shape of every kind; the disc has a colour of its own that can be seen through."""
    space = pymunk.Space()
    body, lift = pymunk.Body(1, 1), pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    body.position = (60, 40)
    lift.position = (20, 40)
    body.angle = 0.4
    disc = pymunk.Circle(body, 20)
    disc.color = (*RED[:3], 100)
    space.add(
        lift,
        pymunk.Poly.create_box(lift, (30, 25), 4),
        pymunk.Segment(space.static_body, (0, 8), (80, 8), 4),
    )
    space.add(body, disc, pymunk.Poly(body, [(20, -15), (40, -15), (30, 5)]))
    return space


def test_every_kind_of_shape_covers_its_area():
    random = np.random.default_rng(7)
    x, y = np.meshgrid(np.arange(48), np.arange(48))
    for number in range(12):
        at = [Vec2d(*point) for point in random.uniform(14, 34, (5, 2)).tolist()]
        radius = random.uniform(2, 9)
        # With corners on the straight, which rounding errors turn one way or the other.
        hull = shapely.segmentize(shapely.MultiPoint(at).convex_hull, 5)
        corners = [Vec2d(*corner) for corner in hull.exterior.coords[:-1]]
        for name, arguments, area in (
            ("draw_circle", (at[0], 0.3, radius), shapely.Point(at[0]).buffer(radius)),
            ("draw_fat_segment", (*at[:2], radius), shapely.LineString(at[:2]).buffer(radius)),
            ("draw_polygon", (corners, radius), hull.buffer(radius)),
            ("draw_polygon", (corners[::-1], 0.0), hull),
        ):
            covered = 1 - np.asarray(painted(name, *arguments, BLACK, BLACK))[:48, :48, 0] / 255
            truth = shapely.area(shapely.intersection(shapely.box(x, y, x + 1, y + 1), area))
            assert np.abs(covered - truth).max() < 0.8, (name, number)
            assert abs(covered.sum() - truth.sum()) < 0.3 * area.length, (name, number)


# Pixels: the largest error of the mean thickness of a line of tens of pixels. Polygons have whole
# pixels, and a picture is drawn at twice its size.
THICKNESS = 0.25


def test_lines_and_outlines_are_as_thick_as_their_width_at_every_angle():
    random = np.random.default_rng(5)
    x, y = np.meshgrid(np.arange(120) + 0.5, np.arange(120) + 0.5)
    for width in (1, 1.5, 2, 3, 4):
        for degrees in range(0, 91, 5):
            along = Vec2d.from_polar(1, math.radians(degrees + random.choice([0, 90])))
            middle = Vec2d(60, 60) + Vec2d(*random.random(2).tolist())
            across = along.perpendicular()
            ends = middle - 50 * along, middle + 50 * along
            far, away = ((x - middle.x) * one.x + (y - middle.y) * one.y for one in (along, across))
            corners = [
                end + 12 * side * across
                for end, side in zip((*ends, *ends[::-1]), (-1, -1, 1, 1), strict=True)
            ]
            # What is drawn, in which part of the picture, and how long a line is there.
            for name, arguments, part, length in (
                ("draw_segment", (*ends, BLACK), np.abs(far) < 35, 70),
                ("draw_fat_segment", (*ends, 0.0, RED, BLACK), np.abs(far) < 35, 70),
                (
                    "draw_fat_segment",
                    (*ends, 12.0, BLACK, WHITE),
                    (np.abs(far) < 35) & (away > 0),
                    70,
                ),
                ("draw_polygon", (corners, 0.0, BLACK, WHITE), (np.abs(far) < 35) & (away > 0), 70),
                ("draw_polygon", (corners, 3.0, BLACK, WHITE), (np.abs(far) < 35) & (away < 0), 70),
                (
                    "draw_circle",
                    (middle, along.angle, 45, BLACK, WHITE),
                    (np.abs(away) < 12) & (np.abs(far - 21) < 19),
                    38,
                ),
                (
                    "draw_circle",
                    (middle, across.angle, 45, BLACK, WHITE),
                    (np.abs(far) > 30) & (np.hypot(far, away) > 35),
                    None,
                ),
            ):
                options = PillowDrawOptions(white(120, 120), line_width=width)
                with options:
                    getattr(options, name)(*arguments)
                covered = float(((1 - np.asarray(options.image)[..., 0] / 255) * part).sum())
                if length is None:  # Two arcs of a circle.
                    length = 4 * math.acos(30 / (45 - width / 2)) * (45 - width / 2)
                assert covered / length == pytest.approx(width, abs=THICKNESS), (
                    name,
                    width,
                    degrees,
                )


def test_marks_of_contacts_are_as_thick_as_lines_at_every_angle():
    mark = SpaceDebugColor(255, 0, 0, 255)
    for width in (1, 2, 3, 4):
        for degrees in range(0, 91, 5):
            options = PillowDrawOptions(white(), line_width=width)
            options.collision_point_color = mark
            along = Vec2d.from_polar(1, math.radians(degrees))
            with options:
                options.draw_segment(Vec2d(32, 32) - along, Vec2d(32, 32) + along, mark)
            covered = float((1 - np.asarray(options.image)[..., 1] / 255).sum())
            # Five widths to either side of the contact, and up to half a pixel more.
            assert covered == pytest.approx(
                width * (10 * width + 0.25), abs=THICKNESS * (10 * width + 1)
            ), (
                width,
                degrees,
            )


def test_what_has_no_length_is_drawn_as_a_point_or_not_at_all():
    here = Vec2d(32, 32)
    assert not has(painted("draw_segment", here, here, BLACK), RED)
    for name, arguments in (
        ("draw_fat_segment", (here, here, 0.0)),
        ("draw_polygon", ([here, here + Vec2d(20, 9)], 0.0)),
    ):
        covered = np.asarray(painted(name, *arguments, RED, BLACK))[..., 0] < 255
        assert 0 < covered.sum() < 40


def test_outline_lets_the_fill_shine_through_nowhere_else():
    box = [Vec2d(10, 12), Vec2d(54, 22), Vec2d(50, 50), Vec2d(12, 44)]
    clear = (0, 0, 0, 0)
    both, fill, outline = (
        painted("draw_polygon", box, 4.0, *colours)
        for colours in ((BLACK, RED), (clear, RED), (BLACK, clear))
    )
    inked = np.asarray(outline)[..., :1] < 255
    np.testing.assert_array_equal(
        np.asarray(both)[~inked[..., 0]], np.asarray(fill)[~inked[..., 0]]
    )
    assert not has(outline, RED)


def test_circles_have_a_line_in_the_direction_of_their_body_in_every_view():
    x, y = np.meshgrid(np.arange(64) - 31.5, np.arange(64) - 31.5)
    for view in (
        Transform.identity(),
        Transform(1, 0, 0, -1, 0, 0),
        Transform.rotation(2) @ Transform(0, 1, 1, 0, 0, 0),
    ):
        options = PillowDrawOptions(white())
        options.transform = Transform.translation(32, 32) @ view
        with options:
            options.draw_circle(Vec2d(0, 0), 0.7, 20, BLACK, RED)
        # What is black in the red disc, but for its rim.
        weight = (255 - np.asarray(options.image, dtype=float)[..., 0]) * (np.hypot(x, y) < 17)
        found = Vec2d((weight * x).sum(), (weight * y).sum()).normalized()
        assert found == pytest.approx((view @ Vec2d(1, 0).rotated(0.7)).normalized(), abs=0.1), view


def test_fit_shows_all_of_a_space_as_large_as_it_can():
    space = pymunk.Space()
    space.add(
        pymunk.Poly(
            space.static_body, [(1003, -7.5), (1003.06, -7.5), (1003.06, -7.47), (1003, -7.47)]
        )
    )
    for size, up in (((200, 100), False), ((80, 160), True)):
        options = PillowDrawOptions(white(*size), positive_y_is_up=up)
        options.fit(space, margin=15)
        space.debug_draw(options)
        left, top, right, bottom = ImageChops.invert(options.image).getbbox()
        assert min(left, top) == pytest.approx(15, abs=1.01)
        assert (left + right, top + bottom) == pytest.approx(size, abs=1.01)
        assert (right - left) / (bottom - top) == pytest.approx(2, rel=0.05)
    options = PillowDrawOptions(white(120, 80))
    options.fit(BB(left=1, bottom=2, right=3, top=4), margin=0)
    assert options.transform == Transform(40, 0, 0, 40, -20, -80)
    options.fit(cradle())
    # The anchors of the constraints are in the picture too.
    assert all(
        10 <= length <= size - 10
        for length, size in zip(options.transform @ (0, 0), (120, 80), strict=True)
    )


def test_alpha_lets_the_background_through():
    for alpha in (0, 1, 100, 255):
        image = Image.new("RGB", (64, 64), (30, 40, 250))
        painted(
            "draw_circle", Vec2d(32, 32), 0, 20, (*RED[:3], 0), (10, 200, 90, alpha), image=image
        )
        mixed = (np.array([10, 200, 90]) * alpha + np.array([30, 40, 250]) * (255 - alpha)) / 255
        assert np.abs(np.array(image.getpixel((32, 40))) - mixed).max() <= 1, alpha


def test_bad_images_line_widths_and_areas_are_refused():
    options = PillowDrawOptions(white())
    cases = [
        ("area", options.fit, [pymunk.Space(), BB(1, 1, 1, 1)]),
        ("margin", lambda margin: options.fit(cradle(), margin), [32]),
        (
            "image",
            PillowDrawOptions,
            [None, "image.png", *(Image.new(mode, (4, 4)) for mode in ("L", "P", "LA"))],
        ),
        (
            "line_width",
            lambda width: PillowDrawOptions(white(), line_width=width),
            [0, -1, math.nan, 101, "1"],
        ),
    ]
    for name, call, values in cases:
        for value in values:
            assert refusal(call, value).name == name, value


def test_what_is_out_of_sight_or_nowhere_changes_nothing():
    image = white()
    options = PillowDrawOptions(image)
    places = [
        (-1e3, 0),
        (1e5, 1e5),
        (32, 1e11),
        (math.nan, 3),
        (3, math.inf),
        (1e300, 0),
        (-1e13, 3),
    ]
    with options:
        for place, radius in [
            *((place, 3.0) for place in places),
            *(((-30, 32), r) for r in (math.nan, math.inf, -3)),
        ]:
            a = Vec2d(*place)
            options.draw_circle(a, 0.3, radius, BLACK, RED)
            options.draw_fat_segment(a, a + Vec2d(5, 5), radius, BLACK, RED)
            options.draw_polygon([a, a + Vec2d(5, 5), a + Vec2d(0, 7)], radius, BLACK, RED)
            options.draw_segment(a, a + Vec2d(5, 5), BLACK)
            options.draw_dot(radius, a, BLACK)
    for nowhere in (
        Transform.translation(1e6, 0),
        Transform(math.nan, 0, 0, 1, 0, 0),
        Transform.scaling(1e300),
    ):
        options.transform = Transform.translation(9, 9) @ nowhere
        shapes().debug_draw(options)
    assert image.tobytes() == white().tobytes()


def test_shapes_far_larger_than_the_picture_are_drawn():
    slope = Vec2d(math.cos(0.4), math.sin(0.4))
    planet = painted(
        "draw_circle", Vec2d(200, 200) - slope * 1e5, 2, 1e5, RED, BLACK, image=white(400, 400)
    )
    x, y = np.meshgrid(np.arange(400) - 199.5, np.arange(400) - 199.5)
    assert np.mean((np.asarray(planet)[..., 1] < 128) != (x * slope.x + y * slope.y < 0)) < 0.004
    far = [Vec2d(-1e7, -1e7), Vec2d(1e7, -1e7), Vec2d(0, 2e7)]
    for radius in (0, 5e6):
        assert (np.asarray(painted("draw_polygon", far, radius, BLACK, RED)) == RED[:3]).all()
    assert has(painted("draw_segment", Vec2d(-4e8, 32.5), Vec2d(4e8, 32.5), BLACK), BLACK)
    # A slope of 0.3 around a point of the picture.
    far_away = Vec2d(1e8, 3e7)
    across = np.asarray(
        painted("draw_segment", Vec2d(20, 30) - far_away, Vec2d(20, 30) + far_away, BLACK)
    )[..., 0]
    assert (
        np.abs(
            np.argmin(across[:, ::9], axis=0) + 0.5 - (30 + 0.3 * (np.arange(0, 64, 9) + 0.5 - 20))
        ).max()
        < 1
    )


def test_wrong_colour_of_a_shape_is_raised_and_the_options_can_be_used_again(capfd):
    options = PillowDrawOptions(white())
    space = pymunk.Space()
    circle = pymunk.Circle(space.static_body, 10, (32, 32))
    space.add(circle)
    for wrong in ((1, 2, 3), "red", None):
        circle.color = wrong
        with pytest.raises((TypeError, ValueError)):
            space.debug_draw(options)
    assert options.image.tobytes() == white().tobytes()
    circle.color = (250.6, 300, -4, 300)
    space.debug_draw(options)
    assert has(options.image, (251, 255, 0))
    assert capfd.readouterr() == ("", "")


def test_recorder_has_every_call_in_the_coordinates_of_the_space():
    recorder = DrawRecorder()
    recorder.transform = Transform.scaling(7)
    shapes().debug_draw(recorder)
    assert {call.name for call in recorder.calls} == {"circle", "segment", "polygon"}
    disc = next(call for call in recorder.calls if call.name == "circle")
    assert (*disc.points[0], disc.radius, disc.angle) == pytest.approx((60, 40, 20, 0.4))
    assert (disc.fill, disc.outline and disc.outline[:3]) == ((*RED[:3], 100), (44, 62, 80))
    cradle().debug_draw(recorder)
    marks = Counter(call.name for call in recorder.calls if call.outline is None)
    assert marks == {"line": 5, "dot": 10, "contact": 3}
    assert recorder.transform == Transform.scaling(7)


def ball(number, colour):
    """Frame of a small ball on a ground with many colours."""
    x, y = np.meshgrid(np.arange(158), np.arange(62))
    ground = np.stack([x, 4 * y, np.full_like(x, 120)], axis=-1)
    ground[np.hypot(x - 20 - 5 * number, y - 30) < 4] = colour
    return Image.fromarray(ground.astype(np.uint8))


def test_recipes_of_the_guide_keep_colours_and_sizes(here):
    # The blocks of the program, from the palette on, of the WebP and of the MP4.
    program, webp, mp4, *_ = GUIDES["pictures"].blocks("python")
    last_frame, first_frame = (230, 20, 20), (20, 200, 40)
    frames = [ball(number, last_frame if number == 19 else first_frame) for number in range(20)]
    names = {"frames": frames, "Image": Image, "numpy": np}
    exec(program[program.index("everything") :] + webp + mp4, names)
    with Image.open("dominoes.gif") as film:
        for number, colour in ((0, first_frame), (19, last_frame)):
            film.seek(number)
            shown = np.asarray(film.convert("RGB")).astype(int)
            assert np.abs(shown[30, 20 + 5 * number] - colour).max() <= 4
            assert np.abs(shown - np.asarray(frames[number])).max() <= 24
    assert np.array_equal(iio.imread("dominoes.webp", index=19, mode="RGB"), frames[19])
    assert iio.immeta("dominoes.mp4")["size"] == (158, 62)


def test_pictures_look_as_they_did(golden):
    options = PillowDrawOptions(white(320, 240), positive_y_is_up=True)
    options.fit(cradle())
    cradle().debug_draw(options)
    golden(options.image, "debug_draw/cradle")
    ramp = np.broadcast_to((np.arange(220) // 4 + 200)[None, :, None], (140, 220, 3))
    options.image = Image.fromarray(ramp.astype(np.uint8))
    options.fit(shapes())
    shapes().debug_draw(options)
    golden(options.image, "debug_draw/shapes")


BOX_OF_DISCS = pymunk.BB(-1, -1, 2, 1)


def discs():
    """An opaque disc, and a translucent one over half of it."""
    space = pymunk.Space()
    for x, colour in ((0, (255, 0, 0, 255)), (1, (0, 0, 255, 128))):
        disc = pymunk.Circle(space.static_body, 1, (x, 0))
        disc.color = colour
        space.add(disc)
    return space


def drawn_on(image, space, box=BOX_OF_DISCS):
    options = PillowDrawOptions(image, positive_y_is_up=True)
    options.shape_outline_color = (0, 0, 0, 255)
    options.fit(box, margin=0)
    space.debug_draw(options)
    return image


def test_picture_with_alpha_is_transparent_where_nothing_is_drawn():
    image = drawn_on(Image.new("RGBA", (120, 80)), discs())
    assert image.getpixel((2, 2))[3] == 0
    assert image.getpixel((30, 45)) == (255, 0, 0, 255)
    assert image.getpixel((90, 45)) == pytest.approx((0, 0, 255, 128), abs=1)
    assert image.getpixel((55, 50)) == pytest.approx((127, 0, 128, 255), abs=1)


@pytest.mark.parametrize("ground", ["white", (30, 60, 90)])
def test_picture_with_alpha_over_a_ground_is_that_on_the_ground(ground):
    layer = drawn_on(Image.new("RGBA", (120, 80)), discs())
    over = Image.new("RGBA", (120, 80), ground)
    over.alpha_composite(layer)
    expected = drawn_on(Image.new("RGB", (120, 80), ground), discs())
    difference = np.asarray(over.convert("RGB")).astype(int) - np.asarray(expected)
    assert abs(difference).max() <= 2
    again = drawn_on(Image.new("RGBA", (120, 80), ground), discs())
    assert abs(np.asarray(again.convert("RGB")).astype(int) - np.asarray(expected)).max() <= 2


@pytest.mark.parametrize("kind", ["png", "gif", "webp"])
def test_transparent_pictures_are_saved_as_stills_and_films(tmp_path, kind):
    space = discs()
    frames = []
    for k in range(3):
        box = pymunk.BB(-1.5 - k, -1, 1.5 - k, 1)
        frames.append(drawn_on(Image.new("RGBA", (120, 80)), space, box))
    path = tmp_path / f"discs.{kind}"
    options = {"save_all": True, "append_images": frames[1:], "duration": 100}
    if kind != "png":
        frames[0].save(path, **options, disposal=2, lossless=True)
    else:
        frames[0].save(path)
    with Image.open(path) as found:
        for k in range(1 if kind == "png" else 3):
            found.seek(k)
            shown = np.asarray(found.convert("RGBA"))
            expected = np.asarray(frames[k])
            clear = expected[..., 3] == 0
            assert clear.any()
            assert (shown[clear][:, 3] == 0).all()
            full = expected[..., 3] == 255
            assert (shown[full][:, 3] == 255).all()


@pytest.mark.parametrize("angle", [0.0, 0.7, 1.5])
def test_spoke_ends_at_the_circle_where_the_view_is_stretched(angle):
    image = Image.new("RGB", (200, 200), "white")
    options = PillowDrawOptions(image)
    options.transform = pymunk.Transform(60, 0, 30, 10, 100, 100)
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    body.angle = angle
    space.add(body, pymunk.Circle(body, 1))
    space.debug_draw(options)
    rows, columns = np.nonzero((np.asarray(image) != 255).any(axis=2))
    reach = np.hypot(columns - 99.5, rows - 99.5).max()
    assert reach == pytest.approx(math.sqrt(600), abs=1.5)
