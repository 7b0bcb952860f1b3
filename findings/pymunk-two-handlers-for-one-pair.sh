#!/usr/bin/env bash
# Pymunk: `on_collision(1, 2, ...)` and `on_collision(2, 1, ...)` are two handlers, and both run
# for each pair.
#
# Expected: a pair of types has one handler, so the second call replaces the first, as the
# documentation says of several calls "with the same combination" of types.
# Seen: both run, each with the shapes in the order of its own types; which one runs first depends
# on the pair. Two shapes of type 1 also call the one handler of `on_collision(1, None, ...)`
# twice in each phase, once in each order.
# Versions: pymunk 7.3.1, cffi 2.1.1, CPython 3.11.7, Linux on x86-64.
# Source: measurement; Munk2D looks handlers up by the ordered pair of types, and calls those of
# (a, b), (b, a), (a, any), (b, any) and (any, any). Pymunk's issue 280 discusses whether the
# order should matter, its issue 289 asked for the second call of (1, None), which came with
# version 7.1.0. In Pymunk 6.11.1, measured too, both calls return one handler, and no other
# handler runs beside it.
# Why it matters: scores, damage and sounds are counted twice after a port from Pymunk 6, without
# an error.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pymunk==7.3.1 cffi==2.1.1

"$folder/venv/bin/python" - <<'PROGRAM'
import sys

import pymunk


def calls(types, handlers):
    """The handlers that run for two shapes that touch, each with the types of its shapes."""
    space, found = pymunk.Space(), []
    for number, kind in enumerate(types):
        body = pymunk.Body(1, 1)
        body.position = 1.8 * number, 0
        shape = pymunk.Circle(body, 1)
        shape.collision_type = kind
        space.add(body, shape)

    def called(arbiter, space, handler):
        found.append((handler, tuple(shape.collision_type for shape in arbiter.shapes)))

    for handler in handlers:
        space.on_collision(*handler, begin=called, data=handler)
    space.step(0.01)
    return sorted(found)


both = calls((1, 2), [(1, 2), (2, 1)])
print("shapes of types 1 and 2 call", both)
twice = calls((1, 1), [(1, None)])
print("two shapes of type 1 call   ", twice)
same = both == [((1, 2), (1, 2)), ((2, 1), (2, 1))] and twice == [((1, None), (1, 1))] * 2
sys.exit(0 if same else "this is no longer what was found")
PROGRAM
