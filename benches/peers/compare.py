"""Runs the three programs in turn and prints the table of ratios, as markdown; `run.sh` builds them and calls this.

    compare.py FOLDER OUR_PROGRAM REPETITIONS FLAGS...

A ratio is the median over the repetitions of ours/theirs in the same repetition: the programs run directly after one another, so
what else the machine does slows both. Below 1 ours is faster.
"""

import os
import pathlib
import platform
import subprocess
import sys
from datetime import date
from statistics import median

import models

# What, our name, whose, their names: the fastest counts.
QUANTITIES = [
    ("inverse dynamics (RNEA)", "rnea", "pinocchio", ["rnea"]),
    ("mass matrix (CRBA)", "crba", "pinocchio", ["crba_world", "crba_local"]),
    ("forward dynamics (ABA)", "aba", "pinocchio", ["aba_world", "aba_local"]),
    ("∂ inverse dynamics", "inverse_dynamics_derivatives", "pinocchio", ["rnea_derivatives"]),
    ("∂ forward dynamics", "forward_dynamics_derivatives", "pinocchio", ["aba_derivatives"]),
    ("∂ step / ∂ forward dynamics", "linearize", "pinocchio", ["aba_derivatives"]),
    ("step", "step", "mujoco", ["step"]),
    ("∂ step", "linearize", "mujoco", ["transition_fd"]),
]
ENGINES = {"pinocchio": "Pinocchio", "mujoco": "MuJoCo"}
# Masses are sums of the same numbers, in another order and printed with six digits.
SAME_MASS = 1e-5


def main():
    folder, ours = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    repetitions, flags = int(sys.argv[3]), sys.argv[4:]
    (folder / "models").mkdir(exist_ok=True)
    load = os.getloadavg()[0]
    results = {}
    for name, file, base in models.ROBOTS:
        path, stem = models.urdf(file), folder / "models" / name
        models.write_pinocchio(path, base, f"{stem}.txt")
        models.write_mujoco(path, base, f"{stem}.mjb")
        programs = {
            "ours": [ours, path, base],
            "pinocchio": [folder / "pinocchio_times", f"{stem}.txt"],
            "mujoco": [folder / "mujoco_times", f"{stem}.mjb"],
        }
        results[name] = [{who: run(program, folder) for who, program in programs.items()} for _ in range(repetitions)]
        check_same(name, results[name][0])
        print(f"{name} done", file=sys.stderr)
    print_machine(flags, load, repetitions)
    print_table(results)


def run(program, folder):
    """In the folder, since MuJoCo writes its log where it is."""
    done = subprocess.run([str(word) for word in program], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{program[0]} failed:\n{done.stderr}")
    return {name: float(value) for name, value in (line.split() for line in done.stdout.splitlines())}


def check_same(name, result):
    """A ratio of times of different robots would say nothing."""
    for who, theirs in result.items():
        for key in ["nv", "mass"]:
            if abs(theirs[key] / result["ours"][key] - 1) > SAME_MASS:
                sys.exit(f"{name} is another robot in {who}: {key} = {theirs[key]}, ours {result['ours'][key]}")


def print_machine(flags, load, repetitions):
    versions = f"Pinocchio {models.pin.__version__}, MuJoCo {models.mujoco.__version__}"
    dirty = " with changes" if output("git", "status", "--porcelain") else ""
    print(f"- {date.today()}, commit {output('git', 'rev-parse', '--short', 'HEAD')}{dirty}, {versions}")
    print(f"- {cpu()}, {os.cpu_count()} cores, load {load:.1f} before the start; median of {repetitions} repetitions")
    print(f"- {output('rustc', '--version')}, {output('c++', '--version').splitlines()[0]}")
    print("\n".join(f"- {flag}" for flag in flags))


def cpu():
    """The model, and what it is compiled for: virtual machines like to hide the name."""
    fields = dict(line.split(":", 1) for line in output("lscpu").splitlines() if ":" in line)
    names = ["Model name", "CPU family", "Model", "Stepping"]
    model, family, number, stepping = (fields.get(name, "?").strip() for name in names)
    vectors = "AVX-512" if "avx512f" in fields.get("Flags", "") else "AVX2" if "avx2" in fields.get("Flags", "") else "SSE"
    return f"{model} (family {family}, model {number}, stepping {stepping}, {vectors}), {platform.system()}"


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def print_table(results):
    heads = [f"{name} ({int(rounds[0]['ours']['nv'])})" for name, rounds in results.items()]
    print("\nµs ours / theirs = **ratio**; in brackets the degrees of freedom\n")
    print(f"| | against | {' | '.join(heads)} |")
    print("|---|---|" + "---|" * len(heads))
    for what, our_name, engine, their_names in QUANTITIES:
        cells = [cell(rounds, our_name, engine, their_names) for rounds in results.values()]
        print(f"| {what} | {ENGINES[engine]} | {' | '.join(cells)} |")


def cell(rounds, our_name, engine, their_names):
    pairs = [(r["ours"][our_name], min(r[engine][name] for name in their_names)) for r in rounds]
    ours, theirs = (median(column) for column in zip(*pairs))
    ratio = median(a / b for a, b in pairs)
    return f"{digits(ours)} / {digits(theirs)} = **{ratio:.2f}**"


def digits(x):
    """Three of them, and never an exponent."""
    return f"{x:.3g}" if x < 1000 else f"{x:.0f}"


if __name__ == "__main__":
    main()
