//! Soft minimum over near features: distances of links whose gradients do not jump where the nearest features switch.

use dualbody::collision::Shape;
use dualbody::contact::{
    CollisionOptions, ContactLaw, Contacts, LinkShapes, Nearest, RelaxedRigid, Rigid, Smoothing,
    Terrain,
};
use dualbody::model::{Mass, Model, Object, World};
use dualbody::spatial::Transform;
use dualbody::trajopt::{LinkDistances, Node, Residual, ResidualJacobian, Robot, System};
use dualbody::{Simulator, State};
use nalgebra::DVector;
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

const WIDTH: f64 = 1e-3;

fn at(x: f64, y: f64, z: f64) -> Transform<f64> {
    Transform::from_translation([x, y, z].into())
}

/// Two boxes that float, of different sizes; in a world they are in the order of their names.
fn boxes() -> (Model, LinkShapes) {
    let mut world = World::default();
    let free = || Object::free(Mass::Kilograms(1.0));
    world
        .add_box("board", [1.0, 0.8, 0.2], &free())
        .expect("a box");
    world
        .add_box("box", [0.3, 0.2, 0.4], &free().at(at(0.0, 0.0, 0.5)))
        .expect("a box");
    let model = world.build().expect("a world");
    let shapes = LinkShapes::without_meshes(&model);
    (model, shapes)
}

fn find(model: &Model, shapes: &LinkShapes, q: &DVector<f64>) -> Nearest {
    shapes
        .nearest(model, q.as_slice(), "board", "box")
        .expect("a distance")
}

/// Largest difference between the gradient along a tangent and a central difference, and largest change of the gradient from sample to sample, on a path.
fn along(
    model: &Model,
    shapes: &LinkShapes,
    start: &DVector<f64>,
    tangent: &[f64],
    range: f64,
) -> (f64, f64) {
    const SAMPLES: i32 = 150;
    let place = |s: f64| {
        let dv: Vec<f64> = tangent.iter().map(|x| x * s).collect();
        model.integrate(start.as_slice(), &dv)
    };
    let slope = |s: f64| {
        let near = find(model, shapes, &place(s));
        near.gradient
            .iter()
            .zip(tangent)
            .map(|(g, t)| g * t)
            .sum::<f64>()
    };
    let distance = |s: f64| find(model, shapes, &place(s)).distance;
    let (mut error, mut jump): (f64, f64) = (0.0, 0.0);
    let mut last = None;
    for k in -SAMPLES..=SAMPLES {
        let s = range * f64::from(k) / f64::from(SAMPLES);
        let h = 1e-5 * range;
        let by = |h: f64| (distance(s + h) - distance(s - h)) / (2.0 * h);
        let expected = (4.0 * by(h) - by(2.0 * h)) / 3.0;
        let found = slope(s);
        error = error.max((found - expected).abs());
        if let Some(last) = last.replace(found) {
            jump = jump.max(f64::abs(found - last));
        }
    }
    (error, jump)
}

// From edge to edge over a face, from a corner to an edge, and across an edge of the lower box: paths through switches of the nearest features, some of them exactly at one.
#[test]
fn gradients_are_continuous_where_vertices_edges_and_faces_switch() {
    let (model, shapes) = boxes();
    let soft = shapes.clone().with_smoothing(2e-2);
    let straight = model.neutral();
    let tilted = model.integrate(straight.as_slice(), &{
        let mut dv = [0.0; 12];
        dv[9..].copy_from_slice(&[0.3, 0.2, 0.1]);
        dv
    });
    // Coordinates 6 to 11 are those of the upper box, the linear ones first.
    let paths: [(&DVector<f64>, [f64; 6], f64); 6] = [
        (&straight, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0], 0.05),
        (&straight, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0], 0.05),
        (&straight, [0.0, 0.0, 0.0, 0.7, 1.0, 0.3], 0.05),
        (&tilted, [1.0, 0.3, 0.0, 0.0, 0.0, 0.0], 0.9),
        (&straight, [0.0, 1.0, 0.0, 0.1, 0.0, 0.2], 0.8),
        (&tilted, [0.0, 0.0, 0.0, 1.0, 1.0, 0.0], 1.5),
    ];
    let mut exact_jumps = 0;
    for (k, (start, tangent, range)) in paths.into_iter().enumerate() {
        let mut dv = [0.0; 12];
        dv[6..].copy_from_slice(&tangent);
        let (error, jump) = along(&model, &soft, start, &dv, range);
        assert!(error < 1e-6, "path {k}: {error:e}");
        // Curvatures are at most the square of half a length over the width, some 6 m/rad².
        assert!(jump < 0.1, "path {k}: a jump of {jump}");
        let (_, exact) = along(&model, &shapes, start, &dv, range);
        exact_jumps += i32::from(exact > 0.15);
    }
    assert!(
        exact_jumps >= 3,
        "without smoothing gradients jump: {exact_jumps}"
    );
}

