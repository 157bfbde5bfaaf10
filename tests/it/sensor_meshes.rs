//! Range finders against meshes of links and surfaces of contacts: against `MuJoCo`, all triangles one by one, finite differences, single states.

use dualbody::collision::Surface;
use dualbody::contact::{CollisionOptions, ContactLaw, Contacts, Rigid, Terrain};
use dualbody::io::MjcfScene;
use dualbody::joint::JointKind;
use dualbody::model::{Base, Collision, Geometry, JointSpec, LinkSpec, ModelBuilder, UpAxis};
use dualbody::scalar::Lanes;
use dualbody::sim::{Sensor, Sensors};
use dualbody::spatial::Transform;
use dualbody::{Scalar, Simulator, State};
use nalgebra::{DVector, Matrix3, Vector3, vector};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use crate::common::{FINITE_DIFFERENCE, SAME_ALGEBRA};
use crate::mjcf::{file, find, golden};

/// `MuJoCo` keeps vertices in single precision.
const SINGLE_PRECISION: f64 = 3e-6;

/// Range of range finders where a ray meets nothing, m; `MuJoCo` reads −1 there.
const RANGE: f64 = 100.0;

fn simulator(scene: &MjcfScene) -> Simulator {
    Simulator::new(scene.model.clone())
}

#[test]
fn ranges_to_meshes_equal_those_of_mujoco() {
    let scene = file("rays");
    let sensors = scene.known_sensors();
    assert!(sensors.missing_shapes().is_empty());
    let (states, mut hits) = (golden("rays"), 0);
    for records in &states {
        let [q, v, tau] = ["q", "v", "tau"].map(|key| find(records, key));
        let y = sensors.read(&simulator(&scene), &State::new(q, v), tau);
        for (name, ours) in sensors.names().iter().zip(&y) {
            let theirs = find(records, &format!("sensor:{name}"))[0];
            let theirs = if theirs < 0.0 { RANGE } else { theirs };
            hits += usize::from(theirs < RANGE);
            let error = (ours - theirs).abs();
            assert!(
                error < SINGLE_PRECISION,
                "{name} is {ours}, MuJoCo's {theirs}"
            );
        }
    }
    assert!(hits > 9, "{hits} rays meet something");
}

/// Rotation and movement of the eye, and a hinge: C of distances to meshes that move and that do not.
#[test]
fn derivatives_of_ranges_to_meshes_equal_finite_differences() {
    let scene = file("rays");
    let (sensors, simulator) = (scene.known_sensors(), simulator(&scene));
    let [q, v] = ["q", "v"].map(|key| find(&golden("rays")[0], key).to_vec());
    let (state, u) = (State::new(&q, &v), vec![0.0; simulator.nu()]);
    let c = sensors.linearize(&simulator, &state, &u).c;
    let mut largest = 0.0_f64;
    for k in 0..simulator.model().nv() {
        let at = |h: f64| {
            let mut dq = vec![0.0; simulator.model().nv()];
            dq[k] = h;
            let q = simulator.model().integrate(&q, &dq);
            sensors.read(&simulator, &State::new(q.as_slice(), &v), &u)
        };
        let difference = |h: f64| (at(h) - at(-h)) / (2.0 * h);
        let slope: DVector<f64> = (difference(5e-5) * 4.0 - difference(1e-4)) / 3.0;
        for (i, expected) in slope.iter().enumerate() {
            let error = (c[(i, k)] - expected).abs();
            largest = largest.max(expected.abs());
            assert!(
                error < FINITE_DIFFERENCE * expected.abs().max(1.0),
                "{i} {k}: {error:e}"
            );
        }
    }
    assert!(largest > 0.5, "some distance depends on the configuration");
}

/// A free eye over a rough grid of heights.
fn over_grid() -> (Simulator, Surface) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let heights: Vec<f64> = (0..30 * 20)
        .map(|_| random.random_range(-0.3..0.3))
        .collect();
    let grid = Surface::grid([-1.5, -1.0], [0.1, 0.1], [30, 20], &heights).expect("a grid");
    let mut builder = ModelBuilder::new("eye over a grid");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(
        LinkSpec::new("eye")
            .with_mass(1.0, [0.0; 3], [1.0; 3])
            .with_collision(Collision {
                name: None,
                placement: Transform::identity(),
                geometry: Geometry::Sphere { radius: 0.01 },
            }),
    );
    builder.add_joint(JointSpec::new("free", JointKind::Floating, "world", "eye"));
    let model = builder.with_base(Base::Fixed).build().expect("a model");
    let law = ContactLaw::Rigid(Rigid::default());
    let options = CollisionOptions::default().with_surface("world", grid.clone());
    let contacts = Contacts::new(&model, Terrain::flat(-5.0), law);
    let contacts = contacts.with_collisions(&model, law, &options);
    let contacts = contacts.expect("a link of the world");
    (Simulator::new(model).with_contacts(contacts), grid)
}

fn looking(simulator: &Simulator, direction: [f64; 3]) -> Sensors {
    let frame = simulator.model().frame("eye").expect("a link");
    let eye = Sensor::RangeFinder {
        frame,
        direction,
        range: RANGE,
    };
    Sensors::new(simulator.model(), [("eye", eye)])
}

