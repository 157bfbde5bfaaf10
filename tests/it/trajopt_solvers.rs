//! Properties of all solvers, through the one trait that calls them; and systems of users, with memory of their
//! own and without a rate.

use crate::common::OTHER_ALGORITHM;
use dualbody::model::samples;
use dualbody::trajopt::{
    Activation, Constraint, Cost, Ddp, DdpOptions, FramePosition, InputError, Problem, Progress,
    Robot, Scratch, ShootingOptions, SingleShooting, Solution, Solver, StateError, Status, System,
    Trajectory,
};
use dualbody::{Scalar, Simulator};

/// A tank that the input fills, in steps of 0.1 s, from which a share of `leak` runs out in a second.
struct Tank {
    leak: f64,
}

const DT: f64 = 0.1;
const HORIZON: usize = 20;

impl System for Tank {
    fn nx(&self) -> usize {
        1
    }
    fn nu(&self) -> usize {
        1
    }
    fn time_step(&self) -> f64 {
        DT
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        next[0] = x[0] + (u[0] - x[0] * self.leak) * DT;
    }
    fn rate<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, rate: &mut [T]) {
        rate[0] = u[0] - x[0] * self.leak;
    }
}

/// To three in 2 s, with the least effort.
fn filling(leak: f64) -> Problem {
    let effort = Cost::new().with(2.0, Activation::Quadratic, InputError::to(&[0.0]));
    let full = Constraint::equal_to_zero(&Tank { leak }, StateError::to(&[3.0]));
    Problem::new(Tank { leak }, HORIZON, &[0.0])
        .with_stage_cost(effort)
        .with_final_constraint(full)
}

/// Solves through the trait, checks the properties of every solution, and returns the solution.
fn solve<S: Solver>(name: &str, solver: &mut S, problem: &Problem) -> Solution<S::Own> {
    let mut reports: Vec<Progress> = Vec::new();
    let guess = Trajectory::zero_input(problem);
    let solution = solver.solve_with(problem, &guess, &mut |progress| reports.push(*progress));
    assert!(solution.is_converged(), "{name}: {}", solution.status);
    assert_eq!(reports.len(), solution.iterations, "{name}");
    assert_eq!(solution.cost_history.len(), reports.len() + 1, "{name}");
    assert_eq!(
        solution.trajectory.states.len(),
        problem.horizon() + 1,
        "{name}"
    );
    assert!(
        reports
            .iter()
            .enumerate()
            .all(|(k, at)| at.iteration == k + 1),
        "{name}"
    );
    assert!(solution.violation <= 1e-6 && solution.gap <= 1e-6, "{name}");
    let again = solver.solve(problem, &guess);
    assert_eq!(
        (again.cost, again.iterations),
        (solution.cost, solution.iterations),
        "{name}"
    );
    solution
}

// u = 3 / 2 all the time: a cost of 2 · ½ u² · 2 s = 4.5, which grows with the goal c as c²/2 by c = 3, and λ = −3.
#[test]
fn every_solver_finds_the_effort_and_its_slope_in_the_goal() {
    let problem = filling(0.0);
    let ddp = solve("Ddp", &mut Ddp::new(&problem), &problem);
    let shooting = solve("shooting", &mut SingleShooting::new(&problem), &problem);
    let check = |name: &str, cost: f64, trajectory: &Trajectory, lambda: f64| {
        assert!((cost - 4.5).abs() < 1e-4, "{name}: {cost}");
        assert!((lambda + 3.0).abs() < 1e-3, "{name}: {lambda}");
        assert!(
            trajectory.inputs.iter().all(|u| (u[0] - 1.5).abs() < 1e-3),
            "{name}"
        );
    };
    check(
        "Ddp",
        ddp.cost,
        &ddp.trajectory,
        ddp.multipliers[HORIZON][0],
    );
    check(
        "shooting",
        shooting.cost,
        &shooting.trajectory,
        shooting.multipliers[HORIZON][0],
    );
    #[cfg(feature = "transcription")]
    {
        let mut solver = dualbody::trajopt::Transcription::new();
        let found = solve("transcription", &mut solver, &problem);
        let lambda = found.multipliers[2 * HORIZON][0];
        check("transcription", found.cost, &found.trajectory, lambda);
    }
    assert_eq!(ddp.gains.len(), HORIZON);
    assert_eq!(shooting.variables.len(), HORIZON);
}

