"""The events of Pymunk's collision callbacks, and errors in a function that Pymunk calls."""

import sys
from typing import Any

import pymunk
from PIL import Image, ImageDraw

from pymunk_dragon import Dragon, March, PillowDrawOptions, simulate
from pymunk_dragon.lessons import Lesson

lesson = Lesson("callbacks", "Which events does a contact cause?", order=100, live="jam")

lesson.question(
    "Pymunk reports contacts through callbacks: a program gives it functions, and it calls them. When does it call, "
    "what does it know by then, and what becomes of an error in such a function?"
)
lesson.predict(
    "A bench brushes another that lies still, and the function for `begin` raises an error.",
    ("Which are called in every step?", "`begin` and `separate`", "`pre_solve` and `post_solve`", "all four"),
    ("What happens after the error?", "the program stops", "the benches do not bounce", "all goes on as without it"),
)

# One bench flies at another, each of 10 kg.
space = pymunk.Space()
for position, angle, velocity in [((-2.4, 1.7), -0.6, (2.5, -1)), ((0, 0), 0, (0, 0))]:
    body = pymunk.Body(mass=10, moment=5)
    body.position, body.angle, body.velocity = position, angle, velocity
    shape = pymunk.Poly.create_box(body, (2.2, 0.3))
    shape.elasticity = 0.5
    space.add(body, shape)

# One function for all callbacks: Pymunk hands it the `data` that it was given for each, here the name. `begin` fails.
step, calls = 0, [""]


def called(arbiter: pymunk.Arbiter, space: pymunk.Space, name: Any) -> None:
    """Tell which call it is, in which step, and which impulse Pymunk knows of."""
    calls.append(f"step {step}   impulse {arbiter.total_impulse.length:.3f} N s   {name}")
    print(calls[-1])
    if name == "begin":
        raise ValueError("an error in begin")


for name in ("begin", "pre_solve", "post_solve", "separate"):
    callback: dict[str, Any] = {name: called}
    space.on_collision(**callback, data=name)

# An error that no caller can catch goes to this hook of Python, which by default writes it to stderr.
usual, sys.unraisablehook = sys.unraisablehook, lambda lost: print(f"hook:    {lost.exc_value}")
frames = []
for step in range(80):
    space.step(0.02)
    if 30 <= step < 70:
        frames.append(Image.new("RGB", (400, 380), "white"))
        ImageDraw.Draw(frames[-1]).text((90, 210), "\n".join(calls), "black", lesson.font(14))
        options = PillowDrawOptions(frames[-1], positive_y_is_up=True, line_width=2)
        options.fit(pymunk.BB(-2.0, -2.5, 2.6, 1.9))
        space.debug_draw(options)
sys.unraisablehook = usual
print(f"afterwards the bench of {body.mass:.0f} kg goes at {body.velocity.length:.4f} m/s")

# A function of ours that fails as the dragon meets itself, called by `simulate`.
try:
    simulate(March(Dragon(benches=12)), start=412, on_event=lambda event: print(f"{event.phase}: {1 / 0}"))
except ZeroDivisionError as error:
    print(f"caught:  {error}")

film = lesson.file(".gif")
frames[0].save(film, save_all=True, append_images=frames[1:], duration=[120] * 39 + [2000], loop=0)
lesson.show(film)

lesson.picture("A bench brushes another, six times slower than it does; every call is written down as it comes.")
lesson.answer(
    "`begin` and `separate` come once, `pre_solve` and `post_solve` in every step between, and only `post_solve` "
    "knows the impulse: before it one reads that of the step before. An error is lost in C, through which Pymunk "
    "calls back, and the benches go on as if nothing had been; so `simulate` keeps it and raises it when the step is "
    "over.",
    ("`pre_solve` and `post_solve`", "in steps 40, 41 and 42"),
    ("all goes on as without it", "at 0.3287 m/s"),
)
lesson.check("The impulse of 3.287 N s is what sets the bench in motion: divide it by 10 kg, and compare the speed.")
lesson.change("Set `elasticity`, their bounce, to 0. Why is there less of an impulse, but more of the calls?")
