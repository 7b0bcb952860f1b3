"""Every public function and class refuses wrong arguments, each with an error of the package.

`make fuzz KIND=arguments` runs that many random calls, at most 3,000, different ones each time; the
suite runs a few, always the same.
"""

import importlib
import inspect
import signal
import warnings
from contextlib import chdir
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FunctionType

import hypothesis
import pytest
from calls import CALLS, RUN, VALUES
from hypothesis import strategies as st
from test_fuzz import CASES, counted, listed

from pymunk_dragon.errors import DragonError

# More cases than there are pairs of an argument and a value do not find more.
MAX_CASES = 3000
# s of processor time, after which a call is ended.
MAX_SECONDS = 30.0
PACKAGES = [
    "",
    ".collision",
    ".dynamics",
    ".drawing",
    ".drawing.debug_draw",
    ".drawing.figures",
    ".lessons",
    ".model.curves",
]
PACKAGES += [".physics", ".player", ".publish.site", ".reports", ".sessions", ".studies", ".sweeps"]
# Not called: errors; records that functions of the package make; base classes; and what takes other
# functions of the package, or the arguments of Pymunk's drawing.
RECORDS = "Contact ContactEvent ContactLog FirstContact NearMiss Separation States Sweep Summary"
RECORDS += " Lesson MaxSpeed MinPitch TurnResult Sensitivity Paper Recording"
OTHERS = "Curve Live PathGuide Rails PygameEvents Result Study styled_figure write_styled"
OTHER_METHODS = (
    "draw_circle draw_dot draw_fat_segment draw_polygon draw_segment draw_shape color_for_shape"
)
OTHER_METHODS += " attach joints relocate joint_forces update key pointer wheel"
FILES = {
    "points.csv": "0,0\n15,1\n30,0\n45,-8\n",
    "speed.csv": "0,1\n5,2\n",
    "scenario.toml": "benches = 6\n",
}


def public():
    """All public names of the packages, and what they stand for."""
    modules = [importlib.import_module("pymunk_dragon" + name) for name in PACKAGES]
    return {name: getattr(module, name) for module in modules for name in module.__all__}


def methods(found):
    """Names of a class's public methods from the package, each with the classes that have it."""
    for base in inspect.getmro(found) if inspect.isclass(found) else ():
        for name, kind in vars(base).items() if base.__module__.startswith("pymunk_dragon") else ():
            if isinstance(kind, FunctionType | classmethod | staticmethod) and name[0] != "_":
                yield name, [f"{each.__name__}.{name}" for each in inspect.getmro(found)]


def test_every_public_function_class_and_method_has_a_right_call():
    missing = []
    for name, found in public().items():
        if not callable(found) or (inspect.isclass(found) and issubclass(found, DragonError)):
            continue
        if name not in f"{RECORDS} {OTHERS}".split() and name not in CALLS:
            missing.append(name)
        for method, names in () if name in RECORDS.split() else methods(found):
            if method not in OTHER_METHODS.split() and not CALLS.keys() & {*names}:
                missing.append(f"{name}.{method}")
    assert missing == []


@st.composite
def calls(draw):
    """A name, and one or two of its arguments with other values, by their numbers in `VALUES`."""
    name = draw(st.sampled_from([name for name, (_, arguments) in CALLS.items() if arguments]))
    arguments = draw(
        st.lists(st.sampled_from([*CALLS[name][1]]), min_size=1, max_size=2, unique=True)
    )
    return name, {argument: draw(st.integers(0, len(VALUES) - 1)) for argument in arguments}


@cache
def folder():
    """A folder with the files that right calls read."""
    made = TemporaryDirectory()
    RUN.save(Path(made.name) / "run.npz")
    for name, content in FILES.items():
        (Path(made.name) / name).write_text(content, encoding="utf-8")
    return made


def check(name, changed):
    """A value of a wrong kind is refused by an error of the package, in a folder with files."""
    function, right = CALLS[name]
    given = {argument: value for argument, (value, _) in right.items()}
    given |= {argument: VALUES[number][0] for argument, number in changed.items()}
    wrong = [
        each
        for each, number in changed.items()
        if not {*right[each][1].split()} & {*VALUES[number][1].split()}
    ]

    def stop(*_):
        raise RuntimeError(f"more than {MAX_SECONDS} s of processor time")

    signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, MAX_SECONDS)
    refused = None
    try:
        with chdir(folder().name), warnings.catch_warnings(action="error"):
            function(**given)
    except DragonError as error:
        refused = str(error)
        assert "\n" not in refused
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    shown = {argument: VALUES[number][0] for argument, number in changed.items()}
    assert refused is not None or not wrong, f"{name} accepts {shown}"


@pytest.mark.parametrize("name", CALLS)
def test_right_call_is_accepted(name):
    check(name, {})


@pytest.mark.parametrize("kind", ["wrong-arguments"])
def test_no_case_fails_in_a_call_of_a_public_function(kind):
    @hypothesis.settings(
        max_examples=min(CASES, MAX_CASES) or 60,
        derandomize=not CASES,
        database=None,
        deadline=None,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(calls())
    def run(case):
        counted[kind] += 1
        check(*case)

    with listed(kind):
        run()
