"""Other platforms: the imports of the package, and a browser without threads and processes."""

import ast
import subprocess
import sys
from pathlib import Path

import pymunk_dragon

# Modules of the standard library that Windows lacks.
POSIX = {
    "crypt",
    "curses",
    "fcntl",
    "grp",
    "posix",
    "pty",
    "pwd",
    "resource",
    "spwd",
    "syslog",
    "termios",
    "tty",
}

# Python in a browser imports `threading`, `signal` and `subprocess`, but starts no thread and no
# process.
BROWSER = """
import os, signal, subprocess, sys, threading

def refuse(*arguments, **named):
    raise OSError("not in a browser")

sys.modules |= dict.fromkeys(("_multiprocessing", "multiprocessing"))
threading.Thread.start = subprocess.Popen.__init__ = os.fork = signal.signal = refuse
from pymunk_dragon import Dragon, March, first_contact, render, simulate

march = March(Dragon(benches=16), turns=8)
assert march.at([0.0]).positions.shape == (1, 17, 2)
assert first_contact(march).benches == (0, 8)
run = simulate(march, start=80.0)
assert run.first_contact.benches == (0, 8)
render(run, "film.gif", size=64)
"""


def test_no_module_needs_posix_to_be_imported():
    for path in Path(pymunk_dragon.__file__).parent.rglob("*.py"):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) else []
            assert POSIX.isdisjoint(name.partition(".")[0] for name in names), path


def test_march_run_and_film_need_no_threads_processes_or_signals(tmp_path):
    subprocess.run([sys.executable, "-c", BROWSER], check=True, cwd=tmp_path)
    assert (tmp_path / "film.gif").read_bytes()[:6] == b"GIF89a"


def test_sessions_import_nothing_that_a_page_waits_for_in_vain():
    vain = "click", "email", "imageio", "pymunk_dragon.player", "pymunk_dragon.reports"
    code = (
        f"import pymunk_dragon.sessions.session, sys; assert sys.modules.keys().isdisjoint({vain})"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
