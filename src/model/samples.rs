//! Small robots for examples, tests and benches, built in code.

use nalgebra::Vector3;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::{JointSpec, Limits, LinkSpec, Model, ModelBuilder};
use crate::joint::{JointKind, Pitch};
use crate::memory;
use crate::scalar::from_each;
use crate::spatial::{Inertia, Quaternion, Symmetric3, Transform};

/// Kinds of joints that move.
const MOVING: [JointKind; 8] = [
    JointKind::Revolute,
    JointKind::Continuous,
    JointKind::Prismatic,
    JointKind::Spherical,
    JointKind::Planar,
    JointKind::Floating,
    JointKind::Screw(Pitch::per_radian(0.2)),
    JointKind::Universal,
];

/// Builds a sample, whose parts are valid.
fn built(builder: &ModelBuilder) -> Model {
    builder
        .build()
        .unwrap_or_else(|error| unreachable!("{error}"))
}

/// A thin rod of 1 kg and 1 m that hangs down from the origin of its link.
fn rod(name: &str) -> LinkSpec {
    LinkSpec::new(name).with_mass(1.0, [0.0, 0.0, -0.5], [1.0 / 12.0, 1.0 / 12.0, 0.0])
}

/// A rod of 1 kg and 1 m on a pivot about x: hanging at q = 0, J = ⅓ kg·m², τ = ½ g sin q.
pub fn pendulum() -> Model {
    let mut builder = ModelBuilder::new("pendulum");
    builder
        .add_link(LinkSpec::new("world"))
        .add_link(rod("rod"));
    builder.add_joint(JointSpec::new(
        "pivot",
        JointKind::Continuous,
        "world",
        "rod",
    ));
    built(&builder)
}

/// Double pendulum: two rods of 1 kg and 1 m in series, both pivots about x, hanging at q = 0.
pub fn double_pendulum() -> Model {
    let mut builder = ModelBuilder::new("double_pendulum");
    builder
        .add_link(LinkSpec::new("world"))
        .add_link(rod("upper"))
        .add_link(rod("lower"));
    builder.add_joint(JointSpec::new(
        "shoulder",
        JointKind::Continuous,
        "world",
        "upper",
    ));
    builder.add_joint(
        JointSpec::new("elbow", JointKind::Continuous, "upper", "lower")
            .with_translation([0.0, 0.0, -1.0]),
    );
    built(&builder)
}

/// The cart-pole of the examples: a cart of 1 kg on a rail along y, a pole of 0.5 kg upright at q = 0, pivot about x.
pub fn cartpole() -> Model {
    let cart = LinkSpec::new("cart").with_mass(
        1.0,
        [0.0; 3],
        [
            0.003_541_666_666_666_667_4,
            0.001_041_666_666_666_666_9,
            0.004_166_666_666_666_667_5,
        ],
    );
    let pole = LinkSpec::new("pole").with_mass(
        0.5,
        [0.0, 0.0, 0.5],
        [0.041_669_791_666_666_67, 0.041_669_791_666_666_67, 6.25e-06],
    );
    let mut builder = ModelBuilder::new("cartpole");
    builder
        .add_link(LinkSpec::new("world"))
        .add_link(cart)
        .add_link(pole);
    let travel = Limits {
        lower: Some(-2.4),
        upper: Some(2.4),
        velocity: Some(10.0),
        effort: Some(500.0),
    };
    builder.add_joint(
        JointSpec::new("linear", JointKind::Prismatic, "world", "cart")
            .with_translation([0.0, 0.0, 1.2])
            .with_axis([0.0, 1.0, 0.0])
            .with_limits(travel),
    );
    builder.add_joint(JointSpec::new(
        "pivot",
        JointKind::Continuous,
        "cart",
        "pole",
    ));
    built(&builder)
}

