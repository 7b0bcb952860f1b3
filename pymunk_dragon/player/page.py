"""The player page: one self-contained HTML file with its style, script and data."""

from html import escape
from itertools import chain
from pathlib import Path

from pymunk_dragon._files import check_destination, write_text
from pymunk_dragon._language import in_language, language
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import Run
from pymunk_dragon.player.data import player_data
from pymunk_dragon.reports.document import headline, provenance, subtitle
from pymunk_dragon.reports.summary import Summary, summarize
from pymunk_dragon.web.html import asset, embedded_json
from pymunk_dragon.web.page import catalogue, document

PLAYER_ENDINGS = (".html",)


def write_player(run: Run, path: str | Path, *, title: str | None = None) -> None:
    """Write the page of `player_page` to a file.

    Parameters
    ----------
    run : Run
        The run to show.
    path : path
        File to write, which ends in .html. An interruption leaves the old file or none.
    title : str, optional
        Heading of the page; by default the result of the run.

    Raises
    ------
    ParameterError
        If a parameter is unusable.
    OutputError
        If writing fails.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, Run, write_player
    >>> write_player(Run.exact(March(Dragon(benches=8)), [0.0, 1.0]), "run.html")
    """
    destination = check_destination(path, PLAYER_ENDINGS)
    write_text(destination, player_page(run, title=title))


def player_page(run: Run, *, title: str | None = None) -> str:
    """Page that plays a run, as a string: one HTML document that needs no network.

    Parameters
    ----------
    run : Run
        The run to show. A run of the exact model has no contacts of its own; the exact first
        contact is added.
    title : str, optional
        Heading of the page; by default the result of the run.

    Raises
    ------
    ParameterError
        If `run` is not a Run, or the title is not a string.

    Notes
    -----
    The page's `dragon` is a promise of an object that controls the player. A page that holds it in
    a frame without a sandbox may call
    `frame.contentWindow.dragon.then((player) => player.seek(409.8))`. A link has the same effect:
    `#t=409.8&follow=head`. `show=curve,contacts,exact` chooses what is drawn, `slow=off` switches
    slow motion off, and `lang=zh`, or `?zh` before the `#`, chooses Chinese. Only the page of a run
    of the engine has the exact model's positions.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> player_page(Run.exact(March(), [0, 1]), title="Start")[:15]
    '<!doctype html>'
    """
    if not isinstance(title, str | None):
        raise ParameterError("title", title, "a text")
    summary = summarize(run)
    payload, packed = player_data(summary)
    english = _texts_of(summary, "en")
    chinese = _texts_of(summary, "zh")
    own = {one: two for one, two in zip(english, chinese, strict=True) if one != two}
    texts = catalogue(__package__) | own
    # A file cannot hold halves of surrogate pairs.
    heading = title.encode("utf-8", "replace").decode("utf-8") if title else english[0]

    body = asset(__package__, "assets/player.html")
    style = asset(__package__, "assets/layout.css")
    page, _ = document(
        "player",
        body,
        style,
        language=language(),
        title=escape(heading),
        subtitle=escape(english[1]),
        provenance=_provenance_html(summary),
        last_bench=str(run.march.dragon.benches - 1),
        texts=embedded_json({"zh": texts}),
        payload=embedded_json(payload),
        **packed,
    )
    return page


def _texts_of(summary: Summary, code: str) -> list[str]:
    """Texts about the run in a language: headline, subtitle and provenance."""
    with in_language(code):
        texts = [headline(summary), subtitle(summary)]
        for heading, table in provenance(summary).tables.items():
            texts += [heading, *chain.from_iterable(table.rows)]
        return texts


@in_language("en")
def _provenance_html(summary: Summary) -> str:
    """Provenance of the run, as in reports."""
    html = ""
    for heading, table in provenance(summary).tables.items():
        rows = ""
        for name, value in table.rows:
            rows += f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>"
        html += f"<div><h3>{escape(heading)}</h3><dl>{rows}</dl></div>"
    return html
