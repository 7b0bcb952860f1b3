"""Refusals of bad input."""

from __future__ import annotations

import pytest
from conftest import assert_says

from pymunk_dragon.errors import ParameterError


def refusal(call, *arguments, error=ParameterError, **settings):
    """The error with which a call is refused; its message is one line."""
    try:
        call(*arguments, **settings)
    except error as refused:
        assert_says(refused)
        return refused
    return pytest.fail(f"accepted: {arguments} {settings}")
