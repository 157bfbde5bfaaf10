//! Shapes by a user's signed distance against balls, planes and finite differences, and bodies that rest on one.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use dualbody::autodiff::Dual;
use dualbody::collision::{
    DistanceField, DistanceFunction, Manifold, Shape, Witness, features, nearest_features, witness,
};
use dualbody::contact::{
    CollisionOptions, ContactLaw, Contacts, LinkShapes, RelaxedRigid, SoftContact, Terrain,
};
use dualbody::joint::JointKind;
use dualbody::model::{Base, JointSpec, LinkSpec, Mass, ModelBuilder};
use dualbody::spatial::{Quaternion, Transform};
use dualbody::{Cast, Lanes, Scalar, Simulator};
use nalgebra::Vector3;

type Pose = Transform<f64>;

/// A ball as a function.
struct Ball(f64);

impl DistanceFunction for Ball {
    fn distance<T: Scalar>(&self, [x, y, z]: [T; 3]) -> T {
        (x * x + y * y + z * z).sqrt() - self.0
    }
}

/// The outside of a ball: a bowl where it is below.
struct Bowl(f64);

impl DistanceFunction for Bowl {
    fn distance<T: Scalar>(&self, [x, y, z]: [T; 3]) -> T {
        -(x * x + y * y + z * z).sqrt() + self.0
    }
}

/// The plane z = 0, which has no number beyond x = 1.
struct Torn;

impl DistanceFunction for Torn {
    fn distance<T: Scalar>(&self, [x, _, z]: [T; 3]) -> T {
        z + (-x + 1.0).sqrt() * 0.0
    }
}

/// A ball that counts how often it is asked.
struct Counted(Ball, Arc<AtomicUsize>);

impl DistanceFunction for Counted {
    fn distance<T: Scalar>(&self, point: [T; 3]) -> T {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.distance(point)
    }
}

fn field(function: impl DistanceFunction, half: f64) -> Shape {
    let field = DistanceField::new(function, [half; 3]);
    Shape::Field { field }
}

fn pose(turn: [f64; 3], at: [f64; 3]) -> Pose {
    Transform::new(Quaternion::exp(&turn.into()).to_matrix(), at.into())
}

fn found(a: &Shape, x: &Pose, b: &Shape, y: &Pose) -> Witness<f64> {
    witness(&nearest_features(a, x, b, y).expect("a pair"), a, x, b, y)
}

fn moved(at: &Pose, first: usize) -> Transform<Dual<f64, 12>> {
    let variable = |k| Dual::<f64, 12>::variable(0.0, first + k);
    let turn = Vector3::from_fn(|k, _| variable(3 + k));
    Transform::new(
        Quaternion::exp(&turn).to_matrix() * at.rotation.map(Dual::from),
        at.translation.map(Dual::from) + Vector3::from_fn(|k, _| variable(k)),
    )
}

// Either way round, of all shapes whose nearest point is a vertex, with derivatives of distance, normal and points.
#[test]
fn ball_by_a_function_equals_the_ball() {
    let (own, ball) = (field(Ball(0.4), 0.4), Shape::Sphere { radius: 0.4 });
    let others = [
        Shape::Sphere { radius: 0.2 },
        Shape::Capsule {
            radius: 0.1,
            half_length: 0.3,
        },
        Shape::Box {
            half_extents: [0.1, 0.2, 0.3],
        },
    ];
    let y = pose([0.1, -0.2, 0.3], [0.1, 0.2, -0.1]);
    for other in &others {
        // Beyond a corner, along the diagonal.
        let x = pose([0.3, -0.5, 0.4], [0.5, 0.7, 0.9]);
        let pair = nearest_features(other, &x, &own, &y).expect("a pair");
        let exact = nearest_features(other, &x, &ball, &y).expect("a pair");
        let [a, b, c] = [other, &own, &ball].map(|shape| shape.cast::<Dual<f64, 12>>());
        let [p, q] = [moved(&x, 0), moved(&y, 6)];
        let (own, exact) = (
            witness(&pair, &a, &p, &b, &q),
            witness(&exact, &a, &p, &c, &q),
        );
        let all = |w: &Witness<Dual<f64, 12>>| {
            let vectors = [w.normal, w.points[0], w.points[1]];
            let numbers = vectors.into_iter().flat_map(|v| [v.x, v.y, v.z]);
            numbers.chain([w.distance]).collect::<Vec<_>>()
        };
        for (own, exact) in all(&own).iter().zip(all(&exact)) {
            assert!(
                (own.re - exact.re).abs() < 1e-12,
                "{other:?}: {own:?} {exact:?}"
            );
            let off = own.eps.iter().zip(exact.eps).map(|(a, b)| (a - b).abs());
            assert!(
                off.fold(0.0, f64::max) < 1e-11,
                "{other:?}: {own:?} {exact:?}"
            );
        }
    }
    let x = pose([0.0; 3], [0.7, 0.0, 0.0]);
    let (ours, theirs) = (
        found(&own, &y, &others[0], &x),
        found(&others[0], &x, &own, &y),
    );
    assert_eq!(
        (ours.distance, ours.normal),
        (theirs.distance, -theirs.normal)
    );
}

