//! Forces given by user functions.

use std::fmt;
use std::sync::Arc;

use crate::numbers::numbers;
use crate::scalar::{Dual, MapEach, Over, Scalar, from_each};
use crate::sim::user_function::{Erased, NumberFunction, erase, evaluate};
use crate::spatial::transform::TRANSFORM_ENTRIES;
use crate::spatial::{Force, Motion, SPATIAL, Transform};

/// A force as a function of the motion of an attachment frame, generic over the scalar.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, Simulator, constraint::Anchor, model::{LinkSpec, ModelBuilder}};
/// use dualbody::sim::{ExternalForce, ForceFunction};
/// use dualbody::spatial::{Force, Motion, Representation, Transform};
/// use nalgebra::Vector3;
///
/// /// Drag in a wind along x:  −c |v − w| (v − w)  with the parameters c (kg/m) and w (m/s).
/// struct Drag;
/// impl ForceFunction for Drag {
///     fn force<T: Scalar>(&self, _: &Transform<T>, velocity: &Motion<T>, parameters: &[T]) -> Force<T> {
///         let mut v = velocity.linear;
///         v.x -= parameters[1];
///         // Still air needs no root of zero.
///         let speed = (v.x * v.x + v.y * v.y + v.z * v.z + 1e-12).sqrt();
///         Force::new(v * (speed * parameters[0] * -1.0), Vector3::zeros())
///     }
/// }
/// let mut builder = ModelBuilder::new("ball");
/// builder.add_link(LinkSpec::new("ball").with_mass(0.1, [0.0; 3], [1e-4; 3]));
/// let model = builder.build()?;
/// let place = Anchor::frame(&model, "ball")?;
/// let drag = ExternalForce::function(place, Drag, &[0.01, 3.0], Representation::Mixed);
/// let falling = Simulator::new(model).with_external_forces(vec![drag]).with_time_step(0.01);
/// let end = falling.rollout(&falling.neutral_state(), 3000, |_, _, _| {}).last().clone();
/// // It ends with the wind, where drag carries the weight: c v² = m g.
/// assert!((end.v[0] - 3.0).abs() < 1e-6 && (end.v[2] + f64::sqrt(0.1 * 9.81 / 0.01)).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Limitations
/// First and second derivatives only: third derivatives panic with a message. [`Traced`](crate::scalar::Traced) numbers record the function with all derivatives.
pub trait ForceFunction: Send + Sync + 'static {
    /// Computes the force at the attachment frame (N, and N·m about the origin of its representation).
    ///
    /// * `pose` – of the attachment frame in the world
    /// * `velocity` – of the attachment frame in the world, in the representation of the force (m/s, rad/s)
    /// * `parameters` – those that the force was made with
    fn force<T: Scalar>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        parameters: &[T],
    ) -> Force<T>;
}

/// Maximum number of parameters of a function.
pub const MAX_FORCE_PARAMETERS: usize = 8;

/// Entries of pose and velocity of an attachment frame.
const PLACE: usize = TRANSFORM_ENTRIES + SPATIAL;

/// All that a function depends on.
const DIRECTIONS: usize = PLACE + MAX_FORCE_PARAMETERS;

/// A force function as one of numbers: of the entries of pose and velocity, then the parameters.
struct OfNumbers<F>(F);

impl<F: ForceFunction> NumberFunction for OfNumbers<F> {
    fn evaluate<T: Scalar>(&self, x: &[T], out: &mut [T]) {
        let pose = Transform::from_entries(from_each(|k| x[k]));
        let velocity = Motion::from_array(from_each(|k| x[TRANSFORM_ENTRIES + k]));
        let force = self.0.force(&pose, &velocity, &x[PLACE..]);
        out.copy_from_slice(&force.to_array());
    }
}

/// A [`ForceFunction`] with its parameters.
#[derive(Clone)]
pub(super) struct Function<P> {
    function: Arc<dyn Erased<DIRECTIONS>>,
    parameters: Vec<P>,
}

impl<P: fmt::Debug> fmt::Debug for Function<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Function")
            .field("parameters", &self.parameters)
            .finish_non_exhaustive()
    }
}

numbers! { struct Function { function: kept(), parameters: parameters("parameter") } }

impl Function<f64> {
    pub(super) fn new(function: impl ForceFunction, parameters: &[f64]) -> Self {
        let n = parameters.len();
        assert!(
            n <= MAX_FORCE_PARAMETERS,
            "{n} parameters of a force, at most {MAX_FORCE_PARAMETERS} are possible"
        );
        Self {
            function: erase(OfNumbers(function)),
            parameters: parameters.to_vec(),
        }
    }

