"""The examples in the documentation of the modules give what stands beside them."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

import dualbody as db

#: Those that need other packages.
OPTIONAL = {"gym", "jax", "ray", "torch"}
MODULES = ["dualbody"] + [f"dualbody.{own.name}" for own in pkgutil.iter_modules(db.__path__) if own.name not in OPTIONAL]


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_a_module_hold(name: str) -> None:
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_there_are_examples() -> None:
    finder = doctest.DocTestFinder()
    found = {name for name in MODULES if any(test.examples for test in finder.find(importlib.import_module(name)))}
    assert {"dualbody", "dualbody.codegen", "dualbody.identify", "dualbody.least_squares", "dualbody.native"} <= found
