//! A small quadratic program with bounds: the inputs of one stage of a trajectory, a step of least squares.
//!
//! min ½ dᵀ H d + gᵀ d  over  lower ≤ d ≤ upper  by the projected Newton method: what is at a bound and pushed against
//! it is clamped, the rest takes a Newton step, a line search along the projected arc decides how far. It lands on
//! bounds exactly: an entry that only comes near one counts as free, pushes on, and leaves room for tiny steps alone.
//! Without active bounds it is one Cholesky solve. It ends after a fixed number of steps for any values.
//!
//! [Bertsekas 1982; Tassa, Mansard, Todorov 2014].

use super::product::dot;
use super::{FreeFactor, NotConvex};

/// Newton steps: the active set settles in few; more only where rounding flips it.
const MAX_STEPS: usize = 50;
/// Lengths that the line search tries.
const MAX_LENGTHS: usize = 20;
/// Number of these lengths that may go beyond the first bound.
const MAX_BENT: usize = 10;
/// Distance to a bound, relative to 1 + |d|, below which an entry is at it: rounding of the sums that led there.
const ROUNDING: f64 = 1e-12;
/// Share of the linear prediction that a step has to keep.
const SUFFICIENT: f64 = 0.1;
/// Largest projected gradient, relative to the gradient at zero, that counts as none.
const GRADIENT_TOLERANCE: f64 = 1e-12;

/// Bounds of the variables, as many as there are of these.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds<'a> {
    pub(crate) lower: &'a [f64],
    pub(crate) upper: &'a [f64],
}

/// Working memory and result.
#[derive(Clone, Debug)]
pub(crate) struct BoxQp {
    /// The minimiser.
    pub(crate) d: Vec<f64>,
    /// Factor of H over the entries that are not at a bound.
    pub(crate) factor: FreeFactor,
    gradient: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    moved: Vec<f64>,
}

