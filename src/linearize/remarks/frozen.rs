//! A robot frozen in a state: its Jacobians and their modes.

use nalgebra::{Complex, DMatrix, DVector};

use crate::dynamics::mass_matrix;
use crate::sim::{Integrator, Simulator, State, linear_factor};

/// Iterations that find the motion of a known eigenvalue; the second one changes nothing but roundings.
const ITERATIONS: usize = 3;
/// Relative distance from the eigenvalue at which a motion is sought, so that the equations have a solution.
const OFF: f64 = 1e-6;

/// A robot in a state, without input.
#[derive(Clone)]
pub(super) struct Frozen {
    pub(super) simulator: Simulator,
    state: State,
    u: Vec<f64>,
}

/// Positions in a motion at two of its phases.
pub(super) type Shape = [DVector<f64>; 2];

/// Jacobians with velocities in rad or m per step, so that they have entries of one size.
fn scaled(mut a: DMatrix<f64>, dt: f64) -> DMatrix<f64> {
    let nv = a.nrows() / 2;
    let mut upper = a.view_mut((0, nv), (nv, nv));
    upper /= dt;
    let mut lower = a.view_mut((nv, 0), (nv, nv));
    lower *= dt;
    a
}

impl Frozen {
    /// * `simulator` – without contacts
    pub(super) fn new(simulator: Simulator, q: &[f64], v: &[f64]) -> Self {
        // Activations are left out, as inputs do not decide how a robot at rest moves.
        let simulator = simulator.without_activations();
        Self {
            state: simulator.state(q, v),
            u: vec![0.0; simulator.nu()],
            simulator,
        }
    }

    pub(super) fn with(&self, change: impl FnOnce(Simulator) -> Simulator) -> Self {
        let Self {
            simulator,
            state,
            u,
        } = self.clone();
        Self {
            simulator: change(simulator),
            state,
            u,
        }
    }

    pub(super) fn dt(&self) -> f64 {
        self.simulator.time_step()
    }

    /// Jacobian of the rate, per step.
    pub(super) fn rate(&self) -> DMatrix<f64> {
        let a = self.simulator.linearize_rate(&self.state, &self.u).a;
        scaled(a, self.dt()) * self.dt()
    }

    /// Jacobian of a step of a small motion. For a falling robot, stages of the Runge–Kutta method contain its displacement within the step, so their
    /// Jacobian is that of the method applied to the rate at its start.
    pub(super) fn step(&self) -> DMatrix<f64> {
        if self.simulator.integrator() == Integrator::RungeKutta4 {
            let rate = self.rate();
            let identity = DMatrix::identity(rate.nrows(), rate.nrows());
            return linear_factor(&rate, &identity);
        }
        let a = self.simulator.linearize(&self.state, &self.u).a;
        scaled(a, self.dt())
    }

    pub(super) fn mass(&self) -> DMatrix<f64> {
        mass_matrix(self.simulator.model(), self.state.q.as_slice())
    }

    /// Name of the coordinate with the largest part of the kinetic energy.
    pub(super) fn name(&self, shape: &Shape) -> String {
        let mass = self.mass().diagonal();
        let energy = |k: usize| mass[k] * (shape[0][k].powi(2) + shape[1][k].powi(2));
        let most = (0..mass.len()).max_by(|&a, &b| energy(a).total_cmp(&energy(b)));
        most.map_or_else(String::new, |k| self.simulator.tangent_name(k))
    }
}

/// The motion of an eigenvalue of a Jacobian: a plane that A maps into itself, by inverse iteration with the real (A − λ) (A − λ̄).
pub(super) fn shape(a: &DMatrix<f64>, eigenvalue: Complex<f64>) -> Option<Shape> {
    let (n, near) = (a.nrows(), eigenvalue * (1.0 + OFF));
    let product = a * a - a * (2.0 * near.re) + DMatrix::identity(n, n) * near.norm_sqr();
    let factors = product.lu();
    let mut x = DVector::from_fn(n, |i, _| 1.0 / (1.0 + i as f64));
    for _ in 0..ITERATIONS {
        x = factors.solve(&x)?.normalize();
    }
    let y = a * &x;
    let is_finite = x.iter().all(|x| x.is_finite());
    is_finite.then(|| [x, y].map(|x| x.rows(0, n / 2).into_owned()))
}
