"""`pymunk-dragon live`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli.command import DragonCommand
from pymunk_dragon.cli.completion import files, named, words
from pymunk_dragon.cli.options import chosen, destination_of, march_of, scenario_options, start_option
from pymunk_dragon.cli.output import progress, wrote

if TYPE_CHECKING:
    from pymunk_dragon.sessions.log import Log
    from pymunk_dragon.sessions.scenes import Ready
    from pymunk_dragon.sessions.session import Session


def _scenes() -> dict[str, str]:
    """Names of the ready scenes, and their titles."""
    from pymunk_dragon.sessions.scenes import SCENES

    return {name: scene.title for name, scene in SCENES.items()}


@click.command(
    cls=DragonCommand,
    examples=("", "near-miss", "--benches 60 --from 300 -o live.npz", "--replay live.npz"),
    names=_scenes,
)
@click.argument("scene", required=False, shell_complete=named(_scenes))
@scenario_options
@start_option
@click.option(
    "--contacts",
    default="resolve",
    metavar="NAME",
    help="What contacts do: stop, report or resolve.  [resolve]",
    shell_complete=words("stop", "report", "resolve"),
)
@click.option("--free-from", type=int, metavar="N", help="First bench without dancers.  [all have dancers]")
@click.option(
    "--replay", metavar="FILE", help="Play a recording again, .npz or .json.", shell_complete=files(".npz", ".json")
)
@click.option("--exit", "ends", is_flag=True, help="Play the recording without a page, as fast as possible, and exit.")
@click.option(
    "-o",
    "--record",
    "output",
    metavar="FILE",
    shell_complete=files(),
    help="File to write at the end: a run, .npz, or a film, as .gif.",
)
@click.option("--port", type=int, default=0, metavar="N", help="Port.  [a free one]")
@click.option(
    "--host", default="127.0.0.1", metavar="ADDRESS", help="Address to listen on.  [127.0.0.1: this machine only]"
)
@click.option(
    "--allow-host", multiple=True, metavar="NAME", help="Name under which a proxy shows the page; repeatable."
)
@click.option("--no-browser", is_flag=True, help="Do not open a browser.")
@click.option("--paused", is_flag=True, help="Begin paused.")
def live(
    scene: str | None,
    scenario_file: str | None,
    start: float,
    contacts: str,
    free_from: int | None,
    replay: str | None,
    ends: bool,
    output: str | None,
    port: int,
    host: str,
    allow_host: tuple[str, ...],
    no_browser: bool,
    paused: bool,
) -> None:
    """Play the dragon in real time, and touch it in a browser.

    SCENE is a ready scene: {names}.
    """
    own = chosen() or scenario_file or start or free_from is not None or contacts != "resolve"
    if (scene is not None) + bool(own) + (replay is not None) > 1:
        raise click.UsageError("a ready scene and a recording have their own dragon: leave out the other options")
    if ends and replay is None:
        raise click.UsageError("--exit ends a replay: give a recording with --replay")
    from pymunk_dragon._extras import library

    if not ends:
        library("aiohttp")
    from pymunk_dragon.sessions import recording, scenes
    from pymunk_dragon.sessions.handle import serve
    from pymunk_dragon.sessions.log import Log
    from pymunk_dragon.sessions.session import Session

    path = destination_of(output, recording.RECORDING_ENDINGS)
    log = None if replay is None else Log.load(replay)
    source = _source(scene, log) or scenes.dragon(
        march_of(scenario_file), contacts=contacts, free_from=free_from, start=start
    )
    session = Session(source, record=path is not None, running=not paused)
    if log is not None:
        session.play_again(log.inputs, log.values, log.steps)
    if ends:
        _replay(session, log, path)
        return
    running = serve(session, host=host, port=port, allow_hosts=allow_host, browser=not no_browser, path=None)
    try:
        if host not in ("127.0.0.1", "localhost", "::1"):
            click.echo(text("Anybody who can reach this address and knows it can control the session:"), err=True)
        click.echo(text("control: {address}").format(address=running.address))
        click.echo(text("watch:   {address}").format(address=running.watch_address))
        if log is not None:
            _wait_for_replay(session, log)
        session.wait()
    finally:
        running.stop()
        if path is not None:
            _write(session, path)


def _source(scene: str | None, log: Log | None) -> Ready | None:
    """A ready scene, or that of a recording."""
    from pymunk_dragon.errors import ParameterError
    from pymunk_dragon.sessions.scenes import planned, ready

    if scene is not None:
        return ready(scene)
    if log is None:
        return None
    if log.plan is None:
        raise ParameterError("replay", "a recording of a space or a curve of your own", "one of a scene that is known")
    return planned(log.plan)


def _replay(session: Session, log: Log | None, path: Path | None) -> None:
    """Play a recording without a page, and write it as another file."""
    from pymunk_dragon.sessions.session import SPEEDS

    assert log is not None  # Called for a replay only.
    session.speed = SPEEDS[1]
    session.start()
    try:
        _wait_for_replay(session, log)
    finally:
        session.stop()
    if path is not None:
        _write(session, path)


def _wait_for_replay(session: Session, log: Log) -> None:
    """Wait for the end of a replay, and compare it with the recording.

    It may differ: processors, and versions of the libraries, round differently.
    """
    poses = session.wait_for_replay()
    if poses is None:
        return
    if poses == log.poses:
        line = text("replay:  {steps} steps, equal to the recording to the bit")
    else:
        line = text("replay:  {steps} steps, poses within {difference:.1e} m and rad of the recording")
    click.echo(line.format(steps=log.steps, difference=log.difference(poses)))


def _write(session: Session, path: Path) -> None:
    """Write the recording, with progress for a film."""
    from pymunk_dragon.sessions.recording import record

    label = text("writing {name}").format(name=path.name)
    with progress(label) as show:
        record(session, path, lambda done, total: show(done, total, label))
    wrote(path)
