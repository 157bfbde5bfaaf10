"""What the tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

import dualbody as db

ROOT = Path(__file__).resolve().parents[2]
ASSETS = ROOT / "assets"

#: Another algorithm for the same number: roundings of a whole robot, and of a linear solve.
OTHER_ALGORITHM = 1e-9
#: Two ways through the same algebra.
SAME_ALGEBRA = 1e-12


def asset(name: str) -> str:
    return str(ASSETS / f"{name}.urdf")


@pytest.fixture(scope="session")
def cartpole() -> db.Model:
    return db.Model.from_urdf(asset("cartpole"))


@pytest.fixture(scope="session")
def panda() -> db.Model:
    return db.Model.from_urdf(asset("panda"), base="fixed")


@pytest.fixture(scope="session")
def quadruped() -> db.Model:
    return db.Model.from_urdf(asset("quadruped"))
