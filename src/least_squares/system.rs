//! The quadratic model of the cost about a point, and its steps.

use nalgebra::DMatrix;

use super::Options;
use crate::linalg::product::{ColumnMajor, Part, add_scaled, dot, mirror_upper};
use crate::linalg::{Bounds, BoxQp};

/// ½ ‖J d + r‖² with weighted residuals, its damping and its bounds.
#[derive(Clone, Debug)]
pub(super) struct System {
    /// (W½ J)ᵀ, directions × residuals.
    transposed: DMatrix<f64>,
    /// Jᵀ W J.
    pub(super) normal: DMatrix<f64>,
    /// Jᵀ W r.
    gradient: Vec<f64>,
    /// D²: the largest diagonal of the normal matrix so far.
    scale: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    scaled: Scaled,
    d: Vec<f64>,
}

/// The damped model in variables without units, each over its scale: what its solver calls small does not depend on units.
#[derive(Clone, Debug)]
struct Scaled {
    /// Unit of each variable.
    units: Vec<f64>,
    h: DMatrix<f64>,
    g: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    qp: BoxQp,
}

impl System {
    pub(super) fn new(residuals: usize, directions: usize) -> Self {
        Self {
            transposed: DMatrix::zeros(directions, residuals),
            normal: DMatrix::zeros(directions, directions),
            gradient: vec![0.0; directions],
            scale: vec![0.0; directions],
            lower: vec![f64::NEG_INFINITY; directions],
            upper: vec![f64::INFINITY; directions],
            scaled: Scaled::new(directions),
            d: vec![0.0; directions],
        }
    }

    /// Takes residuals and Jacobian at a point.
    pub(super) fn set(&mut self, r: &[f64], jacobian: &DMatrix<f64>, options: &Options) {
        let n = jacobian.ncols();
        self.gradient.fill(0.0);
        for (i, (&r, mut column)) in r.iter().zip(self.transposed.column_iter_mut()).enumerate() {
            let root = options.loss.weight(r * r).sqrt();
            for (k, entry) in column.iter_mut().enumerate() {
                *entry = root * jacobian[(i, k)];
            }
            add_scaled(&mut self.gradient, column.as_slice(), root * r);
        }
        self.normal.fill(0.0);
        if n == 0 {
            return;
        }
        let rows = ColumnMajor {
            data: self.transposed.as_slice(),
            rows: n,
        };
        let product = rows.times_transposed(rows, 1.0);
        product.add_to(self.normal.as_mut_slice(), n, Part::Upper);
        mirror_upper(self.normal.as_mut_slice(), n);
        for (scale, diagonal) in self.scale.iter_mut().zip(self.normal.diagonal().iter()) {
            *scale = scale.max(*diagonal);
        }
    }

    /// Sets the room that the variables have for a step.
    pub(super) fn bound(&mut self, x: &[f64], options: &Options) {
        for (room, (bound, x)) in self.lower.iter_mut().zip(options.lower.iter().zip(x)) {
            *room = bound - x;
        }
        for (room, (bound, x)) in self.upper.iter_mut().zip(options.upper.iter().zip(x)) {
            *room = bound - x;
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        let entries = self.gradient.iter().chain(self.normal.iter());
        entries.copied().all(f64::is_finite)
    }

    /// Whether a bound holds a direction back: the cost falls beyond it.
    pub(super) fn is_held(&self, k: usize) -> bool {
        (self.lower[k] >= 0.0 && self.gradient[k] > 0.0)
            || (self.upper[k] <= 0.0 && self.gradient[k] < 0.0)
    }

    /// Largest cosine between the residuals and a column of their Jacobian that no bound holds.
    ///
    /// * `size` – ‖r‖ with the weights of the loss
    pub(super) fn largest_cosine(&self, size: f64) -> f64 {
        let free = (0..self.gradient.len()).filter(|&k| !self.is_held(k));
        let cosine = |k: usize| {
            let length = self.normal[(k, k)].sqrt();
            match length * size {
                0.0 => 0.0,
                product => self.gradient[k].abs() / product,
            }
        };
        free.map(cosine).fold(0.0, f64::max)
    }

    /// Finds the step with the damping λ. Returns by how much the cost falls with it if residuals are linear; `None` if no step can be found.
    pub(super) fn step(&mut self, damping: f64) -> Option<f64> {
        self.scaled.set(&self.normal, &self.scale, damping);
        let bounds = Bounds {
            lower: &self.lower,
            upper: &self.upper,
        };
        self.scaled.solve(&self.gradient, bounds, &mut self.d)?;
        let (d, n) = (&self.d, self.gradient.len());
        let rows = self.normal.as_slice().chunks_exact(n.max(1)).zip(d);
        let quadratic: f64 = rows.map(|(row, x)| x * dot(row, d)).sum();
        Some(-dot(&self.gradient, d) - 0.5 * quadratic)
    }

    /// The step.
    pub(super) fn d(&self) -> &[f64] {
        &self.d
    }

    /// ‖D x‖, the size of a step in the scale of the residuals.
    pub(super) fn size(&self, x: &[f64]) -> f64 {
        let squares = self.scale.iter().zip(x).map(|(scale, x)| scale * x * x);
        squares.sum::<f64>().sqrt()
    }
}

impl Scaled {
    fn new(n: usize) -> Self {
        Self {
            units: vec![1.0; n],
            h: DMatrix::zeros(n, n),
            g: vec![0.0; n],
            lower: vec![0.0; n],
            upper: vec![0.0; n],
            qp: BoxQp::new(n),
        }
    }

    /// Takes D⁻¹ N D⁻¹ + λ 1 with N = Jᵀ W J.
    ///
    /// * `scale` – D²
    fn set(&mut self, normal: &DMatrix<f64>, scale: &[f64], damping: f64) {
        for (unit, &scale) in self.units.iter_mut().zip(scale) {
            // A direction that nothing depends on stays where it is.
            *unit = if scale > 0.0 {
                scale.sqrt().recip()
            } else {
                1.0
            };
        }
        for k in 0..self.units.len() {
            for i in 0..self.units.len() {
                self.h[(i, k)] = self.units[i] * normal[(i, k)] * self.units[k];
            }
            self.h[(k, k)] += damping;
        }
    }

    /// Finds the step; `None` if there is none.
    fn solve(&mut self, gradient: &[f64], bounds: Bounds<'_>, d: &mut [f64]) -> Option<()> {
        for ((g, gradient), unit) in self.g.iter_mut().zip(gradient).zip(&self.units) {
            *g = gradient * unit;
        }
        let largest = self.g.iter().fold(0.0_f64, |max, g| max.max(g.abs()));
        let size = if largest > 0.0 { largest } else { 1.0 };
        self.g.iter_mut().for_each(|g| *g /= size);
        for (k, unit) in self.units.iter_mut().enumerate() {
            *unit *= size;
            self.lower[k] = bounds.lower[k] / *unit;
            self.upper[k] = bounds.upper[k] / *unit;
        }
        let scaled_bounds = Bounds {
            lower: &self.lower,
            upper: &self.upper,
        };
        (self.qp.solve(self.h.as_slice(), &self.g, scaled_bounds)).ok()?;
        for (k, d) in d.iter_mut().enumerate() {
            // Within the bounds whatever rounding did to them.
            *d = (self.qp.d[k] * self.units[k])
                .max(bounds.lower[k])
                .min(bounds.upper[k]);
        }
        Some(())
    }
}
