"""Joint gaps and depths where contacts are resolved: `python tests/bench/bench_pile_up.py`.

The reference scenario, from half a second before its first contact to 10 s after it. A joint's gap is the distance of
its two holes, a depth that of two benches inside each other, both at the end of every substep from the contact on.
"""

from __future__ import annotations

import numpy as np
from measure import sized

from pymunk_dragon.model.march import March
from pymunk_dragon.physics import simulate

CONTACT = 412.474
SUBSTEPS, FORCES = sized(((1 / 100, 1 / 200, 1 / 400), (300.0, None, 1000.0, 3000.0)), ((1 / 100,), (None,)))
# s after the contact, and at the end of a run, when the dragon should be at rest.
PLAYED, AT_REST = sized((10.0, 5.0), (0.5, 0.1))


def main() -> None:
    """Print the table."""
    march = March()
    print(f"{'substep, ms':>12}{'force, N':>10}{'joint gap, mm':>15}{'depth, mm':>11}", end="")
    print(f"{f'moved in the last {AT_REST:g} s, mm':>29}")
    for substep in SUBSTEPS:
        for force in FORCES:
            run = simulate(
                march,
                start=CONTACT - 0.5,
                until=CONTACT + PLAYED,
                contacts="resolve",
                substep=substep,
                frame_interval=substep,
                head_force=force,
            )
            assert run.first_contact is not None
            assert run.settings is not None
            front, rear = march.dragon.holes(run.poses[run.times >= run.first_contact.time])
            gap = np.linalg.norm(front[:, 1:] - rear[:, :-1], axis=-1).max()
            depth = max(event.depth or 0.0 for event in run.events if event.phase == "pre_solve")
            end = run.poses_at([run.times[-1] - AT_REST, run.times[-1]])[..., :2]
            moved = np.linalg.norm(end[1] - end[0], axis=-1).max()
            row = (1e3 * substep, run.settings.head_force, 1e3 * gap, 1e3 * depth, 1e3 * moved)
            print("{:>12.1f}{:>10.0f}{:>15.3f}{:>11.3f}{:>29.2f}".format(*row))


if __name__ == "__main__":
    main()
