"""Studies: each a module with its jobs, what one job does, its summary and its document."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

from dressing_sim.errors import InvalidInputError

if TYPE_CHECKING:
    from dressing_sim.benchmark.studies.study import Study


def _of(place: str) -> Callable[[], object]:
    def make() -> object:
        module, _, name = place.partition(":")
        made: object = getattr(import_module(module), name)()
        return made

    return make


#: What makes each study, by the name that protocols and run folders know it by.
STUDIES: dict[str, Callable[[], object]] = {
    name: _of(f"dressing_sim.benchmark.studies.{name}:{kind}")
    for name, kind in (
        ("success", "Success"),
        ("cost", "Cost"),
        ("thresholds", "ThresholdStudy"),
        ("convergence", "Convergence"),
        ("tuning", "Tuning"),
    )
}


def find_study(name: str) -> Study[Any, Any]:
    """A study by its name, or from ``module:Class`` with a class that needs no arguments.

    Raises:
        InvalidInputError: There is no such study.
    """
    from dressing_sim.benchmark.studies.study import Study

    make = STUDIES.get(name) or (_of(name) if ":" in name else None)
    try:
        study = make() if make else None
    except (ImportError, AttributeError, TypeError, ValueError) as error:
        raise InvalidInputError(f"study {name!r}: {error}") from error
    if not isinstance(study, Study):
        raise InvalidInputError(
            f"unknown study {name!r}; valid is one of {', '.join(STUDIES)}, or module:Class"
        )
    return study
