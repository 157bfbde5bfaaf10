//! Rows in a world of several trees: entries for the trees on which they act, and nothing for the others.
//!
//! With M = Lᵀ D L, tree by tree, and Lᵀ X = Jᵀ, the entries of X are where those of J are, and G = Xᵀ D⁻¹ X. So memory and time grow with the number of rows.

use std::ops::Range;

use crate::cone::Columns;
use crate::dynamics::MassMatrixFactor;
use crate::nested::IntoNested;
use crate::scalar::{GROUP, Scalar};

/// J and X of rows.
#[derive(Clone, Debug)]
pub(super) struct SparseRows<T> {
    /// Coordinates of each tree.
    trees: Vec<Range<usize>>,
    /// Tree of each coordinate.
    of_coordinates: Vec<usize>,
    rows: Vec<Place>,
    segments: Vec<Segment>,
    /// J.
    values: Vec<T>,
    /// X, in the same places, and D⁻¹ X.
    half: Vec<T>,
    scaled: Vec<T>,
    /// Y with Lᵀ Y = τ.
    beside: Vec<T>,
    /// Diagonal of G.
    diagonal: Vec<T>,
}

/// Place of the entries of a row.
#[derive(Clone, Debug)]
struct Place {
    segments: Range<usize>,
    /// Index among the rows that have these segments.
    index: usize,
}

/// Entries of some rows in a tree, row after row.
#[derive(Clone, Copy, Debug)]
struct Segment {
    tree: usize,
    at: usize,
}

impl<T: Scalar> SparseRows<T> {
    /// Memory for trees.
    ///
    /// * `first` – for each coordinate, the first of its tree
    pub(super) fn new(first: &[usize]) -> Self {
        let mut trees: Vec<Range<usize>> = Vec::new();
        let mut of_coordinates = Vec::with_capacity(first.len());
        for (k, &first) in first.iter().enumerate() {
            match trees.last_mut().filter(|tree| tree.start == first) {
                Some(tree) => tree.end = k + 1,
                None => trees.push(k..k + 1),
            }
            of_coordinates.push(trees.len() - 1);
        }
        Self {
            trees,
            of_coordinates,
            rows: Vec::new(),
            segments: Vec::new(),
            values: Vec::new(),
            half: Vec::new(),
            scaled: Vec::new(),
            beside: vec![T::zero(); first.len()],
            diagonal: Vec::new(),
        }
    }

    /// Takes back all rows from one on.
    pub(super) fn truncate(&mut self, rows: usize) {
        if let Some(first) = self.rows.get(rows) {
            let segments = first.segments.start;
            if let Some(segment) = self.segments.get(segments) {
                self.values.truncate(segment.at);
            }
            self.segments.truncate(segments);
            self.rows.truncate(rows);
        }
    }

    /// Adds rows of zeros that act on the same trees.
    pub(super) fn grow(&mut self, rows: usize) {
        let start = self.segments.len();
        self.rows.extend((0..rows).map(|index| Place {
            segments: start..start,
            index,
        }));
    }

    /// Adds to the entries of a coordinate in the last rows that were added together.
    ///
    /// * `rows` – how many these are
    /// * `column` – what is added, from the first of these rows on
    pub(super) fn add(&mut self, rows: usize, k: usize, column: impl Iterator<Item = T>) {
        let own = self.trees[self.of_coordinates[k]].clone();
        let first = self.segment(rows, k) + k - own.start;
        let entries = self.values[first..].iter_mut().step_by(own.len());
        entries.zip(column).for_each(|(entry, x)| *entry += x);
    }

    /// Index of the first value of the last rows in the tree of a coordinate.
    fn segment(&mut self, rows: usize, k: usize) -> usize {
        let tree = self.of_coordinates[k];
        let first = self.rows.len() - rows;
        let segments = &self.segments[self.rows[first].segments.clone()];
        if let Some(segment) = segments.iter().find(|segment| segment.tree == tree) {
            return segment.at;
        }
        let at = self.values.len();
        self.segments.push(Segment { tree, at });
        (self.values).resize(at + rows * self.trees[tree].len(), T::zero());
        let end = self.segments.len();
        let all = self.rows[first..].iter_mut();
        all.for_each(|place| place.segments.end = end);
        at
    }

