//! Pairs of overlapping boxes, by a tree of boxes that is reused from step to step.

use std::fmt;

use super::bounds::Bounds;
use crate::scalar::MapEach;

/// Growth of the area of all nodes at which the tree is built again: refitted trees cost less than a new one until they are about that much looser.
const LOOSE: f64 = 1.5;
/// Nodes that wait in a search: two for each level of a balanced tree.
pub(super) const MAX_WAITING: usize = 128;

/// Boxes that are compared with one another: of so few a tree takes longer.
const FEW: usize = 32;
/// Pairs that may always be found.
const MAX_PAIRS: usize = 1 << 16;
/// Pairs that may be found besides for each box: far more than bodies have neighbours that do not overlap.
const MAX_PAIRS_OF_A_BOX: usize = 256;

/// Error for too many overlapping boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyPairs {
    /// Number of pairs at which the search ended.
    pub pairs: usize,
    /// Number of boxes.
    pub boxes: usize,
}

impl fmt::Display for TooManyPairs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pairs, boxes } = self;
        write!(
            f,
            "of {boxes} shapes {pairs} pairs or more overlap, which are too many; do all of them lie in one place?"
        )
    }
}

impl std::error::Error for TooManyPairs {}

/// Finds the pairs of shapes whose boxes overlap.
///
/// Up to 32 boxes are compared one by one. More are the leaves of a balanced tree, built by medians in O(n log n). Each call fits the tree to the
/// current boxes in O(n), and rebuilds it if it has become loose. A search costs O(log n) for each box and one step for each pair. After the first call it allocates only for more boxes or
/// pairs than before. Use one for each state of a batch.
///
/// # Examples
/// ```
/// use dualbody::collision::{BroadPhase, Bounds, Shape};
/// use dualbody::spatial::Transform;
/// use nalgebra::Vector3;
///
/// let ball = Shape::Sphere { radius: 1.0 };
/// let at = |x| Bounds::of(&ball, &Transform::from_translation(Vector3::new(x, 0.0, 0.0)), 0.0);
/// let mut broad_phase = BroadPhase::default();
/// let pairs = broad_phase.pairs(&[at(0.0), at(1.5), at(4.0)], |_, _| true)?;
/// assert_eq!(pairs, [[0, 1]]);
/// # Ok::<(), dualbody::collision::TooManyPairs>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct BroadPhase {
    /// Boxes with finite bounds, in the order of the leaves.
    pub(super) order: Vec<usize>,
    /// Boxes that reach to infinity.
    endless: Vec<usize>,
    /// Node k has the children 2 k + 1 and 2 k + 2, which halve its leaves.
    pub(super) nodes: Vec<Bounds>,
    /// Area of all nodes when the tree was built.
    area: f64,
    pairs: Vec<[usize; 2]>,
}

/// A node with its range of leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) index: usize,
    pub(super) first: usize,
    end: usize,
}

impl Node {
    pub(super) fn children(self) -> [Self; 2] {
        let middle = self.first.midpoint(self.end);
        let (index, first, end) = (2 * self.index + 1, self.first, self.end);
        [
            Self {
                index,
                first,
                end: middle,
            },
            Self {
                index: index + 1,
                first: middle,
                end,
            },
        ]
    }

    pub(super) fn is_leaf(self) -> bool {
        self.end - self.first == 1
    }
}

impl BroadPhase {
    /// Returns the pairs `[i, j]`, i < j, in order, whose boxes overlap and for which `may_touch(i, j)` is true.
    ///
    /// * `bounds` – one box for each shape; a box with a NaN coordinate overlaps none
    ///
    /// # Errors
    /// If there are more than 65,536 pairs and more than 256 for each box, for example if all shapes are at one position.
    pub fn pairs(
        &mut self,
        bounds: &[Bounds],
        may_touch: impl Fn(usize, usize) -> bool,
    ) -> Result<&[[usize; 2]], TooManyPairs> {
        self.pairs.clear();
        if bounds.len() <= FEW {
            self.compare_all(bounds, may_touch);
            return Ok(&self.pairs);
        }
        self.fit(bounds);
        let most = Self::most_pairs(bounds.len());
        for (at, &i) in self.order.iter().enumerate() {
            let found = &mut self.pairs;
            search(&self.nodes, &self.order, at + 1, &bounds[i], |j| {
                if bounds[i].overlaps(&bounds[j]) && may_touch(i.min(j), i.max(j)) {
                    found.push([i.min(j), i.max(j)]);
                }
                found.len() <= most
            });
            check(found.len(), most, bounds.len())?;
        }
        self.add_endless(bounds, may_touch);
        check(self.pairs.len(), most, bounds.len())?;
        self.pairs.sort_unstable();
        Ok(&self.pairs)
    }

    /// Compares each box with each: of few ones, all pairs are fewer than may always be found.
    fn compare_all(&mut self, bounds: &[Bounds], may_touch: impl Fn(usize, usize) -> bool) {
        for (j, own) in bounds.iter().enumerate() {
            for (i, other) in bounds[..j].iter().enumerate() {
                if own.overlaps(other) && may_touch(i, j) {
                    self.pairs.push([i, j]);
                }
            }
        }
        self.pairs.sort_unstable();
    }

    /// The most pairs that are found for so many boxes.
    pub(crate) fn most_pairs(boxes: usize) -> usize {
        MAX_PAIRS + MAX_PAIRS_OF_A_BOX * boxes
    }

