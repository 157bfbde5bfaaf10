//! Times of values, named `function/scalar/robot`: one call on one scalar, so four states a call on `lanes4`.

mod common;

use criterion::{Criterion, criterion_group, criterion_main};
use dualbody::autodiff::Dual;
use dualbody::model::JointId;
use dualbody::sim::{Sensor, Sensors};
use dualbody::{Lanes, Simulator};

use common::functions::{
    aba, bias, crba, factor_and_solve, jacobian, kinematics, rnea, step, step_and_read,
};
use common::points::{Point, Seed, points};
use common::robots::{ASSETS, asset};

fn bench<T: Seed>(c: &mut Criterion) {
    for robot in ASSETS {
        let simulator = Simulator::new(asset(robot));
        let points = points::<T>(&simulator);
        let mut time = |function: &str, call: &mut dyn FnMut(&Point<T>)| {
            common::bench(c, &format!("{function}/{}/{robot}", T::NAME), &points, call);
        };
        time("kinematics", &mut kinematics(&simulator));
        time("jacobian", &mut jacobian(&simulator));
        time("rnea", &mut rnea(&simulator));
        time("bias_forces", &mut bias(&simulator));
        time("crba", &mut crba(&simulator));
        time("aba", &mut aba(&simulator));
        time("step", &mut step(&simulator));
    }
}

fn bench_factor(c: &mut Criterion) {
    for robot in ASSETS {
        let simulator = Simulator::new(asset(robot));
        let name = format!("factor_and_solve/f64/{robot}");
        common::bench(c, &name, &points(&simulator), factor_and_solve(&simulator));
    }
}

/// Steps with encoders in all joints, an inertial unit on the last link besides, and a force–torque sensor there.
fn bench_sensors(c: &mut Criterion) {
    for robot in ASSETS {
        let simulator = Simulator::new(asset(robot));
        let model = simulator.model();
        let joints = (0..model.n_joints()).map(JointId);
        let encoders = joints.flat_map(|id| [Sensor::JointPosition(id), Sensor::JointVelocity(id)]);
        let mut all: Vec<Sensor> = encoders.collect();
        let last = *model.link_frames().last().expect("a link");
        for (name, more) in [
            ("encoders", vec![]),
            (
                "inertial_unit",
                vec![Sensor::Gyro(last), Sensor::Accelerometer(last)],
            ),
            ("force_torque", vec![Sensor::Wrench(last)]),
        ] {
            all.extend(more);
            let named = all.iter().enumerate().map(|(k, own)| (k.to_string(), *own));
            let sensors = Sensors::new(model, named);
            let name = format!("step_and_{name}/f64/{robot}");
            common::bench(
                c,
                &name,
                &points(&simulator),
                step_and_read(&simulator, sensors),
            );
        }
    }
}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = bench::<f64>, bench::<Dual<f64, 4>>, bench::<Lanes<4>>, bench::<Lanes<8>>, bench_factor, bench_sensors
}
criterion_main!(benches);
