"""A chain followed in small steps of its head: the truth about jackknifed benches, slow and simple.

It uses nothing of the package but points and tangents of a curve. Each rear handle is found by
Newton's method from where it was a step before; where the method fails or jumps, motion has ended.
"""

import numpy as np

from pymunk_dragon import Arc, Composite, Line

# The head's step, m.
STEP = 5e-3
# Longest way of a rear handle in a step, m.
JUMP = 0.3


def follow(curve, start, heads, spacings, step=STEP):
    """States (n, H) of the first n `heads` (T,) in order, and the head's s where motion ends."""
    state, states = np.array(start), []
    direction = np.sign(heads[-1] - state[0])
    for aim in heads:
        while (aim - state[0]) * direction > 0:
            state[0] = state[0] + direction * min(step, abs(aim - state[0]))
            for i, spacing in enumerate(spacings):
                rear = _rear(curve, state[i], state[i + 1], spacing)
                if rear is None:
                    return np.array(states).reshape(-1, state.size), float(state[0])
                state[i + 1] = rear
        states.append(state.copy())
    return np.array(states), np.inf


def _rear(curve, front, before, spacing):
    point, rear = curve.point(front), before
    for _ in range(40):
        if not curve.begin_s <= rear < front or abs(rear - before) > JUMP:
            return None
        between = point - curve.point(rear)
        step = (between @ between - spacing**2) / 2 / (between @ curve.tangent(rear))
        rear += step
        if abs(step) < 1e-12:
            return rear if rear >= curve.begin_s else None
    return None


def random_path(rng, pieces=8, tightest=0.5, straight=(4, 8)):
    """A straight line and then lines and arcs in random order, joined smoothly."""
    heading, length = 0.0, rng.uniform(*straight)
    path, here = [Line(start=(0, 0), stop=(length, 0))], complex(length)
    for _ in range(pieces):
        ahead = np.exp(1j * heading)
        if rng.random() < 0.3:
            there = here + rng.uniform(0.2, 2) * ahead
            path.append(Line(start=(here.real, here.imag), stop=(there.real, there.imag)))
        else:
            radius = float(np.exp(rng.uniform(np.log(tightest), np.log(4))))
            side, sweep = rng.choice([-1, 1]), rng.uniform(0.3, 3.5)
            centre = here + side * 1j * radius * ahead
            begin = heading - side * np.pi / 2
            path.append(
                Arc(
                    centre=(centre.real, centre.imag),
                    radius=radius,
                    begin_angle=begin,
                    sweep=side * sweep,
                )
            )
            heading += side * sweep
            there = centre - side * 1j * radius * np.exp(1j * heading)
        here = there
    return Composite(path)
