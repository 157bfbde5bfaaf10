//! Edges and folds of the ground, and bodies that roll over and into them.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::common::{OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA};
use dualbody::contact::{
    ContactLaw, Contacts, HeightField, HeightFunction, Terrain, TerrainFunction,
};
use dualbody::model::{LinkSpec, Mass};
use dualbody::{Model, Scalar, Simulator, State};
use nalgebra::vector;

use crate::common::ground::{
    assert_derivatives, base_velocity, body, energy, free, hills, rolling_on, run, sticky_laws,
    stored, wheel,
};

const RADIUS: f64 = 0.1;

fn ball() -> Model {
    body(LinkSpec::solid_sphere("ball", RADIUS, Mass::Kilograms(1.0)))
}

/// Makes bodies of 1 kg, with their axes along z.
fn shapes() -> [Model; 3] {
    let mass = Mass::Kilograms(1.0);
    [
        LinkSpec::solid_sphere("ball", RADIUS, mass),
        LinkSpec::solid_capsule("capsule", RADIUS, 0.3, mass),
        LinkSpec::solid_cylinder("cylinder", RADIUS, 0.2, mass),
    ]
    .map(body)
}

/// Up along x from 0 to 1 m between 0 and 2 m.
fn ramp() -> Terrain {
    let heights: Vec<f64> = (0..3).flat_map(|_| [0.0, 0.5, 1.0]).collect();
    Terrain::HeightField(HeightField::new([0.0; 2], [1.0; 2], [3, 3], &heights))
}

/// The same in closed form.
struct Ramp;
impl HeightFunction for Ramp {
    fn height<T: Scalar>(&self, x: T, _y: T, _: &[T]) -> T {
        let (low, high) = (T::zero(), T::one());
        (x * 0.5).max(low).min(high)
    }
}

fn ramp_by_a_function() -> Terrain {
    Terrain::Function(TerrainFunction::new(Ramp, &[]))
}

#[test]
fn ground_beyond_the_border_of_a_grid_is_level() {
    let ramp = ramp();
    let beyond = [
        (2.01, 1.0),
        (10.0, 1.0),
        (1000.0, 1.0),
        (-0.01, 0.0),
        (-7.0, 0.0),
    ];
    for (x, height) in beyond {
        for y in [-5.0, 0.7, 5.0] {
            let ground = ramp.surface(&x, &y);
            assert!((ground.height - height).abs() < ROUNDING, "({x}, {y})");
            let level = ground.slope.iter().all(|s| s.abs() < ROUNDING);
            assert!(level, "({x}, {y}): {ground:?}");
        }
    }
    // Beyond the border it keeps the height and slope of the border.
    let ground = ramp.surface(&0.7, &9.0);
    assert!((ground.height - 0.35).abs() < ROUNDING && (ground.slope[0] - 0.5).abs() < ROUNDING);
    let nowhere = ramp.surface(&f64::NAN, &0.0);
    assert!(nowhere.height.is_nan() && nowhere.slope[0].is_nan());
}

#[test]
fn slope_of_a_grid_is_the_derivative_of_its_height_within_and_beyond() {
    let hills = hills();
    for k in 0..400 {
        let (x, y) = (-2.0 + 0.0103 * f64::from(k), 1.7 - 0.0091 * f64::from(k));
        let h = 1e-6;
        let along = |dx: f64, dy: f64| {
            let at = |s: f64| hills.surface(&(x + s * dx), &(y + s * dy)).height;
            (at(h) - at(-h)) / (2.0 * h)
        };
        let slope = hills.surface(&x, &y).slope;
        let errors = [slope[0] - along(1.0, 0.0), slope[1] - along(0.0, 1.0)];
        assert!(
            errors.iter().all(|e| e.abs() < 1e-8),
            "({x}, {y}): {errors:?}"
        );
    }
}

#[test]
fn ball_beyond_the_border_of_a_grid_stays() {
    for law in sticky_laws(1e-4) {
        let simulator = rolling_on(&ball(), ramp(), law);
        let start = free(&simulator, [2.2, 1.0, 1.0 + RADIUS], 0.0, [0.0; 6]);
        let end = run(&simulator, &start, 3.0);
        assert!(
            (end.q[0] - 2.2).abs() < OTHER_ALGORITHM,
            "{law:?}: {}",
            end.q[0]
        );
    }
}

/// Rolls along x from a place on, at a height of the ground, with a speed.
struct Roll {
    x: f64,
    height: f64,
    speed: f64,
}

/// Down over the upper edge and through the inner one, slow and fast, and into the inner edge and up, slow and fast.
const ROLLS: [Roll; 4] = [
    Roll {
        x: 2.05,
        height: 1.0,
        speed: -0.3,
    },
    Roll {
        x: 2.05,
        height: 1.0,
        speed: -3.0,
    },
    Roll {
        x: -0.3,
        height: 0.0,
        speed: 0.5,
    },
    Roll {
        x: -0.3,
        height: 0.0,
        speed: 3.0,
    },
];

impl Roll {
    /// The start, moved by a part of a step, so that edges fall elsewhere in one.
    fn start(&self, simulator: &Simulator, phase: f64) -> State {
        let x = self.x + phase * simulator.time_step() * self.speed;
        let mut start = wheel(
            simulator,
            [x, 1.0, self.height + RADIUS],
            0.3,
            0.0,
            [0.0; 6],
        );
        let q = nalgebra::Quaternion::new(start.q[3], start.q[4], start.q[5], start.q[6]);
        let R_BW = nalgebra::UnitQuaternion::from_quaternion(q).inverse();
        let linear = R_BW * vector![self.speed, 0.0, 0.0];
        let angular = R_BW * vector![0.0, self.speed / RADIUS, 0.0];
        start.v.rows_mut(0, 3).copy_from(&linear);
        start.v.rows_mut(3, 3).copy_from(&angular);
        start
    }
}

