//! Impedance of regularised rows as a function of the error, of contacts the depth: how strictly the row holds.

use crate::numbers::{Numbers, numbers};
use crate::scalar::{MapEach, Over, Scalar};

/// The impedance d as a function of the depth, or of the error of a constraint: from `least` at zero to `largest` at `width`, along a sigmoid. In
/// `MuJoCo` these are the entries of `solimp` in this order: `least`, `largest`, `width`, midpoint and power of the sigmoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impedance<P = f64> {
    /// d at the surface, in (0, 1).
    pub least: P,
    /// d at depths of `width` and more, in (0, 1).
    pub largest: P,
    /// Depth at which d reaches `largest`, m.
    pub width: P,
    /// Curve from the least to the largest impedance.
    pub sigmoid: Sigmoid<P>,
}

/// A curve s(x) from (0, 0) to (1, 1) through (m, m), with its midpoint m and power p:
///
/// s = m (x / m)ᵖ  up to m,  s = 1 − (1 − m) ((1 − x) / (1 − m))ᵖ  beyond.
///
/// Value and slope are continuous. For p > 1 the slope is zero at both ends; p = 1 is the straight line. The default, m = ½ and p = 2, needs no power function.
///
/// # Examples
/// ```
/// use dualbody::contact::Sigmoid;
///
/// let (quadratic, cubic) = (Sigmoid::<f64>::default(), Sigmoid::<f64>::new(0.5, 3.0));
/// assert_eq!(quadratic.at(0.25), 0.125); // 2 x²
/// let s: f64 = cubic.at(0.25);
/// assert!((s - 0.0625).abs() < 1e-15); // 4 x³
/// ```
///
/// Value and slope are continuous; the curvature jumps at the midpoint, and so do second derivatives of a step there (at half the width with
/// the default).
///
/// # References
/// The chapter on modeling of the manual of `MuJoCo`, solver parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigmoid<P = f64> {
    /// `None` for the default.
    shape: Option<Shape<P>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape<P> {
    midpoint: P,
    power: P,
}

numbers! { pub struct Impedance {
    least: Fraction("least impedance"),
    largest: Fraction("largest impedance"),
    width: Positive("impedance width", "width of the impedance"),
    sigmoid: part(Sigmoid),
} }

numbers! { pub struct Sigmoid { shape: part(Shape) } }

numbers! { struct Shape {
    midpoint: Fraction("impedance midpoint", "midpoint"),
    power: AtLeastOne("impedance power", "power"),
} }

impl Default for Impedance {
    /// The defaults of `MuJoCo`: from 0.9 to 0.95 over 1 mm.
    fn default() -> Self {
        Self {
            least: 0.9,
            largest: 0.95,
            width: 1e-3,
            sigmoid: Sigmoid::default(),
        }
    }
}

impl<P> Default for Sigmoid<P> {
    /// Midpoint ½ and power 2.
    fn default() -> Self {
        Self { shape: None }
    }
}

impl<P: Scalar> Impedance<P> {
    /// That of two surfaces: the means of all parameters.
    pub(crate) fn between(&self, other: &Self) -> Self {
        let mean = |a: P, b: P| (a + b) * 0.5;
        let curves = [&self.sigmoid, &other.sigmoid];
        let has_default = curves.iter().all(|own| own.shape.is_none());
        let [a, b] = curves.map_each(|own| [own.midpoint(), own.power()]);
        let shape = Shape {
            midpoint: mean(a[0], b[0]),
            power: mean(a[1], b[1]),
        };
        Self {
            least: mean(self.least, other.least),
            largest: mean(self.largest, other.largest),
            width: mean(self.width, other.width),
            sigmoid: Sigmoid {
                shape: (!has_default).then_some(shape),
            },
        }
    }

    /// d at a depth δ (m): least + (largest − least) s(x),  x = δ / width within 0 and 1.
    pub fn at<T: Over<P>>(&self, depth: T) -> T {
        let x = (depth / T::from(self.width)).clamp(0.0, 1.0);
        self.sigmoid.at(x) * (self.largest - self.least) + self.least
    }
}

impl<P: Scalar> Sigmoid<P> {
    /// The curve with a midpoint and a power, over any scalar: over dual numbers, for derivatives in both.
    ///
    /// * `midpoint` – m, between 0 and 1; a larger value keeps d near `least` over a longer range
    /// * `power` – p, at least 1; a larger value makes the curve flatter at both ends and steeper between
    ///
    /// # Panics
    /// If one of them is not in its range.
    pub fn new(midpoint: P, power: P) -> Self {
        let shape = Shape { midpoint, power };
        shape.check_numbers();
        Self { shape: Some(shape) }
    }

    /// m.
    pub fn midpoint(&self) -> P {
        self.shape.map_or(P::constant(0.5), |shape| shape.midpoint)
    }

    /// p.
    pub fn power(&self) -> P {
        self.shape.map_or(P::constant(2.0), |shape| shape.power)
    }

    /// s(x) for x within 0 and 1.
    pub fn at<T: Over<P>>(&self, x: T) -> T {
        let rest = -x + 1.0;
        let Some(Shape { midpoint, power }) = self.shape else {
            // 2 x² and 1 − 2 (1 − x)²
            let half = T::constant(0.5);
            return x.select_lt(half, x * x * 2.0, -(rest * rest * 2.0) + 1.0);
        };
        let m = T::from(midpoint);
        let after = -m + 1.0;
        let z = x.select_lt(m, x / m, rest / after);
        let z = power_of(z, power);
        x.select_lt(m, m * z, -(after * z) + 1.0)
    }
}

