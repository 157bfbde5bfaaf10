"""C that this crate generates beside C that CasADi generates of Pinocchio's templates, compiled alike, timed in one process.

    python -m venv VENV && VENV/bin/pip install pin==4.1.0 casadi==3.8.2 cmeel-eigen example-robot-data==5.0.0 mujoco==4.0.0
    cargo bench --features graphs --bench generated --no-run     # prints the path of the program
    VENV/bin/python benches/peers/generated.py PROGRAM FOLDER [REPETITIONS [ROBOT...]]

Needs `c++` and `cc`. Into FOLDER go a program that makes CasADi's code (its templates take three minutes to compile), the code, libraries. Everything comes
from PyPI; MuJoCo only because `models.py` has it. All functions are compiled with `-O3`, twice: for the instruction set of this machine
and for `x86-64-v3`, which has AVX2 and fused products, and not AVX-512. Values are compared, so that both are the same functions.

CasADi's derivatives are made in two ways, of which the faster counts: Pinocchio's algorithms over expressions, and CasADi's own differentiation. A and B of a
step are set beside the derivatives of forward dynamics, from which one would make them. A fused product counts as one operation with us.
"""

import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from statistics import median

import numpy as np

from compare import cpu, digits, output
import models

HERE = pathlib.Path(__file__).resolve().parent
FLAGS = ["-O3", "-std=gnu11", "-fPIC", "-shared", "-DNDEBUG"]
MACHINES = ["native", "x86-64-v3"]
# What, our function, theirs.
ROWS = [
    ("inverse dynamics (RNEA)", "ours/rnea", ["theirs/rnea"]),
    ("forward dynamics (ABA)", "ours/aba", ["theirs/aba"]),
    ("∂ inverse dynamics", "ours/rnea_derivatives", ["theirs/rnea_recursive", "theirs/rnea_automatic"]),
    ("∂ step / ∂ forward dynamics", "ours/linearization", ["theirs/aba_recursive", "theirs/aba_automatic"]),
]
SIDES = ["ours", "theirs"]
N_POINTS = 64
# Largest difference of values relative to the largest value of a function.
TOLERANCE = 1e-10
# Pinocchio's list of joints is longer than what Boost takes without being asked.
DEFINITIONS = ["BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "BOOST_MPL_LIMIT_LIST_SIZE=30", "BOOST_MPL_LIMIT_VECTOR_SIZE=30", "BOOST_FUSION_INVOKE_MAX_ARITY=12"]


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{command[0]} failed:\n{done.stderr[-4000:]}")
    return done.stdout


def newer(target, *sources):
    return target.exists() and all(target.stat().st_mtime > source.stat().st_mtime for source in sources)


def generator(folder):
    """The program that makes CasADi's code. Its own speed does not matter."""
    target, source = folder / "casadi_code", HERE / "casadi.cpp"
    if not newer(target, source):
        import casadi

        prefix, casadi = pathlib.Path(models.pin.__file__).resolve().parents[4], pathlib.Path(casadi.__file__).parent
        include = [f"-isystem{folder}" for folder in [prefix / "include", prefix / "include" / "eigen3", casadi / "include"]]
        libraries = [f"-L{prefix}/lib", "-lboost_serialization", f"-L{casadi}", "-lcasadi", f"-Wl,-rpath,{prefix}/lib:{casadi}"]
        run("c++", "-std=c++17", "-w", "-O0", "-DNDEBUG", *(f"-D{word}" for word in DEFINITIONS), *include, source, "-o", target, *libraries)
    return target


def timer(folder):
    target, source = folder / "generated_times", HERE / "generated_times.cpp"
    if not newer(target, source, HERE / "timing.hpp"):
        run("c++", "-std=c++17", "-O2", source, "-o", target, "-ldl")
    return target


class Robot:
    """Code, joints and points of a robot."""

    def __init__(self, name, file, base, program, folder):
        self.title, self.name, self.folder, self.floats = name, name.lower(), folder / name, base == "floating"
        path, text = models.urdf(file), self.folder / "model.txt"
        for side in SIDES:
            (self.folder / side).mkdir(parents=True, exist_ok=True)
        models.write_pinocchio(path, base, text)
        root = [models.pin.JointModelFreeFlyer()] if self.floats else []
        self.model = models.pin.buildModelFromUrdf(str(path), *root)
        theirs = run(generator(folder), text, self.name, self.folder / "theirs")
        self.operations = {f"theirs/{line.split()[0]}": int(line.split()[1]) for line in theirs.splitlines()}
        self.read(run(program, path, base, self.name, self.folder / "ours"))
        self.write_points()

    def read(self, text):
        """What our program prints: sizes, mass, operations, where the coordinates of joints are."""
        self.joints = {}
        for line in text.splitlines():
            match line.split():
                case ["joint", name, q, v]:
                    self.joints[name] = (int(q), int(v))
                case ["operations", name, number]:
                    self.operations[f"ours/{name}"] = int(number)
                case [key, number]:
                    setattr(self, key, float(number))
        mass = sum(inertia.mass for inertia in list(self.model.inertias)[1:])
        assert self.nv == self.model.nv and abs(self.mass / mass - 1) < 1e-5, f"{self.name} is another robot"
        names = list(self.model.names)[1 + self.floats :]
        # Where each of Pinocchio's velocities is with us.
        self.order = list(range(6 * self.floats)) + [self.joints[name][1] for name in names]

    def write_points(self):
        """The same random states in the order of each side."""
        rng = np.random.default_rng(1)
        points = [self.point(rng) for _ in range(N_POINTS)]
        nq = [self.nq, self.model.nq]
        for k, side in enumerate(SIDES):
            rows = [point[k] for point in points]
            np.concatenate([[nq[k], self.nv], *rows]).tofile(self.folder / f"{side}.points")

    def point(self, rng):
        model, first = self.model, 1 + self.floats
        q, theirs = np.zeros(int(self.nq)), []
        if self.floats:
            quaternion = rng.normal(size=4)
            q[:3], q[3:7] = rng.uniform(-1, 1, 3), quaternion / np.linalg.norm(quaternion)
            theirs = [*q[:3], *q[4:7], q[3]]
        for name, width in zip(list(model.names)[first:], list(model.nqs)[first:]):
            angle = rng.uniform(-3, 3)
            q[self.joints[name][0]] = angle
            theirs += [angle] if width == 1 else [np.cos(angle), np.sin(angle)]
        v, x = rng.uniform(-1, 1, (2, model.nv))
        own = np.zeros((2, model.nv))
        own[:, self.order] = v, x
        return np.concatenate([q, *own]), np.concatenate([theirs, v, x])

    def compile(self, machine):
        """All functions for a kind of machine, as the timer takes them: those of a row together, so that both sides are measured within a second."""
        words, target = [], self.folder / machine
        target.mkdir(exist_ok=True)
        for name in [name for _, own, others in ROWS for name in [own, *self.ways(others)]]:
            side, _, what = name.partition("/")
            source = self.folder / side / f"{self.name}_{what}.c"
            # The text is written anew each time, and takes minutes to compile.
            library = target / f"{side}_{what}_{hashlib.sha256(source.read_bytes()).hexdigest()[:8]}.so"
            if not library.exists():
                run("cc", *FLAGS, f"-march={machine}", source, "-o", library, "-lm")
            size = f":{self.outputs(what)}" if side == "ours" else ""
            words.append(f"{name}={library}:{self.name}_{what}{size}")
        return words

    def ways(self, names):
        """Those of two ways to derivatives that may be the faster: one with over twice the operations of the other is not, and takes minutes to compile."""
        least = min(self.operations[name] for name in names)
        return [name for name in names if self.operations[name] <= 2 * least]

    def outputs(self, what):
        header = (self.folder / "ours" / f"{self.name}_{what}.h").read_text()
        return int(re.search(r"_OUT_SIZE (\d+)", header)[1])

    def times(self, words, folder):
        """Of fresh copies of the libraries: one was seen to take 2.5 times as long as another with the same bytes, for as long as it lay in the same memory."""
        points = [self.folder / f"{side}.points" for side in SIDES]
        with tempfile.TemporaryDirectory(dir=folder) as copies:
            fresh = []
            for word in words:
                name, library, function = re.match("([^=]*)=([^:]*):(.*)", word).groups()
                copy = shutil.copy(library, copies)
                fresh.append(f"{name}={copy}:{function}")
            lines = run(timer(folder), *points, self.folder / "values", *fresh).splitlines()
        return {name: float(time) for name, time in (line.split() for line in lines)}

    def check(self, words, folder):
        """A ratio of times of different functions would say nothing: values of RNEA, ABA and the derivatives of RNEA."""
        nv = self.model.nv
        for own, other in [("ours/rnea", "theirs/rnea"), ("ours/aba", "theirs/aba"), ("ours/rnea_derivatives", "theirs/rnea_recursive")]:
            self.times([word for word in words if word.split("=")[0] in [own, other]], folder)
            values = np.fromfile(self.folder / "values")
            size = self.outputs(own.split("/")[1]) * N_POINTS
            a, b = values[:size].reshape(N_POINTS, -1, nv), values[size:]
            b = b.reshape(a.shape)
            # Rows of the last axis are one matrix's columns; the columns are joints as well where there is more than one.
            a = a[:, :, self.order]
            if a.shape[1] > 1:
                a = np.concatenate([part[:, self.order] for part in np.split(a, 3, axis=1)], axis=1)
            error = np.abs(a - b).max() / np.abs(b).max()
            print(f"{self.name} {own}: largest difference {error:.1e}", file=sys.stderr)
            if error > TOLERANCE:
                sys.exit(f"{self.name}: {own} and {other} differ by {error:.1e}")


def print_table(robots, results, machine):
    print(f"\n`-march={machine}`, µs ours / CasADi = **ratio**, in brackets operations\n")
    print("| | " + " | ".join(f"{robot.title} ({int(robot.nv)})" for robot in robots) + " |")
    print("|---" * (len(robots) + 1) + "|")
    for what, own, others in ROWS:
        print(f"| {what} | " + " | ".join(cell(robot, results[robot.name], own, others) for robot in robots) + " |")


def cell(robot, rounds, own, others):
    best = min(robot.ways(others), key=lambda other: median(times[other] for times in rounds))
    ours, theirs = (median(times[name] for times in rounds) for name in [own, best])
    ratio = median(times[own] / times[best] for times in rounds)
    return f"{digits(ours)} / {digits(theirs)} = **{ratio:.2f}** ({robot.operations[own]} / {robot.operations[best]})"


def main():
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    repetitions = int(sys.argv[3]) if len(sys.argv) > 3 else 9
    names = sys.argv[4:] or ["Panda", "UR5", "HyQ"]
    folder.mkdir(parents=True, exist_ok=True)
    robots = [Robot(*own, program, folder) for own in models.ROBOTS if own[0] in names]
    words = {machine: [robot.compile(machine) for robot in robots] for machine in MACHINES}
    for robot, own in zip(robots, words["native"]):
        robot.check(own, folder)
    print(f"- {cpu()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}; median of {repetitions} repetitions")
    print(f"- commit {output('git', 'rev-parse', '--short', 'HEAD')}, {output('cc', '--version').splitlines()[0]}, `{' '.join(FLAGS)}`")
    for machine in MACHINES:
        results = {robot.name: [robot.times(own, folder) for _ in range(repetitions)] for robot, own in zip(robots, words[machine])}
        print_table(robots, results, machine)


if __name__ == "__main__":
    main()