// A distance and a gradient for each lane, with their derivatives if there are any.
#[test]
fn each_lane_has_its_own_distance_and_asks_the_function_once() {
    type L = Lanes<4>;
    let count = Arc::new(AtomicUsize::new(0));
    let ball = field(Counted(Ball(0.3), count.clone()), 0.3);
    let other = Shape::Sphere { radius: 0.1 };
    let places = [0.5, 1.0, 2.0, 4.0];
    let (x, y) = (pose([0.0; 3], [0.0; 3]), pose([0.0; 3], [0.5, 0.0, 0.0]));
    let pair = nearest_features(&ball, &x, &other, &y).expect("a pair");
    let [x, y] =
        [x, y].map(|at| Transform::<L>::new(at.rotation.map(L::from), at.translation.map(L::from)));
    let y = Transform::new(
        y.rotation,
        Vector3::new(Lanes(places), L::from(0.0), L::from(0.0)),
    );
    count.store(0, Ordering::Relaxed);
    let plain = witness(&pair, &ball, &x, &other, &y);
    assert_eq!(count.swap(0, Ordering::Relaxed), 4);
    for (k, place) in places.into_iter().enumerate() {
        assert!((plain.distance.0[k] - (place - 0.4)).abs() < 1e-15);
    }

    type D = Dual<L, 1>;
    let [x, mut y] = [x, y].map(|at| {
        Transform::<D>::new(
            at.rotation.map(|v| D::new(v, [L::from(0.0)])),
            at.translation.map(|v| D::new(v, [L::from(0.0)])),
        )
    });
    y.translation.y.eps = [L::from(1.0)];
    let ball = ball.cast::<L>();
    let over = witness(&pair, &ball, &x, &other.cast::<L>(), &y);
    assert_eq!(count.load(Ordering::Relaxed), 8);
    // The normal turns with the place: by 1 / distance of the centres.
    for (k, place) in places.into_iter().enumerate() {
        assert_eq!(over.distance.eps[0].0[k], 0.0);
        assert!((over.normal.y.eps[0].0[k] - 1.0 / place).abs() < 1e-15);
    }
}

#[test]
fn box_in_a_bowl_touches_with_its_four_lower_corners() {
    let half_extents = [0.3, 0.4, 0.2];
    let (own, other) = (field(Bowl(1.0), 1.0), Shape::Box { half_extents });
    // The lower corners are on the ball about the origin.
    let z = 0.2 - (1.0_f64 - 0.09 - 0.16).sqrt();
    let (x, y) = (Pose::identity(), pose([0.0; 3], [0.0, 0.0, z]));
    let mut out = Manifold::default();
    features(&own, &x, &other, &y, 1e-6, &mut out);
    assert_eq!(out.pairs().len(), 4);
    for pair in out.pairs() {
        let found = witness(pair, &own, &x, &other, &y);
        assert!(
            found.distance.abs() < 1e-12 && found.points[1].z < 0.0,
            "{found:?}"
        );
        assert!((found.normal + found.points[1]).norm() < 1e-12, "{found:?}");
    }
}

