//! Least squares over bodies: a semidefinite program, by Newton's method on a logarithmic barrier.
//!
//! > min ½ ‖A x − b‖² + ½ ‖D (x − x₀)‖²  over x with P(x) ≻ 0 for each body and x ≥ 0 where asked.
//!
//! With −t (Σ log det P + Σ log x) added, the problem stays convex, its minimum lies inside, and the cost there is at most t ν above the least, where ν is 4
//! for each body and 1 for each bound. t falls geometrically; each minimum is found by a few steps of Newton's method from the one before.
//!
//! [Boyd, Vandenberghe 2004, sections 11.2 and 11.3].

use nalgebra::{DMatrix, DVector};

use super::normal::Normal;
use crate::scalar::from_each;
use crate::spatial::{INERTIAL_PARAMETERS, Inertia};

/// Conditions that unknowns have to obey.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cone {
    /// The ten unknowns from this one on are the inertial parameters of a body.
    Body(usize),
    /// The unknown is not negative.
    NotNegative(usize),
}

/// The program; its nominal unknowns lie inside the cones of bodies.
#[derive(Clone, Debug)]
pub(super) struct Program {
    /// A.
    pub(super) map: DMatrix<f64>,
    /// b.
    pub(super) target: DVector<f64>,
    /// D.
    pub(super) metric: DMatrix<f64>,
    /// x₀.
    pub(super) nominal: DVector<f64>,
    pub(super) cones: Vec<Cone>,
}

/// Solution of a program.
pub(super) struct Found {
    pub(super) x: DVector<f64>,
    /// Upper bound of the difference of the cost from its minimum.
    pub(super) gap: f64,
    pub(super) iterations: usize,
}

impl Program {
    /// ½ ‖A x − b‖² + ½ ‖D (x − x₀)‖².
    pub(super) fn cost(&self, x: &DVector<f64>) -> f64 {
        let fit = &self.map * x - &self.target;
        let distance = &self.metric * (x - &self.nominal);
        0.5 * (fit.norm_squared() + distance.norm_squared())
    }

    /// Solves the program until the cost is known to be at most `gap` above the least.
    pub(super) fn solve(&self, gap: f64) -> Found {
        /// Factor of t from one minimum to the next.
        const FALL: f64 = 0.1;
        /// Steps of Newton's method to a minimum; some ten are usual.
        const STEPS: usize = 50;
        let hessian = self.map.tr_mul(&self.map) + self.metric.tr_mul(&self.metric);
        let degree: f64 = self.cones.iter().map(|cone| cone.degree()).sum();
        let mut out = Found {
            x: self.start(),
            gap: f64::INFINITY,
            iterations: 0,
        };
        let mut t = (self.cost(&out.x) / degree.max(1.0)).max(gap);
        loop {
            let mut decrement = f64::INFINITY;
            for _ in 0..STEPS {
                out.iterations += 1;
                let Some(found) = self.step(t, &hessian, &mut out.x) else {
                    break;
                };
                decrement = found;
                /// Half the square of Newton's decrement, in units of t, below which a minimum is found.
                const CENTRED: f64 = 1e-3;
                if decrement <= CENTRED * t {
                    break;
                }
            }
            if !decrement.is_finite() {
                return out;
            }
            // A point near the minimum: the decrement comes on top.
            out.gap = t * degree + 2.0 * (decrement * t * degree).sqrt() + decrement;
            if out.gap <= gap || degree == 0.0 {
                return out;
            }
            t *= FALL;
        }
    }

    /// The nominal unknowns, inside all cones.
    fn start(&self) -> DVector<f64> {
        /// Least start of what is not negative: in SI units of joints neither large nor small.
        const LEAST: f64 = 0.1;
        let mut out = self.nominal.clone();
        for cone in &self.cones {
            if let Cone::NotNegative(k) = *cone {
                out[k] = out[k].max(LEAST);
            }
        }
        out
    }

    /// Takes a step of Newton's method towards the minimum for t. Returns half the square of its decrement; `None` where rounding lets no step lower the
    /// value.
    fn step(&self, t: f64, hessian: &DMatrix<f64>, x: &mut DVector<f64>) -> Option<f64> {
        /// Share of the promised fall that a step must reach.
        const SHARE: f64 = 0.1;
        /// Halvings after which a step is nothing.
        const HALVINGS: usize = 60;
        let fit = &self.map * &*x - &self.target;
        let distance = &self.metric * (&*x - &self.nominal);
        let mut gradient = self.map.tr_mul(&fit) + self.metric.tr_mul(&distance);
        let mut hessian = hessian.clone();
        for cone in &self.cones {
            cone.add_derivatives(t, x, &mut gradient, &mut hessian)?;
        }
        let root = root_transposed(&hessian);
        let half = root.tr_solve_upper_triangular(&gradient)?;
        let step = -root.solve_upper_triangular(&half)?;
        let decrement = 0.5 * half.norm_squared();
        let start = self.value(t, x);
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            let trial = &*x + &step * length;
            // Not true of a point outside.
            if self.value(t, &trial) <= start - 2.0 * SHARE * length * decrement {
                *x = trial;
                return Some(decrement);
            }
            length *= 0.5;
        }
        None
    }

    /// The cost with the barrier; infinite outside.
    fn value(&self, t: f64, x: &DVector<f64>) -> f64 {
        let barriers = self.cones.iter().map(|cone| cone.barrier(x));
        self.cost(x) + t * barriers.sum::<f64>()
    }
}

