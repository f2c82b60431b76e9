"""``dressing-sim submit``: a finished run as one file for the scoreboard."""

from __future__ import annotations

from pathlib import Path

import tyro


def submit(
    folder: tyro.conf.Positional[Path],
    name: str,
    date: str,
    out: Path,
    link: str = "",
    package: str = "",
    practised: bool = False,
    accept_changes: bool = False,
    force: bool = False,
) -> None:
    """Make of a finished run one file that others can verify, for the scoreboard.

    The file holds the run's config, its rows, every episode's line, checksums, and your own
    demonstrations if it has some; built-in ones are recorded again from their seeds. Refused are
    runs that cannot be compared: unfinished ones, other suites than paper5, test200 and hard_elbow,
    another seed than 0, and runs with --variation, --garment, --person, --robot, or other limits of
    time and memory.

    For example: dressing-sim submit results/mine --name Ada --date 2027-01-31 --out ada.json

    Or: dressing-sim submit results/mine --name Ada --date 2027-01-31 --package mypackage==1.2
    --out mine.json

    Args:
        folder: what dressing-sim evaluate left.
        name: who submits it.
        date: the day that stands beside it, YYYY-MM-DD.
        out: file to write.
        link: to a person, a paper or a repository: https://...
        package: what pip installs to get the policies, if they are not of this package.
        practised: a policy's parameters were found by trying it in the simulator.
        accept_changes: episodes were made with more than one version of the code, and the
            scoreboard may say so.
        force: replace a file that is there.
    """
    from dressing_sim.benchmark.run.folder import CONFIG, EPISODES
    from dressing_sim.benchmark.scoreboard.rules import Statement
    from dressing_sim.benchmark.scoreboard.submission import submit as submission
    from dressing_sim.files import check_output, write_file

    check_output(out, force, [folder / CONFIG, folder / EPISODES])
    said = Statement(name, date, link, package, practised, accept_changes)
    text = submission(folder, said)
    write_file(out, text)
    print(f"written to {out}; to see whether others can verify it: dressing-sim verify {out}")
