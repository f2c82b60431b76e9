"""Types of the public names, which `__init__.py` loads on first use."""

from dressing_sim.arm import Posture as Posture
from dressing_sim.benchmark.studies.evaluate import evaluate as evaluate
from dressing_sim.by_name import demonstrate as demonstrate
from dressing_sim.by_name import dress as dress
from dressing_sim.by_name import record as record
from dressing_sim.episode.config import EpisodeConfig as EpisodeConfig
from dressing_sim.episode.demonstration import Demonstration as Demonstration
from dressing_sim.episode.demonstration import load_demonstrations as load_demonstrations
from dressing_sim.episode.demonstration import save_demonstrations as save_demonstrations
from dressing_sim.episode.dressing import Dressing as Dressing
from dressing_sim.episode.operator import Operator as Operator
from dressing_sim.episode.outcome import Outcome as Outcome
from dressing_sim.learning import Policy as Policy
from dressing_sim.path import Path as Path
from dressing_sim.suites.distribution import sample_postures as sample_postures
from dressing_sim.suites.suites import load_suite as load_suite

__version__: str
