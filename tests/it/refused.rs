//! Numbers and ids that make no sense are refused where they are given, and infinite friction sticks.

use std::panic::{AssertUnwindSafe, catch_unwind};

use dualbody::constraint::{Anchor, Constraint, ConstraintKind};
use dualbody::contact::{
    ContactLaw, ContactPoint, Contacts, Feature, HuntCrossley, Impedance, Material, Materials,
    Plane, Reference, RelaxedRigid, Rigid, SoftContact, Terrain,
};
use dualbody::dynamics::{frame_jacobian, frame_pose, frame_velocity};
use dualbody::model::{
    BodyId, Collision, FrameId, Geometry, JointId, JointSpec, LinkSpec, Mass, ModelBuilder, Spring,
    samples,
};
use dualbody::sim::{
    Actuation, Actuator, CoulombFriction, ExternalForce, PositionLimits, TorqueSpeed, VelocityLimit,
};
use dualbody::spatial::{Force, Inertia, Representation, Transform};
use dualbody::{Integrator, Lanes, Model, Simulator};
use nalgebra::{Vector3, vector};
use num_dual::Dual64;

use crate::common::asset;
use crate::common::ground::{base_velocity, differences, free, run};

const NAN: f64 = f64::NAN;
const INFINITY: f64 = f64::INFINITY;

/// Runs what must panic, and compares what it says.
#[track_caller]
fn refused<R>(message: &str, work: impl FnOnce() -> R) {
    let caught = catch_unwind(AssertUnwindSafe(work)).err();
    let said = caught.expect(message);
    let said = said
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| said.downcast_ref::<&str>().copied())
        .expect("a message");
    assert!(said.contains(message), "\"{said}\" has no \"{message}\"");
}

fn soft() -> SoftContact {
    SoftContact::estimate(1.0, 4, 1e-3)
}

/// Laws with a number that makes no sense, and what is said of it.
fn senseless_laws() -> Vec<(ContactLaw, &'static str)> {
    let (rigid, relaxed) = (Rigid::default(), RelaxedRigid::default());
    let normal = |normal| ContactLaw::Soft(SoftContact { normal, ..soft() });
    let pushes = soft().normal;
    let mut out = vec![
        (
            normal(HuntCrossley {
                stiffness: -1.0,
                ..pushes
            }),
            "the stiffness of soft contact is -1",
        ),
        (
            normal(HuntCrossley {
                damping: NAN,
                ..pushes
            }),
            "the damping of soft contact is NaN",
        ),
        (
            normal(HuntCrossley {
                stiffness_exponent: -0.5,
                ..pushes
            }),
            "exponent of soft contact is -0.5",
        ),
        (
            normal(HuntCrossley::linear(0.0, 0.0)),
            "without stiffness and damping",
        ),
    ];
    for restitution in [1.5, -0.1, NAN] {
        let law = ContactLaw::Rigid(Rigid {
            restitution,
            ..rigid
        });
        out.push((law, "restitution of rigid contact is"));
    }
    for recovery_time in [0.0, -1.0, NAN, INFINITY] {
        let law = ContactLaw::Rigid(Rigid {
            recovery_time,
            ..rigid
        });
        out.push((law, "recovery time of rigid contact is"));
    }
    for friction in [-0.5, NAN] {
        let laws = [
            ContactLaw::Rigid(Rigid { friction, ..rigid }),
            ContactLaw::RelaxedRigid(RelaxedRigid {
                friction,
                ..relaxed
            }),
            ContactLaw::Soft(SoftContact { friction, ..soft() }),
        ];
        out.extend(laws.map(|law| (law, "the friction of")));
    }
    for d in [0.0, 1.0, NAN, -0.5] {
        let default = Impedance::default();
        for impedance in [
            Impedance {
                least: d,
                ..default
            },
            Impedance {
                largest: d,
                ..default
            },
        ] {
            let law = ContactLaw::RelaxedRigid(RelaxedRigid {
                impedance,
                ..relaxed
            });
            out.push((law, "impedance of"));
        }
    }
    let width = Impedance {
        width: 0.0,
        ..Impedance::default()
    };
    let references = [
        Reference::TimeConstant {
            time_constant: 0.0,
            damping_ratio: 1.0,
        },
        Reference::TimeConstant {
            time_constant: 0.02,
            damping_ratio: NAN,
        },
        Reference::Direct {
            stiffness: -1.0,
            damping: 1.0,
        },
        Reference::Direct {
            stiffness: 1.0,
            damping: INFINITY,
        },
    ];
    let law = |law| ContactLaw::RelaxedRigid(law);
    out.push((
        law(RelaxedRigid {
            impedance: width,
            ..relaxed
        }),
        "width of the impedance is 0",
    ));
    let referred = |reference| {
        law(RelaxedRigid {
            reference,
            ..relaxed
        })
    };
    out.extend(references.map(|reference| (referred(reference), "of relaxed rigid contact is")));
    out
}

