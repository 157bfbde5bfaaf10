"""Code generation: dynamics and step of a robot as expression graphs and as C.

>>> import dualbody as db
>>> graph = db.codegen.step(db.Simulator(db.samples.cartpole(), time_step=0.01))
>>> text = graph.to_c("cartpole_step")
>>> "int cartpole_step(const cartpole_step_real *in, cartpole_step_real *out);" in text.header
True

The text is C99 without dependencies except math.h, for small computers and other languages. A graph can also be evaluated directly and differentiated:
`jacobian`, `gradient`, `adjoint`. Trace again after a change of the robot; `Graph.check_origin` detects changes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from . import _dualbody
from ._dualbody import Graph

if TYPE_CHECKING:
    from os import PathLike

    from ._dualbody import Model, Simulator

__all__ = ["Graph", "Source", "forward_dynamics", "inverse_dynamics", "inverse_dynamics_derivatives", "mass_matrix", "step"]


@dataclass(frozen=True)
class Source:
    """A function as C: its name, the text of NAME.h (names, sizes and units of inputs and outputs) and of NAME.c."""

    name: str
    header: str
    source: str

    def save(self, folder: str | PathLike[str]) -> None:
        """Writes both files into a folder, which is created if necessary."""
        path = Path(folder)
        path.mkdir(parents=True, exist_ok=True)
        (path / f"{self.name}.h").write_text(self.header)
        (path / f"{self.name}.c").write_text(self.source)


def inverse_dynamics(model: Model) -> Graph:
    """Inputs q, v, a; output tau."""
    return _dualbody._trace_model("inverse_dynamics", model)


def forward_dynamics(model: Model) -> Graph:
    """Inputs q, v, tau; output a. A singular mass matrix is a ValueError."""
    return _dualbody._trace_model("forward_dynamics", model)


def mass_matrix(model: Model) -> Graph:
    """Input q; output M."""
    return _dualbody._trace_model("mass_matrix", model)


def inverse_dynamics_derivatives(model: Model) -> Graph:
    """Inputs q, v, a; outputs dq (tangent), dv, da: matrices in column-major order."""
    return _dualbody._trace_model("inverse_dynamics_derivatives", model)


def step(simulator: Simulator) -> Graph:
    """Inputs q, v, contact (if there is a contact state), u; outputs q_next, v_next, contact_next likewise.

    Raises a ValueError with the location if a step depends on values by branches, as rigid contact does: such a step has no graph. `Graph.jacobian`
    computes its derivatives, in coordinates.
    """
    return _dualbody._trace_step(simulator)