impl Cone {
    /// ν.
    fn degree(self) -> f64 {
        match self {
            Self::Body(_) => 4.0,
            Self::NotNegative(_) => 1.0,
        }
    }

    /// −log det P or −log x.
    fn barrier(self, x: &DVector<f64>) -> f64 {
        match self {
            Self::Body(first) => match inertia(x, first).to_pseudo_inertia().cholesky() {
                Some(factor) => -factor.determinant().ln(),
                None => f64::INFINITY,
            },
            Self::NotNegative(k) if x[k] > 0.0 => -x[k].ln(),
            Self::NotNegative(_) => f64::INFINITY,
        }
    }

    /// Adds t times gradient and Hessian of the barrier: −tr(P⁻¹ Pᵢ) and tr(P⁻¹ Pᵢ P⁻¹ Pₖ).
    fn add_derivatives(
        self,
        t: f64,
        x: &DVector<f64>,
        gradient: &mut DVector<f64>,
        hessian: &mut DMatrix<f64>,
    ) -> Option<()> {
        match self {
            Self::NotNegative(k) => {
                gradient[k] -= t / x[k];
                hessian[(k, k)] += t / (x[k] * x[k]);
            }
            Self::Body(first) => {
                let inverse = inertia(x, first).to_pseudo_inertia().cholesky()?.inverse();
                let seen = |k: usize| inverse * Inertia::unit(k).to_pseudo_inertia();
                let seen: [_; INERTIAL_PARAMETERS] = from_each(seen);
                for i in 0..INERTIAL_PARAMETERS {
                    gradient[first + i] -= t * seen[i].trace();
                    for k in 0..INERTIAL_PARAMETERS {
                        let both = seen[i].component_mul(&seen[k].transpose()).sum();
                        hessian[(first + i, first + k)] += t * both;
                    }
                }
            }
        }
        Some(())
    }
}

/// The inertia whose parameters begin at an index.
pub(super) fn inertia(unknowns: &DVector<f64>, first: usize) -> Inertia<f64> {
    Inertia::from_parameters(from_each(|i| unknowns[first + i]))
}

/// Lᵀ of a positive definite matrix L Lᵀ of any scale.
pub(super) fn root_transposed(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, Normal { scaled, lengths }) = (matrix.nrows(), Normal::new(matrix));
    let factor = scaled.cholesky().map(|factor| factor.l());
    let mut out = factor
        .unwrap_or_else(|| DMatrix::identity(n, n))
        .transpose();
    for (mut column, length) in out.column_iter_mut().zip(&lengths) {
        column *= *length;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    // One number: ½ (x − b)² over x ≥ 0 has its minimum at b or at 0.
    #[test]
    fn least_number_equals_its_closed_form() {
        for target in [2.0, -3.0] {
            let program = Program {
                map: DMatrix::from_element(1, 1, 1.0),
                target: DVector::from_element(1, target),
                metric: DMatrix::zeros(0, 1),
                nominal: DVector::zeros(1),
                cones: vec![Cone::NotNegative(0)],
            };
            let found = program.solve(1e-9);
            assert!(
                (found.x[0] - f64::max(target, 0.0)).abs() < 1e-4,
                "{target}"
            );
            let least = 0.5 * f64::min(target, 0.0).powi(2);
            let excess = program.cost(&found.x) - least;
            assert!(
                (0.0..=found.gap).contains(&excess) && found.gap <= 1e-9,
                "{excess}"
            );
        }
    }

    // The positive semidefinite matrix nearest to a diagonal one is that with its negative entries set to zero. Entries off the diagonal count twice there.
    #[test]
    fn nearest_body_equals_the_projection_to_the_cone() {
        let wanted = nalgebra::Matrix4::from_diagonal(&[0.3, -0.2, 0.1, 1.5].into());
        let entries = |own: &nalgebra::Matrix4<f64>| {
            let all = (0..4).flat_map(|i| (i..4).map(move |k| (i, k)));
            let scaled = all.map(|(i, k)| {
                own[(i, k)]
                    * if i == k {
                        1.0
                    } else {
                        std::f64::consts::SQRT_2
                    }
            });
            DVector::from_vec(scaled.collect::<Vec<_>>())
        };
        let columns: Vec<_> = (0..10)
            .map(|k| entries(&Inertia::unit(k).to_pseudo_inertia()))
            .collect();
        let start = Inertia::from_pseudo_inertia(&nalgebra::Matrix4::identity());
        let program = Program {
            map: DMatrix::from_columns(&columns),
            target: entries(&wanted),
            metric: DMatrix::zeros(0, 10),
            nominal: DVector::from_column_slice(&start.to_parameters()),
            cones: vec![Cone::Body(0)],
        };
        let found = program.solve(1e-10);
        let nearest = inertia(&found.x, 0).to_pseudo_inertia();
        let projected = nalgebra::Matrix4::from_diagonal(&[0.3, 0.0, 0.1, 1.5].into());
        assert!((nearest - projected).norm() < 1e-4, "{nearest}");
        let excess = program.cost(&found.x) - 0.5 * 0.2 * 0.2;
        assert!((0.0..=1e-10).contains(&excess), "{excess}");
    }
}
