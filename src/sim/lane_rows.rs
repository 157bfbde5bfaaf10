//! X and G of the rows of lanes, row by row along the coordinates on which each acts: those of a contact point are between its body and the world, and the other
//! numbers of J, and of X with Lᵀ X = Jᵀ, are zero.
//!
//! The sums are those with the zeros, in their order, so the bits are the same. A single number has vector registers for several rows side by side instead.

use std::ops::Range;

use crate::dynamics::MassMatrixFactor;
use crate::scalar::{Scalar, plus_scaled};

/// Most rows in a bundle: those of a contact point.
const MOST: usize = 3;

/// Rows that were added together, and act along the same coordinates.
#[derive(Clone, Debug)]
struct Bundle {
    rows: Range<usize>,
    /// Their coordinates, ascending, in the list of all.
    coordinates: Range<usize>,
    /// Whether these are one coordinate with all of its ancestors; otherwise they are all that there are.
    is_path: bool,
    /// Where X begins: coordinate after coordinate the numbers of all rows.
    x: usize,
}

/// Numbers of all rows along their coordinates.
#[derive(Clone, Debug)]
pub(super) struct LaneRows<T> {
    nv: usize,
    /// At last τ beside the rows.
    bundles: Vec<Bundle>,
    /// Whether each coordinate has an entry in the rows of each bundle.
    marks: Vec<bool>,
    coordinates: Vec<usize>,
    /// X of all bundles.
    x: Vec<T>,
    /// D⁻¹ X of one row.
    scaled: Vec<T>,
}

impl<T: Scalar> LaneRows<T> {
    /// Memory for so many rows of so many coordinates; none for a single number.
    pub(super) fn new(nv: usize, rows: usize) -> Self {
        let rows = if T::LANES > 1 { rows + 1 } else { 0 };
        Self {
            nv,
            bundles: Vec::with_capacity(rows),
            marks: Vec::with_capacity(nv * rows),
            coordinates: Vec::with_capacity(nv * rows),
            x: Vec::with_capacity(nv * rows),
            scaled: Vec::with_capacity(if rows > 0 { nv } else { 0 }),
        }
    }

    /// Takes back all rows from one on, and τ.
    pub(super) fn truncate(&mut self, rows: usize) {
        self.bundles.retain(|bundle| bundle.rows.end <= rows);
        self.marks.truncate(self.nv * self.bundles.len());
    }

    /// Adds a few rows. Returns the marks of their coordinates, none for a single number.
    pub(super) fn grow(&mut self, rows: Range<usize>) -> &mut [bool] {
        if const { T::LANES == 1 } {
            return &mut [];
        }
        assert!(rows.len() <= MOST, "a bundle of {} rows", rows.len());
        self.bundles.push(Bundle {
            rows,
            coordinates: 0..0,
            is_path: false,
            x: 0,
        });
        let start = self.marks.len();
        self.marks.resize(start + self.nv, false);
        &mut self.marks[start..]
    }

    /// Finds X, and hands G and J M⁻¹ τ to `store(row, column, number)`: on and below the diagonal, τ after the last row.
    ///
    /// * `jacobian` – J of so many rows, row by row
    pub(super) fn form(
        &mut self,
        factor: &MassMatrixFactor<T>,
        (count, jacobian): (usize, &[T]),
        tau: &[T],
        store: impl FnMut(usize, usize, T),
    ) {
        self.truncate(count);
        self.grow(count..count + 1).fill(true);
        self.find_coordinates(factor);
        T::vectorized(
            #[inline(always)]
            || {
                self.substitute(factor, count, jacobian, tau);
                self.multiply(factor, store);
            },
        );
    }

    /// The coordinates of each bundle: those with an entry, and all of their ancestors.
    fn find_coordinates(&mut self, factor: &MassMatrixFactor<T>) {
        let (nv, coordinates) = (self.nv, &mut self.coordinates);
        coordinates.clear();
        for (at, bundle) in self.bundles.iter_mut().enumerate() {
            let marks = &mut self.marks[nv * at..nv * (at + 1)];
            for k in (0..nv).rev() {
                if let (true, Some(ancestor)) = (marks[k], factor.nearest_ancestor(k)) {
                    marks[ancestor] = true;
                }
            }
            let first = coordinates.len();
            coordinates.extend((0..nv).filter(|&k| marks[k]));
            bundle.is_path = is_path(factor, &coordinates[first..]);
            if !bundle.is_path {
                coordinates.truncate(first);
                coordinates.extend(0..nv);
            }
            bundle.coordinates = first..coordinates.len();
        }
    }

