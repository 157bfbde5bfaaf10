//! Conversion of values to another scalar.

use super::{Over, Scalar};

/// Conversion of a value with parameters over the scalar `P` to another scalar: contact models, motors, constraints, poses, states.
///
/// [`Model`](crate::Model::cast) and [`Simulator`](crate::Simulator::cast) have methods of the same name.
///
/// # Examples
/// ```
/// use dualbody::{Cast, contact::{ContactLaw, RelaxedRigid}, scalar::Dual};
///
/// let law: ContactLaw = ContactLaw::RelaxedRigid(RelaxedRigid::default());
/// let over: ContactLaw<Dual<f64, 1>> = law.cast();
/// # let _ = over;
/// ```
pub trait Cast<P: Scalar> {
    /// The type over another scalar.
    type To<Q: Scalar>;

    /// Converts the numbers to another scalar, without derivatives.
    fn cast<Q: Over<P>>(&self) -> Self::To<Q>;
}