#[test]
fn laws_with_senseless_numbers_are_refused_wherever_they_are_given() {
    let model = asset("box.urdf");
    for (law, message) in senseless_laws() {
        refused(message, || Contacts::new(&model, Terrain::flat(0.0), law));
        let good = match law {
            ContactLaw::Soft(_) => ContactLaw::Soft(soft()),
            ContactLaw::RelaxedRigid(_) => ContactLaw::RelaxedRigid(RelaxedRigid::default()),
            _ => ContactLaw::Rigid(Rigid::default()),
        };
        let contacts = Contacts::new(&model, Terrain::flat(0.0), good);
        let link = model.link_names()[0];
        refused(message, || contacts.clone().with_law(&model, link, law));
        refused(message, || {
            contacts.clone().with_point(contacts.points()[0], law)
        });
        refused(message, || contacts.with_laws(&[law; 8]));
        // In one lane only.
        let mut lanes = [good.cast::<Lanes<4>>(); 8];
        if let (ContactLaw::Rigid(lane), ContactLaw::Rigid(bad)) = (&mut lanes[3], law) {
            lane.friction.0[2] = bad.friction;
            lane.restitution.0[2] = bad.restitution;
            lane.recovery_time.0[2] = bad.recovery_time;
            refused(message, || contacts.cast::<Lanes<4>>().with_laws(&lanes));
        }
    }
}

#[test]
fn points_terrain_and_materials_with_senseless_numbers_are_refused() {
    let model = asset("box.urdf");
    let law = ContactLaw::Rigid(Rigid::default());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let point = contacts.points()[0];
    let axis = Vector3::z();
    for (feature, message) in [
        (
            Feature::Sphere { radius: -0.1 },
            "radius of a sphere is -0.1",
        ),
        (Feature::Sphere { radius: 0.0 }, "radius of a sphere is 0"),
        (
            Feature::Rim {
                axis,
                radius: NAN,
                angle: 0.0,
            },
            "radius of a rim is NaN",
        ),
        (
            Feature::Rim {
                axis,
                radius: 0.1,
                angle: NAN,
            },
            "angle on a rim is NaN",
        ),
        (
            Feature::Rim {
                axis: axis * 2.0,
                radius: 0.1,
                angle: 0.0,
            },
            "axis of a rim of length 2",
        ),
    ] {
        let point = ContactPoint { feature, ..point };
        refused(message, || contacts.clone().with_point(point, law));
    }
    let center = vector![0.0, NAN, 0.0];
    let lost = ContactPoint { center, ..point };
    refused("coordinate of a point of contact is NaN", || {
        contacts.clone().with_point(lost, law)
    });
    let plane = Terrain::Plane(Plane {
        height: NAN,
        slope: [0.0; 2],
    });
    refused("height or slope of the plane is NaN", || {
        contacts.clone().with_terrain(plane.clone())
    });
    refused("height or slope of the plane is NaN", || {
        Contacts::new(&model, plane.clone(), law)
    });
    let material = |friction, restitution| Material {
        friction,
        restitution,
    };
    let table = Materials::default();
    refused("the friction is NaN", || {
        table.clone().with_material("odd", material(NAN, 0.0))
    });
    refused("the restitution is 1.5", || {
        table.clone().with_material("odd", material(0.1, 1.5))
    });
}

