"""Imported before numpy, as the command line does it: golden numbers hold on many processors."""

import os

from dressing_sim.numerics import common_environment

os.environ.update(common_environment())
