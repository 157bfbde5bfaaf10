//! The normals of an ellipse through a point.

use std::f64::consts::FRAC_1_SQRT_2;

/// Most steps of Newton's method, which come from one side: some five.
const MAX_STEPS: usize = 20;
/// Change of the parameter that is rounding, in the square of the larger semi-axis.
const LAST_STEP: f64 = 1e-14;
/// Ratio of semi-axes below which an ellipse is a segment.
const FLAT: f64 = 1e-12;

/// The unit normal of an ellipse in its first quarter along which a point is nearest to the ellipse of all points of that quarter, or least deep in it. `None` where
/// there is no such normal, or where the distance is not above `least`.
///
/// * `at` – the point from the centre, along the axes; the first coordinate not negative
/// * `semi_axes` – the first not below the second
///
/// With the parameter t the point of the ellipse is `(a² x / (t + a²), b² y / (t + b²))`, and  F(t) = (a x / (t + a²))² + (b y / (t + b²))² − 1  vanishes. F is convex between its
/// poles; the nearest point has the largest root for which it is in this quarter, which Newton's method meets from where F is positive.
pub(super) fn normal_of_quarter(
    [x, y]: [f64; 2],
    [a, b]: [f64; 2],
    least: f64,
) -> Option<[f64; 2]> {
    // The ellipse contains the middles between its tips.
    let [u, v] = [x - FRAC_1_SQRT_2 * a, y - FRAC_1_SQRT_2 * b];
    if b <= FLAT * a || (u < 0.0 && v < 0.0 && u.max(v) <= least) {
        return None;
    }
    let (aa, bb) = (a * a, b * b);
    let mut t = b * y - bb;
    if y >= 0.0 {
        t = t.max(a * x - aa);
    }
    for _ in 0..MAX_STEPS {
        let [p, q] = [1.0 / (t + aa), 1.0 / (t + bb)];
        let [k, l] = [a * x * p, b * y * q];
        let [f, g] = [k * k, l * l];
        // At the pole the second part is what is left.
        let g = if t == -bb { (1.0 - f).max(0.0) } else { g };
        let slope = -2.0 * (f * p + g * q);
        let is_below = y < 0.0 && (slope <= 0.0 || t <= -aa);
        if is_below {
            return None;
        }
        let step = (f + g - 1.0) / slope;
        if step.is_nan() || step.abs() <= LAST_STEP * aa {
            break;
        }
        t -= step;
    }
    let n_x = x / (t + aa);
    let n_y = (1.0 - aa * n_x * n_x).max(0.0).sqrt() / b;
    let length = (n_x * n_x + n_y * n_y).sqrt();
    let [c, s] = [n_x / length, n_y / length];
    let distance = x * c + y * s - (aa * c * c + bb * s * s).sqrt();
    (distance > least).then_some([c, s])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    // x cos φ + y sin φ − √(a² cos² φ + b² sin² φ) over the quarter.
    #[test]
    fn distance_equals_the_largest_of_brute_force_inside_the_quarter() {
        const COUNT: usize = 20_000;
        let mut n_found = 0;
        for k in 0..400 {
            let at = |step: f64| (step * f64::from(k)).sin();
            let [x, y] = [1.3 * at(1.7).abs(), 1.3 * at(2.9)];
            let [a, b] = [1.0, 0.02 + 0.9 * at(0.37).abs()];
            let distance = |c: f64, s: f64| x * c + y * s - (a * c).hypot(b * s);
            let angles = (0..=COUNT).map(|k| FRAC_PI_2 * k as f64 / COUNT as f64);
            let values: Vec<f64> = angles.map(|phi| distance(phi.cos(), phi.sin())).collect();
            let peaks = values.windows(3).filter(|w| w[1] > w[0] && w[1] > w[2]);
            let peak = peaks.map(|w| w[1]).fold(f64::NEG_INFINITY, f64::max);
            let found = normal_of_quarter([x, y], [a, b], f64::NEG_INFINITY);
            if peak.is_finite() {
                let [c, s] = found.expect("a normal");
                assert!((c.hypot(s) - 1.0).abs() < 1e-12 && c >= 0.0 && s >= 0.0);
                let off = distance(c, s) - peak;
                assert!(off > -1e-12 && off < 1e-6, "{k}: {off:e}");
                n_found += 1;
                let least = peak + 1e-3;
                assert_eq!(normal_of_quarter([x, y], [a, b], least), None, "{k}");
            }
        }
        assert!(n_found > 100, "{n_found}");
    }

    #[test]
    fn points_without_a_normal_and_segments_have_none() {
        assert_eq!(normal_of_quarter([0.9, -0.5], [1.0, 0.5], -9.0), None);
        assert_eq!(normal_of_quarter([0.5, 0.5], [1.0, 0.0], -9.0), None);
        let [c, s] = normal_of_quarter([0.0, 0.2], [1.0, 0.5], -9.0).expect("a normal");
        assert_eq!([c, s], [0.0, 1.0]);
    }
}
