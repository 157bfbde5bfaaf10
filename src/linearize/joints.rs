//! Contribution of single joints to the Jacobians of a step: their forces, the implicit parts of these, and their stops.

use super::rows::RowColumns;
use crate::autodiff::Dual;
use crate::dynamics::{Blocks, Entries};
use crate::sim::{ConstrainedScratch, Simulator, State, Stop};

/// All positions, all velocities, all inputs. Each acts on its own coordinate only, so one evaluation gives all derivatives.
type Local = Dual<f64, 3>;

/// The coordinates of joints, and their forces.
#[derive(Clone, Debug)]
pub(super) struct JointColumns {
    q: Vec<Local>,
    v: Vec<Local>,
    u: Vec<Local>,
    tau: Vec<Local>,
    /// Δt c + Δt² k of dampers and springs, and of stops that no solver looks at, whose forces are those of the end of the step; zeros where
    /// none are.
    pub(super) resistance: Vec<Local>,
}

impl JointColumns {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, zeros) = (simulator.model(), |n: usize| vec![Dual::from(0.0); n]);
        Self {
            q: zeros(model.nq()),
            v: zeros(model.nv()),
            u: zeros(simulator.nu()),
            tau: zeros(model.nv()),
            resistance: zeros(model.nv()),
        }
    }

    /// Starts the columns with −∂τ/∂x and −∂τ/∂u. In a step whose forces of joints are those of its end, they depend on its acceleration and
    /// on the stops that push.
    pub(super) fn start(
        &mut self,
        simulator: &Simulator,
        (state, u): (&State, &[f64]),
        over_step: Option<(&[f64], &[Stop<f64>])>,
        columns: &mut Blocks,
    ) {
        let seed = |out: &mut [Local], x: &[f64], direction: usize| {
            let moved = out.iter_mut().zip(x);
            moved.for_each(|(out, &x)| *out = Dual::variable(x, direction));
        };
        seed(&mut self.q, state.q.as_slice(), 0);
        seed(&mut self.v, state.v.as_slice(), 1);
        seed(&mut self.u, u, 2);
        let (q, v, u, tau) = (&self.q, &self.v, &self.u, &mut self.tau);
        columns.clear();
        match over_step {
            None => simulator.joint_forces_into(q, v, u, tau),
            Some((a, stops)) => {
                simulator.driving_forces_into(q, v, u, tau);
                self.resist(simulator, a);
                self.push(simulator, a, stops);
            }
        }
        for (k, tau) in self.tau.iter().enumerate() {
            columns.add(k, k, -tau.eps[0], -tau.eps[1]);
        }
        for (column, &row) in simulator.actuated().iter().enumerate() {
            *columns.at(row, simulator.n_tangent() + column) = -self.tau[row].eps[2];
        }
    }

    /// Dampers C and springs K that are implicit in the step:  (M + Δt C + Δt² K) a = τ − h − Δt K v.
    fn resist(&mut self, simulator: &Simulator, a: &[f64]) {
        let (v, tau, resistance) = (&self.v, &mut self.tau, &mut self.resistance);
        let dt = simulator.time_step();
        simulator.each_resistance(v, |k, damping, stiffness: Local| {
            let spring = stiffness * dt;
            resistance[k] = (damping + spring) * dt;
            tau[k] -= resistance[k] * a[k] + spring * v[k];
        });
    }

    /// Stops that push:  f = push − Δt r · (acceleration inward).
    fn push(&mut self, simulator: &Simulator, a: &[f64], stops: &[Stop<f64>]) {
        let (v, tau, resistance) = (&self.v, &mut self.tau, &mut self.resistance);
        let dt = simulator.time_step();
        let mut stops = stops.iter();
        simulator.each_end(&self.q, |k, end| {
            if stops.next().is_some_and(Stop::is_pushing) {
                let force = end.stop.step_force(end.depth, v[k] * end.inward, dt);
                let own = force.resistance * dt;
                tau[k] += force.push * end.inward - own * a[k];
                resistance[k] += own;
            }
        });
    }

    /// ∂y of the rows of stops, from the row `first` on.
    pub(super) fn stop(
        &self,
        simulator: &Simulator,
        (constrained, first): (&ConstrainedScratch<f64>, usize),
        rows: &mut RowColumns,
    ) {
        let (nv, dt) = (self.v.len(), simulator.time_step());
        let mut stops = (first..).zip(constrained.stops()).peekable();
        simulator.each_end(&self.q, |k, end| {
            let takes_part = stops.next_if(|(_, stop)| **stop == (k, end.inward));
            let Some((row, _)) = takes_part else { return };
            let own = end.stop.row(end.depth, self.v[k] * end.inward, dt);
            if own.compliance.re < f64::INFINITY {
                let y = own.compliance * constrained.rows().forces()[row] - own.reference;
                *rows.columns.at(row, k) += y.eps[0];
                *rows.columns.at(row, nv + k) += y.eps[1];
            }
        });
    }
}