// A finer look across the switch: with the smoothing, the slope changes as the width says, L²/(4 w) per radian for two edges that are L apart; at the switch it is zero.
#[test]
fn slope_of_a_box_over_a_face_passes_zero_as_a_hyperbolic_tangent() {
    let (model, shapes) = boxes();
    let soft = shapes.with_smoothing(WIDTH);
    for angle in [-1e-2, -1e-3, -1e-5, 0.0, 1e-5, 1e-3, 1e-2_f64] {
        let mut dv = [0.0; 12];
        dv[10] = angle;
        let q = model.integrate(model.neutral().as_slice(), &dv);
        let found = find(&model, &soft, &q).gradient[10];
        // Over the middle of a wide face the normal stays that of the face: softly, h(−n) of the upper box over its four lower corners.
        let expected = -0.15 * (0.15 * angle / WIDTH).tanh();
        let other = 0.2 * angle.sin();
        assert!(
            (found - expected - other).abs() < 2e-4 + 3.0 * angle.abs(),
            "{angle}: {found} {expected}"
        );
    }
}

// Against its closed form: over a plane, −w ln Σ exp(−hₖ / w) of the heights of the corners.
#[test]
fn distance_of_a_box_from_a_plane_is_the_soft_minimum_of_its_corners() {
    let (model, mut shapes) = boxes();
    shapes.shapes_mut()[0].shape = Shape::HalfSpace;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let simulator = Simulator::new(model.clone());
    for width in [1e-1, 1e-3, 1e-6] {
        let soft = shapes.clone().with_smoothing(width);
        for _ in 0..50 {
            let q = State::random(simulator.model(), &mut rng, 0.0).q;
            let found = find(&model, &soft, &q);
            let frames = ["board", "box"].map(|name| {
                let frame = model.find_frame(name).expect("a link");
                dualbody::dynamics::frame_pose(&model, q.as_slice(), frame)
            });
            let from_plane = frames[0].inverse() * frames[1];
            let heights: Vec<f64> = (0..8)
                .map(|k| {
                    let side = |axis: usize, x: f64| if k >> axis & 1 == 0 { -x } else { x };
                    let corner = nalgebra::Vector3::new(side(0, 0.15), side(1, 0.1), side(2, 0.2));
                    from_plane.point(&corner).z
                })
                .collect();
            let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
            let sum: f64 = heights.iter().map(|h| ((least - h) / width).exp()).sum();
            let expected = least - width * sum.ln();
            let error = found.distance - expected;
            assert!(error.abs() < 1e-13, "{width}: {expected} by {error:e}");
            let [a, b] = found.points;
            assert!((found.normal.dot(&(b - a)) - expected).abs() < 1e-13);
            assert!((a - b).cross(&found.normal).norm() < 1e-12);
        }
    }
}

/// A link of two spheres at x = ±a over a ball that floats.
fn two_spheres() -> (Model, LinkShapes) {
    let model = Model::from_urdf_str(
        r#"<robot name="two"><link name="world"><collision><origin xyz="-0.3 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>
        <collision><origin xyz="0.3 0 0"/><geometry><sphere radius="0.2"/></geometry></collision></link>
        <link name="ball"><collision><geometry><sphere radius="0.05"/></geometry></collision>
        <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="x" type="prismatic"><parent link="world"/><child link="ball"/><origin xyz="0 0 0.5"/><axis xyz="1 0 0"/>
        <limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"#,
    )
    .expect("a model");
    let shapes = LinkShapes::without_meshes(&model);
    (model, shapes)
}

