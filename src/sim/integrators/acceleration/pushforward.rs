//! Jacobians of the acceleration at which all terms balance, by the implicit function theorem.

use super::AccelerationScratch;
use crate::dynamics::{Blocks, Calls};
use crate::scalar::{Differentiable, Linear};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::balance::BalanceColumns;
use crate::sim::integrators::half_step;
use crate::sim::simulator::Simulator;
use crate::sim::terms::{
    AllDerivatives, DerivativePoint, JacobianMemory, RowColumns, TermDerivatives, Terms,
};

/// −∂a/∂(q, v, m, u), and working memory to find it.
#[derive(Clone, Debug)]
pub(crate) struct AccelerationColumns<T: Differentiable> {
    terms: AllDerivatives<T>,
    memory: JacobianMemory<T>,
    balance: BalanceColumns<T>,
    /// With semi-implicit Euler allocated at the first step with fast rotation.
    half_step: Option<Box<half_step::Columns<T>>>,
}

impl<T: Differentiable> AccelerationColumns<T> {
    /// Makes memory for a simulator.
    pub(crate) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        let of_each = simulator.contacts().map_or(0, |c| c.rows_of_each());
        let rows = simulator.bilateral_rows() + simulator.joint_rows() + of_each * points;
        let at_middle = simulator.always_in_the_middle();
        Self {
            terms: AllDerivatives::new(simulator),
            memory: JacobianMemory::new(simulator),
            balance: BalanceColumns::new(simulator, rows, calls),
            half_step: at_middle.then(|| half_step::Columns::new(simulator)),
        }
    }

    /// −∂a, column by column.
    pub(crate) fn minus_a(&self) -> &Blocks<T> {
        &self.balance.forces.acceleration.columns
    }

    /// ∂(m⁺ − m) of a step, or ∂ṁ at an instant, column by column.
    pub(crate) fn bristles(&self) -> &Blocks<T> {
        &self.memory.rates
    }

    /// ∂f of the rows, column by column, where there are rows.
    pub(super) fn row_forces(&self) -> &Blocks<T> {
        &self.balance.rows.columns
    }

    /// Differentiates the acceleration that has been found at an instant.
    pub(crate) fn linearize(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
    ) {
        let has_rows = found.has_rows(at);
        if let Some(balance) = found.balance.as_deref_mut().filter(|_| has_rows) {
            balance.prepare_slopes(at);
        }
        let (own, terms, memory) = (&mut self.balance, &mut self.terms, &mut self.memory);
        let half_step = found.half_step(at).map(|half_step| {
            let new = || half_step::Columns::new(at.simulator);
            let columns = self.half_step.get_or_insert_with(new);
            columns.find(at, half_step, &found.terms, terms, memory);
            columns
        });
        let balance = found.balance.as_deref().filter(|_| has_rows);
        let jacobian = balance.map(|balance| balance.rows().first_rows(balance.rows().count()));
        let point = DerivativePoint::of_all(at, &found.a, balance);
        own.find(&point, jacobian, &found.terms, terms, memory);
        let columns = &mut own.forces.acceleration.columns;
        if let Some(half_step) = half_step {
            half_step.add_to(at, columns, &mut own.rows.columns);
        }
        match found.balance.as_deref_mut().filter(|_| has_rows) {
            None => {
                let resistance = own.forces.resistance.iter().map(|x| x.re);
                own.forces.acceleration.solve(resistance);
            }
            Some(balance) => {
                own.rows.solve(at, balance, columns);
                let point = DerivativePoint::of_all(at, &found.a, Some(balance));
                add_rates(&point, &found.terms, &own.rows, &mut memory.rates);
            }
        }
    }
}

/// Adds the part of the changes of the contact state that depends on the forces of rows, whose derivatives are now known.
fn add_rates<T: Differentiable>(
    point: &DerivativePoint<'_, T>,
    terms: &Terms<T>,
    rows: &RowColumns<T>,
    rates: &mut Blocks<T>,
) {
    AllDerivatives::each_rate_by_force(point, terms, &mut |rate, row, slope| {
        for (rates, f) in rates.blocks_mut().zip(rows.columns.blocks()) {
            rates[rate] = f[row].times_plus(slope, rates[rate]);
        }
    });
}
