"""The first contact by IPC Toolkit (`ipctk`), a collision library that others wrote in C++.

It is given the corners of all benches at two times, as vertices that edges join, and which benches
are neighbours. By Tight Inclusion, which is conservative, it says whether edges come nearer to each
other than a distance while the corners move on straight lines. The true corners leave these in a
step of h by at most a h^2 / 8, a being their largest acceleration. So a step is clear if no edges
come nearer than twice that.
"""

import ipctk
import numpy as np

# Bound on accelerations over the largest second difference of a corner at 2001 times.
SAFETY = 2.0
# Time between the samples of a second difference, s.
DIFFERENCE = 1e-3
# Length at which Tight Inclusion ends its divisions, m.
TOLERANCE = 1e-12
# Longest step, s.
LONGEST = 0.02
# Shortest step, s.
SHORTEST = 1e-10


def cleared_by_ipc_toolkit(march, start, until):
    """Time up to which only neighbours touch, s, and the benches of the closest edges then."""

    def corners(times):
        return march.dragon.outlines(march.at(times).poses).reshape(-1, 4 * march.dragon.benches, 2)

    before, now, after = (
        corners(np.linspace(start, until, 2001) + k * DIFFERENCE) for k in (-1, 0, 1)
    )
    bound = SAFETY * np.linalg.norm(before - 2 * now + after, axis=-1).max() / DIFFERENCE**2
    time = start
    step = LONGEST
    here = np.asfortranarray(now[0])
    edges = [(k, 4 * (k // 4) + (k + 1) % 4) for k in range(len(here))]
    mesh = ipctk.CollisionMesh(here, np.array(edges, dtype=np.int32, order="F"))
    near = {
        (i, j): False
        for i in range(len(here))
        for j in range(i + 1, min(4 * (i // 4) + 8, len(here)))
    }
    mesh.can_collide = ipctk.make_sparse_filter(near, default_value=True)
    ipctk.set_logger_level(ipctk.error)  # It warns of each step that is not clear.
    assert not ipctk.has_intersections(mesh, here)
    while step > SHORTEST and time < until:
        there = np.asfortranarray(corners([time + step])[0])
        method = ipctk.TightInclusionCCD(tolerance=TOLERANCE)
        if ipctk.is_step_collision_free(
            mesh, here, there, bound * step**2 / 4, narrow_phase_ccd=method
        ):
            time = time + step
            here = there
            step = min(2 * step, LONGEST)
        else:
            step /= 2
    found = ipctk.Candidates()
    found.build(mesh, here, 1e-6)
    closest = min(
        found.ev_candidates,
        key=lambda each: each.compute_distance(each.dof(here, mesh.edges, mesh.faces)),
    )
    return time, (
        min(closest.vertex_id, closest.edge_id) // 4,
        max(closest.vertex_id, closest.edge_id) // 4,
    )
