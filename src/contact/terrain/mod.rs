//! The ground: a height z = h(x, y) with its slope, by exact differentiation.

mod function;
mod height_field;
mod tiles;

use nalgebra::Vector3;

pub use function::{HeightFunction, MAX_TERRAIN_PARAMETERS, TerrainFunction};
pub use height_field::HeightField;

use crate::autodiff::Dual;
use crate::numbers::{Numbers, numbers};
use crate::scalar::{Cast, Over, Scalar};

/// A value with its derivatives in x and y.
pub(super) type PlanarDual = Dual<f64, 2>;

/// The ground under a robot.
///
/// All its parameters are of type `P`: over dual numbers, simulation is differentiable in heights and slopes.
///
/// # Examples
/// ```
/// use dualbody::contact::Terrain;
///
/// let ramp = Terrain::plane([0.0, 0.0, 1.0], [-0.6, 0.0, 0.8]);
/// let ground = ramp.surface(&2.0, &0.0);
/// assert!((ground.height - 2.5).abs() < 1e-15); // 1 + 2 · 0.6 / 0.8
/// assert!((ground.normal().x + 0.6).abs() < 1e-15);
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Terrain<P = f64> {
    /// A plane that is not vertical.
    Plane(Plane<P>),
    /// Heights on a grid, interpolated smoothly.
    HeightField(HeightField<P>),
    /// A user's function.
    Function(TerrainFunction<P>),
}

/// The plane z = height + slope · (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<P = f64> {
    /// Height above the world's origin, m.
    pub height: P,
    /// Rise along x and along y, m/m.
    pub slope: [P; 2],
}

numbers! { pub enum Terrain {
    Plane(plane: part(Plane)),
    HeightField(field: part(HeightField)),
    Function(function: part(TerrainFunction)),
} }

numbers! { pub struct Plane {
    height: Finite("height", "height or slope of the plane"),
    slope: Finite(["slope x", "slope y"], "height or slope of the plane"),
} }

/// Number of parameters of a plane.
pub(crate) const PLANE_NUMBERS: usize = <Plane as Numbers<f64>>::COUNT;

/// Height and slope of the ground at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground<T> {
    /// h, m.
    pub height: T,
    /// ∂h/∂x, ∂h/∂y.
    pub slope: [T; 2],
}

impl<T: Scalar> Ground<T> {
    /// The outward unit normal, (−∂h/∂x, −∂h/∂y, 1) divided by its length.
    #[inline(always)]
    pub fn normal(&self) -> Vector3<T> {
        let [x, y] = self.slope;
        let length = (x * x + y * y + 1.0).sqrt();
        let up = T::one() / length;
        Vector3::new(-x * up, -y * up, up)
    }
}

impl Terrain<f64> {
    /// The horizontal plane at a height, m.
    ///
    /// # Panics
    /// If the height is not finite.
    pub fn flat(height: f64) -> Self {
        Self::plane([0.0, 0.0, height], [0.0, 0.0, 1.0])
    }

    /// The plane through a point with an outward normal of any length.
    ///
    /// # Panics
    /// If an argument is not finite, or the normal does not point upwards.
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Self {
        let finite = point.iter().chain(&normal).all(|x| x.is_finite());
        assert!(
            finite && normal[2] > 0.0,
            "the normal {normal:?} of the ground must be finite and point upwards, the point {point:?} finite"
        );
        let slope = [-normal[0] / normal[2], -normal[1] / normal[2]];
        let height = point[2] - slope[0] * point[0] - slope[1] * point[1];
        Self::Plane(Plane { height, slope })
    }

    /// A plane through the origin that rises along x at an angle in (−π/2, π/2), rad: bodies on it slide towards −x.
    ///
    /// # Panics
    /// If the angle is not in that range.
    pub fn incline(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        assert!(
            angle.abs() < std::f64::consts::FRAC_PI_2,
            "an incline must be less steep than 90°, got {angle} rad"
        );
        Self::plane([0.0; 3], [-sin, 0.0, cos])
    }
}

