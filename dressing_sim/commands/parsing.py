"""A command line that cannot be read is told in one line: what was got, and what is valid."""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from functools import wraps
from typing import Any, TextIO

from dressing_sim.errors import InvalidInputError

#: What the parser calls the types of values.
_KINDS = {"INT": "a whole number", "FLOAT": "a number", "PATH": "a path", "STR": "a text"}

#: The frame that the parser draws round its errors, with or without a terminal's line letters.
_FRAME = "│╭╮╰╯─|+ \t"
_RULE = re.compile(r"[│╭╮╰╯─|+\s-]*")


class _Kept(io.StringIO):
    """What the parser prints on standard error while it reads the command line."""

    def __init__(self, real: TextIO) -> None:
        super().__init__()
        self.real = real
        self.parsing = True

    def once_parsed(self, command: Callable[..., None]) -> Callable[..., None]:
        """The command, which begins when the command line has been read."""

        @wraps(command)
        def begun(*args: Any, **kwargs: Any) -> None:
            self.parsing = False
            sys.stderr = self.real
            command(*args, **kwargs)

        return begun


@contextmanager
def errors_in_one_line(arguments: Sequence[str], commands: Sequence[str]) -> Iterator[_Kept]:
    """Within the block the parser's error becomes one of ours.

    Args:
        arguments: The command line.
        commands: Names of the commands.

    Raises:
        InvalidInputError: The parser gave up.
    """
    kept = _Kept(sys.stderr)
    sys.stderr = kept
    try:
        yield kept
    except SystemExit as end:
        if not kept.parsing or end.code != 2:
            raise
        raise InvalidInputError(_line(kept.getvalue(), arguments, commands)) from None
    finally:
        sys.stderr = kept.real


def _line(printed: str, arguments: Sequence[str], commands: Sequence[str]) -> str:
    """The parser's error as one line, with what is valid or where to read on."""
    if not arguments or arguments[0] not in commands:
        got = f"unknown command {arguments[0]!r:.60}" if arguments else "no command"
        near = get_close_matches(arguments[0], commands, 1) if arguments else []
        meant = f"did you mean {near[0]!r}? " if near else ""
        return f"{got}; {meant}valid is one of {', '.join(commands)}"
    name = arguments[0]
    lines = [line for line in printed.splitlines()[1:] if not _RULE.fullmatch(line)]
    text = " ".join(" ".join(line.strip(_FRAME) for line in lines).split())
    more = f"see dressing-sim {name} --help"
    if unknown := re.match(r"Unrecognized options: (.+?)(?: Perhaps you| For full|$)", text):
        return f"{name}: unknown {unknown[1]:.120}; {more}"
    if wrong := re.match(r"Error parsing (\S+): (.+?) Argument helptext: .*?\b([A-Z]{3,})", text):
        value = re.search(r"'.*'", wrong[2])
        valid = _KINDS.get(wrong[3], wrong[3])
        told = f"{name}: {wrong[1]} is {value[0] if value else wrong[2]:.80}, valid is {valid}"
        return f"{told}; {more}"
    told = re.split(r" For full helptext", text)[0]
    told = re.sub(r"Missing from dressing-sim \S+:", "missing", told)
    return f"{name}: {told:.200}; {more}"
