"""What is laid over a picture: arrows, discs and cells where they belong."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from pymunk_dragon.drawing import Camera, Film, Palette, Snapshot, still
from pymunk_dragon.drawing.film.layout import Canvas, lay_out
from pymunk_dragon.drawing.palette import BLOCK, CODES, STRENGTHS, TRANSPARENT, TYPE_RAMP, blends, index_of
from pymunk_dragon.drawing.snapshots import sample, snapshots
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.contact import Contact, ContactEvent, ContactLog
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.physics import simulate

MARCH = March(Dragon(benches=16), turns=4)
HEAD = Camera(follow="head", span=4.0)
PALETTE = Palette()


@pytest.fixture(scope="module")
def run() -> Run:
    return Run.exact(MARCH, np.linspace(0, 10, 1001))


@pytest.fixture(scope="module")
def brushing() -> Run:
    """16 benches that an engine plays on past their first contacts."""
    return simulate(March(Dragon(benches=16), turns=8), start=77.5, until=84.5, contacts="report")


def snapshot_of(source: Any, time: float, *marks: Any) -> Snapshot:
    [snapshot] = snapshots(source, np.array([time]), marks)
    return snapshot


def canvas_of(source: Run | March, film: Film, times: NDArray[np.float64]) -> Canvas:
    return lay_out([sample(source, times, film.show, extent=film.camera.follow == "field")], film)


def shown(source: Any, time: float, film: Film) -> tuple[NDArray[np.uint8], Any]:
    """A picture, and where points of the ground lie on it."""
    view = canvas_of(source, film, np.array([time])).scenes[0].view(snapshot_of(source, time).poses)
    return still(source, time, film), lambda points: view.pixels(points) / BLOCK


def has(picture: NDArray[np.uint8], xy: Any, accent: str) -> bool:
    """Whether the pixel at `xy` or one beside it has the full colour of an accent."""
    x, y = (int(v) for v in xy)
    patch = picture[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2]
    return bool(np.any(np.all(patch == PALETTE.rgb(accent), axis=-1)))


def on_the_ground(accent: Any) -> list[NDArray[np.float64]]:
    """Colours of an accent's strengths on bare ground."""
    return [(1 - s) * PALETTE.rgb("background") + s * PALETTE.rgb(accent) for s in STRENGTHS[accent]]


# Palette


@pytest.mark.parametrize("accent", ["motion", "force", "grid"])
def test_an_accent_over_a_colour_is_their_mean_in_its_strength(accent: Any) -> None:
    table = blends(accent)
    ground = {"background", "curve"}
    for name, code in CODES.items():
        assert table[0, code] == code
        for level, strength in enumerate(STRENGTHS[accent], start=1):
            expected = (1 - strength) * PALETTE.rgb(name) + strength * PALETTE.rgb(accent)
            if accent == "grid" and name not in ground:
                expected = PALETTE.rgb(name)
            assert np.abs(PALETTE.table[table[level, code]] - expected).max() <= 0.5


def test_blends_have_indices_of_their_own() -> None:
    used = {index_of((name,) * BLOCK**2) for name in CODES} | {*TYPE_RAMP, TRANSPARENT}
    for accent in ("motion", "force"):
        partial = {int(i) for row in blends(accent)[1:-1] for code in CODES.values() for i in [row[code]]}
        assert len(partial) == 3 * len(CODES)
        assert not partial & used
        used |= partial


def test_full_strength_covers_whatever_was_there() -> None:
    for accent in ("motion", "force"):
        assert len(set(blends(accent)[-1].tolist())) == 1


# Velocities


def test_an_arrow_points_to_where_the_handle_would_be_in_half_a_second() -> None:
    film = Film(size=600, until=3.0, camera=HEAD, gap=False, show=("velocities",))
    picture, place = shown(MARCH, 3.0, film)
    states = MARCH.at([3.0])
    for handle in (0, 1):
        begin, velocity = states.positions[0, handle], states.velocities[0, handle]
        for share in (0.3, 0.6, 0.95):
            assert has(picture, place(begin + 0.5 * share * velocity), "motion")
        assert not has(picture, place(begin + 0.5 * 1.1 * velocity), "motion")


def test_velocities_of_a_run_are_those_of_its_frames(run: Run) -> None:
    exact = MARCH.at([4.321]).velocities[0]
    found = snapshot_of(run, 4.321, "velocities").velocities
    np.testing.assert_allclose(found, exact, atol=2e-3)


