//! The point of a simplex that is nearest to the origin.

use nalgebra::Vector3;

use crate::scalar::MapEach;

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
        self.points = indices.map_each(|i| self.points[i]);
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
    let longest = [b - a, c - a, c - b].map_each(|u| u.norm_squared());
    let longest = longest.into_iter().fold(0.0, f64::max);
    let inside = square > (FLAT * longest).powi(2) && beside(a, b) && beside(b, c) && beside(c, a);
    inside.then(|| normal * (a.dot(&normal) / square))
}

/// Part of the cube of the farthest corner's distance by which the volumes between the origin and the faces of a tetrahedron are more than rounding.
const NO_VOLUME: f64 = 1e-14;

/// Whether the origin is inside a tetrahedron by more than rounding: four points of one plane have it inside by chance.
fn contains_origin(p: &[Vector3<f64>; 4]) -> bool {
    let volume = |a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| a.cross(b).dot(c);
    let [a, b, c, d] = p;
    let parts = [
        volume(b, c, d),
        -volume(a, c, d),
        volume(a, b, d),
        -volume(a, b, c),
    ];
    let sign = parts[0].signum();
    let smallest = parts
        .iter()
        .fold(f64::INFINITY, |a, part| a.min(part * sign));
    let farthest = || p.iter().map(|x| x.norm_squared()).fold(0.0, f64::max);
    smallest > 0.0 && smallest > NO_VOLUME * farthest().powf(1.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::Quaternion;

    // Four points of a plane through the origin, all to one side of it: their volumes are rounding, of any sign.
    #[test]
    fn points_of_a_plane_beside_the_origin_do_not_contain_it() {
        for k in 0..1000 {
            let at = |step: f64| (step * f64::from(k)).sin();
            let turn = Quaternion::exp(&Vector3::new(at(1.3), at(2.1), at(0.7))).to_matrix();
            let [a, b] = [at(3.1), at(4.7)];
            let points = [
                Vector3::new(0.5, a, 0.0),
                Vector3::new(0.7, b, 0.0),
                Vector3::new(1.0, -a, 0.0),
                Vector3::new(0.9, 0.3 - b, 0.0),
            ];
            assert!(!contains_origin(&points.map(|x| turn * x)), "{k}");
        }
    }
}
