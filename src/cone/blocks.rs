//! A matrix G = Xᵀ X whose factor has few blocks: rows act on few nodes, as those of a contact act on two bodies.
//!
//! The cost of products is the number of entries of the blocks, and Newton's matrices become those of the nodes: with ∂f = −B⁻¹ (e + `E_y` Xᵀ δz) and δz = X δf,
//!
//! > (1 + X B⁻¹ `E_y` Xᵀ) δz = −X B⁻¹ e,
//!
//! as sparse as the nodes are connected by units. [Castro, Permenter & Han 2022] for the velocities as unknowns.

use super::block_factor::{BlockFactor, OF_BODIES};
use super::jacobian::Square;
use super::system::Unit;
use crate::nested::IntoNested;
use crate::scalar::from_each;
use std::ops::Range;

/// X of a problem, row after row: the entries of each in the nodes on which it acts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Columns {
    /// Index of the first coordinate of each node, and one past the last.
    starts: Vec<usize>,
    /// Parts of each row.
    rows: Vec<Range<usize>>,
    parts: Vec<Part>,
    values: Vec<f64>,
}

/// Entries of a row in a node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    node: usize,
    /// Index of the first value.
    at: usize,
}

impl Columns {
    /// Starts with no rows.
    ///
    /// * `sizes` – coordinates of each node
    pub(crate) fn start(&mut self, sizes: impl Iterator<Item = usize>) {
        self.starts.clear();
        self.starts.push(0);
        let mut end = 0;
        self.starts.extend(sizes.map(|size| {
            end += size;
            end
        }));
        self.rows.clear();
        self.parts.clear();
        self.values.clear();
    }

    /// Takes over another X, in the memory there is.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.starts.clone_from(&other.starts);
        self.rows.clone_from(&other.rows);
        self.parts.clone_from(&other.parts);
        self.values.clone_from(&other.values);
    }

    /// Adds a row without entries.
    pub(crate) fn push_row(&mut self) {
        self.rows.push(self.parts.len()..self.parts.len());
    }

    /// Adds the entries of the last row in a node.
    pub(crate) fn push_part(&mut self, node: usize, values: impl Iterator<Item = f64>) {
        let at = self.values.len();
        self.values.extend(values);
        self.parts.push(Part { node, at });
        if let Some(row) = self.rows.last_mut() {
            row.end = self.parts.len();
        }
    }

    fn range(&self, node: usize) -> Range<usize> {
        self.starts[node]..self.starts[node + 1]
    }

    fn n_nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// Coordinates of all nodes.
    pub(super) fn n_coordinates(&self) -> usize {
        self.starts[self.n_nodes()]
    }

    /// The nodes on which a row acts, with its entries there.
    fn parts(&self, row: usize) -> impl Iterator<Item = (usize, &[f64])> {
        self.parts[self.rows[row].clone()].iter().map(|part| {
            let size = self.starts[part.node + 1] - self.starts[part.node];
            (part.node, &self.values[part.at..part.at + size])
        })
    }

    /// `G_ii`.
    pub(super) fn diagonal(&self, row: usize) -> f64 {
        let all = self.parts(row).nested(|(_, values)| values);
        all.map(|x| x * x).sum()
    }

    /// Multiplies a row.
    pub(super) fn scale(&mut self, row: usize, by: f64) {
        for part in &self.parts[self.rows[row].clone()] {
            let size = self.starts[part.node + 1] - self.starts[part.node];
            let values = &mut self.values[part.at..part.at + size];
            values.iter_mut().for_each(|x| *x *= by);
        }
    }

    /// z ← z + X f of one row.
    fn add_row(&self, row: usize, f: f64, z: &mut [f64]) {
        for (node, values) in self.parts(row) {
            let z = z[self.range(node)].iter_mut().zip(values);
            z.for_each(|(z, x)| *z += x * f);
        }
    }

    /// z ← X f.
    pub(super) fn times(&self, f: &[f64], z: &mut [f64]) {
        z.fill(0.0);
        for (row, &f) in f.iter().enumerate().filter(|(_, f)| **f != 0.0) {
            self.add_row(row, f, z);
        }
    }

    /// Xᵀ z of a row.
    pub(super) fn dot(&self, row: usize, z: &[f64]) -> f64 {
        let parts = self.parts(row);
        let products = parts.map(|(node, values)| {
            let z = &z[self.range(node)];
            values.iter().zip(z).map(|(x, z)| x * z).sum::<f64>()
        });
        products.sum()
    }

    /// Xᵀ z of the rows of a unit.
    pub(super) fn along(&self, unit: &Unit, z: &[f64]) -> [f64; 3] {
        let mut out = [0.0; 3];
        for (i, out) in out.iter_mut().enumerate().take(unit.rows()) {
            *out = self.dot(unit.row + i, z);
        }
        out
    }
}

