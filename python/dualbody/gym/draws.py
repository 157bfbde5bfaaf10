"""Random numbers of many environments at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Words = NDArray[np.uint64]

#: Increment and multipliers of the generator splitmix64 (Steele, Lea, Flood 2014).
_STEP, _FIRST, _SECOND = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_U30, _U27, _U31, _U11 = (np.uint64(bits) for bits in (30, 27, 31, 11))


def _mixed(x: Words) -> Words:
    x = (x ^ (x >> _U30)) * _FIRST
    x = (x ^ (x >> _U27)) * _SECOND
    return x ^ (x >> _U31)


def whole(seeds: Sequence[int | None]) -> list[int]:
    """Seeds of 64 bits, random ones where the seed is None."""
    entropy = int(np.random.SeedSequence().generate_state(1, np.uint64)[0])
    return [(entropy + i if s is None else int(s)) % 2**64 for i, s in enumerate(seeds)]


def keys(seeds: Sequence[int | None]) -> Words:
    """The state of a generator for each seed; of a random one where the seed is None."""
    # Mixed twice, so that the sequences of neighbouring seeds are not shifts of one another.
    return _mixed(_mixed(np.array(whole(seeds), np.uint64)) + _STEP)


class Draws:
    """Random numbers of the environments whose episodes begin: one row per environment. A row depends on the seed and the earlier draws of its environment
    only."""

    def __init__(self, states: Words) -> None:
        self._states = states

    def __len__(self) -> int:
        return len(self._states)

    def uniform(self, low: float, high: float, size: int) -> Array:
        """Uniform numbers (n, size) of [low, high)."""
        counter = np.arange(1, size + 1, dtype=np.uint64) * _STEP
        words = _mixed(self._states[:, None] + counter)
        self._states += np.uint64(size * int(_STEP) % 2**64)
        return low + (high - low) * 2.0**-53 * (words >> _U11).astype(np.float64)

    def normal(self, size: int) -> Array:
        """Normal numbers (n, size) of mean 0 and deviation 1, by the method of Box and Muller."""
        u = self.uniform(0.0, 1.0, 2 * size)
        radius, angle = np.sqrt(-2.0 * np.log1p(-u[:, :size])), 2.0 * np.pi * u[:, size:]
        return radius * np.cos(angle)
