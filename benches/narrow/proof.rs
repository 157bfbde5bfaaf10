//! The widest gap over all directions: a proof, not a sample.
//!
//! The signed distance of convex shapes is the largest gap g(n) over unit n, and the gap across n is at most n · x − r for each difference x = q − p of their points, with the
//! radii r. Of cores that are apart the points of the distance themselves are the proof: g(n) ≤ ‖x‖ − r. Where cores overlap, −g is the support function h of the differences p − q, and
//! h(n) ≥ n · y for each of these. Over a triangle of the sphere that is least at a corner, so that h is at least the value of a game: the greatest least product of the corners with
//! a point between known differences, those that reach farthest along the corners. A cell whose bound is the depth claimed is done; others are cut in four.

use super::pairs::{Pair, V};
use super::support::{difference, gap, radii};

/// Most cells of a proof: gaps that are widest along a whole circle need more than any count.
const MAX_CELLS: usize = 8_000;
/// Rounds towards the point between differences that bounds a cell best.
const ROUNDS: usize = 2;
/// Differences that bound a cell: one for each corner, and the one claimed.
const COLUMNS: usize = 4;

/// End of the search for a gap wider than a claim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// No gap is wider than the claim by more than the tolerance.
    Proved,
    /// None was found before the cells ran out.
    NotFound,
    /// A gap is wider by this, m.
    Wider(f64),
}

/// A triangle on the sphere: its corners, each with the difference p − q that reaches farthest along it.
#[derive(Clone, Copy)]
struct Cell {
    corners: [V; 3],
    reached: [V; 3],
}

/// Looks for a gap that exceeds a claim by more than a tolerance, m.
///
/// * `normal` – across which the gap is claimed to be the widest
/// * `known` – a difference q − p of points of the two shapes, without radii
pub(crate) fn widest(
    pair: &Pair,
    claim: f64,
    normal: &V,
    known: Option<V>,
    tolerance: f64,
) -> Verdict {
    if known.is_some_and(|x| x.norm() - radii(pair) <= claim + tolerance) {
        return Verdict::Proved;
    }
    let depth = -(claim + radii(pair) + tolerance);
    if depth <= 0.0 {
        return Verdict::NotFound;
    }
    let mut open: Vec<Cell> = octants(normal)
        .map(|corners| Cell {
            corners,
            reached: corners.map(|n| -difference(pair, &n)),
        })
        .collect();
    for _ in 0..MAX_CELLS {
        let Some(cell) = open.pop() else {
            return Verdict::Proved;
        };
        let shallow = (0..3).find(|&k| cell.corners[k].dot(&cell.reached[k]) < depth);
        if let Some(k) = shallow {
            return Verdict::Wider(climb(pair, &cell.corners[k]) - claim);
        }
        if bound(&cell, known) < depth {
            open.extend(quarters(pair, &cell));
        }
    }
    Verdict::NotFound
}

/// Products of the corners of a cell with a difference.
type Column = [f64; 3];

/// A bound of the depths across directions of a cell, if it is positive.
fn bound(cell: &Cell, known: Option<V>) -> f64 {
    let column = |y: &V| cell.corners.map(|n| n.dot(y));
    let [a, b, c] = cell.reached.map(|y| column(&y));
    let all: [Column; COLUMNS] = [a, b, c, known.map_or(a, |x| column(&-x))];
    let mut best = equalised(&[a, b, c]).unwrap_or(a);
    for column in all {
        if least(&column) > least(&best) {
            best = column;
        }
    }
    for _ in 0..ROUNDS {
        for column in all {
            best = between(&best, &column);
        }
    }
    least(&best)
}

fn least(column: &Column) -> f64 {
    column[0].min(column[1]).min(column[2])
}

/// The mixture of three columns whose products are equal, if it is one.
fn equalised([a, b, c]: &[Column; 3]) -> Option<Column> {
    let [a, b, c] = [a, b, c].map(|column| V::from(*column));
    let one = V::from_element(1.0);
    let [x, y, z] = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|cross| cross.dot(&one));
    let sum = x + y + z;
    let parts = [x / sum, y / sum, z / sum];
    let mixed = a * parts[0] + b * parts[1] + c * parts[2];
    parts.iter().all(|part| *part >= 0.0).then(|| mixed.into())
}

/// The mixture of two columns whose least product is greatest.
fn between(a: &Column, b: &Column) -> Column {
    let mixed = |t: f64| -> Column { std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t) };
    let mut best = *a;
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        // Where the i-th and the j-th product are equal.
        let t = (a[i] - a[j]) / ((a[i] - a[j]) - (b[i] - b[j]));
        if t > 0.0 && t < 1.0 && least(&mixed(t)) > least(&best) {
            best = mixed(t);
        }
    }
    best
}

/// The widest gap that steps of ever smaller length lead to.
pub(crate) fn climb(pair: &Pair, start: &V) -> f64 {
    let (mut n, mut best, mut step) = (*start, gap(pair, start), 1e-2);
    while step > 1e-9 {
        let [x, y] = across(&n);
        let around = [x, -x, y, -y].map(|e| (n + e * step).normalize());
        let gaps = around.map(|n| (gap(pair, &n), n));
        let next = gaps.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        match next {
            Some((wider, next)) if wider > best => (n, best) = (next, wider),
            _ => step *= 0.5,
        }
    }
    best
}

/// Unit directions across a unit direction and one another.
fn across(n: &V) -> [V; 2] {
    let x = n.cross(&V::ith(n.iamin(), 1.0)).normalize();
    [x, n.cross(&x)]
}

/// The octants of three axes, so that a direction is the middle of one of them and of the parts into which it is cut.
fn octants(middle: &V) -> impl Iterator<Item = [V; 3]> {
    let [x, y] = across(middle);
    let axes: [V; 3] = std::array::from_fn(|k| {
        let (sin, cos) = (k as f64 * std::f64::consts::TAU / 3.0).sin_cos();
        (middle + (x * cos + y * sin) * std::f64::consts::SQRT_2).normalize()
    });
    let sign = |k: u32, axis: usize| if k >> axis & 1 == 0 { 1.0 } else { -1.0 };
    (0..8).map(move |k| [0, 1, 2].map(|axis| axes[axis] * sign(k, axis)))
}

fn quarters(pair: &Pair, cell: &Cell) -> [Cell; 4] {
    let middles = [0, 1, 2].map(|k| (cell.corners[k] + cell.corners[(k + 1) % 3]).normalize());
    let corners = [cell.corners, middles].concat();
    let new = middles.map(|n| -difference(pair, &n));
    let reached = [cell.reached, new].concat();
    [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].map(|indices| Cell {
        corners: indices.map(|k| corners[k]),
        reached: indices.map(|k| reached[k]),
    })
}