/// X of a system, with working memory and the factors of its Newton's matrix.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    pub(super) columns: Columns,
    /// R, scaled, and the added regularisation.
    pub(super) diagonal: Vec<f64>,
    factor: BlockFactor,
    pub(super) z: Vec<f64>,
    /// H Xᵀ of a unit in a node.
    product: Vec<f64>,
}

impl Blocks {
    /// X = 0, R = 1.
    pub(super) fn blank(&mut self) {
        self.columns.values.fill(0.0);
        self.diagonal.fill(1.0);
    }

    /// y ← Xᵀ X f + R f + g.
    pub(super) fn velocities(&mut self, f: &[f64], g: &[f64], y: &mut [f64]) {
        self.z.resize(self.columns.n_coordinates(), 0.0);
        self.columns.times(f, &mut self.z);
        for (row, y) in y.iter_mut().enumerate() {
            *y = self.columns.dot(row, &self.z) + self.diagonal[row] * f[row] + g[row];
        }
    }

    /// Prepares for the nodes that units connect, with an order in which few blocks fill.
    pub(super) fn connect(&mut self, units: &[Unit]) {
        let columns = &self.columns;
        let nodes = 0..columns.n_nodes();
        (self.factor).start(nodes.map(|node| columns.range(node).len()));
        for unit in units.iter().filter(|unit| !unit.absent) {
            for row in unit.row..unit.row + unit.rows() {
                for (a, _) in columns.parts(row) {
                    for (b, _) in columns.parts(unit.row).filter(|(b, _)| *b != a) {
                        self.factor.connect(a, b);
                    }
                }
            }
        }
        self.factor.order();
    }

    /// Factorises 1 + X H Xᵀ.
    ///
    /// * `slopes` – H of each unit, none of those without
    pub(super) fn factorize(
        &mut self,
        units: &[Unit],
        mut slopes: impl FnMut(usize) -> Option<Square>,
    ) {
        self.factor.fill_identity();
        for (k, unit) in units.iter().enumerate() {
            if let Some(h) = slopes(k) {
                self.add(unit, &h);
            }
        }
        self.factor.factorize();
    }

    /// Adds X H Xᵀ of a unit.
    fn add(&mut self, unit: &Unit, h: &Square) {
        if self.is_of_bodies(unit) {
            return self.add_of_bodies(unit, h);
        }
        let (rows, columns) = (unit.rows(), &self.columns);
        for b in 0..columns.rows[unit.row].len() {
            let part = |row: usize| {
                let part = columns.parts[columns.rows[unit.row + row].start + b];
                &columns.values[part.at..][..columns.range(part.node).len()]
            };
            let node = columns.parts[columns.rows[unit.row].start + b].node;
            self.product.clear();
            for h in &h[..rows] {
                let first = part(0).iter().map(|x| h[0] * x);
                let start = self.product.len();
                self.product.extend(first);
                for (j, h) in h.iter().enumerate().take(rows).skip(1) {
                    let own = self.product[start..].iter_mut().zip(part(j));
                    own.for_each(|(own, x)| *own += h * x);
                }
            }
            for (a, _) in columns.parts(unit.row) {
                let out = self.factor.block_mut(a, node);
                let width = columns.range(node).len();
                for i in 0..rows {
                    let values = columns.parts(unit.row + i).find(|(other, _)| *other == a);
                    let product = &self.product[width * i..width * (i + 1)];
                    for (k, x) in values.iter().nested(|(_, values)| *values).enumerate() {
                        let out = out[width * k..width * (k + 1)].iter_mut().zip(product);
                        out.for_each(|(out, p)| *out += x * p);
                    }
                }
            }
        }
    }

