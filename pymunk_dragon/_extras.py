"""Importing the libraries of the extras, which only some features need."""

from importlib import import_module
from importlib.util import find_spec
from typing import Any

from pymunk_dragon.errors import MissingExtraError, OutputError

# For each library: the feature that needs it, and the extra that installs it.
FEATURES = {
    "aiohttp": ("a live session", "live"),
    "distributed": ("a Dask scheduler", "cluster"),
    "imageio_ffmpeg": ("an MP4", "mp4"),
    "jinja2": ("an HTML page or LaTeX", "report"),
    "latex2mathml": ("a formula on a page", "demos"),
    "matplotlib": ("a figure", "figures"),
    "nbformat": ("a notebook", "demos"),
    "pygame": ("a pygame program on a page", "pygame"),
    "pygments": ("a page of lessons", "demos"),
    "scipy": ("a path through points", "curves"),
    "scipy.linalg.lapack": ("exact dynamics", "studies"),
    "scipy.optimize": ("the search for the shortest turn", "studies"),
    "xlsxwriter": ("an XLSX file", "report"),
    "zhplot": ("Chinese in a picture", "chinese"),
}


def library(name: str) -> Any:
    """A module of an extra by its name, as `library("scipy.interpolate")`.

    What the module raises while it is imported is raised from here.
    """
    if not is_installed(name):
        raise missing_extra(name)
    try:
        return import_module(name)
    except OSError as error:
        # Matplotlib writes a list of fonts.
        raise OutputError(f"the cache of {name}", error.strerror or str(error)) from error


def is_installed(name: str) -> bool:
    """Whether Python finds the library of a module, which is not imported."""
    return find_spec(name.partition(".")[0]) is not None


def missing_extra(name: str) -> MissingExtraError:
    """The error for a library that is not installed."""
    feature, extra = FEATURES.get(name) or FEATURES[name.partition(".")[0]]
    return MissingExtraError(feature, extra)
