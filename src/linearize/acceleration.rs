//! Jacobians of the acceleration at which all terms balance, by the implicit function theorem.

use super::midpoint::MidpointColumns;
use crate::contact::ROWS;
use crate::dynamics::{At, Blocks, Calls, Gyroscopic};
use crate::scalar::Differentiable;
use crate::sim::{
    AccelerationScratch, Coordinates, ForceColumns, LinearPoint, Moment, RowColumns, Simulator,
    TermColumns, TermDerivatives,
};

/// −∂a/∂(q, v, m, u), and working memory to find it.
#[derive(Clone, Debug)]
pub(super) struct AccelerationColumns<T: Differentiable> {
    coordinates: Coordinates<T>,
    terms: TermColumns<T>,
    forces: ForceColumns<T>,
    rows: RowColumns<T>,
    /// For velocity forces of the middle of a step; with semi-implicit Euler from the first step on in which something whirls.
    midpoint: Option<Box<MidpointColumns<T>>>,
}

impl<T: Differentiable> AccelerationColumns<T> {
    pub(super) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let model = simulator.model();
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        let rows = simulator.held_rows() + model.nv() + ROWS * points;
        let columns = simulator.n_tangent() + simulator.nu();
        let at_middle = simulator.always_in_the_middle();
        Self {
            coordinates: Coordinates::new(simulator),
            terms: TermColumns::new(simulator),
            forces: ForceColumns::new(simulator, calls),
            rows: RowColumns::new(model, rows, columns),
            midpoint: at_middle.then(|| Box::new(MidpointColumns::new(simulator))),
        }
    }

    /// −∂a, column after column.
    pub(super) fn minus_a(&self) -> &Blocks<T> {
        &self.forces.acceleration.columns
    }

    /// ∂(m⁺ − m) of a step, or ∂ṁ at a moment, column after column.
    pub(super) fn bristles(&self) -> &Blocks<T> {
        &self.terms.contact.bristles
    }

    /// Differentiates the acceleration that has been found at a moment.
    pub(super) fn linearize(
        &mut self,
        at: &Moment<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
    ) {
        self.coordinates.set(at);
        let gyroscopic = found.gyroscopic(at);
        if let Some(gyroscopic) = gyroscopic {
            self.find_midpoint(at, found, gyroscopic);
        }
        let midpoint = self.midpoint.as_mut().filter(|_| gyroscopic.is_some());
        let (terms, forces, rows) = (&mut self.terms, &mut self.forces, &mut self.rows);
        let ahead = midpoint.as_ref().map(|midpoint| midpoint.seen());
        let point = LinearPoint {
            moment: at,
            coordinates: &self.coordinates,
            a: &found.a,
            is_free: false,
            balance: found.balance.as_deref().filter(|_| at.has_rows()),
            ahead,
        };
        forces.clear();
        terms.add_forces(&point, &found.terms, forces);
        if let Some(balance) = point.balance {
            let solved = balance.rows();
            let jacobian = solved.first_rows(solved.count());
            let width = at.simulator.n_tangent() + at.simulator.nu();
            rows.start(at.model(), at.v(), point.a, jacobian, width);
            terms.add_rows(&point, &found.terms, rows, forces);
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
                let by_next_v = &mut terms.constraints.by_next_v;
                midpoint.look_ahead(at, by_next_v, &mut rows.columns);
            }
            acceleration.columns.add_all(midpoint.change());
        }
        match found.balance.as_deref_mut().filter(|_| at.has_rows()) {
            None => acceleration.solve(resistance.iter().map(|x| x.re)),
            Some(balance) => {
                rows.solve(at, balance, &mut acceleration.columns);
                terms.accept(rows);
            }
        }
    }

    /// Differentiates the part of velocity forces that belongs to the middle of the step. The other forces that act with it are those without
    /// rows and stops.
    fn find_midpoint(
        &mut self,
        at: &Moment<'_, f64, T>,
        found: &AccelerationScratch<T>,
        gyroscopic: &Gyroscopic<T>,
    ) {
        let new = || Box::new(MidpointColumns::new(at.simulator));
        let midpoint = self.midpoint.get_or_insert_with(new);
        let point = LinearPoint {
            moment: at,
            coordinates: &self.coordinates,
            a: &gyroscopic.a,
            is_free: true,
            balance: None,
            ahead: None,
        };
        midpoint.forces.clear();
        let forces = &mut midpoint.forces;
        self.terms.add_forces(&point, &found.terms, forces);
        midpoint.find(at, gyroscopic, &mut self.terms);
    }
}
