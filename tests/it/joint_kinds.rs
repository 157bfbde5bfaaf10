//! Screw and universal joints: closed forms, the same mechanism from other joints, derivatives, and their form in files.

use dualbody::autodiff::finite_difference;
use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, SoftContact, Terrain};
use dualbody::dynamics::{
    bias_forces, centroidal_momentum_matrix, coriolis_matrix, forward_dynamics,
    forward_dynamics_derivatives, frame_jacobian, frame_jacobian_derivative, frame_pose,
    gravity_forces, inverse_dynamics, inverse_dynamics_derivatives, kinetic_energy, mass_matrix,
    mass_matrix_inverse, potential_energy,
};
use dualbody::joint::{JointKind, Pitch};
use dualbody::model::{
    BodyId, Collision, Geometry, JointSpec, Limits, LinkSpec, Mimic, ModelBuilder, SecondAxis,
    Spring, samples,
};
use dualbody::sim::Actuation;
use dualbody::spatial::{Representation, Transform};
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::{DMatrix, Rotation3, Vector3};

use crate::common::{
    FINITE_DIFFERENCE, OTHER_ALGORITHM, SAME_ALGEBRA, assert_close, assert_close_vector, generator,
    random_point, relative_error,
};

const H: f64 = 0.03;
const KINDS: [JointKind; 4] = [
    JointKind::Screw(Pitch::per_radian(0.1)),
    JointKind::Universal,
    JointKind::Revolute,
    JointKind::Spherical,
];

/// A nut of 2 kg and 0.05 kg m² on a lead screw along z.
fn nut() -> Model {
    let mut builder = ModelBuilder::new("nut");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("nut").with_mass(2.0, [0.0; 3], [0.1, 0.1, 0.05]));
    let screw = JointKind::Screw(Pitch::per_radian(H));
    builder.add_joint(JointSpec::new("thread", screw, "world", "nut").with_axis([0.0, 0.0, 3.0]));
    builder.build().unwrap()
}

// (m h² + J) q̈ = τ − m g h
#[test]
fn nut_on_a_lead_screw_falls_as_its_energy_says() {
    let (model, q, v) = (nut(), [0.7], [2.0]);
    let inertia = 2.0 * H * H + 0.05;
    assert!((mass_matrix(&model, &q)[0] - inertia).abs() < 1e-16);
    assert!((bias_forces(&model, &q, &v)[0] - 2.0 * 9.81 * H).abs() < 1e-15);
    let a = forward_dynamics(&model, &q, &v, &[0.1])[0];
    assert!((a - (0.1 - 2.0 * 9.81 * H) / inertia).abs() < 1e-13);
    let energy = 0.5 * inertia * 4.0;
    assert!((kinetic_energy(&model, &q, &v) - energy).abs() < 1e-15);
    assert!((potential_energy(&model, &q) - 2.0 * 9.81 * H * 0.7).abs() < 1e-14);
    let pose = frame_pose(&model, &q, model.frame("nut").unwrap());
    assert!((pose.translation - Vector3::new(0.0, 0.0, H * 0.7)).norm() < 1e-16);
    let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.7);
    assert!((pose.rotation - turned.matrix()).norm() < 1e-15);
    assert!((Pitch::per_turn(H).metres_per_radian() * std::f64::consts::TAU - H).abs() < 1e-17);
}

/// An arm whose first joint and whose last are those of a function: on the world, or on the arm.
fn arm_of(joint: impl Fn(&mut ModelBuilder, &str, &str, &str)) -> Model {
    let mut builder = ModelBuilder::new("arm");
    builder.add_link(LinkSpec::new("world"));
    for (k, link) in ["a", "b", "c"].into_iter().enumerate() {
        let com = [0.1, -0.05 * k as f64, 0.2];
        builder.add_link(LinkSpec::new(link).with_mass(1.0 + k as f64, com, [0.2, 0.15, 0.1]));
    }
    joint(&mut builder, "first", "world", "a");
    let hinge = JointSpec::new("hinge", JointKind::Revolute, "a", "b");
    builder.add_joint(
        hinge
            .with_translation([0.1, 0.2, 0.3])
            .with_axis([1.0, 2.0, 0.5]),
    );
    joint(&mut builder, "last", "b", "c");
    builder.build().unwrap()
}

const FIRST: [f64; 3] = [0.2, 1.0, -0.4];
const SECOND: [f64; 3] = [1.0, 0.3, 0.5];

