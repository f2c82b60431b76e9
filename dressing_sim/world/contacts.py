"""Who presses whom: the contacts of one physics step, summed up for each link of the mannequin."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.world.kernels import cloth_on_links, sensed
from dressing_sim.world.mannequin import LINKS

#: The first arguments of `cloth_on_links` and of `sensed`.
_Contacts = tuple[Any, Any, Any, Any, Any, Any, Any, Any]


@dataclass(frozen=True, slots=True)
class Touch:
    """A link of the robot that touches a link of the mannequin.

    Attributes:
        robot_link: Index of the robot's link in `ContactReader.robot_links`.
        link: Index of the mannequin's link in `LINKS`.
        force: Normal force, the sum over the pair's contacts [N]; zero of a touch without force.
    """

    robot_link: int
    link: int
    force: float


@dataclass(frozen=True, slots=True)
class ClothForces:
    """How the cloth presses on the mannequin, in the robot's base frame.

    Attributes:
        net: Net force on each link of `LINKS`, shape (n_links, 3) [N].
        normal: Sum of the normal forces on each link, shape (n_links,) [N]. A sleeve that
            squeezes an arm from all sides has none net, but much of this.
        depth: How deep the cloth is in the mannequin where it is deepest, zero if it is not [m].
        others: Number of the step's contacts without cloth, the robot's; None if not known.
    """

    net: NDArray[np.float64]
    normal: NDArray[np.float64]
    depth: float = 0.0
    others: int | None = None


class ContactReader:
    """Reads MuJoCo's contacts in one pass of array operations.

    With elliptic cones a contact's forces are rows of ``efc_force`` from ``efc_address`` on: the
    normal, then the tangents, along the rows of ``frame``, acting on the second of the two
    participants (the manual of MuJoCo 4.0, "Computation", contact).

    Args:
        model: The world; the mannequin's links are bodies of the names in `LINKS`, and whatever
            else has geoms is the robot.

    Attributes:
        robot_links: Names of the bodies that can touch the mannequin.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        bodies = [model.body(body).name for body in model.geom_bodyid]
        self.robot_links = tuple(dict.fromkeys(name for name in bodies if name not in LINKS))
        # By geom. MuJoCo says -1 for a participant that is no geom, so the last entry is for it.
        none = [-1]
        self._link = np.array([_index(LINKS, name) for name in bodies] + none)
        self._robot = np.array([_index(self.robot_links, name) for name in bodies] + none)
        collides = (model.geom_contype | model.geom_conaffinity) > 0
        self._robot_geoms = np.flatnonzero(collides & (self._robot[:-1] >= 0)).tolist()
        self._mannequin_geoms = np.flatnonzero(collides & (self._link[:-1] >= 0)).tolist()

    def cloth(self, data: mujoco.MjData) -> ClothForces:
        """Forces of the cloth on the mannequin in the current step."""
        net, normal = np.empty((len(LINKS), 3)), np.empty(len(LINKS))
        depth, others = cloth_on_links(*self._contacts(data), net, normal)
        return ClothForces(net, normal, depth, others)

    def sensed(
        self,
        data: mujoco.MjData,
        grip: tuple[int, int],
        share: float,
        load: NDArray[np.float64],
        cloth: ClothForces,
    ) -> tuple[NDArray[np.float64], ClothForces]:
        """What force sensors in gripper and links read after a step.

        Args:
            data: The current step.
            grip: First row of the grip's constraints, and the one behind their last.
            share: How much of a change a sensor sees in a step, 0 to 1.
            load: What the gripper's read before, (3,) [N].
            cloth: What the links' read before.
        """
        read: Any = sensed(*self._contacts(data), grip, share, load, cloth.net, cloth.normal)
        return read[0], ClothForces(*read[1:])

    def _contacts(self, data: mujoco.MjData) -> _Contacts:
        of, force = data.contact, data.efc_force
        return of.flex, of.geom, of.dist, of.dim, of.efc_address, of.frame, force, self._link

    def robot(self, data: mujoco.MjData) -> NDArray[np.float64]:
        """Net force of the robot on each link, shape (n_links, 3) [N], in the current step."""
        link, force, _ = self._forces(data, self._robot_contacts(data))
        return (link == np.arange(len(LINKS))[:, None]) @ force

    def touches(self, data: mujoco.MjData) -> tuple[Touch, ...]:
        """Pairs of the robot's and the mannequin's links that touch in the current step."""
        chosen = self._robot_contacts(data)
        if not len(chosen):
            return ()
        link, _, normal = self._forces(data, chosen)
        robot = self._robot[data.contact.geom[chosen]].max(axis=1)
        pairs: dict[tuple[int, int], float] = {}
        for one, other, newtons in zip(robot, link, normal, strict=True):
            if one >= 0 and other >= 0:
                pair = int(one), int(other)
                pairs[pair] = pairs.get(pair, 0.0) + float(newtons)
        return tuple(Touch(*pair, newtons) for pair, newtons in pairs.items())

    def robot_distance(self, model: mujoco.MjModel, data: mujoco.MjData) -> float:
        """Smallest distance between robot and mannequin [m], negative where they overlap.

        Where they are farther than a metre apart, one metre.
        """
        nearest = 1.0
        for one, other in product(self._robot_geoms, self._mannequin_geoms):
            nearest = min(nearest, mujoco.mj_geomDistance(model, data, one, other, nearest, None))
        return nearest

    @staticmethod
    def _robot_contacts(data: mujoco.MjData) -> NDArray[np.intp]:
        # Cloth and robot touch the mannequin only, so a contact without cloth is the robot's.
        return np.flatnonzero((data.contact.flex < 0).all(axis=1))

    def _forces(
        self, data: mujoco.MjData, chosen: NDArray[np.intp]
    ) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]:
        """Link (n,), force on it (n, 3) and its normal part (n,) of the chosen contacts."""
        contacts = data.contact
        links = self._link[contacts.geom[chosen]]
        address, dim = contacts.efc_address[chosen, None], contacts.dim[chosen, None]
        row = np.arange(3)
        # A contact that the solver leaves out has the address -1.
        exerted = (row < dim) & (address >= 0)
        parts = np.zeros((len(chosen), 3))
        parts[exerted] = data.efc_force[(address + row)[exerted]]
        force = np.einsum("ni,nij->nj", parts, contacts.frame[chosen].reshape(-1, 3, 3))
        sign = np.where(links[:, 1] >= 0, 1.0, -1.0)
        return links.max(axis=1), sign[:, None] * force, parts[:, 0]


def _index(names: tuple[str, ...], name: str) -> int:
    return names.index(name) if name in names else -1
