//! Checks of the numbers that are given to the library: each panics with the quantity and its value where a lane of it
//! makes no sense.

use crate::scalar::Scalar;

/// # Panics
/// If a number is infinite or not a number.
pub(crate) fn finite<P: Scalar>(quantity: &str, x: P) {
    each_lane([x], |[x]| {
        assert!(x.is_finite(), "the {quantity} is {x}: not finite");
    });
}

/// Whether a number is neither infinite nor NaN, in every lane.
pub(crate) fn is_finite<P: Scalar>(x: P) -> bool {
    !x.has_value() || (0..P::LANES).all(|lane| x.value(lane).is_finite())
}

/// # Panics
/// If a number is not positive and finite.
pub(crate) fn positive<P: Scalar>(quantity: &str, x: P) {
    each_lane([x], |[x]| {
        let good = x > 0.0 && x.is_finite();
        assert!(good, "the {quantity} is {x}: not positive and finite");
    });
}

/// # Panics
/// If a number is negative or not finite.
pub(crate) fn not_negative<P: Scalar>(quantity: &str, x: P) {
    each_lane([x], |[x]| {
        let good = x >= 0.0 && x.is_finite();
        assert!(good, "the {quantity} is {x}: negative or not finite");
    });
}

/// # Panics
/// If a number is negative or not a number; infinity is a number here.
pub(crate) fn not_negative_or_infinite<P: Scalar>(quantity: &str, x: P) {
    each_lane([x], |[x]| {
        assert!(x >= 0.0, "the {quantity} is {x}: negative or not a number");
    });
}

/// # Panics
/// If a number is not within 0 and 1.
pub(crate) fn within_one<P: Scalar>(quantity: &str, x: P) {
    each_lane([x], |[x]| {
        let good = (0.0..=1.0).contains(&x);
        assert!(good, "the {quantity} is {x}: not in 0..1");
    });
}

/// Hands the values of some numbers to a check, lane by lane; nothing where one of them has none.
pub(crate) fn each_lane<P: Scalar, const N: usize>(x: [P; N], check: impl Fn([f64; N])) {
    if x.iter().all(P::has_value) {
        (0..P::LANES).for_each(|lane| check(x.map(|x| x.value(lane))));
    }
}
