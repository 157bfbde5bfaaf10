//! Parameters of robots, ids that they do not have, and parts of another robot.

use dualbody::constraint::{Anchor, Constraint, ConstraintKind};
use dualbody::contact::{ContactLaw, ContactPoint, Contacts, Rigid, Terrain};
use dualbody::dynamics::{frame_jacobian, frame_pose, frame_velocity};
use dualbody::model::{BodyId, FrameId, JointId, Spring, samples};
use dualbody::sim::{Actuation, ExternalForce};
use dualbody::spatial::{Force, Inertia, Representation, Transform};
use dualbody::{Lanes, Model, Simulator};
use nalgebra::vector;
use num_dual::Dual64;

use super::{INFINITY, NAN, Senseless, assert_not_set, refused};
use crate::common::asset;

const MODEL: [Senseless<Model>; 7] = [
    Senseless {
        said: "the gravity is {}",
        set: |model, x| *model = model.clone().with_gravity(vector![0.0, 0.0, x]),
        values: &[NAN],
    },
    Senseless {
        said: "the damping is {}",
        set: |model, x| *model = model.clone().with_damping(0, x),
        values: &[-1e9, NAN],
    },
    Senseless {
        said: "the armature is {}",
        set: |model, x| *model = model.clone().with_armature(0, x),
        values: &[NAN],
    },
    Senseless {
        said: "the spring stiffness is {}",
        set: |model, x| *model = model.clone().with_spring(0, spring(x, 0.0)),
        values: &[-1.0],
    },
    Senseless {
        said: "rest position of a spring is {}",
        set: |model, x| *model = model.clone().with_spring(0, spring(1.0, x)),
        values: &[NAN],
    },
    Senseless {
        said: "the mass is {}",
        set: |model, x| {
            let own = model.body(BodyId(0)).inertia;
            *model = model
                .clone()
                .with_inertia(BodyId(0), Inertia { mass: x, ..own });
        },
        values: &[NAN],
    },
    Senseless {
        said: "number of a placement is {}",
        set: |model, x| {
            let placement = Transform::from_translation(vector![x, 0.0, 0.0]);
            *model = model.clone().with_placement(BodyId(1), placement);
        },
        values: &[INFINITY],
    },
];

fn spring(stiffness: f64, rest: f64) -> Spring<f64> {
    Spring { stiffness, rest }
}

#[test]
fn models_with_senseless_numbers_are_refused() {
    assert_not_set(&samples::cartpole(), &MODEL);
}

#[test]
fn ids_out_of_range_are_refused_with_their_number() {
    let model = samples::cartpole();
    let own = || model.clone();
    let (q, v) = ([0.0; 2], [0.0; 2]);
    let (frame, body, joint) = (FrameId(40), BodyId(40), JointId(40));
    let mixed = Representation::Mixed;
    let n = model.frames().len();
    let message = format!("\"cartpole\" has no frame 40: it has {n}");
    refused(&message, || frame_pose(&model, &q, frame));
    refused(&message, || frame_velocity(&model, &q, &v, frame, mixed));
    refused(&message, || frame_jacobian(&model, &q, frame, mixed));
    let message = "\"cartpole\" has no joint 40: it has 2";
    refused(message, || model.joint_q(joint));
    refused(message, || model.joint_v(joint));
    refused(message, || model.limits(joint));
    let message = "\"cartpole\" has no body 40: it has 2";
    refused(message, || model.body(body).joint);
    refused(message, || model.body_name(body).len());
    refused(message, || own().with_inertia(body, Inertia::zero()));
    refused(message, || {
        own().with_placement(body, Transform::identity())
    });
    let message = "\"cartpole\" has no velocity coordinate 40: it has 2";
    refused(message, || own().with_damping(40, 0.0));
    refused(message, || own().with_armature(40, 0.0));
    refused(message, || own().with_spring(40, spring(0.0, 0.0)));
}

/// Those of a box.
fn contacts(model: &Model) -> Contacts {
    let law = ContactLaw::Rigid(Rigid::default());
    Contacts::new(model, Terrain::flat(0.0), law)
}

#[test]
fn contacts_of_another_robot_are_refused() {
    let (model, other) = (asset("box.urdf"), samples::cartpole());
    let contacts = contacts(&model);
    let message = "the contacts belong to another robot than \"cartpole\"";
    refused(message, || {
        Simulator::new(other.clone()).with_contacts(contacts.clone())
    });
    refused(message, || contacts.states(&other, &[0.0; 2], &[0.0; 2]));
    refused(message, || contacts.clone().with_links(&other, &[]));
    // As large, but another one.
    let twin = asset("sphere.urdf");
    refused("another robot", || {
        Simulator::new(twin).with_contacts(contacts.clone())
    });
    // A robot that differs only in its parameters counts as the same robot.
    let heavy = model.with_gravity(vector![0.0, 0.0, -1.6]);
    let _ = Simulator::new(heavy).with_contacts(contacts);
}

