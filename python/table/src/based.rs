//! Velocities and accelerations that are given with the base in another representation.

use dualbody::Model;
use dualbody::dynamics::{BaseFrame, BaseQuantity};
use dualbody::scalar::Scalar;
use dualbody::spatial::Representation;

/// The velocity in the library's own representation.
pub fn velocity<T: Scalar>(m: &Model<T>, base: Representation, q: &[T], v: &[T]) -> Vec<T> {
    let base = BaseFrame::new(m, base);
    let own = base.from_representation(q, BaseQuantity::Velocity, v);
    own.as_slice().to_vec()
}

/// Velocity and acceleration in the library's own representation.
pub fn motion<T: Scalar>(
    m: &Model<T>,
    base: Representation,
    q: &[T],
    v: &[T],
    a: &[T],
) -> (Vec<T>, Vec<T>) {
    let v = velocity(m, base, q, v);
    let of = BaseQuantity::Acceleration { v: &v };
    let a = BaseFrame::new(m, base).from_representation(q, of, a);
    (v, a.as_slice().to_vec())
}
