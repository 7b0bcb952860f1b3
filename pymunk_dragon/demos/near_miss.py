"""Nearly is not hit: 3 mm, then 0.9 mm, then contact."""

from pymunk_dragon import Dragon, March, Spiral, first_contact, simulate
from pymunk_dragon.demos import Lesson
from pymunk_dragon.render import Camera, render

lesson = Lesson("near-miss", "Nearly is not hit")

lesson.question(
    "On its way in the head passes bench 9, then bench 11, and then runs into bench 8. A bench is 300 mm wide. How "
    "much room is left when it passes?"
)
lesson.predict(
    "A hand's width, a finger's, or a sheet of cardboard's? And what would a program say that looks only once a "
    "second, or an engine that is a millimetre off?"
)

# The exact model: the first contact, and every close call on the way to it.
march = March(Dragon(), Spiral(pitch=0.55), turns=16, speed=1.0)
hit = first_contact(march)
for miss in hit.clearances:
    print(f"t = {miss.time:.3f} s  benches {miss.benches}  gap {1000 * miss.gap:.3f} mm")
print(f"t = {hit.time:.3f} s  benches {hit.benches}  contact")

# A sloppy engine: a hundredth of the solver's work in each of its steps, and much longer ones.
sloppy = simulate(march, start=400, until=413, substep=0.05, iterations=2)
print(f"sloppy engine: t = {sloppy.first_contact.time:.3f} s  benches {sloppy.first_contact.benches}")

run = simulate(march, start=405, frame_interval=0.02)
film = lesson.file(".gif")
render(run, film, camera=Camera(follow="head"), speedup=1, fps=12, size=400, hold=2)
lesson.show(film, "The head slips past benches 9 and 11 and meets bench 8.")

lesson.answer("...")
lesson.check("...")
lesson.change("...")
