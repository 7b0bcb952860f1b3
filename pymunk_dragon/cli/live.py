"""`pymunk-dragon live`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from pymunk_dragon._extras import library
from pymunk_dragon._language import text
from pymunk_dragon.cli import common
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.sessions.ready import SCENES, Ready, dragon, planned, ready
from pymunk_dragon.sessions.recording import RECORDING_ENDINGS, Log, record
from pymunk_dragon.sessions.session import Session

_RECORD = "File to write at the end: inputs, .json, or the run of a dragon, .npz, which `render` films."


@common.command("", "near-miss", "--benches 60 --from 300 -o live.json", "--replay live.json --exit -o live.npz")
@click.argument("scene", required=False, type=click.Choice(list(SCENES)))
@common.scenario_options
@common.start_option
@click.option("--replay", metavar="FILE", type=click.Path(), help="Play a recording again, .json.")
@click.option("--exit", "ends", is_flag=True, help="Play the recording without a page, as fast as possible, and exit.")
@click.option("-o", "--record", "output", metavar="FILE", type=click.Path(), help=_RECORD)
@common.address_options
def live(scene: str | None, start: float, replay: str | None, ends: bool, output: str | None, **address: Any) -> None:
    """Play the dragon in real time, and touch it in a browser. A scene has its own dragon."""
    own = common.flags_given("scenario", *common.chosen(), "start")
    if sum(map(bool, (scene, own, replay))) > 1:
        raise click.UsageError("a ready scene and a recording have their own dragon: leave out the other options")
    if ends and replay is None:
        raise click.UsageError("--exit ends a replay: give a recording with --replay")
    if not ends:
        library("aiohttp")
    path = common.destination_of(output, RECORDING_ENDINGS)
    log = None if replay is None else Log.load(replay)
    session = Session(_source(scene or ("" if own else "dragon"), log) or dragon(common.march(), start=start))
    if log is not None:
        session.play_again(log)
    if ends:
        session.replay_until(math.inf)
        _wait_for_replay(session, log)
        _write(session, path)
    else:
        serve(session, log, path, **address)


def _source(scene: str, log: Log | None) -> Ready | None:
    """A ready scene, or that of a recording."""
    if log is None:
        return ready(scene) if scene else None
    if log.plan is None:
        raise ParameterError("replay", "a recording of a space or a curve of your own", "one of a scene that is known")
    return planned(log.plan)


def serve(session: Session, log: Log | None, path: Path | None, **address: Any) -> None:
    """Show a session on a page until it ends, and write what was recorded, also where it was interrupted."""
    from pymunk_dragon.sessions import handle

    running = handle.Live(session, **address)
    try:
        if address["host"] not in ("127.0.0.1", "localhost", "::1"):
            click.echo(text("Anybody who can reach this address and knows it can control the session:"), err=True)
        click.echo(text("control: {address}").format(address=running.address))
        click.echo(text("watch:   {address}").format(address=running.watch_address))
        _wait_for_replay(session, log)
        session.wait()
    finally:
        running.stop()
        _write(session, path)


def _wait_for_replay(session: Session, log: Log | None) -> None:
    """Wait for the end of a replay, and compare it with the recording: processors and libraries round differently."""
    if log is None or (poses := session.wait_for_replay()) is None:
        return
    if poses == log.poses:
        line = text("replay:  {steps} steps, equal to the recording to the bit")
    else:
        line = text("replay:  {steps} steps, poses within {difference:.1e} m and rad of the recording")
    click.echo(line.format(steps=log.steps, difference=log.difference(poses)))


def _write(session: Session, path: Path | None) -> None:
    """Write the recording, if there is a file for it."""
    if path is not None:
        record(session, path)
        common.wrote(path)