#[test]
fn functions_without_numbers_have_no_contact_and_no_pair_is_found_with_half_spaces() {
    let own = field(Torn, 1.0);
    let ball = Shape::Sphere { radius: 0.1 };
    let x = Pose::identity();
    let at = |x: f64| pose([0.0; 3], [x, 0.0, 0.05]);
    assert!((found(&own, &x, &ball, &at(0.5)).distance + 0.05).abs() < 1e-15);
    assert_eq!(nearest_features(&own, &x, &ball, &at(1.5)), None);
    for other in [Shape::HalfSpace, field(Ball(0.1), 0.1)] {
        assert_eq!(nearest_features(&own, &x, &other, &at(0.5)), None);
        let mut out = Manifold::default();
        features(&other, &x, &own, &at(0.5), 1.0, &mut out);
        assert!(out.pairs().is_empty());
    }
    // At the middle of a ball its function has no gradient.
    let (ball, point) = (field(Ball(0.4), 0.4), Shape::Sphere { radius: 0.0 });
    if let Some(pair) = nearest_features(&ball, &x, &point, &x) {
        let found = witness(&pair, &ball, &x, &point, &x);
        assert!(found.distance.is_finite() && found.normal.iter().all(|x| x.is_finite()));
    }
}

#[test]
#[should_panic(expected = "half extent of a signed distance")]
fn endless_box_about_a_function_is_refused() {
    let _ = DistanceField::new(Torn, [f64::INFINITY; 3]);
}

/// A ball of 0.1 m in a bowl of 1 m about the origin, whose link is fixed to the world.
fn ball_in_a_bowl(law: ContactLaw) -> Simulator {
    let mut builder = ModelBuilder::new("bowl").with_base(Base::Fixed);
    builder.add_link(LinkSpec::solid_sphere("bowl", 1.0, Mass::Kilograms(1.0)));
    builder.add_link(LinkSpec::solid_sphere("ball", 0.1, Mass::Kilograms(1.0)));
    builder.add_joint(JointSpec::new("free", JointKind::Floating, "bowl", "ball"));
    let model = builder.build().expect("a model");
    let mut shapes = LinkShapes::without_meshes(&model);
    let bowl = model.find_frame("bowl").expect("a bowl");
    let own = shapes.shapes_mut().iter_mut().find(|own| own.link == bowl);
    own.expect("a bowl").shape = field(Bowl(1.0), 1.0);
    let options = CollisionOptions::default().with_self_collision();
    let contacts = Contacts::new(&model, Terrain::flat(-10.0), law)
        .with_link_shapes(&model, law, shapes, &options)
        .expect("links");
    Simulator::new(model)
        .with_actuated_joints(&[])
        .expect("joints")
        .with_contacts(contacts)
        .with_time_step(0.002)
}

// Rolling without slip in a bowl: a pendulum of length 0.9 m with 7/5 of its inertia.
#[test]
fn ball_rolls_in_a_bowl_like_a_pendulum_and_its_steps_have_exact_derivatives() {
    let law = ContactLaw::RelaxedRigid(RelaxedRigid {
        friction: 1.0,
        ..RelaxedRigid::default()
    });
    let simulator = ball_in_a_bowl(law);
    let mut state = simulator.neutral_state();
    let angle = 0.05_f64;
    (state.q[0], state.q[2]) = (0.9 * angle.sin(), -0.9 * angle.cos());
    let period = std::f64::consts::TAU * (7.0 / 5.0 * 0.9 / 9.81_f64).sqrt();
    let half = (0.5 * period / simulator.time_step()).round() as usize;
    let end = simulator.rollout(&state, half, |_, _, _| {}).last().clone();
    assert!((end.q[0] + 0.9 * angle.sin()).abs() < 2e-3, "{}", end.q[0]);

    let soft = ball_in_a_bowl(ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3)));
    let q = state.q;
    let mut state = soft.neutral_state();
    state.q = q;
    state.q[2] -= 1e-3;
    state.v.copy_from_slice(&[0.1, 0.05, -0.1, 0.2, 0.3, -0.1]);
    let a = soft.linearize(&state, &[]).a;
    let model = soft.model();
    for k in 0..6 {
        let h = 1e-6;
        let at = |h: f64| {
            let mut start = state.clone();
            let mut dv = vec![0.0; 6];
            dv[k] = h;
            start.q = model.integrate(state.q.as_slice(), &dv);
            soft.step(&start, &[])
        };
        let difference = (at(h).v - at(-h).v) / (2.0 * h);
        let own = a.view((6, k), (6, 1));
        let size = own.amax().max(1.0);
        assert!((difference - own).amax() < 1e-5 * size, "{k}");
    }
}
