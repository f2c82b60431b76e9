"""A picture of what a policy has learned: a TP-GMM frame by frame, a transport with its tube."""

from __future__ import annotations

from functools import partial
from io import BytesIO
from pathlib import Path

from dressing_sim.benchmark.report import plots
from dressing_sim.errors import InvalidInputError
from dressing_sim.explain.learned import Explanation, MixtureExplanation
from dressing_sim.explain.mixtures import draw_mixtures, mixture_size
from dressing_sim.explain.transport import draw_transport, transport_size
from dressing_sim.files import write_file

FORMATS = (".svg", ".png")

#: Dots an inch of a PNG: two columns of print at full width.
_DPI = 250


def check_picture(path: str | Path) -> None:
    """Raise InvalidInputError unless a picture can be written to a file of this name."""
    if Path(path).suffix.lower() not in FORMATS:
        raise InvalidInputError(
            f"explain {path}: unknown format {Path(path).suffix!r}, valid is {', '.join(FORMATS)}"
        )


def write_explanation(path: str | Path, explanation: Explanation, title: str) -> None:
    """Draw what was learned, and the answer for an arm; the file is whole or not there.

    Lengths are in metres, seen from the arm's shoulder: from the side, at right angles to the line
    from shoulder to wrist, and from above.

    Args:
        path: Where to; its suffix says the format, one of `FORMATS`.
        explanation: As of `dressing_sim.explain.learned.explain`.
        title: Which policy on which arm.

    Raises:
        InvalidInputError: Another format, or the file cannot be written.
    """
    check_picture(path)
    if isinstance(explanation, MixtureExplanation):
        size, draw = mixture_size(explanation), partial(draw_mixtures, explanation=explanation)
    else:
        size, draw = transport_size(explanation), partial(draw_transport, explanation=explanation)
    with plots.figure(*size) as drawn:
        draw(drawn)
        drawn.suptitle(title, x=0.01, ha="left", fontsize=8.5)
        if Path(path).suffix.lower() == ".svg":
            content = plots.svg_of(drawn).encode()
        else:
            file = BytesIO()
            drawn.savefig(file, format="png", dpi=_DPI, metadata={"Software": None})
            content = file.getvalue()
    write_file(path, content)
