//! Questions about contact between bodies: the pairs that touch, their forces, and the Jacobians at the points.

use dualbody::contact::{CollisionOptions, ContactLaw, RelaxedRigid, SoftContact, Terrain};
use dualbody::dynamics::{frame_pose, gravity_forces};
use dualbody::model::{FrameId, Mass, Object, World};
use dualbody::sim::ContactReport;
use dualbody::spatial::Transform;
use dualbody::{Contacts, Simulator, State};
use nalgebra::{DVector, Matrix3, Vector3};

const MASSES: [f64; 2] = [2.0, 1.0];

/// A small box on a large one on the ground.
fn tower() -> Simulator {
    tower_under(ContactLaw::RelaxedRigid(RelaxedRigid::default()))
}

fn tower_under(law: ContactLaw) -> Simulator {
    let mut world = World::new("tower");
    for (name, mass, size, z) in [("a", MASSES[0], 0.4, 0.1), ("b", MASSES[1], 0.2, 0.3)] {
        let at = Transform::from_translation([0.0, 0.0, z].into());
        let object = Object::free(Mass::Kilograms(mass)).at(at);
        world
            .add_box(name, [size, size, 0.2], &object)
            .expect("a box");
    }
    let model = world.build().expect("a world");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("links");
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(0.002)
}

fn links(simulator: &Simulator) -> [FrameId; 2] {
    ["a", "b"].map(|name| simulator.model().frame(name).expect("a link"))
}

fn settled(simulator: &Simulator) -> (State, ContactReport) {
    let rollout = simulator.rollout(&simulator.neutral_state(), 500, |_, _, _| {});
    let state = rollout.last().clone();
    let report = simulator.contact_report(&state, &[]);
    (state, report)
}

#[test]
fn force_between_boxes_at_rest_is_the_weight_of_the_upper_one() {
    let simulator = tower();
    let ([a, b], (_, report)) = (links(&simulator), settled(&simulator));
    let (up, down) = (report.force_between([b, a]), report.force_between([a, b]));
    assert_eq!(up, -down);
    let weight = Vector3::new(0.0, 0.0, MASSES[1] * 9.81);
    assert!((up - weight).norm() < 1e-3 * weight.z, "{up}");
    assert!(report.are_touching([a, b]) && report.are_touching([b, a]));
    let ground: Vector3<f64> = report.forces.iter().sum();
    assert!((ground.z - (MASSES[0] + MASSES[1]) * 9.81).abs() < 0.03);
    // Higher up they do not touch.
    let mut apart = simulator.neutral_state();
    let joint = simulator.model().find_joint("b").expect("a joint");
    apart.q[simulator.model().joint_q(joint).start + 2] = 0.1;
    let report = simulator.contact_report(&apart, &[]);
    assert!(!report.are_touching([a, b]) && report.force_between([a, b]).norm() == 0.0);
}

#[test]
fn forces_of_contact_by_their_jacobians_balance_gravity() {
    let simulator = tower();
    let (state, report) = settled(&simulator);
    let (model, q) = (simulator.model(), state.q.as_slice());
    let mut tau = -gravity_forces(model, q);
    let contacts = simulator.contacts().expect("contacts");
    for (k, force) in report.forces.iter().enumerate() {
        tau += contacts.jacobian(model, q, k).transpose() * force;
    }
    let jacobians = report.pair_jacobians(model, q);
    for (pair, jacobian) in report.pairs.iter().zip(jacobians) {
        tau += jacobian.rows(0, 3).transpose() * pair.force;
    }
    assert!(tau.amax() < 0.02, "{tau}");
}

/// The tower in motion, off its place, so that its boxes overlap a little.
fn moving(simulator: &Simulator) -> (State, ContactReport) {
    let (mut state, _) = settled(simulator);
    state.v = DVector::from_fn(simulator.model().nv(), |k, _| (1.3 * k as f64 + 0.4).sin());
    let report = simulator.contact_report(&state, &[]);
    (state, report)
}

#[test]
fn velocity_at_a_point_equals_jacobian_times_velocity() {
    let simulator = tower();
    let (state, report) = moving(&simulator);
    assert!(report.pairs.len() >= 4);
    let jacobians = report.pair_jacobians(simulator.model(), state.q.as_slice());
    assert_eq!(jacobians.len(), report.pairs.len());
    for (pair, jacobian) in report.pairs.iter().zip(jacobians) {
        let velocity = jacobian * &state.v;
        let off = (velocity.rows(0, 3) - pair.point.velocity).norm();
        // The point of the report is half way between those of the two links.
        assert!(off < 1e-3, "{off}");
    }
}

// Against the world the point moves with the first link: J(q ⊕ h v) there, less J(q ⊕ −h v).
#[test]
fn rate_of_the_jacobian_equals_differences() {
    const STEP: f64 = 1e-5;
    let simulator = tower();
    let (state, report) = moving(&simulator);
    let (model, q) = (simulator.model(), state.q.as_slice());
    let world = FrameId(
        model
            .frames()
            .iter()
            .position(|frame| frame.body.is_none())
            .expect("the world"),
    );
    let mut pair = report.pairs[0].clone();
    pair.links[1] = world;
    let in_link = frame_pose(model, q, pair.links[0])
        .inverse()
        .point(&pair.point.position);
    let at = |h: f64| {
        let q = model.integrate(q, (&state.v * h).as_slice());
        let mut moved = pair.clone();
        moved.point.position = frame_pose(model, q.as_slice(), pair.links[0]).point(&in_link);
        let mut other = report.clone();
        other.pairs = vec![moved];
        other.pair_jacobians(model, q.as_slice()).remove(0)
    };
    let expected = (at(STEP) - at(-STEP)) / (2.0 * STEP);
    let mut one = report.clone();
    one.pairs = vec![pair];
    let found = one
        .pair_jacobian_derivatives(model, q, state.v.as_slice())
        .remove(0);
    assert!((found - expected).amax() < 1e-8);
}

#[test]
fn frames_are_right_handed_about_any_normal() {
    let simulator = tower();
    let (_, report) = settled(&simulator);
    let mut pair = report.pairs[0].clone();
    let normals = [[0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [0.0, 0.8, 0.6]];
    for normal in normals.map(Vector3::from) {
        pair.point.normal = normal;
        let frame = pair.frame();
        assert_eq!(frame.rotation.column(2), normal);
        assert_eq!(frame.translation, pair.point.position);
        let off = frame.rotation.transpose() * frame.rotation - Matrix3::identity();
        assert!(off.amax() < 1e-15 && (frame.rotation.determinant() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn links_touch_under_rigid_and_soft_contact_alike() {
    let soft = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
    for law in [soft, ContactLaw::RelaxedRigid(RelaxedRigid::default())] {
        let simulator = tower_under(law);
        let [a, b] = links(&simulator);
        let mut state = simulator.neutral_state();
        let joint = simulator.model().find_joint("b").expect("a joint");
        let height = simulator.model().joint_q(joint).start + 2;
        let at = |state: &State| {
            let report = simulator.contact_report(state, &[]);
            (report.are_touching([a, b]), report.touching)
        };
        state.q[height] -= 1e-3;
        let (between, touching) = at(&state);
        let links = simulator.model().links().iter();
        let of_upper = links.clone().position(|link| link.frame == b);
        let of_upper = of_upper.expect("a link");
        assert!(between && touching[of_upper]);
        state.q[height] += 0.1;
        let (between, touching) = at(&state);
        assert!(!between && !touching[of_upper]);
    }
}
