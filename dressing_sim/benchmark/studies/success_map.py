"""The map of failures: where in the space of postures each row dresses, and what goes wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.records import EpisodeResult, Protocol, first_failure, in_order
from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import Plot
from dressing_sim.benchmark.report.panels import in_panels
from dressing_sim.episode.rules import rule_colour

#: What an episode without a failure is called.
DRESSED = "dressed"

#: Markers of what went wrong first, so that a map can be read without its colours.
_MARKERS = "^sDvXPp*hd<>8H"

_COLUMNS = 3


def failure_map(protocol: Protocol, episodes: EpisodeTable) -> Plot | None:
    """Every episode over the bend of elbow and shoulder, a panel a row; None if none counts."""
    rows = [episodes.of_entry(entry) for entry in protocol.entries]
    found = [_by_outcome(row) for row in rows]
    reasons = in_order({name for groups in found for name in groups} - {DRESSED})
    if not any(found):
        return None
    looks = {DRESSED: plots.Style(plots.QUIET, "o")} | {
        reason: plots.Style(_drawn_colour(reason), _MARKERS[place % len(_MARKERS)])
        for place, reason in enumerate(reasons)
    }

    def draw(axes: Axes, place: int) -> None:
        for name, inside in found[place].items():
            elbow, shoulder = _angles(inside).T
            axes.plot(
                elbow,
                shoulder,
                looks[name].marker,
                ms=2.4 if name == DRESSED else 3.6,
                mew=0.7,
                mec=looks[name].colour,
                mfc=_face(name, looks[name]),
            )
        axes.grid()

    legend = [
        Line2D(
            [], [], color=s.colour, marker=s.marker, ls="", ms=4.0, label=name, mfc=_face(name, s)
        )
        for name, s in looks.items()
    ]
    titles = [entry.label for entry in protocol.entries]
    axis_labels = "elbow flexion [deg]", "shoulder flexion [deg]"
    svg = in_panels(titles, draw, _COLUMNS, 1.8, axis_labels, legend)
    words = [f"{title}: {_told(groups)}" for title, groups in zip(titles, found, strict=True)]
    caption = "Each mark is an episode, by what went wrong first in it."
    return Plot("map", svg, ". ".join(words), caption)


def _face(name: str, style: plots.Style) -> str:
    return "none" if name == DRESSED else style.colour


def _drawn_colour(reason: str) -> str:
    colour = rule_colour(reason)
    return plots.BLACK if colour == "#000000" else colour


def _by_outcome(row: EpisodeTable) -> Mapping[str, Sequence[EpisodeResult]]:
    """Episodes that count by what went wrong first, those that were dressed beneath all others."""
    groups: dict[str, list[EpisodeResult]] = {}
    for result in row.where(row.valid).results:
        first = first_failure(result.outcome)
        groups.setdefault(DRESSED if first is None else first.reason, []).append(result)
    return {name: groups[name] for name in sorted(groups, key=lambda name: name != DRESSED)}


def _angles(results: Sequence[EpisodeResult]) -> np.ndarray:
    """Flexion of elbow and shoulder, shape (n, 2) [deg]."""
    return np.array([[r.posture.elbow_deg, r.posture.flexion_deg] for r in results])


def _told(groups: Mapping[str, Sequence[EpisodeResult]]) -> str:
    said = []
    for name, inside in groups.items():
        elbow, shoulder = np.median(_angles(inside), axis=0)
        said.append(f"{name} {len(inside)}, median elbow {elbow:.0f}, shoulder {shoulder:.0f} deg")
    return "; ".join(said) or "no episode counts"
