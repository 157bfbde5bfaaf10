//! Joints that follow others, rotors and springs, against the same robot with every joint free.

use dualbody::dynamics::{
    bias_forces, coriolis_matrix, elastic_energy, forward_dynamics, frame_bias_acceleration,
    frame_jacobian, frame_pose, kinetic_energy, mass_matrix, passive_forces,
};
use dualbody::joint::JointKind;
use dualbody::model::{
    FrameId, JointSpec, LinkSpec, Mass, Mimic, Mimicry, Model, ModelBuilder, Object, Spring, World,
    samples,
};
use dualbody::spatial::{Representation, Transform};
use dualbody::{Integrator, LoadError, Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::{
    OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA, assert_close, assert_close_vector, gripper,
    random_point,
};

/// The robot with mimic joints, and the same with six free joints.
fn both() -> (Model, Model) {
    let coupled = gripper().build().expect("a gripper");
    let mut free = gripper();
    free.mimicry = Mimicry::Independent;
    let free = free.build().expect("a gripper");
    assert_eq!((coupled.nv(), free.nv()), (3, 6));
    (coupled, free)
}

/// `q_free` = G q + o, `v_free` = G v in depth-first order: shoulder, elbow, left; thumb and tip follow the shoulder,
/// right the left.
fn map() -> (DMatrix<f64>, DVector<f64>) {
    let mut g = DMatrix::zeros(6, 3);
    let rows = [
        (0, 0, 1.0),
        (1, 1, 1.0),
        (2, 2, 1.0),
        (3, 0, -0.7),
        (4, 0, -1.4),
        (5, 2, 1.0),
    ];
    rows.into_iter()
        .for_each(|(row, column, ratio)| g[(row, column)] = ratio);
    (
        g,
        DVector::from_vec(vec![0.0, 0.0, 0.0, 0.3, 2.0 * 0.3 - 0.1, 0.0]),
    )
}

fn for_all(check: impl Fn(&Model, &Model, [&DVector<f64>; 2], [&DVector<f64>; 2], &DMatrix<f64>)) {
    let (coupled, free) = both();
    let (g, o) = map();
    for seed in 0..5 {
        let point = random_point(&coupled, seed);
        let (q, v) = (&g * &point.q + &o, &g * &point.v);
        check(&coupled, &free, [&point.q, &point.v], [&q, &v], &g);
    }
}

#[test]
fn coupled_mass_matrix_equals_the_projected_free_one() {
    for_all(|coupled, free, [q, _], [q_free, _], g| {
        let expected = g.transpose() * mass_matrix(free, q_free.as_slice()) * g;
        assert_close(
            &mass_matrix(coupled, q.as_slice()),
            &expected,
            SAME_ALGEBRA,
            "M = Gᵀ M G",
        );
    });
}

#[test]
fn coupled_bias_coriolis_and_energy_equal_the_projected_free_ones() {
    for_all(|coupled, free, [q, v], [q_free, v_free], g| {
        let of = |model, q: &DVector<f64>, v: &DVector<f64>| {
            bias_forces(model, q.as_slice(), v.as_slice())
        };
        assert_close_vector(
            &of(coupled, q, v),
            &(g.transpose() * of(free, q_free, v_free)),
            SAME_ALGEBRA,
            "h = Gᵀ h",
        );
        let coriolis =
            g.transpose() * coriolis_matrix(free, q_free.as_slice(), v_free.as_slice()) * g;
        assert_close(
            &coriolis_matrix(coupled, q.as_slice(), v.as_slice()),
            &coriolis,
            SAME_ALGEBRA,
            "C = Gᵀ C G",
        );
        let energy = kinetic_energy(coupled, q.as_slice(), v.as_slice());
        assert!(
            (energy - kinetic_energy(free, q_free.as_slice(), v_free.as_slice())).abs()
                < SAME_ALGEBRA
        );
    });
}

#[test]
fn coupled_springs_and_damping_equal_the_projected_free_ones_up_to_a_constant_of_energy() {
    let (g, o) = map();
    let elastic = |seed: u64| {
        let (coupled, free) = both();
        let q = random_point(&coupled, seed).q;
        elastic_energy(&coupled, q.as_slice()) - elastic_energy(&free, (&g * q + &o).as_slice())
    };
    assert!(
        (elastic(0) - elastic(1)).abs() < SAME_ALGEBRA * 10.0,
        "{} against {}",
        elastic(0),
        elastic(1)
    );
    for_all(|coupled, free, [q, v], [q_free, v_free], g| {
        let expected = g.transpose() * passive_forces(free, q_free.as_slice(), v_free.as_slice());
        assert_close_vector(
            &passive_forces(coupled, q.as_slice(), v.as_slice()),
            &expected,
            SAME_ALGEBRA,
            "springs",
        );
    });
}

#[test]
fn coupled_frames_equal_the_free_ones() {
    for_all(|coupled, free, [q, v], [q_free, v_free], g| {
        for frame in (0..coupled.frames().len()).map(FrameId) {
            let pose = frame_pose(coupled, q.as_slice(), frame);
            assert!(
                (pose.translation - frame_pose(free, q_free.as_slice(), frame).translation).norm()
                    < SAME_ALGEBRA
            );
            let jacobian =
                frame_jacobian(free, q_free.as_slice(), frame, Representation::Mixed) * g;
            assert_close(
                &frame_jacobian(coupled, q.as_slice(), frame, Representation::Mixed),
                &jacobian,
                SAME_ALGEBRA,
                "J = J G",
            );
            let bias = |model, q: &DVector<f64>, v: &DVector<f64>| {
                frame_bias_acceleration(
                    model,
                    q.as_slice(),
                    v.as_slice(),
                    frame,
                    Representation::Mixed,
                )
                .linear
            };
            assert!((bias(coupled, q, v) - bias(free, q_free, v_free)).norm() < 1e-11);
        }
    });
}

// M = GᵀMG is solved, so the free robot held on the constraint by λ: M G v̇ + h = τ + λ with Gᵀ λ = 0.
#[test]
fn coupled_forward_dynamics_obeys_the_projected_equation_of_motion() {
    for_all(|coupled, free, [q, v], [q_free, v_free], g| {
        let tau = DVector::from_vec(vec![0.3, -1.0, 0.7]);
        let a = forward_dynamics(coupled, q.as_slice(), v.as_slice(), tau.as_slice());
        let m = mass_matrix(free, q_free.as_slice());
        let residual = m * g * a + bias_forces(free, q_free.as_slice(), v_free.as_slice());
        assert_close_vector(
            &(g.transpose() * residual),
            &tau,
            OTHER_ALGORITHM,
            "projected equation",
        );
    });
}

/// Accelerations of a part of a world, and the same of that part alone.
fn accelerations(
    world: &Model,
    alone: &Model,
    tau: &DVector<f64>,
    [first_q, first_v]: [usize; 2],
) -> [DVector<f64>; 2] {
    let point = random_point(world, 11);
    let all = forward_dynamics(
        world,
        point.q.as_slice(),
        point.v.as_slice(),
        tau.as_slice(),
    );
    let q = &point.q.as_slice()[first_q..first_q + alone.nq()];
    let own = first_v..first_v + alone.nv();
    let v = &point.v.as_slice()[own.clone()];
    let expected = forward_dynamics(alone, q, v, &tau.as_slice()[own.clone()]);
    [all.rows_range(own).into_owned(), expected]
}

// Followers connect the branches of their own robot, and nothing else.
#[test]
fn coupled_robots_and_others_accelerate_in_a_world_as_alone() {
    let (coupled, _) = both();
    let arm = samples::arm();
    let mut world = World::default();
    let ball = Object::free(Mass::Kilograms(0.5));
    world.add_sphere("a", 0.1, &ball).expect("a ball");
    let ball = world.build().expect("a world");
    for (name, robot) in [("b/", &coupled), ("c/", &arm), ("d/", &coupled)] {
        (world.add(robot, name, &Transform::identity())).expect("a member");
    }
    let world = world.build().expect("a world");
    let tau = DVector::from_fn(world.nv(), |k, _| 0.3 * (k as f64).cos());
    // Members are in the order of their names.
    let (mut q, mut v) = (0, 0);
    for alone in [&ball, &coupled, &arm, &coupled] {
        let [actual, expected] = accelerations(&world, alone, &tau, [q, v]);
        assert_close_vector(&actual, &expected, OTHER_ALGORITHM, alone.name());
        (q, v) = (q + alone.nq(), v + alone.nv());
    }
    assert_eq!((q, v), (world.nq(), world.nv()));
}

#[test]
fn followers_have_no_input_and_report_the_coordinates_of_their_leaders() {
    let (coupled, _) = both();
    let simulator = Simulator::new(coupled.clone());
    assert_eq!(simulator.nu(), 3);
    let joint = |name| coupled.joint(name).expect("a joint");
    assert_eq!(
        coupled.joint_q(joint("tip_joint")),
        coupled.joint_q(joint("shoulder_joint"))
    );
    let rollout = simulator.rollout(&State::neutral(&coupled), 10, |_, _, _| {});
    assert_eq!(rollout.last().q.len(), 3);
}

// A rotor of inertia J on a pendulum of inertia 1/3: (1/3 + J) v̇ = τ − ½ g sin q.
#[test]
fn armature_adds_to_the_inertia_of_the_joint_alone() {
    let model = samples::pendulum().with_armature(0, 0.5);
    let (q, tau) = (0.7_f64, 2.0);
    let expected = (tau - 0.5 * 9.81 * q.sin()) / (1.0 / 3.0 + 0.5);
    assert!((forward_dynamics(&model, &[q], &[0.0], &[tau])[0] - expected).abs() < SAME_ALGEBRA);
    assert!(
        (kinetic_energy(&model, &[q], &[2.0]) - 2.0 * (1.0 / 3.0 + 0.5)).abs() < 10.0 * ROUNDING
    );
}

// m q̈ = −k (q − r): q = r + (q₀ − r) cos ωt with ω² = k / m.
#[test]
fn spring_swings_as_its_closed_form() {
    let mut builder = ModelBuilder::new("oscillator");
    builder
        .add_link(LinkSpec::new("world"))
        .add_link(LinkSpec::new("block").with_mass(2.0, [0.0; 3], [0.1; 3]));
    builder.add_joint(
        JointSpec::new("slide", JointKind::Prismatic, "world", "block").with_spring(8.0, 0.3),
    );
    let model = builder.build().expect("an oscillator");
    assert_eq!(
        model.springs(),
        [Spring {
            stiffness: 8.0,
            rest: 0.3
        }]
    );
    let simulator = Simulator::new(model)
        .with_time_step(1e-3)
        .with_integrator(Integrator::RungeKutta4);
    let rollout = simulator.rollout(&State::new(&[1.3], &[0.0]), 1000, |_, _, _| {});
    assert!((rollout.last().q[0] - (0.3 + 2.0_f64.cos())).abs() < 1e-10);
}

fn refused(change: impl Fn(JointSpec) -> JointSpec) -> String {
    let mut builder = gripper();
    builder.add_link(LinkSpec::new("extra").with_mass(1.0, [0.0; 3], [0.1; 3]));
    builder.add_joint(change(JointSpec::new(
        "extra_joint",
        JointKind::Revolute,
        "elbow",
        "extra",
    )));
    match builder.build() {
        Err(error @ (LoadError::InvalidMimic { .. } | LoadError::Malformed { .. })) => {
            error.to_string()
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn impossible_followers_and_springs_are_refused_by_name() {
    let follow = |leader: &str| Mimic {
        leader: leader.into(),
        multiplier: 1.0,
        offset: 0.0,
    };
    for (leader, reason) in [("extra_joint", "itself"), ("nobody", "no such joint")] {
        let message = refused(|joint| joint.with_mimic(follow(leader)));
        assert!(
            message.contains("extra_joint") && message.contains(reason),
            "{message}"
        );
    }
    let mut circle = gripper();
    for (name, leader) in [("a", "b"), ("b", "a")] {
        circle.add_link(LinkSpec::new(name).with_mass(1.0, [0.0; 3], [0.1; 3]));
        circle.add_joint(
            JointSpec::new(name, JointKind::Revolute, "elbow", name).with_mimic(follow(leader)),
        );
    }
    assert!(
        circle
            .build()
            .expect_err("a circle")
            .to_string()
            .contains("cycle")
    );
}
