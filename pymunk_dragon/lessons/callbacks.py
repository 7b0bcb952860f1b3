# %% [markdown] order=100 scene="callbacks" view=[0,0.3,8,5.5] axes="step|impulse (N s)"
# # Which events does a contact cause?
# A bench flies at another that lies still, and bounces off. At the contact Pymunk calls functions
# of your program.

# %%
import sys
from typing import Any

import pymunk
from PIL import Image, ImageDraw

from pymunk_dragon import Dragon, March, PillowDrawOptions, Slider, simulate

events: list[str] = []


def build(elasticity: float = 0.5, note: Any = events.append) -> pymunk.Space:
    """Make benches touch, and read below "Events" which callbacks Pymunk calls."""
    # One bench flies at another, each of 10 kg.
    space = pymunk.Space()
    for position, angle, velocity in [((-2.4, 1.7), -0.6, (2.5, -1)), ((0, 0), 0, (0, 0))]:
        body = pymunk.Body(mass=10, moment=5)
        body.position = position
        body.angle = angle
        body.velocity = velocity
        shape = pymunk.Poly.create_box(body, (2.2, 0.3))
        shape.elasticity = elasticity
        space.add(body, shape)

    def called(arbiter: pymunk.Arbiter, space: pymunk.Space, name: Any) -> None:
        note(f"impulse {arbiter.total_impulse.length:.2f} N s   {name}")

    # One function for all callbacks: Pymunk hands it the `data` that it was given for each, here
    # the name.
    for name in ("begin", "pre_solve", "post_solve", "separate"):
        callback: dict[str, Any] = {name: called}
        space.on_collision(**callback, data=name)
    return space


def calm(space: pymunk.Space, time: float) -> None:
    """Live, let the benches come to rest, so that one can be dragged against the other."""
    for body in space.bodies if time > 1 else []:
        body.velocity = 0.97 * body.velocity
        body.angular_velocity = 0.97 * body.angular_velocity


slider = Slider("elasticity", 0, 1, label="Elasticity", rebuilds=True)
LIVE: dict[str, Any] = {"step": 0.02, "on_step": calm, "controls": [slider], "events": events}

# %%
calls = list[str]()


def noted(call: str) -> None:
    """Print a call with its step, and keep it for the film. `begin` fails."""
    calls.append(f"step {step}   {call}")
    print(calls[-1])
    if call.endswith("begin"):
        raise ValueError("an error in begin")


space = build(note=noted)
# An error that no caller can catch goes to this hook of Python, which by default writes it to
# stderr.
usual = sys.unraisablehook
sys.unraisablehook = lambda lost: print(f"hook:    {lost.exc_value}")
frames = []
for step in range(70):  # noqa: B007  # `noted` prints it.
    space.step(0.02)
    frame = Image.new("RGB", (400, 380), "white")
    options = PillowDrawOptions(frame, positive_y_is_up=True, line_width=2)
    options.fit(pymunk.BB(-2.6, -2.9, 2.6, 2.04))
    space.debug_draw(options)
    draw = ImageDraw.Draw(frame)
    # In symbols, as the film is the same in all languages.
    symbols = "\n".join(calls).replace("step", "n =").replace("impulse", "J =")
    draw.text((90, 230), symbols, "black", font_size=14)
    frames.append(frame)
sys.unraisablehook = usual
*_, body = space.bodies
print(f"afterwards the bench of {body.mass:.0f} kg goes at {body.velocity.length:.3f} m/s")
first, *others = frames
duration = [60] * 69 + [4000]  # ms
first.save("callbacks.gif", save_all=True, append_images=others, duration=duration, loop=0)

# %%
# A function of ours that fails as the dragon meets itself, called by `simulate`.
try:
    simulate(
        March(Dragon(benches=12)),
        start=412,
        on_event=lambda event: print(f"{event.phase}: {1 / 0}"),
    )
except ZeroDivisionError as error:
    print(f"caught:  {error}")
frames[40]

# %% [markdown]
# ## Answer
# `begin` and `separate` come once, `pre_solve` and `post_solve` in every step between. Only
# `post_solve` comes when the solver has computed the impulse of the step: before it one reads that
# of the step before.
#
# Which one has the impulse first?
# - `begin`: the benches touch there, but nothing is computed yet, and it reads 0.
# - `pre_solve`: it comes in the same step, but before the solver, as its name says.
# - **`post_solve`**: 3.29 N s, and the bench that lay still leaves at 0.329 m/s.
# - `separate`: only then the blow is over, but Pymunk has emptied the contact by then: it reads 0.
# ## Check
# The impulse of 3.29 N s is what sets the bench in motion: divide it by 10 kg, and compare the
# speed.
# ## Try
# Watch which calls come once, which again and again, and with which impulse (in the film $n$ is the
# step and $J$ the impulse). Then drag one bench so that it slowly pushes the other along. What is
# the impulse of a contact that lasts?
# ## Change
# Set `elasticity`, their bounce, to 0. Why is there less of an impulse, but more of the calls?
# ## Teacher
# - A course in programming; functions and exceptions in Python. 45 minutes: 5 to guess, 20 on the
#   stage, 20 to compare.
# - Goal: a library that calls back decides when, and with which state. An exception does not cross
#   C code by itself.
# - Try: while a contact lasts, each step has the impulse of the force of the hand, without the blow
#   of the first.
# - Mistakes: the impulse is read before it is computed; an error that nobody sees is taken for no
#   error.
# - Ask next: which are called in every step of the contact? `pre_solve` and `post_solve`, in steps
#   40, 41 and 42 of the program; the contact is there in each step, but `begin` and `separate`
#   report changes only.
# - In the program `begin` also raises an error, which does not pass through the C code that calls
#   back: Python only reports it, and the benches bounce as if nothing had been. So `simulate` keeps
#   such an error and raises it when the step is over.