impl BoxQp {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Self {
            d: zeros(),
            factor: FreeFactor::new(n),
            gradient: zeros(),
            step: zeros(),
            trial: zeros(),
            moved: zeros(),
        }
    }

    /// −H⁻¹ g, everything free.
    ///
    /// * `h` – H, n × n, of which the upper triangle by columns is read
    pub(crate) fn solve_unbounded(&mut self, h: &[f64], g: &[f64]) -> Result<(), NotConvex> {
        self.factor.free.clear();
        self.factor.free.extend(0..g.len());
        self.factor.factorize(h)?;
        self.d.copy_from_slice(g);
        self.factor.solve(&mut self.d);
        self.d.iter_mut().for_each(|d| *d = -*d);
        Ok(())
    }

    /// The minimiser within bounds.
    ///
    /// * `h` – H, n × n, symmetric
    pub(crate) fn solve(
        &mut self,
        h: &[f64],
        g: &[f64],
        bounds: Bounds<'_>,
    ) -> Result<(), NotConvex> {
        let scale = g.iter().fold(1.0_f64, |max, g| max.max(g.abs()));
        self.d.fill(0.0);
        bounds.clamp(&mut self.d);
        for _ in 0..MAX_STEPS {
            self.evaluate(h, g);
            self.find_free(bounds);
            self.factor.factorize(h)?;
            let remaining = self.factor.free.iter().map(|&i| self.gradient[i].abs());
            if remaining.fold(0.0, f64::max) <= GRADIENT_TOLERANCE * scale {
                break;
            }
            self.newton_step();
            if !self.search(h, bounds) {
                break;
            }
        }
        Ok(())
    }

    /// The gradient H d + g.
    fn evaluate(&mut self, h: &[f64], g: &[f64]) {
        let n = g.len();
        for i in 0..n {
            let row = (0..n).map(|k| h[k * n + i] * self.d[k]);
            self.gradient[i] = g[i] + row.sum::<f64>();
        }
    }

    /// Finds the free entries: those that are not at a bound with the gradient pushing against it.
    fn find_free(&mut self, Bounds { lower, upper }: Bounds<'_>) {
        self.factor.free.clear();
        for (i, (&d, &gradient)) in self.d.iter().zip(&self.gradient).enumerate() {
            let held = (d <= lower[i] && gradient > 0.0) || (d >= upper[i] && gradient < 0.0);
            if !held && lower[i] < upper[i] {
                self.factor.free.push(i);
            }
        }
    }

    /// step = −H⁻¹ gradient over the free entries, zero over the others.
    fn newton_step(&mut self) {
        let (free, step) = (&self.factor.free, &mut self.step);
        step.fill(0.0);
        for (row, &i) in free.iter().enumerate() {
            step[row] = -self.gradient[i];
        }
        self.factor.solve(step);
        // From the order of the free entries to that of all, from the end so that nothing is overwritten.
        for (row, &i) in free.iter().enumerate().rev() {
            let x = std::mem::replace(&mut step[row], 0.0);
            step[i] = x;
        }
    }

    /// Goes along the projected step as far as it pays; `false` where it does not.
    ///
    /// The change  ∇ᵀ s + ½ sᵀ H s  comes from the move s alone: as a difference of two values it would drown in their
    /// rounding.
    fn search(&mut self, h: &[f64], bounds: Bounds<'_>) -> bool {
        let n = self.d.len();
        let mut length = 1.0;
        let straight = self.straight_length(bounds);
        for halvings in 0..MAX_LENGTHS {
            for (trial, (&d, &step)) in self.trial.iter_mut().zip(self.d.iter().zip(&self.step)) {
                *trial = d + length * step;
            }
            bounds.clamp(&mut self.trial);
            let moved = self.moved.iter_mut().zip(self.trial.iter().zip(&self.d));
            moved.for_each(|(moved, (trial, d))| *moved = trial - d);
            let slope = dot(&self.moved, &self.gradient);
            let rows = h.chunks_exact(n.max(1)).zip(&self.moved);
            let quadratic: f64 = rows.map(|(row, moved)| moved * dot(row, &self.moved)).sum();
            if slope < 0.0 && slope + 0.5 * quadratic <= SUFFICIENT * slope {
                self.d.copy_from_slice(&self.trial);
                return true;
            }
            let half = 0.5 * length;
            let is_last = halvings + 1 == MAX_BENT || half <= straight;
            length = if is_last && straight < length {
                straight
            } else {
                half
            };
        }
        false
    }

    /// Share of the step up to the first bound, at most 1; up to there it is a Newton step, which always pays.
    fn straight_length(&self, Bounds { lower, upper }: Bounds<'_>) -> f64 {
        let mut length: f64 = 1.0;
        for (i, (&d, &step)) in self.d.iter().zip(&self.step).enumerate() {
            let room = if step < 0.0 {
                lower[i] - d
            } else {
                upper[i] - d
            };
            if room != 0.0 && step != 0.0 {
                length = length.min(room / step);
            }
        }
        length
    }
}