def test_a_run_of_one_frame_moves_only_where_its_velocities_are_known() -> None:
    run = Run.exact(MARCH, [1.0])
    found = snapshot_of(run, 1.0, "velocities").velocities
    np.testing.assert_allclose(found, MARCH.at([1.0]).velocities[0], atol=1e-12)
    unknown = snapshot_of(replace(run, pose_velocities=None), 1.0, "velocities").velocities
    assert unknown is not None
    assert not unknown.any()


# Grid


def test_cells_are_dark_where_a_bench_touches_them() -> None:
    film = Film(size=600, until=3.0, gap=False, show=("grid",))
    picture, place = shown(MARCH, 3.0, film)
    cell, left, top = 0.55, -4 * 0.55, 4 * 0.55
    benches = shapely.union_all([shapely.Polygon(c) for c in MARCH.dragon.outlines(MARCH.at([3.0]).poses[0])])
    level, _ = on_the_ground("grid")
    checked = {True: 0, False: 0}
    for i in range(8):
        for j in range(8):
            square = shapely.box(left + j * cell, top - (i + 1) * cell, left + (j + 1) * cell, top - i * cell)
            corners = place(np.array(square.exterior.coords))
            (x0, y0), (x1, y1) = np.ceil(corners.min(axis=0)) + 1, np.floor(corners.max(axis=0)) - 1
            inside = picture[int(y0) : int(y1), int(x0) : int(x1)].reshape(-1, 3)
            filed = benches.intersects(square)
            wanted, other = (level, PALETTE.rgb("background")) if filed else (PALETTE.rgb("background"), level)
            if np.any(np.all(inside == np.rint(wanted), axis=-1)):
                checked[filed] += 1
            assert not np.any(np.all(inside == np.rint(other), axis=-1))
    assert checked[True] > 20
    assert checked[False] > 5


def test_lines_stand_at_the_sides_of_the_cells() -> None:
    film = Film(size=600, until=3.0, gap=False, legend=False)
    plain, place = shown(MARCH, 3.0, film)
    picture, _ = shown(MARCH, 3.0, replace(film, show=("grid",)))
    _, line = on_the_ground("grid")
    # The time and the speed are in the first 40 rows.
    for side in range(1, 8):
        x, y = place([-4 * 0.55 + side * 0.55, 4 * 0.55 - side * 0.55])
        for column_or_row in (np.s_[40:, round(x)], np.s_[round(y), :]):
            bare = np.all(plain[column_or_row] == PALETTE.rgb("background"), axis=-1)
            assert bare.sum() > 50
            assert np.all(picture[column_or_row][bare] == np.rint(line))


def test_cells_too_small_to_see_are_left_out() -> None:
    film = Film(size=100, until=3.0, camera=Camera(span=50.0))
    np.testing.assert_array_equal(still(MARCH, 3.0, film), still(MARCH, 3.0, replace(film, show=("grid",))))


# Contacts and normals


def a_contact(run: Run, time: float) -> Contact:
    x, y = run.march.dragon.outlines(run.poses_at([time])[0])[0, 2]
    return Contact(time=time, raw_time=time, benches=(0, 9), point=(float(x), float(y)), normal=(0.6, 0.8), depth=0.0)


def test_a_contact_has_its_point_and_its_normal(run: Run) -> None:
    touching = replace(run, first_contact=a_contact(run, 5.0), outcome="contact")
    film = Film(size=600, camera=HEAD, gap=False, show=("contacts", "normals"))
    picture, place = shown(touching, 5.0, film)
    x, y = place(touching.first_contact.point)
    assert has(picture, (x, y), "force")
    assert has(picture, (x + 0.6 * 30, y - 0.8 * 30), "force")
    assert not has(picture, (x - 0.6 * 15, y + 0.8 * 15), "force")
    before, _ = shown(touching, 4.9, film)
    assert not np.any(np.all(before == PALETTE.rgb("force"), axis=-1))


def test_benches_touch_in_pictures_as_long_as_the_callbacks_say(brushing: Run) -> None:
    windows = [window for window in brushing.events.windows() if window.end is not None]
    assert windows
    substep = brushing.substep
    for window in windows[:5]:
        inside = snapshot_of(brushing, (window.begin + window.end) / 2, "contacts")
        others = [w for w in brushing.events.windows() if w is not window]
        assert inside.touches
        after = window.end + 2 * substep
        if all(not w.begin - substep <= after <= (w.end or np.inf) + 2 * substep for w in others):
            assert not snapshot_of(brushing, after, "contacts").touches


