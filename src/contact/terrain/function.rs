//! Terrain given by a user function.

use std::fmt;
use std::sync::Arc;

use super::{Ground, PlanarDual};
use crate::numbers::{Domain, numbers};
use crate::scalar::traced::{Graph, Port, Traced, trace};
use crate::scalar::{Dual, MapEach, Over, Scalar, is_more_than_values};

/// A terrain height, generic over the scalar.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, contact::{HeightFunction, Terrain, TerrainFunction}};
///
/// /// Waves along x of an amplitude and a wave number.
/// struct Waves;
/// impl HeightFunction for Waves {
///     fn height<T: Scalar>(&self, x: T, _y: T, parameters: &[T]) -> T {
///         (x * parameters[1]).sin_cos().0 * parameters[0]
///     }
/// }
/// let sea = Terrain::Function(TerrainFunction::new(Waves, &[0.5, 2.0]));
/// assert_eq!(sea.surface(&0.0, &7.0).slope, [1.0, 0.0]); // amplitude · wave number
/// ```
pub trait HeightFunction: Send + Sync + 'static {
    /// h(x, y), m; `parameters` are those that the terrain was made with.
    fn height<T: Scalar>(&self, x: T, y: T, parameters: &[T]) -> T;
}

/// Maximum number of parameters of a function.
pub const MAX_TERRAIN_PARAMETERS: usize = 8;

/// A [`HeightFunction`] with its parameters.
///
/// # Limitations
/// The slope is a first derivative of the height, so first derivatives of contact need second derivatives of the height; these are computed. Second
/// derivatives of contact need a plane or a [`HeightField`](super::HeightField). The function is called with scalars of this crate; other scalars get
/// the tangent plane at their value. [`Traced`] numbers record the function with all derivatives.
#[derive(Clone)]
pub struct TerrainFunction<P = f64> {
    function: Arc<dyn ErasedHeight>,
    pub(super) parameters: Vec<P>,
}

numbers! { pub struct TerrainFunction {
    function: kept(),
    parameters: parameters("parameter of the terrain's function"),
} }

/// Height, slope and the derivatives of both in one direction of (x, y, parameters).
#[derive(Clone, Copy, Debug)]
struct Jet {
    height: f64,
    slope: [f64; 2],
    /// ∂h/∂i.
    along: f64,
    /// ∂²h/∂x∂i, ∂²h/∂y∂i.
    slope_along: [f64; 2],
}

/// Height function with its type erased.
trait ErasedHeight: Send + Sync {
    /// The jet at (x, y) in the direction of the i-th of (x, y, parameters).
    fn jet(&self, at: [f64; 2], parameters: &[f64], direction: usize) -> Jet;

    /// Height and slope as functions of (x, y, parameters), for numbers without values.
    fn graph(&self, parameters: usize) -> Graph;
}

/// Inside the derivatives in x and y, outside that in one direction.
type Nested = Dual<Dual<f64, 2>, 1>;

impl<F: HeightFunction> ErasedHeight for F {
    fn jet(&self, at: [f64; 2], parameters: &[f64], direction: usize) -> Jet {
        let along = |i: usize| [if i == direction { 1.0 } else { 0.0 }.into()];
        let place = |axis: usize| Nested::new(Dual::variable(at[axis], axis), along(axis));
        let mut lifted = [Nested::constant(0.0); MAX_TERRAIN_PARAMETERS];
        for (k, (out, &own)) in lifted.iter_mut().zip(parameters).enumerate() {
            *out = Dual::new(own.into(), along(2 + k));
        }
        let h = self.height(place(0), place(1), &lifted[..parameters.len()]);
        let [along] = h.eps;
        Jet {
            height: h.re.re,
            slope: h.re.eps,
            along: along.re,
            slope_along: along.eps,
        }
    }

    fn graph(&self, parameters: usize) -> Graph {
        trace(|t| {
            let x = t.input(Port::vector("x_y_parameters", 2 + parameters));
            let place = |axis: usize| Dual::<Traced, 2>::variable(x[axis], axis);
            let lifted: Vec<_> = x[2..].iter().map(|&x| Dual::constant_of(x)).collect();
            let h = self.height(place(0), place(1), &lifted);
            t.output(Port::number("height"), &[h.re]);
            t.output(Port::vector("slope", 2), &h.eps);
        })
    }
}