    /// X with Lᵀ X = (Jᵀ, τ).
    #[inline(always)]
    fn substitute(
        &mut self,
        factor: &MassMatrixFactor<T>,
        count: usize,
        jacobian: &[T],
        tau: &[T],
    ) {
        let (nv, x) = (self.nv, &mut self.x);
        x.clear();
        for bundle in &mut self.bundles {
            let own = &self.coordinates[bundle.coordinates.clone()];
            bundle.x = x.len();
            for &k in own {
                for row in bundle.rows.clone() {
                    x.push(if row < count {
                        jacobian[nv * row + k]
                    } else {
                        tau[k]
                    });
                }
            }
            let x = &mut x[bundle.x..];
            match bundle.rows.len() {
                1 => factor.back_substitute_along(own, x.as_chunks_mut::<1>().0),
                2 => factor.back_substitute_along(own, x.as_chunks_mut::<2>().0),
                _ => factor.back_substitute_along(own, x.as_chunks_mut::<MOST>().0),
            }
        }
    }

    /// Xᵀ D⁻¹ X, column by column.
    #[inline(always)]
    fn multiply(&mut self, factor: &MassMatrixFactor<T>, mut store: impl FnMut(usize, usize, T)) {
        let Some((_, bundles)) = self.bundles.split_last() else {
            return;
        };
        let scaled = &mut self.scaled;
        for (at, bundle) in bundles.iter().enumerate() {
            let own = bundle.along(&self.coordinates, &self.x);
            for column in bundle.rows.clone() {
                own.scale(column - bundle.rows.start, factor, scaled);
                for other in &self.bundles[at..] {
                    let along = other.along(&self.coordinates, &self.x);
                    let mut store = |row: usize, product| {
                        if other.rows.start + row >= column {
                            store(other.rows.start + row, column, product);
                        }
                    };
                    match along.n {
                        1 => own.each_product::<1>(scaled, &along, &mut store),
                        2 => own.each_product::<2>(scaled, &along, &mut store),
                        _ => own.each_product::<MOST>(scaled, &along, &mut store),
                    }
                }
            }
        }
    }

    /// a += X (f, 1), one row after the other: a row without a force, which a lane has for the sake of others, changes no bit of the sum.
    #[inline(always)]
    pub(super) fn push(&self, f: &[T], a: &mut [T]) {
        for bundle in &self.bundles {
            let Along {
                coordinates, n, x, ..
            } = bundle.along(&self.coordinates, &self.x);
            for (at, row) in bundle.rows.clone().enumerate() {
                let force = f.get(row).copied().unwrap_or(T::one());
                for (i, &k) in coordinates.iter().enumerate() {
                    a[k] = x[n * i + at].mul_add(force, a[k]);
                }
            }
        }
    }
}

/// X of a bundle, with its coordinates.
#[derive(Clone, Copy)]
struct Along<'a, T> {
    coordinates: &'a [usize],
    is_path: bool,
    /// Number of rows.
    n: usize,
    x: &'a [T],
}

impl Bundle {
    #[inline(always)]
    fn along<'a, T>(&self, coordinates: &'a [usize], x: &'a [T]) -> Along<'a, T> {
        let (coordinates, n) = (&coordinates[self.coordinates.clone()], self.rows.len());
        Along {
            coordinates,
            is_path: self.is_path,
            n,
            x: &x[self.x..][..n * coordinates.len()],
        }
    }
}

