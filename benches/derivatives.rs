//! Times of derivatives, named `function/method/robot`.
//!
//! `dense` sends dual numbers through the whole tree, a chunk of directions at a time; `tree` eliminates along it. Both give the
//! same numbers; the difference is the gain by the structure of the robot.
//!
//! `step` is a step on plain numbers (`f64`) and on dual numbers with four directions (`dual4`), and all its Jacobians (`linearize`), of
//! robots in free motion and of one in contact: from how many directions on the Jacobians pay.

mod common;

use criterion::{Criterion, criterion_group, criterion_main};
use dualbody::Simulator;
use dualbody::autodiff::Dual;
use dualbody::contact::{ContactLaw, RelaxedRigid, Rigid, SoftContact};

use common::functions::{
    forward_derivatives, inverse_derivatives, inverse_derivatives_dense, linearize, step,
};
use common::points::{Point, Seed, points, points_from};
use common::robots::{ASSETS, asset, standing_under};

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
        bench_step::<f64>(c, &simulator, robot, &points);
        bench_step::<Dual<f64, 4>>(c, &simulator, robot, &common::points::points(&simulator));
    }
    for (name, law) in laws() {
        let (simulator, state) = standing_under(law);
        let points = points_from(&simulator, &state);
        let name = format!("standing, {name}");
        bench_step::<f64>(c, &simulator, &name, &points);
        bench_step::<Dual<f64, 4>>(c, &simulator, &name, &points_from(&simulator, &state));
        let name = format!("linearize/step/{name}");
        common::bench(c, &name, &points, linearize(&simulator));
    }
}

fn bench_step<T: Seed>(c: &mut Criterion, simulator: &Simulator, name: &str, points: &[Point<T>]) {
    let name = format!("step/{}/{name}", T::NAME);
    common::bench(c, &name, points, step(simulator));
}

fn laws() -> [(&'static str, ContactLaw); 3] {
    [
        (
            "soft",
            ContactLaw::Soft(SoftContact::estimate(12.0, 4, 1e-3)),
        ),
        ("relaxed", ContactLaw::RelaxedRigid(RelaxedRigid::default())),
        ("rigid", ContactLaw::Rigid(Rigid::default())),
    ]
}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = bench
}
criterion_main!(benches);
