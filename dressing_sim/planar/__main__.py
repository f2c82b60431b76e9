"""``python -m dressing_sim.planar``: the planar study on the command line."""

import sys

import tyro

from dressing_sim.errors import InvalidInputError
from dressing_sim.planar.command import planar


def main() -> int:
    """Run the command; errors of the user's are one line and exit code 2."""
    try:
        tyro.cli(planar, prog="dressing-sim planar")
    except InvalidInputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
