"""``dressing-sim scoreboard``: a page of submitted results."""

from __future__ import annotations

from pathlib import Path

import tyro


def scoreboard(folder: tyro.conf.Positional[Path], out: Path, force: bool = False) -> None:
    """Make a page of submitted results: a table for each test suite and class of inputs.

    Every file is checked against the rules, and its rows are counted again from its episodes;
    whether these come out again is for dressing-sim verify to say.

    For example: dressing-sim scoreboard docs/scoreboard --out docs/scoreboard/table.md --force

    Args:
        folder: its files *.json are what dressing-sim submit wrote.
        out: page to write, .md or .html; its links lead to the files.
        force: replace a file that is there.
    """
    from dressing_sim.benchmark.scoreboard.page import scoreboard_page
    from dressing_sim.commands.studies import typed
    from dressing_sim.errors import InvalidInputError
    from dressing_sim.files import check_output, write_file

    if not folder.is_dir():
        raise InvalidInputError(f"{folder}: no folder; valid is one of submitted results")
    files = sorted(folder.glob("*.json"))
    check_output(out, force, files)
    write_file(out, scoreboard_page(files, out, typed()))
    print(f"written to {out}: {len(files)} submitted results")