impl<T: Scalar> Along<'_, T> {
    /// D⁻¹ X of one of the rows.
    #[inline(always)]
    fn scale(&self, row: usize, factor: &MassMatrixFactor<T>, out: &mut Vec<T>) {
        out.clear();
        for (i, &k) in self.coordinates.iter().enumerate() {
            out.push(self.x[self.n * i + row] * factor.reciprocal(k));
        }
    }

    /// Hands the products of a row with those of another bundle to `each(row, product)`.
    #[inline(always)]
    fn each_product<const N: usize>(
        &self,
        scaled: &[T],
        other: &Self,
        each: &mut impl FnMut(usize, T),
    ) {
        let (mut sum, x) = ([T::zero(); N], other.x.as_chunks::<N>().0);
        match (self.is_path, other.is_path) {
            // Two ways to the world are one from where they meet.
            (true, true) => {
                let pairs = self.coordinates.iter().zip(other.coordinates);
                let n = pairs.take_while(|(a, b)| a == b).count();
                let (scaled, x) = (&scaled[..n], &x[..n]);
                for i in 0..n {
                    sum = plus_scaled(&sum, scaled[i], &x[i]);
                }
            }
            (_, false) => {
                for (i, &k) in self.coordinates.iter().enumerate() {
                    sum = plus_scaled(&sum, scaled[i], &x[k]);
                }
            }
            (false, true) => {
                for (i, &k) in other.coordinates.iter().enumerate() {
                    sum = plus_scaled(&sum, scaled[k], &x[i]);
                }
            }
        }
        for row in 0..N {
            each(row, sum[row]);
        }
    }
}

/// Whether coordinates are one with all of its ancestors.
fn is_path<T: Scalar>(factor: &MassMatrixFactor<T>, coordinates: &[usize]) -> bool {
    let mut before = None;
    coordinates.iter().all(|&k| {
        let follows = factor.nearest_ancestor(k) == before;
        before = Some(k);
        follows
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::mass_matrix;
    use crate::model::Model;
    use crate::scalar::Lanes;
    use nalgebra::DMatrix;

    /// A foot, the joint of another leg, and a row along all coordinates, against M⁻¹.
    #[test]
    fn products_are_those_of_the_inverse_mass_matrix() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadruped.urdf");
        let model = Model::from_urdf_file(path).expect("an asset");
        let (nv, q) = (model.nv(), model.neutral());
        let mass = mass_matrix(&model, q.as_slice());
        let wide = mass.map(Lanes::<2>::constant);
        let factor = MassMatrixFactor::new(&model, &wide);
        let supports: [&[usize]; 3] = [&[0, 1, 2, 3, 4, 5, 9, 10, 11], &[7], &[4, 8, 17]];
        let (mut rows, mut jacobian) = (LaneRows::new(nv, 5), DMatrix::zeros(6, nv));
        for (bundle, support) in supports.into_iter().enumerate() {
            let marks = rows.grow(2 * bundle..2 * bundle + 2);
            support.iter().for_each(|&k| marks[k] = true);
            for (row, &k) in
                (2 * bundle..2 * bundle + 2).flat_map(|row| support.iter().map(move |k| (row, k)))
            {
                jacobian[(row, k)] = ((3 * row + k) as f64).sin();
            }
        }
        let tau: Vec<f64> = (0..nv).map(|k| (k as f64).cos()).collect();
        let wide = |x: &f64| Lanes::<2>::constant(*x);
        let flat: Vec<_> = jacobian.transpose().iter().map(wide).collect();
        let wide_tau: Vec<_> = tau.iter().map(wide).collect();
        let mut found = DMatrix::zeros(7, 6);
        rows.form(
            &factor,
            (6, &flat),
            &wide_tau,
            |row, column, x: Lanes<2>| {
                found[(row, column)] = x.value(1);
            },
        );
        let inverse = mass.try_inverse().expect("a mass matrix");
        let expected = &jacobian * &inverse * jacobian.transpose();
        let beside = &jacobian * &inverse * nalgebra::DVector::from_vec(tau);
        for column in 0..6 {
            for row in column..6 {
                let error = found[(row, column)] - expected[(row, column)];
                assert!(error.abs() < 1e-9 * expected.amax(), "{row}, {column}");
            }
            let error: f64 = found[(6, column)] - beside[column];
            assert!(error.abs() < 1e-9 * beside.amax(), "{column}");
        }
    }
}
