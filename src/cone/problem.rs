//! The force problem: blocks of rows, and the law between force and velocity of each.

use super::blocks::Columns;
use crate::scalar::Scalar;

/// A block of rows with one law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// The given number of bilateral rows: y = 0.
    Free(usize),
    /// One unilateral row:  f ≥ 0, y ≥ 0, f y = 0.
    Ray,
    /// Three rows (normal, tangent, tangent) with friction μ:  ‖fₜ‖ ≤ μ fₙ.
    Cone,
    /// One row with a bounded force:  f = Π(f − y)  with the projection Π on [−b, b]. So y = 0 where |f| < b, y ≤ 0 at f = b, y ≥ 0 at f = −b. With a
    /// bound of zero there is no force; with an infinite bound it is a bilateral row.
    Interval,
    /// One row whose force m, a moment about the normal, is bounded by the normal force of the last cone before it:  m = Π(m − y)  with the projection Π
    /// on |m| ≤ c fₙ. So y = 0 where |m| < c fₙ, else m is at its bound against y. Exact also where cones are convex or smoothed.
    Spin,
    /// As [`Spin`](Self::Spin), with two rows, moments about the tangents:  ‖m‖ ≤ c fₙ.
    Roll,
}

impl Block {
    /// Whether its force is bounded by the normal force of a cone.
    pub(crate) fn is_moment(self) -> bool {
        matches!(self, Self::Spin | Self::Roll)
    }

    /// Number of rows of the block.
    pub fn rows(self) -> usize {
        match self {
            Self::Free(rows) => rows,
            Self::Ray | Self::Interval | Self::Spin => 1,
            Self::Roll => 2,
            Self::Cone => 3,
        }
    }
}

/// Friction law of a cone, between its force and its velocity; K = {‖fₜ‖ ≤ μ fₙ}, K* its dual.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Law {
    /// y ∈ K*, f ⊥ y: the minimiser of  ½ fᵀ (G + R) f + gᵀ f. A contact that slides at ‖yₜ‖ also separates at μ ‖yₜ‖.
    #[default]
    Convex,
    /// y + μ ‖yₜ‖ eₙ ∈ K*, f ⊥ that: Coulomb's friction. A contact that slides does not separate.
    Coulomb,
}

/// Find f with the law of every block between f and  y = (G + diag R) f + g.
///
/// In n rows, one block after the other. Units: f in N s and y in m/s, or N and m/s²; κ has the unit of their product.
#[derive(Clone, Copy, Debug)]
pub struct ConeProblem<'a, T> {
    /// The law of all cones.
    pub law: Law,
    /// The kind of every block; their rows add up to n.
    pub blocks: &'a [Block],
    /// μ ≥ 0 of every cone, b ≥ 0 of every interval, in the unit of f, and c ≥ 0 of every moment, finite; ignored for other blocks.
    pub friction: &'a [T],
    /// G by columns, n × n, symmetric and positive semidefinite; singular where rows are redundant.
    pub matrix: &'a [T],
    /// R ≥ 0, length n; a block with an infinite R has no force.
    pub regularization: &'a [T],
    /// g, the free velocity: y without forces, length n.
    pub free_velocity: &'a [T],
}

/// A lane of a problem whose matrix is G = Xᵀ X, with X by blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockProblem<'a> {
    pub(crate) law: Law,
    pub(crate) blocks: &'a [Block],
    /// μ ≥ 0 of every cone, and b ≥ 0 of every interval.
    pub(crate) friction: &'a [f64],
    /// X.
    pub(crate) columns: &'a Columns,
    /// R ≥ 0; the same across the normal in all directions of a cone.
    pub(crate) regularization: &'a [f64],
    /// g.
    pub(crate) free_velocity: &'a [f64],
}

impl<T: Scalar> ConeProblem<'_, T> {
    pub(super) fn check(&self, f: &[T]) {
        let n = self.free_velocity.len();
        let rows: usize = self.blocks.iter().map(|block| block.rows()).sum();
        assert_eq!(
            rows, n,
            "the blocks have {rows} rows, the free velocity {n}"
        );
        assert_eq!(f.len(), n, "as many forces as rows");
        assert_eq!(self.matrix.len(), n * n, "the matrix is n × n");
        assert_eq!(self.regularization.len(), n, "one regularisation per row");
        assert_eq!(
            self.friction.len(),
            self.blocks.len(),
            "one friction per block"
        );
        let negative = |mu: &T| mu.has_value() && (0..T::LANES).any(|lane| mu.value(lane) < 0.0);
        let first = self
            .blocks
            .iter()
            .position(|b| b.is_moment() || *b == Block::Cone);
        assert!(
            first.is_none_or(|k| self.blocks[k] == Block::Cone),
            "moments follow the cone whose normal force bounds them"
        );
        assert!(
            !self.friction.iter().any(negative),
            "a friction coefficient or a bound of a block is negative"
        );
    }
}
