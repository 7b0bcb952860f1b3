"""Lengths of steps that change gradually."""

from __future__ import annotations

# Two steps in a row differ in length by this ratio at most. Pymunk's solver begins a step with the impulses of the step
# before. After a change by a ratio c, it begins the second step with impulses that are wrong by |c - 1|, and errors of
# several steps add up along a chain. With 1 % a step, forces of 30 benches that are pulled over the ground are within
# 2 %, and those of 100 within 10 %; where the step becomes a third at once, they are wrong by 113 and 194 %. The slider
# of a page goes from its middle to an end in 230 steps.
STEP_RATIO = 1.01


def next_length(before: float, chosen: float) -> float:
    """Length of the next step, s, after one of `before` s: the chosen one, or one that is nearer to it.

    Any length may follow where no step was made yet, and `before` is 0.

    Examples
    --------
    >>> next_length(0.01, 0.02), next_length(0.01, 0.01005), next_length(0.0, 0.02)
    (0.0101, 0.01005, 0.02)
    """
    if before == 0:
        return chosen
    return min(max(chosen, before / STEP_RATIO), before * STEP_RATIO)