#[test]
fn contacts_and_constraints_of_another_robot_are_refused() {
    let (model, other) = (asset("box.urdf"), samples::cartpole());
    let law = ContactLaw::Rigid(Rigid::default());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let message = "the contacts belong to another robot than \"cartpole\"";
    let simulator = Simulator::new(other.clone());
    refused(message, || {
        simulator.clone().with_contacts(contacts.clone())
    });
    refused(message, || contacts.states(&other, &[0.0; 2], &[0.0; 2]));
    refused(message, || contacts.clone().with_links(&other, &[]));
    // As large, but another one.
    let twin = asset("sphere.urdf");
    refused("another robot", || {
        Simulator::new(twin).with_contacts(contacts.clone())
    });
    // A robot that differs in numbers is no other robot.
    let heavy = model.clone().with_gravity(vector![0.0, 0.0, -1.6]);
    let _ = Simulator::new(heavy).with_contacts(contacts.clone());

    let nowhere = ContactPoint {
        body: BodyId(7),
        ..contacts.points()[0]
    };
    let lost = ContactPoint {
        link: FrameId(9),
        ..contacts.points()[0]
    };
    let with = |point| contacts.clone().with_point(point, law);
    let on_model = || Simulator::new(model.clone());
    refused("point 8 of contact is on body 7, but its link", || {
        on_model().with_contacts(with(nowhere))
    });
    refused("has no frame 9: it has 1", || {
        on_model().with_contacts(with(lost))
    });

    let chain = samples::double_pendulum();
    let actuation = Actuation::from_model(&chain);
    refused(
        "the actuators belong to another robot than \"cartpole\"",
        || simulator.clone().with_actuation(actuation),
    );
    let names: Vec<&str> = chain.joint_names();
    let coupler = Constraint::coupler(&chain, [names[0], names[1]], 1.0, 0.0).expect("joints");
    refused(
        "the joints of a constraint belong to another robot than \"cartpole\"",
        || simulator.clone().with_constraints(vec![coupler]),
    );
    // As many frames, under other numbers.
    let elsewhere = Anchor::frame(&chain, "lower")
        .expect("a link")
        .moved([0.1, 0.0, 0.0]);
    let pin = Constraint::ball([Anchor::world(), elsewhere]);
    refused(
        "the anchors of a constraint belong to another robot than \"cartpole\"",
        || simulator.clone().with_constraints(vec![pin]),
    );
    let push = ExternalForce::constant(elsewhere, Force::zero(), Representation::Mixed);
    refused("belongs to another robot than \"cartpole\"", || {
        simulator.clone().with_external_forces(vec![push])
    });
    // Of a variant they are taken.
    let heavy = simulator
        .model()
        .clone()
        .with_gravity(vector![0.0, 0.0, -24.8]);
    let own = Anchor::frame(&heavy, "pole").expect("a link");
    let push = ExternalForce::constant(own, Force::zero(), Representation::Mixed);
    let _ = simulator.clone().with_external_forces(vec![push]);
    let anchor = Anchor::new(Some(FrameId(30)), Transform::identity());
    let pin = Constraint::ball([anchor, Anchor::world()]);
    refused("\"cartpole\" has no frame 30", || {
        simulator.clone().with_constraints(vec![pin])
    });
    let open = Constraint::ball([Anchor::world().moved([NAN, 0.0, 0.0]), Anchor::world()]);
    refused("an anchor's placement is NaN", || {
        simulator.clone().with_constraints(vec![open])
    });
    let rod = Constraint::distance([Anchor::world(), Anchor::world()], 1.0);
    let kind = ConstraintKind::Distance {
        anchors: [Anchor::world(), Anchor::world()],
        length: -1.0,
    };
    refused("the distance is -1", || rod.with_kind(kind));
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
        let lanes = Lanes([1.0, 1.0, bad, 1.0]);
        refused(&message, || model.with_some_parameters(&[k], &[lanes]));
    }
    // Finite differences step over zero.
    let damping = layout.find("linear: damping").expect("a parameter");
    let changed = model.with_some_parameters(&[damping], &[-1e-3]);
    assert_eq!(changed.parameters()[damping], -1e-3);
}

#[test]
fn ids_out_of_range_are_refused_with_their_number() {
    let model = samples::cartpole();
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
    refused(message, || {
        model.clone().with_inertia(body, Inertia::zero())
    });
    refused(message, || {
        model.clone().with_placement(body, Transform::identity())
    });
    let message = "\"cartpole\" has no velocity coordinate 40: it has 2";
    refused(message, || model.clone().with_damping(40, 0.0));
    refused(message, || model.clone().with_armature(40, 0.0));
    refused(message, || {
        model.clone().with_spring(
            40,
            Spring {
                stiffness: 0.0,
                rest: 0.0,
            },
        )
    });
}

#[test]
fn models_with_senseless_numbers_are_refused() {
    let model = samples::cartpole();
    let own = || model.clone();
    refused("the gravity is NaN", || {
        own().with_gravity(vector![0.0, 0.0, NAN])
    });
    refused("the damping is -1000000000", || own().with_damping(0, -1e9));
    refused("the damping is NaN", || own().with_damping(0, NAN));
    refused("the armature is NaN", || own().with_armature(0, NAN));
    refused("the spring stiffness is -1", || {
        own().with_spring(
            0,
            Spring {
                stiffness: -1.0,
                rest: 0.0,
            },
        )
    });
    refused("rest position of a spring is NaN", || {
        own().with_spring(
            0,
            Spring {
                stiffness: 1.0,
                rest: NAN,
            },
        )
    });
    let broken = Inertia {
        mass: NAN,
        ..model.body(BodyId(0)).inertia
    };
    refused("the mass is NaN", || own().with_inertia(BodyId(0), broken));
    let placement = Transform::from_translation(vector![INFINITY, 0.0, 0.0]);
    refused("number of a placement is inf", || {
        own().with_placement(BodyId(1), placement)
    });
}