    /// Passes the derivative of the force in each parameter to `each`.
    pub(super) fn each_derivative<T: Scalar>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        each: &mut dyn FnMut(Force<T>),
    ) {
        let mut x = [Dual::<T, MAX_FORCE_PARAMETERS>::from(0.0); DIRECTIONS];
        let numbers = pose.to_entries().into_iter().chain(velocity.to_array());
        let place = x.iter_mut().zip(numbers);
        place.for_each(|(out, x)| *out = Dual::constant_of(x));
        for (k, &own) in self.parameters.iter().enumerate() {
            x[PLACE + k] = Dual::variable(T::constant(own), k);
        }
        let force = self.at(&x);
        for k in 0..self.parameters.len() {
            each(Force::from_array(force.map_each(|x| x.eps[k])));
        }
    }
}

impl<P: Scalar> Function<P> {
    pub(super) fn with_parameters<Q: Scalar>(&self, parameters: &[Q]) -> Function<Q> {
        let (given, own) = (parameters.len(), self.parameters.len());
        assert_eq!(given, own, "the force has {own} parameters");
        Function {
            function: Arc::clone(&self.function),
            parameters: parameters.to_vec(),
        }
    }

    pub(super) fn force<T: Over<P>>(&self, pose: &Transform<T>, velocity: &Motion<T>) -> Force<T> {
        let mut x = [T::zero(); DIRECTIONS];
        x[..TRANSFORM_ENTRIES].copy_from_slice(&pose.to_entries());
        x[TRANSFORM_ENTRIES..PLACE].copy_from_slice(&velocity.to_array());
        let own = x[PLACE..].iter_mut().zip(&self.parameters);
        own.for_each(|(x, &parameter)| *x = parameter.into());
        Force::from_array(self.at(&x))
    }

    fn at<T: Scalar>(&self, x: &[T; DIRECTIONS]) -> [T; SPATIAL] {
        let mut out = [T::zero(); SPATIAL];
        let (x, function) = (&x[..PLACE + self.parameters.len()], &*self.function);
        evaluate::<T, DIRECTIONS, DIRECTIONS, SPATIAL>(function, "a force", x, &mut out);
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::SAME_ALGEBRA;

    /// A force in which every number is multiplied with every other.
    struct Mixed;

    impl ForceFunction for Mixed {
        fn force<T: Scalar>(&self, X: &Transform<T>, V: &Motion<T>, parameters: &[T]) -> Force<T> {
            let numbers = X.to_entries().into_iter().chain(V.to_array());
            let sum = numbers
                .chain(parameters.iter().copied())
                .zip(0..)
                .fold(T::zero(), |sum, (x, k)| {
                    sum + x * T::constant(f64::from(k).cos())
                });
            let force = std::array::from_fn(|k| (sum * T::constant(1.0 + k as f64)).sin_cos().0);
            Force::from_array(force)
        }
    }

    // The function itself over hyper-dual numbers has the derivatives that its quadratic has to have.
    #[test]
    fn second_derivatives_equal_those_of_the_function_itself() {
        type Number = Dual<Dual<f64, 2>, 2>;
        let number = |k: usize| {
            let k = k as f64;
            let inner = |x: f64, y: f64| Dual::<f64, 2>::new(x, [y, y * y - 0.2]);
            Number::new(
                inner(k.sin(), 0.3 * k),
                [inner(k.cos(), 1.0), inner(0.1 * k, -0.4)],
            )
        };
        let entries = std::array::from_fn(number);
        let pose = Transform::from_entries(entries);
        let velocity = Motion::from_array(std::array::from_fn(|k| number(20 + k)));
        let parameters = [number(31), number(32)];
        let values = parameters.map(|x| x.value(0));
        let expected = Mixed.force(&pose, &velocity, &parameters).to_array();
        let found = Function::new(Mixed, &values).with_parameters(&parameters);
        let found = found.force(&pose, &velocity).to_array();
        for (found, expected) in found.into_iter().zip(expected) {
            let both = [found, expected].map(|x| {
                let parts = std::iter::once(x.re).chain(x.eps);
                parts
                    .flat_map(|x| std::iter::once(x.re).chain(x.eps))
                    .collect::<Vec<_>>()
            });
            for (x, y) in both[0].iter().zip(&both[1]) {
                assert!((x - y).abs() < SAME_ALGEBRA * y.abs().max(1.0), "{x} {y}");
            }
        }
    }

    #[test]
    #[should_panic(expected = "first and second derivatives only")]
    fn third_derivatives_are_refused() {
        type Number = Dual<Dual<Dual<f64, 1>, 1>, 1>;
        let at = Transform::<Number>::identity();
        Function::new(Mixed, &[]).force(&at, &Motion::zero());
    }
}
