"""Two recordings of what should be one episode."""

from dataclasses import fields

import numpy as np

from dressing_sim.episode.trace import Trace


def same(one, other):
    """Every bit of the trace, and the verdict."""
    for field in fields(Trace):
        ours, theirs = getattr(one.trace, field.name), getattr(other.trace, field.name)
        np.testing.assert_array_equal(ours, theirs, err_msg=field.name)
    assert one.outcome == other.outcome
