"""Importing the libraries of the extras, which only some features need."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from pymunk_dragon.errors import MissingExtraError, OutputError

# For each library: the feature that needs it, and the extra that installs it.
FEATURES = {
    "aiohttp": ("a live session", "live"),
    "distributed": ("a Dask scheduler", "cluster"),
    "imageio_ffmpeg": ("an MP4", "mp4"),
    "jinja2": ("an HTML page", "report"),
    "latex2mathml": ("a formula on a page", "demos"),
    "matplotlib": ("a figure", "figures"),
    "nbformat": ("a notebook", "demos"),
    "pygame": ("a pygame program on a page", "pygame"),
    "pygments": ("a page of lessons", "demos"),
    "scipy": ("a path through points", "curves"),
    "scipy.optimize": ("the search for the shortest turn", "studies"),
    "xlsxwriter": ("an XLSX file", "report"),
    "zhplot": ("Chinese in a picture", "chinese"),
}


def library(name: str) -> Any:
    """A module of an extra by its name, as `library("scipy.interpolate")`, also to check that it is installed."""
    try:
        return import_module(name)
    except ImportError as error:
        raise missing_extra(name) from error
    except OSError as error:  # As of matplotlib, which writes a list of fonts.
        raise OutputError(f"the cache of {name}", error.strerror or str(error)) from error


def missing_extra(name: str) -> MissingExtraError:
    """The error for a library that is not installed."""
    return MissingExtraError(*(FEATURES.get(name) or FEATURES[name.partition(".")[0]]))
