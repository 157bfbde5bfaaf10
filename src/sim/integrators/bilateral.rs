//! Bilateral rows beside equations without symmetry.
//!
//! > N a − Gᵀ λ = f,  J a = r − R λ
//!
//! With S = J N⁻¹ Gᵀ + R, which is N⁻¹ seen from the rows and how they give way:  λ = S⁻¹ (r − J N⁻¹ f),  a = N⁻¹ f + N⁻¹ Gᵀ λ. Rows that follow
//! from those before them take no force, and neither do rows with an infinite R. Mostly the forces act along the rows: G = J.

#![expect(non_snake_case, reason = "S: monogram notation, see the conventions")]

use crate::scalar::{Linear, Scalar};
use crate::sim::integrators::tree_lu::TreeLu;

/// Pivot of S, relative to its diagonal entry, below which a row is redundant: well above rounding, and below the pivots of independent rows.
const REDUNDANT: f64 = 1e-10;

/// The same, relative to the largest diagonal entry: rows that nothing moves, as those across the plane of a linkage, are rounding, which S squares.
const NOISE: f64 = 1e-26;

/// N⁻¹ Gᵀ and the factors of S, without pivoting: S is close to symmetric and positive.
#[derive(Clone, Debug)]
pub(super) struct Bilateral<T> {
    nv: usize,
    /// J, row by row, `nv` numbers each.
    jacobian: Vec<T>,
    /// N⁻¹ Gᵀ, column by column.
    response: Vec<T>,
    /// Row by row: the factors below the diagonal, the remainder on and above it.
    factors: Vec<T>,
    /// Reciprocals of the diagonal after elimination; zero for redundant rows.
    reciprocals: Vec<T>,
    /// R.
    compliance: Vec<T>,
    /// λ of the last [`hold`](Self::hold).
    pub(super) forces: Vec<T>,
}

impl<T: Scalar> Bilateral<T> {
    /// Memory for so many rows.
    pub(super) fn new(rows: usize, nv: usize) -> Self {
        Self {
            nv,
            jacobian: Vec::with_capacity(rows * nv),
            response: Vec::with_capacity(rows * nv),
            factors: Vec::with_capacity(rows * rows),
            reciprocals: Vec::with_capacity(rows),
            compliance: Vec::with_capacity(rows),
            forces: Vec::with_capacity(rows),
        }
    }

    /// Number of rows.
    pub(super) fn count(&self) -> usize {
        self.reciprocals.len()
    }

    /// J, row by row.
    pub(super) fn jacobian(&self) -> &[T] {
        &self.jacobian
    }

    /// Finds a and the forces λ from N⁻¹ f; without rows, a stays.
    ///
    /// * `wanted` – r and R of each row
    pub(super) fn hold(
        &mut self,
        factor: &TreeLu<T>,
        jacobian: &[T],
        wanted: impl Iterator<Item = (T, T)>,
        a: &mut [T],
    ) {
        let mut forces = std::mem::take(&mut self.forces);
        forces.clear();
        self.compliance.clear();
        for (r, compliance) in wanted {
            forces.push(r);
            self.compliance.push(compliance);
        }
        self.factorize(factor, jacobian, jacobian);
        self.solve(a, &mut forces);
        self.forces = forces;
    }

    /// Takes the factors of N, J, and G, each row by row.
    pub(super) fn factorize(&mut self, factor: &TreeLu<T>, jacobian: &[T], along: &[T]) {
        let (nv, n) = (self.nv.max(1), jacobian.len() / self.nv.max(1));
        self.jacobian.clear();
        self.jacobian.extend_from_slice(jacobian);
        self.response.clear();
        self.response.extend_from_slice(along);
        for column in self.response.chunks_exact_mut(nv) {
            factor.solve(column);
        }
        self.factors.clear();
        for row in jacobian.chunks_exact(nv) {
            let columns = self.response.chunks_exact(nv);
            self.factors.extend(columns.map(|x| product(row, x)));
        }
        let sizes = (0..n).map(|k| self.factors[k * (n + 1)].abs());
        let noise = sizes.fold(T::zero(), T::max) * NOISE + f64::MIN_POSITIVE;
        for (k, &compliance) in self.compliance.iter().take(n).enumerate() {
            self.factors[k * (n + 1)] += compliance;
        }
        self.reciprocals.clear();
        self.reciprocals.resize(n, T::zero());
        self.eliminate(noise);
    }

    /// S = L U
    ///
    /// * `noise` – bound of a pivot that is rounding only
    fn eliminate(&mut self, noise: T) {
        let n = self.count();
        let S = &mut self.factors;
        // The reciprocals contain the original diagonal until they are computed.
        (0..n).for_each(|k| self.reciprocals[k] = S[k * (n + 1)]);
        for k in 0..n {
            let (left, one) = (S[k * (n + 1)], T::one());
            let least = self.reciprocals[k].abs() * REDUNDANT + noise;
            let size = left.abs();
            let reciprocal = one / size.select_lt(least, one, left);
            self.reciprocals[k] = size.select_lt(least, T::zero(), reciprocal);
            for i in k + 1..n {
                let ratio = S[i * n + k] * self.reciprocals[k];
                S[i * n + k] = ratio;
                for j in k + 1..n {
                    let product = ratio * S[k * n + j];
                    S[i * n + j] -= product;
                }
            }
        }
    }

