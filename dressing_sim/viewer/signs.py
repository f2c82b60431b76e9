"""Labels and arrows in the scene: forces with newtons, where to go, what went wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import first_failure
from dressing_sim.viewer.live import Live, Moment
from dressing_sim.viewer.past import title_of
from dressing_sim.viewer.shapes import link_centres
from dressing_sim.world.mannequin import LINKS

if TYPE_CHECKING:
    import viser

#: Length of an arrow for each newton [m].
_PER_NEWTON = 0.03

#: Forces below this have no arrow [N].
_LEAST = 0.2

#: Labels: of forces, and others.
_FORCES, _OTHERS = (*LINKS, "grip"), ("ball", "end", "failure")


class Signs:
    """Labels and arrows.

    Args:
        scene: Of viser.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._arrows: viser.SceneNodeHandle | None = None
        self._labels = {
            name: scene.add_label(f"/labels/{name}", "", visible=False)
            for name in (*_FORCES, *_OTHERS)
        }

    def put(self, name: str, text: str, place: NDArray[np.float64] | None) -> None:
        """A label at a place (3,) [m]; none without a text or a place."""
        label = self._labels[name]
        label.visible = bool(text) and place is not None
        if text and place is not None:
            label.text, label.position = text, place

    def failure(self, live: Live | None) -> None:
        """A label where the first thing went wrong in a dressing that is over, or none."""
        outcome = None if live is None else live.outcome
        failure = None if outcome is None else first_failure(outcome)
        if live is None or failure is None:
            self.put("failure", "", None)
            return
        posture = live.dressing.posture
        places = {name.replace("_", " "): at for name, at in link_centres(posture).items()}
        places |= {name: getattr(posture, name) for name in ("shoulder", "elbow", "wrist")}
        place = places.get(failure.where or "", live.moments[-1].row.tcp)
        self.put("failure", f"\u2717 {title_of(failure)}", place)

    def forces(self, posture: Posture, moment: Moment | None) -> None:
        """Arrows of the cloth's force on each link of the arm, with newtons; and the pull."""
        arrows = []
        for name in _FORCES:
            centre = link_centres(posture).get(name)
            if moment is None or (centre is None and name != "grip"):
                self.put(name, "", None)
                continue
            if name == "grip":
                place, newtons = moment.row.tcp, moment.row.grip_force
                place, text = place + [0.0, 0.0, 0.06], f"pull {newtons:.1f} N"
            else:
                force = moment.row.link_force[LINKS.index(name)]
                newtons, text = float(np.linalg.norm(force)), ""
                assert centre is not None
                begin = centre + 0.05 * force / max(newtons, _LEAST)  # out of the arm
                place = begin + _PER_NEWTON * force
                if newtons >= _LEAST:
                    arrows.append([begin, place])
                    text = f"{name.replace('_', ' ')} {newtons:.1f} N"
            self.put(name, text if newtons >= _LEAST else "", place)
        if self._arrows is not None:
            self._arrows.remove()
            self._arrows = None
        if arrows:
            self._arrows = self._scene.add_arrows(
                "/forces",
                np.array(arrows, dtype=np.float32),
                colors=(200, 30, 30),
                shaft_radius=0.004,
                head_radius=0.010,
                head_length=0.02,
            )
