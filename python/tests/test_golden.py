"""The numbers of independent engines, made by tests/golden/make.py; joints are compared by name."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from conftest import OTHER_ALGORITHM, ROOT, SAME_ALGEBRA, asset

import dualbody as db

FILES = sorted((ROOT / "tests" / "golden").glob("*.txt"))
INPUTS = ("q", "v", "a", "tau")
#: Numbers are compared relative to the largest of a record, or to this if all are smaller.
NEGLIGIBLE = 1e-3


@dataclass
class Golden:
    header: dict[str, list[str]] = field(default_factory=dict)
    states: list[dict[str, np.ndarray]] = field(default_factory=list)

    @staticmethod
    def read(path: Path) -> Golden:
        golden = Golden()
        for line in path.read_text().splitlines():
            if line.startswith("#"):
                continue
            key, *words = line.split()
            if key == "state":
                golden.states.append({})
            elif golden.states:
                rows, columns = int(words[0]), int(words[1])
                golden.states[-1][key] = np.array([float(x) for x in words[2:]]).reshape(rows, columns)
            else:
                golden.header[key] = words
        return golden

    def model(self) -> db.Model:
        base = self.header["base"][0]
        text = Path(asset(self.header["robot"][0])).read_text()
        if base == "floating":
            text = without_world(text)
        independent = self.header["mimic"][0] == "independent"
        model = db.Model.from_urdf(text, base=base, independent_mimic_joints=independent)
        for k in range(6 if model.has_floating_base else 0, model.nv):
            for name in ("damping", "armature"):
                number = float(self.header.get(name, ["0"])[0])
                model = getattr(model, f"with_{name}")(k, number)
        return model


def without_world(text: str) -> str:
    """A description without the link `world`, if a link is fixed to it, which then floats."""
    fixed = re.compile(r"<joint (?=[^>]*type=\"fixed\")(?:(?!</joint>).)*<parent link=\"world\"/>(?:(?!</joint>).)*</joint>", re.S)
    if fixed.search(text):
        text = fixed.sub("", text).replace('<link name="world"/>', "")
    return text


def order(golden: Golden, model: db.Model, base: int) -> list[int]:
    """For each coordinate of the model, where the file has it: the base first, then one number a joint."""
    known = golden.header["joints"]
    independent = [name for name in model.joint_names if name in known]
    return [*range(base), *(base + known.index(name) for name in independent)]


def compare(golden: Golden, model: db.Model, state: dict[str, np.ndarray], name: str) -> tuple[np.ndarray, np.ndarray]:
    base = 6 if model.has_floating_base else 0
    rows = order(golden, model, base)
    rows_q = order(golden, model, base + model.nq - model.nv)
    empty = np.zeros((model.nv, 1))
    q = state["q"][rows_q, 0]
    v, a, tau = (state.get(key, empty)[rows if key in state else slice(None), 0] for key in ("v", "a", "tau"))
    record = state[name]
    square, by_joints, along = record[rows][:, rows] if record.shape[0] == record.shape[1] == len(rows) else None, None, None
    if record.shape[1] == len(rows):
        by_joints = record[:, rows]
    if record.shape[0] == len(rows):
        along = record[rows, 0]
    match name:
        case "mass_matrix":
            return db.mass_matrix(model, q), square
        case "coriolis_matrix":
            return db.coriolis_matrix(model, q, v), square
        case "bias_forces":
            return db.bias_forces(model, q, v), along
        case "gravity_forces":
            return db.gravity_forces(model, q), along
        case "inverse_dynamics":
            return db.inverse_dynamics(model, q, v, a), along
        case "forward_dynamics":
            return db.forward_dynamics(model, q, v, tau), along
        case "inverse_dynamics_dq" | "inverse_dynamics_dv":
            return getattr(db.inverse_dynamics_derivatives(model, q, v, a), name[-2:]), square
        case "forward_dynamics_dq" | "forward_dynamics_dv" | "forward_dynamics_dtau":
            return getattr(db.forward_dynamics_derivatives(model, q, v, tau), name.removeprefix("forward_dynamics_")), square
        case "center_of_mass" | "potential_energy":
            return getattr(db, name)(model, q), record.squeeze()
        case "center_of_mass_velocity" | "centroidal_momentum" | "kinetic_energy":
            return getattr(db, name)(model, q, v), record.squeeze()
        case "center_of_mass_acceleration" | "centroidal_momentum_rate":
            return getattr(db, name)(model, q, v, a), record.squeeze()
        case "center_of_mass_jacobian" | "centroidal_momentum_matrix":
            return getattr(db, name)(model, q), by_joints
        case "final_q" | "final_v":
            simulator = db.Simulator(model, time_step=1e-3, integrator="runge_kutta_4")
            rollout = simulator.rollout(q, v, inputs=np.tile(tau[base:], (1000, 1)))
            if name == "final_v":
                return rollout.v[-1], along
            return model.difference(q, rollout.q[-1]), model.difference(q, record[rows_q, 0])
    quantity, of = name.split(":")
    if quantity == "frame_pose":
        return db.frame_pose(model, q, of)[:3], record
    tip = golden.header["tip"][0]
    match quantity:
        case "frame_velocity":
            return db.frame_velocity(model, q, v, tip, of), record[:, 0]
        case "frame_acceleration":
            return db.frame_acceleration(model, q, v, a, tip, of), record[:, 0]
        case "frame_jacobian":
            return db.frame_jacobian(model, q, tip, representation=of), by_joints
        case "frame_jacobian_derivative":
            return db.frame_jacobian_derivative(model, q, v, tip, of), by_joints
    raise AssertionError(f"unknown record {name}")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_python_agrees_with_the_golden_numbers(path: Path) -> None:
    golden = Golden.read(path)
    model = golden.model()
    compared = 0
    for k, state in enumerate(golden.states):
        for name in state:
            if name in INPUTS:
                continue
            actual, expected = compare(golden, model, state, name)
            assert np.shape(actual) == np.shape(expected), f"state {k}: {name}"
            tolerance = OTHER_ALGORITHM if name.startswith(("forward_dynamics", "final")) else SAME_ALGEBRA
            largest = max(np.abs(expected).max(), NEGLIGIBLE)
            assert np.abs(actual - expected).max() <= tolerance * largest, f"state {k}: {name}"
            compared += 1
    assert compared >= 3


def test_every_golden_file_is_found() -> None:
    assert len(FILES) >= 30