def test_two_points_of_a_contact_are_both_shown(run: Run) -> None:
    event = ContactEvent(
        time=5.0, phase="pre_solve", benches=(0, 9), points=((1.0, 2.0), (1.5, 2.0)), normal=(0.0, 1.0), depth=0.0
    )
    found = replace(run, events=ContactLog((event,)), provenance={"substep": 0.01})
    assert snapshot_of(found, 5.0, "contacts").touches[0].points == ((1.0, 2.0), (1.5, 2.0))
    assert snapshot_of(found, 5.1, "contacts").touches == ()
    assert snapshot_of(found, 5.0).touches == ()


# Joint impulses


def test_the_area_of_a_disc_is_in_proportion_to_the_impulse(run: Run) -> None:
    impulses = np.full((len(run.times), 15), 1.0)
    impulses[:, 0] = 4.0
    pulling = replace(run, joint_impulses=impulses)
    film = Film(size=1200, camera=Camera(follow="head", span=8.0), gap=False, show=("impulses",))
    picture, place = shown(pulling, 5.0, film)
    _, rear = MARCH.dragon.holes(pulling.poses_at([5.0])[0])
    forces = np.all(picture == PALETTE.rgb("force"), axis=-1)
    areas = []
    for x, y in place(rear[:2]):
        areas.append(forces[int(y) - 40 : int(y) + 40, int(x) - 40 : int(x) + 40].sum())
    assert areas[0] / areas[1] == pytest.approx(4.0, rel=0.1)


def discs_of(source: Any, time: float) -> int:
    """Pixels of discs in a picture."""
    film = Film(size=400, camera=Camera(follow="head", span=8.0), gap=False, show=("impulses",))
    return int(np.all(still(source, time, film) == PALETTE.rgb("force"), axis=-1).sum())


def pulling(run: Run, impulse: float) -> Run:
    return replace(run, joint_impulses=np.full((len(run.times), 15), impulse))


def test_discs_are_there_between_two_frames_and_after_the_last() -> None:
    slow = pulling(Run.exact(MARCH, np.linspace(0, 10, 5)), 2.0)
    assert discs_of(slow, 2.5) > 100
    assert discs_of(slow, 3.3) > 100
    longer = pulling(Run.exact(MARCH, np.linspace(0, 14, 5)), 2.0)
    assert discs_of([longer, slow], 13.0) > 1.5 * discs_of(longer, 13.0)


def test_discs_side_by_side_have_one_scale(run: Run) -> None:
    film = Film(size=600, camera=Camera(follow="head", span=8.0), gap=False, show=("impulses",))
    picture = still([pulling(run, 4.0), pulling(run, 1.0)], 5.0, film)
    forces = np.all(picture == PALETTE.rgb("force"), axis=-1)
    assert forces[:, :600].sum() / forces[:, -600:].sum() == pytest.approx(4.0, rel=0.15)


def test_lines_that_would_meet_are_not_both_written(run: Run) -> None:
    wide, narrow = (
        still(pulling(run, 2.0), 5.0, Film(size=size, camera=HEAD, show=("impulses",))) for size in (440, 150)
    )
    # The lower right corner is the label's where there is room for it, and else the picture's.
    label = wide[-8:, -8:].reshape(-1, 3)
    assert np.all(label == PALETTE.rgb("background"))
    plain = still(run, 5.0, Film(size=150, camera=HEAD))
    np.testing.assert_array_equal(narrow[-6:, -6:], plain[-6:, -6:])


def test_impulses_between_frames_are_those_of_the_frame_before(run: Run) -> None:
    impulses = np.repeat(np.arange(len(run.times), dtype=float)[:, None], 15, axis=1)
    pulling = replace(run, joint_impulses=impulses)
    for time, frame in ((0.0, 0), (0.0149, 1), (9.999, 999), (10.0, 1000)):
        assert snapshot_of(pulling, time, "impulses").impulses[0] == frame


@pytest.mark.parametrize("mark", ["contacts", "normals", "impulses", "shadows"])
def test_a_mark_that_a_march_cannot_have_is_bad_input(mark: Any) -> None:
    with pytest.raises(ParameterError, match=f"show is '{mark}'"):
        still(MARCH, 1.0, Film(show=(mark,)))
