"""Generated C, compiled by the system's C compiler and loaded: steps and functions as straight-line code with the parameters of the robot as constants.

>>> import dualbody as db
>>> simulator = db.Simulator(db.samples.cartpole(), time_step=0.01)
>>> fast = db.native.NativeSimulator.or_own(simulator)     # fast.reason says why it was not compiled; None if it was
>>> bool(abs(fast.step([0.1, 0.2], [0.0, 0.0])[1] - simulator.step([0.1, 0.2], [0.0, 0.0])[1]).max() < 1e-12)
True

Compiled code is stored in the user's cache folder and found again by its text, the compiler and the machine, so nothing is compiled twice. Ctrl-C and the
end of the program end the compiler and its child processes. A user with write access to that folder can change the behaviour of the program. Native code
is useful for small robots that are stepped one by one, or in other loops than `Simulator.rollout`, which runs on vector registers.
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
    """A C compiler with the flags of GCC and Clang.

    command: None for the variable CC, or `cc`. flags: for optimisation, None for -O2 and the instructions of this machine. cache: the folder for compiled
    code, None for `dualbody-native` in the user's cache folder.
    """

    command: str | None = None
    flags: Sequence[str] | None = None
    cache: str | PathLike[str] | None = None


def _native_simulator(simulator: Simulator, compiler: Compiler | None) -> NativeSimulator:
    """A simulator that was pickled."""
    return NativeSimulator.or_own(simulator, compiler)
