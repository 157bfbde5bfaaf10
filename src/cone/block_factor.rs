//! LU factors of a matrix by blocks, whose pattern is symmetric: of the nodes of a graph and its edges.
//!
//! Nodes are eliminated in an order of least degree, so that few blocks fill [Davis 2006, chapter 7]. Within a node there is pivoting, between nodes none:
//! the matrices here are the identity plus the terms of laws with monotone derivatives.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use crate::scalar::vectorized;

/// The size of the blocks of free bodies, whose products are unrolled.
pub(super) const OF_BODIES: usize = 6;

/// The factors, and the graph.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockFactor {
    /// Coordinates of each node.
    sizes: Vec<usize>,
    /// Place of each node in the order of elimination, and the node at each place.
    places: Vec<usize>,
    nodes: Vec<usize>,
    /// Neighbours of each node, later ones alone once it is eliminated; sorted.
    neighbours: Vec<Vec<usize>>,
    /// By places: the later ones with which it has blocks, sorted, and the coordinates before each of these.
    later: Vec<Vec<(usize, usize)>>,
    /// Index of the first entry of each place: its own block, those above the diagonal, those below.
    starts: Vec<usize>,
    values: Vec<f64>,
    /// Exchanges of rows in the blocks on the diagonal.
    pivots: Vec<usize>,
    first_pivots: Vec<usize>,
    merged: Vec<usize>,
    union: Vec<usize>,
    /// Nodes with their degrees, those of the least degree first, and of these the first.
    waiting: BinaryHeap<Reverse<(usize, usize)>>,
}

impl BlockFactor {
    /// Starts with nodes without edges.
    pub(super) fn start(&mut self, sizes: impl Iterator<Item = usize>) {
        self.sizes.clear();
        self.sizes.extend(sizes);
        let n = self.sizes.len();
        self.neighbours
            .resize_with(n.max(self.neighbours.len()), Vec::new);
        self.neighbours.iter_mut().for_each(Vec::clear);
        self.later.resize_with(n.max(self.later.len()), Vec::new);
        self.later.iter_mut().for_each(Vec::clear);
    }

    /// Adds an edge, once however often it comes.
    pub(super) fn connect(&mut self, a: usize, b: usize) {
        let own = &mut self.neighbours[a];
        if let Err(at) = own.binary_search(&b) {
            own.insert(at, b);
        }
    }

    /// Finds the order and where blocks fill.
    pub(super) fn order(&mut self) {
        let n = self.sizes.len();
        self.places.clear();
        self.places.resize(n, usize::MAX);
        self.nodes.clear();
        self.waiting.clear();
        let degrees = self.neighbours[..n].iter().map(Vec::len).enumerate();
        (self.waiting).extend(degrees.map(|(node, degree)| Reverse((degree, node))));
        while let Some(Reverse((degree, node))) = self.waiting.pop() {
            // Nodes wait once for each degree that they have had.
            let is_last = self.neighbours[node].len() == degree;
            if is_last && self.places[node] == usize::MAX {
                self.places[node] = self.nodes.len();
                self.nodes.push(node);
                self.eliminate_node(node);
            }
        }
        self.place_blocks();
    }

    /// Connects the neighbours of a node with each other, and no more with it.
    fn eliminate_node(&mut self, node: usize) {
        let mut merged = std::mem::take(&mut self.merged);
        merged.clone_from(&self.neighbours[node]);
        for &other in &merged {
            let (own, union) = (&mut self.neighbours[other], &mut self.union);
            union.clear();
            union.extend(own.iter().chain(&merged).copied());
            union.sort_unstable();
            union.dedup();
            own.clear();
            own.extend(union.iter().filter(|&&k| k != other && k != node));
            self.waiting.push(Reverse((own.len(), other)));
        }
        self.merged = merged;
    }

    fn place_blocks(&mut self) {
        self.starts.clear();
        self.first_pivots.clear();
        let (mut at, mut pivots) = (0, 0);
        for place in 0..self.nodes.len() {
            let node = self.nodes[place];
            let size = self.sizes[node];
            let later = &mut self.later[place];
            later.extend(self.neighbours[node].iter().map(|&k| (self.places[k], 0)));
            later.sort_unstable();
            let mut width = 0;
            for (other, before) in later {
                *before = width;
                width += self.sizes[self.nodes[*other]];
            }
            self.starts.push(at);
            self.first_pivots.push(pivots);
            at += size * (size + 2 * width);
            pivots += size;
        }
        self.starts.push(at);
        self.values.clear();
        self.values.resize(at, 0.0);
        self.pivots.resize(pivots, 0);
    }

    fn size(&self, place: usize) -> usize {
        self.sizes[self.nodes[place]]
    }

    /// Coordinates of all later places with which one has blocks.
    fn width(&self, place: usize) -> usize {
        let last = self.later[place].last();
        last.map_or(0, |&(other, before)| before + self.size(other))
    }

    /// Writes the identity.
    pub(super) fn fill_identity(&mut self) {
        self.values.fill(0.0);
        for place in 0..self.nodes.len() {
            let size = self.size(place);
            let own = &mut self.values[self.starts[place]..][..size * size];
            own.iter_mut().step_by(size + 1).for_each(|x| *x = 1.0);
        }
    }

