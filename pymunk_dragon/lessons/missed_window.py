"""How often a march must be sampled for its first contact."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon import Dragon, March, first_contact, scan, separation
from pymunk_dragon.drawing.figures.style import BLUE, CANDIDATE, COLOURS
from pymunk_dragon.lessons import Lesson

lesson = Lesson("missed-window", "How long must a contact last to be seen?", order=70)

lesson.question(
    "Make all benches one millimetre wider: 0.301 m. A program that checks each second whether any two overlap finds "
    "the head, bench 0, in bench 8, and traces it back to 412.442 s. Has nothing touched before?"
)
lesson.predict(
    "In the lesson before, the head passed two benches with a few millimetres to spare, or less than one.",
    ("What touched before 412.442 s?", "nothing", "there was one short contact", "there were many contacts"),
    ("How often must you sample?", "every tenth of a second", "every thousandth", "no step is short enough"),
)

march = March(Dragon(width=0.301))
for name, hit in {"scan": scan(march, step=1), "first_contact": first_contact(march)}.items():
    print(f"{name:14}{hit.time:.6f} s  benches {hit.benches}  {hit.samples:5} samples")


def gap(times: ArrayLike) -> NDArray[np.float64]:
    """From the head to the nearest of benches 2 to 15 in mm; negative where they overlap."""
    benches = march.dragon.outlines(march.at(times, handles=17).poses)
    return np.array(1000 * separation(benches[:, :1], benches[:, 2:]).distance.min(axis=1))


# A search of our own. Holes go at 1 m/s at most; corners are 0.31 m from them, on benches that turn at less than
# 0.5 rad/s, so they are slower than 1.2 m/s. Within a time interval no gap is smaller than in its middle by more than
# two benches move in half of it. An interval in which that could close the gap is split into its halves.
fastest, begins, until, samples = 1200, np.arange(400.0, 413.0), np.inf, 0  # mm/s, s, s
for halvings in range(31):
    length = 0.5**halvings
    gaps = gap(begins + length / 2)
    samples += len(gaps)
    until = min([until, *begins[gaps <= 0] + length / 2])  # a contact; what comes later is not the first
    begins = begins[gaps <= 2 * fastest * length / 2]
    begins = np.sort(np.concatenate([begins, begins + length / 2]))
    begins = begins[begins < until]
print(f"{'this search':14}{until:.6f} s  none before {begins[0]:.5f} s  {samples} samples")

# How long and how deep the contact is, and the angle between the two benches when it is deepest.
times = until + np.linspace(-0.07, 0.27, 34_001)
touching, deepest = times[gap(times) <= 0], gap(times).argmin()
_, bench = hit.contact.benches
angle = np.degrees(np.ptp(march.at(times[deepest]).poses[0, [0, bench], 2]))
print(f"{np.ptp(touching):.3f} s long  {-gap(times)[deepest]:.3f} mm deep  at an angle of {angle:.2f} degrees")

figure, charts = lesson.subplots(2, figsize=(5.2, 5.0))
for chart, moments in zip(charts, (np.linspace(404.9, 413.1, 2000), times), strict=True):
    chart.plot(moments, gap(moments), color=BLUE)
    whole = np.arange(np.ceil(moments[0]), moments[-1])
    chart.plot(whole, gap(whole), "o", color=COLOURS.ink)
    chart.axhspan(-20, 0, color=CANDIDATE, alpha=0.4, lw=0)
    chart.set(ylabel="gap (mm)", xlim=(moments[0], moments[-1]))
charts[0].set(ylim=(-15, 32))
charts[0].text(406, -8, "overlap")
charts[1].set(ylim=(-0.1, 0.32), xlabel="time (s)")
lesson.show(figure)

lesson.picture(
    "The head's gap to the benches that it passes, and a sample each second as dots; below, the same from close by."
)
lesson.answer(
    "The head touches bench 11 at 409.776 s, for 0.109 s and 0.023 mm deep, and at 410 s there is a gap again. No "
    "step is short enough, as the next contact may be shorter; but if you know how fast a gap can close, each sample "
    "clears a time interval, and you sample again only where a doubt is left, as above, and as `first_contact` does.",
    ("there was one short contact", "0.109 s long"),
    ("no step is short enough", "4665 samples where they are needed"),
)
lesson.check(
    "The depth of 0.023 mm: benches of 0.300 m leave 0.865 mm, as in the lesson before. Half a millimetre more on "
    r"either side brings the edge of bench 11 nearer by 0.5 mm, and the head's corner by 0.5 mm times $\cos "
    r"39.05^\circ$."
)
lesson.change(
    "With which `step` does the scan find bench 11: 0.5, 0.2 or 0.1? Then set `width` to 0.30098: how long is the "
    "contact now, and does the scan with a step of 0.1 still find it?"
)
