"""The first contact by IPC Toolkit (`ipctk`), an independent program for continuous collision detection in C++.

It is given the corners of all benches at two times, as vertices that edges join, and which benches are neighbours. By
Tight Inclusion, which is conservative, it says whether two edges come nearer to each other than a given distance while
every corner moves on a straight line. The corners move on curves. Within a step of h they leave their straight lines by
at most a h^2 / 8, a being their largest acceleration, so a step is clear if no edges come nearer than twice that.
"""

from __future__ import annotations

import ipctk
import numpy as np

from pymunk_dragon import March

# Bound on the accelerations, as a multiple of the largest second difference of all corners at 2001 times.
SAFETY = 2.0
# m: where Tight Inclusion ends its divisions. s: longest and shortest step.
TOLERANCE, LONGEST, SHORTEST = 1e-12, 0.02, 1e-10


def corners(march, times):
    return march.dragon.outlines(march.at(times).poses).reshape(len(times), -1, 2)


def acceleration_bound(march, start, until, difference=1e-3):
    middle = np.linspace(start, until, 2001)
    before, at, after = (corners(march, middle + shift) for shift in (-difference, 0, difference))
    return SAFETY * np.linalg.norm(before - 2 * at + after, axis=-1).max() / difference**2


def cleared_by_ipc_toolkit(march: March, start: float, until: float) -> tuple[float, tuple[int, int]]:
    """Time up to which no benches touch but neighbours, s, and the benches of the closest edges there."""
    bound, time, step = acceleration_bound(march, start, until), start, LONGEST
    here, method = np.asfortranarray(corners(march, [start])[0]), ipctk.TightInclusionCCD(tolerance=TOLERANCE)
    edges = [(4 * bench + side, 4 * bench + (side + 1) % 4) for bench in range(len(here) // 4) for side in range(4)]
    mesh = ipctk.CollisionMesh(here, np.array(edges, dtype=np.int32, order="F"))
    near = {(i, j): False for i in range(len(here)) for j in range(i + 1, min(4 * (i // 4) + 8, len(here)))}
    mesh.can_collide = ipctk.make_sparse_filter(near, default_value=True)
    ipctk.set_logger_level(ipctk.error)  # It warns of every step that is not clear.
    assert not ipctk.has_intersections(mesh, here)
    while step > SHORTEST and time < until:
        there = np.asfortranarray(corners(march, [time + step])[0])
        if ipctk.is_step_collision_free(mesh, here, there, bound * step**2 / 4, narrow_phase_ccd=method):
            time, here, step = time + step, there, min(2 * step, LONGEST)
        else:
            step /= 2
    found = ipctk.Candidates()
    found.build(mesh, here, 1e-6)
    closest = min(found.ev_candidates, key=lambda each: each.compute_distance(each.dof(here, mesh.edges, mesh.faces)))
    bench, other = sorted((closest.vertex_id // 4, closest.edge_id // 4))
    return time, (bench, other)
