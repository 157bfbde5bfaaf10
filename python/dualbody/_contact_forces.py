"""Kinematics of the contact points; forces of contact with the ground and between bodies, of states and of rollouts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ._value import Value

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._dualbody import Array, Simulator
    from ._rollout import Rollout


class ContactKinematics(NamedTuple):
    """All contact points in the order of ``simulator.contact_points``: positions, velocities and normals of the ground (..., n, 3), depths (..., n), m."""

    positions: Array
    velocities: Array
    normals: Array
    depths: Array


def contact_kinematics(simulator: Simulator, q: ArrayLike, v: ArrayLike) -> ContactKinematics:
    """Positions, velocities, normals and depths of the contact points: a ContactKinematics. q (..., nq), v (..., nv)."""
    return kinematics_of(simulator._contact_points(q, v))


def kinematics_of(x: Any) -> ContactKinematics:
    """The parts of what is known of points, (..., n, 10)."""
    return ContactKinematics(x[..., 0:3], x[..., 3:6], x[..., 6:9], x[..., 9])


@dataclass(frozen=True, eq=False, repr=False)
class ContactForces(Value):
    """Forces of contact over a step from each state of a batch (...), in the axes of the world unless another frame is named.

    Points between links are the same in number, m, for all states: where a state has fewer, the others have links -1, and zeros.
    """

    simulator: Simulator
    q: Array
    v: Array
    #: Names of the links, those of ``simulator.model.link_names``
    link_names: list[str]
    #: The force of all contact on each link, in the frame of the link, [linear; angular] (..., n_links, 6), N and N·m
    wrenches: Array
    #: Whether each link is in contact, (..., n_links)
    touching: NDArray[np.bool_]
    #: The force of the ground on each point of ``simulator.contact_points``, (..., n, 3), N
    ground: Array
    #: The links of each point between links, as indices of link_names, (..., m, 2)
    links: NDArray[np.int64]
    #: Frames of the points between links, (..., m, 4, 4): the origin half way between both links, z along the normal, which points out of the second link
    frames: Array
    #: Velocities of the first link less those of the second at the points, (..., m, 3), m/s
    velocities: Array
    #: Forces on the first link at the points, (..., m, 3), N; those on the second are opposite
    forces: Array
    #: How deep the links overlap at the points, (..., m), m; negative where they are apart
    depths: Array
    #: Whether the points are in contact, (..., m)
    in_contact: NDArray[np.bool_]

    def force_between(self, first: str, second: str) -> Array:
        """The force of the second link on the first, the sum over their points, (..., 3), N."""
        weight = self._between(first, second)
        return np.einsum("...m,...mi->...i", weight, self.forces)

    def are_touching(self, first: str, second: str) -> NDArray[np.bool_]:
        """Whether two links are in contact with each other, (...), in either order."""
        return ((self._between(first, second) != 0) & self.in_contact).any(axis=-1)

    def wrench(self, link: str) -> Array:
        """The force of all contact on a link, in the frame of the link, [linear; angular] (..., 6), N and N·m about its origin."""
        return self.wrenches[..., self._index(link), :]

    def is_touching(self, link: str) -> NDArray[np.bool_]:
        """Whether a link is in contact with the ground or with another link, (...)."""
        return self.touching[..., self._index(link)]

    def jacobians(self) -> Array:
        """Jacobians of all points between links, (..., m, 6, nv): of the velocity of the first link less that of the second, rows [linear; angular].

        The first three rows are the Jacobian of the point: a force there acts on the joints by their transpose. A point that a state does not have has zeros.
        """
        return self.simulator._pair_jacobians(self.q, self.v, self._places(), False)

    def jacobian_derivatives(self) -> Array:
        """Rates of the Jacobians of points that are fixed to their links, along v, (..., m, 6, nv)."""
        return self.simulator._pair_jacobians(self.q, self.v, self._places(), True)

    def _places(self) -> Array:
        return np.concatenate([self.links.astype(np.float64), self.frames[..., :3, 3]], axis=-1)

    def _between(self, first: str, second: str) -> Array:
        """1 at points of the first link with the second, -1 where they are in the opposite order, else 0."""
        pair = [self._index(first), self._index(second)]
        own, turned = ((self.links == order).all(axis=-1) for order in (pair, pair[::-1]))
        return own.astype(np.float64) - turned

    def _index(self, link: str) -> int:
        if link not in self.link_names:
            raise KeyError(f"there is no link {link!r}; links are {', '.join(map(repr, self.link_names))}")
        return self.link_names.index(link)

    def __repr__(self) -> str:
        return f"ContactForces({self.touching.shape[:-1]} states, {self.ground.shape[-2]} points with the ground, {self.links.shape[-2]} between links)"


def contact_forces(
    simulator: Simulator, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None
) -> ContactForces:
    """Forces of contact over a step from each state: a ContactForces. q (..., nq), v (..., nv), u (..., nu), contact (..., n_contact).

    Batches are computed on all cores. For one state, `Simulator.contact_report` has modes and reasons besides.
    """
    links, ground, points = simulator._contact_forces(q, v, u, contact)
    batch = points.shape[:-2]
    frames = np.zeros((*points.shape[:-1], 4, 4))
    frames[..., :3, :3] = points[..., 5:14].reshape(*points.shape[:-1], 3, 3)
    frames[..., :3, 3] = points[..., 2:5]
    frames[..., 3, 3] = 1.0
    q, v = (np.broadcast_to(np.asarray(x, dtype=np.float64), (*batch, np.shape(x)[-1])) for x in (q, v))
    return ContactForces(
        simulator,
        q,
        v,
        simulator.model.link_names,
        links[..., :6],
        links[..., 6] > 0,
        ground,
        points[..., :2].astype(np.int64),
        frames,
        points[..., 14:17],
        points[..., 17:20],
        points[..., 20],
        points[..., 21] > 0,
    )


def rollout_contact_forces(simulator: Simulator, rollout: Rollout) -> ContactForces:
    """Forces of contact in each step of a rollout, or of a batch of them: a ContactForces of (..., steps) states.

    A step that was not taken has the forces of no contact, zero, and NaN as its state.
    """
    q, v, contact = (x[..., :-1, :] for x in (rollout.q, rollout.v, rollout.contact))
    u = np.broadcast_to(rollout.u, (*q.shape[:-1], rollout.u.shape[-1]))
    taken = np.isfinite(rollout.q[..., 1:, :]).all(axis=-1)
    found = contact_forces(simulator, q[taken], v[taken], u[taken], contact=contact[taken])

    def spread(x: Any, missing: int = 0) -> Any:
        whole = np.full((*taken.shape, *x.shape[1:]), missing, dtype=x.dtype)
        whole[taken] = x
        return whole

    names = ("wrenches", "touching", "ground", "frames", "velocities", "forces", "depths", "in_contact")
    spreads: dict[str, Any] = {name: spread(getattr(found, name)) for name in names}
    return replace(found, q=q, v=v, links=spread(found.links, -1), **spreads)
