//! Alarms: iterations that each way of solving takes on each problem, as they were measured when the tables were made.
//! The numbers are golden by themselves, not true by anything else: a change that moves them is to be looked at, and
//! the tables are made anew on purpose.

use dualbody::trajopt::{
    Constraint, Curvature, Ddp, DdpOptions, Minimizer, Problem, ShootingOptions, SingleShooting,
    StateError, Trajectory,
};

use crate::common::problems::{Counter, counter, masses, reach, swing, tree};

/// Iterations from the zero-input guess, by the Hessian of Gauss and Newton and the exact one; in the last two columns
/// from a guess with gaps.
const TABLE: &str = "
problem              gauss-newton        exact  gaps, g.-n.  gaps, exact
masses                          1            1            1            1
counter                         0            0            1            1
pendulum                        8            8            8            7
pendulum, bounded              11           10           11           10
pendulum, fixed end            13           13           13           14
arm                            25           22           21           20
tree                            9            3            9            4
";

/// Distance by which states are moved where the guess has gaps, m or rad.
const SHAKE: f64 = 0.1;

/// The zero-input guess, its states moved to and fro.
fn shaken(problem: &Problem, by: f64) -> Trajectory {
    let dynamics = problem.dynamics();
    let mut guess = Trajectory::zero_input(problem);
    for (k, x) in guess.states.iter_mut().enumerate() {
        let moved = |i: usize| by * ((k * 5 + i) as f64).sin();
        let dx: Vec<f64> = (0..dynamics.ndx()).map(moved).collect();
        let start = x.clone();
        dynamics.integrate(start.as_slice(), &dx, x.as_mut_slice());
    }
    guess
}

/// Iterations of one way, or why there are none.
fn iterations(problem: &Problem, curvature: Curvature, shake: f64) -> String {
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

fn row(name: &str, problem: &Problem) -> String {
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

/// Iterations of single shooting from the zero-input guess, by method; a number, or how it ended after a thousand. A
/// span where rounding decides: the least and the most of 16 guesses whose inputs differ by 1e-13.
const SHOOTING: &str = "
problem                      l-bfgs        descent      newton-cg   trust region
masses                           11             71              2              1
masses, bounded                  72            838              9             19
counter, fixed end                5              5              5              5
pendulum                   203..396 IterationLimit              9             36
arm                  IterationLimit IterationLimit         19..57       132..877
tree                             64 IterationLimit              9              9
";

/// Share by which such a count may be off, beyond one: rounding of other machines moves the longer ones.
const SHARE: f64 = 0.25;

fn shooting_row(name: &str, problem: &Problem) -> String {
    let mut line = format!("{name:20}");
    for minimizer in Minimizer::ALL {
        let options = ShootingOptions {
            max_iterations: 1000,
            ..ShootingOptions::default()
        };
        let mut shooting = SingleShooting::with_options(problem, options);
        let solution = shooting.solve(&Trajectory::zero_input(problem), minimizer);
        let cell = match solution.is_converged() {
            true => solution.iterations.to_string(),
            false => format!("{:?}", solution.status),
        };
        line += &format!(" {cell:>14}");
    }
    line + "\n"
}

fn is_near(cell: &str, expected: &str) -> bool {
    let number = |text: &str| text.parse::<f64>().ok();
    let (least, most) = expected.split_once("..").unwrap_or((expected, expected));
    let span = number(least).zip(number(most)).map(|(least, most)| {
        let margin = |count: f64| 1.0 + SHARE * count;
        least - margin(least)..=most + margin(most)
    });
    match number(cell).zip(span) {
        Some((is, span)) => span.contains(&is),
        None => cell == expected,
    }
}

#[test]
fn alarm_iteration_counts_of_single_shooting_are_near_the_table() {
    let head = ["problem", "l-bfgs", "descent", "newton-cg", "trust region"];
    let [problem, a, b, c, d] = head;
    let arrive = Constraint::equal_to_zero(&Counter, StateError::to(&[1.0]));
    let fixed_end = counter(5, 1.0).with_final_constraint(arrive);
    let bounded = masses(20).with_input_bounds(&[-1.0, -0.3], &[0.5, 1.0]);
    let table = format!("\n{problem:20} {a:>14} {b:>14} {c:>14} {d:>14}\n")
        + &shooting_row("masses", &masses(20))
        + &shooting_row("masses, bounded", &bounded)
        + &shooting_row("counter, fixed end", &fixed_end)
        + &shooting_row("pendulum", &swing(20))
        + &shooting_row("arm", &reach(10))
        + &shooting_row("tree", &tree(5));
    check_near(&table, SHOOTING);
}

fn check_near(table: &str, all: &str) {
    assert_eq!(table.lines().count(), all.lines().count(), "{table}");
    for (line, expected) in table.lines().zip(all.lines()) {
        let cells = line.split_whitespace().zip(expected.split_whitespace());
        let are_near = cells
            .into_iter()
            .all(|(cell, expected)| is_near(cell, expected));
        assert!(are_near, "not near {expected} in {table}");
    }
}

/// The pendulum at a small torque.
fn bounded_swing() -> Problem {
    swing(40).with_input_bounds(&[-4.0], &[4.0])
}

/// The pendulum to a given end.
fn fixed_end_swing() -> Problem {
    let free = swing(60);
    let arrive = Constraint::equal_to_zero(free.dynamics(), StateError::to(&[3.0, 0.0]));
    free.with_final_constraint(arrive)
}

/// Iterations of direct transcription, from the zero-input guess and from one with gaps.
#[cfg(feature = "transcription")]
const TRANSCRIPTION: &str = "
problem                     zero-input           gaps
pendulum                            10             10
pendulum, bounded                   11             11
pendulum, fixed end                 11             11
arm                                 23             28
tree                                 9              9
";

#[cfg(feature = "transcription")]
#[test]
fn alarm_iteration_counts_of_transcription_are_near_the_table() {
    use dualbody::trajopt::Transcription;

    let row = |name: &str, problem: Problem| {
        let cells = [0.0, SHAKE].map(|by| {
            let solution = Transcription::new().solve(&problem, &shaken(&problem, by));
            match solution.is_converged() {
                true => solution.iterations.to_string(),
                false => format!("{:?}", solution.status),
            }
        });
        format!("{name:20} {:>14} {:>14}\n", cells[0], cells[1])
    };
    let [problem, zero_input, gaps] = ["problem", "zero-input", "gaps"];
    let table = format!("\n{problem:20} {zero_input:>14} {gaps:>14}\n")
        + &row("pendulum", swing(40))
        + &row("pendulum, bounded", bounded_swing())
        + &row("pendulum, fixed end", fixed_end_swing())
        + &row("arm", reach(10))
        + &row("tree", tree(5));
    check_near(&table, TRANSCRIPTION);
}

#[cfg(feature = "second-order")]
#[test]
fn alarm_iteration_counts_of_ddp_equal_the_table() {
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
        + &row("pendulum, bounded", &bounded_swing())
        + &row("pendulum, fixed end", &fixed_end_swing())
        + &row("arm", &reach(25))
        + &row("tree", &tree(3));
    assert_eq!(table, TABLE, "{table}");
}