/// A 7-joint arm of 1.3 m with alternating axes, 12 kg, fixed to the world.
pub fn arm() -> Model {
    const AXES: [[f64; 3]; 7] = [
        [0., 0., 1.],
        [0., 1., 0.],
        [0., 0., 1.],
        [0., 1., 0.],
        [0., 0., 1.],
        [0., 1., 0.],
        [0., 0., 1.],
    ];
    const LENGTHS: [f64; 7] = [0.3, 0.2, 0.2, 0.2, 0.2, 0.1, 0.1];
    const MASSES: [f64; 7] = [3.0, 2.5, 2.0, 1.8, 1.4, 0.8, 0.5];
    const RADIUS: f64 = 0.05;
    let mut builder = ModelBuilder::new("arm");
    builder.add_link(LinkSpec::new("world"));
    let mut parent = ("world".to_owned(), 0.0);
    for i in 0..AXES.len() {
        let (name, m, l) = (format!("link{}", i + 1), MASSES[i], LENGTHS[i]);
        let across = m * (3.0 * RADIUS * RADIUS + l * l) / 12.0;
        builder.add_link(LinkSpec::new(&name).with_mass(
            m,
            [0.0, 0.0, l / 2.0],
            [across, across, m * RADIUS * RADIUS / 2.0],
        ));
        builder.add_joint(
            JointSpec::new(
                format!("joint{}", i + 1),
                JointKind::Revolute,
                parent.0,
                &name,
            )
            .with_axis(AXES[i])
            .with_translation([0.0, 0.0, parent.1]),
        );
        parent = (name, l);
    }
    builder.add_frame(
        "tool",
        parent.0,
        Transform::from_translation(Vector3::new(0.0, 0.0, parent.1)),
    );
    built(&builder)
}

/// A random tree of `n` moving links with all kinds of joints, arbitrary axes, and a fixed link on each third body. The same seed gives the same robot.
///
/// # Panics
/// If the robot would need more memory than the [limit](crate::memory).
pub fn random_tree(n: usize, seed: u64) -> Model {
    random_tree_of(&MOVING, n, seed)
}

/// A random tree as [`random_tree`], with joints of the given kinds in turn.
///
/// # Panics
/// If `kinds` is empty and `n` is not 0, or if the robot would need more memory than the [limit](crate::memory).
pub fn random_tree_of(kinds: &[JointKind], n: usize, seed: u64) -> Model {
    /// Reach of the random choice of a parent: small enough for some depth, large enough for branches.
    const REACH: usize = 4;
    /// Bytes of a link, roughly: its description, and what is made of it.
    const LINK: usize = 4096;
    let bytes = n.saturating_mul(LINK);
    memory::granted(memory::check(format_args!("{n} random links"), bytes));
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut builder = ModelBuilder::new(format!("random_tree_{n}_{seed}"));
    builder.add_link(LinkSpec::new("world"));
    let mut names = vec!["world".to_owned()];
    for i in 0..n {
        let (name, kind) = (format!("link{i}"), kinds[i % kinds.len()]);
        let parent = &names[rng.random_range(names.len().saturating_sub(REACH)..names.len())];
        builder.add_link(LinkSpec::new(&name).with_inertia(random_inertia(&mut rng)));
        builder.add_joint(
            JointSpec::new(format!("joint{i}"), kind, parent, &name)
                .with_placement(random_pose(&mut rng))
                .with_axis(from_each(|_| rng.random_range(-1.0..1.0)))
                .with_damping(rng.random_range(0.0..0.5)),
        );
        names.push(name.clone());
        if i % 3 == 0 {
            let tip = format!("tip{i}");
            builder.add_link(LinkSpec::new(&tip).with_inertia(random_inertia(&mut rng)));
            builder.add_joint(
                JointSpec::new(format!("weld{i}"), JointKind::Fixed, &name, &tip)
                    .with_placement(random_pose(&mut rng)),
            );
        }
    }
    built(&builder)
}

fn random_pose(rng: &mut Xoshiro256PlusPlus) -> Transform<f64> {
    let mut x = || rng.random_range(-1.0..1.0);
    let rotation = Quaternion::exp(&Vector3::new(x(), x(), x())).to_matrix();
    Transform::new(rotation, Vector3::new(x(), x(), x()) * 0.3)
}

/// The inertia of a random box somewhere near the origin.
fn random_inertia(rng: &mut Xoshiro256PlusPlus) -> Inertia<f64> {
    let mass = rng.random_range(0.2..3.0);
    let [a, b, c] = from_each(|_| rng.random_range(0.05..0.4_f64).powi(2) * mass / 12.0);
    let pose = random_pose(rng);
    pose.inertia(&Inertia::from_com(
        mass,
        &Vector3::zeros(),
        &Symmetric3::diagonal(&Vector3::new(b + c, a + c, a + b)),
    ))
}
