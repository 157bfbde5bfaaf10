//! Equilibria with contact, and regulators about them.

use std::collections::HashSet;

use dualbody::contact::{ContactLaw, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::control::{Equilibrium, EquilibriumLqr, EquilibriumStatus};
use dualbody::model::samples;
use dualbody::{Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::asset;
use crate::common::quadruped::{crouching, quadruped};

fn soft(mass: f64) -> ContactLaw {
    ContactLaw::Soft(SoftContact::estimate(mass, 4, 2e-3))
}

fn found(simulator: &Simulator, guess: &State) -> Equilibrium {
    let found = Equilibrium::find(simulator, guess, &[0.0; 12]);
    assert!(found.is_found(), "{found:?}");
    let next = simulator.step(&found.state, found.input.as_slice());
    let moved = next.deviation(simulator.model(), &found.state).amax();
    assert!(moved < 1e-7, "{moved:e}");
    let bent = (found.state.q.rows(7, 12) - guess.q.rows(7, 12)).amax();
    assert!(bent < 0.05, "{bent}");
    found
}

fn regulator(simulator: &Simulator, at: &Equilibrium) -> EquilibriumLqr {
    let nv = simulator.model().nv();
    let weight = DVector::from_fn(2 * nv, |k, _| match k {
        k if k < 6 => 100.0,
        k if k < nv => 1.0,
        _ => 0.1,
    });
    let r = DMatrix::identity(12, 12).scale(0.1);
    at.lqr(simulator, &DMatrix::from_diagonal(&weight), &r)
}

/// Distance from the equilibrium three seconds after a push.
fn left_after_a_push(simulator: &Simulator, regulator: &EquilibriumLqr) -> f64 {
    let (model, rest) = (simulator.model(), &regulator.at.state);
    let mut pushed = rest.clone();
    pushed.v[1] += 0.1;
    pushed.v[3] += 0.2;
    let stood = simulator.rollout(&pushed, 1500, |_, state, u| {
        u.copy_from_slice(regulator.control(model, state).as_slice());
    });
    stood.last().deviation(model, rest).rows(0, 36).amax()
}

#[test]
fn quadruped_stands_on_soft_ground_and_returns_after_a_push() {
    let simulator = quadruped(soft, Terrain::flat(0.0));
    let at = found(&simulator, &crouching(&simulator, 0.0));
    let report = simulator.contact_report(&at.state, at.input.as_slice());
    let carried: f64 = report.forces.iter().map(|f| f.z).sum();
    let weight = simulator.model().total_mass() * 9.81;
    assert!(
        (carried - weight).abs() < 1e-6 * weight,
        "{carried} {weight}"
    );
    let regulator = regulator(&simulator, &at);
    assert!(regulator.is_stabilized());
    assert_eq!(regulator.dropped.bristles, [0, 1, 2, 3]);
    assert!(regulator.dropped.names.is_empty(), "{}", regulator.dropped);
    assert!(left_after_a_push(&simulator, &regulator) < 1e-2);
}

// Where friction has no memory nothing brings feet back: two ways along the ground and the turn about its normal are out of reach.
#[test]
fn what_relaxed_contact_does_not_hold_is_dropped_by_name() {
    let relaxed = |_| ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let simulator = quadruped(relaxed, Terrain::flat(0.0));
    let at = found(&simulator, &crouching(&simulator, 0.0));
    let regulator = regulator(&simulator, &at);
    assert!(regulator.is_stabilized());
    let dropped = &regulator.dropped;
    assert_eq!(dropped.names, ["q.base.0", "q.base.1", "q.base.5"]);
    assert!(
        dropped
            .eigenvalues
            .iter()
            .all(|z| (z.norm() - 1.0).abs() < 1e-6)
    );
    assert!((&regulator.gain * &dropped.directions).amax() < 1e-9 * regulator.gain.amax());
}

// Rigid contact fixes the feet: of many directions that are out of reach several have the same largest component.
#[test]
fn each_direction_that_rigid_contact_drops_has_a_name_of_its_own() {
    let rigid = |_| ContactLaw::Rigid(Rigid::default());
    let simulator = quadruped(rigid, Terrain::flat(0.0));
    let at = Equilibrium::find(&simulator, &crouching(&simulator, 0.0), &[0.0; 12]);
    assert!(at.is_found(), "{at:?}");
    let dropped = regulator(&simulator, &at).dropped;
    let names: HashSet<&String> = dropped.names.iter().collect();
    assert!(dropped.names.len() > 6, "{dropped}");
    assert_eq!(names.len(), dropped.names.len(), "{dropped}");
    // A name states the components of its direction.
    let known = simulator.tangent_names();
    for (name, direction) in dropped.names.iter().zip(dropped.directions.column_iter()) {
        let first = name
            .split(' ')
            .find(|word| word.contains('.') && !word.starts_with('0'));
        let k = known.iter().position(|own| Some(own.as_str()) == first);
        assert_eq!(k, Some(direction.iamax()), "{name}");
    }
}

#[test]
fn quadruped_stands_on_a_slope() {
    let slope = 0.2_f64;
    let simulator = quadruped(soft, Terrain::plane([0.0; 3], [-slope, 0.0, 1.0]));
    let mut guess = crouching(&simulator, 0.0);
    let (sine, cosine) = (-0.5 * slope.atan()).sin_cos();
    (guess.q[3], guess.q[5]) = (cosine, sine);
    let at = found(&simulator, &guess);
    assert!(regulator(&simulator, &at).is_stabilized());
}

// In the air torques change nothing for the centre of mass.
#[test]
fn robot_in_the_air_is_not_held() {
    let simulator = Simulator::new(asset("quadruped.urdf"));
    let guess = crouching(&simulator, 0.0);
    let found = Equilibrium::find(&simulator, &guess, &[0.0; 12]);
    assert_eq!(found.status, EquilibriumStatus::NotHeld);
    assert!(found.acceleration > 1.0);
}

// The pole of a cart without a motor hangs.
#[test]
fn passive_pole_is_let_down_to_where_it_hangs() {
    let simulator = Simulator::new(samples::cartpole())
        .with_actuated_joints(&["linear"])
        .unwrap();
    let q = simulator.neutral_state::<f64>().q;
    for lean in [0.3, -0.2] {
        let guess = State::new(&[q[0], q[1] + lean], &[0.0; 2]);
        let found = Equilibrium::find(&simulator, &guess, &[0.0]);
        assert!(found.is_found(), "{found:?}");
        let angle = found.state.q[1] / std::f64::consts::PI;
        assert!((angle - angle.round()).abs() < 1e-6, "{angle}");
        assert!(found.input.amax() < 1e-5);
    }
}