    /// Makes a tree of boxes that stay where they are, for [`each_near`](Self::each_near). Allocates; O(n log n).
    pub(crate) fn of_fixed(bounds: &[Bounds]) -> Self {
        let mut own = Self::default();
        own.fit(bounds);
        own
    }

    /// Hands the boxes that overlap another one, by their indices and in no order, to `each` until it returns `false`: O(log n), and one step for each.
    pub(crate) fn each_near(&self, bounds: &Bounds, each: impl FnMut(usize) -> bool) {
        if !self.order.is_empty() {
            search(&self.nodes, &self.order, 0, bounds, each);
        }
    }

    /// Boxes that reach to infinity, one after the other against all.
    fn add_endless(&mut self, bounds: &[Bounds], may_touch: impl Fn(usize, usize) -> bool) {
        for (k, &i) in self.endless.iter().enumerate() {
            let others = self.order.iter().chain(&self.endless[k + 1..]);
            for &j in others.filter(|&&j| bounds[i].overlaps(&bounds[j])) {
                if may_touch(i.min(j), i.max(j)) {
                    self.pairs.push([i.min(j), i.max(j)]);
                }
            }
        }
    }

    /// Fits the tree to the boxes.
    fn fit(&mut self, bounds: &[Bounds]) {
        let is_same = self.order.len() + self.endless.len() == bounds.len()
            && self.order.iter().all(|&i| bounds[i].is_finite())
            && self.endless.iter().all(|&i| !bounds[i].is_finite());
        if !is_same {
            self.sort(bounds);
            self.build(bounds);
        } else if self.refit(bounds) > LOOSE * self.area {
            self.build(bounds);
        }
    }

    fn sort(&mut self, bounds: &[Bounds]) {
        let is_number = |i: &usize| bounds[*i].overlaps(&bounds[*i]);
        let indices = || (0..bounds.len()).filter(is_number);
        self.order.clear();
        self.order
            .extend(indices().filter(|&i| bounds[i].is_finite()));
        self.endless.clear();
        self.endless
            .extend(indices().filter(|&i| !bounds[i].is_finite()));
    }

    pub(super) fn root(&self) -> Node {
        Node {
            index: 0,
            first: 0,
            end: self.order.len(),
        }
    }

    fn build(&mut self, bounds: &[Bounds]) {
        halve(&mut self.order, bounds);
        self.area = self.refit(bounds);
    }

    /// Fits the nodes to the boxes, from the leaves up; the area of all nodes.
    fn refit(&mut self, bounds: &[Bounds]) -> f64 {
        let Some(&first) = self.order.first() else {
            return 0.0;
        };
        let n_nodes = 2 * self.order.len().next_power_of_two();
        self.nodes.clear();
        self.nodes.resize(n_nodes, bounds[first]);
        let root = self.root();
        self.refit_node(root, bounds)
    }

    fn refit_node(&mut self, node: Node, bounds: &[Bounds]) -> f64 {
        if node.is_leaf() {
            self.nodes[node.index] = bounds[self.order[node.first]];
            return 0.0;
        }
        let [a, b] = node.children();
        let area = self.refit_node(a, bounds) + self.refit_node(b, bounds);
        let own = self.nodes[a.index].union(&self.nodes[b.index]);
        self.nodes[node.index] = own;
        area + own.half_area()
    }
}

/// Halves boxes along the longest side of the box about their centres, again and again.
fn halve(order: &mut [usize], bounds: &[Bounds]) {
    if order.len() < 2 {
        return;
    }
    let center = |i: usize, axis: usize| bounds[i].low[axis] + bounds[i].high[axis];
    let width = |axis: usize| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &i in order.iter() {
            low = low.min(center(i, axis));
            high = high.max(center(i, axis));
        }
        high - low
    };
    let widths = [0, 1, 2].map_each(width);
    let axis = (0..3)
        .max_by(|&a, &b| widths[a].total_cmp(&widths[b]))
        .unwrap_or(0);
    let middle = order.len() / 2;
    let along = |i: &usize, j: &usize| center(*i, axis).total_cmp(&center(*j, axis));
    order.select_nth_unstable_by(middle, along);
    let (low, high) = order.split_at_mut(middle);
    halve(low, bounds);
    halve(high, bounds);
}

/// Hands the boxes from a leaf on whose nodes overlap a box to `each`, until it returns `false`.
fn search(
    nodes: &[Bounds],
    order: &[usize],
    first: usize,
    bounds: &Bounds,
    mut each: impl FnMut(usize) -> bool,
) {
    let root = Node {
        index: 0,
        first: 0,
        end: order.len(),
    };
    let mut waiting = [root; MAX_WAITING];
    let mut n_waiting = 1;
    while n_waiting > 0 {
        n_waiting -= 1;
        let node = waiting[n_waiting];
        if node.end <= first || !nodes[node.index].overlaps(bounds) {
            continue;
        }
        if node.is_leaf() {
            if !each(order[node.first]) {
                return;
            }
            continue;
        }
        for child in node.children() {
            waiting[n_waiting] = child;
            n_waiting += 1;
        }
    }
}

fn check(pairs: usize, most: usize, boxes: usize) -> Result<(), TooManyPairs> {
    if pairs > most {
        Err(TooManyPairs { pairs, boxes })
    } else {
        Ok(())
    }
}
