"""The paper's figures, drawn from a study."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Polygon
from matplotlib.ticker import MaxNLocator

from dressing_sim.files import write_files
from dressing_sim.learning.demonstrations import DemonstrationLike, in_frames
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.planar.box import outline
from dressing_sim.planar.study import Selection, Study, situation_sampler

BOX_COLOURS = ("0.75", "#f2c84b")  # start grey, goal yellow, as in the paper
EXPERT, INITIAL = "#1f5fbf", "#c8372d"
METHOD_COLOURS = {"noise": "black", "rf": "#2a9d3a", "rf+noise": "#17a5b8", "copies": "0.6"}
SIZE = 2.6  # of one panel, inches


def draw(study: Study, folder: Path) -> list[Path]:
    """Write all figures as PNG files into ``folder`` and return their paths."""
    pictures = drawn(study)
    write_files({folder / name: content for name, content in pictures.items()})
    return [folder / name for name in pictures]


#: The files of `drawn`.
NAMES = tuple(
    f"{name}.png"
    for name in ("demonstrations", "reproductions", "generalisation", "frames", "cost")
)


def drawn(study: Study) -> dict[str, bytes]:
    """All figures as PNG files, by their names."""
    figures = (
        _demonstrations(study),
        _reproductions(study),
        _generalisation(study),
        _frames(study),
        _cost(study),
    )
    pictures = {}
    for name, figure in zip(NAMES, figures, strict=True):
        file = BytesIO()
        figure.savefig(file, dpi=130, bbox_inches="tight", metadata={"Software": None})
        plt.close(figure)
        pictures[name] = file.getvalue()
    return pictures


def _panels(n_rows: int, n_columns: int) -> tuple[Figure, Any]:
    figure, axes = plt.subplots(
        n_rows,
        n_columns,
        figsize=(SIZE * n_columns, SIZE * n_rows),
        squeeze=False,
        layout="constrained",
    )
    return figure, axes


def _boxes(axes: Axes, frames: Sequence[Frame]) -> None:
    for frame, colour in zip(frames, BOX_COLOURS, strict=False):
        axes.add_patch(Polygon(outline(frame), facecolor=colour, edgecolor="0.4", lw=0.6))


def _world(axes: Axes, title: str) -> None:
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_title(title, fontsize=9)
    axes.tick_params(labelsize=7)
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.yaxis.set_major_locator(MaxNLocator(4))


def _line(axes: Axes, path: FloatArray, colour: str, **style: Any) -> None:
    axes.plot(path[:, 0], path[:, 1], color=colour, **{"lw": 1.3, **style})


def _demonstrations(study: Study) -> Figure:
    """Demonstrations to train and to validate with, each in its situation."""
    groups = [("train", study.data.training), ("validate", study.data.validation)]
    groups = [group for group in groups if group[1]]
    columns = max(len(group[1]) for group in groups)
    figure, axes = _panels(len(groups), columns)
    for row, (name, demonstrations) in zip(axes, groups, strict=True):
        for panel in row[len(demonstrations) :]:
            panel.set_axis_off()
        for index, (panel, demonstration) in enumerate(zip(row, demonstrations, strict=False)):
            _boxes(panel, demonstration.frames)
            _line(panel, demonstration.positions, EXPERT)
            _world(panel, f"{name} {index + 1}")
    return figure


def _reproductions(study: Study) -> Figure:
    """Training situations: the expert, and the initial and the improved policies."""
    names: list[Any] = [None, *study.config.methods]
    figure, axes = _panels(len(study.data.training), len(names))
    for row, demonstration in zip(axes, study.data.training, strict=True):
        for panel, name in zip(row, names, strict=True):
            policy: Any = study.initial if name is None else _best(study, name)
            _boxes(panel, demonstration.frames)
            _line(panel, demonstration.positions, EXPERT, label="expert")
            _line(panel, policy.reproduce(demonstration).positions, INITIAL, label="policy")
            _world(panel, name or "initial")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, loc="outside lower center", ncols=len(labels))
    return figure


def _best(study: Study, method: Any, selection: Selection = "original") -> Any:
    return study.best(method, selection).augmentation.policy


def _generalisation(study: Study) -> Figure:
    """Validation situations or, where there are none, random ones without an expert."""
    experts: Sequence[DemonstrationLike] = study.data.validation
    if experts:
        situations = [expert.frames for expert in experts]
    else:
        sampler = situation_sampler(study.data, study.config.situations)
        rng = np.random.default_rng(study.config.seed)
        situations = [sampler.sample(rng) for _ in range(3)]
    figure, axes = _panels(1, len(situations))
    for index, (panel, frames) in enumerate(zip(axes[0], situations, strict=True)):
        _boxes(panel, frames)
        if experts:
            _line(panel, np.asarray(experts[index].positions), EXPERT, ls="--", label="expert")
        _line(panel, study.initial.generate(frames), INITIAL, label="initial")
        for method in study.config.methods:
            path = _best(study, method).generate(frames)
            _line(panel, path, METHOD_COLOURS[method], label=method)
        _world(panel, f"{'validate' if experts else 'random situation'} {index + 1}")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=7, loc="outside lower center", ncols=len(labels))
    return figure


def _frames(study: Study) -> Figure:
    """Data and components seen from each frame, before and after augmentation."""
    method = "rf" if "rf" in study.config.methods else study.config.methods[0]
    improved = study.best(method, "original").augmentation
    stages: list[tuple[str, Any, Sequence[DemonstrationLike]]] = [
        ("initial", study.initial, study.data.training),
        (f"{method}, final", improved.policy, improved.demonstrations),
    ]
    n_frames = len(study.data.training[0].frames)
    figure, axes = _panels(2, n_frames)
    for row, (name, policy, demonstrations) in zip(axes, stages, strict=True):
        mixture = policy.model.fitted()
        for p, panel in enumerate(row):
            for index, demonstration in enumerate(demonstrations):
                synthetic = index >= len(study.data.training)
                local = in_frames(np.asarray(demonstration.positions), demonstration.frames)[p]
                _line(panel, local, INITIAL if synthetic else EXPERT, lw=0.8, alpha=0.8)
            for k in range(mixture.n_components):
                _ellipse(panel, mixture.means[k, p, 1:], mixture.covariances[k, p, 1:, 1:], k)
            place = {0: "start frame", 1: "goal frame"}.get(p, f"frame {p}")
            _world(panel, f"{name}, {place}")
    return figure


def _ellipse(axes: Axes, mean: FloatArray, covariance: FloatArray, k: int) -> None:
    """Two standard deviations of a Gaussian."""
    values, vectors = np.linalg.eigh(covariance)
    width, height = 4.0 * np.sqrt(np.maximum(values, 0.0))
    angle = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
    colour = plt.get_cmap("tab10")(k % 10)
    axes.add_patch(
        Ellipse((mean[0], mean[1]), width, height, angle=angle, facecolor=colour, alpha=0.35, lw=0)
    )


def _cost(study: Study) -> Figure:
    """Cost against the number of accepted demonstrations: mean and spread of the runs."""
    figure, axes = _panels(1, len(study.selections))
    most = study.config.options.max_demonstrations - len(study.data.training)
    for panel, selection in zip(axes[0], study.selections, strict=True):
        for method in study.config.methods:
            curves = []
            for run in study.of(method, selection):
                costs = [run.augmentation.initial_cost]
                costs += [candidate.cost for candidate in run.augmentation.accepted]
                # A run that accepted fewer keeps the cost that it has.
                curves.append(costs + [costs[-1]] * (most + 1 - len(costs)))
            values = np.array(curves)
            mean, sd = values.mean(axis=0), values.std(axis=0)
            count = np.arange(values.shape[1])
            panel.plot(count, mean, color=METHOD_COLOURS[method], marker="o", ms=3, label=method)
            panel.fill_between(
                count, mean - sd, mean + sd, color=METHOD_COLOURS[method], alpha=0.15, lw=0
            )
        panel.set_title(f"{selection} selection", fontsize=9)
        panel.set_xlabel("accepted demonstrations", fontsize=8)
        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
        panel.tick_params(labelsize=7)
    axes[0, 0].set_ylabel("cost (mean ± sd of the runs)", fontsize=8)
    axes[0, 0].legend(fontsize=7)
    return figure
