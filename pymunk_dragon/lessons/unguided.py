"""What happens without dancers."""

import numpy as np

from pymunk_dragon import Dragon, March, render, simulate
from pymunk_dragon.lessons import Lesson

lesson = Lesson("unguided", "What do the dancers do?", order=80, live="unguided")

lesson.question(
    "Every bench hangs on the one before it, and the head walks its spiral without a fault. Does it take dancers to "
    "bring the other 222 benches along, or do they follow by themselves?"
)
lesson.predict(
    "The dancers let go, and only the head pulls.",
    ("Which path does the dragon take?", "it keeps to the spiral", "it swings outwards", "it cuts across"),
    ("How long does that go well?", "for seconds", "for minutes", "until the end"),
)

# The same march twice: no dancers guide the benches, or dancers keep every hole on the path.
march = March(Dragon(benches=223))
alone = simulate(march, guide="none")
hit = alone.first_contact
guided = simulate(march, until=hit.time)
print(f"without dancers: t = {hit.time:.3f} s  benches {hit.benches} touch")

# Where the front holes of some benches are then: their distance from the middle, and from where they began.
some = [0, 4, 8, 16, 28, 60]
print("bench               " + "".join(f"{bench:8d}" for bench in some))
for name, run in [("with   ", guided), ("without", alone)]:
    (begin, end), _ = march.dragon.holes(run.poses_at([0, hit.time]))
    for what, far in [("from middle", end), ("from start ", end - begin)]:
        print(f"{name} {what}" + "".join(f"{np.hypot(*far[bench]):8.3f}" for bench in some) + " m")

film = lesson.file(".gif")
render([guided, alone], film, headings=("with dancers", "without dancers"), speedup=3, size=(260, 290))
lesson.show(film)

lesson.picture("On the left dancers keep every bench on the spiral; on the right only the head pulls.")
lesson.answer(
    "They do not follow: a chain that is pulled at one end straightens, so the benches behind the head cut across, "
    "and after 10.9 s bench 1 runs into bench 28, while bench 60 has coasted for 9 cm and stands. A chain can only "
    "pull along itself, and in a bend that is always a little inwards, so somebody has to walk beside each bench and "
    "hold it on the path.",
    ("it cuts across", "bench 4 is 5.734 m from the middle, not 8.769 m"),
    ("for seconds", "10.894 s"),
)
lesson.check(
    "The head is 8.691 m from the middle both times, so it is not to blame. It has gone 10.894 m in a lane 0.55 m "
    r"wide, which is the ring from 8.8 m in to its own distance $r$: $\pi (8.8^2 - r^2) = 0.55 \cdot 10.894$."
)
lesson.change("Make it a short dragon: `Dragon(benches=20)`, and `some = [0, 4, 8, 16]`. Whom does the head meet now?")
