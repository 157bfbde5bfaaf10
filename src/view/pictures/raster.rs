//! Triangles to samples.
//!
//! A renderer in software has to keep depths. Of the crates that do, `retrofire-core` has blanket implementations of operators that no crate with
//! generic ones of its own can be built beside, `euc` is not maintained, and others draw by a graphics unit; this is what is left of such a crate.

use nalgebra::Vector3;

/// Corner of a triangle: where the camera sees it (to the right, down, ahead; m), and values that are interpolated.
pub(super) type Seen<const N: usize> = (Vector3<f64>, [f64; N]);

/// The picture that the camera sees things on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    /// Samples along each row, and rows.
    pub(super) size: [usize; 2],
    /// Distance of the picture from the eye, samples.
    pub(super) focal_length: f64,
    /// Distance of what is too near, m.
    pub(super) near: f64,
}

/// Sample of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample<const N: usize> {
    pub(super) x: usize,
    pub(super) y: usize,
    /// One over the distance ahead, 1/m: the larger covers the smaller.
    pub(super) nearness: f64,
    pub(super) values: [f64; N],
}

/// A corner in the picture, with its nearness and with its values times that, which are linear over the picture.
#[derive(Clone, Copy)]
struct Projected<const N: usize> {
    at: [f64; 2],
    nearness: f64,
    values: [f64; N],
}

impl Lens {
    /// Passes each sample whose middle a triangle covers to `each`; seen from either side.
    pub(super) fn each_sample<const N: usize>(
        &self,
        triangle: &[Seen<N>; 3],
        each: &mut impl FnMut(Sample<N>),
    ) {
        let corners: Vec<_> = self
            .in_front(triangle)
            .iter()
            .map(|seen| self.project(seen))
            .collect();
        for k in 2..corners.len() {
            self.fill([corners[0], corners[k - 1], corners[k]], each);
        }
    }

    /// The part of a triangle beyond the near plane [Sutherland, Hodgman 1974].
    fn in_front<const N: usize>(&self, triangle: &[Seen<N>; 3]) -> Vec<Seen<N>> {
        let mut out = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (&triangle[k], &triangle[(k + 1) % 3]);
            let [above_a, above_b] = [a, b].map(|seen| seen.0.z - self.near);
            if above_a >= 0.0 {
                out.push(*a);
            }
            if (above_a >= 0.0) != (above_b >= 0.0) {
                let t = above_a / (above_a - above_b);
                let values = std::array::from_fn(|i| a.1[i] + t * (b.1[i] - a.1[i]));
                out.push((a.0 + (b.0 - a.0) * t, values));
            }
        }
        out
    }

    fn project<const N: usize>(&self, (point, values): &Seen<N>) -> Projected<N> {
        let nearness = 1.0 / point.z;
        let scale = self.focal_length * nearness;
        let [width, height] = self.size.map(|n| n as f64);
        Projected {
            at: [
                0.5 * width + scale * point.x,
                0.5 * height + scale * point.y,
            ],
            nearness,
            values: values.map(|value| value * nearness),
        }
    }

    fn fill<const N: usize>(&self, [a, b, c]: [Projected<N>; 3], each: &mut impl FnMut(Sample<N>)) {
        // Twice the area of a triangle with an edge and a point, positive on one side.
        let side = |p: &[f64; 2], q: &[f64; 2], r: [f64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let area = side(&a.at, &b.at, c.at);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let range = |axis: usize| {
            let all = [a.at[axis], b.at[axis], c.at[axis]];
            let (low, high) = all
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| {
                    (x.min(l), x.max(h))
                });
            // Conversions to integers saturate.
            (low - 0.5).ceil().max(0.0) as usize
                ..((high - 0.5).floor() + 1.0).clamp(0.0, self.size[axis] as f64) as usize
        };
        for y in range(1) {
            for x in range(0) {
                let at = [x as f64 + 0.5, y as f64 + 0.5];
                let weights = [
                    side(&b.at, &c.at, at),
                    side(&c.at, &a.at, at),
                    side(&a.at, &b.at, at),
                ]
                .map(|w| w / area);
                if weights.iter().any(|&w| w < 0.0) {
                    continue;
                }
                let mix = |of: &dyn Fn(&Projected<N>) -> f64| {
                    weights[0] * of(&a) + weights[1] * of(&b) + weights[2] * of(&c)
                };
                let nearness = mix(&|corner| corner.nearness);
                let values = std::array::from_fn(|i| mix(&|corner| corner.values[i]) / nearness);
                each(Sample {
                    x,
                    y,
                    nearness,
                    values,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: Lens = Lens {
        size: [64, 48],
        focal_length: 50.0,
        near: 0.1,
    };

    /// Samples of the plane z = 2 + 0.5 x through three points, with x and y as values.
    fn samples(corners: [[f64; 2]; 3]) -> Vec<Sample<2>> {
        let mut out = Vec::new();
        let seen = corners.map(|[x, y]| (Vector3::new(x, y, 2.0 + 0.5 * x), [x, y]));
        LENS.each_sample(&seen, &mut |sample| out.push(sample));
        out
    }

    #[test]
    fn values_of_samples_equal_where_their_rays_meet_the_plane() {
        let found = samples([[-1.0, -1.0], [1.0, -0.8], [0.2, 1.0]]);
        assert!(found.len() > 300);
        for Sample {
            x,
            y,
            nearness,
            values,
        } in found
        {
            let ray = [
                (x as f64 + 0.5 - 32.0) / 50.0,
                (y as f64 + 0.5 - 24.0) / 50.0,
            ];
            // z = 2 + ½ ray_x z
            let z = 2.0 / (1.0 - 0.5 * ray[0]);
            assert!((nearness * z - 1.0).abs() < 1e-12);
            assert!(
                (values[0] - ray[0] * z).abs() < 1e-12 && (values[1] - ray[1] * z).abs() < 1e-12
            );
        }
    }

    #[test]
    fn a_triangle_that_reaches_behind_the_eye_covers_what_is_in_front() {
        // z = 2 + ½ x is 0 at x = −4: the left part is behind the eye.
        let found = samples([[-40.0, -1.0], [0.0, -1.0], [0.0, 1.0]]);
        assert!(
            !found.is_empty()
                && found
                    .iter()
                    .all(|sample| sample.nearness <= 1.0 / LENS.near)
        );
        // To the left of the middle, x < 0.
        assert!(found.iter().all(|sample| sample.x < 32));
    }

    #[test]
    fn degenerate_and_infinite_triangles_have_no_samples() {
        assert!(samples([[0.0, 0.0], [1.0, 1.0], [0.5, 0.5]]).len() < 64);
        assert!(samples([[0.0, 0.0], [f64::NAN, 1.0], [0.5, 0.5]]).is_empty());
        assert!(samples([[1e300, 0.0], [1e300, 1.0], [1e300, 0.5]]).is_empty());
    }
}
