"""The study of several training sets: as numbers, and as Markdown."""

from collections.abc import Sequence
from dataclasses import asdict
from itertools import product
from typing import Any

import numpy as np

from dressing_sim.planar.claims import CLAIMS, judged
from dressing_sim.planar.measures import measures
from dressing_sim.planar.sets import KINDS, Ratio, best_gain, gain, initial_cost
from dressing_sim.planar.study import Study


def sets_summary(studies: Sequence[Study], source: str) -> dict[str, Any]:
    """The whole result as JSON-able numbers.

    Args:
        studies: of ``run_sets``, one at least.
        source: where the demonstrations are from.
    """
    first = studies[0]
    kinds = [kind for kind in KINDS if initial_cost(first, kind) is not None]
    demonstrations = {
        id(one): one
        for study in studies
        for one in (*study.data.training, *study.data.validation, *study.data.test)
    }
    settings = first.config
    return {
        "source": source,
        "initial": {kind: [initial_cost(study, kind) for study in studies] for kind in kinds},
        "rows": [
            {
                "selection": selection,
                "method": method,
                **{kind: _cell(studies, method, selection, kind) for kind in kinds},
            }
            for selection, method in product(first.selections, settings.methods)
        ],
        "claims": _claims(studies),
        "demonstrations": asdict(measures([*demonstrations.values()])),
        "settings": {
            "components": settings.components,
            "fusion": settings.fusion,
            "runs": settings.runs,
            "seed": settings.seed,
            "max_demonstrations": settings.options.max_demonstrations,
            "max_iterations": settings.options.max_iterations,
            "snr_db": settings.options.snr_db,
            "noise_reference": settings.options.noise_reference,
            "retrain": settings.options.retrain,
            "situations": settings.situations,
            "sets": len(studies),
        },
    }


def _cell(studies: Sequence[Study], method: Any, selection: Any, kind: str) -> dict[str, Any]:
    logs = [gain(study, method, selection, kind) for study in studies]
    best = [best_gain(study, method, selection, kind) for study in studies]
    return {
        "percent": _percent(Ratio.of(logs)),
        "percent_of_best": _percent(Ratio.of(best)),
        "percent_of_sets": [100.0 * float(np.exp(log)) for log in logs],
    }


def _percent(ratio: Ratio) -> dict[str, float | None]:
    """In per cent; None for a bound that one set cannot give."""
    bounded = ratio.n > 1
    return {
        "mean": 100.0 * ratio.estimate,
        "low": 100.0 * ratio.low if bounded else None,
        "high": 100.0 * ratio.high if bounded else None,
    }


def _claims(studies: Sequence[Study]) -> list[dict[str, Any]]:
    rows = []
    for claim in CLAIMS:
        found = judged(claim, studies)
        if found is not None:
            ratio, verdict = found
            percent = _percent(ratio)
            rows.append(
                {"claim": claim.text, "said": claim.side, "percent": percent, "verdict": verdict}
            )
    return rows


def sets_markdown(result: dict[str, Any]) -> str:
    """The tables of ``sets_summary``: gains, claims and the demonstrations' statistics."""
    settings, kinds = result["settings"], list(result["initial"])
    lines = [
        f"K = {settings['components']}, {settings['fusion']}, {settings['sets']} sets of "
        f"{result['source']}, {settings['runs']} runs each, seed {settings['seed']}",
        "",
        "Cost in per cent of the same set's initial model: geometric mean over the sets [95 %].",
        "",
        "| selection | method | " + " | ".join(f"{kind} | best run" for kind in kinds) + " |",
        "|-|-|" + "-|-|" * len(kinds),
    ]
    for row in result["rows"]:
        cells = [row["selection"], row["method"]]
        for kind in kinds:
            cells += [
                _interval(row[kind]["percent"]),
                f"{row[kind]['percent_of_best']['mean']:.0f}",
            ]
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["", "| claim | ratio said | found, % | |", "|-|-|-|-|"]
    said = {"below": "< 100", "above": "> 100", "near": "91 to 110"}
    for row in result["claims"]:
        cells = [row["claim"], said[row["said"]], _interval(row["percent"]), row["verdict"]]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join([*lines, "", *_statistics(result["demonstrations"])]) + "\n"


def _interval(percent: dict[str, float | None]) -> str:
    if percent["low"] is None:
        return f"{percent['mean']:.0f}"
    return f"{percent['mean']:.0f} [{percent['low']:.0f}, {percent['high']:.0f}]"


def _statistics(found: dict[str, float]) -> list[str]:
    names = [name for name in found if name != "n"]
    return [
        f"Statistics of the {found['n']} demonstrations:",
        "",
        "| " + " | ".join(name.replace("_", " ") for name in names) + " |",
        "|" + "-|" * len(names),
        "| " + " | ".join(f"{found[name]:.2g}" for name in names) + " |",
    ]
