"""The reach of `reach.rs` by Crocoddyl's FDDP, beside this crate, in one run on one core.

    pip install crocoddyl==3.1.0 pin==3.8.0 "numpy<2.4,>=2.3" "cmeel-urdfdom<5" "cmeel-tinyxml2<11"
    export RUSTFLAGS="-C target-cpu=native"
    cargo bench --bench reach --no-run                       # prints the path of the program
    taskset -c 0 python benches/peers/reach.py PROGRAM panda.urdf [REPETITIONS]

Panda with free fingers (9 joints), 100 steps of 10 ms of semi-implicit Euler, from rest at zero; running cost (times the time step):
position of `panda_hand` from (0.4, 0.3, 0.5) m with the weight 1, state 1e-4, input 1e-4; position 1e3 at the end. Both start from
states at rest and inputs of zero and take turns; of each turn the fastest of three solutions counts, and
the ratio is that of the medians. Crocoddyl's wheel is built for a generic CPU.
"""

import statistics
import subprocess
import sys
import time

import crocoddyl
import numpy as np
import pinocchio as pin

STEPS, DT = 100, 0.01
# As in reach.rs.
ROUNDS, ITERATIONS = 3, 300
TARGET = np.array([0.4, 0.3, 0.5])


def problem(urdf):
    model = pin.buildModelFromUrdf(urdf)
    state = crocoddyl.StateMultibody(model)
    actuation = crocoddyl.ActuationModelFull(state)
    frame = model.getFrameId("panda_hand")
    hand = crocoddyl.CostModelResidual(state, crocoddyl.ResidualModelFrameTranslation(state, frame, TARGET))
    rest = np.concatenate([np.zeros(model.nq), np.zeros(model.nv)])
    regular = crocoddyl.CostModelResidual(state, crocoddyl.ResidualModelState(state, rest, actuation.nu))
    effort = crocoddyl.CostModelResidual(state, crocoddyl.ResidualModelControl(state, actuation.nu))
    running, terminal = crocoddyl.CostModelSum(state), crocoddyl.CostModelSum(state)
    running.addCost("hand", hand, 1.0)
    running.addCost("state", regular, 1e-4)
    running.addCost("input", effort, 1e-4)
    terminal.addCost("hand", hand, 1e3)

    def action(costs, dt):
        free = crocoddyl.DifferentialActionModelFreeFwdDynamics(state, actuation, costs)
        return crocoddyl.IntegratedActionModelEuler(free, dt)

    return crocoddyl.ShootingProblem(rest, [action(running, DT)] * STEPS, action(terminal, 0.0)), rest


def peer(shooting, rest):
    solver = crocoddyl.SolverFDDP(shooting)
    states = [rest] * (STEPS + 1)
    inputs = [np.zeros(shooting.runningModels[0].nu)] * STEPS
    fastest = float("inf")
    for _ in range(ROUNDS):
        start = time.perf_counter()
        converged = solver.solve(states, inputs, ITERATIONS)
        fastest = min(fastest, time.perf_counter() - start)
        assert converged
    return solver.iter, solver.cost, 1e3 * fastest / solver.iter


def own(program, urdf):
    lines = subprocess.run([program, urdf], check=True, capture_output=True, text=True).stdout.split("\n")
    values = dict(line.split() for line in lines if line)
    return int(values["iterations"]), float(values["cost"]), float(values["ms_per_iteration"])


def main():
    program, urdf = sys.argv[1:3]
    repetitions = int(sys.argv[3]) if len(sys.argv) > 3 else 9
    shooting, rest = problem(urdf)
    theirs, ours = [], []
    for _ in range(repetitions):
        theirs.append(peer(shooting, rest))
        ours.append(own(program, urdf))
    for name, runs in [("crocoddyl", theirs), ("dualbody", ours)]:
        iterations, cost, _ = runs[0]
        median = statistics.median(run[2] for run in runs)
        print(f"{name:10} {iterations:3} iterations, cost {cost:.7f}, {median:.3f} ms per iteration")
    a, b = (statistics.median(run[2] for run in runs) for runs in [ours, theirs])
    print(f"ratio {a / b:.2f}; costs differ by {abs(ours[0][1] / theirs[0][1] - 1):.1e}")


main()
