"""The reach of `reach.rs` by Crocoddyl's FDDP, or BoxFDDP where efforts are limited, beside this crate, in one run on one core.

    pip install crocoddyl==3.1.0 pin==3.8.0 "numpy<2.4,>=2.3" "cmeel-urdfdom<5" "cmeel-tinyxml2<11"
    export RUSTFLAGS="-C target-cpu=native"
    cargo bench --bench reach --no-run                       # prints the path of the program
    taskset -c 0 python benches/peers/reach.py PROGRAM panda.urdf [REPETITIONS [SHARE ...]]

Panda with free fingers (9 joints), 100 steps of 10 ms of semi-implicit Euler, from rest at zero; running cost (times the time step):
position of `panda_hand` from (0.4, 0.3, 0.5) m with the weight 1, state 1e-4, input 1e-4; position 1e3 at the end. Each SHARE bounds the
inputs to this share of the efforts that the file allows. Both start from states at rest and inputs of zero, stop at the same expected
improvement (BoxFDDP by itself would stop at 5e-5) and take turns; of each turn the fastest of three solutions counts, and the ratio is
that of the medians. Crocoddyl's wheel is built for a generic CPU.
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
ROUNDS, ITERATIONS, TOLERANCE = 3, 2000, 1e-9
TARGET = np.array([0.4, 0.3, 0.5])


def problem(urdf, share):
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
        action = crocoddyl.IntegratedActionModelEuler(free, dt)
        if share is not None:
            action.u_lb, action.u_ub = -share * model.effortLimit, share * model.effortLimit
        return action

    return crocoddyl.ShootingProblem(rest, [action(running, DT)] * STEPS, action(terminal, 0.0)), rest


def peer(shooting, rest, share):
    solver = crocoddyl.SolverFDDP(shooting) if share is None else crocoddyl.SolverBoxFDDP(shooting)
    solver.th_stop = TOLERANCE
    states = [rest] * (STEPS + 1)
    inputs = [np.zeros(shooting.runningModels[0].nu)] * STEPS
    fastest = float("inf")
    for _ in range(ROUNDS):
        start = time.perf_counter()
        converged = solver.solve(states, inputs, ITERATIONS)
        fastest = min(fastest, time.perf_counter() - start)
        assert converged
    return solver.iter, solver.cost, 1e3 * fastest / solver.iter


def own(program, urdf, share):
    command = [program, urdf] + ([] if share is None else [str(share)])
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split("\n")
    values = dict(line.split() for line in lines if line)
    return int(values["iterations"]), float(values["cost"]), float(values["ms_per_iteration"])


def compare(program, urdf, repetitions, share):
    shooting, rest = problem(urdf, share)
    theirs, ours = [], []
    for _ in range(repetitions):
        theirs.append(peer(shooting, rest, share))
        ours.append(own(program, urdf, share))
    print("without limits" if share is None else f"efforts within {share} of their limits")
    for name, runs in [("crocoddyl", theirs), ("dualbody", ours)]:
        iterations, cost, _ = runs[0]
        median = statistics.median(run[2] for run in runs)
        print(f"{name:10} {iterations:3} iterations, cost {cost:.7f}, {median:.3f} ms per iteration")
    a, b = (statistics.median(run[2] for run in runs) for runs in [ours, theirs])
    print(f"ratio {a / b:.2f}; costs differ by {ours[0][1] / theirs[0][1] - 1:+.1e}")


def main():
    program, urdf = sys.argv[1:3]
    repetitions = int(sys.argv[3]) if len(sys.argv) > 3 else 9
    for share in [float(share) for share in sys.argv[4:]] or [None]:
        compare(program, urdf, repetitions, share)


main()
