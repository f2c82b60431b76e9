"""Robot, mannequin and sleeve in MuJoCo, whose warnings go to Python's log and to no file."""

from dressing_sim.world.warnings import keep_no_file

keep_no_file()
