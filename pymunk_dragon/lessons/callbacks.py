# %% [markdown] order=100 scene="callbacks" axes="step|impulse (N s)"
# # Which events does a contact cause?
# Pymunk reports contacts through callbacks: a program gives it functions, and it calls them. When does it call, what
# does it know by then, and what becomes of an error in such a function?
# ## Guess
# A bench brushes another that lies still, and the function for `begin` raises an error.

# %%
import sys
from typing import Any

import pymunk
from PIL import Image

from pymunk_dragon import Dragon, March, PillowDrawOptions, simulate

# One bench flies at another, each of 10 kg.
space = pymunk.Space()
for position, angle, velocity in [((-2.4, 1.7), -0.6, (2.5, -1)), ((0, 0), 0, (0, 0))]:
    body = pymunk.Body(mass=10, moment=5)
    body.position, body.angle, body.velocity = position, angle, velocity
    shape = pymunk.Poly.create_box(body, (2.2, 0.3))
    shape.elasticity = 0.5
    space.add(body, shape)


def called(arbiter: pymunk.Arbiter, space: pymunk.Space, name: Any) -> None:
    """Tell which call it is, in which step, and which impulse Pymunk knows of. `begin` fails."""
    print(f"step {step}   impulse {arbiter.total_impulse.length:.2f} N s   {name}")
    if name == "begin":
        raise ValueError("an error in begin")


# One function for all callbacks: Pymunk hands it the `data` that it was given for each, here the name.
for name in ("begin", "pre_solve", "post_solve", "separate"):
    callback: dict[str, Any] = {name: called}
    space.on_collision(**callback, data=name)

# %%
# An error that no caller can catch goes to this hook of Python, which by default writes it to stderr.
usual, sys.unraisablehook = sys.unraisablehook, lambda lost: print(f"hook:    {lost.exc_value}")
frames = []
for step in range(70):  # noqa: B007  # `called` prints it.
    space.step(0.02)
    frames.append(Image.new("RGB", (400, 300), "white"))
    options = PillowDrawOptions(frames[-1], positive_y_is_up=True, line_width=2)
    options.fit(pymunk.BB(-2.6, -1.2, 2.6, 2.0))
    space.debug_draw(options)
sys.unraisablehook = usual
print(f"afterwards the bench of {body.mass:.0f} kg goes at {body.velocity.length:.3f} m/s")
frames[0].save("callbacks.gif", save_all=True, append_images=frames[1:], duration=60, loop=0)

# %%
# A function of ours that fails as the dragon meets itself, called by `simulate`.
try:
    simulate(March(Dragon(benches=12)), start=412, on_event=lambda event: print(f"{event.phase}: {1 / 0}"))
except ZeroDivisionError as error:
    print(f"caught:  {error}")
frames[40]

# %% [markdown]
# ## Answer
# `begin` and `separate` come once, `pre_solve` and `post_solve` in every step between, and only `post_solve` knows the
# impulse: before it one reads that of the step before. An error does not pass through the C code that calls back:
# Python only reports it, and the benches go on as if nothing had been; so `simulate` keeps it and raises it when the
# step is over.
#
# Which are called in every step?
# - `begin` and `separate`: the names of a beginning and an end, but nothing says what comes between.
# - **`pre_solve` and `post_solve`**: in steps 40, 41 and 42.
# - All four: the contact is there in each step, but `begin` and `separate` tell of changes.
#
# What happens after the error?
# - The program stops: so it does after an error in a function that a program of Python calls itself.
# - The benches do not bounce: before Pymunk 7 the value that `begin` returned did decide on that.
# - **All goes on as without it**: the bench that lay still leaves at 0.329 m/s.
# ## Check
# The impulse of 3.29 N s is what sets the bench in motion: divide it by 10 kg, and compare the speed.
# ## Try
# Watch the events, then drag one bench against the other and hold it there: which events come once, and which again and
# again? What is the impulse of a contact that lasts? What becomes of the error is in the program's output.
# ## Change
# Set `elasticity`, their bounce, to 0. Why is there less of an impulse, but more of the calls?
# ## Teacher
# - A course in programming; functions and exceptions in Python. 45 minutes: 5 to guess, 20 on the stage, 20 to compare.
# - Goal: a library that calls back decides when, and with which state. An exception does not cross C code by itself.
# - Try: while a contact lasts, each step has the impulse of the force of the hand, without the blow of the first.
# - Mistakes: the impulse is read before it is computed; an error that nobody sees is taken for no error.
