"""A program with every fault that the harness knows; its first argument names the fault."""

from __future__ import annotations

import os
import sys
import time
import warnings
from pathlib import Path

__all__ = ["main"]


def main(arguments: list[str]) -> None:
    """Behave as the first argument says, and exit."""
    behaviour = arguments[0]
    old = Path("old.json")
    match behaviour:
        case "raise":
            raise RuntimeError("a bug")
        case "code 3":
            fail("bad", 3)
        case "two lines":
            fail("bad\nvery bad")
        case "silent":
            sys.exit(2)
        case "warn":
            warnings.warn("divided by zero", stacklevel=1)
        case "traceback":
            fail("Traceback (most recent call last):")
        case "print":
            print("half an answer")
            fail("bad")
        case "no json":
            print("t = 3")
        case "draft":
            Path(".draft").write_text("half")
            fail("bad")
        case "good draft":
            Path(".draft").write_text("half")
        case "up":
            Path("../new.json").write_text("new")
        case "change":
            old.write_text("new")
            fail("bad")
        case "change another":
            Path("s.toml").write_text("new")
        case "lose":
            old.unlink()
            fail("bad")
        case "memory":
            print(len(b"x" * 300_000_000))
        case "exit":
            os._exit(1)
        case "hang":
            time.sleep(60)
        case "work":
            begin = time.process_time()
            while time.process_time() < begin + 0.1:
                pass
        case "bad input":
            fail("bad")
        case "good":
            old.write_text("new")
            print("{}")
    sys.exit(0)


def fail(message: str, code: int = 2) -> None:
    """Complain and exit."""
    print(message, file=sys.stderr)
    sys.exit(code)