#[test]
fn descriptions_with_senseless_numbers_are_errors() {
    let shape = |geometry| {
        let collision = Collision {
            name: None,
            placement: Transform::identity(),
            geometry,
        };
        let mut builder = ModelBuilder::new("odd");
        let link = LinkSpec::new("link").with_mass(1.0, [0.0; 3], [1.0; 3]);
        builder.add_link(link.with_collision(collision));
        builder.build().expect_err("a senseless shape").to_string()
    };
    for (geometry, message) in [
        (
            Geometry::Sphere { radius: -0.1 },
            "radius = \"-0.1\": is negative",
        ),
        (
            Geometry::Sphere { radius: 0.0 },
            "radius = \"0\": is not positive",
        ),
        (
            Geometry::Cylinder {
                radius: 0.1,
                length: -1.0,
            },
            "length = \"-1\": is negative",
        ),
        (
            Geometry::Capsule {
                radius: NAN,
                length: 1.0,
            },
            "<collision> \"link\": size is not finite",
        ),
        (
            Geometry::Box {
                size: [1.0, -1.0, 1.0],
            },
            "size = \"-1\": is negative",
        ),
    ] {
        let error = shape(geometry);
        assert!(error.contains(message), "{error}");
    }
    let joint = |change: fn(JointSpec) -> JointSpec| {
        let mut builder = ModelBuilder::new("odd");
        builder.add_link(LinkSpec::new("world"));
        builder.add_link(LinkSpec::solid_sphere("ball", 0.1, Mass::Kilograms(1.0)));
        let joint = JointSpec::new(
            "joint",
            dualbody::joint::JointKind::Revolute,
            "world",
            "ball",
        );
        builder.add_joint(change(joint));
        builder.build().expect_err("a senseless joint").to_string()
    };
    for (change, message) in [
        (
            (|joint| joint.with_damping(-1.0)) as fn(JointSpec) -> JointSpec,
            "damping = \"-1\": is negative",
        ),
        (
            |joint| joint.with_armature(-1.0),
            "armature = \"-1\": is negative",
        ),
        (
            |joint| joint.with_spring(-1.0, 0.0),
            "spring stiffness = \"-1\": is negative",
        ),
    ] {
        let error = joint(change);
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn actuators_with_senseless_numbers_are_refused() {
    let model = samples::cartpole();
    let stop = HuntCrossley::linear(100.0, 1.0);
    let limits = PositionLimits {
        lower: Some(-1.0),
        upper: Some(1.0),
        stop,
    };
    let curve = TorqueSpeed {
        torque: 1.0,
        threshold: 1.0,
        maximum: 2.0,
    };
    let none = Actuator::default();
    let friction = |force, slip_velocity| Actuator {
        friction: Some(CoulombFriction {
            force,
            slip_velocity,
        }),
        ..none
    };
    let position = |position| Actuator {
        position: Some(position),
        ..none
    };
    let motor = |torque_speed| Actuator {
        torque_speed: Some(torque_speed),
        ..none
    };
    let speed = |speed, damping| Actuator {
        velocity: Some(VelocityLimit { speed, damping }),
        ..none
    };
    for (actuator, message) in [
        (
            Actuator {
                effort: Some(-1.0),
                ..none
            },
            "effort limit is -1",
        ),
        (friction(-1.0, 0.1), "force of Coulomb friction is -1"),
        (friction(1.0, 0.0), "slip velocity of Coulomb friction is 0"),
        (
            position(PositionLimits {
                lower: Some(NAN),
                ..limits
            }),
            "position limit is NaN",
        ),
        (
            position(PositionLimits {
                lower: Some(2.0),
                ..limits
            }),
            "lower position limit of 2 is above",
        ),
        (
            position(PositionLimits {
                stop: HuntCrossley::linear(-1.0, 0.0),
                ..limits
            }),
            "stiffness of a stop is -1",
        ),
        (
            motor(TorqueSpeed {
                torque: NAN,
                ..curve
            }),
            "torque of a motor is NaN",
        ),
        (
            motor(TorqueSpeed {
                maximum: 1.0,
                ..curve
            }),
            "is not above the threshold of 1",
        ),
        (speed(-1.0, 1.0), "speed limit is -1"),
        (speed(1.0, -1.0), "damping of a speed limit is -1"),
    ] {
        let ideal = || Actuation::ideal(&model);
        refused(message, || {
            ideal().with_actuator(&model, "linear", actuator)
        });
        refused(message, || ideal().with_actuators(&[none, actuator]));
    }
}

/// Laws with a friction for a box of 1 kg.
fn laws(friction: f64) -> [ContactLaw; 3] {
    [
        ContactLaw::Soft(SoftContact { friction, ..soft() }),
        ContactLaw::RelaxedRigid(RelaxedRigid {
            friction,
            ..RelaxedRigid::default()
        }),
        ContactLaw::Rigid(Rigid {
            friction,
            ..Rigid::default()
        }),
    ]
}

fn flat_box() -> Model {
    let mut builder = ModelBuilder::new("plate");
    builder.add_link(LinkSpec::solid_box(
        "plate",
        [0.5, 0.5, 0.05],
        Mass::Kilograms(1.0),
    ));
    builder.build().expect("a box")
}

#[test]
fn nothing_slips_with_infinite_friction() {
    let model = flat_box();
    for angle in [0.3, 1.2] {
        for law in laws(INFINITY) {
            let contacts = Contacts::new(&model, Terrain::incline(angle), law);
            let simulator = Simulator::new(model.clone())
                .with_integrator(Integrator::ImplicitVelocity)
                .with_contacts(contacts);
            let at = [-angle.sin() * 0.025, 0.0, angle.cos() * 0.025];
            let start = free(&simulator, at, -angle, [0.0; 6]);
            let end = run(&simulator, &start, 2.0);
            let down = vector![-angle.cos(), 0.0, -angle.sin()];
            let slid = vector![end.q[0] - at[0], end.q[1], end.q[2] - at[2]].dot(&down);
            let speed = base_velocity(&end).norm();
            // Relaxed contact creeps.
            let creep = if matches!(law, ContactLaw::RelaxedRigid(_)) {
                5e-2
            } else {
                2e-3
            };
            assert!(
                slid.abs() < creep && speed < creep,
                "{law:?}: {slid:e} at {speed:e}"
            );
            let a = simulator.linearize(&end, &[]).a;
            assert!(a.iter().all(|x| x.is_finite()), "{law:?}");
        }
    }
}

#[test]
fn derivatives_with_infinite_friction_equal_differences() {
    let model = asset("sphere.urdf");
    for law in laws(INFINITY) {
        let contacts = Contacts::new(&model, Terrain::incline(0.8), law);
        let simulator = Simulator::new(model.clone())
            .with_integrator(Integrator::ImplicitVelocity)
            .with_contacts(contacts);
        // Not at the middle of the sigmoid, where the law has a jump in its second derivative.
        let height = 0.0997;
        let at = [-f64::sin(0.8) * height, 0.0, f64::cos(0.8) * height];
        let state = free(&simulator, at, 0.3, [0.1, -0.2, -0.1, 0.3, -2.0, 0.4]);
        let a = simulator.linearize(&state, &[]).a;
        let expected = differences(&simulator, &state, 1e-7);
        let error = (&a - &expected).amax() / expected.amax();
        assert!(error < 1e-5, "{law:?}: {error:e}");
    }
}

#[test]
fn infinite_friction_of_a_material_leaves_that_of_the_other() {
    let material = |friction| Material {
        friction,
        restitution: 0.0,
    };
    let table = Materials::default()
        .with_material("glue", material(INFINITY))
        .with_material("wood", material(0.4))
        .with_material("ice", material(0.0));
    let between = |a, b| table.between(a, b).expect("materials").friction;
    assert_eq!(between("glue", "glue"), INFINITY);
    assert_eq!(between("glue", "wood"), 0.8);
    assert_eq!(between("glue", "ice"), 0.0);
}

#[test]
fn soft_contact_without_a_damper_is_a_spring() {
    let model = asset("sphere.urdf");
    let law = SoftContact {
        normal: HuntCrossley::linear(1e4, 0.0),
        friction: 0.5,
    };
    let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Soft(law));
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(1e-4);
    let start = free(
        &simulator,
        [0.0, 0.0, 0.15],
        0.0,
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    let end = run(&simulator, &start, 1.0);
    assert!(
        end.q.iter().chain(end.v.iter()).all(|x| x.is_finite()),
        "{end:?}"
    );
    assert!(end.q[2] > 0.05, "{end:?}");
}
