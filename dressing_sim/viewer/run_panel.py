"""A run that was measured: its postures in space, coloured by outcome, to be replayed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.viewer.panels import Shown, when_asked, when_pressed
from dressing_sim.viewer.past import Past, colour_of, verdict_of
from dressing_sim.viewer.session import Session
from dressing_sim.viewer.shapes import capsule

if TYPE_CHECKING:
    import viser

_NOBODY = "nobody"

#: Around what is chosen, in the map.
_RING = ' stroke="currentColor" stroke-width="2"'

#: Radius of a posture's ball in the scene [m].
_BALL = 0.013


class RunPanel:
    """The episodes of a run.

    In the scene each posture is a ball at its wrist, in the colour of its verdict.

    Args:
        server: Of viser.
        session: It has the run.
        past: The run.
    """

    def __init__(self, server: viser.ViserServer, session: Session, past: Past) -> None:
        gui = server.gui
        self._scene, self._session, self._past = server.scene, session, past
        gui.add_markdown(
            f"The run **{past.name}**. Each ball in the scene is a posture, at its wrist, in the "
            "colour of its verdict. Click one, or choose it below."
        )
        self._row = gui.add_dropdown("Policy", past.rows, initial_value=past.rows[0])
        self._map = gui.add_html("")
        self._posture = gui.add_dropdown("Posture", self._names(), initial_value=self._names()[0])
        self._said = gui.add_markdown("")
        self._other = gui.add_dropdown("Compare with", (_NOBODY, *past.rows), initial_value=_NOBODY)
        self._play = gui.add_button("Replay", color="teal")
        self._balls: viser.BatchedMeshHandle | None = None
        when_asked(self._row, self._changed)
        when_asked(self._posture, self._chosen)
        when_pressed(self._play, self._replay)
        self._changed()

    def _episodes(self) -> list[EpisodeResult]:
        return self._past.episodes(self._row.value)

    def _names(self) -> tuple[str, ...]:
        return tuple(one.posture.name for one in self._past.episodes(self._row.value))

    def _changed(self) -> None:
        """Another row: its map, its balls, its postures."""
        episodes = self._episodes()
        self._posture.options = self._names()
        self._map.content = failure_map(episodes, self._posture.value)
        self._tell()
        places = np.array([one.posture.wrist for one in episodes], dtype=np.float32)
        colours = np.array([_rgb(colour_of(one.outcome)) for one in episodes], dtype=np.uint8)
        vertices, faces = capsule(np.zeros(3), np.zeros(3), _BALL)
        if self._balls is not None:
            self._balls.remove()
        self._balls = self._scene.add_batched_meshes_simple(
            "/postures",
            vertices,
            faces,
            batched_wxyzs=np.tile([1.0, 0.0, 0.0, 0.0], (len(places), 1)),
            batched_positions=places,
            batched_colors=colours,
            cast_shadow=False,
        )
        self._balls.on_click(self._clicked)

    def _clicked(self, event: viser.SceneNodePointerEvent[viser.BatchedMeshHandle]) -> None:
        episodes = self._episodes()
        places = np.array([one.posture.wrist for one in episodes])
        at = nearest(places, np.array(event.ray_origin), np.array(event.ray_direction))
        Shown().put(self._posture, episodes[at].posture.name)
        self._chosen()

    def _chosen(self) -> None:
        """Another posture: the arm takes it."""
        self._tell()
        self._map.content = failure_map(self._episodes(), self._posture.value)
        with self._session.telling():
            episode = self._past.episode(self._row.value, self._posture.value)
            self._session.choose_by(lambda choices: replace(choices, posture=episode.posture))

    def _tell(self) -> None:
        lines = []
        for row in self._past.rows:
            found = [
                one for one in self._past.episodes(row) if one.posture.name == self._posture.value
            ]
            lines += [f"| {row} | {verdict_of(one.outcome)} |" for one in found]
        self._said.content = "\n".join(["| policy | recorded |", "|-|-|", *lines])

    def _replay(self) -> None:
        other = self._other.value
        self._chosen()  # the arm's sliders are those of what is replayed
        beside = None if other in (_NOBODY, self._row.value) else other
        with self._session.telling():
            self._session.replay(self._row.value, self._posture.value, beside)

    def show(self) -> None:
        """The balls stand there while nobody is dressed."""
        if self._balls is not None and self._balls.visible == self._session.showing:
            self._balls.visible = not self._session.showing


def nearest(
    places: NDArray[np.float64], origin: NDArray[np.float64], direction: NDArray[np.float64]
) -> int:
    """Which of places (n, 3) [m] is nearest to a ray."""
    offset = places - origin
    along = np.maximum(offset @ direction / np.linalg.norm(direction) ** 2, 0.0)
    return int(np.linalg.norm(offset - along[:, None] * direction, axis=1).argmin())


def _rgb(colour: str) -> tuple[int, ...]:
    """Bytes of a colour that is seen as the map's: many meshes at once have theirs as light."""
    bright = np.frombuffer(bytes.fromhex(colour.removeprefix("#")), dtype=np.uint8) / 255.0
    light = np.where(bright <= 0.04045, bright / 12.92, ((bright + 0.055) / 1.055) ** 2.4)
    return tuple(np.round(255.0 * light).astype(int).tolist())


def failure_map(episodes: Sequence[EpisodeResult], chosen: str = "") -> str:
    """Verdicts over the elbow's and the shoulder's angle, as HTML with a legend that counts.

    The posture that is chosen has a ring.
    """
    width, height, edge = 320.0, 190.0, 26.0
    elbow = np.array([one.posture.elbow_deg for one in episodes])
    flexion = np.array([one.posture.flexion_deg for one in episodes])

    def spread(values: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
        wide = max(float(np.ptp(values)), 1.0)
        return low + (values - values.min()) / wide * (high - low)

    x, y = spread(elbow, edge, width - 10.0), spread(flexion, height - edge, 10.0)
    dots = "".join(
        f'<circle cx="{cx:.1f}" cy="{cy:.1f}" r="4" fill="{colour_of(one.outcome)}"'
        f"{_RING if one.posture.name == chosen else ''}>"
        f"<title>{one.posture.name}: {verdict_of(one.outcome)}</title></circle>"
        for one, cx, cy in zip(episodes, x, y, strict=True)
    )
    counts = Counter((colour_of(one.outcome), verdict_of(one.outcome)) for one in episodes)
    legend = "".join(
        f'<span style="white-space: nowrap"><span style="color: {colour}">&#9679;</span> {text} '
        f"{count}</span> "
        for (colour, text), count in counts.most_common()
    )
    ranges = (
        f"elbow {elbow.min():.0f} to {elbow.max():.0f}°",
        f"flexion {flexion.min():.0f} to {flexion.max():.0f}°",
    )
    return (
        f'<div style="padding: 4px 12px; font-size: 12px"><svg role="img" '
        f'aria-label="verdicts over elbow and flexion" style="width: 100%" '
        f'viewBox="0 0 {width:g} {height:g}">{dots}'
        f'<text x="{width / 2:g}" y="{height - 4:g}" font-size="11" text-anchor="middle" '
        f'fill="currentColor">{ranges[0]}</text>'
        f'<text x="10" y="{height / 2:g}" font-size="11" text-anchor="middle" fill="currentColor" '
        f'transform="rotate(-90 10 {height / 2:g})">{ranges[1]}</text></svg>{legend}</div>'
    )
