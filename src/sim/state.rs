//! The state of a robot.

use nalgebra::DVector;
use rand::Rng;

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

    /// The deviation δx = (q ⊖ q₀, v − v₀) from a reference state in tangent coordinates, length 2 `nv`: what a linear controller
    /// designed at the reference acts on. Allocates.
    ///
    /// # Panics
    /// If a state has the wrong length.
    pub fn deviation<P: Scalar>(&self, model: &Model<P>, reference: &Self) -> DVector<T> {
        let nv = model.nv();
        model.check_v(self.v.as_slice());
        model.check_v(reference.v.as_slice());
        let mut out = DVector::zeros(2 * nv);
        let (dq, dv) = out.as_mut_slice().split_at_mut(nv);
        model.difference_into(reference.q.as_slice(), self.q.as_slice(), dq);
        for (k, dv) in dv.iter_mut().enumerate() {
            *dv = self.v[k] - reference.v[k];
        }
        out
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

impl State<f64> {
    /// A random state: the configuration as in [`Model::random_configuration`], the velocity as in [`Model::random_velocity`].
    ///
    /// # Panics
    /// If `speed` is negative or not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{State, model::samples};
    /// use rand::{SeedableRng, rngs::Xoshiro256PlusPlus};
    ///
    /// let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    /// let state = State::random(&samples::cartpole(), &mut rng, 0.5);
    /// assert!(state.q[0].abs() < 2.4 && state.v.amax() < 0.5);
    /// ```
    pub fn random<R: Rng + ?Sized>(model: &Model, rng: &mut R, speed: f64) -> Self {
        Self {
            q: model.random_configuration(rng),
            v: model.random_velocity(rng, speed),
        }
    }
}
