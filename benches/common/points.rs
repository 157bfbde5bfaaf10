//! Random inputs over any scalar, drawn before anything is timed.

use dualbody::Cast;
use dualbody::autodiff::Dual;
use dualbody::{Lanes, Over, Simulator, State};
use nalgebra::DVector;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// So many points are gone through in turn: none is remembered by the branch predictor, all stay in the cache.
pub(crate) const N_POINTS: usize = 64;

/// Arguments of a function of dynamics.
pub(crate) struct Point<T: Over<f64>> {
    pub(crate) state: State<T>,
    pub(crate) a: Vec<T>,
    pub(crate) tau: Vec<T>,
    /// Input, of the length of the simulator's.
    pub(crate) u: Vec<T>,
}

/// A scalar with a name, and with derivatives where it has any.
pub(crate) trait Seed: Over<f64> {
    const NAME: &'static str;

    /// The coordinate `k` with the value `x`.
    fn seed(x: f64, k: usize) -> Self;
}

impl Seed for f64 {
    const NAME: &'static str = "f64";

    fn seed(x: f64, _k: usize) -> Self {
        x
    }
}

impl Seed for Dual<f64, 4> {
    const NAME: &'static str = "dual4";

    fn seed(x: f64, k: usize) -> Self {
        Self::variable(x, k % 4)
    }
}

impl Seed for Lanes<4> {
    const NAME: &'static str = "lanes4";

    fn seed(x: f64, _k: usize) -> Self {
        Self::from(x)
    }
}

impl Seed for Lanes<8> {
    const NAME: &'static str = "lanes8";

    fn seed(x: f64, _k: usize) -> Self {
        Self::from(x)
    }
}

/// Random points, the same for each scalar of a robot.
pub(crate) fn points<T: Seed>(simulator: &Simulator) -> Vec<Point<T>> {
    let model = simulator.model();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let one = |_| {
        let state = State::random(model, &mut rng, 1.0);
        let mut random = |n| -> Vec<T> {
            let numbers = (0..n).map(|k| T::seed(rng.random_range(-1.0..1.0), k));
            numbers.collect()
        };
        Point {
            state: State::new(seeded(&state.q).as_slice(), seeded(&state.v).as_slice()),
            a: random(model.nv()),
            tau: random(model.nv()),
            u: random(simulator.nu()),
        }
    };
    (0..N_POINTS).map(one).collect()
}

/// Points along the motion from a state without input.
pub(crate) fn points_from<T: Seed>(simulator: &Simulator, start: &State) -> Vec<Point<T>> {
    let (mut state, u) = (start.clone(), vec![0.0; simulator.nu()]);
    let one = |_| {
        state = simulator.step(&state, &u);
        let mut lifted: State<T> = state.cast();
        (lifted.q, lifted.v) = (seeded(&state.q), seeded(&state.v));
        Point {
            state: lifted,
            a: Vec::new(),
            tau: Vec::new(),
            u: vec![T::zero(); simulator.nu()],
        }
    };
    (0..N_POINTS).map(one).collect()
}

fn seeded<T: Seed>(x: &DVector<f64>) -> DVector<T> {
    DVector::from_iterator(x.len(), x.iter().enumerate().map(|(k, &x)| T::seed(x, k)))
}
