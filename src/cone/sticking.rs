//! A first guess at the forces of few rows: what approaches sticks, and all else is separated. Where these forces obey all laws they are a solution, and of a
//! regularised convex problem there is no other.
//!
//! W is symmetric, and its factors need no pivots, so that a guess is made in all lanes at once, with the operations of a single problem. Robots that stand or
//! walk without slip need nothing else.

use std::ops::Range;

use super::system::REGULARIZED_ABOVE;
use super::{Block, ConeProblem, Law};
use crate::scalar::Scalar;

/// Most rows that take part: the operations grow with their third power, one number after the other.
const MOST_ROWS: f64 = 24.0;
/// Most rows in all lanes together, of which each may have others.
pub(super) const MOST_TOGETHER: usize = 36;

/// A guess, with its working memory.
#[derive(Clone, Debug)]
pub(super) struct Guess<T> {
    /// The forces.
    pub(super) f: Vec<T>,
    /// For each row, positive in the lanes in which it takes part, and in those in which it has a force.
    present: Vec<T>,
    acting: Vec<T>,
    /// The rows of L below its diagonal, with the reciprocals of D on it: W = L D Lᵀ.
    factor: Vec<T>,
    /// D Lᵀ of one row.
    row: Vec<T>,
}

impl<T> Guess<T> {
    pub(super) fn new() -> Self {
        Self {
            f: Vec::new(),
            present: Vec::new(),
            acting: Vec::new(),
            factor: Vec::new(),
            row: Vec::new(),
        }
    }
}

impl<T: Scalar> Guess<T> {
    /// Makes room for so many rows, of which few have forces.
    pub(super) fn reserve(&mut self, rows: usize) {
        let few = rows.min(MOST_TOGETHER);
        self.present.reserve(rows);
        self.acting.reserve(rows);
        self.f.reserve(few);
        self.row.reserve(few);
        self.factor.reserve(few * (few + 1) / 2);
    }

    /// Finds forces, and returns 1 in lanes in which they are those of the solution, 0 in others.
    ///
    /// * `start` – the forces to start from: only from none is there a guess
    /// * `number` – makes a number of one of the problem
    pub(super) fn solve<S: Scalar>(
        &mut self,
        of: &ConeProblem<'_, S>,
        start: &[S],
        number: impl Fn(&S) -> T + Copy,
    ) -> T {
        T::vectorized(
            #[inline(always)]
            || {
                let fits = self.choose(of, start, number);
                if (0..T::LANES).all(|lane| fits.value(lane) == 0.0) {
                    return fits;
                }
                self.fill(of, number);
                self.factorize();
                self.substitute();
                fits * self.obeys(of, number)
            },
        )
    }

    /// Chooses the rows with forces. Returns 1 in lanes with rays and cones alone, few of them and each regularised, 0 in others.
    #[inline(always)]
    fn choose<S: Scalar>(
        &mut self,
        of: &ConeProblem<'_, S>,
        start: &[S],
        number: impl Fn(&S) -> T + Copy,
    ) -> T {
        let (zero, one, n) = (T::zero(), T::one(), start.len());
        let (mut fits, mut count) = (one, zero);
        self.present.clear();
        self.acting.clear();
        for (block, rows) in blocks(of) {
            let compliance = |row: usize| number(&of.regularization[row]);
            let weight = |row: usize| number(&of.matrix[(n + 1) * row]) + compliance(row);
            let finite = T::constant(f64::MAX);
            let mut present = one;
            let mut sum = zero;
            for row in rows.clone() {
                present = compliance(row).select_lt(finite, present, zero);
                sum += weight(row);
            }
            let least = sum * (REGULARIZED_ABOVE / rows.len() as f64);
            let mut regularised = one;
            for row in rows.clone() {
                regularised = least.select_lt(compliance(row), regularised, zero);
            }
            let known = match of.blocks[block] {
                Block::Ray | Block::Cone => regularised,
                _ => zero,
            };
            fits = zero.select_lt(present, fits * known, fits);
            count += present * rows.len() as f64;
            let free = |row: usize| number(&of.free_velocity[row]);
            let acting = present * approaches(of, block, rows.start, free, number);
            for _ in rows {
                self.present.push(present);
                self.acting.push(acting);
            }
        }
        let from = start.iter().fold(zero, |sum, f| sum + number(f).abs());
        fits = zero.select_lt(from, zero, fits);
        T::constant(MOST_ROWS).select_lt(count, zero, fits)
    }

    /// Writes W of the rows with forces, in which others give way without one, and −g.
    #[inline(always)]
    fn fill<S: Scalar>(&mut self, of: &ConeProblem<'_, S>, number: impl Fn(&S) -> T) {
        let (zero, n) = (T::zero(), self.acting.len());
        self.factor.clear();
        self.f.clear();
        for row in 0..n {
            let entries = of.matrix[n * row..].iter().take(row + 1);
            self.factor.extend(entries.map(&number));
            let acting = self.acting[row];
            let compliance = number(&of.regularization[row]);
            let infinite = T::constant(f64::INFINITY);
            if let Some(own) = self.factor.last_mut() {
                *own += zero.select_lt(acting, compliance, infinite);
            }
            let free = number(&of.free_velocity[row]);
            self.f.push(zero.select_lt(acting, -free, zero));
        }
    }

