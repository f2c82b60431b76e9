"""The suites of postures: draw them again, draw their picture, measure how distinct two are.

For example: python scripts/draw_suites.py files

Or: python scripts/draw_suites.py figure

Or: python scripts/draw_suites.py distances case_a case_b
"""

import sys
from pathlib import Path

import tyro
from suite_pictures import distance_table, draw_postures

from dressing_sim.errors import InvalidInputError
from dressing_sim.files import assets
from dressing_sim.suites.drawn import DRAWN_SUITES
from dressing_sim.suites.suites import load_suite, write_suite

SUITES = assets() / "suites"


def files(out: Path = SUITES) -> None:
    """Write the files of all drawn suites; they come out as they are in `assets/suites/`."""
    for name, suite in DRAWN_SUITES.items():
        write_suite(out / f"{name}.json", name, suite.postures(), suite.header())
        print(out / f"{name}.json")


def figure(out: Path = Path("docs/postures.svg")) -> None:
    """Draw the angles of `test200`, `val50` and `paper5`, and their arms from three sides."""
    draw_postures({name: load_suite(name) for name in ("test200", "val50", "paper5")}, out)
    print(out)


def distances(suites: tyro.conf.Positional[tuple[str, ...]] = ("case_a", "case_b")) -> None:
    """Print how far apart the frames of the first two postures of each suite are."""
    print(distance_table({name: load_suite(name) for name in suites}))


def main() -> int:
    """Run a command; errors of the user's are one line and exit code 2."""
    commands = {function.__name__: function for function in (files, figure, distances)}
    try:
        tyro.extras.subcommand_cli_from_dict(commands, description=__doc__)
    except InvalidInputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