/// o + t d = a + r (b − a) + s (c − a), solved as a linear system.
fn distance_to_triangle(o: Vector3<f64>, d: Vector3<f64>, corners: [Vector3<f64>; 3]) -> f64 {
    let [a, b, c] = corners;
    let solved = Matrix3::from_columns(&[-d, b - a, c - a]).try_inverse();
    let Some(x) = solved.map(|inverse| inverse * (o - a)) else {
        return RANGE;
    };
    let is_inside = x[1] >= 0.0 && x[2] >= 0.0 && x[1] + x[2] <= 1.0 && x[0] >= 0.0;
    if is_inside { x[0] } else { RANGE }
}

#[test]
fn ranges_to_a_grid_of_heights_equal_the_least_of_all_triangles() {
    let (simulator, grid) = over_grid();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(4);
    let mut hits = 0;
    for _ in 0..300 {
        let mut state = simulator.neutral_state();
        let mut any = |r: f64| random.random_range(-r..r);
        let origin = vector![any(1.5), any(1.0), 0.5 + any(0.5)];
        let direction = vector![any(1.0), any(1.0), any(1.0)].normalize();
        state.q.as_mut_slice()[..3].copy_from_slice(origin.as_slice());
        let u = vec![0.0; simulator.nu()];
        let y = looking(&simulator, direction.into()).read(&simulator, &state, &u)[0];
        let corners = |t: &[u32; 3]| t.map(|k| grid.vertices()[k as usize]);
        let all = grid.triangles().iter();
        let nearest = all.map(|t| distance_to_triangle(origin, direction, corners(t)));
        // Beside the grid, the plane below it.
        let plane = match direction.z < 0.0 {
            true => (-5.0 - origin.z) / direction.z,
            false => RANGE,
        };
        let expected = nearest.fold(plane.min(RANGE), f64::min);
        hits += usize::from(expected < 3.0);
        assert!(
            (y - expected).abs() < 1e-9 * expected,
            "{y}, all triangles {expected}"
        );
    }
    assert!(hits > 100, "{hits} rays meet the grid");
}

/// Rays straight down onto vertices and edges, which belong to several triangles, pass between none.
#[test]
fn rays_onto_vertices_and_edges_meet_the_grid() {
    let (simulator, grid) = over_grid();
    let down = looking(&simulator, [0.0, 0.0, -1.0]);
    for [a, b, _] in grid.triangles() {
        let [a, b] = [a, b].map(|k| grid.vertices()[*k as usize]);
        for share in [0.0, 0.5] {
            let on = a + (b - a) * share;
            let mut state = simulator.neutral_state();
            state.q.as_mut_slice()[..3].copy_from_slice(&[on.x, on.y, 2.0]);
            let y = down.read(&simulator, &state, &vec![0.0; simulator.nu()])[0];
            let is_border = [a, b].iter().any(|p| p.x.abs() > 1.35 || p.y.abs() > 0.85);
            assert!(
                is_border || (y - (2.0 - on.z)).abs() < 1e-12,
                "{y} above {on}"
            );
        }
    }
}

#[test]
fn lanes_read_the_ranges_of_single_states() {
    let scene = file("rays");
    let (sensors, simulator) = (scene.known_sensors(), simulator(&scene));
    let places: Vec<Vec<f64>> = (golden("rays").iter())
        .map(|records| find(records, "q").to_vec())
        .collect();
    let (v, u) = (vec![0.0; simulator.model().nv()], vec![0.0; simulator.nu()]);
    type L = Lanes<4>;
    let of_lane = |lane: usize| &places[lane % places.len()];
    let q: Vec<L> = (0..places[0].len())
        .map(|k| L::from_values(|lane| of_lane(lane)[k]))
        .collect();
    let zeros = |n: usize| vec![L::from(0.0); n];
    let state = State::new(&q, &zeros(v.len()));
    let together = sensors.read(&simulator, &state, &zeros(u.len()));
    let mut hits = [0; 4];
    for (lane, hits) in hits.iter_mut().enumerate() {
        let single = sensors.read(&simulator, &State::new(of_lane(lane), &v), &u);
        for (together, single) in together.iter().zip(&single) {
            let error = (together.value(lane) - single).abs();
            assert!(error < SAME_ALGEBRA, "lane {lane}: {error:e}");
            *hits += usize::from(*single < RANGE);
        }
    }
    assert!(hits[0] > 0 && hits[1] > 0 && hits[0] < sensors.len());
}

#[test]
fn meshes_that_are_not_seen_are_named() {
    let mut builder = ModelBuilder::new("no mesh");
    let mesh = |path: Option<&str>| Collision {
        name: None,
        placement: Transform::identity(),
        geometry: Geometry::Mesh {
            uri: "wall.stl".into(),
            path: path.map(Into::into),
            scale: [1.0; 3],
            up_axis: UpAxis::default(),
        },
    };
    builder.add_link(
        LinkSpec::new("eye")
            .with_mass(1.0, [0.0; 3], [1.0; 3])
            .with_collision(mesh(None))
            .with_collision(mesh(Some("/nowhere/wall.stl"))),
    );
    let model = builder.build().expect("a model");
    let simulator = Simulator::new(model);
    let sensors = looking(&simulator, [1.0, 0.0, 0.0]);
    let reasons: Vec<String> = sensors
        .missing_shapes()
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(reasons.len(), 2, "{reasons:?}");
    for (reason, part) in reasons.iter().zip(["is not found", "cannot be read"]) {
        assert!(
            reason.contains("link \"eye\": the mesh wall.stl ") && reason.contains(part),
            "{reason}"
        );
    }
    let gyro = Sensor::Gyro(simulator.model().frame("eye").expect("a link"));
    let without = Sensors::new(simulator.model(), [("gyro", gyro)]);
    assert!(
        without.missing_shapes().is_empty(),
        "no range finder reads meshes"
    );
}
