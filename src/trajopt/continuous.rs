//! Systems in continuous time: the rate of the state, ẋ = f(x, u).

use nalgebra::DMatrix;

use super::dynamics::Dynamics;
use crate::autodiff::{CHUNK, Dual, JacobianScratch, jacobian_into};
use crate::linearize::{Linearization, RateScratch};
use crate::scalar::{Scalar, lift_into};
use crate::sim::{Simulator, State, StepScratch};

/// A system in continuous time, ẋ = f(x, u), of which [`step`](Dynamics::step) is some integrator's approximation.
///
/// On a manifold ẋ is in the tangent space at x: a body's velocity in its own frame, not the rate of its quaternion. A [`Simulator`]
/// is one, with ẋ = (v, v̇): the acceleration that its steps integrate.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, trajopt::{ContinuousDynamics, Dynamics}};
///
/// /// A mass of 1 kg pushed along a line.
/// struct Mass;
/// impl Dynamics for Mass {
///     fn nx(&self) -> usize {
///         2
///     }
///     fn nu(&self) -> usize {
///         1
///     }
///     fn time_step(&self) -> f64 {
///         0.1
///     }
///     fn step<T: Scalar>(&self, x: &[T], u: &[T], next: &mut [T]) {
///         next[1] = x[1] + u[0] * 0.1;
///         next[0] = x[0] + next[1] * 0.1;
///     }
/// }
/// impl ContinuousDynamics for Mass {
///     fn rate<T: Scalar>(&self, x: &[T], u: &[T], rate: &mut [T]) {
///         (rate[0], rate[1]) = (x[1], u[0]);
///     }
/// }
/// let mut rate = [0.0; 2];
/// Mass.rate(&[1.0, 3.0], &[10.0], &mut rate);
/// assert_eq!(rate, [3.0, 10.0]);
/// ```
pub trait ContinuousDynamics: Dynamics {
    /// Computes ẋ = f(x, u). May allocate; what is called often goes through [`rates`](Self::rates).
    ///
    /// * `x` – state, length `nx`
    /// * `u` – input, length `nu`
    /// * `rate` – output, tangent at x, length `ndx`
    fn rate<T: Scalar>(&self, x: &[T], u: &[T], rate: &mut [T]);

    /// The rate of the coordinates ξ of  x = start ⊕ ξ,  the start fixed, when x moves at `rate`. The rate itself by default, which
    /// is right where ⊕ is the plain sum. Must not allocate.
    ///
    /// * `xi` – ξ, length `ndx`
    /// * `rate`, `out` – length `ndx`
    fn chart_rate<T: Scalar>(&self, _xi: &[T], rate: &[T], out: &mut [T]) {
        out.copy_from_slice(rate);
    }

    /// Working memory for rates and their Jacobians: by dual numbers through [`rate`](Self::rate) unless a system knows better.
    fn rates(&self) -> Box<dyn Rates<Self>> {
        Box::new(DualRates::new(self))
    }
}

/// Rates of a system with memory of their own, one for each thread.
pub trait Rates<D>: Send {
    /// ẋ = f(x, u), length `ndx`.
    fn rate(&mut self, dynamics: &D, x: &[f64], u: &[f64], rate: &mut [f64]);

    /// δf = A δx + B δu at (x, u), in the tangent space of x.
    ///
    /// * `out` – output, A `ndx` × `ndx` and B `ndx` × `nu`
    fn linearize(&mut self, dynamics: &D, x: &[f64], u: &[f64], out: &mut Linearization);
}

/// Jacobians by the rate on dual numbers.
struct DualRates {
    /// (δx, u) at δx = 0.
    z: Vec<f64>,
    start: Vec<Dual<f64, CHUNK>>,
    moved: Vec<Dual<f64, CHUNK>>,
    jacobian: JacobianScratch<CHUNK>,
    /// (A, B) side by side.
    out: DMatrix<f64>,
}

impl DualRates {
    fn new<D: Dynamics>(dynamics: &D) -> Self {
        let (nx, ndx, nu) = (dynamics.nx(), dynamics.ndx(), dynamics.nu());
        Self {
            z: vec![0.0; ndx + nu],
            start: vec![Dual::from(0.0); nx],
            moved: vec![Dual::from(0.0); nx],
            jacobian: JacobianScratch::new(ndx + nu, ndx),
            out: DMatrix::zeros(ndx, ndx + nu),
        }
    }
}

impl<D: ContinuousDynamics> Rates<D> for DualRates {
    fn rate(&mut self, dynamics: &D, x: &[f64], u: &[f64], rate: &mut [f64]) {
        dynamics.rate(x, u, rate);
    }

    fn linearize(&mut self, dynamics: &D, x: &[f64], u: &[f64], out: &mut Linearization) {
        let ndx = dynamics.ndx();
        lift_into(x, &mut self.start);
        self.z[ndx..].copy_from_slice(u);
        let (start, moved) = (&self.start, &mut self.moved);
        let rate = |z: &[Dual<f64, CHUNK>], rate: &mut [Dual<f64, CHUNK>]| {
            dynamics.integrate(start, &z[..ndx], moved);
            dynamics.rate(moved, &z[ndx..], rate);
        };
        jacobian_into(&self.z, rate, &mut self.jacobian, &mut self.out);
        out.a.copy_from(&self.out.columns(0, ndx));
        out.b.copy_from(&self.out.columns(ndx, u.len()));
    }
}

