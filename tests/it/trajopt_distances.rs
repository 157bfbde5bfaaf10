//! Distances of links as residuals and constraints: against differences, the way between two nodes, and plans that would go through a wall.

use dualbody::contact::{LinkShapes, NearestError};
use dualbody::model::{Mass, Model, Object, World, samples};
use dualbody::spatial::Transform;
use dualbody::trajopt::{
    Cost, Dependence, LinkDistances, Node, Residual, ResidualJacobian, Robot, System,
};
use dualbody::{Simulator, State};
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

fn at(x: f64, y: f64, z: f64) -> Transform<f64> {
    Transform::from_translation([x, y, z].into())
}

/// A tree of joints of one axis, each link but the root with a sphere, a free box, a cylinder and a wall.
fn crowd() -> Simulator {
    let mut world = World::new("crowd");
    let arm = samples::arm();
    world.add(&arm, "arm/", &at(0.0, 0.0, 0.0)).expect("an arm");
    let last = format!("arm/{}", arm.link_names().last().expect("a link"));
    let held = Object::fixed_to(&last, Mass::Kilograms(0.1));
    world.add_capsule("tool", 0.05, 0.2, &held).expect("a tool");
    let free = || Object::free(Mass::Kilograms(1.0));
    world
        .add_box("box", [0.2, 0.3, 0.4], &free().at(at(0.8, 0.1, 0.2)))
        .expect("a box");
    world
        .add_cylinder("can", 0.1, 0.3, &free().at(at(-0.7, 0.3, 0.6)))
        .expect("a can");
    world
        .add_box(
            "wall",
            [0.1, 4.0, 4.0],
            &Object::fixed().at(at(1.8, 0.0, 0.0)),
        )
        .expect("a wall");
    Simulator::new(world.build().expect("a world")).with_time_step(0.05)
}

const PAIRS: [[&str; 2]; 5] = [
    ["tool", "box"],
    ["can", "tool"],
    ["tool", "wall"],
    ["wall", "can"],
    ["box", "can"],
];

fn distances(model: &Model, samples: usize) -> LinkDistances {
    let shapes = LinkShapes::without_meshes(model);
    let made = LinkDistances::new(model, shapes, &PAIRS).expect("pairs");
    made.with_samples_between(samples)
}

fn values(residual: &LinkDistances, node: &Node<'_>, x: &[f64]) -> Vec<f64> {
    let mut r = vec![0.0; residual.dim(node)];
    residual.value(node, x, &[], &mut r);
    r
}

/// Central differences of two widths, extrapolated, and how far apart the two are: much where features change.
fn slope(f: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let by = |h: f64| (f(h) - f(-h)) / (2.0 * h);
    let (coarse, fine) = (by(2e-4), by(1e-4));
    ((4.0 * fine - coarse) / 3.0, (fine - coarse).abs())
}

