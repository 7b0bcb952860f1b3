"""A right call of each public function and class, and what else each of its arguments may be.

`CALLS` has functions, classes and methods by their names. Each argument has a right value and the
kinds of values that it takes; a value of any other kind has to be refused.
"""

import math
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from unittest import mock

import numpy as np
import pymunk
from PIL import Image

import pymunk_dragon as dragons
from pymunk_dragon import lessons, reports, studies
from pymunk_dragon.collision import Grid, first_contact, scan, separation
from pymunk_dragon.drawing import Camera, Film, figures, render, still_png
from pymunk_dragon.model.contact import Contact, ContactEvent, ContactLog
from pymunk_dragon.publish import site

# Values, each with the kinds that it has. A whole number is also a number, and that is also an
# array.
FUNCTION = lambda *arguments: None  # noqa: E731  # A value among others.
NUMBERS = {0: "int", -1: "int", 7: "int", 1.5: "number", -2.5: "number", 1e-320: "number"}
NUMBERS |= {
    1e308: "number",
    -1e308: "number",
    math.inf: "number",
    math.nan: "number",
    10**400: "int",
}
VALUES = [
    *(
        (value, {"int": "int number array", "number": "number array"}[kind])
        for value, kind in NUMBERS.items()
    ),
    *((value, "text path") for value in ("", "x", "spiral", "1", "a" * 300, "\0", "x.y")),
    *((value, "array list empty") for value in ([], ())),
    *((value, "array list") for value in ([1, 2], (0.5, 0.25), [0, 1e308], [math.nan], range(3))),
    *(
        (value, "array")
        for value in (np.zeros((2, 5)), np.zeros((0, 3)), np.arange(4.0) * 1e300, [[]])
    ),
    *((value, "list") for value in ([None], [[1], [1, 2]], [object()])),
    (["a"], "list texts"),
    *((value, "complex") for value in (1j, [1j])),
    *(
        (value, "")
        for value in (b"x", object(), np.array("x"), np.array([None]), {1, 2}, math, Ellipsis)
    ),
    (np.int64(3), "int number array"),
    *((value, "bool") for value in (True, False)),
    *((value, "mapping") for value in ({"x": 1}, {"x": None}, {1: 2})),
    ({}, "mapping empty"),
    (None, "none"),
    (FUNCTION, "function"),
    (Path("x"), "path"),
]

DRAGON = dragons.Dragon(benches=3, head_spacing=1.0, body_spacing=1.0, overhang=0.2)
LINE = dragons.Line(stop=(9.0, 0.0))
MARCH = dragons.March(DRAGON, LINE, start_s=5.0)
SPIRAL = dragons.March(dragons.Dragon(benches=4), turns=3)
RUN = dragons.Run.exact(MARCH, [0.0, 1.0])
POSES = np.zeros((3, 3))
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
CONTACT = Contact(
    time=0.5, raw_time=0.5, benches=(0, 2), point=(1.0, 1.0), normal=(1.0, 0.0), depth=0.0
)
EVENT = ContactEvent(time=0.5, phase="begin", benches=(0, 2))
TABLE = dragons.SpeedTable([0, 10], [1, 2])
STUDIED = dragons.max_speed(DRAGON)
THREAD = ThreadPoolExecutor(1)


@cache
def engine_run():
    """A run of the engine."""
    return dragons.simulate(MARCH, until=0.2, frame_interval=0.1)


def live(**arguments):
    """Begin and end a session, without a browser."""
    with mock.patch("webbrowser.open"), dragons.live(**arguments):
        pass


def own_space(links=3):
    """A space with a body."""
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    space.add(body, pymunk.Circle(body, 0.5))
    return space


def fitted(area, margin):
    """Fit a drawing to an area."""
    image = Image.new("RGB", (64, 64))
    dragons.PillowDrawOptions(image).fit(area, margin)


def changed(name, **arguments):
    """Change a world by one of its methods."""
    getattr(dragons.World(MARCH, until=1.0, contacts="resolve"), name)(**arguments)


def of_session(name, **arguments):
    """Call a method of a session without a server."""
    with dragons.live(own_space(), step=None, browser=False) as session:
        getattr(session, name)(**arguments)


def drawn(name):
    """A method that draws on a new picture."""
    return lambda **arguments: getattr(dragons.Draw(), name)(**arguments)


