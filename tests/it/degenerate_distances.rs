//! Distances of shapes that are aligned, thin, tiny or huge, where several features are as near: points, normals and derivatives stay those of one of them.

use std::sync::Arc;

use dualbody::Cast;
use dualbody::autodiff::Dual;
use dualbody::collision::{Hull, Shape, Witness, nearest_features, witness};
use dualbody::spatial::{Quaternion, Transform};
use nalgebra::{Matrix3, Vector3};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

type V = Vector3<f64>;
type Pose = Transform<f64>;
type D = Dual<f64, 6>;

fn nearest(a: &Shape, x: &Pose, b: &Shape, y: &Pose) -> Witness<f64> {
    let found = nearest_features(a, x, b, y).expect("a distance");
    witness(&found, a, x, b, y)
}

/// Derivatives of the distance in place and rotation of the second shape.
fn slopes(a: &Shape, x: &Pose, b: &Shape, y: &Pose) -> [f64; 6] {
    let found = nearest_features(a, x, b, y).expect("a distance");
    let variable = |k: usize| D::variable(0.0, k);
    let turn = Quaternion::exp(&Vector3::from_fn(|k, _| variable(3 + k))).to_matrix();
    let by = Vector3::from_fn(|k, _| variable(k));
    let plain = |at: &Pose| Transform::new(at.rotation.map(D::from), at.translation.map(D::from));
    let y = plain(y);
    let moved = Transform::new(turn * y.rotation, y.translation + by);
    let [a, b] = [a, b].map(|shape| shape.cast::<D>());
    witness(&found, &a, &plain(x), &b, &moved).distance.eps
}

/// The slopes are those of the normal at the point of the second shape.
fn assert_slopes_are_those_of_the_normal(a: &Shape, x: &Pose, b: &Shape, y: &Pose, most: f64) {
    let found = nearest(a, x, b, y);
    let arm = found.points[1] - y.translation;
    let turn = arm.cross(&found.normal);
    let expected = found.normal.iter().chain(turn.iter());
    for (slope, expected) in slopes(a, x, b, y).iter().zip(expected) {
        assert!(
            (slope - expected).abs() <= most,
            "{a:?} {b:?} {slope} {expected}"
        );
    }
}

fn pose(rotation: [[f64; 3]; 3], translation: [f64; 3]) -> Pose {
    let columns = rotation.map(V::from);
    Transform::new(Matrix3::from_columns(&columns), translation.into())
}

/// Six corners of a cube: a wedge.
fn wedge() -> Shape {
    let side = |k: u32, axis: u32| if k >> axis & 1 == 0 { -0.5 } else { 0.5 };
    let corners = (0..6).map(|k| V::new(side(k, 0), side(k, 1), side(k, 2)));
    Shape::Hull {
        hull: Arc::new(Hull::new(corners.collect()).expect("finite points")),
        scale: [0.5, 0.5, -0.5],
    }
}

// The cylinder of 1 m is deepest across the wedge's end of half a metre: found by cutting all directions in parts.
#[test]
fn wedge_deep_in_an_aligned_cylinder_leaves_it_by_the_shortest_way() {
    let cylinder = Shape::Cylinder {
        radius: 0.5,
        half_length: 0.5,
    };
    let x = pose(
        [
            [2.499286510358517e-11, 5.092235950639814e-11, -1.0],
            [1.0, 1.0635970633538573e-11, 2.499286510412678e-11],
            [1.063597063481127e-11, -1.0, -5.092235950613231e-11],
        ],
        [0.75, 0.0, -0.5],
    );
    let y = pose(
        [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]],
        [1.0, -0.25, -0.75],
    );
    let found = nearest(&wedge(), &x, &cylinder, &y);
    assert!((found.distance + 0.5).abs() < 1e-9, "{found:?}");
}

// The way out across the side is half a metre, that through the end three quarters. Vertices on the axis have no radial direction of their own.
#[test]
fn capsule_on_the_axis_of_a_cylinder_leaves_it_across_the_side() {
    let cylinder = Shape::Cylinder {
        radius: 0.5,
        half_length: 0.5,
    };
    let capsule = Shape::Capsule {
        radius: 0.25,
        half_length: 0.5,
    };
    let needle = Shape::Box {
        half_extents: [0.0, 0.0, 0.5],
    };
    let turn = Quaternion::exp(&V::new(0.3, -0.8, 0.4)).to_matrix();
    let along = V::new(0.0, 0.0, -0.25);
    for rotation in [Matrix3::identity(), turn] {
        let x = Transform::new(rotation, V::zeros());
        let y = Transform::new(rotation, rotation * along);
        for (inner, expected) in [(&capsule, -0.75), (&needle, -0.5)] {
            for found in [
                nearest(&cylinder, &x, inner, &y),
                nearest(inner, &y, &cylinder, &x),
            ] {
                assert!((found.distance - expected).abs() < 1e-15, "{found:?}");
            }
            assert_slopes_are_those_of_the_normal(&cylinder, &x, inner, &y, 1e-12);
        }
    }
}

