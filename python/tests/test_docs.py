"""The examples in the documentation of the modules give the results that it states."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil

import pytest

import dualbody as db

#: Those that need other packages.
OPTIONAL = {"cuda", "gym", "jax", "ray", "torch"}
MODULES = ["dualbody"] + [f"dualbody.{own.name}" for own in pkgutil.iter_modules(db.__path__) if own.name not in OPTIONAL]
# They load when they are asked for: all before doctest goes through the package, which must not grow meanwhile.
for name in MODULES:
    importlib.import_module(name)


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_a_module_hold(name: str) -> None:
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_there_are_examples() -> None:
    finder = doctest.DocTestFinder()
    found = {name for name in MODULES if any(test.examples for test in finder.find(importlib.import_module(name)))}
    assert {"dualbody", "dualbody.codegen", "dualbody.identify", "dualbody.least_squares", "dualbody.native"} <= found


def undocumented(module: object) -> list[str]:
    """Public names of a module, and of its classes, that say nothing of themselves."""
    found = []
    for name in getattr(module, "__all__", []):
        own = getattr(module, name)
        if not callable(own):
            continue
        if not inspect.getdoc(own):
            found.append(name)
        if inspect.isclass(own) and own.__module__.startswith("dualbody"):
            members = ((key, member) for key, member in vars(own).items() if not key.startswith("_"))
            shown = ((key, m) for key, m in members if callable(m) or isinstance(m, (property, staticmethod)) or inspect.isgetsetdescriptor(m))
            found += [f"{name}.{key}" for key, member in shown if not member.__doc__]
    return found


@pytest.mark.parametrize("name", [*(name for name in MODULES if "._" not in name), *(f"dualbody.{own}" for own in sorted(OPTIONAL))])
def test_every_public_name_is_documented(name: str) -> None:
    try:
        module = importlib.import_module(name)
    except ImportError as error:
        pytest.skip(str(error))
    assert module.__doc__ and undocumented(module) == []
