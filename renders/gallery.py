"""Make a file of `renders/`, for the Makefile: `gallery.py TARGET ENDINGS ARGUMENT...`.

Calls `pymunk-dragon ARGUMENT... -o TARGET`, once for each of the comma-separated endings, and
writes a rule for make with the files of the package that were used, `renders/.commands/NAME.d`:
make includes the rule, and makes TARGET again if one of these files changes. A picture that equals
the old one within a tolerance is not replaced: committed pictures do not change if only rounding or
a library's compression has changed.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import pymunk_dragon
from pymunk_dragon.cli import status

RENDERS = Path("renders")
PICTURES = (".gif", ".png")
# Levels of 255: difference of a colour channel that is ignored. Rounding differs between machines
# at edges of lines.
LEVELS = 12
# Fraction of the pixels that may differ by more than LEVELS: about 4e-6 if all benches are
# displaced by a micrometre, at least 5e-5 if a digit of the caption differs.
SHARE = 2e-5


def share_off(one: Image.Image, other: Image.Image) -> float:
    """Fraction of the pixels of two equally large frames that differ by more than LEVELS."""
    first, second = (np.asarray(image.convert("RGBA"), dtype=np.int16) for image in (one, other))
    return float(np.mean((np.abs(first - second) > LEVELS).any(axis=-1)))


def show_the_same(one: Path, other: Path) -> bool:
    """Whether two files have equal sizes, counts and delays, and pixels alike but for SHARE."""
    if one.read_bytes() == other.read_bytes():
        return True
    with Image.open(one) as first, Image.open(other) as second:
        count = getattr(first, "n_frames", 1)
        if first.size != second.size or count != getattr(second, "n_frames", 1):
            return False
        off = 0.0
        for frame in range(count):
            first.seek(frame)
            second.seek(frame)
            if first.info.get("duration") != second.info.get("duration"):
                return False
            off += share_off(first, second)
    return off / count <= SHARE


def replace(target: Path, drafts: list[Path]) -> None:
    """Move the drafts beside `target`; delete them if the first is a picture equal to `target`."""
    same = target.suffix in PICTURES and target.exists() and show_the_same(target, drafts[0])
    for draft in drafts:
        kept = target.parent / draft.name
        if same and kept.exists():
            draft.unlink()
            # For make, which compares times.
            os.utime(kept)
        else:
            os.replace(draft, kept)


def used_files() -> list[str]:
    """Files of the package that this process has imported, and the data files beside them."""
    root = Path(pymunk_dragon.__file__).parent
    loaded = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    modules = {Path(file) for file in loaded if file and Path(file).is_relative_to(root)}
    folders = {module.parent for module in modules}
    data = [
        file
        for file in root.rglob("*.*")
        if file.suffix not in (".py", ".pyc") and {*file.parents[:2]} & folders
    ]
    return sorted(os.path.relpath(file) for file in {*modules, *data})


def make(target: Path, endings: list[str], arguments: list[str]) -> None:
    """Make `target` and its rule; if the program fails, exit with its code."""
    name = target.relative_to(RENDERS)
    drafts = [(RENDERS / ".new" / name).with_suffix(ending) for ending in endings]
    drafts[0].parent.mkdir(parents=True, exist_ok=True)
    for draft in drafts:
        if code := status([*arguments, "-o", str(draft)]):
            sys.exit(code)
    replace(target, drafts)
    files = used_files()
    # The rules without a recipe are for files that are removed later.
    rules = "".join(f"{file}:\n" for file in files)
    (RENDERS / ".commands" / f"{name}.d").write_text(
        f"{target}: {' '.join(files)}\n{rules}", encoding="utf-8"
    )


if __name__ == "__main__":
    make(Path(sys.argv[1]), sys.argv[2].split(","), sys.argv[3:])