    /// The trees on which a row acts.
    pub(super) fn trees_of(&self, row: usize) -> impl Iterator<Item = usize> + '_ {
        let segments = &self.segments[self.rows[row].segments.clone()];
        segments.iter().map(|segment| segment.tree)
    }

    /// Number of coordinates of a tree.
    pub(super) fn coordinates(&self, tree: usize) -> usize {
        self.trees[tree].len()
    }

    /// Hands the entries of X and D⁻¹ X of a row to `each(tree, coordinate in the tree, x, scaled)`.
    pub(super) fn each_half(&self, row: usize, mut each: impl FnMut(usize, usize, T, T)) {
        let both = self
            .parts(&self.half, row)
            .zip(self.parts(&self.scaled, row));
        for ((tree, x), (_, scaled)) in both {
            let entries = x.iter().zip(scaled).enumerate();
            entries.for_each(|(k, (&x, &scaled))| each(tree, k, x, scaled));
        }
    }

    /// Whether some rows act on one and the same tree.
    pub(super) fn are_on_one_tree(&self, rows: &[usize]) -> bool {
        let mut trees = rows.iter().nested(|&row| self.trees_of(row));
        let first = trees.next();
        trees.all(|tree| Some(tree) == first)
    }

    /// Number of trees.
    pub(super) fn n_trees(&self) -> usize {
        self.trees.len()
    }

    /// The entries of a row in each of its trees, of J or of X.
    fn parts<'a>(&'a self, of: &'a [T], row: usize) -> impl Iterator<Item = (usize, &'a [T])> {
        let place = &self.rows[row];
        let segments = &self.segments[place.segments.clone()];
        segments.iter().map(move |segment| {
            let size = self.trees[segment.tree].len();
            let at = segment.at + place.index * size;
            (segment.tree, &of[at..at + size])
        })
    }

    /// X, Y of forces τ along the coordinates, the diagonal of G, and J M⁻¹ τ.
    pub(super) fn form(&mut self, factor: &MassMatrixFactor<T>, tau: &[T], offset: &mut Vec<T>) {
        self.beside.copy_from_slice(tau);
        for tree in &self.trees {
            let own = &mut self.beside[tree.clone()];
            factor.back_substitute_in(tree.clone(), own);
        }
        self.half.clone_from(&self.values);
        self.scaled.resize(self.values.len(), T::zero());
        self.diagonal.clear();
        offset.clear();
        for place in &self.rows {
            let (mut diagonal, mut along) = (T::zero(), T::zero());
            for segment in &self.segments[place.segments.clone()] {
                let tree = self.trees[segment.tree].clone();
                let at = segment.at + place.index * tree.len();
                let own = at..at + tree.len();
                let x = &mut self.half[own.clone()];
                factor.back_substitute_in(tree.clone(), x);
                for ((k, &x), scaled) in tree.zip(&*x).zip(&mut self.scaled[own]) {
                    *scaled = x * factor.reciprocal(k);
                    diagonal = scaled.mul_add(x, diagonal);
                    along = scaled.mul_add(self.beside[k], along);
                }
            }
            self.diagonal.push(diagonal);
            offset.push(along);
        }
    }

    /// `G_ii` of a row.
    pub(super) fn delassus(&self, row: usize) -> T {
        self.diagonal[row]
    }

    /// n M⁻¹ nᵀ of a row n under a matrix M of which the factors are given.
    pub(super) fn delassus_of(
        &self,
        factor: &MassMatrixFactor<T>,
        row: usize,
        memory: &mut Vec<T>,
    ) -> T {
        let mut sum = T::zero();
        for (tree, j) in self.parts(&self.values, row) {
            let own = self.trees[tree].clone();
            memory.clear();
            memory.extend_from_slice(j);
            factor.back_substitute_in(own.clone(), memory);
            sum += factor.square(own.start, memory);
        }
        sum
    }

    /// `G_ij` of a row and some others.
    pub(super) fn products(&self, row: usize, others: &[usize], out: &mut [T]) {
        out.fill(T::zero());
        for (tree, x) in self.parts(&self.scaled, row) {
            for (&other, out) in others.iter().zip(&mut *out) {
                let place = &self.rows[other];
                let mut segments = self.segments[place.segments.clone()].iter();
                if let Some(own) = segments.find(|own| own.tree == tree) {
                    let y = &self.half[own.at + place.index * x.len()..][..x.len()];
                    let pairs = x.iter().zip(y);
                    *out = pairs.fold(*out, |sum, (&x, &y)| x.mul_add(y, sum));
                }
            }
        }
    }

    /// An entry of J.
    pub(super) fn entry(&self, row: usize, k: usize) -> T {
        let tree = self.of_coordinates[k];
        let mut parts = self.parts(&self.values, row);
        let own = parts.find(|(other, _)| *other == tree);
        own.map_or(T::zero(), |(_, j)| j[k - self.trees[tree].start])
    }

    /// J x of a row.
    pub(super) fn dot(&self, row: usize, x: &[T]) -> T {
        let mut sum = T::zero();
        for (tree, j) in self.parts(&self.values, row) {
            let pairs = j.iter().zip(&x[self.trees[tree].clone()]);
            sum = pairs.fold(sum, |sum, (&j, &x)| j.mul_add(x, sum));
        }
        sum
    }

    /// M⁻¹ (τ + Jᵀ f).
    pub(super) fn accelerations(&self, factor: &MassMatrixFactor<T>, f: &[T], a: &mut [T]) {
        a.copy_from_slice(&self.beside);
        for (row, &f) in f.iter().enumerate() {
            for (tree, x) in self.parts(&self.half, row) {
                let own = a[self.trees[tree].clone()].iter_mut().zip(x);
                own.for_each(|(a, &x)| *a = x.mul_add(f, *a));
            }
        }
        for tree in &self.trees {
            factor.forward_substitute_in(tree.clone(), &mut a[tree.clone()]);
        }
    }

    /// All of J, row after row, for derivatives, whose columns are of all coordinates.
    pub(super) fn fill_jacobian(&self, out: &mut [T]) {
        let nv = self.of_coordinates.len();
        for (row, out) in out.chunks_exact_mut(nv).enumerate() {
            for (tree, j) in self.parts(&self.values, row) {
                out[self.trees[tree].clone()].copy_from_slice(j);
            }
        }
    }

    /// All of X, for each group of rows, coordinate after coordinate; Y after the last row.
    pub(super) fn fill_halves(&self, out: &mut [[T; GROUP]]) {
        let nv = self.of_coordinates.len();
        for row in 0..self.rows.len() {
            let own = &mut out[nv * (row / GROUP)..][..nv];
            for (tree, x) in self.parts(&self.half, row) {
                let own = own[self.trees[tree].clone()].iter_mut().zip(x);
                own.for_each(|(out, &x)| out[row % GROUP] = x);
            }
        }
        let after = self.rows.len();
        let own = out[nv * (after / GROUP)..][..nv]
            .iter_mut()
            .zip(&self.beside);
        own.for_each(|(out, &x)| out[after % GROUP] = x);
    }

    /// D^(−½) X of some rows in a lane, as blocks of the trees on which they act.
    ///
    /// * `nodes` – memory for the node of each tree
    pub(super) fn fill_columns(
        &self,
        factor: &MassMatrixFactor<T>,
        rows: &[usize],
        lane: usize,
        nodes: &mut Vec<usize>,
        out: &mut Columns,
    ) {
        const NONE: usize = usize::MAX;
        nodes.clear();
        nodes.resize(self.trees.len(), NONE);
        for tree in rows.iter().nested(|&row| self.trees_of(row)) {
            nodes[tree] = 0;
        }
        let taking_part = nodes.iter_mut().filter(|node| **node != NONE);
        taking_part.enumerate().for_each(|(k, node)| *node = k);
        let taking_part = self.trees.iter().zip(&*nodes);
        out.start(
            taking_part
                .filter(|(_, node)| **node != NONE)
                .map(|(tree, _)| tree.len()),
        );
        for &row in rows {
            out.push_row();
            for (tree, x) in self.parts(&self.half, row) {
                let coordinates = self.trees[tree].clone().zip(x);
                let scaled = coordinates
                    .map(|(k, x)| x.value(lane) * factor.reciprocal(k).value(lane).sqrt());
                out.push_part(nodes[tree], scaled);
            }
        }
    }
}
