# %% [markdown] order=70 axes="time (s)|gap (mm)"
# # Is a check each second enough?
# Benches are one millimetre wider now. A program checks each second whether any overlap: it finds
# the head in bench 8, and traces that back to 412.442 s.

# %%
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon import Dragon, March, first_contact, scan, separation

march = March(Dragon(width=0.301))
searches = {"scan": scan(march, step=1), "first_contact": first_contact(march)}
for name, hit in searches.items():
    print(f"{name:14}{hit.time:.6f} s  benches {hit.benches}  {hit.samples:5} samples")


def gap(times: ArrayLike) -> NDArray[np.float64]:
    """From the head to the nearest of benches 2 to 15 in mm; negative where they overlap."""
    benches = march.dragon.outlines(march.at(times, handles=17).poses)
    distance = separation(benches[:, :1], benches[:, 2:]).distance
    return np.array(1000 * distance.min(axis=1))


# %%
# A search of our own. Holes go at 1 m/s at most; corners are 0.31 m from them, on benches that turn
# at less than 0.5 rad/s, so they are slower than 1.2 m/s. Within a time interval no gap is smaller
# than in its middle by more than two benches move in half of it. An interval in which that could
# close the gap is split into its halves.
fastest = 1200  # mm/s
begins = np.arange(400.0, 413.0)  # s
until = np.inf  # s
samples = 0
for halvings in range(31):
    length = 0.5**halvings
    gaps = gap(begins + length / 2)
    samples += len(gaps)
    # A contact: what comes later is not the first.
    until = min([until, *begins[gaps <= 0] + length / 2])
    begins = begins[gaps <= 2 * fastest * length / 2]
    begins = np.sort(np.concatenate([begins, begins + length / 2]))
    begins = begins[begins < until]
print(f"{'this search':14}{until:.6f} s  none before {begins[0]:.5f} s  {samples} samples")

# %%
# How long and how deep the contact is, and the angle between the two benches when it is deepest.
times = until + np.linspace(-0.07, 0.27, 34_001)
touching = times[gap(times) <= 0]
deepest = gap(times).argmin()
_, bench = hit.contact.benches
directions = march.at(times[deepest]).poses[0, [0, bench], 2]
angle = np.degrees(np.ptp(directions))
print(f"{np.ptp(touching):.3f} s long  {-gap(times)[deepest]:.3f} mm deep  ", end="")
print(f"at an angle of {angle:.2f} degrees")

plt.figure(figsize=(5, 3))
plt.plot(times, gap(times))
plt.plot(410, gap([410]), "o", label="check each second")
plt.axhline(0, color="black", lw=0.8)
plt.xlabel("time (s)")
plt.ylabel("gap of the head (mm)")
plt.legend()
plt.savefig("missed-window.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# The head touches bench 11 at 409.776 s, for 0.109 s and 0.023 mm deep, and at 410 s there is a gap
# again. No step is short enough, as the next contact may be shorter. But if you know how fast a gap
# can close, each sample clears a time interval, and you sample again only where a doubt is left.
#
# What touched before?
# - Nothing: what is traced back seems to be the first, but only this contact is traced.
# - **One bench, briefly**: bench 11, for 0.109 s.
# - Many benches: a millimetre on each seems much, but it closes only the gap of 0.9 mm.
# ## Check
# The depth of 0.023 mm: benches of 0.300 m leave 0.865 mm, as in the lesson before. Half a
# millimetre more on either side brings the edge of bench 11 nearer by 0.5 mm, and the head's corner
# by 0.5 mm times $\cos 39.05^\circ$.
# ## Try
# Drag the time along the strip: what happened between the samples? Then change how often there is a
# sample. What is the longest step that finds both contacts, and is that more than luck? Make the
# benches a hair narrower, down to where a contact is so short that even 0.05 s misses it.
# ## Change
# Set `width` to 0.30098: how long is the contact now, and does `scan` with `step=0.1` still find
# it?
# ## Teacher
# - From grade 11; the lesson near-miss, a bound on a speed. 45 minutes: 10 to guess, 20 on the
#   stage, 15 to compare.
# - Goal: samples prove nothing about the time between. With a bound on the speed they do:
#   conservative advancement.
# - Try: 0.2 s, by luck, as 409.8 s lies within the 0.109 s of the contact. At 300.98 mm it lasts
#   0.052 s, and samples every 0.1 s miss it; at 300.977 mm 0.037 s, and those every 0.05 s do.
# - Mistakes: a finer step is taken for a proof; the first contact found is taken for the first.
# - Ask next: how often must you check? Every tenth of a second finds this contact, but not a
#   shorter one; a thousand checks a second feel safe, but there is no shortest contact. Only a
#   bound on the speed makes samples a proof: the program and `first_contact` take some 4,000, where
#   they are needed.
# - In the lesson before, benches of 0.300 m passed each other with 3.0 mm and with 0.9 mm to spare;
#   here they have 0.301 m.
