//! The state of a robot.

use nalgebra::DVector;

use crate::model::Model;
use crate::scalar::Scalar;

/// Configuration and velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct State<T: Scalar = f64> {
    /// Configuration, length `nq`.
    pub q: DVector<T>,
    /// Velocity in tangent coordinates, length `nv`.
    pub v: DVector<T>,
}

impl<T: Scalar> State<T> {
    /// From slices.
    ///
    /// # Examples
    /// ```
    /// use dualbody::State;
    ///
    /// let state = State::new(&[0.5, -0.7], &[0.0, 0.0]);
    /// assert_eq!(state.q[1], -0.7);
    /// ```
    pub fn new(q: &[T], v: &[T]) -> Self {
        Self {
            q: DVector::from_column_slice(q),
            v: DVector::from_column_slice(v),
        }
    }

    /// The neutral configuration at rest.
    pub fn neutral<P: Scalar>(model: &Model<P>) -> Self {
        Self {
            q: model.neutral().map(T::constant),
            v: DVector::zeros(model.nv()),
        }
    }

    /// The same state over another scalar, without derivatives.
    pub fn lift<S: From<T> + Scalar>(&self) -> State<S> {
        State {
            q: self.q.map(<S as From<T>>::from),
            v: self.v.map(<S as From<T>>::from),
        }
    }
}

impl State<f64> {
    /// `true` if every number is finite.
    pub fn is_finite(&self) -> bool {
        self.q.iter().chain(&self.v).all(|x| x.is_finite())
    }
}
