"""Practice: a few parameters of a policy, chosen by dressing simulated arms.

Where demonstrations leave open how an elbow is passed, trying tells. CMA-ES (Hansen 2016,
arXiv:1604.00772) searches the parameters on postures drawn for nothing else, by how far dressings
stay from their limits, which is smooth where success is not. What it finds are hyper-parameters:
the practised policy answers for a new arm as before, without simulating anything.

A generation is an ordinary run, with its folder; it goes on where it was cut short.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.report.document import Document, Table
from dressing_sim.benchmark.run.executors import Workers
from dressing_sim.benchmark.run.plan import Plan, make_plan
from dressing_sim.benchmark.run.progress import Progress, silent
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.studies.columns import table_of
from dressing_sim.benchmark.studies.practice_document import TRIES
from dressing_sim.benchmark.studies.search import smallest_margin
from dressing_sim.benchmark.studies.study import EpisodeStudy, Summary, run_study
from dressing_sim.checks import whole_number
from dressing_sim.config import to_plain
from dressing_sim.errors import InvalidInputError
from dressing_sim.extras import needed
from dressing_sim.policies.search_spaces import Span, named
from dressing_sim.policies.transported import ELBOW_OFFSETS
from dressing_sim.provenance import versions
from dressing_sim.seeds import derived_seed
from dressing_sim.suites.distribution import PostureDistribution, sample_postures

#: Parameters that are practised, by policy.
SPACES: Mapping[str, Mapping[str, Span]] = {
    "transport": {name: Span(-0.25, 0.25) for name in ELBOW_OFFSETS}
}

#: Half of the postures are drawn from these, where sleeves get caught; the others from all.
BENT = PostureDistribution(elbow_deg=(60.0, 90.0))

#: Of CMA-ES at its start, in ranges of the parameters: about the policy as it is.
_MIDDLE, _WIDTH = 0.5, 0.2


@dataclass(frozen=True, slots=True)
class Practice:
    """What is practised, and how much it may cost.

    Attributes:
        policy: Its name.
        demonstrations: Suite that it learned from.
        postures: How many arms each try dresses; every one learned from the next of
            `demonstration_sets` sets.
        generations: Of CMA-ES.
        population: Tries in a generation.
        seed: Of the postures, of CMA-ES, and of the operator's variability.
        demonstration_sets: So that what is found serves more than one set.
    """

    policy: str = "transport"
    demonstrations: str = "case_a"
    postures: int = 12
    generations: int = 10
    population: int = 8
    seed: int = 0
    demonstration_sets: int = 3

    def __post_init__(self) -> None:
        for name, least, most in (
            ("postures", 2, 10_000),
            ("generations", 1, 1000),
            ("population", 4, 1000),
            ("demonstration_sets", 1, 100),
        ):
            whole_number(getattr(self, name), name, least, most)

    def check(self) -> None:
        """Refuse a policy that has nothing to practise, before anything runs."""
        _ = self.space

    @property
    def space(self) -> Mapping[str, Span]:
        """The parameters and their ranges.

        Raises:
            InvalidInputError: The policy has none.
        """
        kind = self.policy.partition("?")[0]
        if kind not in SPACES:
            raise InvalidInputError(
                f"policy {self.policy!r} has nothing to practise; valid is {', '.join(SPACES)}"
            )
        return SPACES[kind]

    def arms(self) -> tuple[Posture, ...]:
        """The postures, of no suite: every second one with the elbow bent by 60 to 90 degrees."""
        rng = np.random.default_rng(derived_seed(f"practice/{self.seed}"))
        few = self.postures // 2
        bent = sample_postures(few, rng, BENT, "practice-bent")
        usual = sample_postures(self.postures - few, rng, prefix="practice")
        mixed = [arm for pair in zip(usual, bent, strict=False) for arm in pair]
        return (*mixed, *usual[few:])

    def plan(self, names: Sequence[str], arms: tuple[Posture, ...], generation: int) -> Plan:
        """The run of a generation."""
        entries = tuple(Entry(name, self.demonstrations) for name in dict.fromkeys(names))
        name = f"practice-{self.policy}-{self.demonstrations}-{generation}"
        protocol = Protocol(
            name,
            "val50",
            entries,
            demonstration_sets=self.demonstration_sets,
            study=f"{__name__}:Generation",
        )
        return replace(make_plan(protocol, self.seed), tested=arms)


def practise(
    what: Practice,
    workers: Workers,
    out: Path,
    resume: bool = False,
    force: bool = False,
    progress: Progress = silent,
    study: Generation | None = None,
) -> dict[str, Any]:
    """Carry it out.

    Args:
        what: What is practised.
        workers: Where episodes run.
        out: Folder; each generation has a run's folder in it.
        resume: Continue the generations that are there.
        force: Begin anew whatever the generations' folders hold.
        progress: Told after each episode.
        study: How a generation is carried out, if otherwise.

    Returns:
        ``{"policy", "chosen", "before", "after", "generations", "n_episodes", "practice",
        "versions"}``: the name of the practised policy; of the policy before and after practice,
        ``{"policy", "n_episodes", "n_success", "margin"}`` on the postures of practice; of each
        generation its best margin and its mean.
    """
    study = study or Generation()
    cmaes = needed("cmaes", "practice")
    space, arms = what.space, what.arms()
    search = cmaes.CMA(
        mean=np.full(len(space), _MIDDLE),
        sigma=_WIDTH,
        bounds=np.tile([0.0, 1.0], (len(space), 1)),
        seed=what.seed,
        population_size=what.population,
    )
    tried: dict[str, dict[str, Any]] = {}
    told = []
    for generation in range(what.generations):
        asked = [np.asarray(search.ask()) for _ in range(what.population)]
        names = [named(what.policy, space, shares) for shares in asked]
        first = [what.policy] if generation == 0 else []
        plan = what.plan([*first, *names], arms, generation)
        where = out / str(generation)
        run = run_study(study, plan, workers, where, resume=resume, force=force, progress=progress)
        tried |= {row["policy"]: row for row in run.summary["rows"]}
        margins = [tried[name]["margin"] for name in names]
        search.tell([(shares, -m) for shares, m in zip(asked, margins, strict=True)])
        told.append({"best": max(margins), "mean": float(np.mean(margins))})
    chosen = max(tried.values(), key=lambda row: row["margin"])
    return {
        "policy": what.policy,
        "chosen": chosen["policy"],
        "before": tried[what.policy],
        "after": chosen,
        "generations": told,
        "n_episodes": sum(row["n_episodes"] for row in tried.values()),
        "practice": to_plain(what),
        "versions": versions(),
    }


@dataclass(frozen=True)
class Generation(EpisodeStudy):
    """Tries of one generation, all on the same arms."""

    def summarise(self, folder: RunFolder, results: Sequence[EpisodeResult]) -> dict[str, Any]:
        """How far each try stayed from the limits: ``{"rows": [...], "versions"}``."""
        names = dict.fromkeys(entry.policy for entry in folder.plan.protocol.entries)
        return {"rows": [_tried(name, results) for name in names], "versions": versions()}

    def document(
        self, folder: RunFolder, results: Sequence[EpisodeResult], summary: Summary, command: str
    ) -> Document:
        """A table of the tries."""
        table = Table(table_of(TRIES, summary["rows"]))
        return Document("Tries of one generation", command, (table,), ())


def _tried(name: str, results: Sequence[EpisodeResult]) -> dict[str, Any]:
    """What a try's episodes, void ones aside, say of it."""
    own = [r for r in results if r.entry.policy == name and r.outcome.invalid is None]
    margins: NDArray[np.float64] = np.array([smallest_margin(result) for result in own])
    return {
        "policy": name,
        "n_episodes": len(own),
        "n_success": sum(result.outcome.success for result in own),
        "margin": float(margins.mean()) if len(own) else -1.0,
    }
