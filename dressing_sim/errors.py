"""Errors that a person can act on: one line that names the thing and what is valid."""


class DressingSimError(Exception):
    """Base of all errors raised on purpose; the command line prints it and exits with code 2."""


class InvalidInputError(DressingSimError, ValueError):
    """A value, name or file that came from outside is not valid; the message says what is."""


class PolicyError(InvalidInputError):
    """A policy gave no answer, or none that can be used; the message says which and why."""


class Abstained(PolicyError):
    """A policy chose to make no path, as it would probably fail; the message says why."""


def one_line(text: str, most: int = 300) -> str:
    """A text without line ends and control characters, cut where it is too long."""
    plain = "".join(c if c.isprintable() else " " for c in text)
    plain = " ".join(plain.split())
    return plain if len(plain) <= most else f"{plain[: most - 3]}..."
