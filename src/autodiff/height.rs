//! Derivatives of a user's terrain, for the law of contact that needs its slope and the derivatives of that.

use num_dual::{Dual, DualSVec64};

use crate::contact::{ErasedHeight, HeightFunction, Jet, MAX_TERRAIN_PARAMETERS};
use crate::scalar::Scalar;

/// Inside the derivatives in x and y, outside that in one direction.
type Nested = Dual<DualSVec64<2>>;

impl<F: HeightFunction> ErasedHeight for F {
    fn jet(&self, at: [f64; 2], parameters: &[f64], direction: usize) -> Jet {
        let along = |i: usize| if i == direction { 1.0 } else { 0.0 };
        let place = |axis: usize| {
            let inner = DualSVec64::from_re(at[axis]).derivative(axis);
            Dual::new(inner, along(axis).into())
        };
        let mut lifted = [Nested::constant(0.0); MAX_TERRAIN_PARAMETERS];
        for (k, (out, &own)) in lifted.iter_mut().zip(parameters).enumerate() {
            *out = Dual::new(own.into(), along(2 + k).into());
        }
        let h = self.height(place(0), place(1), &lifted[..parameters.len()]);
        let slope = |x: &DualSVec64<2>| {
            [
                x.eps.0.as_ref().map_or(0.0, |e| e[0]),
                x.eps.0.as_ref().map_or(0.0, |e| e[1]),
            ]
        };
        Jet {
            height: h.re.re,
            slope: slope(&h.re),
            along: h.eps.re,
            slope_along: slope(&h.eps),
        }
    }
}
