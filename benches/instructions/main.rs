//! Runs one function so that its instructions can be counted: `run.sh` does, and compares with `counts.txt`.
//!
//! ```sh
//! instructions                     # lists the functions to count
//! instructions rnea/f64/panda      # calls it once on each point
//! ```
//!
//! Only instructions below [`measured`] are counted, not the loading of the robot. Data decide about branches of contact only,
//! which has one state of its own, so a count belongs to a function, a robot and a compiler; from run to run it differs by no more than
//! where memory happens to lie makes a difference to copying, about 1 ‰.

#[path = "../common/mod.rs"]
mod common;

use std::hint::black_box;

use common::functions as f;
use common::points::{N_POINTS, Point, Seed, points};
use common::robots::{asset, standing};
use dualbody::autodiff::Dual;
use dualbody::{Lanes, Simulator};

/// The functions, each with its scalar.
const NAMES: [&str; 12] = [
    "kinematics/f64",
    "jacobian/f64",
    "rnea/f64",
    "bias_forces/f64",
    "crba/f64",
    "aba/f64",
    "step/f64",
    "factor_and_solve/f64",
    "inverse_dynamics_derivatives/f64",
    "linearize/f64",
    "rnea/dual4",
    "step/lanes4",
];

/// An arm with a fixed base, and a tree with a floating one.
const ROBOTS: [&str; 2] = ["panda", "humanoid"];

/// On four feet.
const IN_CONTACT: [&str; 2] = ["step/f64/standing", "linearize/f64/standing"];

fn main() {
    let of_robots = NAMES
        .iter()
        .flat_map(|name| ROBOTS.map(|robot| format!("{name}/{robot}")));
    let names = of_robots.chain(IN_CONTACT.map(str::to_owned));
    let wanted = std::env::args()
        .skip(1)
        .find(|argument| argument.contains('/'));
    match wanted {
        Some(wanted) => run(&wanted),
        // As a bench, to see that everything runs.
        None if common::clock::is_test() => {
            names.for_each(|name| run(&name));
        }
        None => names.for_each(|name| println!("{name} {N_POINTS}")),
    }
}

fn run(wanted: &str) {
    let (function, robot) = wanted.rsplit_once('/').unwrap_or((wanted, ""));
    if IN_CONTACT.contains(&wanted) {
        return run_standing(function);
    }
    assert!(
        ROBOTS.contains(&robot),
        "\"{wanted}\" is not function/scalar/robot with one of the robots {ROBOTS:?}"
    );
    let s = Simulator::new(asset(robot));
    match function {
        "kinematics/f64" => count::<f64>(&s, f::kinematics(&s)),
        "jacobian/f64" => count::<f64>(&s, f::jacobian(&s)),
        "rnea/f64" => count::<f64>(&s, f::rnea(&s)),
        "bias_forces/f64" => count::<f64>(&s, f::bias(&s)),
        "crba/f64" => count::<f64>(&s, f::crba(&s)),
        "aba/f64" => count::<f64>(&s, f::aba(&s)),
        "step/f64" => count::<f64>(&s, f::step(&s)),
        "factor_and_solve/f64" => count(&s, f::factor_and_solve(&s)),
        "inverse_dynamics_derivatives/f64" => count(&s, f::inverse_derivatives(&s)),
        "linearize/f64" => count(&s, f::linearize(&s)),
        "rnea/dual4" => count::<Dual<f64, 4>>(&s, f::rnea(&s)),
        "step/lanes4" => count::<Lanes<4>>(&s, f::step(&s)),
        _ => panic!("\"{function}\" is none of {NAMES:?}"),
    }
}

fn run_standing(function: &str) {
    let (s, state) = standing();
    let mut point = points::<f64>(&s).swap_remove(0);
    point.state = state;
    point.u.fill(0.0);
    let calls = |function: &mut dyn FnMut(&Point<f64>)| {
        function(&point);
        measured(&mut || (0..N_POINTS).for_each(|_| function(&point)));
    };
    match function {
        "step/f64" => calls(&mut f::step(&s)),
        _ => calls(&mut f::linearize(&s)),
    }
}

fn count<T: Seed>(simulator: &Simulator, mut function: impl FnMut(&Point<T>)) {
    let points = points::<T>(simulator);
    // The first call sets up the workspace, which is not counted.
    function(&points[0]);
    measured(&mut || points.iter().for_each(&mut function));
}

/// `run.sh` passes its name to the counter, so it must stay a function.
#[inline(never)]
fn measured(function: &mut dyn FnMut()) {
    black_box(function)();
}