#[test]
fn two_spheres_of_a_link_take_turns_smoothly() {
    let (model, shapes) = two_spheres();
    for width in [1e-4, 1e-2, 0.2] {
        let soft = shapes.clone().with_smoothing(width);
        for k in -100..=100 {
            let x = f64::from(k) * 5e-3;
            let near = soft.nearest(&model, &[x], "world", "ball").expect("links");
            let each = |center: f64, radius: f64| {
                let length = (x - center).hypot(0.5);
                (length - radius - 0.05, (x - center) / length)
            };
            let [(d, g), (e, f)] = [each(-0.3, 0.1), each(0.3, 0.2)];
            let least = d.min(e);
            let [s, t] = [d, e].map(|d| ((least - d) / width).exp());
            let expected = least - width * (s + t).ln();
            assert!((near.distance - expected).abs() < 1e-14);
            assert!((near.gradient[0] - (s * g + t * f) / (s + t)).abs() < 1e-13);
            let exact = shapes
                .nearest(&model, &[x], "world", "ball")
                .expect("links");
            assert!((exact.distance - least).abs() < 1e-15);
            let below = least - near.distance;
            assert!(
                below > -1e-15 && below < width * 2_f64.ln() + 1e-15,
                "{below:e}"
            );
            assert_eq!(near.shapes, exact.shapes);
        }
    }
}

const KINDS: usize = 6;

/// Shapes of each kind, with their excess in widths.
fn kinds() -> [(Shape, f64); KINDS] {
    let ln = f64::ln;
    [
        (Shape::Sphere { radius: 0.2 }, 0.0),
        (
            Shape::Capsule {
                radius: 0.1,
                half_length: 0.3,
            },
            ln(2.0),
        ),
        (
            Shape::Box {
                half_extents: [0.1, 0.2, 0.3],
            },
            ln(8.0),
        ),
        (
            Shape::Cylinder {
                radius: 0.2,
                half_length: 0.1,
            },
            1.0 + ln(2.0),
        ),
        (
            Shape::Ellipsoid {
                semi_axes: [0.3, 0.1, 0.2],
            },
            1.0,
        ),
        (
            Shape::Triangle {
                vertices: [[0.0, 0.0, 0.0], [0.4, 0.0, 0.1], [0.0, 0.3, 0.0]].map(Into::into),
            },
            ln(3.0),
        ),
    ]
}

// Every pair of kinds, apart and overlapping: within the stated bound, and the gradient that of the distance.
#[test]
fn distances_of_all_shapes_are_within_the_bound_with_their_gradients() {
    let (model, mut shapes) = boxes();
    let simulator = Simulator::new(model.clone());
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    let (mut overlapping, mut worst): (usize, f64) = (0, 0.0);
    for (one, e) in kinds() {
        for (other, f) in kinds() {
            shapes.shapes_mut()[0].shape = one.clone();
            shapes.shapes_mut()[1].shape = other.clone();
            for (width, far) in [(1e-2, 0.5), (1e-3, 1.0), (1e-5, 0.3)] {
                let soft = shapes.clone().with_smoothing(width);
                let mut q = State::random(simulator.model(), &mut rng, 0.0).q;
                for k in [0, 1, 2, 7, 8, 9] {
                    q[k] *= far;
                }
                let [exact, found] = [&shapes, &soft].map(|own| find(&model, own, &q));
                overlapping += usize::from(exact.distance < 0.0);
                let below = exact.distance - found.distance;
                assert!(
                    below > -1e-12 && below <= width * (e + f) + 1e-12,
                    "{one:?} {other:?}: {below} at a width of {width}, exact {}",
                    exact.distance
                );
                if width < 1e-4 {
                    continue;
                }
                for k in 0..12 {
                    let moved = |h: f64| {
                        let mut dv = [0.0; 12];
                        dv[k] = h;
                        find(&model, &soft, &model.integrate(q.as_slice(), &dv)).distance
                    };
                    let by = |h: f64| (moved(h) - moved(-h)) / (2.0 * h);
                    let h = width * 1e-2;
                    let expected = (4.0 * by(h / 2.0) - by(h)) / 3.0;
                    worst = worst.max((found.gradient[k] - expected).abs());
                }
            }
        }
    }
    assert!(overlapping > 5, "{overlapping}");
    assert!(worst < 1e-6, "{worst:e}");
}

