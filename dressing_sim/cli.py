"""The command line: ``dressing-sim COMMAND``; every command has ``--help`` with an example."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Sequence
from typing import Any

from dressing_sim.errors import DressingSimError, one_line
from dressing_sim.interrupts import EXIT_CODE, answered_at_once, say_interrupted

#: Of an error; names of all that is valid may make it long [letters].
_LONGEST = 4000


#: What an error of writing to a full or broken disk is, of which no file's name is known.
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


def _commands() -> dict[str, Any]:
    from dressing_sim.commands.confidence import confidence
    from dressing_sim.commands.demonstrate import demonstrate
    from dressing_sim.commands.doctor import doctor
    from dressing_sim.commands.dress import dress
    from dressing_sim.commands.evaluate import evaluate
    from dressing_sim.commands.export import export
    from dressing_sim.commands.import_ import import_
    from dressing_sim.commands.learn import learn
    from dressing_sim.commands.planar import planar
    from dressing_sim.commands.practise import practise
    from dressing_sim.commands.replay import replay
    from dressing_sim.commands.scoreboard import scoreboard
    from dressing_sim.commands.submit import submit
    from dressing_sim.commands.thresholds import thresholds
    from dressing_sim.commands.tune import tune
    from dressing_sim.commands.validate import validate
    from dressing_sim.commands.verify import verify
    from dressing_sim.commands.view import view

    return {
        "evaluate": evaluate,
        "replay": replay,
        "submit": submit,
        "verify": verify,
        "scoreboard": scoreboard,
        "demonstrate": demonstrate,
        "export": export,
        "import": import_,
        "learn": learn,
        "dress": dress,
        "validate": validate,
        "thresholds": thresholds,
        "tune": tune,
        "practise": practise,
        "confidence": confidence,
        "planar": planar,
        "view": view,
        "doctor": doctor,
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command; an error that a user can mend is one line on standard error, exit code 2."""
    with answered_at_once() as interrupts:
        try:
            _run(sys.argv[1:] if arguments is None else arguments)
        except DressingSimError as error:
            print(f"dressing-sim: {one_line(str(error), _LONGEST)}", file=sys.stderr)
            raise SystemExit(2) from None
        except BrokenPipeError:
            # Whoever read our output has had enough; do not complain at exit either.
            _silence()
            raise SystemExit(141) from None
        except OSError as error:
            # Results are written by functions that name their file: this is what is left.
            where = f"{error.filename}: " if error.filename else ""
            if not where and error.errno in _FULL:
                where = "standard output: cannot be written, "
                _silence()
            told = one_line(f"{where}{error.strerror or error}", _LONGEST)
            print(f"dressing-sim: {told}", file=sys.stderr)
            raise SystemExit(2) from None
        except KeyboardInterrupt:
            say_interrupted()
            raise SystemExit(EXIT_CODE) from None
        except Exception:
            # What is compiled may make an error of its own of Ctrl-C.
            if not interrupts.heard.is_set():
                raise
            say_interrupted()
            raise SystemExit(EXIT_CODE) from None


def _run(given: Sequence[str]) -> None:
    """Read the command line and run the command; what that imports is imported in here."""
    from dressing_sim.numerics import common_environment

    # Before numpy is loaded: numbers should not hang on the kind of processor.
    os.environ.update(common_environment())
    import tyro

    from dressing_sim.commands.parsing import errors_in_one_line

    commands = _commands()
    with errors_in_one_line(given, list(commands)) as errors:
        tyro.extras.subcommand_cli_from_dict(
            {name: errors.once_parsed(command) for name, command in commands.items()},
            prog="dressing-sim",
            description="A simulated dressing-robot benchmark.",
            args=given,
        )
    sys.stdout.flush()


def _silence() -> None:
    """Send what is still to be printed nowhere: it would be an error again at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
