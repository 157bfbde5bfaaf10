//! The whole problem around a trajectory: all points and all defects.

use super::defects::{Defects, Flow};
use super::merit::Merit;
use super::point_data::{Memory, PointData};
use super::points::Points;
use crate::linalg::FreeFactor;
use crate::nested::IntoNested;
use crate::parallel::for_each_part;
use crate::scalar::MapEach;
use crate::trajopt::problem::Problem;

/// The problem to first order, its costs to second.
pub(super) struct Approximation {
    pub(super) points: Vec<PointData>,
    pub(super) defects: Vec<Defects>,
    memories: Vec<Memory>,
    convexity: Convexity,
}

impl Approximation {
    pub(super) fn new(problem: &Problem, threads: usize) -> Self {
        let (n, system) = (problem.horizon(), problem.dynamics());
        let memories = (0..threads.clamp(1, 2 * n + 1)).map(|_| Memory::new(problem));
        Self {
            points: (0..=2 * n).map(|i| PointData::new(problem, i)).collect(),
            defects: vec![Defects::new(system); n],
            memories: memories.collect(),
            convexity: Convexity::new(system.ndx() + system.nu()),
        }
    }

    /// Values along a trajectory, without derivatives.
    ///
    /// * `weights` – ν of all defects
    pub(super) fn measure(&mut self, problem: &Problem, at: &Points, weights: &[f64]) -> Merit {
        for_each_part(&mut self.memories, &mut self.points, |memory, i, point| {
            point.measure(problem, i, at.at(i), memory);
        });
        self.measure_defects(problem, at);
        self.merit(weights)
    }

    /// Values and derivatives.
    pub(super) fn expand(&mut self, problem: &Problem, at: &Points) {
        for_each_part(&mut self.memories, &mut self.points, |memory, i, point| {
            point.expand(problem, i, at.at(i), memory);
        });
        self.measure_defects(problem, at);
        let (system, points, defects) = (problem.dynamics(), &self.points, &mut self.defects);
        for_each_part(&mut self.memories, defects, |memory, k, defects| {
            let (states, flows) = interval(at, points, k);
            defects.linearize(system, states, flows, &mut memory.chart);
        });
    }

    /// Whether the Hessian of the costs, regularised, is positive definite.
    pub(super) fn is_convex(&mut self, regularization: f64) -> bool {
        let Self {
            points, convexity, ..
        } = self;
        let mut hessians = points.iter().map(|point| &point.cost.hessian);
        hessians.all(|hessian| convexity.holds(hessian.as_slice(), regularization))
    }

    fn measure_defects(&mut self, problem: &Problem, at: &Points) {
        for (k, defects) in self.defects.iter_mut().enumerate() {
            let (states, flows) = interval(at, &self.points, k);
            defects.measure(problem.dynamics(), states, flows);
        }
    }

    /// The merit of what was measured last.
    ///
    /// * `weights` – ν of all defects
    pub(super) fn merit(&self, weights: &[f64]) -> Merit {
        let defects = self.defects.iter().nested(|defects| &defects.values);
        let entries = self.points.iter().nested(|point| &point.entries);
        let weighed = defects.clone().zip(weights).map(|(d, nu)| nu * d.abs());
        let largest = |max: f64, x: f64| {
            if x.is_nan() {
                f64::INFINITY
            } else {
                max.max(x)
            }
        };
        Merit {
            cost: self.points.iter().map(|point| point.cost.value).sum(),
            weighed_defects: weighed.sum(),
            violations: entries.clone().map(|entry| entry.excess()).sum(),
            gap: defects.map(|d| d.abs()).fold(0.0, largest),
            violation: entries.map(|entry| entry.excess()).fold(0.0, largest),
        }
    }
}

/// Working memory for factors of Hessians.
struct Convexity {
    hessian: Vec<f64>,
    factor: FreeFactor,
}

impl Convexity {
    /// Memory for n × n matrices.
    fn new(n: usize) -> Self {
        let mut factor = FreeFactor::new(n);
        factor.free.extend(0..n);
        Self {
            hessian: vec![0.0; n * n],
            factor,
        }
    }

    /// Whether H + σ is positive definite.
    ///
    /// * `hessian` – H by columns, of which the upper triangle is read
    fn holds(&mut self, hessian: &[f64], regularization: f64) -> bool {
        self.hessian.copy_from_slice(hessian);
        let diagonal = self.factor.free.len() + 1;
        for entry in self.hessian.iter_mut().step_by(diagonal) {
            *entry += regularization;
        }
        self.factor.factorize(&self.hessian).is_ok()
    }
}

/// States and rates at start, middle and end of an interval.
fn interval<'a>(
    at: &'a Points,
    points: &'a [PointData],
    k: usize,
) -> ([&'a [f64]; 3], [&'a Flow; 3]) {
    let all = [2 * k, 2 * k + 1, 2 * k + 2];
    (
        all.map_each(|i| at.at(i).x),
        all.map_each(|i| &points[i].flow),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    // 2 × 2 with eigenvalues −1 and 3; the entry below the diagonal is not read.
    #[test]
    fn regularised_hessian_is_convex_from_its_smallest_eigenvalue_on() {
        let hessian = [1.0, f64::NAN, 2.0, 1.0];
        let mut convexity = Convexity::new(2);
        for (regularization, expected) in [(0.0, false), (0.999, false), (1.001, true)] {
            assert_eq!(convexity.holds(&hessian, regularization), expected);
        }
        assert!(!convexity.holds(&[f64::NAN; 4], 1e9));
    }
}
