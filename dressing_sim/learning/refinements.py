"""Two refinements of Algorithm 1 that its authors leave to future work (their section VII).

* *A mixture that grows*: "as the training data set is augmented, simultaneously increasing the
  number of Gaussians". Whenever a demonstration is kept, one component more is tried.
* *Use of what was discarded*: "instead of discarding the trajectories, efforts could be made to
  exploit them". In the end they are learned from too, each by how little it harmed, as in
  reward-weighted regression (Peters and Schaal 2007, doi:10.1145/1273496.1273590).

Both keep what they change only where the cost on the expert demonstrations does not rise: the rule
of Algorithm 1 itself.
"""

from collections.abc import Sequence
from typing import Protocol, Self, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.demonstrations import DemonstrationLike
from dressing_sim.learning.frame import FloatArray


@runtime_checkable
class Refinable(Protocol):
    """A policy whose mixture may grow, and which can learn from weighted demonstrations."""

    def larger(self, demonstrations: Sequence[DemonstrationLike]) -> Self | None:
        """The policy with one component more, None if it would describe them no better."""

    def refit(
        self,
        demonstrations: Sequence[DemonstrationLike],
        warm: bool = True,
        weights: ArrayLike | None = None,
    ) -> Self:
        """A new policy learned from other demonstrations, which may be weighted."""

    def cost(self, demonstrations: Sequence[DemonstrationLike]) -> float:
        """Reproduction cost J: how far the policy is from these demonstrations."""


P = TypeVar("P", bound=Refinable)


def grown(
    policy: P,
    cost: float,
    training: Sequence[DemonstrationLike],
    criterion: Sequence[DemonstrationLike],
) -> tuple[P, float]:
    """The policy with one component more, and its cost, where that is better by both measures.

    Better is a lower Bayesian information criterion on what is learned from, which holds the number
    of components against the amount of data, and a cost on the criterion that is not higher.

    Args:
        policy: learned from ``training``.
        cost: its cost on ``criterion``.
        training: all demonstrations, synthetic ones too.
        criterion: those that the cost is of.
    """
    try:
        bigger = policy.larger(training)
        new_cost = np.inf if bigger is None else bigger.cost(criterion)
    except InvalidInputError:
        # Too few samples for another component, or one that has become singular: it stays small.
        return policy, cost
    if bigger is None or not new_cost <= cost:
        return policy, cost
    return bigger, new_cost


def discarded_weights(costs: ArrayLike, best: float, total: float) -> FloatArray:
    """How much each discarded demonstration counts, in demonstrations.

    In proportion to exp(-(J_i - J) / T), with T the mean of J_i - J, so that neither the unit of
    the cost nor its size matters.

    Args:
        costs: J_i (N,), of the policy retrained with each; not below ``best``.
        best: J, the cost without them.
        total: what they count together.
    """
    excess = np.asarray(costs, dtype=float) - best
    mean = float(excess.mean())
    shares = np.exp(-excess / mean) if mean > 0.0 else np.ones_like(excess)
    weights: FloatArray = total * shares / shares.sum()
    return weights


def with_discarded(
    policy: P,
    cost: float,
    training: Sequence[DemonstrationLike],
    discarded: Sequence[tuple[DemonstrationLike, float]],
    share: float,
    criterion: Sequence[DemonstrationLike],
) -> tuple[P, float]:
    """The policy retrained with what was discarded as well, and its cost, where that is lower.

    Args:
        policy: learned from ``training``.
        cost: its cost on ``criterion``.
        training: the demonstrations that were kept, each of weight 1.
        discarded: the others, each with the cost of the policy that was retrained with it.
        share: what they count together, as a fraction of what was kept; above zero.
        criterion: those that the cost is of.
    """
    if not discarded:
        return policy, cost
    demonstrations, costs = zip(*discarded, strict=True)
    # Later ones were compared with a lower cost; what they harmed the final policy is not known.
    weights = discarded_weights(costs, min(cost, *costs), share * len(training))
    # A weight of nothing, by underflow, is no weight.
    kept = weights > 1e-12 * len(training)
    more = [one for one, keep in zip(demonstrations, kept, strict=True) if keep]
    try:
        retrained = policy.refit(
            (*training, *more), weights=np.concatenate([np.ones(len(training)), weights[kept]])
        )
        new_cost = retrained.cost(criterion)
    except InvalidInputError:
        # The data may not carry the model any more; then what was discarded is of no use.
        return policy, cost
    return (retrained, new_cost) if new_cost < cost else (policy, cost)