def turn(**arguments):
    """The study of the U-turn with a search that ends at once."""
    with mock.patch.object(
        sys.modules["pymunk_dragon.studies.u_turn"], "_shortest_turn", lambda base, *rest: base
    ):
        return dragons.u_turn(**arguments)


def answers(**arguments):
    """All five answers without the work, which takes long."""
    module = sys.modules["pymunk_dragon.studies.paper"]
    work = dict.fromkeys(("sensitivity", "max_speed", "u_turn"), mock.DEFAULT)
    with mock.patch.multiple(module, **work, slopes=lambda *given: ({}, {})):
        return studies.paper(**arguments)


FLOAT = (1.0, "number")
WHOLE = (2, "int")
OPTIONAL = (None, "number none")
COUNT = (None, "int none")
ARRAY = ([0.0, 1.0], "array")
TEXT = ("x", "text")
FLAG = (True, "bool")
PROGRESS = (None, "function none")
TIMES = ([0.0, 0.5], "array")
PAIR = ((1.0, 2.0), "array list")
ONE_MARCH = (MARCH, "")
ONE_RUN = (RUN, "")
ONE_DRAGON = (DRAGON, "none")
SIZES = (0.25, "number list array")
S = ([6.0, 7.0], "array")


def file(ending):
    """A file that can be written."""
    return "new" + ending, "path"


FILM = {
    **dict.fromkeys(("speedup", "start", "until"), OPTIONAL),
    **dict.fromkeys(("title", "caption"), TEXT),
    **{
        "fps": WHOLE,
        "size": (64, "int list array"),
        "hold": FLOAT,
        "camera": (Camera(), ""),
        "legend": FLAG,
    },
    **{"show": (("grid",), "empty"), "headings": (("x",), "empty")},
}
ENGINE = {
    **{
        "contacts": ("resolve", "text"),
        "substep": (0.01, "number none"),
        "iterations": (5, "int none"),
    },
    **{"drag": (11.5, "number"), "frame_interval": OPTIONAL, "head_force": OPTIONAL},
    "order": (2, "int"),
}
WINDOW = {"start": (0.0, "number"), "until": (0.2, "number none")}
SCENARIO = {
    **{
        "benches": COUNT,
        "head_spacing": FLOAT,
        "body_spacing": (1.0, "number array list"),
        "overhang": SIZES,
    },
    **{"width": SIZES, "pitch": OPTIONAL, "turns": OPTIONAL, "start_s": OPTIONAL},
    "speed": (1.0, "number list array path"),
}
CURVE = {
    **{name: {"s": S} for name in ("point", "tangent", "curvature", "frame")},
    "turns": {"s": FLOAT},
    "max_curvature": {"s": S, "other": S},
    "chain": {"s": S, "spacings": ([1.0], "array")},
    "foot": {"points": ([[6.0, 0.1]], "array"), "near": ([6.0], "array")},
    "at_turn": {"turns": (3.0, "number array")},
    "to_dict": {},
}
SETTING = (0.5, "number none")
COLOUR = ((1, 2, 3), "array list text")

