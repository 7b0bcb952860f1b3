"""The stages of lessons in a real browser: exact model and readouts against the package."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from browser import english_words, needs_browser, opened, wait_until

import pymunk_dragon.lessons
from pymunk_dragon import (
    Dragon,
    Grid,
    March,
    Spiral,
    UTurn,
    first_contact,
    pull,
    scan,
    separation,
)
from pymunk_dragon.lessons._framework.page import packed_runs
from pymunk_dragon.model.curves import Sampled
from pymunk_dragon.model.dragon import bench_poses
from pymunk_dragon.studies import max_speed
from pymunk_dragon.web.page import colour_variables, scripts

pytestmark = [pytest.mark.thorough, needs_browser]

LESSONS = Path(pymunk_dragon.lessons.__file__).parent
ASSETS = LESSONS / "_framework/assets"
FRAME = """
:root { color-scheme: light; --ink: #27303f; --quiet: #5d6675; --rule: #e4dcca; --link: #2f6594; }
body { margin: 1rem; background: #fdfbf6; color: var(--ink); font: 1.05rem/1.6 system-ui; }
main { max-width: 46rem; }
"""
CLOSE = 1e-9  # m
PULLED = [pull(March(), until=12, drag=drag, tolerance=1e-6) for drag in (0, 11.5)]
RUNS = json.dumps(packed_runs(PULLED))
ERRORS = json.dumps(
    {
        "substeps": [0.04, 0.02, 0.01],
        "passes": [3, 10, 20],
        "errors": {
            f"{order} {n}": [4.0, 4 / 2**order, 1.0] for order in (1, 2) for n in (3, 10, 20)
        },
        # Eight handles at five times, all of them 4 mm off at the end.
        "moved": {
            f"{order} {n}": [[[[0, 100 * t]] * 8 for t in range(5)]] * 3
            for order in (1, 2)
            for n in (3, 10, 20)
        },
        "exact": [[[-2 * i, t] for i in range(8)] for t in range(5)],
    }
)
# A page in a file has nothing that plays a scene.
NO_ENGINE = """Played.prototype.enter = function () {
  this.note = ["Nothing plays here.", "这里没有引擎。"];
};"""
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def stage_page(stage: str = "", language: str = "en") -> str:
    """A page with all scripts of the stages, and with one stage that is open."""
    stages = [path.read_text("utf-8") for path in sorted(LESSONS.glob("*.js"))]
    script = "".join([*scripts("lab", "played"), *stages, NO_ENGINE])
    opening = (
        f'<script>openStage(document.querySelector("[data-stage={stage}]"))</script>'
        if stage
        else ""
    )
    return (
        f'<!doctype html><html lang="{language}"><meta charset="utf-8"><title>Stage</title>'
        '<meta name="viewport" content="width=device-width">'
        f"<style>{colour_variables()}{FRAME}{(ASSETS / 'lab.css').read_text('utf-8')}</style>"
        f'<main><h1>Stage</h1><div class="stage" data-stage="{stage}"></div></main>'
        f'<script type="application/json" id="unguided-data">{RUNS}</script>'
        f'<script type="application/json" id="engine-data">{ERRORS}</script>'
        f'<script>"use strict";{script}</script>{opening}'
    )


@pytest.fixture
def visit(browser, tmp_path):
    """Open the page of a stage."""

    def visited(stage: str = "", language: str = "en", **options):
        path = tmp_path / "stage.html"
        path.write_text(stage_page(stage, language), "utf-8")
        return opened(browser, path.as_uri(), **options)

    return visited


@pytest.fixture
def page(visit):
    with visit() as found:
        yield found.page
        assert found.complaints == []


CHAIN = """([kind, sizes, heads]) => heads.map((head) => {
  const curve = eval(kind);
  const { points, ratios } = chainAt(curve, makeDragon(sizes), curve.atLength?.(head) ?? head);
  return points.map(([x, y, tx, ty], i) => [x, y, ratios[i] * tx, ratios[i] * ty]);
})"""


def assert_same_chains(page, curve, march, sizes, heads):
    """Positions and velocities in page and package, with the head at `heads` m on the curve."""
    found = np.array(page.evaluate(CHAIN, [curve, sizes, heads.tolist()]))
    states = march.at(heads - march.head_start)
    np.testing.assert_allclose(found[..., :2], states.positions, rtol=0, atol=CLOSE)
    np.testing.assert_allclose(found[..., 2:], states.velocities, rtol=0, atol=CLOSE)


def test_chains_on_spirals_are_the_packages(page):
    random = np.random.default_rng(1)
    for pitch in (0.45, 0.55, 1.7):
        spiral = Spiral(pitch=pitch)
        heads = random.uniform(spiral.at_radius(8.8), spiral.at_radius(2.5), 130)
        march = March(Dragon(), spiral, start_s=heads.min())
        assert_same_chains(page, f"new Spiral({pitch})", march, {}, heads)


def test_chains_on_u_turns_are_the_packages(page):
    random = np.random.default_rng(2)
    for ratio in (0.5, 1.0, 1.63, 2.0):
        march = March(Dragon(), UTurn(ratio=ratio))
        assert march.curve.length == pytest.approx(
            page.evaluate(f"new UTurn({{ ratio: {ratio} }}).length"), abs=CLOSE
        )
        heads = random.uniform(-10, 40, 80)
        assert_same_chains(page, f"new UTurn({{ ratio: {ratio} }})", march, {}, heads)


def test_chains_on_drawn_paths_are_the_packages(page):
    random = np.random.default_rng(3)
    sizes = {"benches": 12, "head": 0.3, "body": 0.2, "overhang": 0.03, "width": 0.06}
    dragon = Dragon(benches=12, head_spacing=0.3, body_spacing=0.2, overhang=0.03, width=0.06)
    for _ in range(6):
        angles = np.cumsum(random.uniform(-0.7, 0.7, 16))
        points = np.cumsum(
            random.uniform(0.25, 0.45, (16, 1)) * np.stack([np.cos(angles), np.sin(angles)], -1),
            axis=0,
        )
        march = March(dragon, Sampled(points))
        heads = random.uniform(march.head_start, march.curve.end_s, 50)
        assert_same_chains(page, f"new DrawnPath({points.tolist()})", march, sizes, heads)


def test_gaps_of_rectangles_are_the_packages(page):
    random = np.random.default_rng(4)
    poses = random.uniform([-1.5, -1.5, -4], [1.5, 1.5, 4], (1000, 2, 3))
    lengths, widths = random.uniform(0.1, 2, (2, 1000, 2))
    found = page.evaluate(
        """([poses, lengths, widths]) => poses.map((pair, k) => {
          const sizes = { lengths: lengths[k], widths: widths[k] };
          return new Benches(sizes, posesFrom(2, (i) => pair[i])).gap(0, 1).gap;
        })""",
        [poses.tolist(), lengths.tolist(), widths.tolist()],
    )
    dragon = [pymunk_dragon.outlines(poses[k], lengths[k], widths[k]) for k in range(1000)]
    corners = np.array(dragon)
    expected = separation(corners[:, 0], corners[:, 1]).distance
    assert 300 < np.sum(expected < 0) < 900
    np.testing.assert_allclose(found, expected, rtol=0, atol=CLOSE)


def grid_of_page(page, march, time, cell):
    return page.evaluate(
        """([head, count, grid]) => {
          const dragon = makeDragon({ benches: count });
          const benches = benchesBetween(dragon, chainAt(new Spiral(0.55), dragon, head).points);
          const { cells, entries, pairs } = gridPairs(benches, grid);
          const filed = [...cells].flatMap(([cell, each]) => each.map((i) => `${cell},${i}`));
          return [filed, entries, pairs];
        }""",
        [march.head_start + time, march.dragon.benches, {"cell": cell, "origin": [-8.8, 8.8]}],
    )


@pytest.mark.parametrize("cell", [0.3, 0.55, 2.2])
def test_cells_and_pairs_are_those_of_the_packages_grid(page, cell):
    march, time = March(), 412.4
    outlines = march.dragon.outlines(march.at(time).poses[0])
    grid = Grid(cell=cell)
    filed, entries, pairs = grid_of_page(page, march, time, cell)
    cells, benches = grid.file(outlines)
    expected = np.column_stack([cells, benches]).tolist()
    assert sorted(filed) == sorted(",".join(map(str, entry)) for entry in expected)
    assert entries == len(benches)
    assert sorted(map(tuple, pairs)) == sorted(map(tuple, grid.pairs(outlines).tolist()))


def set_slider(page, name, value):
    page.get_by_label(name, exact=True).fill(str(value))


def readout(page):
    """What the stage says, once it has drawn."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    said = page.evaluate("document.querySelector('output').textContent")
    assert not re.search(r"\d \w", said), "a line may end between a number and its unit"
    return said.replace("\u00a0", " ")


def drag(page, name, dx, dy, steps=5):
    """Drag a knob by pixels, to the right and down, with the mouse."""
    readout(page)
    box = page.get_by_role("button", name=name).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx, y + dy, steps=steps)
    page.mouse.up()


def test_spiral_says_how_fast_one_turns(visit):
    with visit("spiral") as found:
        set_slider(found.page, "time", 400)
        state = March().at(400)
        (x, y), (u, v) = state.positions[0, 0], state.velocities[0, 0]
        rate = (y * u - x * v) / (x * x + y * y)
        said = readout(found.page)
        assert f"{rate:.3f} rad/s: a round in {2 * np.pi / rate:.1f} s" in said
        assert f"{np.hypot(x, y):.2f} m from you" in said
        found.page.get_by_label("time").press("End")  # the head bench still fits on the spiral
        assert "m/s, 1.53 m from you" in readout(found.page)
        # A quarter round along the outermost turn, with the mouse.
        set_slider(found.page, "time", 0)
        box = found.page.locator("canvas").bounding_box()
        drag(found.page, "The head", -8.8 * box["height"] / 18.6, 8.67 * box["height"] / 18.6)
        assert "The head walks at 1 m/s, 8.66 m from you" in readout(found.page)


def test_chain_finds_the_next_handle(visit):
    with visit("chain") as found:
        page = found.page
        assert readout(page).startswith(
            "Points of the spiral found on the circle: 0. Yours is not on the spiral"
        )
        march = March()
        (x, y), (px, py) = march.at(300).positions[0, :2]
        box = page.locator("canvas").bounding_box()
        scale = min(box["width"], box["height"]) / 2.4 / 2.86
        knob = page.get_by_role("button", name="The next handle").bounding_box()
        at = knob["x"] + 22, knob["y"] + 22
        centre = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        drag(
            page,
            "The next handle",
            centre[0] + (px - x) * scale - at[0],
            centre[1] - (py - y) * scale - at[1],
        )
        arc = -np.diff(march.handles_s(300, 2)[0]).item()
        assert f"Yours is {arc:.3f} m back along the path, 0.00 m off." in readout(page)
        # By the keyboard once round the circle.
        away = np.hypot(*(Spiral().point(np.linspace(-800, 0, 800_001)) - (x, y)).T)
        for bench in (2.86, 1.65):
            set_slider(page, "handle to handle", bench)
            for _ in range(13):
                page.get_by_role("button", name="The next handle").press("Shift+ArrowUp")
            assert (
                f"on the circle: {np.sum(np.diff(away > bench))}. Yours is not on the spiral"
                in readout(page)
            )


def test_velocity_says_how_slow_the_tail_is_and_how_wrong_a_difference(visit):
    with visit("velocity") as found:
        march, page = March(), found.page
        for time, exponent in ((300, 0), (200, -2), (200, -1)):
            set_slider(page, "time", time)
            set_slider(page, "time step", exponent)
            speeds = march.at(time).speeds
            error = np.abs(march.speeds_by_difference(time, 10.0**exponent) - speeds).max()
            said, tail = readout(page), 1000 * speeds[0, -1]
            assert f"{tail:.3f} mm/s, {1000 - tail:.3f} mm/s slower" in said
            wrong = said.split("apart: ")[1].split()[0].translate(SUPERSCRIPTS).replace("·10", "e")
            assert float(wrong) == pytest.approx(float(f"{error:.1e}"))
        # Of the last two steps the shorter one is better.
        assert "The best step so far: 10 ms, " in readout(page)


def test_sat_says_how_far_two_benches_are_apart(visit):
    with visit("sat") as found:
        page, poses = found.page, np.array([[-0.8, -0.45, 0], [0.8, 0.45, np.pi / 6]])

        def verdict():
            distance = separation(*pymunk_dragon.outlines(poses, [2.2, 2.2], 0.3)).distance.item()
            return (
                f"are {distance:.3f} m apart." if distance > 0 else f"overlap by {-distance:.3f} m."
            )

        assert readout(page) == f"Walls with light: none of 1. The benches, at 30°, {verdict()}"
        set_slider(page, "walls", 4)
        assert (
            readout(page)
            == f"Walls with light: 1 of 4, up to 0.070 m wide. The benches, at 30°, {verdict()}"
        )
        scale = page.locator("canvas").bounding_box()["height"] / 7.2
        drag(page, "The amber bench: drag it", -30, 40)
        poses[1, :2] += np.array([-30, -40]) / scale
        assert readout(page) == f"Walls with light: none of 4. The benches, at 30°, {verdict()}"
        # Half a metre by the keyboard.
        page.get_by_role("button", name="The amber bench: drag it").press("Shift+ArrowUp")
        poses[1, 1] += 0.5
        assert verdict() in readout(page)


def test_grid_says_how_many_pairs_share_a_cell(visit):
    with visit("grid") as found:
        page, march = found.page, March()
        outlines = march.dragon.outlines(march.at(412.473837).poses[0])
        for cell, benches in ((0.55, 223), (0.1, 223), (2.2, 223), (0.55, 16)):
            set_slider(page, "size of a cell", cell)
            set_slider(page, "benches", benches)
            pairs = Grid(cell=cell).pairs(outlines[:benches])
            entries = Grid(cell=cell).file(outlines[:benches])[1]
            every = (benches - 1) * (benches - 2) // 2
            assert f"{len(pairs)} of {every} pairs share a cell; {len(entries)} entries" in readout(
                page
            )
        assert f"Bench 8: {np.sum(pairs == 8)} to test." in readout(page)
        page.get_by_role("button", name="The bench that is picked").press("ArrowLeft")
        assert f"Bench 7: {np.sum(pairs == 7)} to test." in readout(page)


def test_near_miss_shows_the_gap_and_the_false_hit_of_cut_coordinates(visit):
    with visit("near-miss") as found:
        page, march = found.page, March()
        assert readout(page).endswith("Overlaps until now: none.")
        for decimals in (6, 3, 4):
            set_slider(page, "coordinates", decimals)
            for time in (406.8, 409.85, 412.2):
                set_slider(page, "time", time)
                handles = march.at(time, handles=14).positions[0]
                handles = (
                    handles if decimals == 6 else np.trunc(10**decimals * handles) / 10**decimals
                )
                outlines = march.dragon.outlines(bench_poses(handles))
                gaps = 1000 * separation(outlines[0], outlines[2:]).distance
                gap, bench = gaps.min(), gaps.argmin() + 2
                said = (
                    f"gap to bench {bench} is {gap:.3f} mm"
                    if gap > 0
                    else f"bench {bench} by {-gap:.3f} mm"
                )
                assert said in readout(page)
        set_slider(page, "coordinates", 3)
        assert "the first at 409.79 s." in readout(page)


def test_missed_window_says_which_contact_a_step_misses(visit):
    with visit("missed-window") as found:
        page, march = found.page, March(Dragon(width=0.301))
        times = np.linspace(409.7, 410, 30_001)
        outlines = march.dragon.outlines(march.at(times, 17).poses)
        touched = np.ptp(
            times[(separation(outlines[:, :1], outlines[:, 2:]).distance <= 0).any(axis=1)]
        )
        # Nothing of what comes later is said.
        assert re.fullmatch(r"405.000 s: gap 27\.\d+ mm\.", readout(page))
        # A second and a half along the strip, which shows 8 s; then to its end.
        width = page.locator("canvas").bounding_box()["width"] - 74
        drag(page, "The time: drag it", 1.5 / 8 * width, 0)
        assert re.fullmatch(r"406\.5\d\d s: gap [\d.]+ mm\.", readout(page))
        set_slider(page, "time", 411)
        assert "The samples find" not in readout(page)
        assert f"Missed: bench 11, touched for {touched:.3f} s." in readout(page)
        drag(page, "The time: drag it", width, 0)
        # 1 s, 0.5 s and 0.1 s.
        for index, step in ((0, 1.0), (-1, 0.5), (-3, 0.1)):
            set_slider(page, "a sample every", index)
            bench = scan(march, start=405, until=420, step=step).benches[1]
            assert f"The samples find the head in bench {bench} at" in readout(page)
            missed = (
                f"Missed: bench 11, touched for {touched:.3f} s."
                if bench == 8
                else "No contact was missed."
            )
            assert missed in readout(page)
        set_slider(page, "width", 300.98)
        bench = scan(March(Dragon(width=0.30098)), start=405, until=420, step=0.1).benches[1]
        assert (
            f"The samples find the head in bench {bench} at 412.500 s. Missed: bench 11"
            in readout(page)
        )


@pytest.mark.parametrize("pitch", [0.43, 0.4503, 0.4504])
def test_pitch_says_where_the_dragon_stops_and_what_samples_see(visit, pitch):
    with visit("pitch") as found:
        page, march = found.page, March(Dragon(benches=40), Spiral(pitch=pitch))
        arrival = march.curve.at_radius(4.5) - march.head_start
        set_slider(page, "pitch", int(1000 * pitch))
        set_slider(page, "fine adjustment", round(1000 * pitch - int(1000 * pitch), 3))
        hit = first_contact(march, until=arrival)
        if hit.benches:
            radius = np.hypot(*march.at(hit.time).positions[0, 0])
            said = f"The head meets bench {hit.benches[1]}, {radius:.3f} m from the centre."
        else:
            said = "The dragon gets in."
        assert readout(page).startswith(said)

        def smallest_gap(step):
            times = np.arange(arrival // 1 - 20, arrival, step)
            outlines = march.dragon.outlines(march.at(times, handles=27).poses)
            return 1000 * separation(outlines[:, :1], outlines[:, 2:]).distance.min()

        assert (
            f"20 s: {smallest_gap(0.002):.3f} mm; in the samples: {smallest_gap(1.0):.3f} mm."
            in readout(page)
        )
        # Back along the spiral by the keyboard.
        page.get_by_role("button", name="The head").press("ArrowLeft")
        assert readout(page).startswith(said)


def finger(page, start, stop):
    """Drag a finger over the page."""
    touch = page.context.new_cdp_session(page)
    for share in np.linspace(0, 1, 9):
        kind = "touchMove" if share else "touchStart"
        point = np.array(start) + share * np.subtract(stop, start)
        points = [{"x": float(point[0]), "y": float(point[1])}]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def test_u_turn_says_how_long_the_arcs_are(visit):
    with visit("u-turn", width=390, height=844, has_touch=True, is_mobile=True) as found:
        page = found.page

        def arcs(ratio):
            turn = UTurn(ratio=ratio)
            one, two = np.abs(turn.sweeps) * turn.radii
            return f"{one:.2f} + {two:.2f} = {turn.length:.2f} m"

        assert readout(page).endswith("yours 0.00 + 0.00 = 0.00 m.")
        set_slider(page, "time", 14)
        assert readout(page) == f"Walked: the contest's {arcs(2)}, yours {arcs(1)}."
        box = page.get_by_role("button", name="The point where your arcs meet").bounding_box()
        start = np.array([box["x"], box["y"]]) + 22
        scale = page.locator("canvas").bounding_box()["width"] / 11.6
        # With a finger, 1.2 m towards the exit: 1 - 2 / 4.5 is the share of the first arc.
        way = -1.2 * UTurn().tangent_points[0] / 4.5 * scale * (1, -1)
        finger(page, start, start + way)
        own = arcs((1 + 1.2 / 4.5) / (1 - 1.2 / 4.5))
        assert f"yours {own}." in readout(page)
        # The lengths do not wait for the head.
        set_slider(page, "time", 0)
        assert readout(page).endswith(f"yours 0.00 + 0.00 = 0.00 m. Your arcs: {own}.")
        set_slider(page, "time", 14)
        # Handle 1 is pushed back where the second arc is narrower than the head's bench, as at a
        # ratio of 7 to 3.
        for _ in range(13):
            page.get_by_role("button", name="The point where your arcs meet").press("ArrowLeft")
        march = March(
            Dragon(benches=30), UTurn(ratio=(1 + 1.2 / 4.5 + 0.26) / (1 - 1.2 / 4.5 - 0.26))
        )
        assert np.diff(march.handles_s([13.9, 14.0], 2)[:, 1]) < 0
        assert "But your head's bench would push its rear handle back." in readout(page)


def test_speed_limit_says_who_is_fastest(visit):
    with visit("speed-limit") as found:
        page = found.page
        assert "In the whole turn" not in readout(page)
        set_slider(page, "way of the head", 24)
        for ratio in (2.0, 1.0):
            set_slider(page, "ratio of the radii", ratio)
            largest = max_speed(limit=2.0, ratio=ratio)
            set_slider(page, "speed of the head", round(largest.speed, 3))
            top = round(largest.speed, 3) * largest.ratio
            assert f"In the whole turn: {top:.3f} m/s, handle {largest.handle}." in readout(page)
            for way in (9.5, 14.5):
                set_slider(page, "way of the head", way)
                speeds = round(largest.speed, 3) * March(curve=UTurn(ratio=ratio)).at(way).speeds[0]
                first = np.argmax(speeds > speeds.max() - 1e-9)
                assert f"now: handle {first}, {speeds.max():.3f} m/s" in readout(page)
        # Along the way with the mouse, from 14.5 m to 12 m.
        scale = page.locator("canvas").bounding_box()["height"] / 12
        curve = UTurn(ratio=1.0)
        (x, y), (other_x, other_y) = curve.point([14.5, 12.0])
        drag(page, "The head: drag it", (other_x - x) * scale, (y - other_y) * scale)
        speed = March(curve=curve).at(12.0).speeds[0].max()
        assert float(readout(page).split(", ")[2].split()[0]) == pytest.approx(speed, abs=0.01)


KNOBS = """[...document.querySelectorAll(".knob")].filter((knob) => !knob.hidden)
  .map((knob) => [parseFloat(knob.style.left), parseFloat(knob.style.top)])"""


def path_of(page):
    """The points of the drawn path in m, from where they are on the canvas."""
    box = page.locator("canvas").bounding_box()
    scale = min(box["width"] / 2.9, box["height"] / 1.9)
    return (np.array(page.evaluate(KNOBS)) - (box["width"] / 2, box["height"] / 2)) / (
        scale,
        -scale,
    ) + (-0.6, 0)


@pytest.mark.parametrize("drawn", [False, True])
def test_robot_says_whether_the_arm_follows_a_path(visit, drawn):
    with visit("robot") as found:
        page = found.page
        readout(page)
        if drawn:
            box = page.locator("canvas").bounding_box()
            x, y = box["x"] + 30, box["y"] + 0.75 * box["height"]
            page.mouse.move(x, y)
            page.mouse.down()
            page.mouse.move(x + 40, y)
            page.mouse.up()
            assert "too short" in readout(page)
            page.mouse.move(x, y)
            page.mouse.down()
            for share in np.linspace(0, 1, 60):
                page.mouse.move(x + 660 * share, y - 150 * np.sin(4 * share) ** 2)
            page.mouse.up()
            assert readout(page)
        set_slider(page, "time", page.get_by_label("time", exact=True).get_attribute("max"))
        said = readout(page)
        arm = Dragon(
            head_spacing=0.14,
            body_spacing=[0.10] * 6 + [0.13] * 5 + [0.16] * 4,
            overhang=0.02,
            width=[0.05] * 7 + [0.06] * 5 + [0.07] * 4,
        )
        points = path_of(page)
        if drawn:
            # The arm comes in along a straight line before the path.
            (first, second), away = points[:2], np.hypot(*(points[1] - points[0]))
            back = 0.3 * np.arange(7, 0, -1)[:, np.newaxis]
            points = np.concatenate([first - back * (second - first) / away, points])
        march = March(arm, Sampled(points), speed=0.2)
        hit = first_contact(march)
        outcome = "The tip reaches the end after" if drawn else "Link 0 runs into link 13 at"
        assert hit.benches == (None if drawn else (0, 13))
        time, low, high = (
            float(said.split(before)[1].split()[0])
            for before in (outcome, "joints so far at", " to ")
        )
        assert time == pytest.approx(hit.time, abs=2e-3)
        # A path across the stage takes its time.
        assert time > (10 if drawn else 5)
        speeds = march.at([0, hit.time]).speeds
        assert (low, high) == pytest.approx((speeds.min(), speeds.max()), abs=6e-4)
        if drawn:
            page.get_by_role("button", name="Point 3 of the path").press("Shift+ArrowDown")
            assert readout(page) != said


def test_a_point_that_is_dropped_outside_the_stage_stays_in_sight_and_in_the_address(visit):
    with visit("robot") as found:
        page = found.page
        readout(page)
        knob = page.get_by_role("button", name="Point 1 of the path")
        box = knob.bounding_box()
        scene = page.locator("canvas").bounding_box()
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        page.mouse.down()
        page.mouse.move(scene["x"] - 100, scene["y"] + scene["height"] / 2)
        page.mouse.up()
        said = readout(page)
        assert knob.is_visible()
        wait_until(page, "location.hash.startsWith('#robot&path=')")
        place = knob.bounding_box()
        page.reload()
        assert readout(page) == said
        assert knob.bounding_box() == pytest.approx(place, abs=0.01)


def test_dragon_that_is_pulled_is_where_the_exact_run_has_it(visit):
    with visit("unguided") as found:
        for number, run in enumerate(PULLED):
            set_slider(found.page, "drag of the ground", number)
            for time in (5.0, 11.9):
                set_slider(found.page, "time", time)
                said = readout(found.page)
                hit = run.first_contact
                end = min(time, hit.time)
                (front, rear), exact = march_handles(run, end)
                off = np.hypot(*(np.vstack([front, rear[-1:]]) - exact).T)
                # Positions between two frames are right to centimetres.
                low, high = (np.sum(off > near) for near in (0.34, 0.26))
                assert low <= int(said.split("s: ")[1].split()[0]) <= high
                touching = f"Benches {hit.benches[0]} and {hit.benches[1]} touch"
                assert (touching in said) == (time > hit.time)


def test_halved_step_has_the_share_of_the_error_that_the_rule_leaves(visit):
    with visit("engine") as found:
        page = found.page
        # A quarter of the way.
        set_slider(page, "time", 2)
        assert "the worst is 1.00 mm off now" in readout(page)
        set_slider(page, "time", 8)
        for order in (1, 2):
            if order == 2:
                page.get_by_role("button", name="Let the force act in the middle").click()
            for step in (0, 1):
                set_slider(page, "step", step)
                said = readout(page)
            assert f"{4 / 2**order:.2f} mm off" in said
            assert f"{1 / 2**order:.2f} of the error" in said


def march_handles(run, time):
    """Front and rear holes of a run, and the exact handles."""
    front, rear = run.march.dragon.holes(run.poses_at([time])[0])
    return (front, rear), run.march.at([time]).positions[0]


STAGES = sorted(path.stem.replace("_", "-") for path in LESSONS.glob("*.js"))
NUMBERS = re.compile(r"\d+(?:\.\d+)?")


@pytest.mark.parametrize("stage", STAGES)
def test_stages_speak_chinese_and_fit_on_a_phone(visit, stage):
    with visit(stage, "zh", width=390, height=844) as found:
        page = found.page
        chinese = readout(page)
        assert english_words(page) <= {"Stage", "rad"}
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert page.evaluate(
            "[...document.querySelectorAll('.knob, canvas, .play')].every((each) => each.ariaLabel)"
        )
        # Another language keeps the experiment.
        page.evaluate("""() => {
          document.documentElement.lang = 'en';
          document.dispatchEvent(new Event('languagechange'));
        }""")
        assert readout(page) != chinese
        assert sorted(NUMBERS.findall(readout(page))) == sorted(NUMBERS.findall(chinese))
        assert found.complaints == []


def test_state_of_a_stage_is_in_the_address_and_reset_brings_back_the_first_one(visit):
    with visit("near-miss") as found:
        page = found.page
        first = readout(page)
        set_slider(page, "coordinates", 3)
        set_slider(page, "time", 412.6)
        moved = readout(page)
        wait_until(page, "location.hash === '#near-miss&time=412.6&coordinates=3'")
        page.reload()
        assert readout(page) == moved
        page.get_by_role("button", name="Reset").press("Enter")
        assert readout(page) == first
        assert page.url.endswith("#near-miss")
        # What is no state of the stage changes nothing.
        page.goto(page.url + "&time=soon&zoom=[1]&pitch=2&coordinates=")
        page.reload()
        assert readout(page) == first
        assert found.complaints == []


def test_dragged_things_stay_in_the_address_and_colours_have_a_legend(visit):
    with visit("sat") as found:
        page = found.page
        readout(page)
        page.evaluate("""() => {
          const lab = new Lab(document.querySelector('.stage'));
          lab.ends = [[0, 1], [2, 3]];
          lab.keep("two ends", () => lab.ends, (ends) => { lab.ends = ends; });
          lab.legend([["head", ["the head", "龙头"]]]);
          lab.requestDraw();
          window.lab = lab;
        }""")
        assert readout(page) == ""
        assert page.inner_text(".legend") == "the head"
        page.evaluate("location.hash = '#sat&two_ends=[[4,5.5],[6,7],[8,9]]'")
        wait_until(page, "lab.ends.length === 3")
        for wrong in ("[[4],[5,6]]", "[]", "[[0,null]]", "7"):
            page.evaluate(f"location.hash = '#sat&two_ends={wrong}'")
            readout(page)
            assert page.evaluate("lab.ends") == [[4, 5.5], [6, 7], [8, 9]]