#[test]
fn single_shooting_solves_another_problem_than_its_own() {
    let (own, other) = (filling(0.0), filling(0.3));
    let through = solve("another", &mut SingleShooting::new(&own), &other);
    let direct = solve("own", &mut SingleShooting::new(&other), &other);
    assert_eq!(
        (through.cost, &through.variables),
        (direct.cost, &direct.variables)
    );
    assert!(direct.cost > 5.0, "a leak costs");
}

#[test]
fn every_solver_stops_at_its_limit_of_iterations() {
    let problem = filling(0.3);
    let guess = Trajectory::zero_input(&problem);
    let ddp = DdpOptions {
        max_iterations: 1,
        ..DdpOptions::default()
    };
    let shooting = ShootingOptions {
        max_iterations: 1,
        ..ShootingOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, ddp);
    let mut shooting = SingleShooting::with_options(&problem, shooting);
    for (status, iterations) in [
        Solver::solve(&mut ddp, &problem, &guess).outcome(),
        Solver::solve(&mut shooting, &problem, &guess).outcome(),
    ] {
        assert_eq!((status, iterations), (Status::IterationLimit, 1));
    }
}

/// How a solution ended, and after how many iterations.
trait Outcome {
    fn outcome(&self) -> (Status, usize);
}

impl<S> Outcome for Solution<S> {
    fn outcome(&self) -> (Status, usize) {
        (self.status, self.iterations)
    }
}

/// A simulator behind an actuator that applies twice its input, with the simulator's workspace inside its own.
struct Doubled(Simulator);

struct Memory<T> {
    u: Vec<T>,
    inner: Scratch,
}

impl System for Doubled {
    dualbody::forward_system!(0: nx, ndx, nu, time_step, robot, integrate, difference);

    fn step<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, next: &mut [T]) {
        let Memory { u: doubled, inner } = scratch.get(|| Memory {
            u: vec![T::zero(); u.len()],
            inner: Scratch::new(),
        });
        doubled
            .iter_mut()
            .zip(u)
            .for_each(|(out, &u)| *out = u * 2.0);
        System::step(&self.0, x, doubled, inner, next);
    }
}

impl Robot for Doubled {}

fn reach(dynamics: impl Robot, price: f64) -> Problem {
    let tool = dynamics.model().frame("tool").expect("the arm has a tool");
    let target = || FramePosition::new(tool, [0.5, 0.3, 0.6]);
    let running = Cost::new()
        .with(
            1e-3,
            Activation::Quadratic,
            StateError::to_neutral(&dynamics),
        )
        .with(price, Activation::Quadratic, InputError::to_zero(&dynamics));
    let last = Cost::new().with(1e3, Activation::Quadratic, target());
    let start = [0.1; 14];
    Problem::new(dynamics, 15, &start)
        .with_stage_cost(running)
        .with_final_cost(last)
}

// Where each unit of input does twice as much and costs four times as much, the same motion is the best, for the same
// cost.
#[test]
fn simulator_inside_a_system_of_a_user_moves_as_it_does_alone() {
    let arm = Simulator::new(samples::arm()).with_time_step(0.02);
    let (alone, inside) = (reach(arm.clone(), 1e-4), reach(Doubled(arm), 4e-4));
    let tight = DdpOptions {
        tolerance: 1e-13,
        ..DdpOptions::default()
    };
    let mut solver = Ddp::with_options(&alone, tight.clone());
    let alone = solve("alone", &mut solver, &alone);
    let inside = solve("inside", &mut Ddp::with_options(&inside, tight), &inside);
    let far = (alone.cost / inside.cost - 1.0).abs();
    assert!(far < OTHER_ALGORITHM, "{} {}", alone.cost, inside.cost);
    let both = alone.trajectory.inputs.iter();
    for (a, b) in both.zip(&inside.trajectory.inputs) {
        assert!((a - b * 2.0).amax() < 1e-4 * a.amax().max(1.0), "{a} {b}");
    }
}

/// A counter that has steps only.
#[cfg(feature = "transcription")]
#[test]
#[should_panic(expected = "has steps, but no rate")]
fn transcription_of_a_system_without_a_rate_panics() {
    let problem = crate::common::problems::counter(3, 1.0);
    dualbody::trajopt::Transcription::new().solve(&problem, &Trajectory::zero_input(&problem));
}
