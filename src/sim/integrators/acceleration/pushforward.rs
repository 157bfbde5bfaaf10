//! Jacobians of the acceleration at which all terms balance, by the implicit function theorem.

use crate::contact::ROWS;
use crate::dynamics::{At, Blocks, Calls, Gyroscopic};
use crate::scalar::{Differentiable, Linear};
use crate::sim::integrators::half_step::MidpointColumns;
use crate::sim::{
    AccelerationScratch, AllSlopes, Bias, ForceColumns, Held, JacobianMemory, JacobianSink, Moment,
    RowColumns, Simulator, SlopePoint, TermSlopes, Terms,
};

/// −∂a/∂(q, v, m, u), and working memory to find it.
#[derive(Clone, Debug)]
pub(crate) struct AccelerationColumns<T: Differentiable> {
    terms: AllSlopes<T>,
    memory: JacobianMemory<T>,
    forces: ForceColumns<T>,
    rows: RowColumns<T>,
    /// For velocity forces of the middle of a step; with semi-implicit Euler from the first step on in which something whirls.
    midpoint: Option<Box<MidpointColumns<T>>>,
}

impl<T: Differentiable> AccelerationColumns<T> {
    pub(crate) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let model = simulator.model();
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        let rows = simulator.held_rows() + model.nv() + ROWS * points;
        let columns = simulator.n_tangent() + simulator.nu();
        let at_middle = simulator.always_in_the_middle();
        Self {
            terms: AllSlopes::new(simulator),
            memory: JacobianMemory::new(simulator),
            forces: ForceColumns::new(simulator, calls),
            rows: RowColumns::new(model, rows, columns),
            midpoint: at_middle.then(|| Box::new(MidpointColumns::new(simulator))),
        }
    }

    /// −∂a, column after column.
    pub(crate) fn minus_a(&self) -> &Blocks<T> {
        &self.forces.acceleration.columns
    }

    /// ∂(m⁺ − m) of a step, or ∂ṁ at a moment, column after column.
    pub(crate) fn bristles(&self) -> &Blocks<T> {
        &self.memory.rates
    }

    /// Differentiates the acceleration that has been found at a moment.
    pub(crate) fn linearize(
        &mut self,
        at: &Moment<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
    ) {
        let gyroscopic = found.gyroscopic(at);
        if let Some(gyroscopic) = gyroscopic {
            self.find_midpoint(at, found, gyroscopic);
        }
        let midpoint = self.midpoint.as_mut().filter(|_| gyroscopic.is_some());
        let bias = midpoint
            .as_ref()
            .map_or(Bias::Moment, |m| Bias::Ahead(m.seen()));
        let (forces, rows, memory) = (&mut self.forces, &mut self.rows, &mut self.memory);
        let point = found_point(at, found, bias);
        forces.clear();
        if let Some(balance) = point.balance {
            let solved = balance.rows();
            let jacobian = solved.first_rows(solved.count());
            let width = at.simulator.n_tangent() + at.simulator.nu();
            rows.start(at.model(), at.v(), point.a, jacobian, width);
        }
        let mut sink = JacobianSink::new(&point, forces, rows, memory);
        self.terms.emit_forces(&point, &found.terms, &mut sink);
        if point.balance.is_some() {
            self.terms.emit_rows(&point, &found.terms, &mut sink);
        }
        let (q, v, a) = (at.q(), at.v(), &found.a[..]);
        let ForceColumns {
            acceleration,
            bodies,
            resistance,
        } = forces;
        acceleration.balance(at.model(), &At { q, v, a }, bodies);
        if let Some(midpoint) = midpoint {
            if at.simulator.held_rows() > 0 {
                midpoint.look_ahead(at, &mut memory.by_next_v, &mut rows.columns);
            }
            acceleration.columns.add_all(midpoint.change());
        }
        match found.balance.as_deref_mut().filter(|_| at.has_rows()) {
            None => acceleration.solve(resistance.iter().map(|x| x.re)),
            Some(balance) => {
                rows.solve(at, balance, &mut acceleration.columns);
                let point = SlopePoint::of_rows(at, &found.a, balance);
                add_rates(&point, &found.terms, rows, &mut memory.rates);
            }
        }
    }

    /// Differentiates the part of velocity forces that belongs to the middle of the step. The other forces that act with it are those without
    /// rows and joint limits.
    fn find_midpoint(
        &mut self,
        at: &Moment<'_, f64, T>,
        found: &AccelerationScratch<T>,
        gyroscopic: &Gyroscopic<T>,
    ) {
        let new = || Box::new(MidpointColumns::new(at.simulator));
        let midpoint = self.midpoint.get_or_insert_with(new);
        let (terms, memory) = (&mut self.terms, &mut self.memory);
        midpoint.find(at, gyroscopic, &found.terms, terms, memory);
    }
}

/// The acceleration with all forces.
fn found_point<'a, T: Differentiable>(
    at: &'a Moment<'a, f64, T>,
    found: &'a AccelerationScratch<T>,
    bias: Bias<'a, T>,
) -> SlopePoint<'a, T> {
    let balance = found.balance.as_deref().filter(|_| at.has_rows());
    let held = balance.filter(|_| at.simulator.held_rows() > 0);
    SlopePoint {
        moment: at,
        a: &found.a,
        is_free: false,
        balance,
        held: held.map(|balance| Held {
            forces: balance.rows().forces(),
            bias,
        }),
    }
}

/// Adds to changes of the state of contact what follows from the forces of rows, whose derivatives are known now.
fn add_rates<T: Differentiable>(
    point: &SlopePoint<'_, T>,
    terms: &Terms<T>,
    rows: &RowColumns<T>,
    rates: &mut Blocks<T>,
) {
    AllSlopes::each_rate_by_force(point, terms, &mut |rate, row, slope| {
        for (rates, f) in rates.blocks_mut().zip(rows.columns.blocks()) {
            rates[rate] = f[row].times_plus(slope, rates[rate]);
        }
    });
}
