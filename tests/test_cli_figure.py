"""Figures from the command line: all at once, as PDF, and in Chinese."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from pymunk_dragon.drawing.figures import FIGURES
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.physics import simulate

OF_RUN = {"drift", "impulses"}


@pytest.fixture(scope="module")
def run_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("run") / "run.npz"
    simulate(March(Dragon(benches=20)), start=405, substep=0.02, iterations=15).save(file)
    return file


def names(folder: Path) -> set[str]:
    return {path.stem for path in folder.iterdir()}


def test_all_figures_are_written_to_a_folder_and_those_of_a_run_are_named(call: Any, tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    status, out, err = call("figure", "all", "-o", folder)
    assert (status, out) == (0, "")
    assert names(folder) == set(FIGURES) - OF_RUN
    for name in OF_RUN:
        assert f"left out {name}: it is drawn from a run of the engine: give RUN.npz" in err


def test_all_figures_of_a_run(call: Any, tmp_path: Path, run_file: Path) -> None:
    status, out, _ = call("figure", "all", run_file, "-o", tmp_path, "--json")
    printed = json.loads(out)
    assert (status, printed["left_out"]) == (0, {})
    assert {Path(each["output"]).stem for each in printed["outputs"]} == names(tmp_path) == set(FIGURES)
    for each in printed["outputs"]:
        assert Path(each["output"]).stat().st_size == each["bytes"]


def test_figures_that_a_march_does_not_have_are_left_out_with_the_reason(call: Any, tmp_path: Path) -> None:
    status, out, err = call("figure", "all", "--benches", 3, "--turns", 3, "-o", tmp_path, "--json")
    assert (status, set(json.loads(out)["left_out"])) == (0, {*OF_RUN, "collision"})
    assert "left out collision: march is 'clear until" in err


def test_all_figures_need_a_folder(call: Any, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    status, _, err = call("figure", "all", "-o", tmp_path / "file")
    assert status == 2
    assert err.startswith("pymunk-dragon: -o is ")
    assert "folder" in err


@pytest.mark.thorough
@pytest.mark.parametrize(
    "command",
    [
        ["figure", "speeds"],
        ["study", "max-speed"],
        ["sweep", "--benches", "20", "--axis", "pitch=0.5,0.55", "--axis", "width=0.3,0.32"],
    ],
    ids=lambda command: command[0],
)
@pytest.mark.parametrize("lang", ["en", "zh"])
def test_a_pdf_has_the_same_bytes_in_each_process(command: list[str], lang: str, tmp_path: Path) -> None:
    contents = set()
    for seed in ("1", "2"):
        file = tmp_path / f"{seed}.pdf"
        call = [sys.executable, "-m", "pymunk_dragon", *command, "--lang", lang, "-o", str(file)]
        subprocess.run(call, check=True, env=os.environ | {"PYTHONHASHSEED": seed}, stdout=subprocess.DEVNULL)
        contents.add(file.read_bytes())
    [content] = contents
    assert content.startswith(b"%PDF")
    assert b"/CreationDate" not in content
    assert b"/ModDate" not in content
    assert (b"NotoSansSC" in content) == (lang == "zh")


def test_the_language_of_the_environment_is_that_of_figures(
    call: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pictures = []
    for name, variable in (("english", "en"), ("chinese", "zh")):
        monkeypatch.setenv("PYMUNK_DRAGON_LANG", variable)
        assert call("figure", "inward", "-o", tmp_path / f"{name}.png")[0] == 0
        with Image.open(tmp_path / f"{name}.png") as picture:
            pictures.append(picture.convert("RGB").tobytes())
    monkeypatch.delenv("PYMUNK_DRAGON_LANG")
    assert call("figure", "inward", "--lang", "zh", "-o", tmp_path / "flag.png")[0] == 0
    assert pictures[0] != pictures[1]
    assert (tmp_path / "flag.png").read_bytes() == (tmp_path / "chinese.png").read_bytes()