#[test]
fn a_width_of_zero_is_the_exact_distance_bit_for_bit() {
    let (model, shapes) = boxes();
    let none = shapes.clone().with_smoothing(0.0);
    let simulator = Simulator::new(model.clone());
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    for _ in 0..100 {
        let q = State::random(simulator.model(), &mut rng, 0.0).q;
        let [a, b] = [&shapes, &none].map(|own| find(&model, own, &q));
        assert_eq!(a, b);
    }
}

// Extremes of the width: below rounding it changes nothing, above all sizes there is still a number; far from the world's origin no digit is lost.
#[test]
fn odd_widths_and_places_give_finite_distances() {
    let (model, shapes) = boxes();
    let q = model.neutral();
    let exact = find(&model, &shapes, &q);
    for width in [5e-324, 1e-300, 1e-30, 1e-12] {
        let soft = shapes.clone().with_smoothing(width);
        let found = find(&model, &soft, &q);
        assert!((found.distance - exact.distance).abs() < 1e-11, "{width}");
        assert!(found.gradient.iter().all(|g| g.is_finite()));
    }
    for width in [1.0, 1e6, 1e100] {
        let soft = shapes.clone().with_smoothing(width);
        let found = find(&model, &soft, &q);
        assert!(found.distance.is_finite() && found.gradient.iter().all(|g| g.is_finite()));
        assert!(found.distance <= exact.distance);
    }
    let soft = shapes.with_smoothing(WIDTH);
    let near = find(&model, &soft, &q);
    let mut far = q.clone();
    for k in 0..2 {
        far[7 * k] += 1e9;
    }
    assert!((find(&model, &soft, &far).distance - near.distance).abs() < 1e-12);
    // All in one place.
    let mut same = q.clone();
    same[9] = -0.5;
    let found = find(&model, &soft, &same);
    assert!(found.distance < 0.0 && found.gradient.iter().all(|g| g.is_finite()));
    same[7] = f64::NAN;
    assert!(
        soft.nearest(&model, same.as_slice(), "board", "box")
            .is_err()
    );
}

#[test]
#[should_panic(expected = "a width of -0.1 m is negative")]
fn a_negative_width_is_refused() {
    let _ = boxes().1.with_smoothing(-0.1);
}

// Exact Hessians by hyper-dual numbers beside differences of gradients, at a switch and beside it.
#[cfg(feature = "second-order")]
#[test]
fn second_derivatives_equal_differences_of_gradients() {
    use dualbody::trajopt::{Activation, Cost};

    let (model, shapes) = boxes();
    let simulator = Simulator::new(model);
    let soft = shapes.with_smoothing(5e-3);
    let made = LinkDistances::new(simulator.model(), soft, &[["board", "box"]]);
    let cost = Cost::new().with(1.0, Activation::Quadratic, made.expect("links"));
    for tilt in [0.0, 0.01] {
        let mut state = simulator.neutral_state();
        let mut dv = [0.0; 12];
        dv[9..].copy_from_slice(&[0.3 * tilt, tilt, tilt]);
        state.q = simulator.model().integrate(state.q.as_slice(), &dv);
        let x = simulator.pack(&state);
        let found = cost.expand_exactly(&simulator, 0, x.as_slice(), &[]);
        for k in 0..12 {
            let moved = |h: f64| {
                let (mut dx, mut to) = (vec![0.0; 24], x.as_slice().to_vec());
                dx[k] = h;
                System::integrate(&simulator, x.as_slice(), &dx, &mut to);
                cost.value(&simulator, 0, &to, &[])
            };
            let h = 2e-4;
            let expected = (moved(h) - 2.0 * moved(0.0) + moved(-h)) / (h * h);
            let own = found.hessian[(k, k)];
            let size = found.hessian.amax();
            assert!(
                (own - expected).abs() < 2e-3 * size,
                "{tilt} {k}: {own} {expected}"
            );
        }
    }
}

