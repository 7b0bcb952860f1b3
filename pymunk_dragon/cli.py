"""Words on the command line, exit codes, and nothing else.

Everything heavy is imported inside the command that needs it: `pymunk-dragon --help` shall answer at once.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pymunk_dragon.errors import DragonError, FileFormatError, MissingExtraError, ParameterError, UnreachableError

if TYPE_CHECKING:
    from pymunk_dragon.march import March
    from pymunk_dragon.run import Run

__all__ = ["cli", "main"]

Command = TypeVar("Command", bound=Callable[..., Any])

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
PROGRAM = "pymunk-dragon"

# Who may look for the first contact, and whose the settings of looking are.
METHODS = ("exact", "grid", "engine")
SETTINGS_OF = {"step": "grid", "tolerance": "grid", "fine": "engine"}
# The times of the paper's tables.
TABLE_TIMES = "0:300:60"
# Numbers in one list, and positions in one table: more fill the memory, and are a slip of the finger.
MAX_LIST, MAX_TABLE = 1_000_000, 20_000_000
# s: how much of a march `render` films when it is not told.
MARCH_FILM = 60.0

SCENARIO_OPTIONS = {
    "benches": (int, "N", "Number of benches.  [223]"),
    "head_spacing": (float, "M", "Distance between the head's holes, m.  [2.86]"),
    "body_spacing": (float, "M", "Distance between any other bench's holes, m.  [1.65]"),
    "overhang": (float, "M", "From a hole to the end of the bench, m.  [0.275]"),
    "width": (float, "M", "Width of the benches, m.  [0.3]"),
    "pitch": (float, "M", "Distance between the turns of the spiral, m.  [0.55]"),
    "turns": (float, "X", "Turn of the spiral on which the head starts.  [16]"),
    "speed": (float, "M/S", "Speed of the head, m/s.  [1]"),
}


def main(arguments: list[str] | None = None) -> None:
    """Run the program and exit: 0 done, 1 failed while running, 2 bad input, 130 interrupted."""
    sys.exit(_status(arguments))


def _status(arguments: list[str] | None) -> int:
    try:
        cli.main(arguments, prog_name=PROGRAM, standalone_mode=False)
        sys.stdout.flush()
        return DONE
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return BAD_INPUT
    except click.ClickException as error:
        return _complain(error.format_message(), BAD_INPUT)
    except (ParameterError, UnreachableError, FileFormatError, MissingExtraError) as error:
        return _complain(str(error), BAD_INPUT)
    except DragonError as error:
        return _complain(str(error), FAILED)
    except (KeyboardInterrupt, click.Abort):
        return _complain("interrupted", INTERRUPTED)
    except BrokenPipeError:
        # Whoever read our output has seen enough. Python would complain once more when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except MemoryError:
        return _complain("not enough memory for a dragon of this size", FAILED)


def _complain(message: str, status: int) -> int:
    click.echo(f"{PROGRAM}: " + " ".join(message.split()), err=True)
    return status


def scenario_options(command: Command) -> Command:
    """Give a command the options of a scenario, as one argument `scenario`: the chosen names and values."""

    def collect(context: click.Context, parameter: click.Parameter, value: Any) -> None:
        if value is not None:
            context.meta.setdefault("scenario", {})[parameter.name] = value

    for name, (kind, metavar, text) in reversed(SCENARIO_OPTIONS.items()):
        flag = "--" + name.replace("_", "-")
        add = click.option(flag, name, type=kind, metavar=metavar, help=text, callback=collect, expose_value=False)
        command = add(command)
    file = click.option("--scenario", "scenario_file", metavar="FILE.toml", help="Read these from a file; flags win.")
    return file(command)


json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object and nothing else.")
start_option = click.option("--from", "start", type=float, default=0.0, metavar="T", help="First time, s.  [0]")


def output_option(endings: str, required: bool = False) -> Callable[[Command], Command]:
    """The option -o; its ending chooses the format."""
    return click.option("-o", "--output", metavar="FILE", required=required, help=f"File to write: {endings}.")


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="pymunk-dragon", prog_name=PROGRAM)
def cli() -> None:
    """A bench dragon on its spiral: where it is, how fast, and when it runs into itself."""


@cli.command()
@scenario_options
@click.option("--times", metavar="LIST", help=f"Times, s: 0,60,120 or 0:300:1.  [{TABLE_TIMES}]")
@click.option("--handles", metavar="LIST", help="Handles.  [those of the paper's tables]")
@click.option("--paper", is_flag=True, help="Print the paper's tables 1 to 3 instead, cut as the paper cuts them.")
@json_option
@output_option(".csv, .json, or .xlsx for the contest's sheets with all handles")
def positions(
    scenario_file: str | None, times: str | None, handles: str | None, paper: bool, as_json: bool, output: str | None
) -> None:
    """Where the handles are and how fast, exactly."""
    march = _march(scenario_file)
    if paper:
        if times or handles or as_json or output:
            raise click.UsageError("--paper prints all of its tables: leave out --times, --handles, --json and -o")
        click.echo(_paper_tables(march))
        return
    from pymunk_dragon.words import POSITIONS, position_rows, positions_in_words

    last = march.dragon.handles - 1
    chosen = march.dragon.representatives if handles is None else _handles(handles, last)
    at = _numbers("times", times or TABLE_TIMES)
    if len(at) * march.dragon.handles > MAX_TABLE:
        raise ParameterError("times", times, f"at most {MAX_TABLE // march.dragon.handles} for this dragon")
    destination = _destination(output, (".csv", ".json", ".xlsx"))
    sheets = destination if destination is not None and destination.suffix.lower() == ".xlsx" else None
    if sheets is not None and handles is not None:
        raise click.UsageError("the contest's sheets have all handles: leave out --handles, or write .csv or .json")
    states = march.at(at)
    places, speeds = states.positions[:, chosen].tolist(), states.speeds[:, chosen].tolist()
    result = {"times": at, "handles": chosen, "positions": places, "speeds": speeds}
    if sheets is not None:
        _write_contest_tables(march, at, sheets)
    elif destination is not None:
        _write_table(destination, POSITIONS, position_rows(result), result)
    if as_json:
        _print_json(result)
    elif destination is None:
        click.echo(positions_in_words(result))


@cli.command()
@scenario_options
@click.option("--method", type=click.Choice(METHODS), default="exact", help="Who looks for it.  [exact]")
@click.option("--compare", is_flag=True, help="Ask all three, and print their answers side by side.")
@start_option
@click.option("--until", type=float, metavar="T", help="Last time, s.  [the end of the curve]")
@click.option("--step", type=float, metavar="T", help="Of the grid: s between looks.  [1]")
@click.option("--tolerance", type=float, metavar="T", help="Of the grid: how far it bisects, s.  [1e-6]")
@click.option("--fine", is_flag=True, default=None, help="Of the engine: a quarter of the usual substep.")
@json_option
@output_option(".json, or .xlsx for the contest's sheet of that moment")
def contact(
    scenario_file: str | None,
    method: str,
    compare: bool,
    start: float,
    until: float | None,
    as_json: bool,
    output: str | None,
    **settings: Any,
) -> None:
    """When benches that are not neighbours first touch, and where.

    The exact method certifies that nothing touched before, however briefly. The grid is the paper's way: it looks every
    so often, and bisects. The engine is Pymunk.
    """
    from pymunk_dragon.words import answer_in_words, comparison_in_words

    given = {name: value for name, value in settings.items() if value is not None}
    for name in given:
        if not compare and SETTINGS_OF[name] != method:
            raise click.UsageError(f"--{name} is of the {SETTINGS_OF[name]}: add --method {SETTINGS_OF[name]}")
    march = _march(scenario_file)
    destination = _destination(output, (".json", ".xlsx"))
    sheet = destination if destination is not None and destination.suffix.lower() == ".xlsx" else None
    if sheet is not None:
        _check_xlsx()
    asked = METHODS if compare else (method,)
    answers = [_answer(march, name, given, start=start, until=until) for name in asked]
    if compare:
        result: dict[str, Any] = {"methods": answers}
    else:
        # How long it took is no part of the answer: the same question has the same bytes.
        result = {name: value for name, value in answers[0].items() if name != "wall_seconds"}
    if sheet is not None:
        _write_contact_sheet(march, answers[0], sheet)
    elif destination is not None:
        _write_json(destination, result)
    if as_json:
        _print_json(result)
    else:
        click.echo(comparison_in_words(answers) if compare else answer_in_words(answers[0]))


@cli.command()
@scenario_options
@start_option
@click.option("--until", type=float, metavar="T", help="Last time, s.  [the end of the curve]")
@click.option("--guide", default="rails", metavar="NAME", help="What keeps it on the path: rails or none.  [rails]")
@click.option(
    "--contacts", default="stop", metavar="NAME", help="At the first contact: stop, report or resolve.  [stop]"
)
@click.option("--substep", type=float, metavar="T", help="s.  [the time in which the head goes 10 mm]")
@click.option("--iterations", type=int, metavar="N", help="Solver iterations in a substep.  [60]")
@click.option("--fine", is_flag=True, help="A quarter of the usual substep.")
@click.option("--frame-interval", type=float, metavar="T", help="s between frames.  [until the head goes 0.1 m]")
@json_option
@output_option(".npz")
def simulate(scenario_file: str | None, as_json: bool, output: str | None, fine: bool, **settings: Any) -> None:
    """Play the march in Pymunk until the dragon runs into itself."""
    from pymunk_dragon.words import answer_in_words, answer_of, quality_in_words, summary, windows_in_words

    march = _march(scenario_file)
    _destination(output, (".npz",))
    if fine and not (settings["substep"] is None and settings["iterations"] is None):
        raise click.UsageError("--fine chooses the substep and the iterations: leave out --substep and --iterations")
    run = _played(march, fine=fine, **settings)
    if output is not None:
        run.save(output)
    if as_json:
        _print_json(summary(run))
    else:
        click.echo(answer_in_words(answer_of("engine", run)))
        click.echo(quality_in_words(run))
        if settings["contacts"] != "stop":
            click.echo(windows_in_words(run))


@cli.command()
@click.argument("run_file", metavar="[RUN.npz]", required=False)
@scenario_options
@click.option("--from", "since", type=float, metavar="T", help="First time, s.  [the run's, or 0]")
@click.option("--until", type=float, metavar="T", help=f"Last time, s.  [the run's, or {MARCH_FILM:g} s of a march]")
@click.option("--speedup", type=float, metavar="X", help="Simulated seconds in a second of film.  [20]")
@click.option("--fps", type=int, metavar="N", help="Frames in a second: 10, 20, 25 or 50.  [10]")
@click.option("--size", metavar="PIXELS", help="Width and height: 440, or 640x360.  [440]")
@click.option("--camera", default="field", metavar="NAME", help="field: stand still; head: follow it.  [field]")
@click.option("--span", type=float, metavar="M", help="Width of the ground in view, m.")
@click.option("--hold", type=float, metavar="T", help="How long the last frame stays, s.  [1]")
@json_option
@output_option(".gif for a film, .png for a picture at --until", required=True)
def render(
    run_file: str | None,
    scenario_file: str | None,
    camera: str,
    span: float | None,
    size: str | None,
    as_json: bool,
    output: str,
    **choices: Any,
) -> None:
    """Film a run, or the exact march where no run is named."""
    from pymunk_dragon.render import FILM_ENDINGS, STILL_ENDINGS, Camera, Film, write_film, write_still
    from pymunk_dragon.run import Run

    destination = _destination(output, (*FILM_ENDINGS, *STILL_ENDINGS))
    assert destination is not None
    given = {name: value for name, value in choices.items() if value is not None}
    if size is not None:
        given["size"] = _size(size)
    source: Run | March
    if run_file is not None:
        if _chosen() or scenario_file:
            raise click.UsageError("a run brings its own scenario: leave out the options of the dragon and its curve")
        source = Run.load(run_file)
    else:
        source = _march(scenario_file)
        given.setdefault("until", min(given.get("since", 0.0) + MARCH_FILM, source.end))
    film = Film(camera=Camera(follow=camera, span=span), **given)  # type: ignore[arg-type]  # Camera checks the word.
    if destination.suffix.lower() in STILL_ENDINGS:
        last = float(source.times[-1]) if isinstance(source, Run) else given["until"]
        write_still(source, last if film.until is None else film.until, destination, film)
    else:
        with _progress("frame") as show:
            write_film(source, destination, film, lambda done, total: show(done, total, f"frame {done}"))
    if as_json:
        _print_json({"output": str(destination), "bytes": destination.stat().st_size})


@cli.command()
@click.argument("run_file", metavar="RUN.npz")
@json_option
@output_option(".html, .md, .xlsx, .csv or .json", required=True)
def report(run_file: str, as_json: bool, output: str) -> None:
    """Tell what happened in a run, as a document or a table."""
    from pymunk_dragon.report import REPORT_ENDINGS
    from pymunk_dragon.report import report as write_report
    from pymunk_dragon.run import Run

    destination = _destination(output, REPORT_ENDINGS)
    assert destination is not None
    with _progress("report") as show:
        write_report(Run.load(run_file), destination, lambda done, total: show(done, total, "report"))
    if as_json:
        _print_json({"output": str(destination), "bytes": destination.stat().st_size})


def _chosen() -> dict[str, Any]:
    """The scenario options that were given as flags."""
    found: dict[str, Any] = click.get_current_context().meta.get("scenario", {})
    return found


def _march(scenario_file: str | None) -> March:
    """The march of a scenario file with the flags laid over it."""
    from pymunk_dragon.scenario import Scenario

    values = Scenario.read(scenario_file) if scenario_file is not None else {}
    return Scenario.from_mapping({**values, **_chosen()}).march()


def _played(march: March, *, fine: bool, **settings: Any) -> Run:
    from pymunk_dragon.physics import simulate as play
    from pymunk_dragon.physics.simulation import FINE_ITERATIONS, FINE_STRIDE

    if fine:
        settings |= {"substep": FINE_STRIDE / march.speed, "iterations": FINE_ITERATIONS}
    given = {name: value for name, value in settings.items() if value is not None}
    start = given["start"]
    with _progress("t") as show:

        def tell(time: float, until: float) -> None:
            show(time - start, until - start, f"t = {time:.1f} s")

        return play(march, progress=tell, **given)


def _answer(
    march: March, method: str, settings: dict[str, Any], *, start: float, until: float | None
) -> dict[str, Any]:
    """What one method finds, and what that costs."""
    from time import perf_counter

    from pymunk_dragon.collision import first_contact, scan
    from pymunk_dragon.words import answer_of

    own = {name: value for name, value in settings.items() if SETTINGS_OF[name] == method}
    begin = perf_counter()
    if method == "engine":
        run = _played(march, fine=own.get("fine", False), start=start, until=until)
        answer = answer_of(method, run) | {"looks": run.provenance["substeps"], "tests": None}
    else:
        look = first_contact if method == "exact" else scan
        with _progress("t") as show:

            def tell(time: float, last: float) -> None:
                show(time - start, last - start, f"t = {time:.1f} s")

            found = look(march, start=start, until=until, progress=tell, **own)
        answer = answer_of(method, found) | {"looks": found.looks, "tests": found.tests}
    return answer | {"wall_seconds": perf_counter() - begin}


def _paper_tables(march: March) -> str:
    from pymunk_dragon.collision import first_contact
    from pymunk_dragon.report import paper_tables

    impact = first_contact(march)
    return paper_tables(march, impact.time if impact.status == "contact" else None)


def _write_contest_tables(march: March, times: list[float], path: Path) -> None:
    from pymunk_dragon.report import write_tables

    with _progress("row") as show:
        write_tables(march, times, path, lambda done, total: show(done, total, f"row {done}"))


def _check_xlsx() -> None:
    from pymunk_dragon.report.extras import library

    library("xlsxwriter")


def _write_contact_sheet(march: March, answer: dict[str, Any], path: Path) -> None:
    from pymunk_dragon.report import write_contact_table

    if answer["time"] is None:
        raise DragonError(f"no contact until t = {answer['until']:.6g} s, so {path} was not written")
    write_contact_table(march, answer["time"], path)


def _destination(output: str | None, endings: tuple[str, ...]) -> Path | None:
    """Check where to write before the long work that makes what is written."""
    if output is None:
        return None
    from pymunk_dragon.files import check_destination

    return check_destination(output, endings)


def _numbers(name: str, text: str) -> list[float]:
    """Numbers from `0,60,120` or `0:300:1`, both ends included, or a mixture."""
    bound = "numbers such as 0,60,120 or first:last:step such as 0:300:1"
    numbers: list[float] = []
    for part in text.split(","):
        try:
            values = [float(value) for value in part.split(":")]
        except ValueError:
            raise ParameterError(name, text, bound) from None
        if len(values) == 1:
            numbers += values
        elif len(values) == 3 and all(abs(value) < float("inf") for value in values) and values[2] > 0:
            first, last, step = values
            # A millionth of a step is rounding, as in 0:1:0.1.
            count = (last - first) / step + 1e-6
            if not 0 <= count < MAX_LIST:
                raise ParameterError(name, text, f"at least one and at most {MAX_LIST} numbers, first:last:step")
            numbers += [first + step * i for i in range(int(count) + 1)]
        else:
            raise ParameterError(name, text, bound)
    return numbers


def _handles(text: str, last: int) -> list[int]:
    numbers = _numbers("handles", text)
    if not all(number.is_integer() and 0 <= number <= last for number in numbers):
        raise ParameterError("handles", text, f"whole numbers from 0 to {last}")
    return [int(number) for number in numbers]


def _size(text: str) -> int | tuple[int, int]:
    try:
        lengths = [int(length) for length in text.lower().split("x")]
    except ValueError:
        lengths = []
    if len(lengths) not in (1, 2):
        raise ParameterError("size", text, "pixels such as 480, or 640x360")
    return lengths[0] if len(lengths) == 1 else (lengths[0], lengths[1])


@contextmanager
def _progress(label: str) -> Iterator[Callable[[float, float, str], None]]:
    """A bar on stderr with the time left, where that is a terminal; gives `show(done, total, label)`."""
    parts = 1000
    with click.progressbar(length=parts, label=label, file=sys.stderr, hidden=not sys.stderr.isatty()) as bar:

        def show(done: float, total: float, now: str) -> None:
            bar.label = now
            step = int(parts * done / total) - bar.pos
            if step > 0:
                bar.update(step)

        yield show


def _write_table(path: Path, heads: tuple[str, ...], rows: list[tuple[float, ...]], result: dict[str, Any]) -> None:
    import csv

    from pymunk_dragon.files import written_in_place

    if path.suffix.lower() == ".json":
        _write_json(path, result)
        return
    with written_in_place(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(heads)
        writer.writerows(rows)


def _write_json(path: Path, result: dict[str, Any]) -> None:
    from pymunk_dragon.files import written_in_place

    with written_in_place(path) as draft:
        draft.write_text(json.dumps(result) + "\n", encoding="utf-8")


def _print_json(result: dict[str, Any]) -> None:
    click.echo(json.dumps(result))