    /// L and D⁻¹, row by row.
    #[inline(always)]
    fn factorize(&mut self) {
        self.row.clear();
        self.row.resize(self.f.len(), T::zero());
        for i in 0..self.f.len() {
            let (done, rest) = self.factor.split_at_mut(i * (i + 1) / 2);
            let (own, row) = (&mut rest[..i + 1], &mut self.row[..i]);
            let mut last = own[i];
            for j in 0..i {
                let other = &done[j * (j + 1) / 2..][..j + 1];
                let mut sum = own[j];
                for k in 0..j {
                    sum -= row[k] * other[k];
                }
                row[j] = sum;
                own[j] = sum * other[j];
                last -= sum * own[j];
            }
            own[i] = T::one() / last;
        }
    }

    /// f ← W⁻¹ f.
    #[inline(always)]
    fn substitute(&mut self) {
        let (f, factor) = (&mut self.f[..], &self.factor[..]);
        for i in 0..f.len() {
            let (row, mut sum) = (&factor[i * (i + 1) / 2..][..i], f[i]);
            for k in 0..i {
                sum -= row[k] * f[k];
            }
            f[i] = sum;
        }
        for i in (0..f.len()).rev() {
            let row = &factor[i * (i + 1) / 2..][..i + 1];
            f[i] *= row[i];
        }
        for i in (0..f.len()).rev() {
            let (row, own) = (&factor[i * (i + 1) / 2..][..i], f[i]);
            for k in 0..i {
                f[k] -= row[k] * own;
            }
        }
    }

    /// 1 in lanes in which all forces are inside their cones, and what is separated moves away; 0 in others.
    #[inline(always)]
    fn obeys<S: Scalar>(&self, of: &ConeProblem<'_, S>, number: impl Fn(&S) -> T + Copy) -> T {
        let (zero, one) = (T::zero(), T::one());
        let velocity = |row: usize| self.velocity(of, row, number);
        let mut all = one;
        for (block, rows) in blocks(of) {
            let first = rows.start;
            let (present, acting) = (self.present[first], self.acting[first]);
            let is_open = |lane| present.value(lane) > acting.value(lane);
            let open = match (0..T::LANES).any(is_open) {
                true => one - approaches(of, block, first, velocity, number),
                false => one,
            };
            let open = zero.select_lt(present, open, one);
            let pressing = zero.select_lt(self.f[first], one, zero);
            let inside = match of.blocks[block] {
                Block::Cone => {
                    let bound = number(&of.friction[block]) * self.f[first];
                    let across = square(self.f[first + 1], self.f[first + 2]);
                    pressing * across.select_lt(bound * bound, one, zero)
                }
                _ => pressing,
            };
            all *= zero.select_lt(acting, inside, open);
        }
        all
    }

    /// y of a row without a force.
    #[inline(always)]
    fn velocity<S: Scalar>(
        &self,
        of: &ConeProblem<'_, S>,
        row: usize,
        number: impl Fn(&S) -> T,
    ) -> T {
        let (n, mut sum) = (self.f.len(), number(&of.free_velocity[row]));
        for (g, &f) in of.matrix[n * row..n * (row + 1)].iter().zip(&self.f) {
            sum += number(g) * f;
        }
        sum
    }
}

/// Index and rows of each block that has rows.
#[inline(always)]
fn blocks<S>(of: &ConeProblem<'_, S>) -> impl Iterator<Item = (usize, Range<usize>)> {
    let mut row = 0;
    let all = of.blocks.iter().enumerate().map(move |(block, kind)| {
        let rows = row..row + kind.rows();
        row = rows.end;
        (block, rows)
    });
    all.filter(|(_, rows)| !rows.is_empty())
}

/// 1 in lanes in which a ray or cone without a force would have one at its velocity, 0 in others.
#[inline(always)]
fn approaches<S: Scalar, T: Scalar>(
    of: &ConeProblem<'_, S>,
    block: usize,
    row: usize,
    velocity: impl Fn(usize) -> T,
    number: impl Fn(&S) -> T,
) -> T {
    let (zero, mut inward) = (T::zero(), -velocity(row));
    if of.blocks[block] == Block::Cone && of.law == Law::Convex {
        let across = square(velocity(row + 1), velocity(row + 2)).sqrt();
        inward += number(&of.friction[block]) * across;
    }
    zero.select_lt(inward, T::one(), zero)
}

/// x² + y²
#[inline(always)]
fn square<T: Scalar>(x: T, y: T) -> T {
    x * x + y * y
}