// Axis and edge lie along one another, the end of the axis beyond the edge: the points must be where both are.
#[test]
fn capsule_along_an_edge_of_a_hull_has_points_on_both() {
    let capsule = Shape::Capsule {
        radius: 0.25,
        half_length: 0.5,
    };
    let x = pose(
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [-0.5, -0.25, -0.25],
    );
    let y = pose(
        [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        [-0.5, 0.0, 0.75],
    );
    let found = nearest(&wedge(), &x, &capsule, &y);
    let [p, q] = found.points;
    assert!((found.distance - 0.5).abs() < 1e-15);
    assert!((q - p).norm() - 0.5 < 1e-15, "{found:?}");
    // The edge on top is y = 0, z = 0, x from -0.75 to -0.25; the capsule's axis x from -1 to 0.
    assert!(
        p.x >= -0.75 && p.x <= -0.25 && p.y.abs() + p.z.abs() < 1e-15,
        "{found:?}"
    );
}

// The deepest point of the ellipsoid lies above the middle of the cap: the normal is the cap's, and turns with it.
#[test]
fn ellipsoid_deep_behind_a_cap_has_the_derivatives_of_the_cap() {
    let ellipsoid = Shape::Ellipsoid {
        semi_axes: [0.3159408494577999, 0.41833161936339114, 0.28090785349751737],
    };
    let cylinder = Shape::Cylinder {
        radius: 0.22291776101918137,
        half_length: 0.23624414647247383,
    };
    let x = pose(
        [
            [
                0.30572636658289776,
                0.9501204909624956,
                0.061663939455778194,
            ],
            [
                -0.1287261005218323,
                -0.022922992368147543,
                0.9914152144612937,
            ],
            [0.943377432325187, -0.3110395297612124, 0.1152971426595697],
        ],
        [
            -0.2920685683530967,
            -0.2882507737004143,
            -0.23386324746015952,
        ],
    );
    let y = pose(
        [
            [
                -0.5871914756381913,
                0.7765307857711381,
                -0.22848656347256502,
            ],
            [
                -0.4382913637950656,
                -0.06770255305305461,
                0.8962795572435868,
            ],
            [0.6805195451715587, 0.6264314033154447, 0.38010109915618195],
        ],
        [
            -0.0623500713227938,
            0.11430684717533585,
            -0.18932135706601988,
        ],
    );
    assert_slopes_are_those_of_the_normal(&ellipsoid, &x, &cylinder, &y, 1e-12);
    let found = nearest(&ellipsoid, &x, &cylinder, &y);
    let apart = found.points[1] - found.points[0] - found.normal * found.distance;
    assert!(apart.norm() < 1e-12, "{found:?}");
}

// Half of all directions are as good; their curvature is that of rounding.
#[test]
fn ball_about_the_edge_of_a_plate_has_the_derivatives_of_its_normal() {
    let ball = Shape::Ellipsoid {
        semi_axes: [0.5; 3],
    };
    let plate = Shape::Box {
        half_extents: [0.5, 0.5, 0.0],
    };
    let nothing = 2.220446049250313e-16;
    let x = pose(
        [
            [0.0, -nothing, 1.0],
            [2.0 * nothing, 1.0, nothing],
            [-1.0, 2.0 * nothing, 0.0],
        ],
        [1.0, 0.0, 0.0],
    );
    let y = pose(
        [
            [-nothing, 0.0, 1.0],
            [-1.2246467991473532e-16, -1.0, 0.0],
            [1.0, -1.2246467991473532e-16, nothing],
        ],
        [1.0, 0.5, -0.25],
    );
    assert_slopes_are_those_of_the_normal(&ball, &x, &plate, &y, 1e-9);
}

// A line 10⁻⁷ m beside a point far along it: rounding of the normal must not count along the line.
#[test]
fn point_close_beside_a_line_has_the_derivatives_of_its_normal() {
    let needle = Shape::Capsule {
        radius: 0.1,
        half_length: 50.0,
    };
    let point = Shape::Sphere { radius: 0.0 };
    let box_ = Shape::Box {
        half_extents: [0.0, 0.0, 50.0],
    };
    let turn = Quaternion::exp(&V::new(0.3, -0.8, 0.4)).to_matrix();
    for (first, line) in [(&needle, -0.1), (&box_, 0.0)] {
        let x = Transform::new(turn, V::new(0.1, 0.2, 0.3));
        let beside = turn * V::new(3e-8, -2e-8, 41.0);
        let y = Transform::new(Matrix3::identity(), x.translation + beside);
        let found = nearest(first, &x, &point, &y);
        let expected = V::new(3e-8, -2e-8, 0.0).norm() + line;
        assert!((found.distance - expected).abs() < 3e-14, "{found:?}");
        assert_slopes_are_those_of_the_normal(first, &x, &point, &y, 1e-6);
    }
}

/// The distance is that expected either way round, with points as far apart along the normal and the derivatives of these.
fn assert_distance(a: &Shape, x: &Pose, b: &Shape, y: &Pose, expected: f64, most: f64) {
    for found in [nearest(a, x, b, y), nearest(b, y, a, x)] {
        assert!((found.distance - expected).abs() <= most, "{found:?}");
        let apart = found.points[1] - found.points[0] - found.normal * found.distance;
        assert!(apart.norm() <= most, "{found:?}");
    }
    assert_slopes_are_those_of_the_normal(a, x, b, y, 1e-7);
}

// The centre of the ball is above one face by 10⁻⁶ m and as much behind the other one at their edge: all normals about the edge are as good to 10⁻⁶ m.
#[test]
fn ball_about_an_edge_of_a_hull_leaves_it_across_the_nearer_face() {
    let ball = Shape::Ellipsoid {
        semi_axes: [0.5; 3],
    };
    let x = pose(
        [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]],
        [-0.75, -1.0, -0.25],
    );
    let y = pose(
        [
            [
                -5.2624247202703506e-6,
                -4.4930290637194e-6,
                0.9999999999760598,
            ],
            [
                9.997115513437907e-6,
                0.9999999999399349,
                4.493081672624901e-6,
            ],
            [
                -0.9999999999361823,
                9.99713915770264e-6,
                -5.262379802623708e-6,
            ],
        ],
        [-0.5, -1.0, 0.0],
    );
    let center = y.inverse().point(&x.translation);
    assert!(center.x > -0.25 && center.z > 0.25, "{center:?}");
    assert_distance(&ball, &x, &wedge(), &y, center.z - 0.75, 1e-12);
}

