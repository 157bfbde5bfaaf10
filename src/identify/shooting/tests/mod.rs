//! Numbers of a robot that are found again, and intervals that hold them.

mod limits;
mod slopes;

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::constraint::{Anchor, Constraint};
use crate::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use crate::identify::dataset::Segment;
use crate::identify::tests::{normal, rng};
use crate::model::{BodyId, Model, samples};
use crate::sim::State;

/// A rollout as data, with errors of these deviations.
fn logged(simulator: &Simulator, start: &State, steps: usize, deviations: [f64; 2]) -> Dataset {
    let push = |t: f64, _: &State, u: &mut [f64]| {
        u.iter_mut()
            .enumerate()
            .for_each(|(k, u)| *u = ((3.0 + k as f64) * t).sin());
    };
    let (model, rollout) = (simulator.model(), simulator.rollout(start, steps, push));
    let mut rng = rng(5);
    let mut segment = Segment {
        experiment: "log".into(),
        start: 0.0,
        rate: simulator.time_step().recip(),
        q: DMatrix::zeros(model.nq(), steps),
        v: DMatrix::zeros(model.nv(), steps),
        a: DMatrix::zeros(model.nv(), steps),
        tau: DMatrix::zeros(model.nv(), steps),
    };
    for k in 0..steps {
        let error = DVector::from_fn(model.nv(), |_, _| deviations[0] * normal(&mut rng));
        let q = model.integrate(rollout.states[k].q.as_slice(), error.as_slice());
        segment.q.set_column(k, &q);
        let error = DVector::from_fn(model.nv(), |_, _| deviations[1] * normal(&mut rng));
        segment.v.set_column(k, &(&rollout.states[k].v + error));
        for (u, &row) in rollout.inputs[k].iter().zip(simulator.actuated()) {
            segment.tau[(row, k)] = *u;
        }
    }
    Dataset::new(vec![segment])
}

fn cartpole() -> Simulator {
    let model = samples::cartpole()
        .with_damping(0, 0.7)
        .with_damping(1, 0.1);
    Simulator::new(model).with_time_step(5e-3)
}

fn adjustable() -> Vec<Adjustable> {
    vec![
        Adjustable::Parameter("linear: damping".into()),
        Adjustable::Inertia("pole".into()),
        Adjustable::Parameter("pivot: damping".into()),
    ]
}

/// A nominal robot that is wrong in what is asked for.
fn wrong() -> Simulator {
    let model = samples::cartpole().with_link_mass("pole", 0.8).unwrap();
    Simulator::new(model).with_time_step(5e-3)
}

fn four_bar() -> Simulator {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/four_bar.urdf");
    let model = Model::from_urdf_file(file).unwrap();
    let end = |name| Anchor::frame(&model, name).unwrap();
    let pin = Constraint::ball([end("loop_a"), end("loop_b")]);
    Simulator::new(model)
        .with_constraints(vec![pin])
        .with_time_step(2e-3)
}

#[test]
fn damping_and_a_pin_of_a_closed_loop_are_found_again() {
    let nominal = four_bar();
    let layout = nominal.parameter_layout();
    let names = ["crank_joint: damping", "constraint 0: first anchor z"];
    let places = names.map(|name| layout.find(name).unwrap());
    let mut parameters = nominal.parameters();
    parameters[places[0]] = 0.3;
    parameters[places[1]] += 0.01;
    let expected = places.map(|place| parameters[place]);
    let truth = nominal.with_parameters(parameters.as_slice());
    let start = truth.assemble(&truth.neutral_state()).unwrap().state;
    let data = logged(&truth, &start, 300, [1e-5, 1e-4]);
    let adjustable = names.map(|name| Adjustable::Parameter(name.into()));
    let options = ShootingOptions {
        samples: 5,
        starts: Starts::Free,
        ..Default::default()
    };
    let few = logged(&truth, &start, 12, [0.0; 2]);
    slopes::check_jacobian(Shooting::new(&nominal, &few, &adjustable, &options).unwrap());
    let options = ShootingOptions {
        position_deviation: 1e-5,
        velocity_deviation: 1e-4,
        starts: Starts::Free,
        ..Default::default()
    };
    let found = shoot(&nominal, &data, &adjustable, 0.99, &options).unwrap();
    for (own, expected) in found.intervals.unwrap().iter().zip(expected) {
        assert!(
            (own.lower..=own.upper).contains(&expected),
            "{own:?} {expected}"
        );
        assert!(own.deviation < 0.02 * expected, "{own:?}");
    }
}

