//! Distances of convex shapes against support functions, finite differences and known manifolds.

use std::sync::Arc;

use dualbody::Cast;
use dualbody::autodiff::Dual;
use dualbody::collision::{
    Bounds, BroadPhase, Groups, Hull, Manifold, Shape, Witness, features, nearest_features, witness,
};
use dualbody::scalar::Traced;
use dualbody::scalar::traced::{Port, trace};
use dualbody::spatial::{Quaternion, Transform};
use nalgebra::Vector3;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

type V = Vector3<f64>;
type Pose = Transform<f64>;

/// Kinds of shapes that [`shape`] makes.
const KINDS: usize = 8;
/// Distances by other formulas.
const DISTANCE: f64 = 1e-9;

fn rng(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

fn vector(rng: &mut Xoshiro256PlusPlus, size: f64) -> V {
    V::from_fn(|_, _| rng.random_range(-size..size))
}

fn pose(rng: &mut Xoshiro256PlusPlus, size: f64) -> Pose {
    let rotation = Quaternion::exp(&vector(rng, 2.0)).to_matrix();
    Transform::new(rotation, vector(rng, size))
}

/// A shape of a kind, with sizes that now and then are zero where edges and faces are flat.
fn shape(kind: usize, rng: &mut Xoshiro256PlusPlus) -> Shape {
    let is_flat = rng.random_range(0..10) == 0;
    let mut size = || rng.random_range(0.1..1.0);
    let [a, b, c] = [size(), size(), size()];
    let flat = if is_flat { 0.0 } else { c };
    match kind {
        0 => Shape::Sphere { radius: flat },
        1 => Shape::Capsule {
            radius: a,
            half_length: flat,
        },
        2 => Shape::Box {
            half_extents: [a, b, flat],
        },
        3 => Shape::Cylinder {
            radius: a,
            half_length: b,
        },
        4 => Shape::Ellipsoid {
            semi_axes: [a, b, c],
        },
        5 => {
            let points = (0..12).map(|_| vector(rng, 1.0)).collect();
            let hull = Arc::new(Hull::new(points).unwrap());
            Shape::Hull {
                hull,
                scale: [a, b, -c],
            }
        }
        // About the origin, as the other shapes are.
        6 => {
            let (a, b) = (vector(rng, 1.0), vector(rng, 1.0));
            Shape::Triangle {
                vertices: [a, b, -(a + b)],
            }
        }
        _ => Shape::HalfSpace,
    }
}

/// How far a shape reaches along a direction.
fn reach(shape: &Shape, at: &Pose, n: &V) -> f64 {
    let m = at.rotation.transpose() * n;
    let own = match shape {
        Shape::Sphere { radius } => radius * n.norm(),
        Shape::Capsule {
            radius,
            half_length,
        } => half_length * m.z.abs() + radius * n.norm(),
        Shape::Box { half_extents: h } => (0..3).map(|k| h[k] * m[k].abs()).sum(),
        Shape::Cylinder {
            radius,
            half_length,
        } => half_length * m.z.abs() + radius * m.x.hypot(m.y),
        Shape::Ellipsoid { semi_axes: s } => m.component_mul(&V::from(*s)).norm(),
        Shape::Hull { hull, scale } => {
            let scaled = hull
                .vertices()
                .iter()
                .map(|v| v.component_mul(&V::from(*scale)));
            scaled.map(|v| v.dot(&m)).fold(f64::NEG_INFINITY, f64::max)
        }
        Shape::Triangle { vertices } => {
            let reaches = vertices.map(|v| v.dot(&m));
            reaches.into_iter().fold(f64::NEG_INFINITY, f64::max)
        }
        _ if (m - V::z()).norm() < 1e-12 => 0.0,
        _ => f64::INFINITY,
    };
    own + at.translation.dot(n)
}

/// How far a point is outside of a shape; of a hull in a few hundred directions.
fn outside(shape: &Shape, at: &Pose, p: &V) -> f64 {
    let x = at.rotation.transpose() * (p - at.translation);
    match shape {
        Shape::Box { half_extents: h } => (0..3)
            .map(|k| x[k].abs() - h[k])
            .fold(f64::NEG_INFINITY, f64::max),
        Shape::Cylinder {
            radius,
            half_length,
        } => (x.z.abs() - half_length).max(x.x.hypot(x.y) - radius),
        Shape::Ellipsoid { semi_axes: s } => x.component_div(&V::from(*s)).norm() - 1.0,
        Shape::HalfSpace => x.z,
        _ => directions()
            .map(|n| n.dot(p) - reach(shape, at, &n))
            .fold(f64::NEG_INFINITY, f64::max),
    }
}

/// Directions a tenth of a radian apart.
fn directions() -> impl Iterator<Item = V> {
    const COUNT: usize = 400;
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    (0..COUNT).map(|k| {
        let z = 1.0 - (2 * k + 1) as f64 / COUNT as f64;
        let (sin, cos) = (k as f64 * GOLDEN_ANGLE).sin_cos();
        let r = (1.0 - z * z).sqrt();
        V::new(r * cos, r * sin, z)
    })
}

struct Pair {
    shapes: [Shape; 2],
    at: [Pose; 2],
}

impl Pair {
    fn random(rng: &mut Xoshiro256PlusPlus, kinds: [usize; 2]) -> Self {
        let size = if rng.random_range(0..2) == 0 {
            0.3
        } else {
            1.5
        };
        Self {
            shapes: kinds.map(|kind| shape(kind, rng)),
            at: [pose(rng, size), pose(rng, size)],
        }
    }

    fn found(&self) -> Option<Witness<f64>> {
        let ([a, b], [x, y]) = (&self.shapes, &self.at);
        let pair = nearest_features(a, x, b, y)?;
        Some(witness(&pair, a, x, b, y))
    }

    /// Gap between planes across n with the shapes on either side.
    fn gap(&self, n: &V) -> f64 {
        -reach(&self.shapes[0], &self.at[0], n) - reach(&self.shapes[1], &self.at[1], &-n)
    }

    /// The widest gap about a direction, by random steps.
    fn widest_gap(&self, start: &V, rng: &mut Xoshiro256PlusPlus) -> f64 {
        let (mut n, mut widest, mut step) = (*start, self.gap(start), 0.1);
        while step > 1e-6 {
            let next = (n + vector(rng, step)).normalize();
            let gap = self.gap(&next);
            if gap > widest {
                (n, widest) = (next, gap);
            } else {
                step *= 0.9;
            }
        }
        widest
    }
}

fn each_pair(seed: u64, count: usize, mut each: impl FnMut(&Pair, &mut Xoshiro256PlusPlus, &str)) {
    let mut rng = rng(seed);
    for round in 0..count {
        let kinds = [rng.random_range(0..KINDS), rng.random_range(0..KINDS - 1)];
        let pair = Pair::random(&mut rng, kinds);
        let name = format!(
            "seed {seed}, round {round}: {:?} at {:?}",
            pair.shapes, pair.at
        );
        each(&pair, &mut rng, &name);
    }
}

// d = max over n of the gap, attained at the normal; points on both shapes that far apart make it exact where they do not overlap.
#[test]
fn distance_equals_the_gap_along_the_normal_and_that_of_points_on_both_shapes() {
    each_pair(1, 4000, |pair, _, name| {
        let found = pair.found().expect(name);
        let gap = pair.gap(&found.normal);
        assert!(
            (found.distance - gap).abs() < DISTANCE,
            "{name}: {} {gap}",
            found.distance
        );
        assert!((found.normal.norm() - 1.0).abs() < 1e-12, "{name}");
        let [p, q] = found.points;
        let apart = q - p - found.normal * found.distance;
        assert!(apart.norm() < DISTANCE, "{name}: {apart}");
        for (k, point) in found.points.iter().enumerate() {
            let outside = outside(&pair.shapes[k], &pair.at[k], point);
            assert!(outside < DISTANCE, "{name}: {k} {outside:e}");
        }
    });
}

#[test]
fn depth_equals_the_least_of_brute_force() {
    each_pair(2, 1500, |pair, rng, name| {
        let found = pair.found().expect(name);
        let is_endless = matches!(pair.shapes[0], Shape::HalfSpace);
        if found.distance < 0.0 && !is_endless {
            let mut starts: Vec<V> = directions().collect();
            starts.sort_by(|a, b| pair.gap(b).total_cmp(&pair.gap(a)));
            for start in &starts[..6] {
                let gap = pair.widest_gap(start, rng);
                assert!(
                    gap <= found.distance + DISTANCE,
                    "{name}: {} {gap}",
                    found.distance
                );
            }
        }
    });
}

/// A pose whose translation and rotation are variables, in six directions from the first on.
fn seeded(at: &Pose, first: usize) -> Transform<Dual<f64, 12>> {
    let mut out = Transform::new(
        at.rotation.map(Dual::constant_of),
        at.translation.map(Dual::constant_of),
    );
    for k in 0..3 {
        out.translation[k].eps[first + k] = 1.0;
        for j in 0..3 {
            let turned = V::ith(k, 1.0).cross(&at.rotation.column(j).into_owned());
            (0..3).for_each(|i| out.rotation[(i, j)].eps[first + 3 + k] = turned[i]);
        }
    }
    out
}

fn nudged(at: &Pose, k: usize, h: f64) -> Pose {
    if k < 3 {
        return Transform::new(at.rotation, at.translation + V::ith(k, h));
    }
    let turn = Quaternion::exp(&V::ith(k - 3, h)).to_matrix();
    Transform::new(turn * at.rotation, at.translation)
}

/// Steps of extrapolated differences, m and rad.
const STEP: f64 = 1e-4;
/// Error of extrapolated differences: curvature of rims seen from nearby.
const DIFFERENCE: f64 = 1e-7;

#[test]
fn derivatives_equal_central_differences_where_features_do_not_switch() {
    let mut compared = 0;
    each_pair(3, 400, |pair, _, name| {
        let ([a, b], [x, y]) = (&pair.shapes, &pair.at);
        let own = nearest_features(a, x, b, y).expect(name);
        let exact: Witness<Dual<f64, 12>> = witness(&own, a, &seeded(x, 0), b, &seeded(y, 6));
        for k in 0..12 {
            let at = |h: f64| {
                let [x, y] = if k < 6 {
                    [nudged(x, k, h), *y]
                } else {
                    [*x, nudged(y, k - 6, h)]
                };
                let pair = nearest_features(a, &x, b, &y)?;
                let found: Witness<f64> = witness(&pair, a, &x, b, &y);
                (pair.id == own.id).then_some(found.distance)
            };
            let difference = |h: f64| Some((at(h)? - at(-h)?) / (2.0 * h));
            let (Some(coarse), Some(fine)) = (difference(STEP), difference(STEP / 2.0)) else {
                continue;
            };
            // Where the two differ much, features are so near that the distance is not a polynomial over the step.
            if (coarse - fine).abs() < DIFFERENCE {
                let expected = (4.0 * fine - coarse) / 3.0;
                let found = exact.distance.eps[k];
                assert!(
                    (found - expected).abs() < DIFFERENCE,
                    "{name}: {k} {found} {expected}"
                );
                compared += 1;
            }
        }
    });
    assert!(compared > 3000, "{compared}");
}

#[test]
fn derivatives_in_sizes_equal_central_differences() {
    type D = Dual<f64, 3>;
    let mut rng = rng(4);
    for _ in 0..200 {
        let at = [pose(&mut rng, 0.5), pose(&mut rng, 1.5)];
        let ball = Shape::Sphere { radius: 0.1 };
        let sizes: [f64; 3] = std::array::from_fn(|_| rng.random_range(0.2..1.0));
        let solid = |x: [f64; 3]| {
            [
                Shape::Box { half_extents: x },
                Shape::Ellipsoid { semi_axes: x },
            ]
        };
        for k in 0..2 {
            let own = nearest_features(&solid(sizes)[k], &at[0], &ball, &at[1]).unwrap();
            let dual: [D; 3] = std::array::from_fn(|i| D::variable(sizes[i], i));
            let shape = [
                Shape::Box { half_extents: dual },
                Shape::Ellipsoid { semi_axes: dual },
            ];
            let lifted = at.map(|x| x.cast::<D>());
            let exact = witness(&own, &shape[k], &lifted[0], &ball.cast(), &lifted[1]);
            for i in 0..3 {
                let moved = |h: f64| {
                    let mut sizes = sizes;
                    sizes[i] += h;
                    let shape = &solid(sizes)[k];
                    let pair = nearest_features(shape, &at[0], &ball, &at[1]).unwrap();
                    witness::<f64, f64>(&pair, shape, &at[0], &ball, &at[1]).distance
                };
                let difference = |h: f64| (moved(h) - moved(-h)) / (2.0 * h);
                let expected = (4.0 * difference(STEP / 2.0) - difference(STEP)) / 3.0;
                let found = exact.distance.eps[i];
                let is_smooth = (difference(STEP) - difference(STEP / 2.0)).abs() < DIFFERENCE;
                assert!(
                    !is_smooth || (found - expected).abs() < DIFFERENCE,
                    "{sizes:?}: {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn shapes_in_one_place_have_a_finite_distance_with_finite_derivatives() {
    let mut rng = rng(5);
    let zero = [
        Shape::Sphere { radius: 0.0 },
        Shape::Capsule {
            radius: 0.0,
            half_length: 0.0,
        },
        Shape::Box {
            half_extents: [0.0; 3],
        },
        Shape::Box {
            half_extents: [0.0, 1.0, 1e-9],
        },
        Shape::Cylinder {
            radius: 0.0,
            half_length: 0.0,
        },
        Shape::Cylinder {
            radius: 1.0,
            half_length: 0.0,
        },
        Shape::Ellipsoid {
            semi_axes: [0.0; 3],
        },
        Shape::Ellipsoid {
            semi_axes: [1.0, 0.0, 0.5],
        },
        Shape::Hull {
            hull: Arc::new(Hull::new(vec![V::zeros(); 4]).unwrap()),
            scale: [1.0; 3],
        },
    ];
    let mut shapes = zero.to_vec();
    shapes.extend((0..KINDS - 1).map(|kind| shape(kind, &mut rng)));
    let far = Transform::from_translation(V::new(1e6, -1e6, 1e6));
    for at in [Transform::identity(), pose(&mut rng, 1.0), far] {
        for a in &shapes {
            for b in &shapes {
                let pair = nearest_features(a, &at, b, &at).expect("a pair");
                let dual = witness(&pair, a, &seeded(&at, 0), b, &seeded(&at, 6));
                let vectors = dual
                    .points
                    .iter()
                    .chain([&dual.normal])
                    .flat_map(|v| v.iter());
                let numbers = vectors.chain([&dual.distance]);
                let is_finite =
                    |x: &Dual<f64, 12>| x.re.is_finite() && x.eps.iter().all(|x| x.is_finite());
                assert!(
                    numbers.copied().all(|x| is_finite(&x)),
                    "{a:?} {b:?} {dual:?}"
                );
                assert!(
                    dual.distance.re <= DISTANCE,
                    "{a:?} {b:?} {}",
                    dual.distance.re
                );
            }
        }
    }
}

// The rule where centres coincide: the normal is z, so that the second ball moved along z leaves, and moved across stays.
#[test]
fn balls_about_one_centre_have_the_derivative_along_z() {
    let ball = Shape::Sphere { radius: 0.5 };
    let at = Transform::identity();
    let pair = nearest_features(&ball, &at, &ball, &at).unwrap();
    let found = witness(&pair, &ball, &seeded(&at, 0), &ball, &seeded(&at, 6));
    assert_eq!(found.distance.re, -1.0);
    assert_eq!(found.distance.eps[..3], [0.0, 0.0, -1.0]);
    assert_eq!(found.distance.eps[6..9], [0.0, 0.0, 1.0]);
}

#[test]
fn poses_that_are_not_finite_never_hang() {
    let mut rng = rng(6);
    for bad in [f64::NAN, f64::INFINITY, 1e300, 1e-300] {
        let at = Transform::from_translation(V::new(0.0, bad, 0.0));
        for [i, j] in (0..KINDS).flat_map(|i| (0..KINDS).map(move |j| [i, j])) {
            let (a, b) = (shape(i, &mut rng), shape(j, &mut rng));
            let found = nearest_features(&a, &Transform::identity(), &b, &at);
            assert!(
                found.is_none() || bad.is_finite(),
                "{bad} {a:?} {b:?} {found:?}"
            );
        }
    }
}

#[test]
fn mirrored_hull_equals_the_hull_of_mirrored_points() {
    let mut rng = rng(7);
    for _ in 0..100 {
        let points: Vec<V> = (0..10).map(|_| vector(&mut rng, 1.0)).collect();
        let scale = [-0.5, 2.0, 1.5];
        let scaled = points
            .iter()
            .map(|p| p.component_mul(&V::from(scale)))
            .collect();
        let hull = |points: Vec<V>| Arc::new(Hull::new(points).unwrap());
        let shapes = [
            Shape::Hull {
                hull: hull(points),
                scale,
            },
            Shape::Hull {
                hull: hull(scaled),
                scale: [1.0; 3],
            },
        ];
        let (at, other) = (pose(&mut rng, 1.0), pose(&mut rng, 3.0));
        let solid = Shape::Box {
            half_extents: [0.3, 0.2, 0.1],
        };
        let [a, b] = shapes.map(|shape| {
            let pair = nearest_features(&shape, &at, &solid, &other).unwrap();
            witness::<f64, f64>(&pair, &shape, &at, &solid, &other)
        });
        assert!((a.distance - b.distance).abs() < 1e-12 && (a.normal - b.normal).norm() < 1e-12);
    }
    assert!(Hull::new(Vec::new()).is_err());
    assert!(Hull::new(vec![V::new(0.0, f64::NAN, 0.0)]).is_err());
}

fn manifold(
    a: &Shape,
    x: &Pose,
    b: &Shape,
    y: &Pose,
    margin: f64,
) -> (Manifold, Vec<Witness<f64>>) {
    let mut out = Manifold::default();
    features(a, x, b, y, margin, &mut out);
    let points = out
        .pairs()
        .iter()
        .map(|pair| witness(pair, a, x, b, y))
        .collect();
    (out, points)
}

// Two equal squares turned by 45° against one another have eight crossings, at (±½, ±(√½ − ½)) and exchanged.
#[test]
fn box_on_a_turned_box_touches_at_the_corners_of_an_octagon() {
    let cube = Shape::Box {
        half_extents: [0.5; 3],
    };
    let turned = |angle: f64| {
        let rotation = Quaternion::exp(&V::new(0.0, 0.0, angle)).to_matrix();
        Transform::new(rotation, V::new(0.0, 0.0, 0.999))
    };
    let half = std::f64::consts::FRAC_PI_4;
    let (first, points) = manifold(&cube, &Transform::identity(), &cube, &turned(half), 0.01);
    assert_eq!(points.len(), 8);
    for point in &points {
        let [x, y] = [point.points[0].x.abs(), point.points[0].y.abs()];
        let expected = [0.5_f64.sqrt() - 0.5, 0.5];
        assert!((x.min(y) - expected[0]).abs() < 1e-12 && (x.max(y) - expected[1]).abs() < 1e-12);
        assert!((point.distance + 1e-3).abs() < 1e-12 && (point.normal.z - 1.0).abs() < 1e-12);
    }
    // A small motion keeps the identity of each point.
    let (next, _) = manifold(
        &cube,
        &Transform::identity(),
        &cube,
        &turned(half + 1e-3),
        0.01,
    );
    let ids = |manifold: &Manifold| {
        let mut ids: Vec<_> = manifold
            .pairs()
            .iter()
            .map(|pair| pair.id.features)
            .collect();
        ids.sort();
        ids
    };
    assert_eq!(ids(&first), ids(&next));
}

#[test]
fn manifolds_on_a_plane_have_the_corners_that_touch() {
    let ground = Shape::HalfSpace;
    let at = |z: f64, tilt: f64| {
        let rotation = Quaternion::exp(&V::new(tilt, 0.0, 0.0)).to_matrix();
        Transform::new(rotation, V::new(0.3, 0.2, z))
    };
    let count = |shape: &Shape, z: f64, tilt: f64| {
        let (_, points) = manifold(&ground, &Transform::identity(), shape, &at(z, tilt), 1e-3);
        for point in &points {
            assert!((point.normal - V::z()).norm() < 1e-15 && point.points[0].z.abs() < 1e-12);
        }
        points.len()
    };
    let solid = Shape::Box {
        half_extents: [0.5; 3],
    };
    assert_eq!(count(&solid, 0.5, 0.0), 4);
    assert_eq!(count(&solid, 0.5, 1e-4), 4);
    assert_eq!(count(&solid, 0.7, 0.0), 0);
    assert_eq!(
        count(&solid, 0.5_f64.sqrt(), std::f64::consts::FRAC_PI_4),
        2
    );
    let lying = std::f64::consts::FRAC_PI_2;
    assert_eq!(
        count(
            &Shape::Capsule {
                radius: 0.1,
                half_length: 0.5
            },
            0.1,
            lying
        ),
        2
    );
    assert_eq!(
        count(
            &Shape::Cylinder {
                radius: 0.1,
                half_length: 0.5
            },
            0.1,
            lying
        ),
        2
    );
    assert_eq!(
        count(
            &Shape::Cylinder {
                radius: 0.1,
                half_length: 0.5
            },
            0.5,
            0.0
        ),
        8
    );
    assert_eq!(count(&Shape::Sphere { radius: 0.1 }, 0.1, 0.0), 1);
}

#[test]
fn broad_phase_equals_all_pairs_while_shapes_move() {
    let mut rng = rng(8);
    let mut broad_phase = BroadPhase::default();
    let mut places: Vec<V> = (0..300).map(|_| vector(&mut rng, 3.0)).collect();
    let shapes: Vec<Shape> = (0..300)
        .map(|k| shape(if k == 7 { KINDS - 1 } else { k % (KINDS - 1) }, &mut rng))
        .collect();
    for step in 0..20 {
        let size = if step == 10 { 2.0 } else { 0.05 };
        places
            .iter_mut()
            .for_each(|place| *place += vector(&mut rng, size));
        let mut bounds: Vec<Bounds> = (shapes.iter().zip(&places))
            .map(|(shape, place)| Bounds::of(shape, &Transform::from_translation(*place), 0.01))
            .collect();
        if step == 15 {
            bounds[3].low.x = f64::NAN;
        }
        let may_touch = |i: usize, j: usize| !(i + j).is_multiple_of(3);
        let found = broad_phase.pairs(&bounds, may_touch).unwrap().to_vec();
        let all = (0..300).flat_map(|i| (i + 1..300).map(move |j| [i, j]));
        let expected: Vec<_> = all
            .filter(|&[i, j]| may_touch(i, j) && bounds[i].overlaps(&bounds[j]))
            .collect();
        assert_eq!(found, expected, "step {step}");
        assert!(found.len() > 300);
    }
}

#[test]
fn too_many_shapes_in_one_place_are_an_error() {
    let ball = Shape::Sphere { radius: 1.0 };
    let bounds = vec![Bounds::of(&ball, &Transform::identity(), 0.0); 20_000];
    let error = BroadPhase::default()
        .pairs(&bounds, |_, _| true)
        .unwrap_err();
    assert!(error.to_string().starts_with("of 20000 shapes"), "{error}");
    assert_eq!(
        BroadPhase::default().pairs(&[], |_, _| true).unwrap().len(),
        0
    );
}

#[test]
fn groups_touch_where_each_is_in_the_mask_of_the_other() {
    let [hand, table, ghost] =
        [[0b01, 0b10], [0b10, 0b11], [0b10, 0]].map(|[own, mask]| Groups { own, mask });
    assert!(hand.may_touch(&table) && table.may_touch(&hand));
    assert!(!hand.may_touch(&hand) && table.may_touch(&table));
    assert!(!ghost.may_touch(&table) && !hand.may_touch(&ghost));
}

// A graph holds its features fixed: recorded once, evaluated where the second shape has moved.
#[test]
fn recorded_distance_equals_the_computed_one_where_features_stay() {
    let solid = Shape::Box {
        half_extents: [0.5, 0.4, 0.3],
    };
    let round = Shape::Cylinder {
        radius: 0.3,
        half_length: 0.2,
    };
    let ball = Shape::Sphere { radius: 0.1 };
    let egg = Shape::Ellipsoid {
        semi_axes: [0.3, 0.2, 0.1],
    };
    let tilted = Quaternion::exp(&V::new(0.3, 0.5, -0.2)).to_matrix();
    let at = Transform::identity();
    for (a, b) in [
        (&solid, &ball),
        (&round, &ball),
        (&egg, &ball),
        (&solid, &egg),
        (&round, &egg),
        (&ball, &ball),
    ] {
        let start = Transform::new(tilted, V::new(0.7, 0.8, 0.9));
        let own = nearest_features(a, &at, b, &start).expect("a pair");
        let graph = trace(|t| {
            let place = t.input(Port::vector("place", 3));
            let moved = Transform::new(tilted.map(Traced::from), Vector3::from_fn(|k, _| place[k]));
            let found = witness(&own, a, &at.cast(), b, &moved);
            t.output(Port::vector("distance", 1), [found.distance].iter());
        });
        for step in [
            V::zeros(),
            V::new(0.02, -0.03, 0.01),
            V::new(-0.05, 0.02, 0.04),
        ] {
            let moved = Transform::new(tilted, start.translation + step);
            let pair = nearest_features(a, &at, b, &moved).expect("a pair");
            assert_eq!(pair.id, own.id, "{a:?} {b:?}");
            let computed: Witness<f64> = witness(&pair, a, &at, b, &moved);
            let recorded = graph
                .evaluate(moved.translation.as_slice())
                .expect("a distance");
            assert!(
                (recorded[0] - computed.distance).abs() < 1e-12,
                "{a:?} {b:?} {recorded:?} {computed:?}"
            );
        }
    }
}

/// A pose whose axes are those of the world in some order or nearly so, at a place of a coarse grid.
fn aligned_pose(rng: &mut Xoshiro256PlusPlus) -> Pose {
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut turn = nalgebra::Matrix3::identity();
    for axis in 0..3 {
        let angle = quarter * f64::from(rng.random_range(0..4));
        turn = Quaternion::exp(&V::ith(axis, angle)).to_matrix() * turn;
    }
    if rng.random_range(0..2) == 0 {
        turn = turn.map(f64::round);
    }
    if rng.random_range(0..3) == 0 {
        let by = 10_f64.powf(rng.random_range(-12.0..-2.0));
        turn = Quaternion::exp(&vector(rng, by)).to_matrix() * turn;
    }
    let place = V::from_fn(|_, _| 0.25 * f64::from(rng.random_range(-4..5)));
    Transform::new(turn, place)
}

/// A sphere, a capsule or a box of which sizes are alike, tiny or zero.
fn degenerate_shape(rng: &mut Xoshiro256PlusPlus) -> Shape {
    let sizes: [f64; 3] = std::array::from_fn(|_| match rng.random_range(0..6) {
        0 => 0.0,
        1 => 1e-4,
        _ => 0.5,
    });
    let [radius, half_length, _] = sizes;
    match rng.random_range(0..4) {
        0 => Shape::Sphere { radius },
        1 => Shape::Capsule {
            radius,
            half_length,
        },
        _ => Shape::Box {
            half_extents: sizes,
        },
    }
}

/// Error of distances of shapes whose features are parallel up to angles near rounding, where the nearest feature is not decided more exactly.
const NEARLY_PARALLEL: f64 = 1e-6;

#[test]
fn distance_of_aligned_and_degenerate_shapes_equals_the_widest_gap() {
    let mut rng = rng(11);
    for round in 0..600 {
        let shapes = [(); 2].map(|()| degenerate_shape(&mut rng));
        let at = [(); 2].map(|()| aligned_pose(&mut rng));
        let pair = Pair { shapes, at };
        let name = format!("round {round}: {:?} at {:?}", pair.shapes, pair.at);
        let found = pair.found().expect(&name);
        let gap = pair.gap(&found.normal);
        let off = found.distance - gap;
        assert!(off.abs() < NEARLY_PARALLEL, "{name}: {gap}");
        let axes = (0..2).flat_map(|k| (0..3).map(move |i| (k, i)));
        let axes = axes.map(|(k, i)| pair.at[k].rotation.column(i).into_owned());
        let mut starts: Vec<V> = directions().chain(axes.flat_map(|n| [n, -n])).collect();
        starts.sort_by(|a, b| pair.gap(b).total_cmp(&pair.gap(a)));
        for start in &starts[..4] {
            let widest = pair.widest_gap(start, &mut rng);
            let most = found.distance + NEARLY_PARALLEL;
            assert!(widest <= most, "{name}: {widest}");
        }
    }
}

// Along one axis the nearest points of the axes coincide up to rounding, and give no direction.
#[test]
fn capsules_along_one_axis_are_separated_across_it() {
    let capsule = |radius, half_length| Shape::Capsule {
        radius,
        half_length,
    };
    let quarter = V::y() * std::f64::consts::FRAC_PI_2;
    let turn = Quaternion::exp(&quarter).to_matrix();
    let back = Quaternion::exp(&-quarter).to_matrix();
    for (turn, half_length) in [(turn, 1e-5), (back, 1e-5), (turn, 0.3), (back, 0.0)] {
        let pair = Pair {
            shapes: [capsule(0.25, 0.8), capsule(0.3, half_length)],
            at: [
                Transform::new(back, V::new(-1.0, -0.25, 0.0)),
                Transform::new(turn, V::new(-1.0, -0.25, 0.0)),
            ],
        };
        let found = pair.found().expect("finite shapes");
        assert!((found.distance + 0.55).abs() < 1e-12, "{}", found.distance);
        assert!(found.normal.x.abs() < 1e-12);
    }
}

// A margin only limits the search to nearer features.
#[test]
fn a_manifold_within_a_margin_is_empty_exactly_where_shapes_are_farther_apart() {
    each_pair(12, 3000, |pair, _, name| {
        let ([a, b], [x, y]) = (&pair.shapes, &pair.at);
        let found = pair.found().expect(name);
        for margin in [0.0, 0.1, 1.0] {
            let mut points = Manifold::default();
            features(a, x, b, y, margin, &mut points);
            if (found.distance - margin).abs() > DISTANCE {
                let is_near = found.distance < margin;
                assert_eq!(!points.pairs().is_empty(), is_near, "{name}: {margin}");
            }
        }
    });
}

#[test]
fn bounding_boxes_reach_as_far_as_their_shapes() {
    each_pair(13, 2000, |pair, _, name| {
        for (shape, at) in pair.shapes.iter().zip(&pair.at) {
            if let Shape::HalfSpace = shape {
                continue;
            }
            let found = Bounds::of(shape, at, 0.25);
            for axis in 0..3 {
                let n = V::ith(axis, 1.0);
                let expected = [-reach(shape, at, &-n) - 0.25, reach(shape, at, &n) + 0.25];
                for (found, expected) in [found.low, found.high].iter().zip(expected) {
                    assert!((found[axis] - expected).abs() < 1e-12, "{name}: {found}");
                }
            }
        }
    });
}

// What boxes that do not overlap leave out is not seen by any search: it must be apart by more than both margins.
#[test]
fn shapes_whose_boxes_do_not_overlap_are_apart_by_more_than_their_margins() {
    let mut apart = 0;
    each_pair(14, 3000, |pair, rng, name| {
        let margins = [rng.random_range(0.0..0.2), rng.random_range(0.0..0.2)];
        let bounds = [0, 1].map(|k| Bounds::of(&pair.shapes[k], &pair.at[k], margins[k]));
        if !bounds[0].overlaps(&bounds[1]) {
            apart += 1;
            let found = pair.found().expect(name);
            assert!(found.distance > margins[0] + margins[1] - 1e-12, "{name}");
        }
    });
    assert!(apart > 300, "{apart}");
}

/// The hull of the corners of a box.
fn hull_of_box([a, b, c]: [f64; 3]) -> Shape {
    let side = |k: usize, bit: usize, half: f64| if k >> bit & 1 == 0 { -half } else { half };
    let corner = |k: usize| V::new(side(k, 0, a), side(k, 1, b), side(k, 2, c));
    Shape::Hull {
        hull: Arc::new(Hull::new((0..8).map(corner).collect()).unwrap()),
        scale: [1.0; 3],
    }
}

// Boxes have code of their own for corners, gaps and bounding boxes, hulls that of any polytope.
#[test]
fn boxes_touch_as_the_hulls_of_their_corners_do() {
    let mut rng = rng(15);
    let mut on_faces = 0;
    for round in 0..2000 {
        let mut size = || rng.random_range(0.1..1.0);
        let sizes = [[size(), size(), size()], [size(), size(), size()]];
        let (x, mut y) = (pose(&mut rng, 0.1), pose(&mut rng, 0.3));
        if round % 2 == 0 {
            // One lies on the other, tilted by less than manifolds reach.
            let tilt = vector(&mut rng, 0.02) + V::new(0.0, 0.0, rng.random_range(-3.0..3.0));
            let above = V::new(0.1, -0.05, sizes[0][2] + sizes[1][2] - 1e-3);
            let on = Transform::new(Quaternion::exp(&tilt).to_matrix(), above);
            y = x * on;
        }
        let boxes = sizes.map(|half_extents| Shape::Box { half_extents });
        let hulls = sizes.map(hull_of_box);
        let (_, found) = manifold(&boxes[0], &x, &boxes[1], &y, 0.02);
        let (_, expected) = manifold(&hulls[0], &x, &hulls[1], &y, 0.02);
        on_faces += usize::from(found.len() > 2);
        assert_eq!(
            found.len(),
            expected.len(),
            "{round}: {sizes:?} {x:?} {y:?}"
        );
        let middle = |point: &Witness<f64>| (point.points[0] + point.points[1]) / 2.0;
        for point in &found {
            let apart = |other: &Witness<f64>| {
                (middle(point) - middle(other)).norm() + (point.distance - other.distance).abs()
            };
            let least = expected.iter().map(apart).fold(f64::INFINITY, f64::min);
            assert!(least < 1e-9, "{round}: {least} {sizes:?} {x:?} {y:?}");
        }
    }
    assert!(on_faces > 500, "{on_faces}");
}
