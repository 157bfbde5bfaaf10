//! Cylinders and balls that roll and stand, on planes and on curved ground, against closed forms.

use crate::common::{OTHER_ALGORITHM, ROUNDING};
use dualbody::contact::{
    ContactLaw, Contacts, HeightField, HeightFunction, Terrain, TerrainFunction,
};
use dualbody::dynamics::kinetic_energy;
use dualbody::model::{LinkSpec, Mass};
use dualbody::sim::BatchSimulator;
use dualbody::{Integrator, Model, Scalar, Simulator, State};
use nalgebra::{UnitQuaternion, Vector3, vector};

use crate::common::ground::{
    assert_derivatives, base_velocity, body, energy, hills, rolling_on, run, sticky_laws, stored,
    waves, wheel,
};

const GRAVITY: f64 = 9.81;
const RADIUS: f64 = 0.1;
/// Half a turn of the base about y by this lays a cylinder on its rims.
const LYING: f64 = std::f64::consts::FRAC_PI_2;

fn cylinder(length: f64) -> Model {
    body(LinkSpec::solid_cylinder(
        "disc",
        RADIUS,
        length,
        Mass::Kilograms(1.0),
    ))
}

#[test]
fn lowest_point_of_a_rim_is_exact_beyond_a_milliradian() {
    let simulator = rolling_on(&cylinder(0.04), Terrain::flat(0.0), sticky_laws(1e-4)[2]);
    let (model, contacts) = (simulator.model(), simulator.contacts().expect("contacts"));
    for lean in [0.0, 0.3, -1.2, LYING - 1.1e-3] {
        for phase in [0.0, 0.4, 1.9, 3.0, -2.2] {
            let state = wheel(&simulator, [0.5, 0.0, 0.2], phase, lean, [0.0; 6]);
            let points = contacts.states(model, state.q.as_slice(), &[0.0; 6]);
            let (sin, cos) = lean.sin_cos();
            // Axle (0, −cos, −sin) of length 0.04; the lowest point lies (0, sin, −cos) · r away from it.
            for (k, end) in [(0, -0.5), (3, 0.5)] {
                let centre = vector![0.5, -end * 0.04 * cos, 0.2 - end * 0.04 * sin];
                let expected = centre + vector![0.0, sin, -cos] * RADIUS;
                let error = (points[k].position - expected).amax();
                assert!(error < ROUNDING, "lean {lean} phase {phase}: {error:e}");
            }
        }
    }
}

#[test]
fn disc_on_its_rim_stands_still() {
    for law in sticky_laws(1e-4) {
        let simulator = rolling_on(&cylinder(0.04), Terrain::flat(0.0), law);
        for phase in [0.0, 0.7] {
            let start = wheel(&simulator, [0.0, 0.0, RADIUS], phase, 0.0, [0.0; 6]);
            let end = run(&simulator, &start, 5.0);
            let moved = end.q[0].abs().max(end.q[1].abs());
            assert!(moved < OTHER_ALGORITHM, "{law:?}: moved by {moved:e}");
            assert!(end.v.amax() < OTHER_ALGORITHM, "{law:?}: {}", end.v.amax());
        }
    }
}

#[test]
fn wheel_keeps_its_speed_on_the_level() {
    for law in sticky_laws(1e-5) {
        let simulator = rolling_on(&cylinder(0.04), Terrain::flat(0.0), law);
        for speed in [0.02, 0.1] {
            // Its axle is along −y of the world: z of the body.
            let spin = -speed / RADIUS;
            let start = wheel(&simulator, [0.0, 0.0, RADIUS], 0.3, 0.0, [0.0; 6]);
            let v_B = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(
                start.q[3], start.q[4], start.q[5], start.q[6],
            ))
            .inverse()
                * vector![speed, 0.0, 0.0];
            let start = simulator.state(start.q.as_slice(), &[v_B.x, v_B.y, v_B.z, 0.0, 0.0, spin]);
            let end = run(&simulator, &start, 10.0);
            assert!(
                (end.q[0] / (10.0 * speed) - 1.0).abs() < 2e-3,
                "{law:?} {}",
                end.q[0]
            );
        }
    }
}

