//! Conversions of the base velocity, by the function.

use dualbody::dynamics::{BaseFrame, BaseQuantity};
use dualbody::spatial::Representation;
use dualbody::{Model, Scalar};
use nalgebra::DVector;

macro_rules! conversions {
    ($($to:ident $from:ident $quantity:ident ($($v:ident)?);)*) => {$(
        pub(crate) fn $to<T: Scalar + dualbody::Over<f64>>(
            model: &Model, q: &[T], $($v: &[T],)? x: &[T], to: Representation,
        ) -> DVector<T> {
            BaseFrame::new(model, to).to_representation(q, BaseQuantity::$quantity $({ $v })?, x)
        }

        pub(crate) fn $from(
            model: &Model, q: &[f64], $($v: &[f64],)? x: &[f64], from: Representation,
        ) -> DVector<f64> {
            BaseFrame::new(model, from).from_representation(q, BaseQuantity::$quantity $({ $v })?, x)
        }
    )*};
}

conversions! {
    velocity_to velocity_from Velocity ();
    acceleration_to acceleration_from Acceleration (v);
    force_to force_from Force ();
    deviation_to deviation_from Deviation (v);
    gradient_to gradient_from Gradient (v);
}
