//! Robots, random states, tolerances and comparisons that the tests share.

pub(crate) mod base;
pub(crate) mod everything;
pub(crate) mod ground;
pub(crate) mod problems;
pub(crate) mod quadruped;

use std::path::Path;

use dualbody::Simulator;
use dualbody::constraint::{Anchor, Constraint};
use dualbody::joint::JointKind;
use dualbody::model::{Base, JointSpec, LinkSpec, Mimic, Model, ModelBuilder, samples};
use nalgebra::{DMatrix, DVector};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// A handful of operations on numbers of size one: some roundings of 1.1e-16 each. Ten times as much for a dozen
/// operations.
pub(crate) const ROUNDING: f64 = 1e-15;
/// Two ways through the same algebra: roundings that add up over a whole formula.
pub(crate) const SAME_ALGEBRA: f64 = 1e-12;
/// Another algorithm for the same number, or an iteration that has converged: roundings of a whole robot, and of a
/// linear solve.
pub(crate) const OTHER_ALGORITHM: f64 = 1e-9;
/// Extrapolated central differences: about eleven digits at inputs and derivatives of size one, less where curvature is
/// large.
pub(crate) const FINITE_DIFFERENCE: f64 = 1e-8;

/// A free box with arms on spherical, planar, prismatic and revolute joints.
pub(crate) fn floating_robot() -> Model {
    let mut builder = ModelBuilder::new("floating_robot");
    builder.add_link(LinkSpec::new("torso").with_mass(4.0, [0.02, -0.01, 0.05], [0.3, 0.25, 0.2]));
    let arms = [
        ("ball", JointKind::Spherical, [0.0, 0.2, 0.1]),
        ("slide", JointKind::Prismatic, [0.1, 0.0, 0.0]),
        ("hinge", JointKind::Revolute, [0.0, -0.2, 0.1]),
        ("plate", JointKind::Planar, [0.0, 0.0, 0.3]),
    ];
    for (name, kind, at) in arms {
        let (joint, tip) = (format!("{name}_joint"), format!("{name}_tip"));
        builder.add_link(LinkSpec::new(name).with_mass(
            0.7,
            [0.05, 0.1, -0.1],
            [0.02, 0.03, 0.015],
        ));
        builder.add_link(LinkSpec::new(&tip).with_mass(0.3, [0.0, 0.0, -0.2], [0.01, 0.01, 0.002]));
        builder.add_joint(
            JointSpec::new(&joint, kind, "torso", name)
                .with_armature(0.07)
                .with_translation(at)
                .with_axis([0.6, 0.0, 0.8]),
        );
        builder.add_joint(
            JointSpec::new(format!("{name}_elbow"), JointKind::Revolute, name, tip)
                .with_translation([0.0, 0.0, -0.25])
                .with_axis([0.0, 1.0, 0.0])
                .with_damping(0.05),
        );
    }
    builder.build().expect("a robot that is known to be right")
}

/// An arm with rotors and a spring, and fingers that mimic: one its neighbour, one a joint further up, one another
/// mimic joint.
pub(crate) fn gripper() -> ModelBuilder {
    let mut builder = ModelBuilder::new("gripper");
    builder.add_link(LinkSpec::new("world"));
    let joints = [
        ("shoulder", JointKind::Revolute, "world", [0.0, 0.0, 1.0]),
        ("elbow", JointKind::Continuous, "shoulder", [0.6, 0.8, 0.0]),
        ("left", JointKind::Prismatic, "elbow", [0.0, 1.0, 0.0]),
        ("right", JointKind::Prismatic, "elbow", [0.0, -1.0, 0.0]),
        ("thumb", JointKind::Revolute, "left", [1.0, 0.0, 0.0]),
        ("tip", JointKind::Revolute, "thumb", [0.0, 0.0, 1.0]),
    ];
    for (k, (name, kind, parent, axis)) in joints.into_iter().enumerate() {
        builder.add_link(LinkSpec::new(name).with_mass(
            1.0 / (1.0 + k as f64),
            [0.05, -0.02, 0.1],
            [0.02, 0.015, 0.01],
        ));
        let joint = JointSpec::new(format!("{name}_joint"), kind, parent, name)
            .with_axis(axis)
            .with_translation([0.1, 0.05 * k as f64, 0.2])
            .with_damping(0.1 + 0.01 * k as f64)
            .with_armature(0.05 * k as f64)
            .with_spring(2.0 * k as f64, 0.1);
        builder.add_joint(match name {
            "right" => joint.with_mimic(mimic("left_joint", 1.0, 0.0)),
            "thumb" => joint.with_mimic(mimic("shoulder_joint", -0.7, 0.3)),
            "tip" => joint.with_mimic(mimic("thumb_joint", 2.0, -0.1)),
            _ => joint,
        });
    }
    builder
}