#[test]
fn cylinder_rolls_down_with_two_thirds_of_sliding() {
    let angle: f64 = 0.3;
    for length in [0.04, 0.5] {
        for (k, law) in sticky_laws(1e-5).into_iter().enumerate() {
            let errors = [2e-3, 1e-3].map(|dt| {
                let simulator =
                    rolling_on(&cylinder(length), Terrain::incline(angle), law).with_time_step(dt);
                let at = [-angle.sin() * RADIUS, 0.0, angle.cos() * RADIUS];
                let start = wheel(&simulator, at, 0.3, 0.0, [0.0; 6]);
                let [one, two] = [0.5, 1.0].map(|t| base_velocity(&run(&simulator, &start, t)));
                let down = vector![-angle.cos(), 0.0, -angle.sin()];
                let gained = 2.0 * (two - one).dot(&down);
                gained / (2.0 / 3.0 * GRAVITY * angle.sin()) - 1.0
            });
            let bound = [2e-4, 2e-3, 1e-9][k];
            assert!(errors[1].abs() < bound, "{law:?}: {errors:?}");
        }
    }
}

/// A coin that leans about an axis in no special direction of the rims, with some spin.
fn leaning_coin(simulator: &Simulator, lean: f64) -> State {
    let height = RADIUS * lean.sin() + 0.01 * lean.cos();
    let axis = nalgebra::Unit::new_normalize(vector![0.8, 0.33, 0.0]);
    let turn = UnitQuaternion::from_axis_angle(&axis, lean);
    simulator.state(
        &[0.0, 0.0, height, turn.w, turn.i, turn.j, turn.k],
        &[0.0, 0.0, 0.0, 0.1, 0.0, 0.4],
    )
}

/// Largest gain of energy over any moment before, J.
fn growth(simulator: &Simulator, states: &[State]) -> f64 {
    let (mut least, mut growth) = (f64::INFINITY, 0.0_f64);
    for state in states {
        let now = energy(simulator.model(), state) + stored(simulator, state);
        least = least.min(now);
        growth = growth.max(now - least);
    }
    growth
}

/// Depth of the deepest point of any state, m.
fn deepest(simulator: &Simulator, states: &[State]) -> f64 {
    let contacts = simulator.contacts().expect("contacts");
    let of = |state: &State| contacts.states(simulator.model(), state.q.as_slice(), &[0.0; 6]);
    let points = states.iter().flat_map(of);
    points.map(|point| point.depth).fold(0.0, f64::max)
}

// The lowest point of a coin in fast rotation runs around its rim, and a step that keeps the point where it was from sinking
// lets the next one sink, by ½ r α (Ω Δt)². Rigid contact lifts a sunken point in its recovery time, which takes m g
// δ and no more. Regularised contact returns the energy of its springs.
#[test]
fn energy_of_a_falling_coin_grows_by_no_more_than_lifts_it_out() {
    for law in sticky_laws(1e-4) {
        for lean in [0.05, 0.4] {
            let simulator =
                rolling_on(&cylinder(0.02), Terrain::flat(0.0), law).with_time_step(2e-4);
            let start = leaning_coin(&simulator, lean);
            let rollout = simulator.rollout(&start, 10_000, |_, _, _| {});
            let growth = growth(&simulator, &rollout.states);
            let most = match law {
                ContactLaw::Soft(_) => 1e-9,
                ContactLaw::RelaxedRigid(_) => 0.06,
                _ => {
                    let depth = deepest(&simulator, &rollout.states);
                    assert!(depth < 2e-4, "{depth}");
                    GRAVITY * depth
                }
            };
            assert!(growth < most, "{law:?}: {growth} of {most}");
        }
    }
}

