"""How films and stills are to look."""

from __future__ import annotations

from dataclasses import dataclass

from dressing_sim.checks import one_of
from dressing_sim.errors import InvalidInputError
from dressing_sim.pictures import AUTO, CAMERAS, LARGEST_SIDE, OVERLAYS


def check_size(width: int, height: int) -> None:
    """Raise InvalidInputError unless a picture can have this size [pixels]."""
    for side in (width, height):
        if not 1 <= side <= LARGEST_SIDE:
            raise InvalidInputError(
                f"a picture of {width} x {height} pixels: valid is 1 to {LARGEST_SIDE} each"
            )


@dataclass(frozen=True, slots=True)
class Look:
    """How films and stills are to look.

    Raises:
        InvalidInputError: A value is not valid.
    """

    camera: str = "front"
    """One of `dressing_sim.pictures.CAMERAS`, or `AUTO`."""
    width: int = 640
    """Of one picture [pixels]; two that are compared are twice as wide together."""
    height: int = 480
    """Of one picture [pixels]."""
    overlays: tuple[str, ...] = ()
    """Of `dressing_sim.pictures.OVERLAYS`."""
    caption: bool = False
    """Whether numbers and verdict are written into the picture."""
    fine: bool = False
    """Whether edges are smooth and shadows are cast, which takes six times as long."""

    def __post_init__(self) -> None:
        one_of(self.camera, "camera", (*CAMERAS, AUTO))
        for overlay in self.overlays:
            one_of(overlay, "overlay", OVERLAYS)
        check_size(self.width, self.height)
