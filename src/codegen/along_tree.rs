//! Derivatives of the acceleration in a step along the tree, for robots whose forces follow from the state.
//!
//! With the joint forces τ, each of which depends on its own coordinate and input, and what they resist with at the end
//! of the step, R:  (M + R) δa = δτ − δR a − ∂ID  at the acceleration that has been found. ∂ID and M come from one pass
//! along the tree, instead of a pass for each direction: the implicit function theorem, as in
//! [`Simulator::linearize`](crate::Simulator::linearize).

use crate::autodiff::CHUNK;
use crate::dynamics::{AccelerationDerivatives, At, Calls, Entries};
use crate::scalar::{Dual, Over, Scalar, Traced};
use crate::sim::{AccelerationScratch, Integrator, Moment, Simulator, State};

/// A number of one coordinate with its derivatives in position, velocity and input.
pub(super) type OfCoordinate = Dual<Traced, 3>;

/// A number with its derivatives in some directions, to be recorded.
pub(super) type Number = Dual<Traced, CHUNK>;

/// The acceleration of a step, and −∂a in q (tangent), v and u.
pub(super) struct Acceleration {
    a: Vec<Traced>,
    derivatives: AccelerationDerivatives<Traced>,
}

impl Acceleration {
    /// Finds both; `None` where forces act on bodies, rows have forces, joints have stops, or there is more than one
    /// evaluation a step.
    pub(super) fn of<P: Scalar>(
        simulator: &Simulator<P>,
        state: &State<Traced>,
        u: &[Traced],
    ) -> Option<Self>
    where
        Traced: Over<P>,
        OfCoordinate: Over<P>,
    {
        let is_free = simulator.contacts().is_none()
            && simulator.constraints().is_empty()
            && simulator.frame_terms().is_empty();
        if !is_free || simulator.integrator() != Integrator::SemiImplicitEuler {
            return None;
        }
        let mut found = AccelerationScratch::new(simulator, Calls::One);
        simulator.accelerate(&Moment::of_step(simulator, state, u), &mut found);
        if !found.terms.stops.ends().is_empty() {
            return None;
        }
        let mut out = Self {
            a: found.a,
            derivatives: AccelerationDerivatives::new(
                simulator.model(),
                simulator.nu(),
                Calls::One,
            ),
        };
        out.differentiate(simulator, state, u);
        Some(out)
    }

    fn differentiate<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<Traced>,
        u: &[Traced],
    ) where
        Traced: Over<P>,
        OfCoordinate: Over<P>,
    {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let moved = State {
            q: state.q.map(|x| OfCoordinate::variable(x, 0)),
            v: state.v.map(|x| OfCoordinate::variable(x, 1)),
            contact: state.contact.map(OfCoordinate::constant_of),
        };
        let u: Vec<_> = u.iter().map(|&u| OfCoordinate::variable(u, 2)).collect();
        let at = Moment::of_step(simulator, &moved, &u);
        let mut scratch = AccelerationScratch::new(simulator, Calls::One);
        let (tau, resistance) = simulator.joint_forces(&at, &mut scratch);
        let mut net: Vec<OfCoordinate> = tau.to_vec();
        for ((net, &resistance), &a) in net.iter_mut().zip(resistance).zip(&self.a) {
            *net -= resistance * OfCoordinate::constant_of(a);
        }
        let columns = &mut self.derivatives.columns;
        for (k, net) in net.iter().enumerate() {
            columns.add(k, k, -net.eps[0], -net.eps[1]);
        }
        for (column, &row) in simulator.actuated().iter().enumerate() {
            *columns.at(row, 2 * nv + column) -= net[row].eps[2];
        }
        let at = At {
            q: state.q.as_slice(),
            v: state.v.as_slice(),
            a: &self.a,
        };
        self.derivatives.balance(model, &at, &[]);
        self.derivatives.solve(resistance.iter().map(|x| x.re));
    }

    /// a with its derivatives in the directions from `first` on, of state and input together.
    pub(super) fn along(&self, first: usize) -> Vec<Number> {
        let mut out: Vec<Number> = self.a.iter().map(|&a| Number::constant_of(a)).collect();
        for direction in 0..out.first().map_or(0, |a| a.eps.len()) {
            if first + direction >= self.derivatives.columns.columns() {
                break;
            }
            let column = self.derivatives.columns.column(first + direction);
            let entries = out.iter_mut().zip(column);
            entries.for_each(|(a, minus)| a.eps[direction] = -minus);
        }
        out
    }
}
