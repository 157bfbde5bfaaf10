//! Robots as systems: x = (q, v).

use nalgebra::DVector;

use super::scratch::Scratch;
use super::system::AnySystem;
use super::system::System;
use crate::linearize::{Linearization, LinearizeScratch, RateScratch, StepGradient, VjpScratch};
use crate::model::Model;
use crate::scalar::Scalar;
use crate::sim::{Simulator, State, StepScratch};

/// A system whose state is that of a robot, x = (q, v, m) with the contact state m. Residuals of robots need it.
///
/// To wrap a [`Simulator`] (another actuation, a delay) and use these residuals, implement this trait and [`System::robot`];
/// [`forward_system!`](crate::forward_system) forwards the unchanged functions.
pub trait Robot: System {
    /// The robot.
    ///
    /// # Panics
    /// If [`System::robot`] does not say which one it is.
    fn model(&self) -> &Model {
        self.robot().expect(NO_ROBOT)
    }

    /// x = (q, v, m, w) of a state, with the state of contact m and activations w. Nothing sleeps in it. Allocates.
    fn pack(&self, state: &State) -> DVector<f64> {
        let n = state.len() - state.sleep.len();
        DVector::from_iterator(n, state.q.iter().chain(state.beside_q()).copied())
    }

    /// The state of x. Allocates.
    ///
    /// # Panics
    /// If `x` does not have length `nx`.
    fn unpack(&self, x: &[f64]) -> State {
        assert_eq!(x.len(), self.nx(), "x is (q, v, m, w)");
        let model = self.model();
        let (q, rest) = x.split_at(model.nq());
        let (v, contact) = rest.split_at(model.nv());
        State::new(q, v).with_contact(DVector::from_column_slice(contact))
    }
}

/// Message for a system without a model if its model is requested.
pub(super) const NO_ROBOT: &str =
    "only robots have a model: `System::robot` says which one a system is";

impl Robot for Simulator {
    fn unpack(&self, x: &[f64]) -> State {
        let mut out: State = awake_state(self);
        out.copy_from_slice(x);
        out
    }
}

impl System for Simulator {
    fn nx(&self) -> usize {
        self.model().nq() + self.model().nv() + self.n_contact() + self.n_activation()
    }

    fn ndx(&self) -> usize {
        self.n_tangent()
    }

    fn ndq(&self) -> usize {
        self.model().nv()
    }

    fn nu(&self) -> usize {
        Self::nu(self)
    }

    fn time_step(&self) -> f64 {
        Self::time_step(self)
    }

    fn robot(&self) -> Option<&Model> {
        Some(self.model())
    }

