//! The point of a simplex that is nearest to the origin.

use nalgebra::Vector3;

/// Up to four points; the last is the newest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simplex {
    points: [Vector3<f64>; 4],
    len: usize,
}

impl Simplex {
    pub(super) fn new(point: Vector3<f64>) -> Self {
        Self {
            points: [point; 4],
            len: 1,
        }
    }

    pub(super) fn points(&self) -> &[Vector3<f64>] {
        &self.points[..self.len]
    }

    pub(super) fn push(&mut self, point: Vector3<f64>) {
        self.points[self.len] = point;
        self.len += 1;
    }

    /// Keeps those points between which the one nearest to the origin lies, and computes that one. The newest point stays.
    pub(super) fn reduce(&mut self) -> Vector3<f64> {
        let newest = self.len - 1;
        let mut best = (self.points[newest], [newest; 4], 1);
        let others = 0..newest;
        let mut offer = |indices: [usize; 4], len: usize, nearest: Option<Vector3<f64>>| {
            if let Some(v) = nearest
                && v.norm_squared() < best.0.norm_squared()
            {
                best = (v, indices, len);
            }
        };
        let p = &self.points;
        for i in others.clone() {
            offer([i, newest, 0, 0], 2, on_segment(&p[i], &p[newest]));
            for j in 0..i {
                offer([j, i, newest, 0], 3, on_triangle(&p[j], &p[i], &p[newest]));
            }
        }
        if self.len == 4 {
            offer([0, 1, 2, 3], 4, contains_origin(p).then(Vector3::zeros));
        }
        let (nearest, indices, len) = best;
        self.points = indices.map(|i| self.points[i]);
        self.len = len;
        nearest
    }
}

/// Point nearest to the origin strictly inside a segment.
fn on_segment(a: &Vector3<f64>, b: &Vector3<f64>) -> Option<Vector3<f64>> {
    let u = b - a;
    let (t, square) = (-a.dot(&u), u.norm_squared());
    // The rejection of the nearer end loses least.
    let from = if 2.0 * t < square { a } else { b };
    (t > 0.0 && t < square).then(|| from - u * (from.dot(&u) / square))
}

/// Part of the square of its longest side below which the area of a triangle is rounding: its sides say as much.
const FLAT: f64 = 1e-13;

/// Point nearest to the origin strictly inside a triangle.
fn on_triangle(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> Option<Vector3<f64>> {
    let normal = (b - a).cross(&(c - a));
    let square = normal.norm_squared();
    let beside = |p: &Vector3<f64>, q: &Vector3<f64>| p.cross(q).dot(&normal) > 0.0;
    let longest = [b - a, c - a, c - b].map(|u| u.norm_squared());
    let longest = longest.into_iter().fold(0.0, f64::max);
    let inside = square > (FLAT * longest).powi(2) && beside(a, b) && beside(b, c) && beside(c, a);
    inside.then(|| normal * (a.dot(&normal) / square))
}

/// Whether the origin is strictly inside a tetrahedron.
fn contains_origin(p: &[Vector3<f64>; 4]) -> bool {
    let volume = |a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| a.cross(b).dot(c);
    let [a, b, c, d] = p;
    let whole = volume(&(b - a), &(c - a), &(d - a));
    let parts = [
        volume(b, c, d),
        -volume(a, c, d),
        volume(a, b, d),
        -volume(a, b, c),
    ];
    whole != 0.0 && parts.iter().all(|part| part * whole > 0.0)
}