impl<P: Scalar> Terrain<P> {
    /// Height and slope at (x, y), m. Differentiable in both and in the parameters of the terrain.
    #[inline(always)]
    pub fn surface<T: Over<P>>(&self, x: &T, y: &T) -> Ground<T> {
        match self {
            Self::Plane(plane) => plane.surface(*x, *y),
            Self::HeightField(field) => field.surface(*x, *y),
            Self::Function(function) => function.surface(*x, *y),
        }
    }

    /// Whether the normal of the ground varies with the position.
    pub(crate) fn is_curved(&self) -> bool {
        !matches!(self, Self::Plane(_))
    }

    /// Height and slope about a place (m) in a lane of `T`: values, and derivatives in x and y.
    pub(super) fn surface_in_lane<T: Over<P>>(
        &self,
        lane: usize,
        at: [f64; 2],
    ) -> Ground<PlanarDual> {
        let [x, y] = [
            PlanarDual::variable(at[0], 0),
            PlanarDual::variable(at[1], 1),
        ];
        match self {
            Self::Plane(plane) => {
                let plane = plane.map_numbers(&mut |x| T::from(x).value(lane));
                plane.surface(x, y)
            }
            Self::HeightField(field) => field.surface_in_lane::<T>(lane, [x, y]),
            Self::Function(function) => function.surface_in_lane::<T>(lane, at),
        }
    }

    /// Number of its [local numbers](Self::local_numbers).
    pub(crate) fn n_local_numbers(&self) -> usize {
        match self {
            Self::Plane(_) => PLANE_NUMBERS,
            Self::HeightField(field) => field.weights().len(),
            Self::Function(function) => function.parameters.len(),
        }
    }

    /// Adds the indices of those numbers from which the ground at a place (x, y, m) is computed, each once: the parameters, or of a grid the weights of
    /// the basis splines that reach there.
    pub(crate) fn local_numbers(&self, at: [f64; 2], out: &mut Vec<usize>) {
        match self {
            Self::HeightField(field) => field.local_weights(at, out),
            _ if out.is_empty() => out.extend(0..self.n_local_numbers()),
            _ => {}
        }
    }

    /// One of these numbers.
    pub(crate) fn local_number_mut(&mut self, index: usize) -> &mut P {
        match self {
            Self::Plane(plane) => match index {
                0 => &mut plane.height,
                axis => &mut plane.slope[axis - 1],
            },
            Self::HeightField(field) => &mut field.weights_mut()[index],
            Self::Function(function) => &mut function.parameters[index],
        }
    }

    /// Adds derivatives in all these values to those in the [`parameters`](Self::parameters); overwrites the former.
    pub(crate) fn add_local_slopes<T: Scalar>(&self, by_local: &mut [T], out: &mut [T]) {
        match self {
            Self::HeightField(field) => field.add_weight_slopes(by_local, out),
            _ => {
                let pairs = out.iter_mut().zip(by_local);
                pairs.for_each(|(out, slope)| *out += *slope);
            }
        }
    }

    /// Its parameters: height and slopes of a plane, heights of a grid row by row, or the parameters of a function. Allocates.
    pub fn parameters(&self) -> Vec<P> {
        self.to_vec()
    }

    /// Returns the ground with other [`parameters`](Self::parameters), over their scalar. Allocates.
    ///
    /// # Panics
    /// If the number of parameters differs.
    pub fn with_parameters<Q: Over<P>>(&self, parameters: &[Q]) -> Terrain<Q> {
        let (expected, given) = (self.parameters().len(), parameters.len());
        assert_eq!(given, expected, "the ground has {expected} parameters");
        let (mut out, mut rest) = (self.cast::<Q>(), parameters.iter());
        out.each_number(&mut |_, x| {
            if let Some(&given) = rest.next() {
                *x = given;
            }
        });
        out
    }
}

impl<P: Scalar> Plane<P> {
    #[inline]
    fn surface<T: Over<P>>(&self, x: T, y: T) -> Ground<T> {
        Ground {
            height: x * self.slope[0] + y * self.slope[1] + self.height,
            slope: [self.slope[0].into(), self.slope[1].into()],
        }
    }
}