impl<P: fmt::Debug> fmt::Debug for TerrainFunction<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TerrainFunction")
            .field("parameters", &self.parameters)
            .finish_non_exhaustive()
    }
}

impl TerrainFunction<f64> {
    /// A function with its parameters (an empty slice for none).
    ///
    /// # Panics
    /// If there are more than [`MAX_TERRAIN_PARAMETERS`], or one is not finite.
    pub fn new(function: impl HeightFunction, parameters: &[f64]) -> Self {
        let n = parameters.len();
        assert!(
            n <= MAX_TERRAIN_PARAMETERS,
            "{n} parameters of a terrain, at most {MAX_TERRAIN_PARAMETERS} are possible"
        );
        for &x in parameters {
            Domain::Finite.check("parameter of a terrain", x);
        }
        Self {
            function: Arc::new(function),
            parameters: parameters.to_vec(),
        }
    }
}

impl<P: Scalar> TerrainFunction<P> {
    /// Values from the function; derivatives and other content of a scalar by the chain rule:  h(x) + Σ ∂h/∂xᵢ (xᵢ − value of xᵢ).
    /// Numbers without values pass through the function with all their derivatives.
    pub(super) fn surface<T: Over<P>>(&self, x: T, y: T) -> Ground<T> {
        if const { !T::HAS_VALUES } {
            return self.replay(x, y);
        }
        assert!(
            T::ORDER <= 1,
            "a terrain given as a function has first derivatives only"
        );
        let mut out = Ground {
            height: T::zero(),
            slope: [T::zero(); 2],
        };
        for direction in 0..self.directions::<T>() {
            let own: T = match direction {
                0 => x,
                1 => y,
                i => self.parameters[i - 2].into(),
            };
            let moved = own - T::from_values(|lane| own.value(lane));
            let at = |lane| [x.value(lane), y.value(lane)];
            let first = self.jet::<T>(0, at(0), direction);
            let jet = |lane| match lane {
                0 => first,
                _ => self.jet::<T>(lane, at(lane), direction),
            };
            let part = |of: fn(&Jet) -> f64| T::from_values(|lane| of(&jet(lane)));
            if direction == 0 {
                out.height += part(|jet| jet.height);
                out.slope[0] += part(|jet| jet.slope[0]);
                out.slope[1] += part(|jet| jet.slope[1]);
            }
            if is_more_than_values::<T>() {
                out.height += moved * part(|jet| jet.along);
                out.slope[0] += moved * part(|jet| jet.slope_along[0]);
                out.slope[1] += moved * part(|jet| jet.slope_along[1]);
            }
        }
        out
    }

    fn replay<T: Over<P>>(&self, x: T, y: T) -> Ground<T> {
        let parameters = self.parameters.iter().map(|&x| x.into());
        let at: Vec<T> = [x, y].into_iter().chain(parameters).collect();
        let surface = self.function.graph(self.parameters.len()).replay(&at);
        Ground {
            height: surface[0],
            slope: [surface[1], surface[2]],
        }
    }

    fn directions<T: Scalar>(&self) -> usize {
        if !is_more_than_values::<T>() {
            return 1;
        }
        2 + self.parameters.len()
    }

    /// The surface about a place in a lane of `T`, with its first derivatives in x and y.
    pub(super) fn surface_in_lane<T: Over<P>>(
        &self,
        lane: usize,
        at: [f64; 2],
    ) -> Ground<PlanarDual> {
        let jets = [0, 1].map_each(|axis| self.jet::<T>(lane, at, axis));
        let slope =
            |k: usize| PlanarDual::new(jets[0].slope[k], jets.map_each(|jet| jet.slope_along[k]));
        Ground {
            height: PlanarDual::new(jets[0].height, jets[0].slope),
            slope: [slope(0), slope(1)],
        }
    }

    fn jet<T: Over<P>>(&self, lane: usize, at: [f64; 2], direction: usize) -> Jet {
        let mut parameters = [0.0; MAX_TERRAIN_PARAMETERS];
        for (out, &own) in parameters.iter_mut().zip(&self.parameters) {
            *out = T::from(own).value(lane);
        }
        let parameters = &parameters[..self.parameters.len()];
        self.function.jet(at, parameters, direction)
    }
}