// Everything but the mass is as it should be, moments in proportion to it.
#[test]
fn mass_of_a_link_is_found_with_its_moments() {
    let truth = cartpole();
    let data = logged(&truth, &State::new(&[0.0, 2.0], &[0.0; 2]), 200, [0.0; 2]);
    let mass = |simulator: &Simulator| simulator.model().body(BodyId(1)).inertia;
    let all = [Adjustable::LinkMass("pole".into())];
    let model = truth.model().clone().with_link_mass("pole", 0.8).unwrap();
    let wrong = Simulator::new(model).with_time_step(5e-3);
    let found = shoot(&wrong, &data, &all, 0.95, &ShootingOptions::default()).unwrap();
    let (own, expected) = (mass(&found.simulator), mass(&truth));
    assert!(
        (found.values[0] - expected.mass).abs() < 1e-6,
        "{:?}",
        found.values
    );
    assert!((own.mass - found.values[0]).abs() < 1e-15);
    assert!((own.first_moment - expected.first_moment).norm() < 1e-6);
    assert!((own.rotational.zz - expected.rotational.zz).abs() < 1e-6);
    assert_eq!(found.simulator.model().inertia_flaws(), []);
}

// Of the pole the motion tells its moment about the pivot, m l and, through the cart, its mass.
#[test]
fn numbers_of_a_simulated_cart_pole_are_found_again() {
    let truth = cartpole();
    let data = logged(&truth, &State::new(&[0.0, 2.0], &[0.0; 2]), 400, [0.0; 2]);
    let found = shoot(
        &wrong(),
        &data,
        &adjustable(),
        0.95,
        &ShootingOptions::default(),
    )
    .unwrap();
    let model = found.simulator.model();
    assert!(
        (model.damping()[0] - 0.7).abs() < 1e-5,
        "{:?}",
        found.values
    );
    assert!(
        (model.damping()[1] - 0.1).abs() < 1e-5,
        "{:?}",
        found.values
    );
    let of = |model: &Model| {
        let own = model.body(BodyId(1)).inertia;
        [own.mass, own.first_moment.norm(), own.rotational.zz]
    };
    for (own, expected) in of(model).iter().zip(of(truth.model())) {
        assert!((own - expected).abs() < 1e-4, "{own} {expected}");
    }
    assert_eq!(model.inertia_flaws(), []);
}

#[test]
fn intervals_of_a_noisy_log_hold_the_dampings() {
    let truth = cartpole();
    let data = logged(
        &truth,
        &State::new(&[0.0, 2.0], &[0.0; 2]),
        400,
        [1e-4, 1e-3],
    );
    let options = ShootingOptions {
        samples: 50,
        starts: Starts::Free,
        position_deviation: 1e-4,
        velocity_deviation: 1e-3,
        ..Default::default()
    };
    let found = shoot(&wrong(), &data, &adjustable(), 0.99, &options).unwrap();
    assert!((found.deviation - 1.0).abs() < 0.1, "{}", found.deviation);
    let intervals = found.intervals.unwrap();
    for (name, expected) in [
        ("linear: damping", 0.7),
        ("pivot: damping", 0.1),
        ("pole: mass", 0.5),
    ] {
        let own = intervals.iter().find(|own| own.name == name).unwrap();
        assert!((own.lower..=own.upper).contains(&expected), "{own:?}");
        assert!(own.deviation < 0.05 * expected, "{own:?}");
    }
}

// A box that slides on the ground, on bristles that are bent where shots begin.
#[test]
fn friction_of_a_sliding_box_is_found_again() {
    let urdf = r#"<robot name="box"><link name="box">
        <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
        <collision><geometry><box size="0.4 0.4 0.1"/></geometry></collision></link></robot>"#;
    let model = Model::from_urdf_str(urdf).unwrap();
    let simulator = |friction: f64| {
        let law = SoftContact {
            friction,
            ..SoftContact::estimate(1.0, 4, 1e-3)
        };
        let law = ContactLaw::Soft(law);
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
        Simulator::new(model.clone())
            .with_time_step(2e-3)
            .with_contacts(contacts)
    };
    let truth = simulator(0.4);
    let mut start = truth.neutral_state();
    start.q[2] = 0.049;
    start.v.copy_from_slice(&[1.5, 0.3, 0.0, 0.0, 0.0, 0.5]);
    assert!(truth.n_contact() > 0);
    let data = logged(&truth, &start, 70, [0.0; 2]);
    let all = (0..truth.contacts().unwrap().points().len()).collect();
    let found = shoot(
        &simulator(0.7),
        &data,
        &[Adjustable::Friction(all)],
        0.95,
        &ShootingOptions::default(),
    );
    let found = found.unwrap();
    assert!(
        (found.values[0] - 0.4).abs() < 1e-4,
        "{:?} {:?}",
        found.values,
        found.status
    );
}
