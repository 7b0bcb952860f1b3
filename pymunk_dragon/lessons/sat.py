"""The separating axis theorem for two benches."""

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from numpy.typing import NDArray

from pymunk_dragon import outlines, separation
from pymunk_dragon.drawing.figures.style import AMBER, BLUE, COLOURS
from pymunk_dragon.lessons import Lesson

lesson = Lesson("sat", "From how many sides must one look?", order=40)

lesson.question(
    "Two benches are rectangles, 2.20 m long and 0.30 m wide, at any angle to each other. How does a program find out, "
    "from nothing but their corners, whether they touch?"
)
lesson.predict(
    "Shine a lamp on both, and look at their shadows on the wall behind. If there is light between the shadows, the "
    "benches are apart.",
    ("From how many directions must you look to be sure?", "2", "4", "8", "all around"),
)

length, width, aside, ahead = 2.20, 0.30, 1.60, 0.90  # m; so far aside and ahead of the blue bench the amber one turns
names = ["blue, along", "blue, across", "amber, along", "amber, across"]


def shadows(degrees: float) -> tuple[NDArray[np.float64], ...]:
    """Both benches, the axes along their edges, where the shadows on these begin and end, and the gaps between them."""
    poses = [(-aside / 2, -ahead / 2, 0), (aside / 2, ahead / 2, np.radians(degrees))]
    benches = outlines(poses, [length, length], width)  # (2 benches, 4 corners, x and y)
    axes = ((benches[:, [1, 3]] - benches[:, [0]]) / [[length], [width]]).reshape(4, 2)
    seen = benches @ axes.T  # how far each corner is along each axis
    begins, ends = seen.min(axis=1), seen.max(axis=1)
    return benches, axes, begins, ends, np.maximum(begins[1] - ends[0], begins[0] - ends[1])


# The widest of the four gaps, and what the library says of the same benches. A gap below zero is an overlap.
for turn in range(30, 180, 30):
    benches, *_, gaps = shadows(turn)
    found = separation(*benches).distance
    print(f"{turn:3} deg  widest gap {gaps.max():7.4f} m  {names[gaps.argmax()]:13}  separation {found:7.4f} m")

figure, floor = lesson.subplots(figsize=(5.2, 5.2))


def draw(degrees: float) -> None:
    """The benches, below them their shadows, and through the widest gap a dashed line along the bench's other axis."""
    benches, axes, begins, ends, gaps = shadows(degrees)
    best, apart = int(gaps.argmax()), gaps.max() > 0
    floor.clear()
    floor.set(xlim=(-2.1, 2.1), ylim=(-2.5, 1.7), xticks=[], yticks=[], frame_on=False)
    floor.text(-2, 1.5, f"{degrees} degrees: {'apart' if apart else 'no gap, they overlap'}")
    foot = axes[best] * (begins[:, best].max() + ends[:, best].min()) / 2
    floor.axline(foot, foot + axes[[1, 0, 3, 2][best]], color=COLOURS.contact, ls="--", alpha=float(apart), zorder=0)
    floor.axhspan(-2.5, -0.75, color=COLOURS.background)
    for bench, colour in enumerate((BLUE, AMBER)):
        floor.fill(*benches[bench].T, color=colour)
        floor.hlines(-1.02 - 0.4 * np.arange(4) - 0.09 * bench, begins[bench], ends[bench], colour, lw=6)
    for row, gap in enumerate(gaps):
        colour = COLOURS.contact if apart and row == best else COLOURS.ink
        floor.text(-2, -0.93 - 0.4 * row, f"{names[row]}: gap {gap:.2f} m", color=colour)


film = lesson.file(".gif")
FuncAnimation(figure, draw, range(2, 180, 4)).save(film, PillowWriter(fps=8), dpi=75)
lesson.show(film)

lesson.picture("The amber bench turns; below, the shadows of both along and across each bench.")
lesson.answer(
    "Four are enough: where two rectangles are apart, a straight line fits between them, which can be shifted and "
    "turned until it runs along an edge of one of them, and the edges of both run in only four directions. As long "
    "as one of the four axes shows a gap they are apart, and it may be just one, as at 120 degrees; at 60 none is "
    "left.",
    ("4", "along and across each bench"),
)
lesson.check(
    "The gap at 30 degrees, 0.0701 m: the middle of the amber bench is 0.90 m above that of the blue one; take off "
    r"half the blue width, 0.15 m, and half the amber shadow, $1.10 \sin 30^\circ + 0.15 \cos 30^\circ$."
)
lesson.change(
    "Put `gaps = gaps[:2]` below `found`, without the amber bench's axes: at which angle is the verdict wrong? Or set "
    "`aside` and `ahead` to 1.80 and 1.00: each axis is the best at some angle, and an overlap of 9 mm is hard to see."
)
