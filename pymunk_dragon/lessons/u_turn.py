"""The length of the turn of the contest's question 4."""

import numpy as np

from pymunk_dragon import Camera, March, UTurn, render
from pymunk_dragon.lessons import Lesson

lesson = Lesson("u-turn", "Which turn is the shortest?", order=130)

lesson.question(
    "The dragon comes in on a spiral of 1.7 m a turn, goes round within a circle 9 m wide on two arcs that touch each "
    "other and both spirals, and out again. In the contest the first arc has twice the radius of the second; a rival "
    "takes two equal ones. Whose turn is shorter?"
)
lesson.predict(
    "Both dragons enter the circle at the same moment, at 1 m/s.",
    ("Which one leaves it first?", "the one with unequal arcs", "the one with equal arcs", "both at once"),
)

# The length is measured: 100,000 small steps from where the circle is entered to where it is left.
contest, rival = 2.0, 1.0
for ratio in (0.5, rival, 1.5, contest, 4.0):
    turn = UTurn(pitch=1.7, radius=4.5, ratio=ratio)
    steps = np.diff(turn.point(np.linspace(0, turn.joints[-1], 100_001)), axis=0)
    (first, second), angles = turn.radii, np.degrees(np.abs(turn.sweeps))
    print(f"radii {first:.3f} and {second:.3f} m  ", end="")
    print(f"angles {angles[0]:.3f} and {angles[1]:.3f} degrees  length {np.hypot(*steps.T).sum():.6f} m")

# Handle 0 enters the circle at t = 0.
marches = [March(curve=UTurn(ratio=ratio)) for ratio in (contest, rival)]
headings = (f"radii {contest:g} to 1", f"radii {rival:g} to 1")
film = lesson.file(".gif")
camera = Camera(span=11.5)
render(marches, film, start=-4, until=24, speedup=5, size=(220, 242), camera=camera, headings=headings)
lesson.show(film)

lesson.picture("Two dragons turn along different curves, and leave side by side.")
lesson.answer(
    "Both at once, after 13.621245 m: the head leaves opposite to where it came in, and in the same direction, so "
    "the one arc turns it by as much as the other turns it back, 173.118 degrees. Arcs of the same angle have the "
    "same shape, so both are the same number of times as long as their chords, and these share out the diameter of 9 "
    "m.",
    ("both at once", "13.621245 m each"),
)
lesson.check(
    r"The length, 13.621245 m: the path enters at $a = \arctan(2 \pi \cdot 4.5 / 1.7) = 1.510743$ radians to the "
    r"diameter, which is half the angle of an arc. So an arc is $a / \sin a$ times as long as its chord, both chords "
    r"together are 9 m, and the length is $9 a / \sin a$."
)
lesson.change(
    "Set `rival` to 2.5: the narrow arc is 2.58 m wide, and the holes of the head's bench are 2.86 m apart. In which "
    "direction does handle 1 go from t = 13 s on? Up to about which ratio does the dragon get round?"
)
