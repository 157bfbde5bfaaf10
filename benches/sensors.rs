//! Time of a step with the readings of sensors, beside that of the same step without: µs without, and the ratios. Each column has the sensors of those before it.
//!
//! ```sh
//! cargo bench --bench sensors
//! ```
//!
//! - *encoders*: position and velocity of every joint,
//! - *inertial*: gyro and accelerometer on a link,
//! - *feet*: the contact force on each of four feet,
//! - *wrench*: a force–torque sensor on the last link,
//! - *A to D*: the Jacobians of the step and of all of these readings (`Sensors::linearize`), beside those of the step alone.

mod common;

use std::hint::black_box;

use common::clock::{Clock, is_test};
use common::functions::{linearize, step, step_and_read};
use common::points::{Point, points};
use common::robots::{FEET, asset, standing};
use dualbody::model::{FrameId, JointId};
use dualbody::sim::{Sensor, Sensors};
use dualbody::{Model, Simulator};

/// Pairs of measurements for a ratio, of which the median counts.
const PAIRS: usize = 15;

fn main() {
    let clock = if is_test() {
        Clock::ONCE
    } else {
        Clock { rounds: 11 }
    };
    println!(
        "{:24}{:>9}{:>10}{:>10}{:>8}{:>8}{:>8}",
        "", "µs", "encoders", "inertial", "feet", "wrench", "A to D"
    );
    for name in ["ur5", "panda", "quadruped", "humanoid"] {
        let simulator = Simulator::new(asset(name)).with_time_step(1e-3);
        let points = points(&simulator);
        print_row(clock, name, &simulator, &points);
    }
    let (simulator, state) = standing();
    let point = Point {
        a: Vec::new(),
        tau: Vec::new(),
        u: vec![0.0; simulator.nu()],
        state,
    };
    print_row(clock, "quadruped that stands", &simulator, &[point]);
}

fn print_row(clock: Clock, name: &str, simulator: &Simulator, points: &[Point<f64>]) {
    print!("{name:24}{:9.3}", clock.over(points, step(simulator)) * 1e6);
    let sets = sets(simulator.model());
    for (sensors, width) in sets.iter().zip([10, 10, 8, 8]) {
        let with = step_and_read(simulator, sensors.clone());
        let ratio = ratio(clock, points, step(simulator), with);
        print!("{ratio:width$.3}");
    }
    let jacobians = |p: &Point<f64>| drop(black_box(sets[3].linearize(simulator, &p.state, &p.u)));
    println!(
        "{:8.3}",
        ratio(clock, points, linearize(simulator), jacobians)
    );
}

/// The median of the ratios of measurements in turn, so that other work on the machine slows both.
fn ratio(
    clock: Clock,
    points: &[Point<f64>],
    mut without: impl FnMut(&Point<f64>),
    mut with: impl FnMut(&Point<f64>),
) -> f64 {
    let mut ratios: Vec<f64> = (0..PAIRS)
        .map(|_| {
            let plain = clock.over(points, &mut without);
            clock.over(points, &mut with) / plain
        })
        .collect();
    ratios.sort_unstable_by(f64::total_cmp);
    ratios[PAIRS / 2]
}

/// The sensors of each column.
fn sets(model: &Model) -> [Sensors; 4] {
    let joints = (0..model.n_joints()).map(JointId);
    let mut all: Vec<Sensor> = joints
        .flat_map(|id| [Sensor::JointPosition(id), Sensor::JointVelocity(id)])
        .collect();
    let last = *model.link_frames().last().expect("a link");
    let unit = model.frame("imu_link").unwrap_or(last);
    let feet: Vec<FrameId> = FEET.iter().filter_map(|foot| model.frame(foot)).collect();
    let more = [
        Vec::new(),
        vec![Sensor::Gyro(unit), Sensor::Accelerometer(unit)],
        feet.into_iter().map(Sensor::ContactForce).collect(),
        vec![Sensor::Wrench(last)],
    ];
    more.map(|more| {
        all.extend(more);
        let named = all.iter().enumerate().map(|(k, own)| (k.to_string(), *own));
        Sensors::new(model, named)
    })
}
