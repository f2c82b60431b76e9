"""Minari: a folder that `minari.load_dataset` reads, written and read by `minari` itself."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dressing_sim.archives import check_folder_size, read_by_others
from dressing_sim.checks import shown
from dressing_sim.datasets.columns import (
    Written,
    actions,
    demonstration_from,
    description,
    observations,
)
from dressing_sim.datasets.prepare import ImportConfig
from dressing_sim.datasets.robomimic_files import DESCRIPTION
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.errors import InvalidInputError
from dressing_sim.extras import needed
from dressing_sim.files import new_folder

#: Within its folder, where a data set's files are.
DATA = "data"

#: Minari's names have a version.
_NAME = re.compile(r"[A-Za-z0-9_-]+-v\d{1,6}", re.ASCII)


def write_minari(path: str | Path, demonstrations: Sequence[Demonstration], told: Written) -> None:
    """Write demonstrations as a data set of Minari's called ``dressing-sim/NAME``, all or nothing.

    With T rows an episode has T observations and T - 1 actions. It ends with reward 1.

    Args:
        path: The folder, of a name such as ``case-a-v0``; within
            ``$MINARI_DATASETS_PATH/dressing-sim`` Minari finds it by its name.
        demonstrations: All with the same observations.
        told: About progress.

    Raises:
        InvalidInputError: The name has no version, the folder is there, demonstrations differ in
            what they have, or Minari is not installed.
    """
    minari, spaces = needed("minari", "minari"), needed("gymnasium.spaces", "minari")
    storage_module = needed("minari.dataset.minari_storage", "minari")
    buffers = needed("minari.data_collector.episode_buffer", "minari")
    name = Path(path).name
    if not _NAME.fullmatch(name):
        raise InvalidInputError(f"{path}: valid is a folder's name of letters that ends with -v0")
    same_observations(demonstrations)
    box = {
        key: spaces.Box(-np.inf, np.inf, array.shape[1:], np.float64)
        for key, array in observations(demonstrations[0]).items()
    }
    with new_folder(path) as made:
        (made / DATA).mkdir(parents=True)
        storage = storage_module.MinariStorage.new(
            made / DATA, spaces.Dict(box), spaces.Box(-np.inf, np.inf, (3,), np.float64)
        )
        for number, one in enumerate(demonstrations):
            last = np.arange(len(one.positions) - 1) == len(one.positions) - 2
            episode = buffers.EpisodeBuffer(
                id=number,
                observations=observations(one),
                actions=actions(one)[:-1],
                rewards=last.astype(np.float64),
                terminations=last,
                truncations=np.zeros_like(last),
                infos={},
            )
            storage.update_episodes([episode])
            storage.update_episode_metadata([{DESCRIPTION: description(one)}], [number])
            told(number + 1, len(demonstrations))
        about = {
            "dataset_id": f"dressing-sim/{name}",
            "minari_version": minari.__version__,
            "algorithm_name": "demonstrations",
            "description": "Demonstrations of dressing one arm; actions are targets in metres.",
        }
        storage.update_metadata(about)


def same_observations(demonstrations: Sequence[Demonstration]) -> None:
    """Raise InvalidInputError unless there are demonstrations, all with the same observations."""
    if not demonstrations:
        raise InvalidInputError("no demonstrations; valid is one or more")
    for number, one in enumerate(demonstrations):
        if {*one.optional} != {*demonstrations[0].optional}:
            raise InvalidInputError(
                f"demonstration {number} has {shown([*one.optional])} where the first has "
                f"{shown([*demonstrations[0].optional])}; valid are demonstrations of one kind"
            )


def read_minari(path: str | Path, config: ImportConfig) -> list[Demonstration]:
    """The demonstrations in a data set of Minari's with our observations.

    Raises:
        InvalidInputError: It cannot be read, is damaged, or has other observations, or Minari is
            not installed.
    """
    module = needed("minari.dataset.minari_dataset", "minari")
    path = Path(path)
    check_folder_size(path)
    with read_by_others(path, "data set of Minari's"):
        data = module.MinariDataset(path / DATA)
        texts = [
            metadata.get(DESCRIPTION)
            for metadata in data.storage.get_episode_metadata(data.episode_indices)
        ]
        return [
            demonstration_from(episode.observations, text, f"episode_{episode.id}", config)
            for episode, text in zip(data, texts, strict=True)
        ]
