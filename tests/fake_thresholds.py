"""Made-up episodes of the study of thresholds, with their verdicts under every variant."""

from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.benchmark.run.runner import job_result
from dressing_sim.benchmark.studies.thresholds_verdicts import FACTORS, NAMES, VERDICTS
from dressing_sim.episode.outcome import Outcome


def turning(at, lead):
    """The second row overtakes the first where strain is multiplied by `at` or more."""
    return lambda row, name, factor: (
        20 + (lead if row == (name == "strain" and factor >= at) else 0)
    )


def verdicts_of(successes, row, column):
    """Row r succeeds in so many episodes: `successes(r, threshold, factor)`."""
    return {
        name: {f"{factor:g}": column < successes(row, name, factor) for factor in FACTORS}
        for name in NAMES
    }


def episodes(successes, protocol, postures, void=()):
    """All episodes of a protocol; those of the (row, column) in `void` are invalid."""
    results = []
    for row, entry in enumerate(protocol.entries):
        for column, posture in enumerate(postures):
            found = verdicts_of(successes, row, column)
            outcome, extra = Outcome(found["strain"]["1"]), {VERDICTS: found}
            if (row, column) in void:
                outcome, extra = Outcome(False, invalid="not finite"), {}
            index = len(results)
            results.append(EpisodeResult(index, entry, posture, 0, index, {}, outcome, extra))
    return results


def fake_judge(n_postures, source, job, config):
    """A job's episode in a protocol on so many postures."""
    row, column = divmod(job.index, n_postures)
    found = verdicts_of(turning(1.1, 15), row, column)
    return job_result(job, job.posture, {}, Outcome(found["strain"]["1"]), {VERDICTS: found})
