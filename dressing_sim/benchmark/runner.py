"""Runs a protocol: demonstrations, training, episodes, on as many processes as wanted."""

from __future__ import annotations

import hashlib
import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass

from dressing_sim.arm import Posture
from dressing_sim.benchmark.policies import EXPERT, make_policy
from dressing_sim.benchmark.protocol import Entry, Protocol
from dressing_sim.benchmark.suites import load_suite
from dressing_sim.demonstration import Demonstration
from dressing_sim.episode import EpisodeConfig, demonstrate, record
from dressing_sim.errors import DressingSimError
from dressing_sim.judge import Outcome
from dressing_sim.learning import Policy
from dressing_sim.operator import Operator

#: Told about progress: the stage, how much of it is done, and the outcomes of its episodes so far.
Progress = Callable[[str, int, int, "Sequence[EpisodeResult]"], None]


@dataclass(frozen=True, slots=True)
class EpisodeResult:
    """One line of ``episodes.jsonl``.

    Attributes:
        entry: Row of the protocol.
        posture: The arm that was dressed.
        seed: Seed of the episode.
        outcome: The verdict.
    """

    entry: Entry
    posture: Posture
    seed: int
    outcome: Outcome


@contextmanager
def process_pool(workers: int) -> Iterator[Executor]:
    """Fresh processes; on an error or Ctrl-C, what has not begun is dropped."""
    # Spawned rather than forked: OpenGL, BLAS and MuJoCo hold threads that a fork would break.
    executor = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    try:
        yield executor
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        raise
    executor.shutdown()


def run_protocol(
    protocol: Protocol,
    executor: Executor,
    seed: int = 0,
    config: EpisodeConfig | None = None,
    progress: Progress | None = None,
) -> list[EpisodeResult]:
    """Measure a protocol.

    Args:
        protocol: What to measure.
        executor: Where episodes run; results do not depend on how many workers it has.
        seed: Of the operator's variability, in demonstrations and where the expert is tested.
        config: World, robot and rules.
        progress: Told after each demonstration and episode.

    Returns:
        One result an episode: all test postures of the first entry, then of the next.

    Raises:
        InvalidInputError: An unknown suite or policy, or a policy whose path is not valid.
        DressingSimError: A demonstration failed, so nothing can be learned from it.
    """
    config = config or EpisodeConfig()
    report = progress or (lambda stage, done, total, results: None)
    postures = load_suite(protocol.suite)
    shown = dict.fromkeys(e.demonstrations for e in protocol.entries if e.demonstrations)
    suites = {name: load_suite(name) for name in shown}
    for entry in protocol.entries:
        if entry.policy != EXPERT:
            make_policy(entry.policy)  # an unknown name is reported before anything runs
    recorded = _demonstrate(suites, executor, seed, config, report)

    jobs: dict[Future[Outcome], tuple[Entry, Posture, int]] = {}
    for entry in protocol.entries:
        policy = _trained(entry, recorded)
        for posture in postures:
            own_seed = posture_seed(seed, posture)
            future = executor.submit(_episode, policy, posture, own_seed, config)
            jobs[future] = entry, posture, own_seed
    finished: list[EpisodeResult] = []
    report("episodes", 0, len(jobs), finished)
    for future in as_completed(jobs):
        finished.append(EpisodeResult(*jobs[future], future.result()))
        report("episodes", len(finished), len(jobs), finished)
    return [EpisodeResult(*place, future.result()) for future, place in jobs.items()]


def _trained(entry: Entry, recorded: dict[str, list[Demonstration]]) -> Policy | Operator:
    if entry.demonstrations is None:
        return Operator()
    return make_policy(entry.policy).fit(recorded[entry.demonstrations])


def _episode(
    source: Policy | Operator, posture: Posture, seed: int, config: EpisodeConfig
) -> Outcome:
    return record(source, posture, seed, config).outcome


def _demonstrate(
    suites: dict[str, list[Posture]],
    executor: Executor,
    seed: int,
    config: EpisodeConfig,
    report: Progress,
) -> dict[str, list[Demonstration]]:
    """Demonstrations of every suite; a posture that is in two suites is demonstrated once."""
    postures = list(dict.fromkeys(posture for suite in suites.values() for posture in suite))
    futures = {
        # Each demonstration varies in its own way, whatever the order and the other suites.
        posture: executor.submit(demonstrate, posture, posture_seed(seed, posture), None, config)
        for posture in postures
    }
    if futures:
        report("demonstrations", 0, len(futures), ())
    for done, _ in enumerate(as_completed(futures.values()), start=1):
        report("demonstrations", done, len(futures), ())
    recorded = {}
    for posture, future in futures.items():
        demonstration, outcome = future.result()
        if demonstration is None or not outcome.success:
            why = outcome.void or ", ".join(f.detail for f in outcome.failures)
            raise DressingSimError(
                f"the demonstration on posture {posture.name!r} with seed {seed} failed: {why}; "
                "choose another seed or posture"
            )
        recorded[posture] = demonstration
    return {name: [recorded[posture] for posture in suite] for name, suite in suites.items()}


def posture_seed(seed: int, posture: Posture) -> int:
    """Seed of the operator on a posture, so that no two postures get the same variability.

    It depends on both arguments and on nothing else: not on the order, nor on the other postures.
    """
    digest = hashlib.sha256(f"{seed} {posture.name}".encode()).digest()
    return int.from_bytes(digest[:4], "big")
