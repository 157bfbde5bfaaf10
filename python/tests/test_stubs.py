"""The package has the types of the compiled module, which are those of its entries, and name what it has."""

from __future__ import annotations

import ast
import importlib.util
from pathlib import Path

import dualbody
from dualbody import _dualbody

HERE = Path(__file__).parents[1]
#: Of the package as it is installed: no file of the repository.
FILE = Path(dualbody.__file__).with_name("_dualbody.pyi")


def test_stubs_are_those_of_the_entries() -> None:
    spec = importlib.util.spec_from_file_location("stubs", HERE / "stubs.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert FILE.read_text(encoding="utf-8") == module.stubs(), "build the package again"


def test_stubs_name_what_the_module_has() -> None:
    tree = ast.parse(FILE.read_text(encoding="utf-8"))
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef) and "Keywords" not in node.name}
    own = {name for name in dir(_dualbody) if not name.startswith("__")}
    optional = {"BaseFunctions", "CudaSimulator", "CudaStates"}  # types alone; only with the feature `cuda`
    own -= {f"_base_{name}" for name in own}  # methods of BaseFunctions
    assert functions | set(classes) - optional == own - optional
    for name in set(classes) - optional:
        stated = {node.name for node in classes[name].body if isinstance(node, ast.FunctionDef)}
        assert {member for member in vars(getattr(_dualbody, name)) if not member.startswith("__")} == {x for x in stated if not x.startswith("__")}
