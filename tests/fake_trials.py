"""Made-up trials of a convergence study."""

from dataclasses import replace

from dressing_sim.benchmark.studies.convergence_trials import (
    CONVERGED,
    DEFAULT,
    FINEST,
    PATHS,
    Setting,
    Trial,
)
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.outcome import Failure, Outcome

NAMES = (DEFAULT, FINEST, CONVERGED, "coarse mesh")
CHOSEN = tuple(Setting(name, "", EpisodeConfig()) for name in NAMES)
STUCK = (Failure("stuck", "at the elbow"),)


def outcome(failures=(), strain=0.1, void=None):
    figures = {"strain": strain, "grip_force": 10 * strain, "armscye_s": 2.0}
    return Outcome(not failures and void is None, failures, figures, void)


def trials(n=10, seconds=1.0, **changed):
    """All succeed, but `changed` maps a setting's name to {posture number: outcome}."""
    places = [(setting, kind, i) for setting in CHOSEN for kind in PATHS for i in range(n)]
    return [
        Trial(
            index,
            setting.name,
            kind,
            f"p{i}",
            changed.get(setting.name.split()[0], {}).get(i, outcome()),
            seconds,
        )
        for index, (setting, kind, i) in enumerate(places)
    ]


def fake_simulate(job, config, posture, seed):
    """A success throughout; with seed 7 stuck throughout."""
    return replace(job, outcome=outcome(STUCK) if seed == 7 else outcome(), seconds=1.0)


def row(summary, name):
    return next(row for row in summary["rows"] if row["setting"] == name)
