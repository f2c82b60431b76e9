"""Seeds that depend on names: the same words, the same seed, on every machine."""

import hashlib


def derived_seed(text: str) -> int:
    """A seed from 0 to 2^32 - 1 that depends on the text and on nothing else."""
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")
