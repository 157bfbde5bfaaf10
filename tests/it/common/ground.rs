//! Free bodies on the ground, and differences of their steps.

use dualbody::contact::{
    ContactLaw, Contacts, HeightField, HeightFunction, Terrain, TerrainFunction,
};
use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::{Model, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector, Vector3, vector};

/// A robot on a ground, in steps of 1 ms.
pub(crate) fn on(model: Model, terrain: Terrain, law: ContactLaw) -> Simulator {
    let contacts = Contacts::new(&model, terrain, law);
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(1e-3)
}

/// A free body at a place, with a base turned about y by an angle.
pub(crate) fn free(simulator: &Simulator, position: [f64; 3], angle: f64, v: [f64; 6]) -> State {
    let (sin, cos) = (0.5 * angle).sin_cos();
    let [x, y, z] = position;
    simulator.state(&[x, y, z, cos, 0.0, sin, 0.0], &v)
}

/// The last state of a run without input.
pub(crate) fn run(simulator: &Simulator, start: &State, seconds: f64) -> State {
    let steps = (seconds / simulator.time_step()).round() as usize;
    simulator.rollout(start, steps, |_, _, _| {}).last().clone()
}

/// The velocity of the base's origin in the world.
pub(crate) fn base_velocity(state: &State) -> Vector3<f64> {
    let q = nalgebra::Quaternion::new(state.q[3], state.q[4], state.q[5], state.q[6]);
    nalgebra::UnitQuaternion::from_quaternion(q) * vector![state.v[0], state.v[1], state.v[2]]
}

/// A of a step without input by central differences of a size.
pub(crate) fn differences(simulator: &Simulator, state: &State, size: f64) -> DMatrix<f64> {
    let (model, n) = (simulator.model(), simulator.n_tangent());
    let nv = model.nv();
    let u = vec![0.0; simulator.nu()];
    let mut out = DMatrix::zeros(n, n);
    let reference = simulator.step(state, &u);
    for k in 0..n {
        let moved = |size: f64| {
            let mut dx = DVector::zeros(n);
            dx[k] = size;
            let mut moved = state.clone();
            moved.q = model.integrate(state.q.as_slice(), &dx.as_slice()[..nv]);
            moved.v += dx.rows(nv, nv);
            moved.contact += dx.rows(2 * nv, n - 2 * nv);
            simulator.step(&moved, &u).deviation(model, &reference)
        };
        out.set_column(k, &((moved(size) - moved(-size)) / (2.0 * size)));
    }
    out
}

/// A soft box of 1 kg let go on an incline, along it and at the depth of 1 mm at which its corners carry it: it sticks if and only if the
/// slope is below friction, and else slides with g (sin α − μ cos α).
#[track_caller]
pub(crate) fn assert_sticks_or_slides(simulator: &Simulator, slope: f64, mu: f64) {
    let (sin, cos) = slope.atan().sin_cos();
    let height = 0.06 - 1e-3 * cos.powf(2.0 / 3.0);
    let at = [-sin * height, 0.0, cos * height];
    let start = free(simulator, at, -slope.atan(), [0.0; 6]);
    let down = vector![-cos, 0.0, -sin];
    let [v_1, v_2] = [1.0, 2.0].map(|t| base_velocity(&run(simulator, &start, t)).dot(&down));
    if slope < mu {
        assert!(v_2.abs() < 1e-6, "slope {slope} μ {mu}: creeps at {v_2}");
    } else {
        let (gained, expected) = (v_2 - v_1, 9.81 * (sin - mu * cos));
        let text = format!("slope {slope} μ {mu}: {gained}, not {expected}");
        assert!((gained - expected).abs() < 1e-3, "{text}");
    }
}

/// Kinetic and potential energy.
pub(crate) fn energy(model: &Model, state: &State) -> f64 {
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    kinetic_energy(model, q, v) + potential_energy(model, q)
}

/// Hills of a few millimetres on a grid.
pub(crate) fn hills() -> Terrain {
    let heights: Vec<f64> = (0..30).map(|k| 0.004 * (1.7 * k as f64).sin()).collect();
    Terrain::HeightField(HeightField::new(
        [-1.1, -0.9],
        [0.45, 0.38],
        [6, 5],
        &heights,
    ))
}

struct Waves;

impl HeightFunction for Waves {
    fn height<T: Scalar>(&self, x: T, y: T, parameters: &[T]) -> T {
        (x * parameters[1]).sin_cos().0 * parameters[0] + y * x * 0.01
    }
}

/// Waves of a few millimetres by a function.
pub(crate) fn waves() -> Terrain {
    Terrain::Function(TerrainFunction::new(Waves, &[0.003, 2.0]))
}
