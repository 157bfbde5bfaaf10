"""Writes the types of the compiled module, `dualbody/_dualbody.pyi`, from the entries in `src` and in the table: `build.rs` runs it.

Names, arguments, defaults and documentation are those of the entries; types follow from those in Rust. What Rust leaves open is in `ARGUMENTS` (arguments
by their name) and in `OTHERS` (what is different from that: {class.method: {argument or "return": type}}).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent

HEADER = '''"""The compiled module; written by `stubs.py`."""

import builtins
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self, TypedDict, Unpack

from . import codegen as _codegen
from . import contact as _contact
from . import cuda as _cuda
from . import identify as _identify
from . import model as _model
from . import native as _native
from . import sim as _sim
from . import trajopt as _trajopt
from . import view as _view

Array = NDArray[np.float64]
Path = str | PathLike[str]
RepresentationName = Literal["body", "mixed", "inertial"]
MomentumFrameName = Literal["centroidal", "world", "base"]
EngineName = Literal["pinocchio", "mujoco", "jaxsim"]
IntegratorName = Literal["semi_implicit_euler", "implicit_velocity", "runge_kutta_4", "implicit_midpoint"]
Vector3 = tuple[float, float, float]
Guess = tuple[ArrayLike | None, ArrayLike]
Report = Callable[[int, float, float, float], object]
Constraint = _sim.Weld | _sim.Ball | _sim.Distance | _sim.Coupler | _sim.Tendon

__version__: str

class LoaderKeywords(TypedDict, total=False):
    base: Literal["auto", "fixed", "floating"]
    gravity: Sequence[float]
    independent_mimic_joints: bool
    kept_joints: Sequence[str]
    locked_joints: Mapping[str, float | Sequence[float]]
    massless_links: Literal["kept", "refused"] | tuple[float, float]
    mesh_up_axis: Literal["auto", "honour", "ignore"]
    all_models: bool
    model_name: str
    search_paths: Sequence[Path]
    roots: Sequence[Path]

class ObjectKeywords(TypedDict, total=False):
    mass: float
    density: float
    fixed: bool
    position: Sequence[float]
    quaternion: Sequence[float]
    on: str
    color: Sequence[float]
    has_gravity: bool

class DdpKeywords(TypedDict, total=False):
    max_iterations: int
    tolerance: float
    threads: int
    line_search_steps: int
    exact_curvature: bool
    constraint_tolerance: float
    penalty: float
'''

#: Types of arguments that are any object in Rust, by name; of others an array.
ARGUMENTS = {
    "adjustable": "object",
    "activations": "Mapping[str, _sim.Activation]",
    "sleeping": "bool | tuple[float, float]",
    "actuated": "Sequence[str]",
    "actuation": '_sim.Actuation | Literal["ideal", "model"]',
    "checkpoints": "int | str",
    "compiler": "_native.Compiler",
    "constraints": "Constraint",
    "contacts": "_contact.Contacts",
    "control": "Callable[[int, Array, Array], ArrayLike]",
    "data": "_identify.Dataset",
    "description": "Path",
    "estimate": "_identify.Estimate",
    "experiments": "_identify.Experiment",
    "external_forces": "_sim.ExternalForce",
    "forces": "Mapping[str, ArrayLike]",
    "frame_actuators": "_sim.FrameActuator",
    "joint": "_model.JointSpec",
    "joints": "_model.JointSpec",
    "law": "_contact.SoftContact",
    "link": "_model.LinkSpec",
    "links": "_model.LinkSpec",
    "motion": "_identify.Excitation",
    "noise": "Mapping[str, _sim.SensorNoise]",
    "out": "Array",
    "parameters": "ArrayLike",
    "positions": "Mapping[str, float | Sequence[float]]",
    "preparation": "_identify.Preparation",
    "problem": "_trajopt.Problem",
    "progress": "bool | Callable[[int], object]",
    "regressor": "_identify.Regressor",
    "report": "Report",
    "robot": "_identify.Robot",
    "rollout": "_sim.Rollout",
    "seed": "int",
    "sensors": "Mapping[str, _sim.Sensor]",
    "shape": "_model.Shape",
    "stage_cost": "Iterable[_trajopt.Term]",
    "steps": "int",
    "tendon_servos": "_sim.TendonServo",
    "terrain": "_contact.Terrain",
    "tiles": "_contact.HeightField",
    "validation": "_identify.Dataset",
}
ARGUMENTS["final_cost"] = ARGUMENTS["stage_cost"]

#: Types of arguments that are text in Rust, by name.
TEXTS = {"engine": "EngineName", "integrator": "IntegratorName", "representation": "RepresentationName"}

#: What is different, by class and method.
OTHERS: dict[str, dict[str, str]] = {
    "BatchSimulator.__new__": {"n": "int", "parameters": "Mapping[str, ArrayLike]"},
    "BatchSimulator.step": {"steps": "int"},
    "CudaSimulator.__new__": {
        "count": "int", "parameters": "Mapping[str, ArrayLike]", "precision": 'Literal["double", "single"]',
        "derivatives": 'Sequence[Literal["jacobians", "gradients"]]', "device": "int",
    },
    "CudaSimulator.linearize": {"return": "_sim.Linearization"},
    "CudaSimulator.rollout": {"every": "int", "return": "_cuda.Rollout"},
    "CudaSimulator.vjp": {"return": "_sim.StepGradient"},
    "CudaStates.__dlpack__": {"stream": "Any", "return": "Any"},
    "CudaStates.advance": {"u": "Any", "steps": "int"},
    "CudaStates.copy_from": {"states": "Any"},
    "CudaStates.status": {"return": "list[_sim.Status]"},
    "EngineCoordinates.engine": {"return": "EngineName"},
    "Graph.to_c": {"precision": 'Literal["double", "single"]', "return": "_codegen.Source"},
    "Model._repr_html_": {"return": "str"},
    "Model.from_mjcf": {"keywords": "Unpack[LoaderKeywords]"},
    "Model.from_sdf": {"keywords": "Unpack[LoaderKeywords]"},
    "Model.from_urdf": {"keywords": "Unpack[LoaderKeywords]"},
    "Model.limits": {"return": "_model.Limits"},
    "Model.sensors": {"return": "dict[str, tuple[_sim.Sensor, _sim.SensorNoise]]"},
    "Model.show": {"return": "_view.Page"},
    "Model.with_armature": {"v": "int | str"},
    "Model.with_damping": {"v": "int | str"},
    "Model.with_spring": {"v": "int | str"},
    "NativeSimulator.linearize": {"return": "_sim.Linearization"},
    "NativeSimulator.rollout": {"return": "_sim.Rollout"},
    "Plot.__new__": {"size": "tuple[int, int]"},
    "Plot.with_size": {"width": "int", "height": "int"},
    "RecedingHorizon.__new__": {"options": "Unpack[DdpKeywords]"},
    "Recording.__new__": {"models": "Model"},
    "Recording._repr_html_": {"return": "str"},
    "Recording.push": {"states": "tuple[ArrayLike, ...]"},
    "Recording.read": {"models": "Model"},
    "Recording.show": {"return": "_view.Page"},
    "Sensors.linearize": {"return": "_sim.SensorLinearization"},
    "Simulator.contact_report": {"return": "_sim.ContactReport"},
    "Simulator.from_mjcf": {"keywords": "Unpack[LoaderKeywords]", "return": "Simulator"},
    "Simulator.from_urdf": {"keywords": "Unpack[LoaderKeywords]", "return": "Simulator"},
    "Simulator.integrator": {"return": "IntegratorName"},
    "Simulator.keyframes": {"return": "dict[str, tuple[Array, Array, Array, Array]]"},
    "Simulator.linearize": {"return": "_sim.Linearization"},
    "Simulator.linearize_rate": {"return": "_sim.Linearization"},
    "Simulator.replace": {"return": "Self"},
    "Simulator.rollout": {"return": "_sim.Rollout"},
    "Simulator.rollout_vjp": {"return": "_sim.RolloutGradient"},
    "Simulator.vjp": {"return": "_sim.StepGradient"},
    "Simulator.with_parameters": {"return": "Self"},
    "_Balance.first": {"return": "tuple[Array, Array, int]"},
    "_Balance.step": {"return": "Any"},
    "_call": {"of": "Model | Simulator"},
    "_check_grid": {"nx": "int", "ny": "int"},
    "_estimate_soft_contact": {"points": "int"},
    "_finite_horizon_lqr": {"final_cost": "ArrayLike"},
    "_foreign_name": {"of": "Model | Simulator"},
    "_least_squares": {
        "residuals": "Callable[[Array], ArrayLike]",
        "jacobian": "Callable[[Array], ArrayLike]",
        "manifold": "tuple[int, Callable[[Array, Array], ArrayLike]]",
    },
    "_recording": {"class_": "type[Recording]", "return": "Recording"},
    "_sample": {"arguments": "int"},
    "_signature": {"of": "Model | Simulator"},
    "_surface_grid": {"return": "tuple[list[Vector3], list[tuple[int, int, int]]]"},
    "_tiled": {"columns": "int"},
    "_trajectory_cost": {"states": "ArrayLike | None"},
    "carried_state": {"q": "ArrayLike", "v": "ArrayLike"},
    "set_memory_limit": {"bytes": "int"},
    "set_threads": {"threads": "int"},
}  # fmt: skip
for _name in ("trace", "show_frame", "add_force", "add_applied_forces", "place"):
    OTHERS[f"Recording.{_name}"] = {"robot": "int"}

#: Types of Rust in Python.
TYPES = {
    "()": "None", "Guess": "Guess", "PathBuf": "Path", "bool": "bool", "f32": "np.float32", "f64": "float", "str": "str", "String": "str",
    "Array": "Array", "PyAny": "Array", "PyBytes": "bytes", "PyCapsule": "object", "PyDict": "dict[str, Any]", "PySlice": "builtins.slice",
    "PyTuple": "tuple[Any, ...]", "Self": "Self", "Keyword": "tuple[str, str | None]",
}  # fmt: skip
TYPES |= dict.fromkeys(("i32", "i64", "u8", "u32", "u64", "usize"), "int")
#: Elements of arrays.
ELEMENTS = {"bool": "bool_", "f32": "float32", "f64": "float64", "u8": "uint8"}

_FUNCTION = re.compile(r"((?:[ \t]*(?:///.*|//.*|#\[(?:.|\n)*?\])\n)*)[ \t]*(?:pub(?:\(\w+\))? )?fn (\w+)(?:<'py>)?\(")
_CLASS = re.compile(r'#\[pyclass\(([^\]]*)\)\]\n(?:pub\(crate\) )?struct (\w+)')


class Argument(NamedTuple):
    """An argument: "", "*" or "**" before its name, its type in Rust, its default in Rust."""

    stars: str
    name: str
    type: str
    default: str | None


class Entry(NamedTuple):
    """A function, or a method or attribute of a class."""

    owner: str
    kind: str
    name: str
    arguments: list[Argument]
    result: str
    doc: str


def parts(text: str) -> list[str]:
    """What commas separate, outside of brackets and texts."""
    out, depth, quoted = [""], 0, False
    for i, c in enumerate(text):
        quoted ^= c == '"'
        depth += 0 if quoted else (c in "([{<") - (c in ")]}" or (c == ">" and text[i - 1] != "-"))
        if c == "," and depth == 0 and not quoted:
            out.append("")
        else:
            out[-1] += c
    return [" ".join(part.split()) for part in out if part.strip()]


def closed(text: str, start: int) -> int:
    """Where the bracket at `start` is closed."""
    depth = 0
    for i in range(start, len(text)):
        depth += (text[i] in "([{") - (text[i] in ")]}")
        if depth == 0:
            return i
    raise ValueError(text[start : start + 80])


def described(attributes: str) -> str:
    """The documentation among attributes."""
    return "\n".join(line.strip()[4:] for line in attributes.splitlines() if line.strip().startswith("///"))


def arguments(text: str, attributes: str) -> list[Argument]:
    """The arguments of Python in those of an entry, of which some are in Rust only."""
    signature = re.search(r"[(\s]signature = \(((?:.|\n)*?)\)(?:\)\]|,\s*text)", attributes)
    shown = re.search(r'text_signature = "\((?:\$self, )?(.*)\)"', attributes)
    given = {}
    for part in parts(text):
        stars, name, of, default = re.fullmatch(r"(\*{0,2})(?:(?:mut )?(\w*)|&.*)(?:: ([^=]*?))?(?: = (.*))?", part).groups()  # type: ignore[union-attr]
        if name not in (None, "self", "this", "py"):
            given[stars + name] = Argument(stars, name, "PyAny" if not of or of.startswith("|") else of, default)
    for part in parts(signature[1]) if signature else []:
        name, _, default = (x.strip() for x in part.partition("="))
        bare = name.lstrip("*")
        own = given.pop(bare, given.pop(name, Argument(name, "", "", None)))
        given[name] = own._replace(stars=name[: len(name) - len(bare)], default=default or None)
    for part in parts(shown[1]) if shown else []:
        name, _, default = part.partition("=")
        if default:
            given[name] = given[name]._replace(type=given[name].type.removeprefix("Option<").removesuffix(">"), default=default)
    return list(given.values())


def full_entries(text: str, owner: str) -> Iterator[Entry]:
    """Entries of the form `fn name(arguments) -> …`, or `fn name(arguments) = …` of what gives a changed object."""
    for found in _FUNCTION.finditer(text):
        end = closed(text, found.end() - 1)
        result = re.compile(r"\s*(?:-> ((?:.|\n)*?))?\s*\{").match(text, end + 1)
        kind = next((kind for kind in ("new", "staticmethod", "getter", "setter") if f"#[{kind}]" in found[1]), "method")
        own = arguments(text[found.end() : end], found[1])
        yield Entry(owner, kind, found[2], own, (result[1] or "()") if result else "Self", described(found[1]))


def attributes_of(text: str, owner: str) -> Iterator[Entry]:
    """Entries of the form `name: Type = |own| value;`."""
    for found in re.finditer(r"((?:[ \t]*///.*\n)*)[ \t]+(\w+): (.*?) = \|own", text):
        yield Entry(owner, "getter", found[2], [], found[3], described(found[1]))


def entries_of(text: str) -> Iterator[Entry]:
    """All entries of a file of `src`."""
    text = re.sub(r"^macro_rules! (?:.|\n)*?^\}", "", text, flags=re.M)
    for found in re.finditer(r"^(#\[pymethods\]\nimpl|\w+!) (?:(\w+) )?\{\n((?:.|\n)*?)^\}", text, re.M):
        head, owner, body = found.groups()
        owner = "PyModel" if head == "edits!" else owner
        if head in ("methods!", "functions!") or owner:
            yield from full_entries(body, owner or "")
    for found in re.finditer(r"^(methods|getters)! \{ (\w+) \{\n((?:.|\n)*?)^\} \}", text, re.M):
        read = full_entries if found[1] == "methods" else attributes_of
        yield from read(found[3], found[2])
    for found in re.finditer(r"((?:^///.*\n|^#\[(?:.|\n)*?\]\n)*)^#\[pyfunction\]\n((?:#\[(?:.|\n)*?\]\n)*(?:pub\(crate\) )?fn (?:.|\n)*?)^\}", text, re.M):
        yield from full_entries(found[1] + found[2], "")
    if inner := re.search(r"#\[pyfunction\]\n    fn (?:.|\n)*?\n    \}", text):
        yield from full_entries(inner[0].split("\n", 1)[1], "")


def entries_of_table(text: str) -> Iterator[Entry]:
    """All functions of a file of the table."""
    form = r"((?:[ \t]*///.*\n)*)[ \t]+(\w+)(?: \[\w+\] ?)?\(([^()]*)\) -> \|"
    for found in re.finditer(form, text):
        vectors, _, named = found[3].partition(";")
        vectors, *option = vectors.split(" + ")
        own = [Argument("", "model", "PyModel", None), *arguments(vectors, ""), *arguments(named, ""), Argument("*", "", "", None)]
        own += [Argument("", name.strip(), "Option<PyAny>", "None") for name in (*option, "out")]
        yield Entry("", "method", found[2], own, "Array", described(found[1]))


def base_functions(functions: list[Entry]) -> Iterator[Entry]:
    """The functions of which there is one for other velocities of the base, as methods without options."""
    names = {own.name for own in functions}
    for own in functions:
        if f"_base_{own.name}" in names:
            given = [x for x in own.arguments[1:] if x.name and not x.type.startswith("Option")]
            yield own._replace(owner="BaseFunctions", arguments=given)


class Writer:
    """Writes entries as stubs."""

    def __init__(self, sources: dict[str, str]) -> None:
        self.classes: dict[str, str] = {"BaseFunctions": "BaseFunctions"}
        self.subclassed: set[str] = set()
        self.aliases: dict[str, str] = {}
        for text in sources.values():
            for options, name in _CLASS.findall(text):
                python = re.search(r'name = "(\w+)"', options)
                self.classes[name] = python[1] if python else name
                if "subclass" in options.split(", "):
                    self.subclassed.add(name)
            for name, _, of in re.findall(r"^(?:pub(?:\(\w+\))? )?type (\w+)(<[^>]*>)? = ((?:.|\n)*?);$", text, re.M):
                self.aliases[name] = of

    def type(self, rust: str, argument: str = "") -> str:
        """The type in Python of a type in Rust, of an argument or of a result."""
        rust = re.sub(r"&(?:'\w+ )?(?:mut )?|(?:\w+::)+|'\w+, |<'\w+>", "", " ".join(rust.split())).strip()
        if found := re.fullmatch(r"(\w+)<(.*)>", rust):
            outer, inner = found.groups()
            if outer == "Option":
                return self.type(inner, argument) + " | None"
            if outer in ("Vec", "PyArrayLike1"):
                return f"{'Sequence' if argument else 'list'}[{self.type(inner, argument)}]" if outer == "Vec" else "ArrayLike"
            if outer.startswith("PyArray"):
                return "Array" if inner == "f64" else f"NDArray[np.{ELEMENTS[inner]}]"
            return self.type(inner, argument)  # PyResult, Bound, Py, …
        if rust.startswith("(") and rust != "()":
            return f"tuple[{', '.join(self.type(part, argument) for part in parts(rust[1:-1]))}]"
        if rust.startswith("["):
            inner, _, count = rust[1:-1].rpartition(";") if re.search(r"; \w+\]$", rust) else (rust[1:-1], "", "")
            return f"{'Sequence' if argument else 'list'}[{self.type(inner, argument)}]"
        if argument and rust == "PyAny" or argument and rust == "PyDict" and argument in ARGUMENTS:
            return ARGUMENTS.get(argument, "ArrayLike")
        if argument and rust in ("str", "String", "Representation", "MomentumFrame", "FrameId"):
            return "MomentumFrameName" if rust == "MomentumFrame" else TEXTS.get(argument, "str")
        if rust in self.classes:
            return self.classes[rust]
        return TYPES[rust] if rust in TYPES else self.type(self.aliases[rust], argument)

    def argument(self, own: Argument, others: dict[str, str]) -> str:
        """An argument with its type and default."""
        name = "class_" if own.name == "class" else own.name
        if own.stars == "*" and not name:
            return "*"
        if own.stars == "*":
            of = others.get(name, "ArrayLike" if own.type == "PyAny" else self.type(own.type, name).removeprefix("Sequence[").removesuffix("]"))
            return f"*{name}: {of}"
        if own.stars:
            return f"**{name}: {others.get(name, 'Unpack[ObjectKeywords]' if name == 'object' else 'Any')}"
        default = (own.default or "").replace("true", "True").replace("false", "False")
        of = self.type(own.type, name)
        if name in others:
            of = others[name] + (" | None" if of.endswith("| None") else "")
        if default == "None" and not of.endswith("| None"):
            of += " | None"
        default = "..." if set(default) & set("[(") else default
        return f"{name}: {of}" + (f" = {default}" if default else "")

    def entry(self, own: Entry) -> str:
        """An entry as lines."""
        owner = self.classes.get(own.owner, "")
        name = {"new": "__new__", "setter": own.name.removeprefix("set_")}.get(own.kind, own.name)
        others = OTHERS.get(f"{owner}.{name}" if owner else name, {})
        first = {"method": ["self"] if owner else [], "staticmethod": [], "new": ["cls"]}.get(own.kind, ["self"])
        result = others.get("return", self.type("Self" if own.kind == "new" else own.result))
        result = result.replace("tuple[Any, ...]", "tuple[Array, ...]") if name == "step" else result
        if result == "Self" and (own.kind == "staticmethod" or own.owner not in self.subclassed):
            result = owner
        given = ", ".join(first + [self.argument(x, others) for x in own.arguments])
        mark = {"staticmethod": "@staticmethod\n", "getter": "@property\n", "setter": f"@{name}.setter\n"}.get(own.kind, "")
        doc = "" if name.startswith("_") else own.doc.replace("\\", "\\\\").strip()  # of what users call
        ending = "\n" if "\n" in doc else ""
        text = f'{mark}def {name}({given}) -> {result}:' + (f'\n    """{doc}{ending}"""'.replace("\n", "\n    ").rstrip(" ") if doc else " ...")
        return text.replace("    \n", "\n").replace("\n        ", "\n    ")


def place(own: Entry) -> tuple[bool, str, bool]:
    """Where an entry goes: attributes first, a setter behind its getter."""
    is_attribute = own.kind in ("getter", "setter")
    return not is_attribute, own.name.removeprefix("set_") * is_attribute, own.kind == "setter"


def stubs() -> str:
    """The text of the file."""
    sources = {str(path): path.read_text(encoding="utf-8") for path in sorted(HERE.glob("src/**/*.rs"))}
    table = [path.read_text(encoding="utf-8") for path in (*sorted(HERE.glob("table/src/functions/*.rs")), HERE / "src/dynamics/mod.rs")]
    writer = Writer(sources)
    entries = [own for text in sources.values() for own in entries_of(text)]
    functions = [own for own in entries if not own.owner]
    functions += [own for text in table for own in entries_of_table(text) if "|s" not in text]
    lines = [HEADER]
    by_name = {f"_base_{own.name}" for own in functions}  # called by their names alone, in `BaseVelocity`
    lines += (writer.entry(own) for own in functions if own.name not in by_name)
    lines.append("class BaseFunctions:\n    \"\"\"Methods of `BaseVelocity`.\"\"\"\n")
    lines += [re.sub(r"^(?=.)", "    ", writer.entry(own), flags=re.M) for own in base_functions(functions)]
    for rust, name in list(writer.classes.items())[1:]:
        own = sorted((x for x in entries if x.owner == rust and x.name not in HIDDEN), key=place)
        members = list(map(writer.entry, own))
        lines.append(("" if rust in writer.subclassed else "@final\n") + f"class {name}:" + ("" if members else " ..."))
        lines += [re.sub(r"^(?=.)", "    ", member, flags=re.M) for member in members]
    return "\n".join(lines) + "\n"


#: Methods that all objects have.
HIDDEN = ("__repr__", "__reduce__", "__eq__", "__hash__")

if __name__ == "__main__":
    # In a source distribution the modules are beside this folder.
    module = next(own for own in (HERE / "dualbody", HERE.parent / "dualbody") if own.is_dir())
    (module / "_dualbody.pyi").write_text(stubs(), encoding="utf-8")