fn placed(spec: JointSpec) -> JointSpec {
    let rotation = *Rotation3::from_euler_angles(0.3, -0.5, 0.8).matrix();
    spec.with_placement(Transform::new(rotation, Vector3::new(0.1, 0.0, -0.2)))
}

fn with_universal() -> Model {
    arm_of(|builder, name, parent, child| {
        let second = SecondAxis {
            damping: 0.4,
            armature: 0.07,
            ..SecondAxis::about(SECOND)
        };
        let spec = placed(JointSpec::new(name, JointKind::Universal, parent, child));
        let spec = spec.with_axis(FIRST).with_damping(0.2).with_armature(0.03);
        builder.add_joint(spec.with_second_axis(second));
    })
}

fn with_two_hinges() -> Model {
    arm_of(|builder, name, parent, child| {
        let cross = format!("{name}_cross");
        builder.add_link(LinkSpec::new(&cross));
        let spec = placed(JointSpec::new(name, JointKind::Revolute, parent, &cross));
        builder.add_joint(spec.with_axis(FIRST).with_damping(0.2).with_armature(0.03));
        let second = JointSpec::new(format!("{name}2"), JointKind::Revolute, cross, child);
        builder.add_joint(
            second
                .with_axis(SECOND)
                .with_damping(0.4)
                .with_armature(0.07),
        );
    })
}

fn with_screws() -> Model {
    arm_of(|builder, name, parent, child| {
        let kind = JointKind::Screw(Pitch::per_radian(-H));
        builder.add_joint(placed(JointSpec::new(name, kind, parent, child)).with_axis(FIRST));
    })
}

/// A turn, and a slide along its axis that follows it.
fn with_followers() -> Model {
    arm_of(|builder, name, parent, child| {
        let carriage = format!("{name}_carriage");
        builder.add_link(LinkSpec::new(&carriage));
        let turn = placed(JointSpec::new(name, JointKind::Revolute, parent, &carriage));
        builder.add_joint(turn.with_axis(FIRST));
        let follows = Mimic {
            leader: name.into(),
            multiplier: -H,
            offset: 0.0,
        };
        let slide = JointSpec::new(
            format!("{name}_slide"),
            JointKind::Prismatic,
            carriage,
            child,
        );
        builder.add_joint(slide.with_axis(FIRST).with_mimic(follows));
    })
}

/// Dynamics, kinematics and first derivatives at a random point.
fn assert_same(model: &Model, other: &Model) {
    for seed in 0..5 {
        let point = random_point(model, seed);
        let (q, v, w) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let name = model.name();
        let both = |f: &dyn Fn(&Model) -> DMatrix<f64>, what: &str| {
            assert_close(
                &f(model),
                &f(other),
                OTHER_ALGORITHM,
                &format!("{name}: {what}"),
            );
        };
        let column =
            |x: nalgebra::DVector<f64>| DMatrix::from_column_slice(x.len(), 1, x.as_slice());
        both(&|m| mass_matrix(m, q), "mass matrix");
        both(&|m| mass_matrix_inverse(m, q), "its inverse");
        both(
            &|m| column(inverse_dynamics(m, q, v, w)),
            "inverse dynamics",
        );
        both(
            &|m| column(forward_dynamics(m, q, v, w)),
            "forward dynamics",
        );
        both(&|m| column(gravity_forces(m, q)), "gravity");
        both(&|m| column(coriolis_matrix(m, q, v) * &point.v), "Coriolis");
        both(
            &|m| column(centroidal_momentum_matrix(m, q) * &point.v),
            "momentum",
        );
        both(&|m| inverse_dynamics_derivatives(m, q, v, w).dq, "∂τ/∂q");
        both(&|m| inverse_dynamics_derivatives(m, q, v, w).dv, "∂τ/∂v");
        both(&|m| forward_dynamics_derivatives(m, q, v, w).dq, "∂a/∂q");
        both(&|m| forward_dynamics_derivatives(m, q, v, w).dv, "∂a/∂v");
        for representation in [
            Representation::Body,
            Representation::Mixed,
            Representation::Inertial,
        ] {
            both(
                &|m| frame_jacobian(m, q, m.frame("c").unwrap(), representation),
                "Jacobian",
            );
            both(
                &|m| frame_jacobian_derivative(m, q, v, m.frame("c").unwrap(), representation),
                "its rate",
            );
        }
    }
}

#[test]
fn universal_joint_equals_two_revolute_joints_with_a_massless_link() {
    let (one, two) = (with_universal(), with_two_hinges());
    assert_same(&one, &two);
    assert_eq!(one.damping(), two.damping());
    assert_eq!((one.n_joints(), two.n_joints()), (3, 5));
}

