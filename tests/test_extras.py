"""Libraries of the extras: missing, broken, and interrupted while they are imported."""

import os
import signal
import subprocess
import sys

import pytest
from conftest import assert_one_line
from test_faults import LIMIT

from pymunk_dragon import Dragon, March, Run

# For each library: a file that needs it, and the arguments that write one.
WRITERS = {
    "imageio_ffmpeg": ("film.mp4", "render RUN.npz --size 64 -o"),
    "jinja2": ("report.html", "report RUN.npz -o"),
    "matplotlib": ("report.html", "report RUN.npz -o"),
    "scipy": (
        "p.csv",
        "positions --curve path.csv --times 0 --benches 2 --head-spacing 1 --body-spacing 1 -o",
    ),
    "xlsxwriter": ("p.xlsx", "positions --times 0,1 -o"),
}


def run_without(tmp_path, library, source, replaced):
    """Exit code and stderr of a program whose library has this source; its file must be kept."""
    name, arguments = WRITERS[library]
    stubs = tmp_path / "stubs"
    (stubs / library).mkdir(parents=True)
    (stubs / library / "__init__.py").write_text(source)
    Run.exact(March(Dragon(benches=4)), [0.0, 0.5]).save(tmp_path / "run.npz")
    (tmp_path / "path.csv").write_text("0,0\n15,1\n30,0\n45,-8\n")
    (tmp_path / name).write_bytes(b"old")
    command = [
        sys.executable,
        "-m",
        "pymunk_dragon",
        *arguments.replace("RUN", "run").split(),
        name,
    ]
    path = os.pathsep.join(filter(None, [str(stubs), os.environ.get("PYTHONPATH")]))
    options = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": path}, "timeout": LIMIT}
    ended = subprocess.run(command, capture_output=True, text=True, **options)
    assert ((tmp_path / name).read_bytes() == b"old") != replaced
    assert not list(tmp_path.glob(f".{name}*"))
    return ended.returncode, ended.stderr


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["INT", "TERM"])
@pytest.mark.parametrize("library", ["matplotlib", "scipy", "xlsxwriter"])
def test_signal_during_an_import_ends_the_program_and_keeps_the_old_file(tmp_path, library, number):
    # As a module in C makes an ImportError of what interrupts its initialization.
    source = (
        f"import os\ntry:\n    os.kill(os.getpid(), {int(number)})\n    for _ in range(9): pass\n"
    )
    source += "except BaseException as error:\n"
    source += "    raise ImportError('initialization failed') from error\n"
    code, err = run_without(tmp_path, library, source, replaced=False)
    assert code == 128 + number
    assert_one_line(err, "interrupted")


@pytest.mark.parametrize("library", WRITERS)
def test_error_inside_an_import_is_shown_and_not_taken_for_a_missing_library(tmp_path, library):
    for error in (
        "ImportError('libpng is too old')",
        f"ModuleNotFoundError('No module named {library}_core')",
    ):
        code, err = run_without(tmp_path / error[:3], library, f"raise {error}", replaced=False)
        assert code == 1
        assert error.split("'")[1] in err
        assert "pip install" not in err
