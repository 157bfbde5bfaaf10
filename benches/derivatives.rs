//! Times of derivatives, named `function/method/robot`.
//!
//! `dense` sends dual numbers through the whole tree, a chunk of directions at a time; `tree` eliminates along it. Both give the
//! same numbers; the difference is what the structure of the robot is worth.

mod common;

use criterion::{Criterion, criterion_group, criterion_main};
use dualbody::Simulator;

use common::functions::{
    forward_derivatives, inverse_derivatives, inverse_derivatives_dense, linearize,
};
use common::points::{Point, points};
use common::robots::{ASSETS, asset};

fn bench(c: &mut Criterion) {
    for robot in ASSETS {
        let simulator = Simulator::new(asset(robot));
        let points = points(&simulator);
        let mut time = |function: &str, call: &mut dyn FnMut(&Point<f64>)| {
            common::bench(c, &format!("{function}/{robot}"), &points, call);
        };
        time(
            "inverse_dynamics/tree",
            &mut inverse_derivatives(&simulator),
        );
        time(
            "inverse_dynamics/dense",
            &mut inverse_derivatives_dense(&simulator),
        );
        time(
            "forward_dynamics/tree",
            &mut forward_derivatives(&simulator),
        );
        time("linearize/step", &mut linearize(&simulator));
    }
}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = bench
}
criterion_main!(benches);
