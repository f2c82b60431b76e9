"""``dressing-sim learn``: a policy from demonstrations, in a file."""

from __future__ import annotations

import json as json_format
from pathlib import Path

import tyro

from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_output


def learn(
    demonstrations: tyro.conf.Positional[Path],
    policy: str = "default",
    out: Path = Path("policy.npz"),
    force: bool = False,
    json: bool = False,
) -> None:
    """Learn a policy from recorded demonstrations and save it.

    For example: dressing-sim learn case_a.h5 --out case_a.npz

    Or: dressing-sim learn case_a.h5 --policy "tp-gmm-rf?max_iterations=50"

    Args:
        demonstrations: file that ``dressing-sim demonstrate`` wrote.
        policy: name of the policy, with ?name=value&... for its hyper-parameters.
        out: file to write.
        force: replace a file that is there already.
        json: print what was learned as JSON.
    """
    from dressing_sim.episode.demonstration import load_demonstrations
    from dressing_sim.inputs import fit
    from dressing_sim.learning.storage import Storable
    from dressing_sim.policies.files import save_policy
    from dressing_sim.policies.hosted import hosted_policy, is_ours
    from dressing_sim.policies.registry import make_policy

    fresh = make_policy(policy) if is_ours(policy) else hosted_policy(policy)
    if not isinstance(fresh, Storable):
        raise InvalidInputError(
            f"policy {policy!r} cannot be saved; valid is a policy of this package that learns"
        )
    recorded = load_demonstrations(demonstrations)
    check_output(out, force, [demonstrations])
    fit(fresh, recorded)
    check_output(out, force, [demonstrations])  # it took long
    save_policy(fresh, out)
    if json:
        print(
            json_format.dumps(
                {"policy": policy, "n_demonstrations": len(recorded), "file": str(out)}
            )
        )
    else:
        print(f"{policy} learned from {len(recorded)} demonstrations, written to {out}")
