"""Robots that come with the library."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from . import _dualbody
from ._dualbody import Model

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._dualbody import LoaderKeywords

__all__ = ["arm", "cartpole", "double_pendulum", "load", "pendulum", "random_tree", "urdf"]

Name = Literal[
    "acrobot", "box", "cartpole", "double_pendulum", "four_bar", "hopper", "humanoid", "panda", "quadrotor", "quadruped", "sphere", "ur5",
]


def urdf(name: Name) -> str:
    """The URDF of a robot of the library's examples, as a text."""
    return _dualbody._sample_urdf(name)


def load(name: Name, **keywords: Unpack[LoaderKeywords]) -> Model:
    """A robot of the library's examples, from its URDF; keywords as for `Model.from_urdf`.

    >>> load("panda", base="fixed").nv
    8
    """
    return Model.from_urdf(urdf(name), **keywords)


def pendulum() -> Model:
    """A rod of 1 kg and 1 m on a hinge."""
    return _dualbody._sample("pendulum")


def double_pendulum() -> Model:
    """Two rods."""
    return _dualbody._sample("double_pendulum")


def cartpole() -> Model:
    """A pole on a cart: joints "linear" and "pivot"."""
    return _dualbody._sample("cartpole")


def arm() -> Model:
    """An arm of seven joints."""
    return _dualbody._sample("arm")


def random_tree(n: int, seed: int) -> Model:
    """A tree of n random bodies on random joints; equal seeds give equal robots."""
    return _dualbody._sample("random_tree", n, seed)