#[test]
fn screw_joint_equals_a_turn_and_a_slide_that_follows_it() {
    assert_same(&with_screws(), &with_followers());
}

// Hooke's joint: Rx(q₀) Ry(q₁).
#[test]
fn universal_joint_is_one_joint_with_two_coordinates() {
    let model = with_universal();
    assert_eq!(model.joint_names(), ["first", "hinge", "last"]);
    assert_eq!((model.nq(), model.nv(), model.n_bodies()), (5, 5, 5));
    let last = model.joint("last").unwrap();
    assert_eq!((model.joint_q(last), model.joint_v(last)), (3..5, 3..5));
    let bodies = (0..model.n_bodies()).map(BodyId);
    let own: Vec<_> = bodies
        .filter(|&body| model.body_joint(body) == Some(last))
        .collect();
    assert_eq!((own.len(), own.last()), (2, Some(&model.joint_body(last))));
    assert_eq!(model.body_name(own[0]), "last::cross");
    assert_eq!(model.body_name(own[1]), "c");
    assert_eq!(model.link_names(), ["world", "a", "b", "c"]);
    assert_eq!(model.joints()[last.0].kind, JointKind::Universal);

    let mut builder = ModelBuilder::new("hooke");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("shaft").with_mass(1.0, [0.0; 3], [0.1; 3]));
    builder.add_joint(JointSpec::new(
        "hooke",
        JointKind::Universal,
        "world",
        "shaft",
    ));
    let model = builder.build().unwrap();
    let (q, shaft) = ([0.4, -0.9], model.frame("shaft").unwrap());
    let expected = Rotation3::from_axis_angle(&Vector3::x_axis(), q[0])
        * Rotation3::from_axis_angle(&Vector3::y_axis(), q[1]);
    let error = frame_pose(&model, &q, shaft).rotation - expected.matrix();
    assert!(error.amax() < 1e-15, "{error}");
    let locked = model.with_locked_joints(&[("hooke", &q)]).unwrap();
    let held = frame_pose(&locked, &[], locked.frame("shaft").unwrap());
    assert!((held.rotation - expected.matrix()).amax() < 1e-15);
}

#[test]
fn second_axis_has_limits_springs_and_actuators_of_its_own() {
    let limits = |upper: f64| Limits {
        lower: Some(-0.1),
        upper: Some(upper),
        velocity: Some(upper),
        effort: Some(10.0 * upper),
    };
    let mut builder = ModelBuilder::new("cardan");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("shaft").with_mass(1.0, [0.0, 0.0, 0.3], [0.1; 3]));
    let second = SecondAxis {
        limits: limits(0.2),
        spring: Spring {
            stiffness: 7.0,
            rest: 0.5,
        },
        ..SecondAxis::about([0.0, 1.0, 0.0])
    };
    let spec = JointSpec::new("cardan", JointKind::Universal, "world", "shaft");
    let spec = spec.with_limits(limits(0.1)).with_spring(5.0, 0.0);
    builder.add_joint(spec.with_second_axis(second));
    let model = builder.build().unwrap();
    let mut rng = generator(3);
    let mut largest = [0.0_f64; 2];
    for _ in 0..200 {
        let (q, v) = (
            model.random_configuration(&mut rng),
            model.random_velocity(&mut rng, 9.0),
        );
        for k in 0..2 {
            assert!((-0.1..=[0.1, 0.2][k]).contains(&q[k]) && v[k].abs() <= [0.1, 0.2][k]);
            largest[k] = largest[k].max(q[k]);
        }
    }
    assert!(largest[0] > 0.09 && largest[1] > 0.19, "{largest:?}");
    assert_eq!(
        (model.springs()[0].stiffness, model.springs()[1].stiffness),
        (5.0, 7.0)
    );
    let actuation = Actuation::from_model(&model);
    let efforts: Vec<_> = actuation.actuators().iter().map(|a| a.effort).collect();
    assert_eq!(efforts, [Some(1.0), Some(2.0)]);
    let names = model.parameter_layout();
    let rest = names.find("cardan.1: rest").unwrap();
    assert_eq!(model.parameters()[rest], 0.5);
    let edited = model.clone().with_damping(1, 0.3).with_armature(0, 0.2);
    let rebuilt = edited.to_builder().build().unwrap();
    assert_eq!(rebuilt.damping(), [0.0, 0.3]);
    assert_eq!(rebuilt.armature(), [0.2, 0.0]);
    assert_eq!(rebuilt.springs(), model.springs());
    assert!(
        model.tree().to_string().contains("then (0, 1, 0)"),
        "{}",
        model.tree()
    );
}

