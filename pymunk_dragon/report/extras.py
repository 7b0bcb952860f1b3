"""The libraries that only some formats need."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from pymunk_dragon.errors import MissingExtraError

__all__ = ["library"]

FEATURES = {"jinja2": "an HTML report", "xlsxwriter": "an XLSX file"}


def library(name: str) -> Any:
    """A module of the extra `report`.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise MissingExtraError(FEATURES[name], "report") from error
