"""Made-up trials of a convergence study."""

from dressing_sim.benchmark.studies.convergence import (
    CONVERGED,
    DEFAULT,
    FINEST,
    PATHS,
    Setting,
    Trial,
)
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.rules import Failure, Outcome

NAMES = (DEFAULT, FINEST, CONVERGED, "coarse mesh")
CHOSEN = tuple(Setting(name, "", EpisodeConfig()) for name in NAMES)
STUCK = (Failure("stuck", "at the elbow"),)


def outcome(failures=(), strain=0.1, void=None):
    figures = {"strain": strain, "grip_force": 10 * strain, "armscye_s": 2.0}
    return Outcome(not failures and void is None, failures, figures, void)


def trials(n=10, seconds=1.0, **changed):
    """All succeed, but `changed` maps a setting's name to {posture number: outcome}."""
    made = []
    for setting in CHOSEN:
        other = changed.get(setting.name.split()[0], {})
        made += [
            Trial(setting.name, kind, f"p{i}", other.get(i, outcome()), seconds)
            for kind in PATHS
            for i in range(n)
        ]
    return made


def row(summary, name):
    return next(row for row in summary["rows"] if row["setting"] == name)
