//! The whole problem around a trajectory: all points and all defects.

use nalgebra::Cholesky;

use super::defects::{Defects, Flow};
use super::local::{Local, Worker};
use super::merit::Price;
use super::points::Points;
use crate::sim::for_each_part;
use crate::trajopt::continuous::ContinuousDynamics;
use crate::trajopt::problem::Problem;

/// The problem to first order, its costs to second.
pub(super) struct Model<D> {
    pub(super) locals: Vec<Local>,
    pub(super) defects: Vec<Defects>,
    workers: Vec<Worker<D>>,
}

impl<D: ContinuousDynamics> Model<D> {
    pub(super) fn new(problem: &Problem<D>, threads: usize) -> Self {
        let n = problem.horizon();
        Self {
            locals: (0..=2 * n).map(|i| Local::new(problem, i)).collect(),
            defects: vec![Defects::new(problem.dynamics()); n],
            workers: (0..threads.max(1)).map(|_| Worker::new(problem)).collect(),
        }
    }

    /// Values along a trajectory, without derivatives.
    ///
    /// * `weights` – ν of all defects
    pub(super) fn measure(
        &mut self,
        problem: &Problem<D>,
        points: &Points,
        weights: &[f64],
    ) -> Price {
        for_each_part(&mut self.workers, &mut self.locals, |worker, i, local| {
            local.measure(problem, i, points.at(i), worker);
        });
        self.measure_defects(problem, points);
        self.price(weights)
    }

    /// Values and derivatives.
    pub(super) fn expand(&mut self, problem: &Problem<D>, points: &Points) {
        for_each_part(&mut self.workers, &mut self.locals, |worker, i, local| {
            local.expand(problem, i, points.at(i), worker);
        });
        self.measure_defects(problem, points);
        let (dynamics, locals) = (problem.dynamics(), &self.locals);
        for_each_part(
            &mut self.workers,
            &mut self.defects,
            |worker, k, defects| {
                let (states, flows) = interval(points, locals, k);
                defects.linearize(dynamics, states, flows, &mut worker.chart);
            },
        );
    }

    /// Whether the Hessian of the costs, regularised, is positive definite.
    pub(super) fn is_convex(&self, regularization: f64) -> bool {
        self.locals.iter().all(|local| {
            let mut hessian = local.cost.hessian.clone();
            hessian.fill_lower_triangle_with_upper_triangle();
            for k in 0..hessian.nrows() {
                hessian[(k, k)] += regularization;
            }
            Cholesky::new(hessian).is_some()
        })
    }

    fn measure_defects(&mut self, problem: &Problem<D>, points: &Points) {
        for (k, defects) in self.defects.iter_mut().enumerate() {
            let (states, flows) = interval(points, &self.locals, k);
            defects.measure(problem.dynamics(), states, flows);
        }
    }

    pub(super) fn price(&self, weights: &[f64]) -> Price {
        let defects = self.defects.iter().flat_map(|defects| &defects.values);
        let entries = self.locals.iter().flat_map(|local| &local.entries);
        let weighed = defects.clone().zip(weights).map(|(d, nu)| nu * d.abs());
        let largest = |max: f64, x: f64| {
            if x.is_nan() {
                f64::INFINITY
            } else {
                max.max(x)
            }
        };
        Price {
            cost: self.locals.iter().map(|local| local.cost.value).sum(),
            weighed_defects: weighed.sum(),
            violations: entries.clone().map(|entry| entry.excess()).sum(),
            gap: defects.map(|d| d.abs()).fold(0.0, largest),
            violation: entries.map(|entry| entry.excess()).fold(0.0, largest),
        }
    }
}

/// States and rates at start, middle and end of an interval.
fn interval<'a>(
    points: &'a Points,
    locals: &'a [Local],
    k: usize,
) -> ([&'a [f64]; 3], [&'a Flow; 3]) {
    let all = [2 * k, 2 * k + 1, 2 * k + 2];
    (all.map(|i| points.at(i).0), all.map(|i| &locals[i].flow))
}
