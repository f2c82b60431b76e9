"""Studies: each a module with its jobs, what one job does, its summary and its document."""

from __future__ import annotations

from collections.abc import Callable
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from dressing_sim.errors import InvalidInputError

if TYPE_CHECKING:
    from dressing_sim.benchmark.studies.study import Study


def _maker(place: str) -> Callable[[], object]:
    return lambda: resolve_name(place)()


#: What makes each study, by the name that protocols and run folders know it by.
STUDIES: dict[str, Callable[[], object]] = {
    "success": _maker(f"{__name__}.success:Success"),
    "cost": _maker(f"{__name__}.cost:Cost"),
    "thresholds": _maker(f"{__name__}.thresholds:ThresholdStudy"),
    "agreement": _maker(f"{__name__}.agreement:Agreement"),
    "change": _maker(f"{__name__}.change:Change"),
    "convergence": _maker(f"{__name__}.convergence:Convergence"),
    "confidence": _maker(f"{__name__}.confidence:Confidence"),
    "search": _maker(f"{__name__}.search:SearchStudy"),
    "tuning": _maker(f"{__name__}.tuning:Tuning"),
}


def find_study(name: str) -> Study[Any, Any]:
    """A study by its name, or from ``module:Class`` with a class that needs no arguments.

    Raises:
        InvalidInputError: There is no such study.
    """
    from dressing_sim.benchmark.studies.study import Study

    make = STUDIES.get(name) or (_maker(name) if ":" in name else None)
    try:
        study = make() if make else None
    except (ImportError, AttributeError, TypeError, ValueError) as error:
        raise InvalidInputError(f"study {name!r}: {error}") from error
    if not isinstance(study, Study):
        raise InvalidInputError(
            f"unknown study {name!r}; valid is one of {', '.join(STUDIES)}, or module:Class"
        )
    return study