// Only impacts and slip take energy from a rigid coin: without them it keeps rotating as Euler's disc, with the
// kinetic energy ½ m g r sin α, until it leans by less than the milliradian below which a circle has no lowest point.
// Other laws damp it.
#[test]
fn tilted_coin_falls_flat_or_whirls_on_as_eulers_disc() {
    for law in sticky_laws(1e-4) {
        for lean in [0.05, 0.4] {
            let simulator =
                rolling_on(&cylinder(0.02), Terrain::flat(0.0), law).with_time_step(2e-4);
            let end = run(&simulator, &leaning_coin(&simulator, lean), 2.0);
            assert!((end.q[2] - 0.01).abs() < 6e-4, "{law:?}: {}", end.q[2]);
            let alpha = 2.0 * end.q[4].hypot(end.q[5]);
            if alpha < 1e-3 {
                continue;
            }
            let model = simulator.model();
            let kinetic = kinetic_energy(model, end.q.as_slice(), end.v.as_slice());
            let expected = 0.5 * GRAVITY * RADIUS * alpha;
            let is_rigid = matches!(law, ContactLaw::Rigid(_));
            assert!(is_rigid && alpha < 3e-3, "{law:?}: leans by {alpha}");
            assert!(
                (kinetic / expected - 1.0).abs() < 0.02,
                "{kinetic}, not {expected}"
            );
        }
    }
}

#[test]
fn derivatives_of_rolling_and_standing_cylinders_equal_differences() {
    for law in sticky_laws(1e-3) {
        for lean in [0.0, 0.4, LYING - 2e-3, LYING - 7e-4, LYING - 2e-4, LYING] {
            let simulator = rolling_on(&cylinder(0.1), Terrain::flat(0.0), law);
            let (sin, cos) = (f64::sin(lean), f64::cos(lean));
            let height = RADIUS * cos + 0.05 * sin - 7e-4;
            let v = [0.1, -0.2, 0.05, 0.3, 0.1, -0.2];
            let state = wheel(&simulator, [0.0, 0.0, height], 0.3, lean, v);
            assert_derivatives(&simulator, &state, &format!("{law:?} lean {lean}"));
        }
    }
}

#[test]
fn derivatives_of_rolling_on_curved_ground_equal_differences() {
    let mass = Mass::Kilograms(1.0);
    let models = [
        body(LinkSpec::solid_sphere("ball", RADIUS, mass)),
        body(LinkSpec::solid_capsule("capsule", RADIUS, 0.3, mass)),
        cylinder(0.1),
    ];
    let v = [0.1, -0.2, 0.05, 0.3, 0.1, -0.2];
    for (model, terrain) in models
        .iter()
        .flat_map(|m| grounds().map(|ground| (m, ground)))
    {
        for (law, lean) in sticky_laws(1e-3).into_iter().zip([0.05, 0.9, 1.2]) {
            let simulator = rolling_on(model, terrain.clone(), law);
            let mut state = wheel(&simulator, [0.11, 0.07, 0.3], 0.3, lean, v);
            // Down until the lowest point is 0.7 mm deep.
            let contacts = simulator.contacts().expect("contacts");
            for _ in 0..4 {
                let points = contacts.states(model, state.q.as_slice(), &v);
                let deepest = points.iter().map(|p| p.depth).fold(-1.0, f64::max);
                state.q[2] += deepest - 7e-4;
            }
            let at = format!("{} on {terrain:?}: {law:?}", model.total_mass());
            assert_derivatives(&simulator, &state, &at);
        }
    }
}

fn grounds() -> [Terrain; 3] {
    [hills(), waves(), trough()]
}