    fn step<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, next: &mut [T]) {
        let memory = scratch.get(|| StepMemory::new(self));
        memory.state.copy_from_slice(x);
        self.step_into(&memory.state, u, &mut memory.step, &mut memory.next);
        memory.next.copy_to_slice(next);
    }

    fn integrate<T: Scalar>(&self, x: &[T], dx: &[T], out: &mut [T]) {
        let (nq, nv) = (self.model().nq(), self.model().nv());
        self.model()
            .integrate_into(&x[..nq], &dx[..nv], &mut out[..nq]);
        for ((out, &x), &dx) in out[nq..].iter_mut().zip(&x[nq..]).zip(&dx[nv..]) {
            *out = x + dx;
        }
    }

    fn difference<T: Scalar>(&self, x0: &[T], x1: &[T], dx: &mut [T]) {
        let (nq, nv) = (self.model().nq(), self.model().nv());
        self.model()
            .difference_into(&x0[..nq], &x1[..nq], &mut dx[..nv]);
        for ((dx, &x0), &x1) in dx[nv..].iter_mut().zip(&x0[nq..]).zip(&x1[nq..]) {
            *dx = x1 - x0;
        }
    }

    fn is_vector_space(&self) -> bool {
        let mut joints = self.model().independent().map(|body| body.joint);
        joints.all(|joint| joint.nv() <= 1)
    }

    fn rate<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, rate: &mut [T]) {
        let memory = scratch.get(|| RateMemory::new(self));
        memory.state.q.copy_from_slice(&x[..self.model().nq()]);
        memory.state.v.copy_from_slice(&x[self.model().nq()..]);
        // With a contact state, or activations, this is refused: they have no rate apart from a step.
        let a = self.acceleration_into(&memory.state, u, &mut memory.step);
        let (dq, dv) = rate.split_at_mut(self.model().nv());
        dq.copy_from_slice(memory.state.v.as_slice());
        dv.copy_from_slice(a);
    }

    fn chart_rate<T: Scalar>(&self, xi: &[T], rate: &[T], out: &mut [T]) {
        let nv = self.model().nv();
        self.model()
            .tangent_rate_into(&xi[..nv], &rate[..nv], &mut out[..nv]);
        out[nv..].copy_from_slice(&rate[nv..]);
    }

    /// Linearises along the tree.
    fn linearize(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        let memory = scratch.get(|| LinearizeMemory::new(self));
        memory.state.copy_from_slice(x);
        self.linearize_into(&memory.state, u, &mut memory.linearize, out);
    }

    /// One sweep backwards along the tree.
    fn vjp(
        &self,
        x: &[f64],
        u: &[f64],
        lambda: &[f64],
        scratch: &mut Scratch,
        dx: &mut [f64],
        du: &mut [f64],
    ) {
        let memory = scratch.get(|| VjpMemory::new(self));
        memory.state.copy_from_slice(x);
        let (vjp, out) = (&mut memory.vjp, &mut memory.out);
        self.vjp_into(&memory.state, u, lambda, vjp, out);
        dx.copy_from_slice(out.state.as_slice());
        du.copy_from_slice(out.input.as_slice());
    }

    /// Forward over adjoint, a product for each number: n steps and their adjoints instead of n² steps over hyper-dual numbers.
    #[cfg(feature = "second-order")]
    fn add_step_hessian(&self, x: &[f64], u: &[f64], lambda: &[f64], hessian: &mut [f64]) {
        let own = self.step_hessian(&self.unpack(x), u, lambda);
        let n = own.nrows();
        for (i, column) in own.column_iter().enumerate() {
            let upper = hessian[i * n..].iter_mut().zip(&column).take(i + 1);
            upper.for_each(|(out, x)| *out += x);
        }
    }

    /// Linearises the rate along the tree.
    fn linearize_rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        let (q, v) = x.split_at(self.model().nq());
        let memory = scratch.get(|| LinearizeRateMemory {
            linearize: RateScratch::new(self),
            state: State::neutral(self.model()),
        });
        memory.state.q.copy_from_slice(q);
        memory.state.v.copy_from_slice(v);
        self.linearize_rate_into(&memory.state, u, &mut memory.linearize, out);
    }

    fn prepare(&self, scratch: &mut Scratch) {
        scratch.get(|| StepMemory::<f64>::new(self));
        scratch.get(|| LinearizeMemory::new(self));
    }

    // Inlined elsewhere, it would bring along all that its table of functions points to.
    #[inline(never)]
    fn face(&self) -> &dyn AnySystem {
        self
    }

    #[inline(never)]
    fn boxed(self) -> Box<dyn AnySystem> {
        Box::new(self)
    }
}

/// Memory for steps.
struct StepMemory<T: Scalar> {
    step: StepScratch<T>,
    state: State<T>,
    next: State<T>,
}

impl<T: Scalar> StepMemory<T> {
    fn new(simulator: &Simulator) -> Self {
        Self {
            step: StepScratch::awake(simulator),
            state: awake_state(simulator),
            next: awake_state(simulator),
        }
    }
}

/// A state without numbers of what sleeps.
fn awake_state<T: Scalar>(simulator: &Simulator) -> State<T> {
    State {
        sleep: DVector::zeros(0),
        ..simulator.neutral_state()
    }
}

/// Memory for accelerations.
struct RateMemory<T: Scalar> {
    step: StepScratch<T>,
    state: State<T>,
}

impl<T: Scalar> RateMemory<T> {
    fn new(simulator: &Simulator) -> Self {
        Self {
            step: StepScratch::awake(simulator),
            state: State::neutral(simulator.model()),
        }
    }
}

/// Memory for step Jacobians.
struct LinearizeMemory {
    linearize: LinearizeScratch,
    state: State,
}

impl LinearizeMemory {
    fn new(simulator: &Simulator) -> Self {
        Self {
            linearize: LinearizeScratch::new(simulator),
            state: awake_state(simulator),
        }
    }
}

/// Memory for gradients of steps.
struct VjpMemory {
    vjp: VjpScratch,
    out: StepGradient,
    state: State,
}

impl VjpMemory {
    fn new(simulator: &Simulator) -> Self {
        Self {
            vjp: VjpScratch::new(simulator),
            out: StepGradient::zeros(simulator).without_parameters(),
            state: awake_state(simulator),
        }
    }
}

