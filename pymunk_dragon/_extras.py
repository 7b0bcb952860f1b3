"""The libraries that only some features need."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from pymunk_dragon.errors import MissingExtraError, OutputError

__all__ = ["extras_named", "library"]

# What needs it, and the extra that brings it.
FEATURES = {
    "imageio_ffmpeg": ("an MP4", "mp4"),
    "jinja2": ("an HTML page", "report"),
    "matplotlib": ("a figure", "figures"),
    "nbformat": ("a notebook", "demos"),
    "pygments": ("a page of lessons", "demos"),
    "scipy": ("a path through points", "curves"),
    "scipy.optimize": ("the search for the shortest turn", "studies"),
    "xlsxwriter": ("an XLSX file", "report"),
}


def library(name: str) -> Any:
    """A module of one of the extras, as `library("scipy.interpolate")`.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    OutputError
        If it cannot write the files that it keeps for itself, as matplotlib its list of fonts.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise MissingExtraError(*(FEATURES.get(name) or FEATURES[name.partition(".")[0]])) from error
    except OSError as error:
        raise OutputError(f"the cache of {name}", error.strerror or str(error)) from error


@contextmanager
def extras_named() -> Iterator[None]:
    """Name the extra that brings a library which what is in here imports by itself.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name is None or (name := error.name.partition(".")[0]) not in FEATURES:
            raise
        raise MissingExtraError(*FEATURES[name]) from error
