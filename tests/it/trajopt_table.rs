//! How many iterations each way of solving takes on each problem: a table that changes only on purpose.

use dualbody::trajopt::{
    Constraint, Curvature, Ddp, DdpOptions, Dynamics, Problem, StateError, Trajectory,
};

use crate::common::problems::{counter, masses, reach, swing, tree};

/// Iterations from the resting guess, by the Hessian of Gauss and Newton and the exact one; in the last two columns from a guess with gaps.
const TABLE: &str = "
problem              gauss-newton        exact  gaps, g.-n.  gaps, exact
masses                          1            1            1            1
counter                         0            0            1            1
pendulum                        8            8            8            7
pendulum, bounded              24           22           27           27
pendulum, fixed end            13           13           13           14
arm                            25           22           21           20
tree                            9            3            9            4
";

/// Where the guess has gaps, by how much its states are moved, m or rad.
const SHAKE: f64 = 0.1;

/// The resting guess, its states moved to and fro.
fn shaken<D: Dynamics>(problem: &Problem<D>, by: f64) -> Trajectory {
    let dynamics = problem.dynamics();
    let mut guess = Trajectory::resting(problem);
    for (k, x) in guess.states.iter_mut().enumerate() {
        let moved = |i: usize| by * ((k * 5 + i) as f64).sin();
        let dx: Vec<f64> = (0..dynamics.ndx()).map(moved).collect();
        let start = x.clone();
        dynamics.integrate(start.as_slice(), &dx, x.as_mut_slice());
    }
    guess
}

/// Iterations of one way, or why there are none.
fn iterations<D: Dynamics>(problem: &Problem<D>, curvature: Curvature, shake: f64) -> String {
    let options = DdpOptions {
        curvature,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(problem, options);
    let solution = ddp.solve(problem, &shaken(problem, shake));
    match solution.is_converged() {
        true => solution.iterations.to_string(),
        false => solution.status.to_string(),
    }
}

fn row<D: Dynamics>(name: &str, problem: &Problem<D>) -> String {
    let mut line = format!("{name:20}");
    for (curvature, shake) in [
        (Curvature::GaussNewton, 0.0),
        (Curvature::Exact, 0.0),
        (Curvature::GaussNewton, SHAKE),
        (Curvature::Exact, SHAKE),
    ] {
        line += &format!(" {:>12}", iterations(problem, curvature, shake));
    }
    line + "\n"
}

#[test]
fn iteration_counts_equal_the_table() {
    let bounded = swing(40).with_input_bounds(&[-4.0], &[4.0]);
    let free = swing(60);
    let arrive = Constraint::equal_to_zero(free.dynamics(), StateError::to(&[3.0, 0.0]));
    let fixed_end = free.with_final_constraint(arrive);
    let head = [
        "problem",
        "gauss-newton",
        "exact",
        "gaps, g.-n.",
        "gaps, exact",
    ];
    let [problem, a, b, c, d] = head;
    let table = format!("\n{problem:20} {a:>12} {b:>12} {c:>12} {d:>12}\n")
        + &row("masses", &masses(30))
        + &row("counter", &counter(10, 1.0))
        + &row("pendulum", &swing(40))
        + &row("pendulum, bounded", &bounded)
        + &row("pendulum, fixed end", &fixed_end)
        + &row("arm", &reach(25))
        + &row("tree", &tree(3));
    assert_eq!(table, TABLE, "{table}");
}
