//! Reasons of a report for the derivatives of a contact.

use dualbody::contact::{ContactLaw, Contacts, Rigid, Smoothing, SoftContact, Terrain};
use dualbody::sim::ContactReason;
use dualbody::{Integrator, ModelOptions, Simulator, State};

use crate::common::ground::{free, on};
use crate::common::{SAME_ALGEBRA, asset};

fn rigid() -> ContactLaw {
    ContactLaw::Rigid(Rigid::default())
}

/// A ball of 0.1 m at rest at a height above flat ground.
fn above(simulator: &Simulator, height: f64) -> State {
    free(simulator, [0.0, 0.0, 0.1 + height], 0.0, [0.0; 6])
}

/// The ball on an incline of slope ½: a point with a mode that the state decides.
fn reason_on_incline(friction: f64, height: f64, v: [f64; 6]) -> ContactReason {
    let law = ContactLaw::Rigid(Rigid {
        friction,
        ..Rigid::default()
    });
    let angle = 0.5_f64.atan();
    let simulator = on(asset("sphere.urdf"), Terrain::incline(angle), law);
    let (sin, cos) = angle.sin_cos();
    let at = [-sin * (0.1 + height), 0.0, cos * (0.1 + height)];
    let state = free(&simulator, at, 0.0, v);
    simulator.contact_report(&state, &[]).reasons[0]
}

// Each by the physics of a ball: it flies, leaves, sticks with enough friction, and slides without.
#[test]
fn report_says_why_derivatives_are_zero() {
    let still = [0.0; 6];
    let up = [0.0, 0.0, 2.0, 0.0, 0.0, 0.0];
    let ContactReason::Separated { height } = reason_on_incline(1.0, 0.012, still) else {
        panic!("flies");
    };
    assert!((height - 0.012).abs() < SAME_ALGEBRA);
    let text = reason_on_incline(1.0, 0.012, still).to_string();
    assert!(
        text.starts_with("separated: 12 mm above the ground"),
        "{text}"
    );
    let ContactReason::Leaving { speed } = reason_on_incline(1.0, -1e-3, up) else {
        panic!("leaves");
    };
    assert!((speed - 2.0 * 0.5_f64.atan().cos()).abs() < SAME_ALGEBRA);
    assert_eq!(
        reason_on_incline(1.0, -1e-6, still),
        ContactReason::Sticking
    );
    assert_eq!(reason_on_incline(0.1, -1e-6, still), ContactReason::Sliding);
    assert_eq!(reason_on_incline(1.0, 0.0, still), ContactReason::Resting);
    assert_eq!(reason_on_incline(0.1, 0.0, still), ContactReason::Gliding);
    // A ball that rolls needs 2/7 of the slope as friction.
    assert_eq!(
        reason_on_incline(0.5 * 2.0 / 7.0, 0.0, still),
        ContactReason::Impending
    );
    for reason in [
        ContactReason::Sticking,
        ContactReason::Sliding,
        ContactReason::Resting,
        ContactReason::Gliding,
        ContactReason::Impending,
    ] {
        let name = format!("{reason:?}").to_lowercase();
        assert!(reason.to_string().starts_with(&name), "{reason}");
    }
}

// Without gravity a ball that just touches at rest has neither force nor velocity.
#[test]
fn report_says_that_a_point_touches() {
    let model = ModelOptions::default().with_gravity([0.0; 3]);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sphere.urdf");
    let (model, _) = model.load_urdf_file(path).expect("a ball");
    let simulator = on(model, Terrain::flat(0.0), rigid());
    let state = above(&simulator, 0.0);
    let report = simulator.contact_report(&state, &[]);
    assert_eq!(report.reasons, [ContactReason::Touching]);
    assert!(report.reasons[0].to_string().starts_with("touching"));
}

#[test]
fn report_tells_smoothed_and_soft_contact() {
    let model = asset("sphere.urdf");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), rigid());
    let smoothed = contacts.with_smoothing(Smoothing::new(1.0));
    let simulator = Simulator::new(model).with_contacts(smoothed);
    let reason = |simulator: &Simulator, height| {
        let state = above(simulator, height);
        simulator.contact_report(&state, &[]).reasons[0]
    };
    let text = reason(&simulator, 0.012).to_string();
    assert!(
        text.starts_with("smoothed: 12 mm above the ground"),
        "{text}"
    );
    let far = reason(&simulator, 0.5);
    assert!(matches!(far, ContactReason::Separated { .. }), "{far}");
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3));
    for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
        let soft = on(asset("sphere.urdf"), Terrain::flat(0.0), law).with_integrator(integrator);
        let text = reason(&soft, -2e-3).to_string();
        assert!(text.starts_with("soft: 2 mm in the ground"), "{text}");
        let far = reason(&soft, 0.5);
        assert!(matches!(far, ContactReason::Separated { .. }), "{far}");
    }
}