fn compare(simulator: &Simulator, residual: &LinkDistances, seed: u64, lost: &mut usize) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let x = simulator.pack(&State::random(simulator.model(), &mut rng, 1.0));
    let (x, node, nv) = (
        x.as_slice(),
        Node::new(simulator, 2),
        simulator.model().nv(),
    );
    let mut out = ResidualJacobian::new(simulator, residual.dim(&node));
    residual.linearize(&node, x, &[], &mut out);
    let base = values(residual, &node, x);
    for i in 0..base.len() {
        assert!((out.values[i] - base[i]).abs() < 1e-14);
        for k in 0..2 * nv {
            let moved = |h: f64| {
                let (mut dx, mut to) = (vec![0.0; 2 * nv], x.to_vec());
                dx[k] = h;
                System::integrate(simulator, x, &dx, &mut to);
                values(residual, &node, &to)[i]
            };
            let (expected, spread) = slope(&moved);
            let found = out.row(i)[k];
            if spread > 1e-6 {
                *lost += 1;
            } else {
                let error = (found - expected).abs();
                assert!(
                    error < 1e-7,
                    "seed {seed}, entry {i}, direction {k}: {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn derivatives_of_distances_at_and_between_nodes_equal_differences() {
    let simulator = crowd();
    for samples in [0, 2] {
        let residual = distances(simulator.model(), samples);
        let mut lost = 0;
        for seed in 0..4 {
            compare(&simulator, &residual, seed, &mut lost);
        }
        // A few directions pass over an edge.
        assert!(lost < 30, "{lost}");
    }
    let arm = Simulator::new(samples::arm());
    assert!(System::is_vector_space(&arm) && !System::is_vector_space(&simulator));
}

// On a robot whose joints have one axis each the derivatives between nodes come from the gradient of the distance; over dual numbers they are the same.
#[test]
fn gradients_between_nodes_equal_those_by_dual_numbers() {
    let mut world = World::new("arm");
    let arm = samples::arm();
    world.add(&arm, "arm/", &at(0.0, 0.0, 0.0)).expect("an arm");
    let last = format!("arm/{}", arm.link_names().last().expect("a link"));
    let tool = Object::fixed_to(&last, Mass::Kilograms(0.1));
    world
        .add_box("tool", [0.1, 0.2, 0.3], &tool)
        .expect("a tool");
    world
        .add_box(
            "wall",
            [0.1, 4.0, 4.0],
            &Object::fixed().at(at(1.5, 0.0, 0.0)),
        )
        .expect("a wall");
    let simulator = Simulator::new(world.build().expect("a world")).with_time_step(0.05);
    let shapes = LinkShapes::without_meshes(simulator.model());
    let residual = LinkDistances::new(simulator.model(), shapes, &[["tool", "wall"]])
        .expect("a pair")
        .with_samples_between(3);
    assert_eq!(residual.depends_on(), Dependence::State);
    let node = Node::new(&simulator, 1);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for _ in 0..10 {
        let x = simulator.pack(&State::random(simulator.model(), &mut rng, 1.0));
        let [mut short, mut long] = [0, 1].map(|_| ResidualJacobian::new(&simulator, 4));
        residual.linearize(&node, x.as_slice(), &[], &mut short);
        long.fill_by_duals(&residual, &node, x.as_slice(), &[]);
        for i in 0..4 {
            let off = short
                .row(i)
                .iter()
                .zip(long.row(i))
                .map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12, "{i}");
        }
    }
}

// Semi-implicit Euler goes straight from q to q ⊕ dt v⁺; the samples of the second node are on that way.
#[test]
fn samples_are_on_the_way_from_the_node_before() {
    const SAMPLES: usize = 3;
    let simulator = crowd();
    let (model, residual) = (simulator.model(), distances(simulator.model(), SAMPLES));
    let shapes = LinkShapes::without_meshes(model);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
    // A free body that turns is moved by its centre of mass, which is another way.
    let mut start = State::random(model, &mut rng, 1.0);
    for name in ["box", "can"] {
        let joint = model.find_joint(name).expect("a joint");
        start.v.rows_mut(model.joint_v(joint).start, 6).fill(0.0);
    }
    let next = simulator.step(&start, &vec![0.0; simulator.nu()]);
    let found = values(
        &residual,
        &Node::new(&simulator, 1),
        simulator.pack(&next).as_slice(),
    );
    for k in 0..=SAMPLES {
        let part = 1.0 - k as f64 / (SAMPLES + 1) as f64;
        let way = &next.v * (part * simulator.time_step());
        let q = model.integrate(start.q.as_slice(), way.as_slice());
        for (i, [a, b]) in PAIRS.iter().enumerate() {
            let expected = shapes
                .nearest(model, q.as_slice(), a, b)
                .expect("a distance");
            let off = (found[k * PAIRS.len() + i] - expected.distance).abs();
            assert!(off < 1e-12, "{k}, {a} {b}: {off}");
        }
    }
    // The first node has no previous node.
    let first = values(
        &residual,
        &Node::new(&simulator, 0),
        simulator.pack(&next).as_slice(),
    );
    assert_eq!(first[..PAIRS.len()], first[PAIRS.len()..2 * PAIRS.len()]);
}

#[cfg(feature = "second-order")]
#[test]
fn second_derivatives_of_a_barrier_equal_differences_of_its_gradient() {
    let simulator = crowd();
    let (activation, residual) = distances(simulator.model(), 1).barrier(2.0);
    let cost = Cost::new().with(1.0, activation, residual);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    let x = simulator.pack(&State::random(simulator.model(), &mut rng, 0.5));
    let (n, u) = (simulator.ndx(), vec![0.0; simulator.nu()]);
    let exact = cost.expand_exactly(&simulator, 1, x.as_slice(), &u).hessian;
    let value = |dx: &[f64]| {
        let mut to = x.as_slice().to_vec();
        System::integrate(&simulator, x.as_slice(), dx, &mut to);
        cost.expand(&simulator, 1, &to, &u).value
    };
    const STEP: f64 = 1e-3;
    let mut compared = 0;
    for i in 0..n {
        let along = |h: f64| {
            let mut dx = vec![0.0; n];
            dx[i] = h;
            value(&dx)
        };
        let by = |h: f64| (along(h) + along(-h) - 2.0 * along(0.0)) / (h * h);
        let (fine, coarse) = (by(STEP), by(2.0 * STEP));
        if (fine - coarse).abs() < 2e-5 {
            let expected = (4.0 * fine - coarse) / 3.0;
            assert!(
                (exact[(i, i)] - expected).abs() < 1e-5,
                "{i}: {} {expected}",
                exact[(i, i)]
            );
            compared += 1;
        }
    }
    assert!(compared > n / 3, "{compared} of {n}");
}

// A ball of radius 0.1 m goes through a wall of 0.02 m in steps of 0.3 m: its centre is 0.15 m before and behind the middle of the wall at the nodes. Of the way
// there are five samples, of which the third is in the middle of the wall: as deep as half the wall and the radius.
#[test]
fn a_step_through_a_wall_is_seen_between_nodes_and_not_at_them() {
    let mut world = World::new("wall");
    let ball = Object::free(Mass::Kilograms(1.0));
    world.add_sphere("ball", 0.1, &ball).expect("a ball");
    let wall = Object::fixed();
    world
        .add_box("wall", [0.02, 2.0, 2.0], &wall)
        .expect("a wall");
    let simulator = Simulator::new(world.build().expect("a world")).with_time_step(0.1);
    let model = simulator.model();
    let mut state = simulator.neutral_state();
    (state.q[0], state.v[0]) = (0.15, 3.0);
    let x = simulator.pack(&state);
    let seen = |samples: usize| {
        let shapes = LinkShapes::without_meshes(model);
        let clear = LinkDistances::new(model, shapes, &[["ball", "wall"]]).expect("a pair");
        let clear = clear.with_samples_between(samples).at_least(0.01);
        let mut out = ResidualJacobian::new(&simulator, samples + 1);
        clear.linearize(&simulator, 3, x.as_slice(), &[0.0; 6], &mut out);
        out.values
    };
    assert!((seen(0)[0] - 0.04).abs() < 1e-12);
    let way = seen(5);
    assert!((way[3] + 0.11).abs() < 1e-12, "{way:?}");
    let least = way.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(least, way[3]);
}

#[test]
fn pairs_without_a_distance_are_refused_and_lost_coordinates_are_no_number() {
    let simulator = crowd();
    let model = simulator.model();
    let shapes = LinkShapes::without_meshes(model);
    let error = LinkDistances::new(model, shapes.clone(), &[["tool", "shelf"]]).unwrap_err();
    assert!(matches!(error, NearestError::UnknownName(_)), "{error}");
    assert!(error.to_string().contains("shelf") && error.to_string().contains("tool"));
    let all = LinkDistances::all(shapes.clone());
    // tool, box, can, wall: six pairs that no joint connects; the tool and the wall have the world between them.
    assert_eq!(all.dim(&Node::new(&simulator, 0)), 6);
    let none = LinkDistances::new(model, shapes, &[]).expect("no pair");
    let node = Node::new(&simulator, 1);
    assert!(values(&none.with_samples_between(2), &node, &[0.0; 64]).is_empty());
    let mut x = simulator.pack(&simulator.neutral_state());
    x[0] = f64::NAN;
    let lost = values(&distances(model, 1), &node, x.as_slice());
    assert!(lost[0].is_nan() && lost.iter().all(|r| !r.is_infinite()));
}
