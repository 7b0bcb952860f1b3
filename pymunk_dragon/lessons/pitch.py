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
    "One program proves its answer. Another one samples once a second whether benches overlap, and narrows the pitch "
    "down with that.",
    ("How small may the pitch be?", "0.31 m", "0.38 m", "0.45 m"),
    ("The pitch found with a sample each second is ...", "right", "too large", "too small"),
)

# The library's answer, which is proved to a billionth of a metre.
found = min_pitch()
contact, arrival = found.march.time([found.distance, found.arrival_distance])
print(f"smallest pitch  {found.pitch:.9f} m  benches {found.benches} touch at t = {contact:.3f} s")
print(f"inward march    {16 * found.pitch:.6f} m to 4.5 m from the centre  {arrival:.3f} s")


def smallest_gap(pitch: float, step: float) -> float:
    """The smallest gap between the head and benches 2 to 39 in mm, sampled every `step` s in the last 20 s."""
    spiral = Spiral(pitch=pitch)
    march = March(Dragon(benches=40), spiral)
    arrival = spiral.at_radius(4.5) - march.head_start  # m along the spiral, and so s at 1 m/s
    times = np.arange(max(0, arrival // 1 - 20), arrival, step)
    benches = march.dragon.outlines(march.at(times).poses)
    return float(1000 * separation(benches[:, :1], benches[:, 2:]).distance.min())


# With a sample each second: halve the bracket, which begins with a bench's width and the contest's pitch.
blocked, free, interval = 0.30, 0.55, 1.0  # m, m, s
while free - blocked > 1e-7:
    middle = (blocked + free) / 2
    blocked, free = (blocked, middle) if smallest_gap(middle, interval) > 0 else (middle, free)
for step in (interval, 0.01):
    print(f"each {step:4g} s     {free:.6f} m  gap {smallest_gap(free, step):.3f} mm")

figure, axes = lesson.subplots()
pitches = round(found.pitch, 4) + np.linspace(-1e-4, 1e-4, 9)
for step, style, colour in ((interval, "--", AMBER), (0.01, "-", BLUE)):
    axes.plot(pitches, [smallest_gap(pitch, step) for pitch in pitches], style, color=colour)
axes.text(pitches[5], 0.12, f"each {interval:g} s ", color=AMBER, ha="right")
axes.text(pitches[3], -0.09, "  each 0.01 s", color=BLUE)
axes.axhline(0, color=QUIET, lw=0.8)
for pitch, height, side in ((free, 0.01, "right"), (found.pitch, -0.022, "left")):
    axes.plot(pitch, 0, "o", color=COLOURS.ink)
    axes.text(pitch, height, f" {pitch:.6f} m ", ha=side)
axes.set(xlabel="pitch (m)", ylabel="smallest gap sampled (mm)", xticks=pitches[::2])
lesson.show(figure)

lesson.picture(
    "The smallest gap of the inward march, over the pitch, sampled each second and each hundredth of a second."
)
lesson.answer(
    "The smallest pitch is 0.450337393 m, half as much again as the width, because a straight bench on a curve "
    "sticks out at its ends and sags in at its middle; with it the head just touches bench 19. Samples each "
    "second give 0.450274 m, which is too small: no sample has an overlap, but between two of them benches overlap by "
    "0.064 mm.",
    ("0.45 m", "0.450337393 m"),
    ("too small", "0.450274 m"),
)
lesson.check(
    "The inward march takes 220.934 s: to 4.5 m from the centre there are $16 - 4.5 / 0.450337 = 6.007483$ turns, of a "
    "mean radius of $(7.205398 + 4.5) / 2$ m. As circles these are 220.917 m, at 1 m/s; the rest is due to the motion "
    "towards the centre."
)
lesson.change(
    "Set `interval` to 0.5 or 0.1: does the pitch ever come out too large? Then ask for the smallest "
    "pitch of wider benches, `min_pitch(Dragon(width=0.31))`: does 10 mm of width take 10 mm of pitch?"
)