// A hull without two of its extents is a needle, whatever vertices it has between its ends.
#[test]
fn needle_of_many_points_has_the_distance_of_the_segment_between_its_ends() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut vector = |size: f64| V::from_fn(|_, _| rng.random_range(-size..size));
    let cylinder = Shape::Cylinder {
        radius: 0.65,
        half_length: 0.8,
    };
    let ellipsoid = Shape::Ellipsoid {
        semi_axes: [0.6, 0.7, 0.9],
    };
    for _ in 0..200 {
        let points: Vec<V> = (0..12).map(|_| vector(1.0)).collect();
        let reach = points.iter().map(|p| p.x.abs()).fold(0.0, f64::max);
        let ends = [-reach, reach].map(|x| V::x() * x);
        let all = points.into_iter().chain(ends).collect();
        let hull = |points| Hull::new(points).expect("finite points");
        let [needle, segment] = [all, ends.to_vec()].map(|points| Shape::Hull {
            hull: Arc::new(hull(points)),
            scale: [0.5, 0.0, 1e-9],
        });
        let poses = [(); 2].map(|()| {
            let turn = Quaternion::exp(&vector(2.0)).to_matrix();
            Transform::new(turn, vector(0.3))
        });
        for other in [&cylinder, &ellipsoid] {
            let [found, expected] = [&needle, &segment]
                .map(|shape| nearest(shape, &poses[0], other, &poses[1]).distance);
            assert!((found - expected).abs() < 3e-9, "{found} {expected}");
        }
    }
}

// Beyond the edge of a cap by a few millimetres, a rim: only normals within a few degrees of one direction widen the gap.
#[test]
fn rims_that_all_but_face_each_other_are_not_taken_for_a_cap() {
    let cylinder = Shape::Cylinder {
        radius: 0.5,
        half_length: 0.5,
    };
    let x = pose(
        [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]],
        [-0.75, -0.25, 0.0],
    );
    let y = pose(
        [
            [
                0.00568248733474645,
                0.9999725981646636,
                -0.004744708368572295,
            ],
            [
                0.9999654309023919,
                -0.005653516805125803,
                0.006097109801204846,
            ],
            [
                0.0060701184407089,
                -0.004779191097509484,
                -0.999970156051954,
            ],
        ],
        [0.25, 0.25, -0.5],
    );
    // By steps up the gap of both shapes.
    assert_distance(&cylinder, &x, &cylinder, &y, -0.0030201279498182757, 1e-12);
}

