//! Steps and parameters that are not those of a robot, and refused problems.

use super::*;
use crate::joint::JointKind;
use crate::sim::Actuation;

// A trial step may reach parameters that are not physically consistent; the descent must then take a shorter step.
#[test]
fn numbers_that_make_no_robot_have_no_residuals() {
    let data = logged(
        &cartpole(),
        &State::new(&[0.0, 2.0], &[0.0; 2]),
        12,
        [0.0; 2],
    );
    let (nominal, options) = (wrong(), ShootingOptions::default());
    let is_finite = |own: Adjustable, x: &[f64]| {
        let own = [own];
        let mut problem = Shooting::new(&nominal, &data, &own, &options).unwrap();
        let mut out = vec![0.0; problem.n_residuals()];
        problem.residuals(x, &mut out);
        out.iter().all(|r| r.is_finite())
    };
    let parameter = |name: &str| Adjustable::Parameter(name.into());
    assert!(is_finite(parameter("pole: mass"), &[0.3]));
    assert!(!is_finite(parameter("pole: mass"), &[-0.3]));
    assert!(is_finite(parameter("pivot: armature"), &[0.0]));
    assert!(!is_finite(parameter("pivot: armature"), &[-1e-9]));
    // Less moment about the pivot than none.
    assert!(!is_finite(parameter("pole: Jzz"), &[-1.0]));
    // A pseudo-inertia that is not positive.
    assert!(!is_finite(Adjustable::Inertia("pole".into()), &[-1.0; 10]));
}

// Of a robot at rest only what gravity does is known: the descent goes where the noise leads it with the rest.
#[test]
fn log_at_rest_ends_with_a_robot() {
    let numbers = |joint: &str, link: &str| {
        let of = |what| Adjustable::Parameter(format!("{joint}: {what}"));
        vec![
            of("armature"),
            of("damping"),
            Adjustable::Inertia(link.into()),
        ]
    };
    let carried = {
        let kinds = [JointKind::Floating, JointKind::Revolute];
        let model = samples::random_tree_of(&kinds, 2, 3).with_gravity(nalgebra::Vector3::zeros());
        Simulator::new(model).with_time_step(5e-3)
    };
    let names = carried.model().joint_names();
    let link = carried.model().links().last().unwrap().frame;
    let of_carried = numbers(names[1], &carried.model().frames()[link.0].name);
    let hanging = State::new(&[0.0, std::f64::consts::PI], &[0.0; 2]);
    let cases = [
        (wrong(), hanging, numbers("pivot", "pole")),
        (carried.clone(), carried.neutral_state(), of_carried),
    ];
    for (nominal, start, adjustable) in cases {
        let simulator = nominal.clone().with_actuated_joints(&[]).unwrap();
        let data = logged(&simulator, &start, 60, [1e-3, 1e-2]);
        for starts in [Starts::Measured, Starts::Free] {
            let options = ShootingOptions {
                starts,
                ..Default::default()
            };
            let found = shoot(&simulator, &data, &adjustable, 0.95, &options).unwrap();
            let model = found.simulator.model();
            assert_eq!(model.check_mass_matrix(), Ok(()));
            assert!(
                model
                    .armature()
                    .iter()
                    .chain(model.damping().iter())
                    .all(|&x| x >= 0.0)
            );
            assert!(
                found.values.iter().all(|x| x.is_finite()),
                "{:?}",
                found.status
            );
        }
    }
}

#[test]
fn what_cannot_be_adjusted_is_refused_by_name() {
    let data = logged(
        &cartpole(),
        &State::new(&[0.0, 2.0], &[0.0; 2]),
        50,
        [0.0; 2],
    );
    let says =
        |simulator: &Simulator, own: Adjustable, options: ShootingOptions, expected: &str| {
            let text = shoot(simulator, &data, &[own], 0.95, &options)
                .unwrap_err()
                .to_string();
            assert!(text.contains(expected), "{text}\ndoes not say: {expected}");
        };
    let mass = || Adjustable::Parameter("pole: mass".into());
    let options = ShootingOptions::default;
    says(
        &wrong(),
        Adjustable::Parameter("pole: weight".into()),
        options(),
        "pole: weight",
    );
    says(
        &wrong(),
        Adjustable::Inertia("world".into()),
        options(),
        "it does not move",
    );
    says(
        &wrong(),
        Adjustable::Friction(vec![0]),
        options(),
        "no such contact points",
    );
    let with_stops = {
        let actuation = Actuation::from_model(wrong().model());
        wrong().with_actuation(actuation)
    };
    says(
        &with_stops,
        Adjustable::Parameter("linear: upper limit".into()),
        options(),
        "linear: upper limit: the fit",
    );
    says(
        &wrong(),
        Adjustable::Parameter("time step".into()),
        options(),
        "time step: the rate of the log sets it",
    );
    says(
        &wrong().with_time_step(3e-3),
        mass(),
        options(),
        "time steps of the simulator",
    );
    says(
        &wrong(),
        mass(),
        ShootingOptions {
            samples: 0,
            ..options()
        },
        "samples: 0",
    );
    says(
        &Simulator::new(samples::arm()),
        Adjustable::Inertia("link1".into()),
        options(),
        "\"arm\" has 7",
    );
}