fn mimic(leader: &str, multiplier: f64, offset: f64) -> Mimic {
    Mimic {
        leader: leader.into(),
        multiplier,
        offset,
    }
}

/// A rigid body without joints.
pub(crate) fn free_body() -> Model {
    let mut builder = ModelBuilder::new("free_body");
    builder.add_link(LinkSpec::new("body").with_mass(2.0, [0.1, -0.2, 0.05], [0.3, 0.2, 0.1]));
    builder.build().expect("a robot that is known to be right")
}

/// A robot that cannot move.
pub(crate) fn statue() -> Model {
    let mut builder = ModelBuilder::new("statue").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("stone").with_mass(2.0, [0.0; 3], [0.1; 3]));
    builder.build().expect("a robot that is known to be right")
}

/// One robot of every sort; together they have every joint kind, both bases, branches and no degree of freedom at all.
pub(crate) fn robots() -> Vec<Model> {
    let mut robots = vec![
        samples::pendulum(),
        samples::double_pendulum(),
        samples::cartpole(),
        samples::arm(),
        free_body(),
        floating_robot(),
        statue(),
        gripper()
            .build()
            .expect("a robot that is known to be right"),
    ];
    robots.extend((0..3).map(|seed| samples::random_tree(9, seed)));
    robots
}

pub(crate) fn asset(name: &str) -> Model {
    // Packages of folders below have no assets of their own.
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let assets =
        folders.find_map(|folder| Some(folder.join("assets")).filter(|path| path.is_dir()));
    let path = assets.expect("the assets of the crate").join(name);
    Model::from_urdf_file(path).expect("an asset of the crate")
}

/// A generator of random numbers that gives the same ones each time.
pub(crate) fn generator(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// A random tangent vector with entries in (−1, 1).
pub(crate) fn random_tangent(model: &Model, rng: &mut Xoshiro256PlusPlus) -> DVector<f64> {
    DVector::from_fn(model.nv(), |_, _| rng.random_range(-1.0..1.0))
}

/// A random point: configuration, and two tangent vectors.
pub(crate) struct Point {
    pub(crate) q: DVector<f64>,
    pub(crate) v: DVector<f64>,
    pub(crate) w: DVector<f64>,
}

pub(crate) fn random_point(model: &Model, seed: u64) -> Point {
    let mut rng = generator(seed);
    Point {
        q: model.random_configuration(&mut rng),
        v: random_tangent(model, &mut rng),
        w: random_tangent(model, &mut rng),
    }
}

/// Largest difference, relative to the size of the expected numbers or to one.
pub(crate) fn relative_error(actual: &DMatrix<f64>, expected: &DMatrix<f64>) -> f64 {
    assert_eq!(actual.shape(), expected.shape());
    if actual.is_empty() {
        return 0.0;
    }
    (actual - expected).amax() / expected.amax().max(1.0)
}

#[track_caller]
pub(crate) fn assert_close(
    actual: &DMatrix<f64>,
    expected: &DMatrix<f64>,
    tolerance: f64,
    what: &str,
) {
    let error = relative_error(actual, expected);
    assert!(
        error <= tolerance,
        "{what}: relative error {error:e}\nactual {actual}expected {expected}"
    );
}

#[track_caller]
pub(crate) fn assert_close_vector(
    actual: &DVector<f64>,
    expected: &DVector<f64>,
    tolerance: f64,
    what: &str,
) {
    let column = |x: &DVector<f64>| DMatrix::from_column_slice(x.len(), 1, x.as_slice());
    assert_close(&column(actual), &column(expected), tolerance, what);
}

/// A constraint whose forces are bounded by zero: it changes nothing, but a solver finds all forces.
pub(crate) fn with_solver(simulator: &Simulator) -> Simulator {
    let last = *simulator.model().link_names().last().expect("a link");
    let tip = Anchor::frame(simulator.model(), last).expect("a link");
    let rod = Constraint::distance([Anchor::world().moved([0.3, 0.2, 0.9]), tip], 0.4);
    simulator
        .clone()
        .with_constraints(vec![rod.with_largest_force(0.0)])
}