    /// The block of two nodes that are connected, by rows.
    pub(super) fn block_mut(&mut self, a: usize, b: usize) -> &mut [f64] {
        let (row, column) = (self.places[a], self.places[b]);
        let range = if row == column {
            let size = self.sizes[a];
            self.starts[row]..self.starts[row] + size * size
        } else if row < column {
            self.above(row, self.find(row, column))
        } else {
            self.below(column, self.find(column, row))
        };
        &mut self.values[range]
    }

    /// Index among the later ones of a place.
    fn find(&self, place: usize, other: usize) -> usize {
        self.later[place].partition_point(|&(k, _)| k < other)
    }

    /// Numbers of the block of a place, in its rows, with one of its later ones.
    fn above(&self, place: usize, index: usize) -> Range<usize> {
        let (other, before) = self.later[place][index];
        let size = self.size(place);
        let start = self.starts[place] + size * (size + before);
        start..start + size * self.size(other)
    }

    /// Numbers of the block of a place, in its columns, with one of its later ones.
    fn below(&self, place: usize, index: usize) -> Range<usize> {
        let shift = self.size(place) * self.width(place);
        let Range { start, end } = self.above(place, index);
        start + shift..end + shift
    }

    /// Factorises the matrix in the blocks, in place.
    pub(super) fn factorize(&mut self) {
        vectorized(
            #[inline(always)]
            || {
                for place in 0..self.nodes.len() {
                    self.eliminate(place);
                }
            },
        );
    }

    /// U ← D⁻¹ U in the rows of a place, and  A −= L U  in later ones.
    #[inline(always)]
    fn eliminate(&mut self, place: usize) {
        let size = self.size(place);
        let (values, later_values) = self.values.split_at_mut(self.starts[place + 1]);
        let own = &mut values[self.starts[place]..];
        let (diagonal, rest) = own.split_at_mut(size * size);
        let pivots = &mut self.pivots[self.first_pivots[place]..][..size];
        factorize_block(diagonal, pivots, size);
        let (above, below) = rest.split_at_mut(rest.len() / 2);
        let later = &self.later[place];
        for &(other, before) in later {
            let width = self.sizes[self.nodes[other]];
            let block = &mut above[size * before..size * (before + width)];
            solve_block(diagonal, pivots, size, block, width);
        }
        let base = self.starts[place + 1];
        for (index, &(i, before_i)) in later.iter().enumerate() {
            let n_i = self.sizes[self.nodes[i]];
            let range_i = size * before_i..size * (before_i + n_i);
            let (l_i, u_i) = (&below[range_i.clone()], &above[range_i]);
            let panel = &mut later_values[self.starts[i] - base..self.starts[i + 1] - base];
            let (own, rest) = panel.split_at_mut(n_i * n_i);
            subtract_product(own, l_i, u_i, [n_i, size, n_i]);
            let (above_i, below_i) = rest.split_at_mut(rest.len() / 2);
            let mut others = self.later[i].iter();
            for &(k, before_k) in &later[index + 1..] {
                let Some(&(_, at)) = others.by_ref().find(|(other, _)| *other == k) else {
                    continue;
                };
                let n_k = self.sizes[self.nodes[k]];
                let range_k = size * before_k..size * (before_k + n_k);
                let (l_k, u_k) = (&below[range_k.clone()], &above[range_k]);
                let to = n_i * at..n_i * (at + n_k);
                subtract_product(&mut above_i[to.clone()], l_i, u_k, [n_i, size, n_k]);
                subtract_product(&mut below_i[to], l_k, u_i, [n_k, size, n_i]);
            }
        }
    }

    /// x ← A⁻¹ x.
    ///
    /// * `starts` – index of the first coordinate of each node
    pub(super) fn solve(&self, x: &mut [f64], starts: &[usize]) {
        for place in 0..self.nodes.len() {
            let (node, size) = (self.nodes[place], self.size(place));
            let own = starts[node]..starts[node] + size;
            let diagonal = &self.values[self.starts[place]..][..size * size];
            let pivots = &self.pivots[self.first_pivots[place]..][..size];
            solve_block(diagonal, pivots, size, &mut x[own.clone()], 1);
            for (index, &(other, _)) in self.later[place].iter().enumerate() {
                let l = &self.values[self.below(place, index)];
                let to = starts[self.nodes[other]];
                for (i, row) in l.chunks_exact(size).enumerate() {
                    let products = row.iter().zip(&x[own.clone()]).map(|(l, x)| l * x);
                    x[to + i] -= products.sum::<f64>();
                }
            }
        }
        for place in (0..self.nodes.len()).rev() {
            let (node, size) = (self.nodes[place], self.size(place));
            for (index, &(other, _)) in self.later[place].iter().enumerate() {
                let u = &self.values[self.above(place, index)];
                let (from, width) = (starts[self.nodes[other]], self.size(other));
                for (i, row) in u.chunks_exact(width).enumerate().take(size) {
                    let products = row.iter().zip(&x[from..from + width]).map(|(u, x)| u * x);
                    x[starts[node] + i] -= products.sum::<f64>();
                }
            }
        }
    }
}

