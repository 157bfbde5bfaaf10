//! Many contacts, from any start: descent in the coordinates of the nodes, with a line search.
//!
//! With the forces that each law gives to the velocities it sees, under a spring ρ about the last forces f̄, the coordinates z = X f minimise
//!
//! > ½ ‖z‖² + Σ φ(ρ f̄ − Xᵀ z − g − s),   f = ∂φ,   φ(c) = max over the law's cone of  cᵀ f − ½ fᵀ (R + ρ) f,
//!
//! which is convex and smooth, so that Newton's steps with a line search always arrive. Of Coulomb's law s is De Saxcé's shift μ ‖yₜ‖ of the
//! last solution, along the normal; it and f̄ follow from step to step. The last digits are left to the active set.
//! [Castro, Permenter & Han 2022; Acary, Cadoux, Lemaréchal, Malick 2011; Rockafellar 1976]

use super::Law;
use super::jacobian::Square;
use super::newton::{Newton, largest};
use super::response::Response;
use super::system::{Kind, of_unit};
use crate::scalar::from_each;

/// Steps of Newton's method for one s and f̄.
const STEPS: usize = 30;
/// The part of the slope along a step that may be left after it.
const SLOPE_LEFT: f64 = 0.3;
/// Evaluations of a line search.
const SEARCHES: usize = 20;
/// Parts of a step that are tried, each half of the one before, and how much of it the gradient falls.
const HALVINGS: usize = 6;
const FALL: f64 = 1e-2;
/// Gradient beside the size of the problem that rounding leaves.
const ROUNDING: f64 = 1e-14;

/// Working memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Descent {
    z: Vec<f64>,
    step: Vec<f64>,
    gradient: Vec<f64>,
    /// ρ f̄ − g − s.
    given: Vec<f64>,
    /// c, and how it changes along the step.
    c: Vec<f64>,
    along: Vec<f64>,
    f: Vec<f64>,
    slopes: Vec<Square>,
    /// Of the forces, Coulomb's or the convex one with shifts.
    law: Law,
    start_z: Vec<f64>,
}

impl Descent {
    /// Makes z and c those of the forces there are.
    pub(super) fn start(&mut self, newton: &Newton) {
        let coordinates = newton.blocks.columns.n_coordinates();
        for x in [&mut self.z, &mut self.step, &mut self.gradient] {
            x.clear();
            x.resize(coordinates, 0.0);
        }
        for x in [&mut self.given, &mut self.c, &mut self.along, &mut self.f] {
            x.clear();
            x.resize(newton.system.n, 0.0);
        }
        self.slopes.resize(newton.system.units.len(), [[0.0; 3]; 3]);
        newton.blocks.columns.times(&newton.f, &mut self.z);
    }

    /// Minimises about the forces there are, with the shifts of their velocities, and replaces the forces. At most so many steps.
    pub(super) fn run(&mut self, newton: &mut Newton, rho: f64, tolerance: f64, most: usize) {
        self.law = Law::Convex;
        self.find_given(newton, rho);
        if newton.system.law == Law::Coulomb {
            self.shift(newton);
        }
        let goal = tolerance.max(ROUNDING) * newton.size();
        self.evaluate(newton, rho);
        for _ in 0..most.min(STEPS) {
            if largest(&self.gradient) <= goal {
                break;
            }
            self.find_step(newton);
            if !self.advance(newton, rho) {
                break;
            }
            self.evaluate(newton, rho);
        }
        newton.f.copy_from_slice(&self.f);
    }

    /// Looks for the forces of Coulomb's law itself about those there are, by Newton's method as long as residuals fall; whether they are found.
    pub(super) fn run_exactly(
        &mut self,
        newton: &mut Newton,
        rho: f64,
        tolerance: f64,
        most: usize,
    ) -> bool {
        self.law = Law::Coulomb;
        self.find_given(newton, rho);
        let goal = tolerance.max(ROUNDING) * newton.size();
        self.start_z.clone_from(&self.z);
        self.evaluate(newton, rho);
        for _ in 0..most.min(STEPS) {
            if largest(&self.gradient) <= goal {
                newton.f.copy_from_slice(&self.f);
                return true;
            }
            self.find_step(newton);
            if !self.reduce(newton, rho) {
                break;
            }
        }
        self.z.clone_from(&self.start_z);
        false
    }

