"""`pymunk-dragon publish`."""

import shlex
from pathlib import Path

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli.options import command
from pymunk_dragon.cli.output import progress


@command("site", "program.py site --include picture.png", "site --offline pyodide")
@click.argument("places", metavar="[PROGRAM.py] FOLDER", nargs=-1)
@click.option(
    "--include",
    multiple=True,
    help="A file that the program reads or imports; also several times.",
)
@click.option(
    "--offline",
    help="Folder with a copy of Pyodide, which is put into FOLDER: the page needs no other server.",
)
@click.option(
    "--address",
    help="Where FOLDER will be, as https://example.org/dragon/: links to it show a picture.",
)
def publish(
    places: tuple[str, ...], include: tuple[str, ...], offline: str | None, address: str | None
) -> None:
    """Write a folder for the web: lessons and scenes, or your program.

    The program calls `live`. The engine runs in the reader's browser, and nothing on the server.
    """
    from pymunk_dragon.publish.site import publish_program, publish_site

    if len(places) not in (1, 2) or (include and len(places) == 1):
        raise click.UsageError(
            "give a folder, or a program and a folder; --include needs a program"
        )
    *program, folder = places
    if program:
        publish_program(program[0], folder, include=include, runtime=offline, address=address)
    else:
        with progress("publish") as show:
            publish_site(folder, runtime=offline, address=address, progress=show)
    place = shlex.quote(str(Path(folder)))
    click.echo(text("to see it: {command}", command=f"python -m http.server -d {place}"))