#[test]
fn depth_of_a_ball_is_measured_to_the_nearest_point_of_the_ground() {
    let ball = body(LinkSpec::solid_sphere("ball", RADIUS, Mass::Kilograms(1.0)));
    for terrain in grounds() {
        let contacts = Contacts::new(&ball, terrain.clone(), sticky_laws(1e-4)[2]);
        for (k, gap) in (0..60).zip([-0.01, 0.0, 0.03].into_iter().cycle()) {
            let x = 0.3 * f64::sin(1.3 * f64::from(k));
            let y = 0.2 * f64::cos(2.1 * f64::from(k));
            let z = terrain.surface(&x, &y).height + RADIUS + gap;
            let q = [x, y, z, 1.0, 0.0, 0.0, 0.0];
            let point = contacts.states(&ball, &q, &[0.0; 6])[0];
            let centre = vector![x, y, z];
            let error = point.depth - (RADIUS - distance(&terrain, centre));
            assert!(error.abs() < 1e-10, "{terrain:?} at {q:?}: {error:e}");
            let lowest = centre - point.normal * RADIUS;
            assert!((point.position - lowest).amax() < 10.0 * ROUNDING);
        }
    }
}

/// To the nearest point of the ground, by a search on ever finer grids.
fn distance(terrain: &Terrain, centre: Vector3<f64>) -> f64 {
    let (mut least, mut at, mut width) = (f64::INFINITY, [centre.x, centre.y], 0.1);
    for _ in 0..14 {
        let about = at;
        for (i, j) in (-10..=10).flat_map(|i| (-10..=10).map(move |j| (i, j))) {
            let [x, y] = [
                about[0] + 0.1 * width * f64::from(i),
                about[1] + 0.1 * width * f64::from(j),
            ];
            let ground = vector![x, y, terrain.surface(&x, &y).height];
            let distance = (ground - centre).norm();
            if distance < least {
                (least, at) = (distance, [x, y]);
            }
        }
        width *= 0.3;
    }
    least
}

#[test]
fn rolling_on_curved_ground_in_a_batch_equals_one_by_one_bit_for_bit() {
    let ball = body(LinkSpec::solid_sphere("ball", RADIUS, Mass::Kilograms(1.0)));
    let mut cases = Vec::new();
    for law in sticky_laws(1e-4) {
        for model in [&ball, &cylinder(0.1)] {
            cases.extend([hills(), trough()].map(|terrain| (model.clone(), terrain, law)));
        }
    }
    for (model, terrain, law) in cases {
        let simulator =
            rolling_on(&model, terrain, law).with_integrator(Integrator::SemiImplicitEuler);
        let start = |k: u32| {
            let x = 0.02 * f64::from(k);
            wheel(&simulator, [x, 0.0, 0.13], 0.3, 10.0 * x, [0.1; 6])
        };
        let starts: Vec<State> = (0..11).map(start).collect();
        let mut batch = BatchSimulator::new(simulator.clone(), starts.len());
        let rollout = batch.rollout(&starts, 200, |_, _, _| {});
        for (k, start) in starts.iter().enumerate() {
            let own = simulator.rollout(start, 200, |_, _, _| {});
            assert_eq!(rollout.last(k), *own.last(), "{law:?}: {k}");
        }
    }
}

/// z = R − √(R² − x²), a trough along y.
struct Trough;
impl HeightFunction for Trough {
    fn height<T: Scalar>(&self, x: T, _y: T, parameters: &[T]) -> T {
        parameters[0] - (parameters[0] * parameters[0] - x * x).sqrt()
    }
}

fn trough() -> Terrain {
    Terrain::Function(TerrainFunction::new(Trough, &[1.0]))
}

/// Makes the trough on a grid.
fn trough_on_a_grid(spacing: f64) -> Terrain {
    let n = (1.2 / spacing).round() as usize + 1;
    let line = (0..n).map(|k| {
        let x = -0.6 + spacing * k as f64;
        1.0 - (1.0 - x * x).sqrt()
    });
    let line: Vec<f64> = line.collect();
    let heights: Vec<f64> = (0..4).flat_map(|_| line.iter().copied()).collect();
    Terrain::HeightField(HeightField::new(
        [-0.6, -1.5],
        [spacing, 1.0],
        [n, 4],
        &heights,
    ))
}

