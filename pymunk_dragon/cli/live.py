"""`pymunk-dragon live`."""

import math
from pathlib import Path
from time import sleep
from typing import Any

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli.options import (
    address_options,
    chosen_march,
    command,
    flags_given,
    option_values,
    scenario_options,
    start_option,
)
from pymunk_dragon.cli.output import destination_of, write_result
from pymunk_dragon.sessions.live import Live
from pymunk_dragon.sessions.replay import Log, load_log
from pymunk_dragon.sessions.scenes import SCENES, march_scene, named_scene, recorded_scene
from pymunk_dragon.sessions.session import Session


@command("", "near-miss", "--benches 60 --from 300 -o live.json", "--replay live.json --exit")
@click.argument("scene", metavar="[SCENE]", required=False, type=click.Choice(list(SCENES)))
@scenario_options
@start_option
@click.option("--replay", type=click.Path(), help="Play a recording again, .json.")
@click.option(
    "--exit",
    "ends",
    is_flag=True,
    help="Play the recording without a page, as fast as possible, and exit.",
)
@click.option("-o", "--record", "output", type=click.Path(), help="File .json for the inputs.")
@address_options
def live(
    scene: str | None,
    start: float,
    replay: str | None,
    ends: bool,
    output: str | None,
    **address: Any,
) -> None:
    """Play the dragon in real time, and touch it in a browser. A scene has its own dragon."""
    own = flags_given("scenario", *option_values(), "start")
    if sum(map(bool, (scene, own, replay))) > 1:
        rule = "a built-in scene and a recording have their own dragon"
        raise click.UsageError(f"{rule}: leave out the other options")
    if ends and replay is None:
        raise click.UsageError("--exit ends a replay: give a recording with --replay")

    path = destination_of(output, [".json"])
    log = None
    if replay is not None:
        log = load_log(replay)
        source = recorded_scene(log["plan"])
    elif own:
        source = march_scene(chosen_march(), start=start)
    else:
        source = named_scene(scene or "dragon")
    session = Session(source, log=log)
    if ends:
        _replay_at_once(session, log, path)
    else:
        serve(session, log, path, **address)


def serve(session: Session, log: Log | None, path: Path | None, **address: Any) -> None:
    """Show a session on a page until it ends or is interrupted, and write what was recorded."""
    running = Live(session, **address)
    try:
        if address["host"] not in ("127.0.0.1", "localhost", "::1"):
            click.echo(
                text("Anybody who can reach this address and knows it can control the session:"),
                err=True,
            )
        click.echo(text("control: {address}", address=running.address))
        click.echo(text("watch:   {address}", address=running.watch_address))
        _wait_for_replay(session, log)
        # Until Ctrl-C.
        while True:
            sleep(1)
    finally:
        running.stop()
        if path is not None:
            write_result(path, session.log())


def _replay_at_once(session: Session, log: Log | None, path: Path | None) -> None:
    """Play a recording again as fast as possible."""
    session.clock.speed = math.inf
    session.start()
    try:
        _wait_for_replay(session, log)
    finally:
        session.stop()
    if path is not None:
        write_result(path, session.log())


def _wait_for_replay(session: Session, log: Log | None) -> None:
    """Wait for the end of a replay, and compare it with the recording.

    Processors and libraries round differently.
    """
    difference = session.wait_for_replay()
    if log is None or difference is None:
        return
    found = "replay:  {steps} steps, equal to the recording to the bit"
    if difference != 0:
        found = "replay:  {steps} steps, poses within {difference:.1e} m and rad of the recording"
    click.echo(text(found, steps=log["steps"], difference=difference))
