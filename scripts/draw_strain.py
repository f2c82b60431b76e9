"""Draws docs/strain.png: a sleeve led round the elbow, and one pulled straight to the shoulder."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from dressing_sim.benchmark.studies.convergence_trials import path_of
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.rollout import follow
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.files import write_file
from dressing_sim.pictures.rendering import OffscreenRenderer
from dressing_sim.pictures.strain_colours import COLOURS
from dressing_sim.suites.suites import find_posture
from dressing_sim.world.scene import grip_start
from dressing_sim.world.simulation import World
from dressing_sim.world.strain import StrainGauge

POSTURE, SEED = "bent55", 0
FILE = Path("docs/strain.png")


def most_strained(kind: str) -> tuple[NDArray[np.float64], Outcome]:
    """The scene's positions when the cloth is strained most, and what became of the episode."""
    posture, config = find_posture(POSTURE), EpisodeConfig()
    episode = Dressing(posture, config)
    episode.reset()
    gauge = StrainGauge(episode.world.mesh)
    percent = config.thresholds.strain_percentile
    worst, state = -1.0, episode.world.data.qpos.copy()

    def watch(world: World) -> None:
        nonlocal worst, state
        strain = gauge.percentile(gauge.principal(world.cloth), percent)
        if strain > worst:
            worst, state = strain, world.data.qpos.copy()

    path, dt = path_of(kind, posture, grip_start(posture, config.world.sleeve), SEED)
    outcome = follow(episode, path, dt, watch).outcome
    return state, outcome


def main() -> None:
    """Draw the picture."""
    top = Thresholds().strain
    figure = Figure(figsize=(9.0, 3.9), layout="constrained")
    panels = figure.subplots(1, 2)
    scenes = []
    for kind in ("expert", "straight"):
        state, outcome = most_strained(kind)
        scenes.append((kind, state, outcome))
    posture = find_posture(POSTURE)
    with OffscreenRenderer(posture, EpisodeConfig().world, 900, 720, strain_top=top) as renderer:
        for axes, (kind, state, outcome) in zip(panels, scenes, strict=True):
            axes.imshow(renderer.draw(state, "close"))
            verdict = "success" if outcome.success else ", ".join(outcome.reasons)
            axes.set_title(
                f"{kind} path: {verdict}; {100 * outcome.metrics['strain']:.0f} %", fontsize=10
            )
            axes.axis("off")
    scale = ScalarMappable(
        Normalize(0.0, 100 * top), LinearSegmentedColormap.from_list("strain", COLOURS)
    )
    figure.colorbar(scale, ax=panels, label="principal strain [%]", extend="max", shrink=0.8)
    content = BytesIO()
    figure.savefig(content, format="png", dpi=110, metadata={"Software": None})
    write_file(FILE, content.getvalue())


if __name__ == "__main__":
    main()
