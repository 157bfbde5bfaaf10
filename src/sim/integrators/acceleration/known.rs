//! An acceleration with its derivatives over dual numbers, where its Jacobian is known. Sensors read the forces of a step there, which no solver has to find
//! again.

use std::ops::Range;

use nalgebra::DMatrix;

use super::{AccelerationColumns, AccelerationScratch};
use crate::dynamics::{Blocks, Calls};
use crate::scalar::{Differentiable, Dual, Opaque, Over, Scalar, compiled_over_f64, from_each};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// The acceleration of a step and the forces of its rows, with the Jacobians of both: columns (q, v, contact state, signals of the motors).
#[derive(Clone, Debug)]
pub(crate) struct KnownAcceleration<T: Scalar> {
    found: Opaque<AccelerationScratch<T>>,
    a: DMatrix<T>,
    forces: DMatrix<T>,
}

impl<T: Differentiable> KnownAcceleration<T> {
    /// Finds them.
    ///
    /// * `signal` – what the motors get
    pub(crate) fn new(simulator: &Simulator, state: &State<T>, signal: &[T]) -> Self {
        compiled_over_f64!(
            [f64, T] find, simulator: &Simulator, state: &State, signal: &[f64] => KnownAcceleration<f64> as KnownAcceleration<T>
        )
    }

    /// Leaves acceleration and motions as if they had been found at a point over dual numbers, and, if they are read, the forces of all terms.
    ///
    /// * `directions` – those of the dual numbers, of the tangent of the state and of the input
    pub(crate) fn write<const N: usize>(
        &self,
        at: &EvaluationPoint<'_, f64, Dual<T, N>>,
        directions: &Range<usize>,
        reads_forces: bool,
        out: &mut AccelerationScratch<Dual<T, N>>,
    ) where
        Dual<T, N>: Over<f64>,
    {
        if reads_forces {
            at.simulator.apply_terms(at, out);
        }
        let (found, along) = (self.found.get(), Along::new(at, directions));
        let a = found.a.iter().enumerate();
        out.a.clear();
        out.a.extend(a.map(|(k, &a)| along.number(&self.a, (k, a))));
        let balance = out.balance.as_deref_mut();
        if let Some(balance) = balance.filter(|_| at.may_have_rows()) {
            balance.place(at);
        }
        if !reads_forces {
            return;
        }
        let forces = match found.balance.as_deref() {
            Some(own) => own.rows().forces(),
            None => &[],
        };
        let forces = forces.iter().take(self.forces.nrows()).enumerate();
        let forces = forces.map(|(row, &f)| along.number(&self.forces, (row, f)));
        out.follow(at, found, forces);
    }
}

/// Directions of dual numbers at a point.
struct Along<'a, T: Scalar, const N: usize> {
    directions: &'a Range<usize>,
    n_motion: usize,
    /// The signals of motors that change along them.
    signals: Vec<(usize, &'a [T; N])>,
}

impl<'a, T: Differentiable, const N: usize> Along<'a, T, N>
where
    Dual<T, N>: Over<f64>,
{
    fn new(at: &EvaluationPoint<'a, f64, Dual<T, N>>, directions: &'a Range<usize>) -> Self {
        let signals = at.u.iter().map(|signal| &signal.eps).enumerate();
        let changing = signals.filter(|(_, eps)| eps.iter().any(|slope| !slope.is_zero()));
        Self {
            directions,
            n_motion: at.simulator.n_motion(),
            signals: changing.collect(),
        }
    }

    /// A number that was found, with its slopes.
    ///
    /// * `jacobian` – in motions and signals of the motors
    /// * `found` – row of the Jacobian, and value
    fn number(&self, jacobian: &DMatrix<T>, (row, value): (usize, T)) -> Dual<T, N> {
        let slope = |lane: usize| {
            let own = self.directions.start + lane;
            let is_motion = own < self.n_motion && self.directions.contains(&own);
            let first = if is_motion {
                jacobian[(row, own)]
            } else {
                T::zero()
            };
            let signals = self.signals.iter();
            signals.fold(first, |sum, (j, eps)| {
                sum + jacobian[(row, self.n_motion + j)] * eps[lane]
            })
        };
        Dual::new(value, from_each(slope))
    }
}

fn find<T: Differentiable>(
    simulator: &Simulator,
    state: &State<T>,
    signal: &[T],
) -> KnownAcceleration<T> {
    let mut found = AccelerationScratch::new(simulator, Calls::One);
    let mut columns = AccelerationColumns::new(simulator, Calls::One);
    let at = EvaluationPoint::of_step(simulator, state, signal);
    simulator.accelerate(&at, &mut found);
    let rows = match found.has_rows(&at) {
        true => found.balance.as_deref().map_or(0, |own| own.rows().count()),
        false => 0,
    };
    columns.linearize(&at, &mut found);
    let width = simulator.n_motion() + simulator.nu();
    let minus_a = matrix(columns.minus_a(), simulator.model().nv(), width);
    KnownAcceleration {
        a: -minus_a,
        forces: matrix(columns.row_forces(), rows, width),
        found: Opaque::new(found),
    }
}

/// The first columns of blocks.
fn matrix<T: Scalar>(blocks: &Blocks<T>, rows: usize, columns: usize) -> DMatrix<T> {
    let mut out = DMatrix::zeros(rows, columns);
    let all = out.as_mut_slice().chunks_exact_mut(rows.max(1));
    blocks.copy_columns_to(all, |x| x);
    out
}

impl<T: Scalar> AccelerationScratch<T> {
    /// Takes over the forces of rows that were found over other numbers, with their values over these, where acceleration and motions are there.
    fn follow<S: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &AccelerationScratch<S>,
        forces: impl Iterator<Item = T>,
    ) where
        T: Over<f64>,
    {
        self.are_apart = found.are_apart;
        let own = self.balance.as_deref_mut().filter(|_| at.may_have_rows());
        let Some(balance) = own else { return };
        self.terms.contact.find_candidates(at, balance);
        if self.are_apart {
            return self.rest(at);
        }
        balance.rows.set_forces(forces);
        self.terms.frame_servos.follow(&found.terms.frame_servos);
        if let Some(contacts) = at.solved_contacts() {
            let contact = &mut self.terms.contact;
            contact.follow(&found.terms.contact, contacts, balance);
        }
    }
}