/// Largest gain of energy over the first state, and over any state before, J.
fn gains(simulator: &Simulator, states: &[State]) -> [f64; 2] {
    let energy = |state| energy(simulator.model(), state) + stored(simulator, state);
    let first = energy(&states[0]);
    let (mut least, mut gains) = (first, [0.0_f64; 2]);
    for now in states.iter().map(energy) {
        least = least.min(now);
        gains = [gains[0].max(now - first), gains[1].max(now - least)];
    }
    gains
}

// Of 1 to 20 J. A ball that strikes the other side of an inner edge may lose energy, by the law of impact; no law may gain
// any. Regularised contact returns the energy of its springs, whose amount is not known.
#[test]
fn nothing_round_gains_energy_over_edges_and_in_folds() {
    for (model, terrain) in shapes()
        .iter()
        .flat_map(|model| [ramp(), ramp_by_a_function()].map(|terrain| (model, terrain)))
    {
        for law in sticky_laws(1e-4) {
            let simulator = rolling_on(model, terrain.clone(), law);
            for (roll, phase) in ROLLS.iter().flat_map(|r| [0.0, 0.3, 0.6].map(|p| (r, p))) {
                let start = roll.start(&simulator, phase);
                let rollout = simulator.rollout(&start, 1500, |_, _, _| {});
                let [mut gain, growth] = gains(&simulator, &rollout.states);
                if !matches!(law, ContactLaw::RelaxedRigid(_)) {
                    gain = growth;
                }
                let name = &model.link_names()[0];
                let text = format!("{name} on {terrain:?}, {law:?}, from {} m", roll.x);
                assert!(
                    gain < OTHER_ALGORITHM,
                    "{text}: {gain:e} J at {} m/s",
                    roll.speed
                );
                let mut moved = rollout.states.iter().map(|state| state.q[0] - start.q[0]);
                assert!(moved.any(|x| x.abs() > 0.2), "{text}: it does not move");
            }
        }
    }
}

// By hand: of the two planes of z = max(0, x / 2), the one that is nearer to the centre, from both sides of where they
// are as near.
#[test]
fn depth_in_a_fold_is_that_in_the_deeper_side_and_has_no_jump() {
    let (sin, cos) = 0.5_f64.atan().sin_cos();
    let contacts_on = |terrain| Contacts::new(&ball(), terrain, sticky_laws(1e-4)[2]);
    for contacts in [ramp(), ramp_by_a_function()].map(contacts_on) {
        for k in -60..40 {
            let (x, z) = (1e-3 * f64::from(k), RADIUS - 2e-3);
            let point = contacts.states(&ball(), &[x, 1.0, z, 1.0, 0.0, 0.0, 0.0], &[0.0; 6])[0];
            let (level, slope) = (RADIUS - z, RADIUS - (z * cos - x * sin));
            let error = point.depth - level.max(slope);
            assert!(
                error.abs() < SAME_ALGEBRA,
                "at {x}: {point:?}, not {level} or {slope}"
            );
            let leans = if slope > level { sin } else { 0.0 };
            assert!(
                (point.normal.x + leans).abs() < SAME_ALGEBRA,
                "at {x}: {point:?}"
            );
        }
    }
}

/// z = |x| / 2.
struct Groove;
impl HeightFunction for Groove {
    fn height<T: Scalar>(&self, x: T, _y: T, _: &[T]) -> T {
        x.max(-x) * 0.5
    }
}

// It touches one side at a time, and so trembles between them; the centre is r √(1 + ¼) above the fold.
#[test]
fn ball_dropped_into_a_groove_comes_to_lie_between_its_sides() {
    let groove = Terrain::Function(TerrainFunction::new(Groove, &[]));
    let height = RADIUS * 1.25_f64.sqrt();
    for law in sticky_laws(1e-4) {
        let simulator = rolling_on(&ball(), groove.clone(), law);
        for x in [0.0, 0.03] {
            let start = free(&simulator, [x, 0.0, 0.16], 0.0, [0.0; 6]);
            let rollout = simulator.rollout(&start, 3000, |_, _, _| {});
            let end = rollout.last();
            let off = end.q[0].hypot(end.q[2] - height);
            let last = &rollout.states[2500..];
            let speeds = last.iter().map(|state| base_velocity(state).norm());
            let speed = speeds.fold(0.0, f64::max);
            assert!(off < 1e-3 && speed < 0.06, "{law:?}: {off} at {speed}");
            let [over_start, _] = gains(&simulator, &rollout.states);
            assert!(over_start < OTHER_ALGORITHM, "{law:?}: {over_start}");
        }
    }
}

#[test]
fn derivatives_on_an_edge_equal_differences() {
    for law in sticky_laws(1e-3) {
        let simulator = rolling_on(&ball(), ramp(), law);
        // The normal on the upper edge of a ramp of 0.5 is between 0 and 0.46 rad from the vertical.
        for angle in [0.1_f64, 0.3] {
            let reach = RADIUS - 7e-4;
            let at = [2.0 - reach * angle.sin(), 1.2, 1.0 + reach * angle.cos()];
            let state = free(&simulator, at, 0.4, [0.1, -0.2, 0.05, 0.3, 0.1, -0.2]);
            let contacts = simulator.contacts().expect("contacts");
            let point = contacts.states(&ball(), state.q.as_slice(), state.v.as_slice())[0];
            assert!((point.depth - 7e-4).abs() < SAME_ALGEBRA, "{point:?}");
            assert!((point.normal.x + angle.sin()).abs() < 1e-8, "{point:?}");
            assert_derivatives(&simulator, &state, &format!("{law:?} at {angle}"));
        }
    }
}
