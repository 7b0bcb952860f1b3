# %% [markdown] order=80 scene="unguided"
# # What do the dancers do?
# Every bench hangs on the one before it, and the ground drags at all of them. The head walks its
# spiral without a fault. Does it take dancers to bring the other 222 benches along, or do they
# follow by themselves?
# ## Guess
# The dancers let go, and only the head pulls.

# %%
import numpy as np

from pymunk_dragon import Dragon, March, render, simulate

# The same march twice: no dancers guide the benches, or dancers keep every hole on the path.
march = March(Dragon(benches=223))
alone = simulate(march, guide="none")
hit = alone.first_contact
guided = simulate(march, until=hit.time)
print(f"without dancers: t = {hit.time:.1f} s  benches {hit.benches} touch")

# %%
# Where the front holes of some benches are then: their distance from the middle, and from where
# they began.
some = [0, 4, 8, 16, 28, 60]
print("bench               " + "".join(f"{bench:7d}" for bench in some))
for name, run in [("with   ", guided), ("without", alone)]:
    poses = run.poses_at([0, hit.time])
    (begin, end), _ = march.dragon.holes(poses)
    for what, far in [("from middle", end), ("from start ", end - begin)]:
        print(f"{name} {what}" + "".join(f"{np.hypot(*far[bench]):7.2f}" for bench in some) + " m")

# A with dancers, B without.
render(
    [guided, alone], "unguided.gif", headings=("A", "B"), legend=False, speedup=3, size=(300, 336)
)
alone

# %% [markdown]
# ## Answer
# They do not follow: a chain that is pulled at one end straightens, so the benches behind the head
# cut across, and after 10.9 s bench 1 runs into bench 28, while bench 60 has coasted for 9 cm and
# stands, as the ground has stopped it. A chain can only pull along itself, and in a bend that is
# always a little inwards, so somebody has to walk beside each bench and hold it on the path.
#
# Which path does the dragon take?
# - It keeps to the spiral: so a train does, but it has rails.
# - It swings outwards: a stone that is let go flies straight on; here the ground stops a bench
#   within 10 cm.
# - **It cuts across**: bench 4 is 5.73 m from the middle, not 8.77 m.
#
# How long does that go well?
# - **For seconds**: after 10.9 s two benches touch.
# - For minutes: the head needs nearly one for a turn of the spiral, but the benches behind it leave
#   the path at once.
# - Until the end: if one sees the chain as a rope that is drawn through a groove.
# ## Check
# The head is 8.69 m from the middle both times, so it is not to blame. It has gone 10.9 m in a lane
# 0.55 m wide, which is the ring from 8.8 m in to its own distance $r$:
# $\pi (8.8^2 - r^2) = 0.55 \cdot 10.9$.
# ## Try
# Recorded: the dancers of A hold on, those of B let go. Live: press "Let all go": which benches
# meet, and when? Start again, choose the tool "Let go" and tap a bench: its dancers and those
# behind it let go. Is that better?
# ## Change
# Make it a short dragon: `Dragon(benches=20)`, and `some = [0, 4, 8, 16]`. Whom does the head meet
# now?
# ## Teacher
# - From grade 8; forces along a rope. 25 minutes: 5 to guess, 10 on the stage, 10 to compare.
# - Goal: a chain transmits only tension, along itself. To follow a bend it needs forces across it,
#   from the dancers.
# - Try: no. From bench 60 on benches touch within half a second, as the next turn of the dragon is
#   in their way.
# - Mistakes: a centrifugal force is expected to drive it outwards; a link is taken to copy the path
#   of the one before.
