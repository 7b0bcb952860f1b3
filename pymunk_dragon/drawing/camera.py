"""The camera of a film."""

from dataclasses import dataclass
from typing import Literal, get_args

from pymunk_dragon._checks import finite, word

# What a camera follows.
Target = Literal["field", "head", "cut"]

# m: bounds of the width of a view, which detect lengths in another unit. The least shows less than
# two holes of a bench.
_MIN_SPAN = 0.1
# m: more ground than the longest dragon covers.
_MAX_SPAN = 1e5


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Camera of a film: what it follows, and the width of its view.

    Parameters
    ----------
    follow : {"field", "head", "cut"}
        Keep the camera fixed over the whole field, centre it on the head bench, or cut from the
        whole field to the head before the first near miss or contact.
    span : float, optional
        Width of the ground in view, m, from 0.1 to 1e5. The default for "field" holds the dragon
        during the whole film, the default for "head" is 20 times the head bench's width. With
        "cut" it is the width of the view that follows the head.

    Examples
    --------
    >>> from pymunk_dragon import Camera
    >>> Camera(follow="head", span=8.0)
    Camera(follow='head', span=8.0)
    """

    follow: Target = "field"
    span: float | None = None

    def __post_init__(self) -> None:
        word("follow", self.follow, get_args(Target))
        if self.span is not None:
            finite("span", self.span, _MIN_SPAN, _MAX_SPAN, "m")