    /// Goes a part of the step such that the gradient falls. `false` if none does.
    fn reduce(&mut self, newton: &Newton, rho: f64) -> bool {
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let before = norm(&self.gradient);
        let mut length = 1.0;
        let mut moved = 0.0;
        for _ in 0..HALVINGS {
            let part = length - moved;
            let all = self.z.iter_mut().zip(&self.step);
            all.for_each(|(z, step)| *z += part * step);
            moved = length;
            self.evaluate(newton, rho);
            if norm(&self.gradient) <= (1.0 - FALL * length) * before {
                return true;
            }
            length *= 0.5;
        }
        false
    }

    fn find_given(&mut self, newton: &Newton, rho: f64) {
        for (row, given) in self.given.iter_mut().enumerate() {
            *given = rho * newton.f[row] - newton.system.g[row];
        }
    }

    /// Adds −s.
    fn shift(&mut self, newton: &Newton) {
        let units = newton.system.units.iter();
        for unit in units.filter(|unit| unit.kind == Kind::Cone) {
            let y = of_unit(&newton.y, unit);
            self.given[unit.row] -= unit.mu * y[1].hypot(y[2]);
        }
    }

    /// c, f and the gradient  z − X f.
    fn evaluate(&mut self, newton: &Newton, rho: f64) {
        let columns = &newton.blocks.columns;
        for (row, c) in self.c.iter_mut().enumerate() {
            *c = self.given[row] - columns.dot(row, &self.z);
        }
        for (unit, slopes) in newton.system.units.iter().zip(&mut self.slopes) {
            let response = Response::of(newton, self.law, unit, rho);
            let c = of_unit(&self.c, unit);
            let f = response.force(c);
            *slopes = response.slopes(c, f);
            self.f[unit.row..unit.row + unit.rows()].copy_from_slice(&f[..unit.rows()]);
        }
        columns.times(&self.f, &mut self.gradient);
        let all = self.gradient.iter_mut().zip(&self.z);
        all.for_each(|(gradient, z)| *gradient = z - *gradient);
    }

    /// δz = −(1 + X H Xᵀ)⁻¹ gradient.
    fn find_step(&mut self, newton: &mut Newton) {
        let (system, blocks) = (&newton.system, &mut newton.blocks);
        let slopes = |k: usize| Some(self.slopes[k]).filter(|h| h[0][0] != 0.0);
        blocks.factorize(&system.units, slopes);
        newton.steps += 1;
        let minus = self.step.iter_mut().zip(&self.gradient);
        minus.for_each(|(step, gradient)| *step = -gradient);
        blocks.solve(&mut self.step);
        for (row, along) in self.along.iter_mut().enumerate() {
            *along = -blocks.columns.dot(row, &self.step);
        }
    }

    /// Goes along the step to where the slope is a part of the first one. `false` if that is not down.
    fn advance(&mut self, newton: &Newton, rho: f64) -> bool {
        // At its start the slope is that of the gradient.
        let along = self.gradient.iter().zip(&self.step);
        let first: f64 = along.map(|(gradient, step)| gradient * step).sum();
        if first.is_nan() || first >= 0.0 {
            return false;
        }
        let (mut low, mut high, mut length) = (0.0, f64::INFINITY, 1.0);
        let mut at_low = first;
        for _ in 0..SEARCHES {
            let slope = self.slope(newton, rho, length);
            if slope.abs() <= -SLOPE_LEFT * first {
                break;
            }
            if slope < 0.0 {
                (low, at_low) = (length, slope);
                length = if high.is_finite() {
                    0.5 * (low + high)
                } else {
                    2.0 * length
                };
            } else {
                high = length;
                // Where a line through both slopes is zero, but not at their ends.
                let share = (at_low / (at_low - slope)).clamp(0.1, 0.9);
                length = low + share * (high - low);
            }
        }
        let moved = self.z.iter_mut().zip(&self.step);
        moved.for_each(|(z, step)| *z += length * step);
        length.is_finite()
    }

    /// Slope of the objective along the step:  (z + α δz)ᵀ δz + fᵀ(c + α δc) ∂c/∂α.
    fn slope(&self, newton: &Newton, rho: f64, length: f64) -> f64 {
        let own = self.z.iter().zip(&self.step);
        let mut sum: f64 = own.map(|(z, step)| (z + length * step) * step).sum();
        for unit in &newton.system.units {
            let (c, along) = (of_unit(&self.c, unit), of_unit(&self.along, unit));
            let c = from_each(|i| c[i] + length * along[i]);
            let f = Response::of(newton, self.law, unit, rho).force(c);
            sum += f[0] * along[0] + f[1] * along[1] + f[2] * along[2];
        }
        sum
    }
}