#[test]
fn universal_joint_with_parallel_axes_or_a_hinge_with_two_is_refused() {
    let build = |kind, second| {
        let mut builder = ModelBuilder::new("bad");
        builder.add_link(LinkSpec::new("world"));
        builder.add_link(LinkSpec::new("link").with_mass(1.0, [0.0; 3], [0.1; 3]));
        let spec = JointSpec::new("joint", kind, "world", "link").with_axis([0.0, 0.0, 2.0]);
        builder.add_joint(spec.with_second_axis(SecondAxis::about(second)));
        builder.build().unwrap_err().to_string()
    };
    let parallel = build(JointKind::Universal, [0.0, 0.0, -1.0]);
    assert!(
        parallel.contains("\"joint\"") && parallel.contains("parallel"),
        "{parallel}"
    );
    let hinge = build(JointKind::Revolute, [1.0, 0.0, 0.0]);
    assert!(
        hinge.contains("\"joint\"") && hinge.contains("revolute"),
        "{hinge}"
    );
    let nothing = build(JointKind::Universal, [0.0; 3]);
    assert!(nothing.contains("\"joint\""), "{nothing}");
}

#[test]
fn dynamics_of_trees_of_the_kinds_obey_their_identities() {
    for seed in 0..6 {
        let model = samples::random_tree_of(&KINDS, 9, seed);
        let point = random_point(&model, seed);
        let (q, v, w) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let (m, bias) = (mass_matrix(&model, q), bias_forces(&model, q, v));
        let tau = inverse_dynamics(&model, q, v, w);
        assert_close_vector(&(&m * &point.w + &bias), &tau, SAME_ALGEBRA, "M a + h");
        let a = forward_dynamics(&model, q, v, tau.as_slice());
        assert_close_vector(&a, &point.w, OTHER_ALGORITHM, "forward of inverse");
        let energy = 0.5 * point.v.dot(&(&m * &point.v));
        assert!((kinetic_energy(&model, q, v) - energy).abs() < SAME_ALGEBRA * m.amax().max(1.0));
        let forces = coriolis_matrix(&model, q, v) * &point.v + gravity_forces(&model, q);
        assert_close_vector(&forces, &bias, SAME_ALGEBRA, "C v + g");
        let step = point.v.map(|v| 0.3 * v.clamp(-1.0, 1.0));
        let moved = model.integrate(q, step.as_slice());
        let back = model.difference(q, moved.as_slice());
        assert_close_vector(&back, &step, SAME_ALGEBRA, "difference of integrate");
    }
}

#[test]
fn step_jacobians_over_the_kinds_equal_finite_differences() {
    for (seed, integrator) in [
        Integrator::SemiImplicitEuler,
        Integrator::ImplicitVelocity,
        Integrator::RungeKutta4,
    ]
    .into_iter()
    .enumerate()
    {
        let model = samples::random_tree_of(&KINDS, 6, seed as u64);
        let simulator = Simulator::new(model.clone())
            .with_time_step(5e-3)
            .with_integrator(integrator);
        let point = random_point(&model, seed as u64);
        let u: Vec<f64> = simulator.actuated().iter().map(|&k| point.w[k]).collect();
        let state = State::new(point.q.as_slice(), point.v.as_slice());
        let exact = simulator.linearize(&state, &u);
        let numeric = simulator
            .estimate_linearization(&state, &u, &finite_difference::Options::default())
            .linearization;
        let errors = [
            relative_error(&exact.a, &numeric.a),
            relative_error(&exact.b, &numeric.b),
        ];
        assert!(
            errors[0].max(errors[1]) < FINITE_DIFFERENCE,
            "{integrator:?}: {errors:?}"
        );
    }
}