// In trajectory optimisation: values and Jacobians at and between nodes, over dual numbers for free bodies, at a pose where four corners are equally near.
#[test]
fn residual_over_dual_numbers_equals_differences_at_a_switch() {
    let (model, shapes) = boxes();
    let simulator = Simulator::new(model).with_time_step(0.05);
    let soft = shapes.with_smoothing(WIDTH);
    let x = simulator.pack(&simulator.neutral_state());
    let x = x.as_slice();
    let node = Node::new(&simulator, 2);
    for samples in [0, 1] {
        let made = LinkDistances::new(simulator.model(), soft.clone(), &[["board", "box"]]);
        let residual = made.expect("links").with_samples_between(samples);
        let dim = residual.dim(&node);
        let mut out = ResidualJacobian::new(&simulator, dim);
        residual.linearize(&node, x, &[], &mut out);
        let value = |x: &[f64]| {
            let mut r = vec![0.0; dim];
            residual.value(&node, x, &[], &mut r);
            r
        };
        for (i, base) in value(x).into_iter().enumerate() {
            assert_eq!(out.values[i], base);
            for k in 0..24 {
                let moved = |h: f64| {
                    let (mut dx, mut to) = (vec![0.0; 24], x.to_vec());
                    dx[k] = h;
                    System::integrate(&simulator, x, &dx, &mut to);
                    value(&to)[i]
                };
                let expected = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                let found = out.row(i)[k];
                assert!(
                    (found - expected).abs() < 1e-7,
                    "{i} {k}: {found} {expected}"
                );
            }
        }
    }
}

/// A box that rocks by an angle over a plate or over the ground, in smoothed contact, 2 mm above it.
fn rocking(law: ContactLaw, ground: bool, angle: f64) -> (Simulator, State) {
    let mut world = World::default();
    let plate = Object::fixed().at(at(0.0, 0.0, if ground { -9.0 } else { -0.1 }));
    let size = [1.0, 0.8, 0.2];
    world.add_box("plate", size, &plate).expect("a plate");
    let place = at(0.0, 0.0, 0.202);
    let own = Object::free(Mass::Kilograms(1.0)).at(place);
    world.add_box("box", [0.3, 0.2, 0.4], &own).expect("a box");
    let model = world.build().expect("a world");
    let terrain = Terrain::flat(if ground { 0.0 } else { -5.0 });
    let contacts = Contacts::new(&model, terrain, law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("links")
        .with_smoothing(Smoothing::new(1.0));
    let simulator = Simulator::new(model).with_contacts(contacts);
    let simulator = simulator.with_time_step(1e-3);
    let mut state = simulator.neutral_state();
    let turned = [0.0, 0.0, 0.0, 0.0, angle, 0.0];
    state.q = simulator.model().integrate(state.q.as_slice(), &turned);
    (simulator, state)
}

// With smoothed contact each corner has its own force: the step and its derivatives are continuous where the lowest corner switches.
#[test]
fn smoothed_forces_pass_a_switch_of_corners_smoothly() {
    let laws = [
        ContactLaw::Rigid(Rigid::default()),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
    ];
    for law in laws {
        for ground in [true, false] {
            let velocity = |angle: f64| {
                let (simulator, state) = rocking(law, ground, angle);
                simulator.step(&state, &[]).v
            };
            let slope = |angle: f64| {
                let (simulator, state) = rocking(law, ground, angle);
                let a = simulator.linearize(&state, &[]).a;
                a.view((6, 4), (6, 1)).into_owned()
            };
            let h = 1e-6;
            let difference = (velocity(h) - velocity(-h)) / (2.0 * h);
            let at_switch = slope(0.0);
            let size = at_switch.amax().max(difference.amax());
            assert!(size > 1e-2, "no force: {size:e}");
            for (k, found) in at_switch.iter().enumerate() {
                let error = (found - difference[k]).abs();
                assert!(
                    error < 1e-4 * size,
                    "{law:?} {ground} {k}: {found} {difference}"
                );
            }
            for side in [-1e-7, 1e-7] {
                let jump = (slope(side) - &at_switch).amax();
                assert!(jump < 1e-4 * size, "{law:?} {ground}: {jump:e} of {size:e}");
            }
        }
    }
}
