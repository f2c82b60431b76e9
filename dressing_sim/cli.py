"""The command line: ``dressing-sim COMMAND``; every command has ``--help`` with an example."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any

import tyro

from dressing_sim.errors import DressingSimError
from dressing_sim.numerics import common_environment


def _commands() -> dict[str, Any]:
    from dressing_sim.commands.demonstrate import demonstrate
    from dressing_sim.commands.doctor import doctor
    from dressing_sim.commands.dress import dress
    from dressing_sim.commands.evaluate import evaluate
    from dressing_sim.commands.learn import learn
    from dressing_sim.commands.planar import planar
    from dressing_sim.commands.replay import replay
    from dressing_sim.commands.thresholds import thresholds
    from dressing_sim.commands.validate import validate

    return {
        "evaluate": evaluate,
        "replay": replay,
        "demonstrate": demonstrate,
        "learn": learn,
        "dress": dress,
        "validate": validate,
        "thresholds": thresholds,
        "planar": planar,
        "doctor": doctor,
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command; an error that a user can mend is one line on standard error, exit code 2."""
    # Before numpy is loaded: numbers should not hang on the kind of processor.
    os.environ.update(common_environment())
    try:
        tyro.extras.subcommand_cli_from_dict(
            _commands(),
            prog="dressing-sim",
            description="A simulated dressing-robot benchmark.",
            args=arguments,
        )
    except DressingSimError as error:
        print(f"dressing-sim: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    except BrokenPipeError:
        # Whoever read our output has had enough; do not complain at exit either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(141) from None
    except KeyboardInterrupt:
        print("dressing-sim: interrupted", file=sys.stderr)
        raise SystemExit(130) from None
