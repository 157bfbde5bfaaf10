//! Time of a step with dry friction in every joint, beside that of the same robot in the same states without: µs without, and the ratios. In a first line without
//! other actuation, in a second one with the limits of efforts, positions and speeds of the description on both sides.
//!
//! ```sh
//! cargo bench --bench friction
//! ```
//!
//! - *slide*: random velocities of about 1 rad/s, so little friction that every joint keeps moving,
//! - *stop*: the same velocities, so much friction that some joints stop within the step and others do not,
//! - *hold*: at rest, every joint held,
//! - *motion*: states along a motion under waves of joint forces, in which joints stop and break away one after the other.

mod common;

use common::clock::{Clock, is_test};
use common::functions;
use common::points::{Point, points};
use common::robots::{asset, standing};
use dualbody::joint::JointKind;
use dualbody::sim::{Actuation, Actuator, CoulombFriction};
use dualbody::{Model, Simulator, State};

/// Friction of joints, N·m: of *slide*, *stop* and *hold*.
const FRICTION: [f64; 3] = [0.002, 5.0, 1e3];
/// Friction of *motion*, and the amplitude of the waves beside it.
const OF_MOTION: f64 = 1.0;
const AMPLITUDE: f64 = 1.5;
/// Steps between two states of a motion.
const EVERY: usize = 10;
const TIME_STEP: f64 = 1e-3;

fn main() {
    let clock = if is_test() { Clock::ONCE } else { Clock::EXACT };
    println!(
        "{:24}{:>9}{:>8}{:>8}{:>8}{:>8}",
        "", "µs", "slide", "stop", "hold", "motion"
    );
    for name in ["ur5", "panda", "quadruped", "humanoid"] {
        let plain = Simulator::new(asset(name)).with_time_step(TIME_STEP);
        print_row(clock, name, &plain, &points(&plain));
    }
    let (plain, state) = standing();
    let point = Point {
        a: Vec::new(),
        tau: Vec::new(),
        u: vec![0.0; plain.nu()],
        state,
    };
    print_row(clock, "quadruped that stands", &plain, &[point]);
}

/// * `random` – states and inputs of *slide* and *stop*; of *hold* without velocities
fn print_row(clock: Clock, name: &str, plain: &Simulator, random: &[Point<f64>]) {
    let actuation = without_friction(Actuation::from_model(plain.model()));
    let limited = plain.clone().with_actuation(actuation);
    print_ratios(clock, name, plain, random);
    print_ratios(clock, "  with its limits", &limited, random);
}

fn print_ratios(clock: Clock, name: &str, plain: &Simulator, random: &[Point<f64>]) {
    let rest = random.iter().map(at_rest);
    let rest: Vec<_> = rest.collect();
    let motion = motion(plain, &random[0].state);
    let [slide, stop, hold] = FRICTION;
    let ratio = |friction: f64, points: &[Point<f64>]| {
        let with = with_friction(plain, friction);
        let mut pairs: Vec<[f64; 2]> = (0..5)
            .map(|_| [plain, &with].map(|simulator| clock.over(points, functions::step(simulator))))
            .collect();
        pairs.sort_by(|a, b| (a[1] / a[0]).total_cmp(&(b[1] / b[0])));
        pairs[2][1] / pairs[2][0]
    };
    let without = clock.over(random, functions::step(plain));
    println!(
        "{name:24}{:9.3}{:8.2}{:8.2}{:8.2}{:8.2}",
        without * 1e6,
        ratio(slide, random),
        ratio(stop, random),
        ratio(hold, &rest),
        ratio(OF_MOTION, &motion)
    );
}

fn at_rest(point: &Point<f64>) -> Point<f64> {
    let mut state = point.state.clone();
    state.v.fill(0.0);
    Point {
        state,
        a: Vec::new(),
        tau: Vec::new(),
        u: vec![0.0; point.u.len()],
    }
}

/// States of a motion under waves of joint forces, of another frequency in each joint.
fn motion(plain: &Simulator, start: &State) -> Vec<Point<f64>> {
    let simulator = with_friction(plain, OF_MOTION);
    let input = |time: f64, u: &mut [f64]| {
        for (k, u) in u.iter_mut().enumerate() {
            *u = AMPLITUDE * (20.0 * time * (1.0 + 0.3 * k as f64)).sin();
        }
    };
    let mut start = start.clone();
    start.v.fill(0.0);
    let rollout = simulator.rollout(&start, 64 * EVERY, |time, _, u| input(time, u));
    let states = rollout.states.iter().enumerate().step_by(EVERY).take(64);
    let point = |(step, state): (usize, &State)| {
        let mut u = vec![0.0; simulator.nu()];
        input(step as f64 * TIME_STEP, &mut u);
        Point {
            state: state.clone(),
            a: Vec::new(),
            tau: Vec::new(),
            u,
        }
    };
    states.map(point).collect()
}

/// Friction that holds in every joint.
fn with_friction(plain: &Simulator, force: f64) -> Simulator {
    let model: &Model = plain.model();
    let own = plain.actuation().cloned();
    let actuation = own.unwrap_or_else(|| Actuation::ideal(model));
    let mut actuators = actuation.actuators().to_vec();
    for body in model
        .bodies()
        .iter()
        .filter(|body| body.joint != JointKind::Floating)
    {
        for own in &mut actuators[body.v..body.v + body.joint.nv()] {
            own.friction = Some(CoulombFriction::exact(force));
        }
    }
    let actuation = actuation.with_actuators(&actuators);
    plain.clone().with_actuation(actuation)
}

fn without_friction(actuation: Actuation) -> Actuation {
    let own = actuation.actuators().iter();
    let actuators: Vec<_> = own
        .map(|own| Actuator {
            friction: None,
            ..*own
        })
        .collect();
    actuation.with_actuators(&actuators)
}