/// The period of rolling in a trough from an amplitude on, rad, from where it crosses the middle.
fn period(simulator: &Simulator, radius: f64, amplitude: f64) -> f64 {
    let reach = 1.0 - radius;
    let at = [reach * amplitude.sin(), 0.0, 1.0 - reach * amplitude.cos()];
    let start = wheel(simulator, at, 0.3, 0.0, [0.0; 6]);
    let dt = simulator.time_step();
    let steps = (6.0 / dt) as usize;
    let rollout = simulator.rollout(&start, steps, |_, _, _| {});
    let x: Vec<f64> = rollout.states.iter().map(|state| state.q[0]).collect();
    let crossings: Vec<f64> = (1..x.len())
        .filter(|&k| x[k - 1] > 0.0 && x[k] <= 0.0)
        .map(|k| dt * (k as f64 - x[k] / (x[k] - x[k - 1])))
        .collect();
    crossings[1] - crossings[0]
}

/// That of a pendulum of length (R − r) with the inertia k m r² of rolling.
fn expected_period(radius: f64, inertia: f64, amplitude: f64) -> f64 {
    let small = std::f64::consts::TAU * ((1.0 + inertia) * (1.0 - radius) / GRAVITY).sqrt();
    let square = amplitude * amplitude;
    small * (1.0 + square / 16.0 + square * square * (11.0 / 3072.0))
}

#[test]
fn ball_in_a_valley_swings_with_its_period() {
    for radius in [0.02, 0.1, 0.3] {
        let expected = expected_period(radius, 0.4, 0.02);
        let ball = body(LinkSpec::solid_sphere("ball", radius, Mass::Kilograms(1.0)));
        for terrain in [trough(), trough_on_a_grid(0.02)] {
            for law in sticky_laws(1e-6) {
                let simulator = rolling_on(&ball, terrain.clone(), law);
                let error = period(&simulator, radius, 0.02) / expected - 1.0;
                assert!(error.abs() < 1e-3, "r {radius} {law:?}: {error:e}");
            }
        }
    }
}

#[test]
fn period_on_a_grid_of_a_twenty_fifth_of_the_radius_of_the_valley_is_exact_to_a_ten_thousandth() {
    let ball = body(LinkSpec::solid_sphere("ball", 0.1, Mass::Kilograms(1.0)));
    let simulator = rolling_on(&ball, trough_on_a_grid(0.04), sticky_laws(1e-6)[2]);
    let error = period(&simulator, 0.1, 0.02) / expected_period(0.1, 0.4, 0.02) - 1.0;
    assert!(error.abs() < 1e-4, "{error:e}");
}

#[test]
fn ball_in_a_valley_swings_far_as_a_pendulum_does() {
    for radius in [0.1, 0.3] {
        let ball = body(LinkSpec::solid_sphere("ball", radius, Mass::Kilograms(1.0)));
        let expected = expected_period(radius, 0.4, 0.4);
        for law in sticky_laws(1e-6) {
            let simulator = rolling_on(&ball, trough(), law);
            let error = period(&simulator, radius, 0.4) / expected - 1.0;
            assert!(error.abs() < 1e-3, "r {radius} {law:?}: {error:e}");
        }
    }
}

#[test]
fn cylinder_and_capsule_in_a_valley_swing_with_their_periods() {
    let cylinder = cylinder(0.2);
    let capsule = body(LinkSpec::solid_capsule(
        "capsule",
        RADIUS,
        0.3,
        Mass::Kilograms(1.0),
    ));
    for model in [cylinder, capsule] {
        let inertia = model.bodies()[0].inertia.rotational.to_matrix()[(2, 2)] / (RADIUS * RADIUS);
        let expected = expected_period(RADIUS, inertia, 0.02);
        for terrain in [trough(), trough_on_a_grid(0.02)] {
            for law in sticky_laws(1e-6) {
                let simulator = rolling_on(&model, terrain.clone(), law);
                let error = period(&simulator, RADIUS, 0.02) / expected - 1.0;
                assert!(error.abs() < 1e-3, "{law:?}: {error:e}");
            }
        }
    }
}