#[test]
fn points_on_bodies_and_links_that_there_are_not_are_refused() {
    let model = asset("box.urdf");
    let contacts = contacts(&model);
    let (first, law) = (contacts.points()[0], contacts.laws()[0]);
    let with = |point| {
        let contacts = contacts.clone().with_point(point, law);
        Simulator::new(model.clone()).with_contacts(contacts)
    };
    let body = BodyId(7);
    refused("contact point 8 is on body 7, but its link", || {
        with(ContactPoint { body, ..first })
    });
    let link = FrameId(9);
    refused("has no frame 9: it has 1", || {
        with(ContactPoint { link, ..first })
    });
}

#[test]
fn actuators_of_another_robot_are_refused() {
    let actuation = Actuation::from_model(&samples::double_pendulum());
    refused(
        "the actuators belong to another robot than \"cartpole\"",
        || Simulator::new(samples::cartpole()).with_actuation(actuation),
    );
}

#[test]
fn constraints_of_another_robot_or_with_senseless_numbers_are_refused() {
    let with = |constraint| Simulator::new(samples::cartpole()).with_constraints(vec![constraint]);
    let chain = samples::double_pendulum();
    let names: Vec<&str> = chain.joint_names();
    let coupler = Constraint::coupler(&chain, [names[0], names[1]], 1.0, 0.0).expect("joints");
    refused(
        "the joints of a constraint belong to another robot than \"cartpole\"",
        || with(coupler),
    );
    // As many frames, under other numbers.
    let elsewhere = on_frame(&chain, "lower");
    let pin = Constraint::ball([Anchor::world(), elsewhere]);
    refused(
        "the anchors of a constraint belong to another robot than \"cartpole\"",
        || with(pin),
    );
    let anchor = Anchor::new(Some(FrameId(30)), Transform::identity());
    let world = Anchor::world;
    let pin = Constraint::ball([anchor, world()]);
    refused("\"cartpole\" has no frame 30", || with(pin));
    let open = Constraint::ball([world().moved([NAN, 0.0, 0.0]), world()]);
    refused("pose of an attachment frame is NaN", || with(open));
    let rod = Constraint::distance([world(), world()], 1.0);
    let kind = ConstraintKind::Distance {
        anchors: [world(), world()],
        length: -1.0,
    };
    refused("the distance is -1", || rod.with_kind(kind));
}

fn on_frame(model: &Model, name: &str) -> Anchor {
    let anchor = Anchor::frame(model, name).expect("a link");
    anchor.moved([0.1, 0.0, 0.0])
}

#[test]
fn forces_on_frames_of_another_robot_are_refused_but_not_of_a_variant() {
    let push = |anchor| {
        let force = ExternalForce::constant(anchor, Force::zero(), Representation::Mixed);
        Simulator::new(samples::cartpole()).with_external_forces(vec![force])
    };
    refused("belongs to another robot than \"cartpole\"", || {
        push(on_frame(&samples::double_pendulum(), "lower"))
    });
    let heavy = samples::cartpole().with_gravity(vector![0.0, 0.0, -24.8]);
    let _ = push(on_frame(&heavy, "pole"));
}

#[test]
fn parameters_that_are_no_numbers_are_refused_by_name_over_every_scalar() {
    let model = samples::cartpole();
    let all = model.parameters();
    let layout = model.parameter_layout();
    for (name, bad) in [
        ("pole: mass", NAN),
        ("pivot: shift y", INFINITY),
        ("world: gravity z", -INFINITY),
        ("linear: damping", NAN),
        ("pivot: armature", INFINITY),
        ("pivot: stiffness", NAN),
    ] {
        let k = layout.find(name).expect("a parameter");
        let mut changed = all.clone();
        changed[k] = bad;
        let message = format!("the parameter \"{name}\" is {bad}: not finite");
        refused(&message, || model.with_parameters(changed.as_slice()));
        refused(&message, || {
            model.with_some_parameters(&[k], &[Dual64::from_re(bad)])
        });
        let lanes = Lanes([1.0, 1.0, bad, 1.0, 1.0, 1.0, 1.0, 1.0]);
        refused(&message, || model.with_some_parameters(&[k], &[lanes]));
    }
    // Finite differences step over zero.
    let damping = layout.find("linear: damping").expect("a parameter");
    let changed = model.with_some_parameters(&[damping], &[-1e-3]);
    assert_eq!(changed.parameters()[damping], -1e-3);
}
