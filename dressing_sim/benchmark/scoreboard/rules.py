"""Which runs may stand on the scoreboard, and what their submitter has to say."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import date
from functools import cache

from dressing_sim.arm import Posture
from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.study import read_results
from dressing_sim.checks import clean_name, shown
from dressing_sim.config import check_kinds
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.policy import INPUTS
from dressing_sim.policies.confidence import split_judged
from dressing_sim.policies.host import PolicyLimits
from dressing_sim.policies.hosted import is_ours
from dressing_sim.policies.registry import learns
from dressing_sim.suites.suites import load_suite, suite_names

#: Suites for testing, and for nothing else: results on these can be compared.
TEST_SUITES = ("paper5", "test200", "hard_elbow")

#: The seed of all runs: the best of many seeds would be no result.
SEED = 0

#: Names of policies, demonstrations and packages: nothing that Markdown, a shell or a path needs.
PLAIN = re.compile(r"[\w.:?=&+@,-]{1,200}", re.ASCII)

_PACKAGE = re.compile(r"[\w.:?=&+@,~/#%-]{1,200}", re.ASCII)
_LINK = re.compile(r"(https?://[\w.~:/?#@&+=%-]{1,190})?", re.ASCII)
_CHECKSUM = re.compile(r"[0-9a-f]{64}")
_MARKUP = re.compile(r"[<>\[\]`*|\\{}&\"]")


@dataclass(frozen=True, slots=True)
class Statement:
    """What a submitter says of a run, which its folder does not tell.

    Attributes:
        name: Who submits.
        date: When, as ``YYYY-MM-DD``.
        link: To a person, a paper or a repository, starting with ``https://``; may be empty.
        package: What pip installs to get the policies, such as ``mine==1.2`` or an address; empty
            for those of this package.
        practised: Whether a policy's parameters were found by trying it in the simulator.
        mixed_code: Whether episodes were made with more than one version of the code.

    Raises:
        InvalidInputError: A text that is none, or could be taken for something else.
    """

    name: str
    date: str
    link: str = ""
    package: str = ""
    practised: bool = False
    mixed_code: bool = False

    def __post_init__(self) -> None:
        check_kinds(self, "a submission")
        clean_name(self.name, "a submission: name")
        if _MARKUP.search(self.name):
            raise InvalidInputError(
                f"a submission: name is {shown(self.name)}, valid is one without markup"
            )
        if not _LINK.fullmatch(self.link):
            raise InvalidInputError(
                f"a submission: link is {shown(self.link)}, valid is https://... or nothing"
            )
        if self.package and not _PACKAGE.fullmatch(self.package):
            raise InvalidInputError(
                f"a submission: package is {shown(self.package)}, valid is what pip installs, "
                "such as mine==1.2 or git+https://..."
            )
        try:
            plain = date.fromisoformat(self.date).isoformat() == self.date
        except ValueError:
            plain = False
        if not plain:
            raise InvalidInputError(
                f"a submission: date is {shown(self.date)}, valid is YYYY-MM-DD"
            )


def check_run(run: RunFolder, statement: Statement) -> None:
    """Raise InvalidInputError, with what is valid, unless a run keeps the scoreboard's rules."""
    plan = run.plan
    for broken in (_test(plan), _policies(plan), _taught(plan), _episodes(run)):
        for told in broken:
            raise InvalidInputError(told)
    if not run.origin.numerics:
        raise InvalidInputError("it does not say on what it was computed; valid is a newer run")
    policies = [entry.policy for entry in plan.protocol.entries]
    if any(map(run.origin.mixed, policies)) != statement.mixed_code:
        raise InvalidInputError(
            "episodes of more than one version of the code: valid is a run of one, or to say so "
            "with --accept-changes; a run of one says nothing"
        )
    if not statement.package and not all(map(is_ours, policies)):
        raise InvalidInputError(
            "its policies are not of this package; valid is --package with what pip installs"
        )