    /// Whether a unit has three rows on the same free bodies.
    fn is_of_bodies(&self, unit: &Unit) -> bool {
        let columns = &self.columns;
        let first = &columns.parts[columns.rows[unit.row].clone()];
        let is_of_same = |row: usize| {
            let own = &columns.parts[columns.rows[row].clone()];
            let nodes = own.iter().zip(first);
            own.len() == first.len() && nodes.fold(true, |same, (a, b)| same && a.node == b.node)
        };
        let is_body = |part: &Part| columns.range(part.node).len() == OF_BODIES;
        unit.rows() == 3
            && first.iter().all(is_body)
            && is_of_same(unit.row + 1)
            && is_of_same(unit.row + 2)
    }

    /// [`add`](Self::add) of three rows on the same free bodies, whose products are unrolled.
    fn add_of_bodies(&mut self, unit: &Unit, h: &Square) {
        let columns = &self.columns;
        let parts = |row: usize| &columns.parts[columns.rows[unit.row + row].clone()];
        let entries = |part: &Part| -> [f64; OF_BODIES] {
            let values = &columns.values[part.at..part.at + OF_BODIES];
            from_each(|k| values[k])
        };
        let all = parts(0).iter().zip(parts(1)).zip(parts(2));
        let of_node = all.map(|((a, b), c)| (a.node, [a, b, c].map(entries)));
        for (b, x) in of_node.clone() {
            let product: [[f64; OF_BODIES]; 3] = from_each(|i| {
                from_each(|j| h[i][0] * x[0][j] + h[i][1] * x[1][j] + h[i][2] * x[2][j])
            });
            for (a, x) in of_node.clone() {
                let (rows, _) = (self.factor.block_mut(a, b)).as_chunks_mut::<OF_BODIES>();
                for (k, row) in rows.iter_mut().enumerate() {
                    for i in 0..3 {
                        for j in 0..OF_BODIES {
                            row[j] += x[i][k] * product[i][j];
                        }
                    }
                }
            }
        }
    }

    /// x ← (1 + X H Xᵀ)⁻¹ x.
    pub(super) fn solve(&self, x: &mut [f64]) {
        self.factor.solve(x, &self.columns.starts);
    }

    /// z ← z + X f of a unit.
    pub(super) fn add_unit(&self, unit: &Unit, f: [f64; 3], z: &mut [f64]) {
        for (i, f) in f.into_iter().enumerate().take(unit.rows()) {
            self.columns.add_row(unit.row + i, f, z);
        }
    }
}

/// The inverse of a matrix, of which so many rows count.
pub(super) fn inverse(b: &Square, rows: usize) -> Square {
    if rows == 1 {
        return [[1.0 / b[0][0], 0.0, 0.0], [0.0; 3], [0.0; 3]];
    }
    let minor = |i: usize, j: usize| {
        let (r, s) = ((i + 1) % 3, (i + 2) % 3);
        let (u, v) = ((j + 1) % 3, (j + 2) % 3);
        b[r][u] * b[s][v] - b[r][v] * b[s][u]
    };
    let determinant: f64 = (0..3).map(|j| b[0][j] * minor(0, j)).sum();
    from_each(|i| from_each(|j| minor(j, i) / determinant))
}
