"""The same run by a cluster and by this machine alone: the same bytes.

python examples/09_on_a_cluster.py [--suite random:2] [--policies expert]

Here scheduler and workers are on this machine; `dask_jobqueue.SLURMCluster` or `PBSCluster` in the
place of `LocalCluster` asks for nodes of a cluster. Needs the extra ``dask``.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from distributed import LocalCluster

from dressing_sim.numerics import common_environment


def evaluate(out: Path, *more: str) -> bytes:
    """The episodes of a run."""
    command = [sys.executable, "-m", "dressing_sim", "evaluate", "--no-pictures"]
    subprocess.run([*command, "--out", out, *more], check=True, stdout=subprocess.DEVNULL)
    return (out / "episodes.jsonl").read_bytes()


def main() -> None:
    """Run twice and compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--suite", default="random:2")
    parser.add_argument("--policies", default="expert")
    args = parser.parse_args()
    asked = ["--suite", args.suite, "--policies", args.policies]
    os.environ.update(common_environment())  # the workers' numpy begins with it
    with TemporaryDirectory() as folder:
        cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
        with cluster:
            address = cluster.scheduler_address
            there = evaluate(Path(folder) / "cluster", *asked, "--scheduler", address)
        here = evaluate(Path(folder) / "alone", *asked, "--workers", "1")
    # Lines are in the order in which episodes ended.
    same = sorted(there.splitlines()) == sorted(here.splitlines())
    print(f"{len(here.splitlines())} episodes, {'the same bytes' if same else 'other bytes'}")


if __name__ == "__main__":
    main()
