# %% [markdown] order=80 scene="unguided"
# # Who keeps the dragon on its path?
# The dancers let go. Only the head goes on along the spiral, and pulls the other 222 benches over
# smooth ice.

# %%
import numpy as np

from pymunk_dragon import March, pull, render

# The exact motion of a dragon that only its head pulls, on nine grounds. With the drag `d` of the
# ground a bench that is let go slides for 1 / d metres.
march = March()
mass = march.dragon.masses[1]
spacing = march.dragon.spacings[1]
print(f"a bench: {mass:.1f} kg, {spacing:.2f} m between its holes")
runs = {}
for drag in [0, 0.1, 0.25, 0.5, 1, 2, 5, 11.5, 50]:  # per metre
    run = pull(march, until=13, drag=drag, tolerance=1e-6)
    run.save(f"{drag:g}.npz")
    runs[drag] = run
    hit = run.first_contact
    found = f"benches {hit.benches} touch at {hit.time:.2f} s" if hit else "no contact until 13 s"
    print(f"drag {drag:4g} /m  {found}")

# %%
# How far some benches are off their path when two of them touch, and what the joints carry.
some = [4, 50, 100, 150, 200]
for ground, drag in [("on ice   ", 0), ("on ground", 11.5)]:
    run = runs[drag]
    frame = np.searchsorted(run.times, run.first_contact.time)
    print(f"{ground} at {run.times[frame]:.2f} s, bench" + "".join(f"{n:9d}" for n in some))
    off = run.drift[frame, some]
    print(f"{ground} off the path     " + "".join(f"{n:9.4f}" for n in off) + " m")
    forces = np.array(run.joint_forces)[frame, some]
    print(f"{ground} force behind it  " + "".join(f"{n:9.2f}" for n in forces) + " N")
    x, y = march.dragon.holes(run.poses[frame])[0][4]
    print(f"{ground} bench 4 is {np.hypot(x, y):.2f} m from the middle")

# A on ice, B on the ground.
two = [runs[0], runs[11.5]]
render(two, "unguided.gif", headings=("A", "B"), legend=False, speedup=3, size=(300, 336))
runs[0]

# %% [markdown]
# ## Answer
# On ice all joints pull with the same force, 8 N. Wherever the chain bends, the two pulls on a
# bench add up to just the force inwards that its turn needs, whatever the bend. It can only fail at
# the free end, where the last twenty benches swing out. On the ground the drag stops the benches;
# the head has to haul them, and a chain that is hauled straightens.
#
# Where do they go?
# - They cut across: so they do where the ground drags.
# - They swing outwards: a single bench would, but its neighbours pull it inwards.
# - **They keep to the spiral**: bench 100 is 0.3 mm off at 11.7 s.
# ## Check
# The 8 N: a bench of $m = 13.2$ kg and $l = 1.65$ m between its holes moves at $v = 1$ m/s. On a
# circle of the radius $r$ the pulls $F$ at its two ends differ in direction by $l / r$, so together
# they are $F l / r$. That is to be $m v^2 / r$, so $F = m v^2 / l$, whatever $r$ is.
# ## Try
# Play it on ice first, and then on grounds that drag more and more. Which one lets the dragon go on
# longest before two benches touch? Look at the tail too: what does it do on ice, and what in mud?
# ## Change
# Make it a short dragon: `March(Dragon(benches=20))` with `Dragon` from `pymunk_dragon`, and
# `some = [4, 8, 16]`. What does its tail do on ice?
# ## Teacher
# - From grade 10; centripetal force, tension. 25 minutes: 5 to guess, 10 on the stage, 10 to
#   compare.
# - Goal: a tension of $m v^2 / l$ bends the path of a moving chain by just as much as the path
#   turns. Drag, not inertia, pulls a chain off a curve.
# - Try: with a drag of 0.1 per metre nothing touches until 13 s. On ice the tail swings out like
#   the end of a whip; in mud it does not move at all.
# - Mistakes: a centrifugal force is expected to drive the chain outwards; a chain is taken to cut
#   across always.
# - Ask next: and on the ground, where a bench that is let go stops within 10 cm? They cut across:
#   bench 4 is 5.74 m from the middle, not 8.77 m, and at 10.9 s benches 1 and 28 touch; the head
#   hauls them with a thousand newton. A train keeps to its path, but it has rails. They cannot
#   swing outwards, as their speed is gone before that.
# - On ice the last twenty benches swing out like the end of a whip, and at 11.7 s benches 162 and
#   206 touch.
