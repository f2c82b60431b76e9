"""``python -m dressing_sim``."""

from dressing_sim.cli import main

main()
