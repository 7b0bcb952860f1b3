"""The figures that README and the docstrings quote: `python tests/bench/bench.py [NAME ...]`.

`BENCHMARKS` has all of them but those of live sessions, which are in `bench_live.py`. Times are
medians.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial, reduce
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
from imageio import v3 as imageio
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from measure import compare, nothing, run, sized, spread
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1]))
import exact_curves
import oracle

from pymunk_dragon import (
    Dragon,
    EngineSettings,
    Film,
    Grid,
    March,
    Run,
    UTurn,
    World,
    first_contact,
    joint_forces,
    pull,
    separation,
)
from pymunk_dragon._arrays import Array
from pymunk_dragon._extras import library
from pymunk_dragon.drawing import render
from pymunk_dragon.drawing.debug_draw import PillowDrawOptions
from pymunk_dragon.drawing.film.layout import Layout
from pymunk_dragon.drawing.film.take import checked_sources, takes_of_film
from pymunk_dragon.drawing.film.timing import frame_times
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.physics import simulate
from pymunk_dragon.player import write_player
from pymunk_dragon.studies import max_speed, min_pitch
from pymunk_dragon.sweeps import sweep

# Pixels of a picture.
SIZE = 640
# Frames a second of a film.
FPS = 20


def answers() -> None:
    """The answers of `studies` and of independent methods in 34 to 50 digits; time of both, s."""
    text = {
        "width": "0.3",
        "overhang": "0.275",
        "head_spacing": "2.86",
        "body_spacing": "1.65",
        "pitch": "0.55",
    }
    sizes = {name: mp.mpf(value) for name, value in text.items()}
    chain = {
        "benches": 223,
        "head_spacing": 2.86,
        "body_spacing": 1.65,
        "pitch": 0.55,
        "turns": 16,
        "speed": 1,
    }

    def row(
        question: str, ours: Callable[[], Any], theirs: Callable[[], mp.mpf], method: str
    ) -> None:
        begin = time.perf_counter()
        one = mp.mpf(ours())
        between = time.perf_counter()
        other = theirs()
        end = time.perf_counter()
        decimals = int(-mp.log10(max(abs(one - other), mp.mpf("1e-16"))))
        shown = f"{mp.nstr(one, 13)} | {mp.nstr(other, 13)} | {decimals} | {between - begin:.2f}"
        print(f"| {question} | {shown} | {method}, {end - between:.1f} |", flush=True)

    def last_handle() -> mp.mpf:
        return oracle.solve(300, **chain, difference=False)[0][-1][0]

    def smallest_pitch() -> mp.mpf:
        return oracle.grazing((0, 19), "216.34", sizes | {"pitch": mp.mpf("0.45034")})[1]

    positions = partial(March().at, np.arange(301.0))
    row(
        "1, x of handle 223 at 300 s, m",
        lambda: positions().positions[300, -1, 0].item(),
        last_handle,
        "50 digits",
    )
    touching = partial(oracle.touching, (0, 8), "412.47", sizes)
    row("2, first contact, s", lambda: first_contact(March()).time, touching, "root in 50 digits")
    row(
        "3, smallest pitch, m",
        lambda: min_pitch().pitch,
        smallest_pitch,
        "grazing moment in 50 digits",
    )
    with mp.workdps(exact_curves.DIGITS):
        turn = partial(exact_curves.s_turn, mp.mpf("1.7"), mp.mpf("4.5"), mp.mpf(2))
        row(
            "4, length of the turn, m",
            lambda: UTurn().length,
            lambda: turn()[-1],
            "tangency in 34 digits",
        )
        row(
            "5, largest speed, m/s",
            lambda: max_speed().speed,
            largest_speed,
            "its maximum in 34 digits",
        )


def largest_speed() -> mp.mpf:
    """The ratio at its top, where it is as large a little before as a little behind."""
    path = exact_curves.u_turn()
    spacings = Dragon().spacings[:3]
    tiny = mp.mpf("1e-12")

    def ratio(way: mp.mpf) -> mp.mpf:
        before, after = (
            exact_curves.walked_chain(path, way + sign * tiny, spacings)[-1] for sign in (-1, 1)
        )
        return (after - before) / (2 * tiny)

    step, ends = mp.mpf("1e-4"), (mp.mpf("14.47"), mp.mpf("14.49"))
    return 2 / ratio(
        mp.findroot(
            lambda at: ratio(at + step) - ratio(at - step), ends, solver="anderson", tol=1e-12
        )
    )


def plain_recursion(times: Array) -> tuple[Array, Array]:
    """Complex positions and speeds (T, 224) of the reference march: fastest known with NumPy.

    Newton's method (paper, eq. 10-15) on the angle between two handles begins at the angle between
    the two before.
    """
    dragon = Dragon()
    k = 0.55 / (2 * np.pi)
    start = 32 * np.pi
    arc = start * np.hypot(start, 1) + np.arcsinh(start) - 2 * times / k
    front = np.sqrt(arc)
    for _ in range(4):
        rise = np.hypot(front, 1)
        front = front - (front * rise + np.arcsinh(front) - arc) / (2 * rise)
    angles, speeds = np.empty((dragon.handles, times.size)), np.ones((dragon.handles, times.size))
    angles[0], turn = front, front
    for i, chord in enumerate(dragon.spacings / k):
        turn = chord / np.hypot(front, 1) if i < 2 else turn - turn * turn / front
        for _ in range(3 if i > 1 else 6):
            rear = front + turn
            cosine = np.cos(turn)
            product = front * (front + turn)
            error = rear * rear + front * front - 2 * product * cosine - chord * chord
            turn = turn - error / (2 * (rear - front * cosine + product * np.sin(turn)))
        rear = front + turn
        cosine = np.cos(turn)
        both = front * (front + turn) * np.sin(turn)
        ratio = (rear * cosine - front + both) / (rear - front * cosine + both)
        speeds[i + 1] = speeds[i] * ratio * np.sqrt((1 + rear * rear) / (1 + front * front))
        angles[i + 1] = front = rear
    return (k * angles * np.exp(1j * angles)).T, speeds.T


def march() -> None:
    """Processor time of positions and velocities of 301 times x 224 handles (`model`)."""
    times, march = np.linspace(0.0, 300.0, sized(301, 3)), March()
    works = {"plain recursion with NumPy": lambda: plain_recursion(times)}
    compare(works | {"March.at": lambda: march.at(times)}, sized(60, 1), time.process_time)
    apart = np.abs(plain_recursion(times)[0] - march.motion(times).points).max()
    print(f"They differ by at most {apart:.1e} m.")


def contact() -> None:
    """The first contact of 223 benches, the broad phase, and the whole process (`collision`)."""
    march = March()
    grid, corners = Grid.of(march), march.dragon.outlines(march.at(0.0).poses[0])
    command = [sys.executable, "-m", "pymunk_dragon", "contact"]
    works = {
        "first_contact": lambda: first_contact(March()),
        "filing and pairing": lambda: grid.pairs(corners),
        "process": lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL),
    }
    compare(works, sized(15, 1))


BOX = Dragon(benches=2, head_spacing=1.65)  # two boxes of the size of a bench


def gaps(first: Array, last: Array, shares: Array) -> Array:
    """Distances (C,) of boxes, m, at `shares` (C,) of the way from `first` (C, 2, 3) to `last`."""
    corners = BOX.outlines(first + shares[:, None, None] * (last - first))
    return separation(corners[:, 0], corners[:, 1]).distance


def advanced(first: Array, last: Array) -> Array:
    """Share of the way to each contact, or infinity, by conservative advancement to 0.1 mm."""
    moves = last - first
    shares = np.zeros(len(first))
    left = np.arange(len(first))
    most = np.hypot(*(moves[:, 1] - moves[:, 0])[:, :2].T)
    most += np.hypot(BOX.lengths[0], BOX.widths[0]) / 2 * np.abs(moves[..., 2]).sum(axis=1)
    while left.size:
        gap = gaps(first[left], last[left], shares[left])
        shares[left] += gap / most[left]
        left = left[(gap > 1e-4) & (shares[left] < 1)]
    return np.where(shares < 1, shares, np.inf)


def time_of_impact() -> None:
    """Contacts that Box2D misses or finds late (`renders/guides/certificate.md`)."""
    import Box2D  # Not for every Python.

    shape = Box2D.b2PolygonShape(box=(BOX.lengths[0] / 2, BOX.widths[0] / 2))
    random = np.random.default_rng(1)

    def impact(first: Array, last: Array) -> float:
        one, other = (
            Box2D.b2Sweep(c0=p[:2], a0=p[2], c=q[:2], a=q[2])
            for p, q in zip(first, last, strict=True)
        )
        state, share = Box2D.b2TimeOfImpact(
            shapeA=shape, shapeB=shape, sweepA=one, sweepB=other, tMax=1.0
        )
        return (
            share
            if state in (Box2D.b2TOIOutput.e_touching, Box2D.b2TOIOutput.e_overlapped)
            else np.inf
        )

    cases, count = sized(20_000, 200), sized(501, 21)
    heads = ["turn up to, rad", "contacts deeper than 20 mm", "missed by Box2D", "late"]
    print("|", " | ".join([*heads, "missed by advancement"]), "|")
    for turn in (0.0, 0.5, 1.0, 1.57, 3.0):
        first = np.zeros((cases, 2, 3))
        first[:, 1, :2] = random.uniform(-3, 3, (cases, 2))
        first[..., 2] = random.uniform(0, 2 * np.pi, (cases, 2))
        last = first + random.uniform(-1, 1, first.shape) * (1, 1, turn)
        samples = np.stack(
            [gaps(first, last, np.full(cases, share)) for share in np.linspace(0, 1, count)]
        )
        deep = (samples[0] > 0.03) & (samples.min(axis=0) < -0.02)
        first = first[deep]
        last = last[deep]
        begins = (samples[:, deep] <= 0).argmax(axis=0) / (count - 1)
        theirs = np.array(
            [impact(*case) for case in zip(first.tolist(), last.tolist(), strict=True)]
        )
        missed, late = np.isinf(theirs), np.isfinite(theirs) & (theirs > begins + 0.01)
        ours = (advanced(first, last) > begins).sum()
        share = f"{missed.sum()}, {missed.mean():.1%}"
        print(f"| {turn} | {deep.sum()} | {share} | {late.sum()} | {ours} |")


def engine() -> None:
    """The engine from t = 0 to the first contact (`physics`), and its page (`player`)."""
    played, exact = simulate(March(), until=sized(415.0, 0.2)), first_contact(March()).time or 0.0
    found = played.to_dict()
    late = played.first_contact.time - exact if played.first_contact else np.nan
    print(
        f"{found['realtime_factor']:.1f} times real time, "
        f"driver {found['driver_overhead']:.2f} of the steps, "
        f"drift {1e3 * played.head_drift:.4f} mm and {1e3 * played.max_drift:.4f} mm, "
        f"contact {1e3 * late:+.3f} ms late"
    )
    with tempfile.TemporaryDirectory() as folder:
        write_player(played, path := Path(folder, "run.html"))
        print(f"page of {len(played.times)} frames: {path.stat().st_size / 1e6:.2f} MB")


def drift() -> None:
    """Drift of the first twelve benches and of any, µm; error of the contact, ms (`physics`)."""
    march = March()
    exact = first_contact(march).time or 0.0
    rates, tries, drags = sized(
        ((25, 50, 100, 400), (10, 60), (5.0, 7.0, 9.0, 15.0, 20.0)), ((100,), (10,), (5.0,))
    )
    settings = [
        (1 / rate, iterations, EngineSettings.drag) for rate in rates for iterations in tries
    ]
    for substep, iterations, drag in [*settings, *((1 / 50, 10, drag) for drag in drags)]:
        chosen = EngineSettings(substep=substep, iterations=iterations, drag=drag)
        played = simulate(march, settings=chosen, start=sized(400.0, 412.0), until=414.0)
        found = played.first_contact
        ending = f"benches {found.benches}, {1e3 * (found.time - exact):+.3f}" if found else "none"
        row = f"{1e6 * played.head_drift:.2f} | {1e6 * played.max_drift:.2f} | {ending}"
        print(f"| 1/{1 / substep:.0f} s | {iterations} | drag {drag:g} | {row} |", flush=True)


def pile_up() -> None:
    """Joint gaps, overlaps and motion, mm, 10 s after a contact that is resolved (`physics`)."""
    march, contact = March(), 412.474
    played, rest = sized((10.0, 5.0), (0.5, 0.1))
    cases = sized(
        ((100, None), (200, 300.0), (200, None), (200, 3000.0), (400, None)), ((100, None),)
    )
    for rate, force in cases:
        chosen = EngineSettings(
            substep=1 / rate, frame_interval=1 / rate, head_force=force, contacts="resolve"
        )
        found = simulate(march, settings=chosen, start=contact - 0.5, until=contact + played)
        assert found.first_contact is not None
        assert found.settings is not None
        front, rear = march.dragon.holes(found.poses[found.times >= found.first_contact.time])
        gap = np.linalg.norm(front[:, 1:] - rear[:, :-1], axis=-1).max()
        depth = max(event.depth or 0.0 for event in found.events if event.phase == "pre_solve")
        end = found.poses_at([found.times[-1] - rest, found.times[-1]])[..., :2]
        moved = np.linalg.norm(end[1] - end[0], axis=-1).max()
        print(f"| 1/{rate} s | {found.settings.head_force:.0f} | ", end="")
        print(f"{1e3 * gap:.3f} | {1e3 * depth:.3f} | {1e3 * moved:.2f} |", flush=True)


def imageio_rgb(run: Run, film: Film, path: Path) -> None:
    """The default of imageio: a stack of RGB frames, drawn as ours are."""
    takes = takes_of_film(checked_sources(run), film)
    layout = Layout(takes, frame_times(takes, film).times, film)
    stack = np.stack([np.asarray(frame) for frame in layout.frames()])
    imageio.imwrite(path, stack, duration=1000 / FPS, loop=0)


def matplotlib_animation(run: Run, film: Film, path: Path) -> None:
    """FuncAnimation and PillowWriter of matplotlib with axes and a title, as they come."""
    times = frame_times(takes_of_film(checked_sources(run), film), film).times
    march, palette = run.march, Palette()
    figure = Figure(figsize=(SIZE / 100, SIZE / 100), dpi=100)
    axes = figure.add_subplot(aspect="equal", xlim=(-11.5, 11.5), ylim=(-11.5, 11.5))
    axes.plot(
        *march.curve.point(np.linspace(*march.span(times[0], times[-1]), 5000)).T,
        color=palette.curve,
        lw=0.5,
    )
    benches = PolyCollection([], facecolors=palette.body, edgecolors=palette.ink, linewidths=0.5)
    axes.add_collection(benches)
    clock = axes.set_title("")

    def draw(frame: int) -> None:
        benches.set_verts([*march.dragon.outlines(run.poses_at(times[frame])[0])])
        clock.set_text(f"t = {times[frame]:.2f} s")

    FuncAnimation(figure, draw, frames=len(times)).save(str(path), writer=PillowWriter(fps=FPS))


def film() -> None:
    """GIF of 300 frames of 640 x 640 pixels (`drawing`)."""
    count = sized(300, 4)
    start = 100.0
    step = 0.5
    times = start + step * np.arange(count)
    run = Run.exact(March(), times)
    film = Film(
        size=SIZE, fps=FPS, speedup=FPS * step, start=start, until=times[-1], hold=0.0, legend=False
    )
    with tempfile.TemporaryDirectory() as folder:
        ways: dict[str, Callable[[Path], object]] = {"render": lambda path: render(run, path, film)}
        ways |= {
            way.__name__: partial(way, run, film) for way in (imageio_rgb, matplotlib_animation)
        }
        works = {name: partial(way, Path(folder, f"{name}.gif")) for name, way in ways.items()}
        for name, value in compare(works, sized(3, 1)).items():
            size = Path(folder, f"{name}.gif").stat().st_size / 1e6
            print(f"| {name} | {value / count:.1f} ms a frame | {size:.1f} MB |")


def debug_draw() -> None:
    """Processor time of a picture of 223 benches and their pivots (`drawing.debug_draw`)."""
    from pymunk import BB, matplotlib_util  # It loads all of matplotlib.pyplot.

    space = World(March(), start=300.0, guide="none").space
    box = reduce(BB.merge, (shape.bb for shape in space.shapes))
    options = PillowDrawOptions(Image.new("RGB", (SIZE, SIZE)), positive_y_is_up=True)
    options.fit(space)

    def with_pillow() -> None:
        options.image = Image.new("RGB", (SIZE, SIZE), "white")
        space.debug_draw(options)

    def with_matplotlib() -> None:
        canvas: Any = FigureCanvasAgg(Figure(figsize=(SIZE / 100, SIZE / 100), dpi=100))
        axes = canvas.figure.add_axes(
            (0, 0, 1, 1), xlim=(box.left, box.right), ylim=(box.bottom, box.top), aspect="equal"
        )
        with warnings.catch_warnings(action="ignore", category=DeprecationWarning):
            space.debug_draw(matplotlib_util.DrawOptions(axes))
        canvas.draw()

    compare(
        {"Pillow": with_pillow, "pymunk.matplotlib_util": with_matplotlib},
        sized(9, 1),
        time.process_time,
    )


def sweep_seconds(points: int, scheduler: str | None) -> float:
    """Wall time of a sweep of the quantity of no work, s."""
    axes = {
        "pitch": np.linspace(0.5, 0.6, points // 10).tolist(),
        "overhang": np.linspace(0.1, 0.2, 10).tolist(),
    }
    with tempfile.TemporaryDirectory() as folder:
        table, short = Path(folder, "table.csv"), {"benches": 2, "turns": 8}
        return sweep(short, axes, nothing, out=table, scheduler=scheduler, workers=2).seconds


def sweep_overhead() -> None:
    """Time of a point of no work, ms, without the start of the workers (`sweeps`)."""
    count = sized(1000, 20)
    local = library(
        "distributed"
    ).LocalCluster  # Its workers log errors when it ends before they do.
    with local(
        n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs="CRITICAL"
    ) as cluster:
        for name, where in (("processes", None), ("Dask", cluster.scheduler_address)):
            found = [
                1e3 * (sweep_seconds(2 * count, where) - sweep_seconds(count, where)) / count
                for _ in range(sized(3, 1))
            ]
            print(f"{name}: {spread(found, 2)}", flush=True)


def sweep_efficiency() -> None:
    """Speed of two workers over twice that of one, 200 contact times (`sweeps`)."""
    axes = {
        "pitch": np.linspace(0.45, 0.75, sized(20, 2)).tolist(),
        "width": np.linspace(0.2, 0.4, sized(10, 1)),
    }
    times = [
        [sweep(None, axes, workers=count).seconds for count in (1, 2)] for _ in range(sized(3, 1))
    ]
    print(spread([one / (2 * two) for one, two in times], 3))


def sweep_map() -> None:
    """10,000 contact times on two workers (`sweeps`)."""
    side = sized(100, 2)
    axes = {
        "pitch": np.linspace(0.4, 0.8, side).tolist(),
        "width": np.linspace(0.2, 0.4, side).tolist(),
    }
    with tempfile.TemporaryDirectory() as folder:
        found = sweep(None, axes, out=Path(folder, "map.csv"), workers=2)
    print(f"{found.points} points: {found.seconds / 60:.1f} minutes, {found.failed} failed")


def errors_of_tolerances() -> None:
    """Largest position error of frames, m, and error of the contact, s, by tolerance."""
    turn = March(Dragon(benches=sized(100, 6)), UTurn(), start_s=-2.0)
    cases = [(March(), sized(11.0, 1.0)), (turn, sized(20.0, 3.0))]
    best = [pull(each, until=until, tolerance=1e-12) for each, until in cases]
    for tolerance in (1e-4, 1e-6, 1e-9, 1e-11):
        row = f"| {tolerance:g} | "
        for (each, until), known in zip(cases, best, strict=True):
            found = pull(each, until=until, tolerance=tolerance)
            common = np.intersect1d(found.times, known.times)
            apart = found.poses_at(common)[..., :2] - known.poses_at(common)[..., :2]
            row += f"{np.linalg.norm(apart, axis=-1).max():.1e} | "
            one, other = found.first_contact, known.first_contact
            row += f"{abs(one.time - other.time):.1e} | " if one and other else "- | "
        print(row, flush=True)


def pulled() -> None:
    """First contacts of the pulled dragon by drag, and forces in its joints (`dynamics`)."""
    for drag in sized((0.0, 0.25, 0.5, 1.0, 11.5, 200.0), (11.5,)):
        found = pull(March(), until=sized(13.0, 0.2), drag=drag)
        touch = found.first_contact
        print(f"| {drag:g} | {touch and touch.benches} | {touch and round(touch.time, 9)} |")
    times = [5.0, 100.0, 400.0]
    for push in (True, False):
        print(f"push {push}: {joint_forces(March(), times, push=push)[:, 0].round(3)} N")
    found = pull(March(), until=sized(5.0, 0.2))
    assert found.joint_forces is not None
    forces = found.joint_forces[:, 0]
    print(f"pulled: {forces[-1]:.2f} N, at most {forces.max():.0f} N", end=" ")
    print(f"at {found.times[forces.argmax()]:.1f} s")


def pull_speed() -> None:
    """Processor time of `simulate` and `pull` for 1,000 benches and 10.8 s (`dynamics`)."""
    march = March(Dragon(benches=sized(1000, 5)))
    until = sized(10.8, 0.2)
    works = {
        "simulate": partial(simulate, march, guide="none", until=until),
        "pull": partial(pull, march, until=until, tolerance=1e-6),
    }
    compare(works, sized(7, 1), time.process_time)


def sweep_points() -> None:
    """Processor time of a point of two maps on one thread, ms (`sweeps`)."""
    maps: dict[str, Any] = {
        "pitch x width": {"width": np.linspace(0.2, 0.4, sized(50, 1)).tolist()},
        "pitch x head_spacing": {"head_spacing": np.linspace(2.2, 3.4, sized(5, 1)).tolist()},
    }
    for name, other in maps.items():
        axes = {"pitch": np.random.default_rng(5).uniform(0.4, 0.8, sized(5, 1)).tolist()} | other
        begin = time.process_time()
        found = sweep(None, axes, executor=ThreadPoolExecutor(1))
        print(f"{name}: {1e3 * (time.process_time() - begin) / found.points:.0f} ms a point")


OF_MOTION = (answers, march, contact, time_of_impact, engine, drift, pile_up)
OF_DYNAMICS = (errors_of_tolerances, pulled, pull_speed)
OF_PICTURES = (film, debug_draw)
OF_SWEEPS = (sweep_overhead, sweep_efficiency, sweep_map, sweep_points)
BENCHMARKS = {
    each.__name__.replace("_", "-"): each
    for each in (*OF_MOTION, *OF_DYNAMICS, *OF_PICTURES, *OF_SWEEPS)
}

if __name__ == "__main__":
    run(BENCHMARKS)