/// zᵖ for z ≥ 0; nothing at 0.
fn power_of<P: Scalar, T: Over<P>>(z: T, power: P) -> T {
    let zero = T::zero();
    let positive = zero.select_lt(z, z, T::one());
    zero.select_lt(z, (positive.ln() * power).exp(), zero)
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    /// The formula of `MuJoCo`'s manual: a xᵖ and 1 − b (1 − x)ᵖ.
    fn documented(x: f64, m: f64, p: f64) -> f64 {
        let (a, b) = (m.powf(1.0 - p), (1.0 - m).powf(1.0 - p));
        if x <= m {
            a * x.powf(p)
        } else {
            1.0 - b * (1.0 - x).powf(p)
        }
    }

    const SHAPES: [(f64, f64); 6] = [
        (0.5, 2.0),
        (0.3, 2.0),
        (0.7, 3.5),
        (0.9, 1.2),
        (0.4, 1.0),
        (0.05, 6.0),
    ];

    #[test]
    fn sigmoid_equals_the_documented_formula() {
        for (m, p) in SHAPES {
            let sigmoid = Sigmoid::new(m, p);
            for k in 0..=40 {
                let x = f64::from(k) / 40.0;
                let (s, expected) = (sigmoid.at(x), documented(x, m, p));
                assert!(
                    (s - expected).abs() < 1e-14,
                    "({m}, {p}) at {x}: {s} {expected}"
                );
            }
            assert_eq!((sigmoid.at(0.0), sigmoid.at(1.0)), (0.0, 1.0));
        }
        // By hand: 0.3 (0.1 / 0.3)² and 1 − 0.7 (0.2 / 0.7)².
        let sigmoid = Sigmoid::new(0.3, 2.0);
        assert!((sigmoid.at(0.1) - 1.0 / 30.0).abs() < 1e-15);
        assert!((sigmoid.at(0.8) - (1.0 - 0.04 / 0.7)).abs() < 1e-15);
    }

    #[test]
    fn default_sigmoid_equals_that_with_its_numbers() {
        let default = Sigmoid::<f64>::default();
        assert_eq!((default.midpoint(), default.power()), (0.5, 2.0));
        let given = Sigmoid::new(0.5, 2.0);
        for k in 0..=40 {
            let x = f64::from(k) / 40.0;
            assert!((default.at(x) - given.at(x)).abs() < 1e-15, "{x}");
        }
    }

    #[test]
    fn sigmoid_and_its_slope_are_continuous() {
        for (m, p) in SHAPES {
            let slope = |x: f64| Sigmoid::new(m, p).at(Dual64::from_re(x).derivative());
            let (before, after) = (slope(m - 1e-9), slope(m + 1e-9));
            assert!((before.re - after.re).abs() < 1e-7, "({m}, {p})");
            assert!((before.eps - after.eps).abs() < 1e-6, "({m}, {p})");
            assert!((slope(m).eps - p).abs() < 1e-12, "({m}, {p})");
            for end in [0.0, 1.0] {
                assert!(slope(end).eps.is_finite(), "({m}, {p}) at {end}");
            }
            if p > 1.5 {
                assert!(slope(1e-9).eps < 1e-3 && slope(1.0 - 1e-9).eps < 1e-3);
            }
        }
    }

    #[test]
    fn derivatives_in_midpoint_and_power_equal_finite_differences() {
        for (m, p) in SHAPES.into_iter().filter(|&(_, p)| p > 1.0) {
            for x in [0.02, 0.2, 0.55, 0.97] {
                let at = |m: Dual64, p: Dual64| Sigmoid::new(m, p).at(Dual64::from_re(x)).eps;
                let (dm, dp) = (Dual64::from_re(m), Dual64::from_re(p));
                let by = 1e-6;
                let of_m = documented(x, m + by, p) - documented(x, m - by, p);
                let of_p = documented(x, m, p + by) - documented(x, m, p - by);
                let errors = [
                    at(dm.derivative(), dp) - of_m / (2.0 * by),
                    at(dm, dp.derivative()) - of_p / (2.0 * by),
                ];
                assert!(
                    errors.iter().all(|e| e.abs() < 1e-8),
                    "({m}, {p}): {errors:?}"
                );
            }
        }
    }

    #[test]
    fn impedance_goes_from_the_least_to_the_largest() {
        let sigmoid = Sigmoid::new(0.3, 2.0);
        let impedance = Impedance {
            sigmoid,
            ..Impedance::default()
        };
        let [above, quarter, deep] = [-1e-3, 1e-4, 1.0].map(|depth: f64| impedance.at(depth));
        assert_eq!((above, deep), (0.9, 0.95));
        assert!((quarter - (0.9 + 0.05 / 30.0)).abs() < 1e-15, "{quarter}");
    }

    #[test]
    #[should_panic(expected = "a midpoint of 1 is not between 0 and 1")]
    fn midpoint_at_an_end_is_refused() {
        let _ = Sigmoid::new(1.0, 2.0);
    }

    #[test]
    #[should_panic(expected = "a power of 0.5 is not finite and at least 1")]
    fn power_below_one_is_refused() {
        let _ = Sigmoid::new(0.5, 0.5);
    }
}
