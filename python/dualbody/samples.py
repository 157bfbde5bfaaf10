"""Robots that come with the library."""

from __future__ import annotations

from . import _dualbody
from ._dualbody import Model


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
    """A tree of n random bodies on random joints, the same for the same seed."""
    return _dualbody._sample("random_tree", n, seed)
