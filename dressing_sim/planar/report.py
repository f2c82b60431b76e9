"""The study's table: as numbers, and as Markdown next to the paper's."""

from typing import Any

import numpy as np

from dressing_sim.planar import paper
from dressing_sim.planar.box import mean_violation
from dressing_sim.planar.study import Run, Study


def summary(study: Study) -> dict[str, Any]:
    """The whole result as JSON-able numbers: initial costs, then a row a method and selection.

    ``best`` is the run with the lowest cost by its criterion of selection, as in the paper; its
    training and validation cost are both reported. What there is no validation set for is None.
    """
    validation = study.data.validation
    return {
        "initial_training_cost": study.initial_training_cost,
        "initial_validation_cost": study.initial_validation_cost,
        "initial_training_violation": mean_violation(
            [study.initial.reproduce(d) for d in study.data.training]
        ),
        "initial_validation_violation": mean_violation(
            [study.initial.reproduce(d) for d in validation]
        )
        if validation
        else None,
        "rows": [
            _row(study, selection, method)
            for selection in study.selections
            for method in study.config.methods
        ],
        "paper": {
            "initial_training_cost": paper.INITIAL_TRAINING_COST,
            "initial_validation_cost": paper.INITIAL_VALIDATION_COST,
        },
        "settings": {
            "components": study.config.components,
            "fusion": study.config.fusion,
            "runs": study.config.runs,
            "seed": study.config.seed,
            "max_demonstrations": study.config.options.max_demonstrations,
            "max_iterations": study.config.options.max_iterations,
            "snr_db": study.config.options.snr_db,
            "noise_reference": study.config.options.noise_reference,
            "retrain": study.config.options.retrain,
            "situations": study.config.situations,
            "n_training": len(study.data.training),
            "n_validation": len(validation),
        },
    }


def _row(study: Study, selection: Any, method: Any) -> dict[str, Any]:
    runs, best = study.of(method, selection), study.best(method, selection)
    row: dict[str, Any] = {"method": method, "selection": selection, "runs": len(runs)}
    initial = {
        "training": study.initial_training_cost,
        "validation": study.initial_validation_cost,
    }
    for index, kind in enumerate(("training", "validation")):
        name, start = f"{kind}_cost", initial[kind]
        values = [value for run in runs if (value := getattr(run, name)) is not None]
        printed = paper.TABLE.get((selection, method), (None, None))[index]
        if start is None or not values:
            row |= {f"{name}_{key}": None for key in ("best", "mean", "sd")}
            row |= {f"{name}_best_percent": None, f"{name}_mean_percent": None}
        else:
            mean = float(np.mean(values))
            row[f"{name}_best"] = getattr(best, name)
            row[f"{name}_mean"] = mean
            row[f"{name}_sd"] = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
            row[f"{name}_best_percent"] = 100.0 * getattr(best, name) / start
            row[f"{name}_mean_percent"] = 100.0 * mean / start
        row[f"paper_{name}"] = printed
    row["accepted_mean"] = float(np.mean([len(run.augmentation.accepted) for run in runs]))
    row["discarded_mean"] = float(np.mean([_discarded(run) for run in runs]))
    row["best_training_violation"] = _violation(best, study.data.training)
    row["best_validation_violation"] = _violation(best, study.data.validation)
    return row


def _discarded(run: Run) -> int:
    return len(run.augmentation.history) - len(run.augmentation.accepted)


def _violation(run: Run, demonstrations: Any) -> float | None:
    if not demonstrations:
        return None
    policy: Any = run.augmentation.policy
    return mean_violation([policy.reproduce(demonstration) for demonstration in demonstrations])


def markdown(result: dict[str, Any]) -> str:
    """The table of ``summary`` as Markdown: cost and per cent of the initial model's."""
    settings, printed = result["settings"], result["paper"]
    lines = [
        f"K = {settings['components']}, {settings['fusion']}, {settings['runs']} runs, "
        f"seed {settings['seed']}, {settings['n_training']} demonstrations to train, "
        f"{settings['n_validation']} to validate",
        "",
        "| selection | method | training: best | mean ± sd | paper | "
        "validation: of that model | mean ± sd | paper | accepted / discarded | wall depth |",
        "|-|-|-|-|-|-|-|-|-|-|",
        "| | initial | "
        + " | ".join(
            (
                _cost(result["initial_training_cost"], 100.0),
                "",
                f"{printed['initial_training_cost']:.2f}",
                _cost(result["initial_validation_cost"], 100.0),
                "",
                f"{printed['initial_validation_cost']:.2f}",
                "",
                _depth(
                    result["initial_training_violation"], result["initial_validation_violation"]
                ),
            )
        )
        + " |",
    ]
    for row in result["rows"]:
        cells = [row["selection"], row["method"]]
        for kind in ("training", "validation"):
            name = f"{kind}_cost"
            cells.append(_cost(row[f"{name}_best"], row[f"{name}_best_percent"]))
            mean, sd = row[f"{name}_mean"], row[f"{name}_sd"]
            cells.append("-" if mean is None else f"{mean:.3f} ± {sd:.3f}")
            printed_cost = row[f"paper_{name}"]
            cells.append("" if printed_cost is None else f"{printed_cost:.2f}")
        cells.append(f"{row['accepted_mean']:.1f} / {row['discarded_mean']:.1f}")
        cells.append(_depth(row["best_training_violation"], row["best_validation_violation"]))
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _cost(value: float | None, percent: float | None) -> str:
    return "-" if value is None or percent is None else f"{value:.3f} ({percent:.0f} %)"


def _depth(training: float, validation: float | None) -> str:
    return f"{training:.3f}" + ("" if validation is None else f", {validation:.3f}")