/// Memory for Jacobians of accelerations.
struct LinearizeRateMemory {
    linearize: RateScratch,
    state: State,
}

#[cfg(test)]
#[cfg_attr(
    not(feature = "second-order"),
    allow(unused_imports, reason = "for tests of second derivatives")
)]
mod tests {
    use super::*;
    use crate::Integrator;
    use crate::model::samples;
    use crate::trajopt::system::tangent;
    use crate::trajopt::system::zero_linearization;
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    #[test]
    fn rates_of_the_simulator_equal_those_by_dual_numbers() {
        for seed in 0..5 {
            let simulator = Simulator::new(samples::random_tree(9, seed));
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let x = simulator.pack(&State::random(simulator.model(), &mut rng, 2.0));
            let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).sin()).collect();
            let (x, mut scratch) = (x.as_slice(), Scratch::new());
            let mut out = [(); 2].map(|()| zero_linearization(&simulator));
            System::linearize_rate(&simulator, x, &u, &mut scratch, &mut out[0]);
            tangent::linearize_rate(&simulator, x, &u, &mut scratch, &mut out[1]);
            for (short, long) in [(&out[0].a, &out[1].a), (&out[0].b, &out[1].b)] {
                let error = (short - long).amax() / long.amax();
                assert!(error < 1e-11, "seed {seed}: {error:e}");
            }
        }
    }

    #[cfg(feature = "second-order")]
    /// g(δ) = λᵀ (f(x ⊕ δx, u + δu) ⊖ f(x, u)).
    fn weighted(simulator: &Simulator, [x, u, lambda]: [&[f64]; 3], delta: &[f64]) -> f64 {
        let (ndx, mut scratch) = (simulator.ndx(), Scratch::new());
        let (mut base, mut moved, mut next) = (x.to_vec(), x.to_vec(), x.to_vec());
        System::step(simulator, x, u, &mut scratch, &mut base);
        System::integrate(simulator, x, &delta[..ndx], &mut moved);
        let u: Vec<f64> = u.iter().zip(&delta[ndx..]).map(|(u, d)| u + d).collect();
        System::step(simulator, &moved, &u, &mut scratch, &mut next);
        let mut way = vec![0.0; ndx];
        System::difference(simulator, &base, &next, &mut way);
        way.iter().zip(lambda).map(|(way, l)| way * l).sum()
    }

    #[cfg(feature = "second-order")]
    /// The Hessian of g by central differences.
    fn by_differences(simulator: &Simulator, at: [&[f64]; 3], n: usize) -> DMatrix<f64> {
        const STEP: f64 = 3e-4;
        DMatrix::from_fn(n, n, |i, j| {
            let corner = |a: f64, b: f64| {
                let mut delta = vec![0.0; n];
                delta[i] += a * STEP;
                delta[j] += b * STEP;
                a * b * weighted(simulator, at, &delta)
            };
            let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
            corners.map(|(a, b)| corner(a, b)).iter().sum::<f64>() / (4.0 * STEP * STEP)
        })
    }

    #[cfg(feature = "second-order")]
    #[test]
    fn hessians_of_a_weighted_step_equal_differences() {
        let integrators = [
            Integrator::SemiImplicitEuler,
            Integrator::ImplicitVelocity,
            Integrator::RungeKutta4,
        ];
        for (seed, integrator) in (0..6).zip(integrators.into_iter().cycle()) {
            let simulator = Simulator::new(samples::random_tree(5, seed))
                .with_integrator(integrator)
                .with_time_step(0.02);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let x = simulator.pack(&State::random(simulator.model(), &mut rng, 1.0));
            let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).sin()).collect();
            let lambda: Vec<f64> = (0..simulator.ndx()).map(|k| (k as f64).cos()).collect();
            let (x, n) = (x.as_slice(), simulator.ndx() + u.len());
            let mut hessian = vec![1.0; n * n];
            System::add_step_hessian(&simulator, x, &u, &lambda, &mut hessian);
            let expected = by_differences(&simulator, [x, &u, &lambda], n);
            let found = DMatrix::from_vec(n, n, hessian);
            for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
                // Only the upper triangle is added to.
                let wanted = 1.0 + if i <= j { expected[(i, j)] } else { 0.0 };
                let error = (found[(i, j)] - wanted).abs() / expected.amax();
                assert!(error < 1e-5, "{seed}, entry ({i}, {j}): {error:e}");
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