    /// Solves in place: N⁻¹ f becomes a, and r becomes λ. Over lanes, for several right-hand sides.
    pub(super) fn solve<S: Linear<T>>(&self, a: &mut [S], rows: &mut [S]) {
        let (nv, n) = (self.nv.max(1), self.count());
        for (r, jacobian) in rows.iter_mut().zip(self.jacobian.chunks_exact(nv)) {
            for (&a, &entry) in a.iter().zip(jacobian) {
                *r = (-a).times_plus(entry, *r);
            }
        }
        for i in 0..n {
            for k in 0..i {
                rows[i] = (-rows[k]).times_plus(self.factors[i * n + k], rows[i]);
            }
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                rows[i] = (-rows[k]).times_plus(self.factors[i * n + k], rows[i]);
            }
            rows[i] = rows[i] * self.reciprocals[i];
        }
        for (&force, response) in rows.iter().zip(self.response.chunks_exact(nv)) {
            for (a, &response) in a.iter_mut().zip(response) {
                *a = force.times_plus(response, *a);
            }
        }
    }

    /// The transpose of [`solve`](Self::solve), from weights of a and λ: those of a become those of N⁻¹ f, of which those of f follow by N⁻ᵀ, those of λ
    /// become those of r.
    ///
    /// * `a` – weights g of a; on return  g − Jᵀ ρ
    /// * `rows` – weights h of λ; on return  ρ = S⁻ᵀ (h + G N⁻ᵀ g), the weights of r
    pub(super) fn solve_transposed(&self, a: &mut [T], rows: &mut [T]) {
        let (nv, n) = (self.nv.max(1), self.count());
        for (weight, response) in rows.iter_mut().zip(self.response.chunks_exact(nv)) {
            *weight += product(response, a);
        }
        for i in 0..n {
            for k in 0..i {
                rows[i] = (-rows[k]).mul_add(self.factors[k * n + i], rows[i]);
            }
            rows[i] *= self.reciprocals[i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                rows[i] = (-rows[k]).mul_add(self.factors[k * n + i], rows[i]);
            }
        }
        for (&weight, jacobian) in rows.iter().zip(self.jacobian.chunks_exact(nv)) {
            for (a, &entry) in a.iter_mut().zip(jacobian) {
                *a = (-weight).mul_add(entry, *a);
            }
        }
    }
}

fn product<T: Scalar>(x: &[T], y: &[T]) -> T {
    let pairs = x.iter().zip(y);
    pairs.fold(T::zero(), |sum, (&x, &y)| x.mul_add(y, sum))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{coriolis_matrix, mass_matrix};
    use crate::model::samples;
    use crate::tests::OTHER_ALGORITHM;
    use nalgebra::{DMatrix, DVector};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    // The third row is the sum of the two before it: the equations hold, and it takes no force.
    #[test]
    fn solutions_obey_both_equations_also_with_redundant_rows() {
        for seed in 0..20 {
            let model = samples::random_tree(8 + seed as usize % 5, seed);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let q = model.random_configuration(&mut rng);
            let v = model.random_velocity(&mut rng, 3.0);
            let c = coriolis_matrix(&model, q.as_slice(), v.as_slice());
            let N = mass_matrix(&model, q.as_slice()) + c * 0.05;
            let mut lu = TreeLu::new(&model);
            lu.factorize(|i, j| N[(i, j)]);
            let nv = model.nv();
            let mut J = DMatrix::from_fn(4, nv, |_, _| model.random_velocity(&mut rng, 1.0)[0]);
            let sum = J.row(0) + J.row(1);
            J.set_row(2, &sum);
            let f = model.random_velocity(&mut rng, 1.0);
            let mut r = DVector::from_vec(vec![0.3, -0.2, 0.1, 0.7]);
            let wanted = r.clone();
            let mut bilateral = Bilateral::new(4, nv);
            let rows = J.transpose();
            bilateral.factorize(&lu, rows.as_slice(), rows.as_slice());
            let mut a = f.clone();
            lu.solve(a.as_mut_slice());
            bilateral.solve(a.as_mut_slice(), r.as_mut_slice());
            let scale = a.amax().max(1.0);
            assert!(
                (&J * &a - wanted).amax() < OTHER_ALGORITHM * scale,
                "tree {seed}"
            );
            let balance = &N * &a - J.transpose() * &r - &f;
            assert!(balance.amax() < 1e-8 * scale, "tree {seed}: {balance}");
            assert_eq!(r[2], 0.0, "tree {seed}");
        }
    }

    // J a = r − R λ; a row with an infinite R takes no force, as if it were not there.
    #[test]
    fn rows_that_give_way_obey_their_compliance() {
        let model = samples::random_tree(8, 3);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let q = model.random_configuration(&mut rng);
        let N = mass_matrix(&model, q.as_slice());
        let mut lu = TreeLu::new(&model);
        lu.factorize(|i, j| N[(i, j)]);
        let nv = model.nv();
        let J = DMatrix::from_fn(3, nv, |_, _| model.random_velocity(&mut rng, 1.0)[0]);
        let mut a = model.random_velocity(&mut rng, 1.0);
        let f = &N * &a;
        let R = [0.0, 0.7, f64::INFINITY];
        let r = [0.3, -0.2, 0.1];
        let mut bilateral = Bilateral::new(3, nv);
        let wanted = r.into_iter().zip(R);
        bilateral.hold(&lu, J.transpose().as_slice(), wanted, a.as_mut_slice());
        let forces = DVector::from_column_slice(&bilateral.forces);
        assert_eq!(forces[2], 0.0);
        for k in 0..2 {
            let error = (J.row(k) * &a)[0] - r[k] + R[k] * forces[k];
            assert!(error.abs() < OTHER_ALGORITHM, "row {k}: {error:e}");
        }
        assert!((&N * &a - J.transpose() * &forces - f).amax() < OTHER_ALGORITHM);
    }
}
