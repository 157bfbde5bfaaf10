"""Generated C, compiled by the system's C compiler and loaded: steps and functions as straight-line code that knows the robot's numbers.

>>> import dualbody as db
>>> simulator = db.Simulator(db.samples.cartpole(), time_step=0.01)
>>> fast = db.native.NativeSimulator.or_own(simulator)     # fast.reason says why it was not compiled; None if it was
>>> bool(abs(fast.step([0.1, 0.2], [0.0, 0.0])[1] - simulator.step([0.1, 0.2], [0.0, 0.0])[1]).max() < 1e-12)
True

What is compiled is kept in a folder of the user's caches, and found again by its text, the compiler and the machine: nothing is compiled
twice. Ctrl-C, and the end of the program, end the compiler with all that it has started. Whoever may write to that folder may change what
the program does. It pays for small robots whose steps are taken one by one, or many at once in other loops than those of
`Simulator.rollout`, which runs on vector registers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ._dualbody import NativeFunction, NativeSimulator

if TYPE_CHECKING:
    from os import PathLike

    from ._dualbody import Simulator

__all__ = ["Compiler", "NativeFunction", "NativeSimulator"]


@dataclass(frozen=True)
class Compiler:
    """A C compiler that takes flags as GCC and Clang do.

    command: None is what the variable CC names, or `cc`. flags: those for optimisation, None for -O2 and this very machine. cache: the folder for
    what it compiles, None for `dualbody-native` among the user's caches.
    """

    command: str | None = None
    flags: Sequence[str] | None = None
    cache: str | PathLike[str] | None = None


def _native_simulator(simulator: Simulator, compiler: Compiler | None) -> NativeSimulator:
    """A simulator that was pickled."""
    return NativeSimulator.or_own(simulator, compiler)