/// LU of a block by rows, in place, with exchanges of rows; reciprocals of pivots on the diagonal.
#[inline(always)]
fn factorize_block(a: &mut [f64], pivots: &mut [usize], n: usize) {
    for k in 0..n {
        let larger = |&i: &usize, &j: &usize| a[n * i + k].abs().total_cmp(&a[n * j + k].abs());
        let pivot = (k..n).rev().max_by(larger).unwrap_or(k);
        pivots[k] = pivot;
        if pivot != k {
            for j in 0..n {
                a.swap(n * k + j, n * pivot + j);
            }
        }
        let reciprocal = 1.0 / a[n * k + k];
        a[n * k + k] = reciprocal;
        let (done, rest) = a.split_at_mut(n * (k + 1));
        let own = &done[n * k + k + 1..];
        for row in rest.chunks_exact_mut(n) {
            row[k] *= reciprocal;
            let factor = row[k];
            let others = row[k + 1..].iter_mut().zip(own);
            others.for_each(|(x, own)| *x -= factor * own);
        }
    }
}

/// B ← A⁻¹ B of a block by rows.
#[inline(always)]
fn solve_block(a: &[f64], pivots: &[usize], n: usize, b: &mut [f64], width: usize) {
    for (k, &pivot) in pivots.iter().enumerate() {
        if pivot != k {
            for j in 0..width {
                b.swap(width * k + j, width * pivot + j);
            }
        }
    }
    for k in 0..n {
        let (done, rest) = b.split_at_mut(width * (k + 1));
        let own = &done[width * k..];
        for (i, row) in rest.chunks_exact_mut(width).enumerate() {
            let factor = a[n * (k + 1 + i) + k];
            row.iter_mut()
                .zip(own)
                .for_each(|(x, own)| *x -= factor * own);
        }
    }
    for k in (0..n).rev() {
        let (rest, done) = b.split_at_mut(width * k);
        let own = &mut done[..width];
        own.iter_mut().for_each(|x| *x *= a[n * k + k]);
        for (i, row) in rest.chunks_exact_mut(width).enumerate() {
            let factor = a[n * i + k];
            row.iter_mut()
                .zip(&*own)
                .for_each(|(x, own)| *x -= factor * own);
        }
    }
}

/// C −= A B of blocks by rows, m × l and l × n.
#[inline(always)]
fn subtract_product(c: &mut [f64], a: &[f64], b: &[f64], [m, l, n]: [usize; 3]) {
    if l == OF_BODIES && n == OF_BODIES {
        return subtract_product_of::<OF_BODIES>(c, a, b);
    }
    for i in 0..m {
        let c = &mut c[n * i..n * (i + 1)];
        for (a, b) in a[l * i..l * (i + 1)].iter().zip(b.chunks_exact(n)) {
            c.iter_mut().zip(b).for_each(|(c, b)| *c -= a * b);
        }
    }
}

#[inline(always)]
fn subtract_product_of<const N: usize>(c: &mut [f64], a: &[f64], b: &[f64]) {
    let (b, _) = b.as_chunks::<N>();
    let (rows, _) = c.as_chunks_mut::<N>();
    for (c, a) in rows.iter_mut().zip(a.as_chunks::<N>().0) {
        let mut sum = *c;
        for k in 0..N {
            for j in 0..N {
                sum[j] -= a[k] * b[k][j];
            }
        }
        *c = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Nodes of several sizes in a ring with a chord, so that blocks fill: A x of the solution is the right side.
    #[test]
    fn solution_times_the_matrix_is_the_right_side() {
        let (sizes, edges) = (
            [6, 1, 6, 3, 6],
            [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0), (2, 4)],
        );
        let mut factor = BlockFactor::default();
        factor.start(sizes.into_iter());
        for (a, b) in edges {
            factor.connect(a, b);
            factor.connect(b, a);
        }
        factor.order();
        factor.fill_identity();
        let starts: Vec<usize> = (0..=5).map(|k| sizes[..k].iter().sum()).collect();
        let n = starts[5];
        let mut dense = vec![vec![0.0; n]; n];
        (0..n).for_each(|k| dense[k][k] = 1.0);
        let pairs = edges.into_iter().flat_map(|(a, b)| [(a, b), (b, a)]);
        for (a, b) in pairs.chain((0..5).map(|a| (a, a))) {
            let block = factor.block_mut(a, b);
            for (at, x) in block.iter_mut().enumerate() {
                let (i, j) = (starts[a] + at / sizes[b], starts[b] + at % sizes[b]);
                let entry = 0.3 * ((7 * i + 3 * j) as f64).sin();
                *x += entry;
                dense[i][j] += entry;
            }
        }
        factor.factorize();
        let b: Vec<f64> = (0..n).map(|k| (k as f64).cos()).collect();
        let mut x = b.clone();
        factor.solve(&mut x, &starts);
        for (row, b) in dense.iter().zip(b) {
            let product: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((product - b).abs() < 1e-10, "{product} {b}");
        }
    }
}
