"""WebP writer: Pillow's, which encodes with libwebp and keeps the compressed frames in memory."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

from pymunk_dragon.drawing.film.formats.frames import Frames

# libwebp's compression method, 0 (fastest) to 6.
METHOD = 0
# libwebp's effort of lossless compression, 0 (fastest) to 100.
EFFORT = 0
# Frames between two key frames: 0 is no key frame but the first. They would make seeking faster and files larger.
KEY_FRAMES = 0


def write_webp(path: Path, frames: Frames) -> None:
    """Write a lossless animated WebP that repeats without end; one frame is in memory, and the compressed film."""
    animation = _LazyAnimation(frames)
    # ms; libwebp merges equal frames.
    durations = frames.durations(1000)
    # Pillow leaves a file open that it opened itself if Ctrl-C interrupts the drawing.
    with path.open("wb") as file:
        animation.save(
            file,
            "WEBP",
            save_all=True,
            duration=durations,
            loop=0,
            lossless=True,
            method=METHOD,
            quality=EFFORT,
            kmin=KEY_FRAMES,
            kmax=KEY_FRAMES,
        )


class _LazyAnimation(Image.Image):
    """Frames as one image of several frames, drawn when Pillow seeks them; a list would keep them all in memory."""

    def __init__(self, frames: Frames) -> None:
        super().__init__()
        self._mode, self._size = "RGB", frames.size
        self.n_frames = len(frames.ends)
        self._pictures = frames.coloured()
        self._frame = -1
        self.seek(0)

    def tell(self) -> int:
        """Return the number of the current frame."""
        return self._frame

    def seek(self, frame: int) -> None:
        """Draw the frames up to `frame`. At the end Pillow seeks the first frame, which is no longer there."""
        while self._frame < frame:
            self.im = next(self._pictures).convert("RGB").im
            self._frame += 1
