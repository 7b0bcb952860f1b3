"""`pymunk-dragon demo`."""

from __future__ import annotations

import click

__all__ = ["demo"]


@click.command()
@click.argument("name", required=False)
@click.option("--save", metavar="DIR", help="Folder for the picture.")
@click.option("--lang", default="en", help="Language of the text.")
@click.option("--pause", is_flag=True)
def demo(name: str | None, save: str | None, lang: str, pause: bool) -> None:
    """Play a lesson; without a name, list them."""
    from pymunk_dragon.demos import DEMOS, Terminal

    if name is None:
        for one in DEMOS.values():
            click.echo(f"{one.name}  {one.title}")
        return
    DEMOS[name].play(Terminal(save, lang, pause))