// The normal along the axis of a cap to the last digit: the point of the rim along it is rounding.
#[test]
fn cap_flat_on_a_plane_has_the_derivatives_of_the_plane() {
    let nothing = 2.220446049250313e-16;
    let cylinder = Shape::Cylinder {
        radius: 0.5,
        half_length: 0.5,
    };
    let x = pose(
        [
            [nothing, 1.0, 0.0],
            [-nothing, 0.0, 1.0],
            [1.0, -nothing, nothing],
        ],
        [0.5, 1.0, -0.25],
    );
    let disc = Shape::Ellipsoid {
        semi_axes: [0.5, 0.5, 0.0],
    };
    let y = pose(
        [
            [nothing, 1.0, -1.2246467991473532e-16],
            [-nothing, 1.2246467991473537e-16, 1.0],
            [1.0, -nothing, nothing],
        ],
        [-0.5, -0.25, 0.0],
    );
    for shape in [&cylinder, &disc] {
        assert_slopes_are_those_of_the_normal(&Shape::HalfSpace, &x, shape, &y, 1e-9);
        assert_slopes_are_those_of_the_normal(shape, &y, &Shape::HalfSpace, &x, 1e-9);
    }
}

// An axis that touches the edge of a flat ellipsoid: normals of a whole arc are as good, and have no derivatives.
#[test]
fn cylinder_about_the_edge_of_a_flat_ellipsoid_has_the_derivatives_of_its_normal() {
    let nothing = 2.220446049250313e-16;
    let ellipsoid = Shape::Ellipsoid {
        semi_axes: [0.0, 0.5, 0.5],
    };
    let cylinder = Shape::Cylinder {
        radius: 0.5,
        half_length: 0.5,
    };
    let x = pose(
        [
            [0.0, -nothing, -1.0],
            [1.0, -nothing, 0.0],
            [-nothing, -1.0, nothing],
        ],
        [0.5, -0.25, -0.5],
    );
    let y = pose(
        [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        [1.0, 0.0, -0.5],
    );
    assert_distance(&ellipsoid, &x, &cylinder, &y, -0.5, 1e-12);
}

/// A size from a micrometre to a thousand kilometres, or none.
fn odd_size(rng: &mut Xoshiro256PlusPlus) -> f64 {
    match rng.random_range(0..4) {
        0 => 0.0,
        _ => 10_f64.powf(rng.random_range(-6.0..6.0)),
    }
}

fn odd_shape(rng: &mut Xoshiro256PlusPlus) -> Shape {
    let [a, b, c] = [(); 3].map(|()| odd_size(rng));
    match rng.random_range(0..7) {
        0 => Shape::Sphere { radius: a },
        1 => Shape::Capsule {
            radius: a,
            half_length: b,
        },
        2 => Shape::Box {
            half_extents: [a, b, c],
        },
        3 => Shape::Cylinder {
            radius: a,
            half_length: b,
        },
        4 => Shape::Ellipsoid {
            semi_axes: [a, b, c],
        },
        5 => match wedge() {
            Shape::Hull { hull, .. } => Shape::Hull {
                hull,
                scale: [a, -b, c],
            },
            other => other,
        },
        _ => Shape::Triangle {
            vertices: [V::x() * a, V::y() * b, V::z() * c],
        },
    }
}

/// A pose about a place: random, or along the axes.
fn odd_pose(rng: &mut Xoshiro256PlusPlus, size: f64) -> Pose {
    let mut vector = |size: f64| V::from_fn(|_, _| rng.random_range(-size..size));
    let [turn, place] = [vector(2.0), vector(1.0) * size];
    let quarter = turn.map(|x| x.round() * std::f64::consts::FRAC_PI_2);
    let is_aligned = turn.x > 0.0;
    let rotation = Quaternion::exp(if is_aligned { &quarter } else { &turn }).to_matrix();
    Transform::new(rotation, place)
}

#[test]
fn sizes_of_any_ratio_have_finite_distances_with_a_unit_normal_and_finite_slopes() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    for k in 0..3000 {
        let [a, b] = [(); 2].map(|()| odd_shape(&mut rng));
        let apart = [0.0, 1e-6, 1.0, 1e6][k % 4];
        let x = Transform::new(odd_pose(&mut rng, 1.0).rotation, V::zeros());
        let y = if apart == 0.0 {
            Transform::new(odd_pose(&mut rng, 1.0).rotation, V::zeros())
        } else {
            odd_pose(&mut rng, apart)
        };
        let found = nearest(&a, &x, &b, &y);
        let numbers = found.points.iter().flat_map(|p| p.iter());
        assert!(
            numbers.chain([&found.distance]).all(|x| x.is_finite()),
            "{k}: {a:?} {b:?} {found:?}"
        );
        assert!(
            (found.normal.norm() - 1.0).abs() < 1e-12,
            "{k}: {a:?} {b:?} {found:?}"
        );
        let slopes = slopes(&a, &x, &b, &y);
        assert!(
            slopes.iter().all(|x| x.is_finite()),
            "{k}: {a:?} {b:?} {slopes:?}"
        );
    }
}
