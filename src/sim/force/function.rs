//! Forces as a user's function.

use std::fmt;
use std::sync::Arc;

use crate::scalar::{Dual, Over, Scalar, is_more_than_values};
use crate::spatial::transform::TRANSFORM_ENTRIES;
use crate::spatial::{Force, Motion, SPATIAL, Transform};

/// A force that follows how a place moves, written over the scalar.
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
/// First derivatives only: second ones (exact curvature in trajectory optimisation, Hessians) panic with a message that says so.
pub trait ForceFunction: Send + Sync + 'static {
    /// The force on the place (N, and N·m about the origin of its representation).
    ///
    /// * `pose` – of the place in the world
    /// * `velocity` – of the place in the world, in the representation that the force has too (m/s, rad/s)
    /// * `parameters` – those that the force was made with
    fn force<T: Scalar>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        parameters: &[T],
    ) -> Force<T>;
}

/// The most parameters of a function.
pub const MAX_FORCE_PARAMETERS: usize = 8;

/// Entries of pose and velocity of a place.
const PLACE: usize = TRANSFORM_ENTRIES + SPATIAL;

/// All that a function depends on.
const DIRECTIONS: usize = PLACE + MAX_FORCE_PARAMETERS;

/// A force with its derivatives.
#[derive(Clone, Copy, Debug)]
struct Jet {
    force: [f64; SPATIAL],
    /// Of each coordinate in each entry of the place, then in each parameter.
    slopes: [[f64; DIRECTIONS]; SPATIAL],
}

/// Force function with its type erased.
trait ErasedForce: Send + Sync {
    fn value(&self, place: &[f64; PLACE], parameters: &[f64]) -> [f64; SPATIAL];

    fn jet(&self, place: &[f64; PLACE], parameters: &[f64]) -> Jet;
}

impl<F: ForceFunction> ErasedForce for F {
    fn value(&self, place: &[f64; PLACE], parameters: &[f64]) -> [f64; SPATIAL] {
        evaluate(self, place, parameters).to_array()
    }

    fn jet(&self, place: &[f64; PLACE], parameters: &[f64]) -> Jet {
        let place = std::array::from_fn(|k| Dual::variable(place[k], k));
        let mut lifted = [Dual::from(0.0); MAX_FORCE_PARAMETERS];
        for (k, (out, &own)) in lifted.iter_mut().zip(parameters).enumerate() {
            *out = Dual::variable(own, PLACE + k);
        }
        let force: Force<Dual<f64, DIRECTIONS>> =
            evaluate(self, &place, &lifted[..parameters.len()]);
        let force = force.to_array();
        Jet {
            force: force.map(|x| x.re),
            slopes: force.map(|x| x.eps),
        }
    }
}

fn evaluate<F: ForceFunction, T: Scalar>(
    function: &F,
    place: &[T; PLACE],
    parameters: &[T],
) -> Force<T> {
    let pose = Transform::from_entries(std::array::from_fn(|k| place[k]));
    let velocity = Motion::from_array(std::array::from_fn(|k| place[TRANSFORM_ENTRIES + k]));
    function.force(&pose, &velocity, parameters)
}

/// A [`ForceFunction`] with its parameters.
#[derive(Clone)]
pub(super) struct Function<P> {
    function: Arc<dyn ErasedForce>,
    parameters: Vec<P>,
}

impl<P: fmt::Debug> fmt::Debug for Function<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Function")
            .field("parameters", &self.parameters)
            .finish_non_exhaustive()
    }
}

impl Function<f64> {
    pub(super) fn new(function: impl ForceFunction, parameters: &[f64]) -> Self {
        let n = parameters.len();
        assert!(
            n <= MAX_FORCE_PARAMETERS,
            "{n} parameters of a force, at most {MAX_FORCE_PARAMETERS} are possible"
        );
        Self {
            function: Arc::new(function),
            parameters: parameters.to_vec(),
        }
    }
}

impl Function<f64> {
    /// Hands the derivative of the force in each parameter to `each`: a plain number, as functions have first derivatives only.
    pub(super) fn each_slope<T: Scalar>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        each: &mut dyn FnMut(Force<T>),
    ) {
        let mut place = [0.0; PLACE];
        let (pose, velocity) = (pose.to_entries(), velocity.to_array());
        let numbers = pose.iter().chain(&velocity);
        place
            .iter_mut()
            .zip(numbers)
            .for_each(|(out, x)| *out = x.value(0));
        let jet = self.function.jet(&place, &self.parameters);
        for k in PLACE..PLACE + self.parameters.len() {
            each(Force::from_array(
                jet.slopes.map(|slopes| T::constant(slopes[k])),
            ));
        }
    }
}

impl<P: Scalar> Function<P> {
    pub(super) fn parameters(&self) -> &[P] {
        &self.parameters
    }

    pub(super) fn parameters_mut(&mut self) -> &mut [P] {
        &mut self.parameters
    }

    pub(super) fn cast<Q: Over<P>>(&self) -> Function<Q> {
        let parameters = self.parameters.iter().map(|&x| x.into());
        self.with_parameters(&parameters.collect::<Vec<Q>>())
    }

    pub(super) fn with_parameters<Q: Scalar>(&self, parameters: &[Q]) -> Function<Q> {
        let (given, own) = (parameters.len(), self.parameters.len());
        assert_eq!(given, own, "the force has {own} parameters");
        Function {
            function: Arc::clone(&self.function),
            parameters: parameters.to_vec(),
        }
    }

    /// Values from the function, derivatives by the chain rule:  F(x) + Σ ∂F/∂xᵢ (xᵢ − value of xᵢ), lane by lane.
    pub(super) fn force<T: Over<P>>(&self, pose: &Transform<T>, velocity: &Motion<T>) -> Force<T> {
        assert!(
            T::ORDER <= 1,
            "a force given as a function has first derivatives only"
        );
        let mut x = [T::zero(); DIRECTIONS];
        x[..TRANSFORM_ENTRIES].copy_from_slice(&pose.to_entries());
        x[TRANSFORM_ENTRIES..PLACE].copy_from_slice(&velocity.to_array());
        let own = x[PLACE..].iter_mut().zip(&self.parameters);
        own.for_each(|(x, &parameter)| *x = parameter.into());
        let mut out = [T::zero(); SPATIAL];
        for lane in 0..T::LANES {
            self.add_lane(&x, lane, &mut out);
        }
        Force::from_array(out)
    }

    fn add_lane<T: Scalar>(&self, x: &[T; DIRECTIONS], lane: usize, out: &mut [T; SPATIAL]) {
        let in_lane = |value: f64| T::from_values(|l| if l == lane { value } else { 0.0 });
        let at = x.map(|x| x.value(lane));
        let (place, parameters) = at.split_at(PLACE);
        let place = std::array::from_fn(|k| place[k]);
        let parameters = &parameters[..self.parameters.len()];
        if !is_more_than_values::<T>() {
            let force = self.function.value(&place, parameters);
            let both = out.iter_mut().zip(force);
            return both.for_each(|(out, f)| *out += in_lane(f));
        }
        let jet = self.function.jet(&place, parameters);
        for ((out, f), slopes) in out.iter_mut().zip(jet.force).zip(&jet.slopes) {
            *out += in_lane(f);
            let used = PLACE + parameters.len();
            for ((&x, &value), &slope) in x.iter().zip(&at).zip(slopes).take(used) {
                *out += (x - in_lane(value)) * in_lane(slope);
            }
        }
    }
}
