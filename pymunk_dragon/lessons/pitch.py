# %% [markdown] order=120 axes="pitch (m)|smallest gap (mm)"
# # How tight can it coil?
# The dragon shall coil in to 4.5 m from the centre, and no bench may touch another. Benches are
# 0.30 m wide.

# %%
import matplotlib.pyplot as plt
import numpy as np

from pymunk_dragon import Dragon, March, Spiral, min_pitch, separation

# The library's answer, which is proved to a billionth of a metre.
found = min_pitch()
contact, arrival = found.march.time([found.distance, found.arrival_distance])
print(f"smallest pitch  {found.pitch:.6f} m  benches {found.benches} touch at t = {contact:.1f} s")
print(f"inward march    {16 * found.pitch:.3f} m to 4.5 m from the centre  {arrival:.1f} s")


def smallest_gap(pitch: float, step: float) -> float:
    """Smallest gap of the head and benches 2 to 39, mm, every `step` s of the last 20 s."""
    spiral = Spiral(pitch=pitch)
    march = March(Dragon(benches=40), spiral)
    arrival = spiral.at_radius(4.5) - march.head_start  # m along the spiral, and so s at 1 m/s
    times = np.arange(max(0, arrival // 1 - 20), arrival, step)
    benches = march.dragon.outlines(march.at(times).poses)
    distance = separation(benches[:, :1], benches[:, 2:]).distance
    return float(1000 * distance.min())


# %%
# With a check each second: halve the bracket, which begins with a bench's width and the contest's
# pitch.
blocked = 0.30  # m
free = 0.55  # m
interval = 1.0  # s
while free - blocked > 1e-7:
    middle = (blocked + free) / 2
    blocked, free = (blocked, middle) if smallest_gap(middle, interval) > 0 else (middle, free)
for step in (interval, 0.01):
    print(f"each {step:4g} s     {free:.6f} m  gap {smallest_gap(free, step):.3f} mm")

plt.figure(figsize=(5, 3.5))
pitches = np.linspace(found.pitch - 1e-4, found.pitch + 1e-4, 9)
for step in (interval, 0.01):
    gaps = [smallest_gap(pitch, step) for pitch in pitches]
    plt.plot(1000 * pitches, gaps, label=f"checked each {step:g} s")
plt.axhline(0, color="black", lw=0.8)
plt.xlabel("pitch (mm)")
plt.ylabel("smallest gap (mm)")
plt.legend()
plt.savefig("pitch.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# The smallest pitch, the distance from turn to turn, is 0.45034 m, half as much again as the width,
# because a straight bench on a curve sticks out at its ends and sags in at its middle. With it the
# head just touches bench 19.
#
# How small may the pitch be?
# - 0.31 m: so little would be enough on a straight line.
# - 0.38 m: a little more for straight benches on round turns; but the head is 3.41 m long and needs
#   more.
# - **0.45 m**: 0.45034 m.
# ## Check
# The inward march takes 220.9 s: to 4.5 m from the centre there are $16 - 4.5 / 0.45034 = 6.0075$
# turns, of a mean radius of $(7.205 + 4.5) / 2$ m. Multiply their length by the turns: those are
# metres, and at 1 m/s as many seconds.
# ## Try
# Move the pitch until the dragon just gets in, to a millimetre. Which bench does the head touch if
# it is a little too small, and where? Then stay at 450 mm, and use the fine adjustment: from where
# on do samples every 1 s see no overlap, and from where on is there none?
# ## Change
# Set `interval` to 0.5 or 0.1: does the pitch ever come out too large? Then ask for the smallest
# pitch of wider benches, `min_pitch(Dragon(width=0.31))`: does 10 mm of width take 10 mm of pitch?
# ## Teacher
# - From grade 11; bisection, the lesson missed-window. 45 minutes: 10 to guess, 20 on the stage, 15
#   to compare.
# - Goal: bisection with a test that misses contacts converges to a wrong answer, with as many
#   digits as the right one.
# - Try: 451 mm; at 450 mm the head hits bench 19, 4.58 m from the centre. Samples miss it from
#   450.28 to 450.33 mm.
# - Mistakes: the pitch is taken to be the width of a bench; many digits are taken for a small
#   error.
# - Ask next: a program checks once a second for benches that overlap, and narrows the pitch by
#   that. Does it find the right one? No, 0.45027 m, which is too small: no sample has an overlap,
#   but between two of them benches overlap by 0.064 mm. The bracket is halved until it has seven
#   digits, but digits are not truth. It would be too large if the checks saw contacts that are
#   none.
# - The head starts on turn 16; with turns 0.55 m apart the march is easy.
