//! Accelerations as residuals of an equilibrium.

use nalgebra::{DMatrix, DVector};

use super::stance::near_the_ground;
use crate::contact::STANDARD_GRAVITY;
use crate::dynamics::mass_matrix;
use crate::least_squares::Residuals;
use crate::linearize::{Linearization, LinearizeScratch};
use crate::nested::IntoNested;
use crate::sim::{Simulator, State, StepScratch};

/// Weight of a displacement of 1 m or 1 rad beside an acceleration of g.
const PULL: f64 = 1e-3;
/// Lever arm, m: a torque of the robot's weight at it counts as much as a displacement of 1 rad.
const ARM: f64 = 0.1;

/// Residuals √Mᵢᵢ v̇ᵢ of a robot that shall rest, √m times the acceleration at which bristles slip, and, weakly, how far the variables (u, m, q) are
/// from those that a round began with: there are more variables than accelerations.
pub(super) struct Rest<'a> {
    simulator: &'a Simulator,
    /// Numbers of contact that are variables: bristles of points near the ground. The others are straight, and stay so.
    bristles: Vec<usize>,
    /// √Mᵢᵢ of each coordinate, then √m of each of these numbers.
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
    pub(super) fn new(simulator: &'a Simulator, mut state: State, input: DVector<f64>) -> Self {
        let model = simulator.model();
        let inertia = mass_matrix(model, state.q.as_slice()).diagonal();
        let mass = model.total_mass();
        let bristles = bristles_near_the_ground(simulator, &state);
        let bent = bristles.iter().map(|&k| state.contact[k]);
        let from = input
            .iter()
            .copied()
            .chain(bent)
            .chain(state.q.iter().copied());
        let from = from.collect();
        state.contact.fill(0.0);
        let masses = std::iter::repeat_n(&mass, bristles.len());
        Self {
            simulator,
            scale: inertia.iter().chain(masses).map(|x| x.sqrt()).collect(),
            weight: mass.sqrt() * STANDARD_GRAVITY,
            from,
            bristles,
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
        let (m, q) = rest.split_at(self.bristles.len());
        self.input.copy_from_slice(u);
        for (&k, m) in self.bristles.iter().zip(m) {
            self.state.contact[k] = *m;
        }
        self.state.q.copy_from_slice(q);
    }

    /// Number of inputs, of bristles' numbers, and of directions of the pose.
    fn sizes(&self) -> [usize; 3] {
        let nv = self.simulator.model().nv();
        [self.input.len(), self.bristles.len(), nv]
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
        let (next, now) = (&self.next.contact, &self.state.contact);
        let slips = self
            .bristles
            .iter()
            .map(|&k| (next[k] - now[k]) / (dt * dt));
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
            let bristle = row.checked_sub(nv).map(|k| 2 * nv + self.bristles[k]);
            let (from, factor) = match bristle {
                Some(from) => (from, scale / (dt * dt)),
                None => (nv + row, scale / dt),
            };
            let mut put = |column, slope: f64| out[(row, column)] = factor * slope;
            (0..nu).for_each(|k| put(k, b[(from, k)]));
            for (k, column) in self.bristles.iter().map(|k| 2 * nv + k).enumerate() {
                let own = if from == column { 1.0 } else { 0.0 };
                put(nu + k, a[(from, column)] - own);
            }
            (0..nv).for_each(|k| put(nu + nm + k, a[(from, k)]));
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

/// The numbers of contact of points near the ground; none without bristles.
fn bristles_near_the_ground(simulator: &Simulator, state: &State) -> Vec<usize> {
    let contacts = simulator.contacts().filter(|_| simulator.n_contact() > 0);
    let near = contacts.map(|contacts| near_the_ground(simulator.model(), contacts, state));
    let near = near.unwrap_or_default().into_iter();
    near.nested(|point| 3 * point..3 * point + 3).collect()
}
