"""Published programs of Pymunk's kind, as users write them: what is read, and how they play."""

from __future__ import annotations

from pathlib import Path

import pytest

from pymunk_dragon.errors import DragonError
from pymunk_dragon.publish.program import read_program

PROGRAMS = sorted(Path(__file__).parent.joinpath("data/programs").glob("*.py"))


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_programs_have_all_that_their_pages_show(path):
    program = read_program(path)
    assert program.title
    # A title is no sentence.
    assert not program.title.endswith(".")
    assert program.picture.startswith(b"\x89PNG")


@pytest.mark.parametrize("content", [b"\xff\xfe", b"x = 1\0", None])
def test_file_that_is_no_program_is_named_once(tmp_path, content):
    path = tmp_path / "none.py"
    if content:
        path.write_bytes(content)
    with pytest.raises(DragonError) as refused:
        read_program(path)
    assert str(refused.value).count(str(path)) == 1
    assert "None" not in str(refused.value)
