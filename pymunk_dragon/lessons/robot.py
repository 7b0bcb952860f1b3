"""A robot's arm that goes where its tip went: the dragon's code on a curve of one's own."""

import numpy as np

from pymunk_dragon import Dragon, March, first_contact, render, simulate
from pymunk_dragon.lessons import Lesson
from pymunk_dragon.model.curves import Sampled

lesson = Lesson("robot", "Does the arm reach the end of its path?", order=150, live="robot-arm")

lesson.question(
    "A snake arm looks into engines where no hand can reach: its 16 links go where the tip went before. You draw a "
    "path, and the tip follows it at a constant speed; how fast do the joints go, and does the arm block itself?"
)
lesson.predict(
    "The tip goes at 0.2 m/s along a drawn curve, with bends to both sides and a narrow loop at its end.",
    ("In a bend, how fast is a joint compared with the tip?", "half as fast", "as fast to 3 %", "twice as fast"),
    ("Does the tip get past the links that are still coming in?", "yes", "no"),
)

# Links from the tip to the base, in m: slender and short in front, wide and long behind.
arm = Dragon(
    head_spacing=0.14,
    body_spacing=[0.10] * 6 + [0.13] * 5 + [0.16] * 4,
    overhang=0.02,
    width=[0.05] * 7 + [0.06] * 5 + [0.07] * 4,
)
# The path, as points that were tapped on a screen; the smooth curve through them is what the tip follows.
points = [(-1.9, 0), (-1.6, 0), (-1.3, 0), (-1, 0), (-0.75, 0.08), (-0.5, 0.25), (-0.25, 0.3), (-0.03, 0.15)]
points += [(0.1, -0.1), (0.32, -0.25), (0.55, -0.15), (0.6, 0.1), (0.42, 0.28), (0.2, 0.22), (0.05, 0.05), (-0.1, -0.1)]
march = March(arm, Sampled(np.array(points)), speed=0.2)

# As for the dragon: does it run into itself, exactly and in Pymunk, ...
hit = first_contact(march)
run = simulate(march, frame_interval=0.1)
print(f"exact    t = {hit.time:.4f} s   " + (f"contact   links {hit.benches}" if hit.benches else "clear"))
touch = run.first_contact
print(f"engine   t = {run.times[-1]:.4f} s   " + (f"contact   links {touch.benches}" if touch else "clear"))

# ... and where is each joint, and how fast?
states = march.at(np.arange(0.1, hit.time - 0.1, 0.1))
for word, found in [("fastest", states.speeds.argmax()), ("slowest", states.speeds.argmin())]:
    now, joint = np.unravel_index(found, states.speeds.shape)
    print(f"{word}  joint {joint:2d}   t = {states.times[now]:.1f} s   {states.speeds[now, joint]:.3f} m/s")
for time in (states.times[now] - 0.1, states.times[now] + 0.1):  # where the slowest one was before, and after
    x, y = march.at(time).positions[0, joint]
    print(f"         joint {joint:2d}   t = {time:.1f} s   at ({x:.4f}, {y:.4f}) m")

film = lesson.file(".gif")
render(run, film, speedup=1, size=(540, 300))
lesson.show(film)

lesson.picture("The arm's 16 links follow the tip along a curve that was drawn by hand, until it runs into link 13.")
lesson.answer(
    "No joint is more than some 3 % faster or slower than the tip: both ends of a link go equally fast along it, so "
    "the faster one is the one that goes more across it. But after 8.668 s the tip runs into link 13, so this arm "
    "cannot follow this path.",
    ("as fast to 3 %", "0.194 m/s to 0.204 m/s"),
    ("no", "it meets link 13 at 8.6677 s"),
)
lesson.check(
    "The slowest speed of 0.194 m/s: it is printed where that joint was 0.1 s before and 0.1 s after. Divide the "
    "distance between the two positions by 0.2 s."
)
lesson.change(
    "Let `points` end in (0.1, 0.05), (0.2, 0), and the tip slips past. Then draw a path of your own: the "
    "documentation of scenario files (`make docs`) describes the file that holds a dragon and its curve, and "
    "`pymunk-dragon study` lists what else to ask."
)
