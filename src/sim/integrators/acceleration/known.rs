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

    /// Leaves acceleration, forces of terms and motions as if they had been found at a point over dual numbers.
    ///
    /// * `directions` – those of the dual numbers, of the tangent of the state and of the input
    pub(crate) fn write<const N: usize>(
        &self,
        at: &EvaluationPoint<'_, f64, Dual<T, N>>,
        directions: &Range<usize>,
        out: &mut AccelerationScratch<Dual<T, N>>,
    ) where
        Dual<T, N>: Over<f64>,
    {
        let n_motion = at.simulator.n_motion();
        let along = |jacobian: &DMatrix<T>, row: usize, value: T| {
            let slope = |lane: usize| {
                let own = directions.start + lane;
                let has_own = own < n_motion && directions.contains(&own);
                let first = if has_own {
                    jacobian[(row, own)]
                } else {
                    T::zero()
                };
                let signals = at.u.iter().enumerate();
                signals.fold(first, |sum, (j, signal)| {
                    sum + jacobian[(row, n_motion + j)] * signal.eps[lane]
                })
            };
            Dual::new(value, from_each(slope))
        };
        let found = self.found.get();
        let a = found.a.iter().enumerate();
        let a = a.map(|(k, &a)| along(&self.a, k, a));
        let forces = found
            .balance
            .as_deref()
            .map_or(&[][..], |own| own.rows().forces());
        let rows = self.forces.nrows();
        let forces = forces.iter().take(rows).enumerate();
        let forces = forces.map(|(row, &f)| along(&self.forces, row, f));
        out.follow(at, found, a, forces);
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
    /// Takes over an acceleration that was found over other numbers, with its value and the forces of its rows over these.
    fn follow<S: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &AccelerationScratch<S>,
        a: impl Iterator<Item = T>,
        forces: impl Iterator<Item = T>,
    ) where
        T: Over<f64>,
    {
        at.simulator.apply_terms(at, self);
        self.a.clear();
        self.a.extend(a);
        self.are_apart = found.are_apart;
        let own = self.balance.as_deref_mut().filter(|_| at.may_have_rows());
        let Some(balance) = own else { return };
        balance.place(at);
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