impl ContinuousDynamics for Simulator {
    fn rate<T: Scalar>(&self, x: &[T], u: &[T], rate: &mut [T]) {
        let (q, v) = x.split_at(self.model().nq());
        let mut scratch = StepScratch::new(self);
        // With a state of contact this is refused: bristles have no rate apart from a step.
        let a = self.acceleration_into(&State::new(q, v), u, &mut scratch);
        let (dq, dv) = rate.split_at_mut(v.len());
        dq.copy_from_slice(v);
        dv.copy_from_slice(a);
    }

    fn chart_rate<T: Scalar>(&self, xi: &[T], rate: &[T], out: &mut [T]) {
        let nv = self.model().nv();
        self.model()
            .tangent_rate_into(&xi[..nv], &rate[..nv], &mut out[..nv]);
        out[nv..].copy_from_slice(&rate[nv..]);
    }

    fn rates(&self) -> Box<dyn Rates<Self>> {
        Box::new(SimulatorRates {
            step: StepScratch::new(self),
            linearize: RateScratch::new(self),
            state: State::neutral(self.model()),
        })
    }
}

/// Accelerations of the simulator, their Jacobians along the tree.
struct SimulatorRates {
    step: StepScratch<f64>,
    linearize: RateScratch,
    state: State,
}

impl SimulatorRates {
    fn read(&mut self, x: &[f64]) {
        let (q, v) = x.split_at(self.state.q.len());
        self.state.q.copy_from_slice(q);
        self.state.v.copy_from_slice(v);
    }
}

impl Rates<Simulator> for SimulatorRates {
    fn rate(&mut self, simulator: &Simulator, x: &[f64], u: &[f64], rate: &mut [f64]) {
        self.read(x);
        let (dq, dv) = rate.split_at_mut(self.state.v.len());
        dq.copy_from_slice(self.state.v.as_slice());
        dv.copy_from_slice(simulator.acceleration_into(&self.state, u, &mut self.step));
    }

    fn linearize(&mut self, simulator: &Simulator, x: &[f64], u: &[f64], out: &mut Linearization) {
        self.read(x);
        simulator.linearize_rate_into(&self.state, u, &mut self.linearize, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;
    use crate::trajopt::Robot;
    use crate::trajopt::dynamics::zero_linearization;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    #[test]
    fn rates_of_the_simulator_equal_those_by_dual_numbers() {
        for seed in 0..5 {
            let simulator = Simulator::new(samples::random_tree(9, seed));
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let x = simulator.pack(&State::random(simulator.model(), &mut rng, 2.0));
            let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).sin()).collect();
            let mut expected = vec![0.0; simulator.ndx()];
            simulator.rate(x.as_slice(), &u, &mut expected);
            let mut rate = expected.clone();
            let both: [Box<dyn Rates<Simulator>>; 2] =
                [simulator.rates(), Box::new(DualRates::new(&simulator))];
            let [mut short, mut long] = both;
            short.rate(&simulator, x.as_slice(), &u, &mut rate);
            assert_eq!(rate, expected);
            let mut out = [(); 2].map(|()| zero_linearization(&simulator));
            short.linearize(&simulator, x.as_slice(), &u, &mut out[0]);
            long.linearize(&simulator, x.as_slice(), &u, &mut out[1]);
            for (short, long) in [(&out[0].a, &out[1].a), (&out[0].b, &out[1].b)] {
                let error = (short - long).amax() / long.amax();
                assert!(error < 1e-11, "seed {seed}: {error:e}");
            }
        }
    }

    // ξ(t) = x(t) ⊖ start along  x(t) = x ⊕ t ẋ.
    #[test]
    fn chart_rate_equals_the_rate_of_the_difference() {
        let simulator = Simulator::new(samples::random_tree(9, 3));
        let ndx = simulator.ndx();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let start = simulator.pack(&State::random(simulator.model(), &mut rng, 1.0));
        let xi: Vec<f64> = (0..ndx).map(|k| 0.02 * (k as f64).cos()).collect();
        let rate: Vec<f64> = (0..ndx).map(|k| (3.0 * k as f64).sin()).collect();
        let mut x = start.clone();
        simulator.integrate(start.as_slice(), &xi, x.as_mut_slice());
        let at = |t: f64| {
            let dx: Vec<f64> = rate.iter().map(|rate| t * rate).collect();
            let (mut moved, mut out) = (x.clone(), vec![0.0; ndx]);
            simulator.integrate(x.as_slice(), &dx, moved.as_mut_slice());
            simulator.difference(start.as_slice(), moved.as_slice(), &mut out);
            out
        };
        const STEP: f64 = 1e-4;
        let (before, after) = (at(-STEP), at(STEP));
        let mut out = vec![0.0; ndx];
        simulator.chart_rate(&xi, &rate, &mut out);
        for k in 0..ndx {
            let expected = (after[k] - before[k]) / (2.0 * STEP);
            // The series of the rate is exact up to ξ⁴.
            assert!(
                (out[k] - expected).abs() < 1e-7,
                "{k}: {} {expected}",
                out[k]
            );
        }
    }
}
