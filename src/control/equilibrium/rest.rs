//! Accelerations of a robot that shall rest, as residuals.

use nalgebra::{DMatrix, DVector};

use crate::contact::STANDARD_GRAVITY;
use crate::dynamics::mass_matrix;
use crate::least_squares::Residuals;
use crate::linearize::{Linearization, LinearizeScratch};
use crate::sim::{Simulator, State, StepScratch};

/// Weight of a displacement of 1 m or 1 rad beside an acceleration of g.
const PULL: f64 = 1e-3;
/// Lever arm, m: a torque of the robot's weight at it counts as much as a displacement of 1 rad.
const ARM: f64 = 0.1;

/// Residuals √Mᵢᵢ v̇ᵢ of a robot that shall rest, √m times the acceleration at which bristles slip, and, weakly, how far the variables (u, m, q) are
/// from those that a round began with: there are more variables than accelerations.
pub(super) struct Rest<'a> {
    simulator: &'a Simulator,
    /// √Mᵢᵢ of each coordinate, then √m of each number of contact.
    pub(super) scale: Vec<f64>,
    /// √m g: residuals are small beside it. Standard gravity, so that robots without gravity have a scale too.
    pub(super) weight: f64,
    /// Variables that a round began with.
    pub(super) from: Vec<f64>,
    /// Weights of the distance from there: of inputs, and of poses and bristles.
    pull: [f64; 2],
    pub(super) state: State,
    pub(super) input: DVector<f64>,
    next: State,
    step: StepScratch<f64>,
    linearize: LinearizeScratch,
    jacobian: Linearization,
}

impl<'a> Rest<'a> {
    pub(super) fn new(simulator: &'a Simulator, state: State, input: DVector<f64>) -> Self {
        let model = simulator.model();
        let inertia = mass_matrix(model, state.q.as_slice()).diagonal();
        let mass = model.total_mass();
        let bristles = std::iter::repeat_n(&mass, simulator.n_contact());
        Self {
            simulator,
            scale: inertia.iter().chain(bristles).map(|x| x.sqrt()).collect(),
            weight: mass.sqrt() * STANDARD_GRAVITY,
            from: input
                .iter()
                .chain(&state.contact)
                .chain(&state.q)
                .copied()
                .collect(),
            pull: [
                PULL / mass.sqrt() / ARM,
                PULL * mass.sqrt() * STANDARD_GRAVITY,
            ],
            input,
            next: state.clone(),
            state,
            step: StepScratch::new(simulator),
            linearize: LinearizeScratch::new(simulator),
            jacobian: Linearization::zeros(simulator),
        }
    }

    pub(super) fn move_to(&mut self, x: &[f64]) {
        let (u, rest) = x.split_at(self.input.len());
        let (m, q) = rest.split_at(self.state.contact.len());
        self.input.copy_from_slice(u);
        self.state.contact.copy_from_slice(m);
        self.state.q.copy_from_slice(q);
    }

    /// Number of inputs, numbers of contact, and directions of the pose.
    fn sizes(&self) -> [usize; 3] {
        let simulator = self.simulator;
        [
            simulator.nu(),
            simulator.n_contact(),
            simulator.model().nv(),
        ]
    }

    /// Weight of the distance along a direction.
    fn pull(&self, direction: usize) -> f64 {
        self.pull[usize::from(direction >= self.input.len())]
    }

    fn take_step(&mut self) {
        let (input, scratch) = (self.input.as_slice(), &mut self.step);
        self.simulator
            .step_into(&self.state, input, scratch, &mut self.next);
    }

    pub(super) fn acceleration(&mut self) -> f64 {
        self.take_step();
        self.next.v.amax() / self.simulator.time_step()
    }
}

impl Residuals for Rest<'_> {
    fn n_residuals(&self) -> usize {
        self.scale.len() + self.sizes().iter().sum::<usize>()
    }

    fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
        self.move_to(x);
        self.take_step();
        let dt = self.simulator.time_step();
        let bristles = self.next.contact.iter().zip(&self.state.contact);
        let slips = bristles.map(|(next, now)| (next - now) / (dt * dt));
        let accelerations = self.next.v.iter().map(|v| v / dt).chain(slips);
        let (out, way) = out.split_at_mut(self.scale.len());
        for ((out, a), scale) in out.iter_mut().zip(accelerations).zip(&self.scale) {
            *out = a * scale;
        }
        let (model, plain) = (self.simulator.model(), x.len() - self.state.q.len());
        for (k, way) in way[..plain].iter_mut().enumerate() {
            *way = x[k] - self.from[k];
        }
        model.difference_into(&self.from[plain..], &x[plain..], &mut way[plain..]);
        for (k, way) in way.iter_mut().enumerate() {
            *way *= self.pull(k);
        }
    }

    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) {
        self.move_to(x);
        let (simulator, input) = (self.simulator, self.input.as_slice());
        simulator.linearize_into(&self.state, input, &mut self.linearize, &mut self.jacobian);
        let ([nu, nm, nv], dt) = (self.sizes(), simulator.time_step());
        let Linearization { a, b } = &self.jacobian;
        for (row, scale) in self.scale.iter().enumerate() {
            let factor = if row < nv {
                scale / dt
            } else {
                scale / (dt * dt)
            };
            let mut put = |column, slope: f64| out[(row, column)] = factor * slope;
            (0..nu).for_each(|k| put(k, b[(nv + row, k)]));
            for k in 0..nm {
                let own = if row == nv + k { 1.0 } else { 0.0 };
                put(nu + k, a[(nv + row, 2 * nv + k)] - own);
            }
            (0..nv).for_each(|k| put(nu + nm + k, a[(nv + row, k)]));
        }
        // That of a turn only next to where it began, which is where the rounds end.
        let mut way = out.rows_mut(self.scale.len(), nu + nm + nv);
        way.fill(0.0);
        (0..way.nrows()).for_each(|k| way[(k, k)] = self.pull(k));
    }

    fn n_directions(&self, x: &[f64]) -> usize {
        let model = self.simulator.model();
        x.len() - model.nq() + model.nv()
    }

    fn retract(&self, x: &[f64], d: &[f64], out: &mut [f64]) {
        let model = self.simulator.model();
        let plain = x.len() - model.nq();
        for k in 0..plain {
            out[k] = x[k] + d[k];
        }
        model.integrate_into(&x[plain..], &d[plain..], &mut out[plain..]);
    }
}