impl Bounds<'_> {
    /// Moves entries into the bounds, and onto those that are near.
    fn clamp(self, x: &mut [f64]) {
        for (x, (&lower, &upper)) in x.iter_mut().zip(self.lower.iter().zip(self.upper)) {
            let near = ROUNDING * (1.0 + x.abs());
            *x = if *x <= lower + near {
                lower
            } else if *x >= upper - near {
                upper
            } else {
                *x
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::OTHER_ALGORITHM;
    use nalgebra::{DMatrix, DVector};

    fn problem(n: usize, seed: usize) -> (DMatrix<f64>, DVector<f64>) {
        let x = |i: usize| ((seed * 37 + i * 11) as f64).sin();
        let a = DMatrix::from_fn(n, n, |i, j| x(i * n + j));
        let h = a.tr_mul(&a) + DMatrix::identity(n, n) * 0.05;
        (h, DVector::from_fn(n, |i, _| 3.0 * x(1000 + i)))
    }

    // d is the minimiser iff the projected gradient vanishes.
    #[test]
    fn minimiser_satisfies_the_conditions_of_optimality() {
        let mut clamped = 0;
        for (seed, n) in (0..60).map(|seed| (seed, 1 + seed % 7)) {
            let (h, g) = problem(n, seed);
            let (lower, upper) = (vec![-0.7; n], vec![0.4; n]);
            let mut qp = BoxQp::new(n);
            let bounds = Bounds {
                lower: &lower,
                upper: &upper,
            };
            qp.solve(h.as_slice(), g.as_slice(), bounds).unwrap();
            let d = DVector::from_column_slice(&qp.d);
            let gradient = &h * &d + &g;
            for i in 0..n {
                assert!((-0.7..=0.4).contains(&d[i]), "seed {seed}");
                let projected = d[i] - (d[i] - gradient[i]).clamp(-0.7, 0.4);
                assert!(
                    projected.abs() < OTHER_ALGORITHM,
                    "seed {seed}: {projected:e}"
                );
            }
            clamped += n - qp.factor.free.len();
        }
        assert!(clamped > 20, "bounds were active {clamped} times");
    }

    // The inputs of a long motion: curvatures of very different size, and entries a rounding or a little more away from
    // a bound.
    #[test]
    fn entries_near_a_bound_do_not_keep_the_minimiser_away() {
        let near = [1.8e-15, 1e-13, 1e-9, 5e-6, 1e-3, 0.3];
        for (seed, n) in (0..600).map(|seed| (seed, 2 + seed % 8)) {
            let (mut h, g) = problem(n, seed);
            let scale = |i: usize| 10_f64.powi(-((seed + 3 * i) as i32 % 4));
            h = DMatrix::from_fn(n, n, |i, j| h[(i, j)] * scale(i) * scale(j));
            let lower: Vec<f64> = (0..n).map(|i| -near[(seed + i) % 6]).collect();
            let upper: Vec<f64> = (0..n).map(|i| 1.0 + lower[(i + 1) % n]).collect();
            let swap = |i: usize| (seed + i).is_multiple_of(3);
            let [lower, upper] = [(&lower, &upper), (&upper, &lower)].map(|(a, b)| -> Vec<f64> {
                (0..n).map(|i| if swap(i) { -b[i] } else { a[i] }).collect()
            });
            let mut qp = BoxQp::new(n);
            let bounds = Bounds {
                lower: &lower,
                upper: &upper,
            };
            qp.solve(h.as_slice(), g.as_slice(), bounds).unwrap();
            let gradient = &h * DVector::from_column_slice(&qp.d) + &g;
            for i in 0..n {
                let d = qp.d[i];
                let (at_lower, at_upper) = (d <= lower[i] + 1e-11, d >= upper[i] - 1e-11);
                let held = (at_lower && gradient[i] > 0.0) || (at_upper && gradient[i] < 0.0);
                assert!(
                    held || gradient[i].abs() < OTHER_ALGORITHM,
                    "seed {seed}: {gradient}"
                );
                assert_eq!(qp.factor.free.contains(&i), !held, "seed {seed}, entry {i}");
            }
        }
    }

    #[test]
    fn without_active_bounds_it_equals_the_cholesky_solution() {
        let (h, g) = problem(5, 3);
        let mut qp = BoxQp::new(5);
        let wide = Bounds {
            lower: &[f64::NEG_INFINITY; 5],
            upper: &[f64::INFINITY; 5],
        };
        qp.solve(h.as_slice(), g.as_slice(), wide).unwrap();
        let bounded = qp.d.clone();
        qp.solve_unbounded(h.as_slice(), g.as_slice()).unwrap();
        let expected = -h.cholesky().unwrap().solve(&g);
        for i in 0..5 {
            assert!(
                (bounded[i] - expected[i]).abs() < 1e-10 && (qp.d[i] - expected[i]).abs() < 1e-10
            );
        }
    }

    #[test]
    fn negative_curvature_is_reported() {
        let mut qp = BoxQp::new(1);
        assert_eq!(qp.solve_unbounded(&[-1.0], &[1.0]), Err(NotConvex));
        assert_eq!(qp.solve_unbounded(&[f64::NAN], &[1.0]), Err(NotConvex));
    }
}
