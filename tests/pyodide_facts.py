"""What Python in Pyodide must find as Python does elsewhere; both sides call these functions."""

from pymunk_dragon import March, first_contact, simulate
from pymunk_dragon.sessions.scenes import SCENES

# Steps that a scene is played for.
STEPS = 500


def contact():
    """The first contact of the paper's dragon, and its near misses."""
    return first_contact(March()).to_dict()


def late_run():
    """The paper's dragon in the engine, from 400 s to its first contact."""
    return simulate(March(), start=400.0)


def scenes():
    """Poses of the bodies in every ready scene after its steps."""
    return {name: played(source.build({})).tolist() for name, source in SCENES.items()}


def played(scene):
    for _ in range(STEPS):
        scene.advance()
    # It reads forces and contacts from the engine's memory.
    scene.frame({})
    return scene.poses()
