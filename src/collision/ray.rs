//! The first triangle that a ray meets, on plain values.

use nalgebra::Vector3;

use super::bounds::Bounds;
use super::broad_phase::{BroadPhase, MAX_WAITING, Node};
use crate::scalar::MapEach;

/// Slope of a ray to a triangle, by both lengths, below which it passes along the triangle and does not meet it.
const ALONG: f64 = 1e-12;

/// Relative widening of distances to boxes: far above their rounding, so that a flat box is not missed.
const SLACK: f64 = 1e-12;

/// The half-line origin + t direction, t ≥ 0, on plain values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfLine {
    pub(crate) origin: Vector3<f64>,
    /// Of any length but zero.
    pub(crate) direction: Vector3<f64>,
}

impl HalfLine {
    /// t at which the half-line meets a triangle, from either side, by the signs of its volumes with the edges: equal but for the sign for both triangles
    /// of an edge, so that none passes between these.
    fn meets(&self, corners: &[Vector3<f64>; 3]) -> Option<f64> {
        let [a, b, c] = corners.map_each(|corner| corner - self.origin);
        let volumes = [[b, c], [c, a], [a, b]].map_each(|[p, q]| self.direction.dot(&p.cross(&q)));
        let is_inside = volumes.iter().all(|x| *x >= 0.0) || volumes.iter().all(|x| *x <= 0.0);
        let normal = (b - a).cross(&(c - a));
        let slope = normal.dot(&self.direction);
        let least = ALONG * normal.norm() * self.direction.norm();
        let at = normal.dot(&a) / slope;
        (is_inside && slope.abs() > least && at >= 0.0).then_some(at)
    }

    /// t at which the half-line enters a box, if it does so before `end`.
    fn enters(&self, bounds: &Bounds, end: f64) -> Option<f64> {
        let (mut first, mut last) = (0.0_f64, end);
        for k in 0..3 {
            let (origin, slope) = (self.origin[k], self.direction[k]);
            if slope == 0.0 {
                if !(bounds.low[k]..=bounds.high[k]).contains(&origin) {
                    return None;
                }
                continue;
            }
            let to = |plane: f64| (plane - origin) / slope;
            let (low, high) = (to(bounds.low[k]), to(bounds.high[k]));
            first = first.max(low.min(high));
            last = last.min(low.max(high));
        }
        (first <= last * (1.0 + SLACK)).then_some(first)
    }
}

/// A node whose box a half-line enters, and at which t.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    node: Node,
    from: f64,
}

impl BroadPhase {
    /// Returns the corners of the first triangle that a half-line meets before t = `end`, of those whose boxes this tree has. O(log n) for well-spread
    /// triangles; does not allocate.
    ///
    /// * `triangle` – the corners of a triangle, by the index of its box
    pub(crate) fn first_met(
        &self,
        line: &HalfLine,
        end: f64,
        triangle: impl Fn(usize) -> [Vector3<f64>; 3],
    ) -> Option<[Vector3<f64>; 3]> {
        let root = Waiting {
            node: self.root(),
            from: 0.0,
        };
        let (mut waiting, mut n_waiting) = ([root; MAX_WAITING], 1);
        let (mut found, mut end) = (None, end);
        while n_waiting > 0 && !self.order.is_empty() {
            n_waiting -= 1;
            let Waiting { node, from } = waiting[n_waiting];
            if from > end {
                continue;
            }
            if node.is_leaf() {
                let corners = triangle(self.order[node.first]);
                if let Some(at) = line.meets(&corners).filter(|at| *at < end) {
                    (end, found) = (at, Some(corners));
                }
                continue;
            }
            for child in self.entered(node, line, end).into_iter().flatten() {
                waiting[n_waiting] = child;
                n_waiting += 1;
            }
        }
        found
    }

    /// The children of a node that a half-line enters, the nearer one last: it is taken first.
    fn entered(&self, node: Node, line: &HalfLine, end: f64) -> [Option<Waiting>; 2] {
        let [a, b] = node.children().map_each(|node| {
            let from = line.enters(&self.nodes[node.index], end)?;
            Some(Waiting { node, from })
        });
        match (a, b) {
            (Some(near), Some(far)) if near.from < far.from => [b, a],
            _ => [a, b],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(origin: [f64; 3], direction: [f64; 3]) -> HalfLine {
        HalfLine {
            origin: origin.into(),
            direction: direction.into(),
        }
    }

    const CORNERS: [Vector3<f64>; 3] = [
        Vector3::new(0.0, 0.0, 0.0),
        Vector3::new(1.0, 0.0, 0.0),
        Vector3::new(0.0, 1.0, 0.0),
    ];

    #[test]
    fn rays_meet_a_triangle_from_both_sides_on_its_edges_and_not_beside_it() {
        let down = |x: f64, y: f64| line([x, y, 2.0], [0.0, 0.0, -2.0]).meets(&CORNERS);
        assert_eq!(down(0.25, 0.25), Some(1.0));
        assert_eq!(down(0.5, 0.5), Some(1.0));
        assert_eq!(down(0.0, 0.0), Some(1.0));
        assert_eq!(down(0.6, 0.6), None);
        assert_eq!(down(-1e-300, 0.5), None);
        let up = line([0.25, 0.25, -3.0], [0.0, 0.0, 1.0]);
        assert_eq!(up.meets(&CORNERS), Some(3.0));
        let away = line([0.25, 0.25, -3.0], [0.0, 0.0, -1.0]);
        assert_eq!(away.meets(&CORNERS), None);
        let along = line([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]);
        assert_eq!(along.meets(&CORNERS), None);
    }

    #[test]
    fn flat_boxes_are_entered_from_all_sides() {
        let bounds = Bounds {
            low: Vector3::new(-1.0, -1.0, 0.3),
            high: Vector3::new(1.0, 1.0, 0.3),
        };
        for k in 0..1000 {
            let height = 0.3 + f64::from(k) * 0.007;
            let ray = line([0.0, 0.0, height], [0.01, 0.003, -0.1]);
            assert!(ray.enters(&bounds, f64::INFINITY).is_some(), "{height}");
        }
        let beside = line([2.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        assert!(beside.enters(&bounds, f64::INFINITY).is_none());
        let in_plane = line([-1.0, 0.0, 2.0], [0.0, 0.0, -1.0]);
        assert!(in_plane.enters(&bounds, f64::INFINITY).is_some());
        let short = line([0.0, 0.0, 2.0], [0.0, 0.0, -1.0]);
        assert!(short.enters(&bounds, 1.0).is_none());
    }
}