def _test(plan: Plan) -> Iterator[str]:
    """What is wrong with how it was tested."""
    protocol = plan.protocol
    if protocol.study != "success":
        yield f"a run of study {shown(protocol.study)}, valid is one of 'dressing-sim evaluate'"
    if protocol.suite not in TEST_SUITES:
        yield f"suite {shown(protocol.suite)}, valid is a test suite: {', '.join(TEST_SUITES)}"
    if plan.tested != tuple(load_suite(protocol.suite)):
        yield f"other postures than suite {protocol.suite} has, valid is a run without --person"
    if plan.config != EpisodeConfig():
        yield (
            "another world or other rules than the benchmark's, valid is a run without --garment "
            "and --robot"
        )
    if plan.seed != SEED:
        yield f"seed {plan.seed}, valid is a run with --seed {SEED}, so that nobody chooses one"
    if plan.policy_limits != PolicyLimits():
        yield "other limits of time and memory, valid is a run without --fit-time and the like"
    if not 1 <= protocol.demonstration_sets <= len(plan.tested):
        yield f"{protocol.demonstration_sets} demonstration sets, valid is 1 to {len(plan.tested)}"
    if any(entry.variation for entry in protocol.entries):
        yield "a varied world, valid is a run without --variation"


def _policies(plan: Plan) -> Iterator[str]:
    entries = plan.protocol.entries
    if not entries or len(set(entries)) < len(entries):
        yield "no rows, or two that are the same; valid is one or more"
    for entry in entries:
        name = shown(entry.policy)
        if not PLAIN.fullmatch(entry.policy):
            yield f"policy {name}, valid is a name of letters, digits and . : ? = & + @ , -"
        if split_judged(entry.policy)[1] is not None:
            yield f"policy {name} reads a judge's file, which others do not have; valid is without"
        if entry.inputs not in INPUTS:
            yield f"policy {name}: inputs is {shown(entry.inputs)}, valid is {', '.join(INPUTS)}"
        if (entry.demonstrations is not None) != learns(entry.policy):
            yield f"policy {name} learned from {shown(entry.demonstrations)}, valid is what it can"


def _taught(plan: Plan) -> Iterator[str]:
    """What is wrong with the demonstrations: others must be able to record them again."""
    wanted = {e.demonstrations for e in plan.protocol.entries if e.demonstrations is not None}
    if set(plan.demonstrated) != wanted or not set(plan.own) <= wanted:
        yield "demonstrations that no row learned from, or none for a row; valid is as in a run"
    for name, postures in plan.demonstrated.items():
        stem = name.partition(":")[0]
        if name in plan.own:
            checksum = isinstance(plan.own[name], str) and _CHECKSUM.fullmatch(plan.own[name])
            if not PLAIN.fullmatch(name) or not checksum or plan.protocol.demonstration_sets > 1:
                yield f"own demonstrations {shown(name)}, valid is a plain name and its checksum"
        elif stem not in suite_names() or postures != tuple(load_suite(name)):
            valid = ", ".join(one for one in suite_names() if one not in TEST_SUITES)
            yield f"demonstrations {shown(name)}, valid is one of {valid}, or a file of your own"
        seen = [one.name for one in postures if replace(one, name="") in _test_postures()]
        if seen:
            yield f"{shown(seen[0])} was demonstrated, valid is a posture that is no test's"


@cache
def _test_postures() -> frozenset[Posture]:
    return frozenset(replace(one, name="") for name in TEST_SUITES for one in load_suite(name))


def _episodes(run: RunFolder) -> Iterator[str]:
    plan = run.plan
    n = len(plan.protocol.entries) * len(plan.tested)
    if run.finished != frozenset(range(n)):
        yield f"{len(run.finished)} of {n} episodes, valid is all; go on with --resume"
    results = read_results(find_study("success"), run)
    for job, result in zip(plan.jobs, results, strict=True):
        made = result.posture, result.demonstration_set, result.seed, dict(result.variation)
        if made != (job.posture, job.demonstration_set, job.seed, {}):
            yield f"episode {job.index} is none of this run's, valid is its posture, set and seed"


def others_policies(plan: Plan) -> list[str]:
    """Names of the policies that are not of this package."""
    return [entry.policy for entry in plan.protocol.entries if not is_ours(entry.policy)]
