//! Solver parameters `solref` and `solimp`, within the bounds that `MuJoCo` gives them.

use crate::contact::{Impedance, Reference, Sigmoid};
use crate::scalar::MapEach;

/// Defaults of the format.
pub(super) const SOLREF: [f64; 2] = [0.02, 1.0];
pub(super) const SOLIMP: [f64; 5] = [0.9, 0.95, 0.001, 0.5, 2.0];

/// Least and largest impedance, and the least width of its rise (m).
const LEAST_IMPEDANCE: f64 = 1e-4;
const LARGEST_IMPEDANCE: f64 = 0.9999;
const LEAST_WIDTH: f64 = 1e-15;

/// The reference acceleration of a `solref`: time constant and damping ratio, or both negative, stiffness and damping. A mixture counts as the default.
pub(super) fn reference(solref: [f64; 2], time_step: f64) -> Reference {
    let [one, two] = match solref {
        [one, two] if (one > 0.0) == (two > 0.0) => solref,
        _ => SOLREF,
    };
    match one > 0.0 {
        true => Reference::TimeConstant {
            time_constant: one.max(2.0 * time_step),
            damping_ratio: two,
        },
        false => Reference::Direct {
            stiffness: -one,
            damping: -two,
        },
    }
}

/// The impedance of a `solimp`. Without width it is constant.
pub(super) fn impedance([least, largest, width, midpoint, power]: [f64; 5]) -> Impedance {
    let bounded = |x: f64| x.clamp(LEAST_IMPEDANCE, LARGEST_IMPEDANCE);
    let [mut least, mut largest] = [least, largest].map_each(bounded);
    if width <= LEAST_WIDTH {
        least = 0.5 * (least + largest);
        largest = least;
    }
    let sigmoid = match (midpoint, power) {
        (0.5, 2.0) => Sigmoid::default(),
        _ => Sigmoid::new(bounded(midpoint), power.max(1.0)),
    };
    Impedance {
        least,
        largest,
        width: width.max(LEAST_WIDTH),
        sigmoid,
    }
}
