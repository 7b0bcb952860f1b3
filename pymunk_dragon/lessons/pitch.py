"""How tightly the dragon can coil."""

import numpy as np

from pymunk_dragon import Dragon, March, Spiral, min_pitch, separation
from pymunk_dragon.drawing.figures.style import AMBER, BLUE, COLOURS, QUIET
from pymunk_dragon.lessons import Lesson

lesson = Lesson("pitch", "How tight can it coil?", order=120)

lesson.question(
    "The head starts on turn 16 of the spiral and shall come to 4.5 m from its centre, without any bench touching "
    "another. With turns 0.55 m apart that is easy. How small may this pitch be, if benches are 0.30 m wide?"
)
lesson.predict(
    "Is it 0.31 m, 0.38 m or 0.45 m? And if you look once a second whether benches overlap: is the pitch that you find "
    "right, too large or too small?"
)

# The answer of the library: it proves that a billionth of a metre more is free, and as much less is not.
found = min_pitch()
contact, arrival = found.march.time([found.distance, found.arrival_distance])
print(f"smallest pitch  {found.pitch:.9f} m  benches {found.benches} touch at t = {contact:.3f} s")
print(f"the way in      {16 * found.pitch:.6f} m to 4.5 m from the centre  {arrival:.3f} s")


def smallest_gap(pitch: float, step: float) -> float:
    """The smallest gap between the head and benches 2 to 39 in mm, sampled every `step` s from 200 s on."""
    spiral = Spiral(pitch=pitch)
    march = March(Dragon(benches=40), spiral)
    arrival = spiral.at_radius(4.5) - march.head_start  # m along the spiral, and so s at 1 m/s
    benches = march.dragon.outlines(march.at(np.arange(200, arrival, step)).poses)
    return float(1000 * separation(benches[:, :1], benches[:, 2:]).distance.min())


# With a sample each second: halve the bracket, until the answer is known to a millionth of a metre.
blocked, free, look = 0.4500, 0.4505, 1.0  # m, m, s
while free - blocked > 1e-7:
    middle = (blocked + free) / 2
    blocked, free = (blocked, middle) if smallest_gap(middle, look) > 0 else (middle, free)
for step in (look, 0.01):
    print(f"each {step:4g} s     {free:.6f} m  gap {smallest_gap(free, step):.3f} mm")

figure, axes = lesson.subplots()
pitches = np.linspace(0.4502, 0.4504, 9)
for step, style, colour in ((look, "--", AMBER), (0.01, "-", BLUE)):
    axes.plot(pitches, [smallest_gap(pitch, step) for pitch in pitches], style, color=colour)
axes.text(0.45033, 0.12, f"each {look:g} s ", color=AMBER, ha="right")
axes.text(0.45029, -0.07, "each 0.01 s", color=BLUE)
axes.axhline(0, color=QUIET, lw=0.8)
for pitch, height, side in ((free, 0.01, "right"), (found.pitch, -0.022, "left")):
    axes.plot(pitch, 0, "o", color=COLOURS.ink)
    axes.text(pitch, height, f" {pitch:.6f} m ", ha=side)
axes.set(xlabel="pitch (m)", ylabel="smallest gap seen (mm)", xticks=pitches[::2])
lesson.show(figure, "The smallest gap on the way in, over the pitch, as looks each second and each hundredth see it.")

lesson.answer(
    "The smallest pitch is 0.450337393 m, half as much again as the width, because a straight bench on a curve sticks "
    "out at its ends and sags in at its middle; with it the head just touches bench 19. Looks each second find "
    "0.450274 m, which is too small: they see nothing overlap, but between two of them benches do, by 0.064 mm."
)
lesson.check(
    "The way in takes 220.934 s: to 4.5 m from the centre there are 16 - 4.5 / 0.450337 = 6.007483 turns, of a mean "
    "radius of (7.205398 + 4.5) / 2 m. As circles these are 220.917 m, at 1 m/s; the rest is the way inward."
)
lesson.change(
    "Set `look` to 0.5 or 0.1: does the pitch ever come out too large? Then ask for the smallest "
    "pitch of wider benches, `min_pitch(Dragon(width=0.31))`: does 10 mm of width take 10 mm of pitch?"
)
