//! The widest gap over all directions, by branch and bound: a proof, not a sample.
//!
//! The signed distance of convex shapes is the largest gap g(n) over unit n. The gap across n is at most x · n − r for each difference x = q − p of their points, with the
//! radii r. For x one takes differences that are least along the middle and the corners of a cell, and points between them: over a cell of angle θ about c the gap is at most
//! ‖x‖ cos(max(0, ∠(x, c) − θ)) − r. A cell whose bound does not exceed the distance claimed is done; others are cut in four.

use super::pairs::{Pair, V};
use super::support::{difference, gap, radii};

/// Most cells of a proof: gaps that are widest along a whole circle need more than any count.
const MAX_CELLS: usize = 20_000;
/// Steps towards the point between differences that bounds a cell best.
const STEPS: usize = 6;

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

/// A triangle on the sphere.
type Cell = [V; 3];

/// Looks for a gap that exceeds a claim by more than a tolerance, m.
///
/// * `known` – a difference of points of the two shapes, without radii
pub(crate) fn widest(pair: &Pair, claim: f64, known: Option<V>, tolerance: f64) -> Verdict {
    let mut open: Vec<Cell> = octants().collect();
    let mut worst = tolerance;
    for _ in 0..MAX_CELLS {
        let Some(cell) = open.pop() else {
            return verdict(worst, tolerance, Verdict::Proved);
        };
        let c = (cell[0] + cell[1] + cell[2]).normalize();
        let own = gap(pair, &c);
        if own - claim > worst {
            worst = climb(pair, &c) - claim;
        }
        if bound(pair, &cell, &c, known) > claim + worst {
            open.extend(quarters(&cell));
        }
    }
    verdict(worst, tolerance, Verdict::NotFound)
}

fn verdict(worst: f64, tolerance: f64, otherwise: Verdict) -> Verdict {
    if worst > tolerance {
        Verdict::Wider(worst)
    } else {
        otherwise
    }
}

/// A bound of the gaps of a cell about c.
fn bound(pair: &Pair, cell: &Cell, c: &V, known: Option<V>) -> f64 {
    let width = cell.iter().map(|v| angle(v, c)).fold(0.0, f64::max);
    let most = |x: &V| x.norm() * (angle(x, c) - width).max(0.0).cos();
    let middle = difference(pair, c);
    let corners = cell.map(|v| difference(pair, &v));
    let all = [
        middle,
        corners[0],
        corners[1],
        corners[2],
        known.unwrap_or(middle),
    ];
    let mut best = (most(&middle), middle);
    for _ in 0..STEPS {
        let before = best.0;
        for x in all {
            let u = x - best.1;
            // Where the part across c is least.
            let across = u - c * c.dot(&u);
            let t = -across.dot(&best.1) / across.norm_squared();
            for t in [t.clamp(0.0, 1.0), 1.0] {
                let next = best.1 + u * t;
                if most(&next) < best.0 {
                    best = (most(&next), next);
                }
            }
        }
        if best.0 >= before {
            break;
        }
    }
    best.0 - radii(pair)
}

fn angle(a: &V, b: &V) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// The widest gap that steps of ever smaller length lead to.
pub(crate) fn climb(pair: &Pair, start: &V) -> f64 {
    let (mut n, mut best, mut step) = (*start, gap(pair, start), 1e-2);
    while step > 1e-9 {
        let x = n.cross(&V::ith(n.iamin(), 1.0)).normalize();
        let y = n.cross(&x);
        let around = [x, -x, y, -y].map(|e| (n + e * step).normalize());
        let next = around
            .into_iter()
            .max_by(|a, b| gap(pair, a).total_cmp(&gap(pair, b)));
        match next {
            Some(next) if gap(pair, &next) > best => (n, best) = (next, gap(pair, &next)),
            _ => step *= 0.5,
        }
    }
    best
}

fn octants() -> impl Iterator<Item = Cell> {
    let sign = |k: u32, axis: usize| if k >> axis & 1 == 0 { 1.0 } else { -1.0 };
    (0..8).map(move |k| [0, 1, 2].map(|axis| V::ith(axis, sign(k, axis))))
}

fn quarters([a, b, c]: &Cell) -> [Cell; 4] {
    let [x, y, z] = [(a + b), (b + c), (c + a)].map(|v| v.normalize());
    [[*a, x, z], [x, *b, y], [z, y, *c], [x, y, z]]
}