/// A foot that turns on a screw on a universal joint, pressed into the ground.
#[test]
fn contact_jacobians_over_the_kinds_equal_finite_differences() {
    let foot = LinkSpec::new("foot").with_mass(0.5, [0.1, 0.05, -0.1], [0.02, 0.03, 0.01]);
    let mut builder = ModelBuilder::new("leg");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("leg").with_mass(1.0, [0.0, 0.0, -0.1], [0.03, 0.02, 0.02]));
    builder.add_link(foot.with_collision(Collision {
        name: None,
        placement: Transform::from_translation(Vector3::new(0.2, 0.1, -0.2)),
        geometry: Geometry::Sphere { radius: 0.05 },
    }));
    let hip = JointSpec::new("hip", JointKind::Universal, "world", "leg");
    builder.add_joint(hip.with_translation([0.0, 0.0, 0.5]));
    let screw = JointKind::Screw(Pitch::per_radian(0.1));
    let thread = JointSpec::new("thread", screw, "leg", "foot").with_axis([0.1, 0.2, 1.0]);
    builder.add_joint(thread.with_translation([0.0, 0.0, -0.2]));
    let model = builder.build().unwrap();
    let laws = [
        ContactLaw::Soft(SoftContact::estimate(1.5, 1, 1e-3)),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
    ];
    for law in laws {
        let (q, v) = ([0.1, -0.2, 0.3], [0.2, -0.1, -0.4]);
        let frame = frame_pose(&model, &q, model.frame("foot").unwrap());
        let point = frame.point(&Vector3::new(0.2, 0.1, -0.2));
        let ground = Terrain::flat(point.z - 0.05 + 1e-3);
        let contacts = Contacts::new(&model, ground, law);
        let simulator = Simulator::new(model.clone())
            .with_contacts(contacts)
            .with_actuated_joints(&[])
            .unwrap()
            .with_time_step(1e-3);
        let state = simulator.state(&q, &v);
        crate::common::ground::assert_derivatives(&simulator, &state, "a foot on a screw");
    }
}

#[test]
fn energy_of_trees_of_the_kinds_stays_without_damping() {
    let kinds = [
        JointKind::Screw(Pitch::per_radian(0.1)),
        JointKind::Universal,
    ];
    let mut model = samples::random_tree_of(&kinds, 4, 2);
    for k in 0..model.nv() {
        model = model.with_damping(k, 0.0);
    }
    let energy = |state: &State| {
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        kinetic_energy(&model, q, v) + potential_energy(&model, q)
    };
    let simulator = Simulator::new(model.clone())
        .with_time_step(1e-3)
        .with_integrator(Integrator::RungeKutta4);
    let point = random_point(&model, 4);
    let start = State::new(point.q.as_slice(), (point.v * 0.3).as_slice());
    let u = vec![0.0; simulator.nu()];
    let mut state = start.clone();
    for _ in 0..200 {
        state = simulator.step(&state, &u);
    }
    assert!((&state.q - &start.q).norm() > 0.01);
    let (before, after) = (energy(&start), energy(&state));
    assert!(
        (after - before).abs() < 1e-7 * before.abs().max(1.0),
        "{before} and {after}"
    );
}

#[test]
fn files_hold_universal_joints_as_hinges_and_screws_where_they_can() {
    let model = with_universal();
    let urdf = Model::from_urdf_str(&model.to_urdf().unwrap()).unwrap();
    assert_eq!(urdf.joint_names().len(), 5);
    let point = random_point(&model, 1);
    let (q, v) = (point.q.as_slice(), point.v.as_slice());
    // URDF has no armature.
    let mut bare = model.clone();
    for k in 0..bare.nv() {
        bare = bare.with_armature(k, 0.0);
    }
    assert_close(
        &mass_matrix(&urdf, q),
        &mass_matrix(&bare, q),
        OTHER_ALGORITHM,
        "written M",
    );
    assert_close_vector(
        &bias_forces(&urdf, q, v),
        &bias_forces(&bare, q, v),
        OTHER_ALGORITHM,
        "h",
    );
    let mjcf = model.to_mjcf().unwrap();
    assert_eq!(mjcf.matches("type=\"hinge\"").count(), 5, "{mjcf}");
    assert!(mjcf.contains("name=\"last_second\""), "{mjcf}");
    assert_eq!(mjcf.matches("<motor").count(), 5, "{mjcf}");

    let screw = nut().to_urdf().unwrap_err().to_string();
    assert!(
        screw.contains("\"thread\"") && screw.contains("screw"),
        "{screw}"
    );
    let mjcf = nut().to_mjcf().unwrap();
    let tie = "joint1=\"thread_advance\" joint2=\"thread\" polycoef=\"0 0.03 0 0 0\"";
    assert!(
        mjcf.contains(tie) && mjcf.contains("type=\"slide\""),
        "{mjcf}"
    );
    // Twice as long, it advances twice as far.
    let long = nut().scaled(2.0, 1.0).unwrap();
    assert_eq!(
        long.joints()[0].kind,
        JointKind::Screw(Pitch::per_radian(2.0 * H))
    );
}