CALLS = {
    # The model.
    "Dragon": (dragons.Dragon, {name: SCENARIO[name] for name in list(SCENARIO)[:5]}),
    "Dragon.outlines": (DRAGON.outlines, {"poses": (POSES, "array")}),
    "Dragon.outlines_between": (
        DRAGON.outlines_between,
        {"handles": (np.arange(4) * 1j, "array complex")},
    ),
    "Dragon.holes": (DRAGON.holes, {"poses": (POSES, "array")}),
    "Dragon.hole_velocities": (
        DRAGON.hole_velocities,
        {"poses": (POSES, "array"), "velocities": (POSES, "array")},
    ),
    "outlines": (
        dragons.outlines,
        {"poses": (POSES, "array"), "lengths": ([1.0, 1.0, 2.0], "array"), "width": (0.3, "array")},
    ),
    "Line": (dragons.Line, {"start": ((0.0, 0.0), "array"), "stop": ((3.0, 4.0), "array")}),
    "Arc": (
        dragons.Arc,
        {"centre": ((0.0, 0.0), "array"), "radius": FLOAT, "begin_angle": FLOAT, "sweep": FLOAT},
    ),
    "Spiral": (dragons.Spiral, {"pitch": FLOAT, "rotation": FLOAT, "outward": FLAG}),
    "Spiral.angle": (dragons.Spiral().angle, {"s": ([-20.0], "array")}),
    "Spiral.at_radius": (dragons.Spiral().at_radius, {"radius": FLOAT}),
    "UTurn": (
        dragons.UTurn,
        {"pitch": (1.7, "number"), "radius": (4.5, "number"), "ratio": (2.0, "number")},
    ),
    "Sampled": (dragons.Sampled, {"points": ([(0, 0), (3, 1), (6, 0), (9, 1)], "array")}),
    "Sampled.read": (dragons.Sampled.read, {"path": ("points.csv", "path")}),
    "Composite": (dragons.Composite, {"pieces": ((LINE,), "")}),
    "Section": (dragons.Section, {"curve": (LINE, ""), "begin_s": FLOAT, "end_s": (5.0, "number")}),
    "Reversed": (dragons.Reversed, {"curve": (LINE, "")}),
    "check_curve": (dragons.check_curve, {"curve": (LINE, ""), "low": OPTIONAL, "high": OPTIONAL}),
    "Curve.from_dict": (
        dragons.Curve.from_dict,
        {"values": ({"kind": "line", "stop": [3, 4]}, "mapping")},
    ),
    **{f"Curve.{name}": (getattr(LINE, name), arguments) for name, arguments in CURVE.items()},
    **{
        f"{type(curve).__name__}.{name}": (getattr(curve, name), arguments)
        for curve in (
            *(
                dragons.Arc(radius=5.0, sweep=3.0),
                dragons.Spiral(),
                dragons.UTurn(),
                dragons.Reversed(LINE),
            ),
            *(dragons.Composite((LINE,)), dragons.Section(LINE, 1.0, 8.0)),
            dragons.Sampled([(0, 0), (3, 1), (6, 0), (9, 1)]),
        )
        for name, arguments in CURVE.items()
    },
    "March": (
        dragons.March,
        {
            "dragon": (DRAGON, ""),
            "curve": (LINE, ""),
            "turns": OPTIONAL,
            "start_s": OPTIONAL,
            "speed": FLOAT,
        },
    ),
    **{
        f"March.{name}": (getattr(MARCH, name), {"times": TIMES, "handles": COUNT})
        for name in ("at", "handles_s", "motion", "motion_or_nan")
    },
    "March.distance": (MARCH.distance, {"times": TIMES}),
    "March.time": (MARCH.time, {"distances": TIMES}),
    "March.span": (MARCH.span, {"start": FLOAT, "until": FLOAT}),
    "March.speeds_by_difference": (
        SPIRAL.speeds_by_difference,
        {"times": TIMES, "step": (0.1, "number")},
    ),
    "March.at_unit_speed": (MARCH.at_unit_speed, {}),
    "States.to_dict": (MARCH.at(TIMES[0]).to_dict, {"handles": ([1], "array list none")}),
    "States.rows": (MARCH.at(TIMES[0]).rows, {"handles": ([1], "array list none")}),
    "States.text": (MARCH.at(TIMES[0]).text, {"handles": ([1], "array list none")}),
    "SpeedTable": (dragons.SpeedTable, {"times": ([0, 10], "array"), "speeds": ([1, 2], "array")}),
    "SpeedTable.of": (
        dragons.SpeedTable.of,
        {
            "function": (lambda t: 1.0, "function"),
            "start": (0.0, "number"),
            "until": FLOAT,
            "step": (0.1, "number"),
        },
    ),
    "SpeedTable.read": (dragons.SpeedTable.read, {"path": ("speed.csv", "path")}),
    "SpeedTable.at": (TABLE.at, {"t": TIMES}),
    "SpeedTable.acceleration": (TABLE.acceleration, {"t": TIMES}),
    "SpeedTable.distance": (TABLE.distance, {"t": TIMES}),
    "SpeedTable.time": (TABLE.time, {"distance": TIMES}),
    "SpeedTable.fastest": (TABLE.fastest, {"start": FLOAT, "until": FLOAT}),
    "Scenario": (dragons.Scenario, SCENARIO | {"curve": ("spiral", "text path none mapping")}),
    "Scenario.of": (dragons.Scenario.of, {"march": ONE_MARCH}),
    "Scenario.from_dict": (
        dragons.Scenario.from_dict,
        {"values": ({"benches": 5}, "mapping"), "files": FLAG},
    ),
    "Scenario.flat": (dragons.Scenario.flat, {"values": ({"benches": 5}, "mapping")}),
    "Scenario.read": (dragons.Scenario.read, {"path": ("scenario.toml", "path")}),
    "Scenario.to_dict": (dragons.Scenario().to_dict, {}),
    "Scenario.values": (dragons.Scenario().values, {}),
    "Scenario.march": (dragons.Scenario().march, {}),
    "ContactLog.windows": (ContactLog([EVENT]).windows, {}),
    "Run": (
        dragons.Run,
        {
            **{"march": ONE_MARCH, "times": ([0.0, 1.0], "array"), "poses": (RUN.poses, "array")},
            **{
                "drift": (RUN.drift, "array"),
                "pose_velocities": (RUN.pose_velocities, "array none"),
            },
            **{"joint_forces": (None, "array none"), "events": (ContactLog([EVENT]), "empty")},
            **{
                "first_contact": (CONTACT, "none"),
                "outcome": ("clear", "text"),
                "provenance": ({}, "mapping"),
            },
            **{"wall_seconds": OPTIONAL, "step_seconds": OPTIONAL},
        },
    ),
    "Run.exact": (dragons.Run.exact, {"march": ONE_MARCH, "times": TIMES}),
    "Run.load": (dragons.Run.load, {"path": ("run.npz", "path")}),
    "Run.save": (RUN.save, {"path": file(".npz")}),
    "Run.poses_at": (RUN.poses_at, {"times": TIMES}),
    "Run.pose_velocities_at": (RUN.pose_velocities_at, {"times": TIMES}),
    "Run.to_dict": (RUN.to_dict, {}),
    # Contacts.
    "Grid": (Grid, {"cell": FLOAT, "origin": ((0.0, 0.0), "array")}),
    "Grid.of": (Grid.of, {"march": ONE_MARCH}),
    "Grid.walk": (Grid().walk, {"start": ((0.0, 0.0), "array"), "end": ((1.0, 1.0), "array")}),
    "Grid.file": (Grid().file, {"outlines": ([SQUARE], "array")}),
    "Grid.pairs": (Grid().pairs, {"outlines": ([SQUARE], "array")}),
    "separation": (separation, {"first": (SQUARE, "array"), "second": (SQUARE, "array")}),
    "first_contact": (first_contact, {"march": ONE_MARCH, **WINDOW, "progress": PROGRESS}),
    "scan": (scan, {"march": ONE_MARCH, **WINDOW, "step": FLOAT, "progress": PROGRESS}),
    # The engine.
    "EngineSettings": (dragons.EngineSettings, ENGINE),
    "EngineSettings.resolved": (
        dragons.EngineSettings().resolved,
        {"top_speed": FLOAT, "pulled_mass": FLOAT, "holds_all": (True, "bool")},
    ),
    "simulate": (
        dragons.simulate,
        {
            **{
                "march": ONE_MARCH,
                **WINDOW,
                "settings": (None, "none"),
                "guide": ("rails", "text"),
            },
            **{"on_event": PROGRESS, "progress": PROGRESS, **ENGINE},
        },
    ),
    "World": (
        dragons.World,
        {
            "march": ONE_MARCH,
            "guide": ("none", "text"),
            "settings": (None, "none"),
            **WINDOW,
            **ENGINE,
        },
    ),
    "World.change": (
        lambda **changes: changed("change", **changes),
        {"substep": (0.01, "number none"), "iterations": (5, "int none"), "drag": (11.5, "number")},
    ),
    "World.cut": (lambda joint: changed("cut", joint=joint), {"joint": (1, "int")}),
    "World.release": (lambda bench: changed("release", bench=bench), {"bench": (1, "int")}),
    "World.follow": (
        lambda **given: changed("follow", **given),
        {"lag": FLOAT, "braking": FLOAT, "speed": FLOAT, "recovers": FLAG},
    ),
    "World.prepare": (
        lambda **given: changed("prepare", **given),
        {"states": (MARCH.at([0.1], handles=2), ""), "row": (0, "int"), "share": FLOAT},
    ),
    "World.read": (lambda: changed("read"), {}),
    "World.hold": (lambda: changed("hold"), {}),
    # Exact dynamics.
    "pull": (
        dragons.pull,
        {
            **{"march": ONE_MARCH, **WINDOW, "free_from": (1, "int")},
            **{"drag": FLOAT, "tolerance": (1e-6, "number")},
        },
    ),
    "joint_forces": (
        dragons.joint_forces,
        {"march": ONE_MARCH, "times": TIMES, "drag": FLOAT, "push": FLAG},
    ),
    # Pictures.
    "Camera": (Camera, {"follow": ("head", "text"), "span": OPTIONAL}),
    "Film": (Film, FILM),
    "Film.texts": (Film().texts, {"headings": (("x",), "empty texts")}),
    "render": (
        render,
        {
            "source": (RUN, ""),
            "path": file(".png"),
            "film": (None, "none"),
            "progress": PROGRESS,
            **FILM,
        },
    ),
    "still_png": (still_png, {"source": (RUN, ""), "time": FLOAT, "film": (Film(size=64), "none")}),
    "PillowDrawOptions": (
        dragons.PillowDrawOptions,
        {"image": (Image.new("RGB", (9, 9)), ""), "positive_y_is_up": FLAG, "line_width": FLOAT},
    ),
    "PillowDrawOptions.fit": (fitted, {"area": (own_space(), ""), "margin": FLOAT}),
    "figure": (figures.figure, {"name": ("speeds", "text"), "source": (RUN, "none")}),
    "write_figure": (
        figures.write_figure,
        {"name": ("speeds", "text"), "path": file(".svg"), "source": (RUN, "none")},
    ),
    # Documents.
    "report": (reports.report, {"run": ONE_RUN, "path": file(".json")}),
    "summarize": (reports.summarize, {"run": ONE_RUN}),
    "Summary.to_dict": (reports.summarize(RUN).to_dict, {}),
    "paper_tables": (
        reports.paper_tables,
        {"march": (SPIRAL, ""), "impact_time": (None, "number none")},
    ),
    "write_contact_table": (
        reports.write_contact_table,
        {"march": ONE_MARCH, "impact_time": FLOAT, "path": file(".xlsx")},
    ),
    "write_latex": (
        reports.write_latex,
        {
            "states": (MARCH.at(TIMES[0]), ""),
            "handles": ([1], "array list none"),
            "path": file(".tex"),
        },
    ),
    "write_tables": (
        reports.write_tables,
        {"march": ONE_MARCH, "times": TIMES, "path": file(".xlsx")},
    ),
    "player_page": (dragons.player_page, {"run": ONE_RUN, "title": (None, "text none")}),
    "write_player": (
        dragons.write_player,
        {"run": ONE_RUN, "path": file(".html"), "title": (None, "text none")},
    ),
    # The right call is one that is refused at once: the folder is no copy of Pyodide.
    "publish_program": (
        site.publish_program,
        {
            "program": ("program.py", "text path"),
            "folder": ("new", "text path"),
            "include": ([], "texts empty"),
            "runtime": (".", "text path none"),
            "address": (None, "text none"),
        },
    ),
    "publish_site": (
        site.publish_site,
        {
            "folder": ("new", "text path"),
            "runtime": (".", "text path"),
            "address": (None, "text none"),
            "progress": (FUNCTION, "function"),
        },
    ),
    # Studies. The right call is one that is refused at once: a search takes seconds.
    "min_pitch": (
        dragons.min_pitch,
        {
            "dragon": ONE_DRAGON,
            "turns": FLOAT,
            "speed": FLOAT,
            "radius": FLOAT,
            "progress": (FUNCTION, "function"),
        },
    ),
    "paper": (answers, {"dragon": (DRAGON, "none"), "progress": (FUNCTION, "function")}),
    "max_speed": (
        dragons.max_speed,
        {
            **{
                "dragon": ONE_DRAGON,
                "limit": FLOAT,
                "pitch": (1.7, "number"),
                "radius": (4.5, "number"),
            },
            **{"ratio": (2.0, "number"), "progress": (FUNCTION, "function")},
        },
    ),
    "sensitivity": (
        dragons.sensitivity,
        {
            **{
                "dragon": ONE_DRAGON,
                "pitch": (0.55, "number"),
                "turns": (0.5, "number"),
                "speed": FLOAT,
            },
            **{"radius": FLOAT, "progress": (FUNCTION, "function")},
        },
    ),
    "u_turn": (
        turn,
        {
            **{"dragon": (DRAGON, "none"), "pitch": (1.7, "number"), "radius": (4.5, "number")},
            **{"ratio": (2.0, "number"), "speed": FLOAT, "search": (False, "bool")},
            "progress": (FUNCTION, "function"),
        },
    ),
    "Result.to_dict": (STUDIED.to_dict, {}),
    "Result.plot": (STUDIED.plot, {}),
    "Result.write_figure": (STUDIED.write_figure, {"path": file(".svg")}),
    "Study.answer": (
        studies.STUDIES["max-speed"].answer,
        {"values": ({"limit": 0.0}, "mapping"), "progress": (FUNCTION, "function")},
    ),
    "sweep": (
        dragons.sweep,
        {
            **{
                "scenario": ({"benches": 4, "turns": 2.0}, "mapping none"),
                "quantity": ("max-speed", "text"),
            },
            **{
                "axes": ({"pitch": [0.5]}, "mapping"),
                "executor": (THREAD, "none"),
                "out": ((), "empty texts path"),
            },
            **{
                "refine": (1, "int"),
                "resume": (False, "bool"),
                "workers": COUNT,
                "progress": (FUNCTION, "function"),
            },
        },
    ),
    # Sessions.
    "Slider": (
        dragons.Slider,
        {
            **{
                "name": TEXT,
                "low": (0.5, "number"),
                "high": (9.0, "number"),
                "value": (1.0, "number none"),
            },
            **{"rebuilds": (False, "bool"), "action": PROGRESS, "label": TEXT, "unit": TEXT},
            **{"logarithmic": FLAG, "whole": (False, "bool")},
        },
    ),
    "Slider.checked": (dragons.Slider("x", 0, 9).checked, {"value": FLOAT}),
    "Button": (dragons.Button, {"name": TEXT, "action": (FUNCTION, "function")}),
    "Key": (dragons.Key, {"name": TEXT, "action": (FUNCTION, "function"), "up": PROGRESS}),
    "Draw": (dragons.Draw, {}),
    **{
        f"Draw.{name}": (drawn(name), arguments | {"color": COLOUR})
        for name, arguments in {
            "line": {"a": PAIR, "b": PAIR},
            "circle": {"center": PAIR, "radius": FLOAT, "fill": (None, "none array list text")},
            "arrow": {"begin": PAIR, "end": PAIR},
            "trail": {"of": PAIR, "last": WHOLE},
            "text": {"point": PAIR, "text": TEXT, "size": FLOAT},
        }.items()
    },
    "live": (
        live,
        {
            **{
                "what": (own_space, ""),
                "step": SETTING,
                "on_step": PROGRESS,
                "controls": ((), "empty"),
            },
            **{"on_draw": PROGRESS, "on_click": PROGRESS},
            **{
                "plots": (None, "none empty"),
                "events": (None, "none empty texts"),
                "show": (None, "none empty"),
                "y_down": FLAG,
                "units": TEXT,
            },
            **{
                "view": (None, "array none"),
                "follow": (None, "none function"),
                "title": (None, "none text"),
            },
            **{
                "paused": FLAG,
                "browser": (False, "bool"),
                "host": ("127.0.0.1", "path"),
                "port": (0, "int"),
            },
            "allow_hosts": ((), "empty texts"),
        },
    ),
    "Live.step": (lambda dt: of_session("step", dt=dt), {"dt": (0.01, "number")}),
    "Live.paused": (lambda: of_session("paused"), {}),
    "Live.wait": (lambda: of_session("wait"), {}),
    "Live.stop": (lambda: of_session("stop"), {}),
    # Lessons.
    "Lesson.sections": (lessons.LESSONS["spiral"].sections, {"language": ("en", "text")}),
    "play": (
        lessons.play,
        {"lesson": (None, ""), "save": ("folder", "path none"), "language": ("en", "text")},
    ),
    "record": (lessons.record, {"lesson": (None, "")}),
    "write_lessons": (
        lessons.write_lessons,
        {
            **{
                "lessons": ([lessons.LESSONS["spiral"]], ""),
                "path": file(".py"),
                "language": ("en", "text"),
            },
            "progress": (FUNCTION, "function"),
        },
    ),
}
