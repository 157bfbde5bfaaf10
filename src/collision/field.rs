//! A shape given by a user's function: its signed distance.

use std::fmt;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::numbers::Domain;
use crate::scalar::traced::{Graph, Port, Traced, trace};
use crate::scalar::{Dual, MapEach, Scalar, is_more_than_values};

/// The signed distance from a body, generic over the scalar: negative inside, with a gradient of length one near its surface.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, collision::{DistanceField, DistanceFunction, Shape}, spatial::Transform};
/// use nalgebra::Vector3;
///
/// /// A torus about z.
/// struct Torus { radius: f64, thickness: f64 }
/// impl DistanceFunction for Torus {
///     fn distance<T: Scalar>(&self, [x, y, z]: [T; 3]) -> T {
///         let beyond = (x * x + y * y).sqrt() - self.radius;
///         (beyond * beyond + z * z).sqrt() - self.thickness
///     }
/// }
/// let field = DistanceField::new(Torus { radius: 1.0, thickness: 0.1 }, [1.1, 1.1, 0.1]);
/// let torus = Shape::Field { field };
/// let found = torus.distance_to_point(&Transform::identity(), &Vector3::new(0.5, 0.0, 0.0)).unwrap();
/// assert!((found.distance - 0.4).abs() < 1e-15);
/// assert_eq!(found.normal, -Vector3::x());
/// ```
pub trait DistanceFunction: Send + Sync + 'static {
    /// The distance of a point in the frame of the shape, m.
    fn distance<T: Scalar>(&self, point: [T; 3]) -> T;
}

/// A [`DistanceFunction`], for a [`Shape`](super::Shape) of any form, convex or not.
///
/// Its distance from another shape is that of *points* of that shape, with a radius for spheres and capsules: the centre of a sphere, both ends of the
/// axis of a capsule, the corners of a box, the vertices of a hull and of a triangle, sixteen points on each rim of a cylinder, the ends of the axes of
/// an ellipsoid. A ridge of the field between these points is not found. There is no contact with a half-space, or with another field.
///
/// # Limitations
/// First derivatives of contact need second derivatives of the function; these are computed, higher ones are not. If the function or its gradient is
/// not finite, there is no contact; second derivatives that are not finite count as zero. At a nonsmooth point of the function, such as the axis of a
/// tube, the gradient is the one-sided derivative of its operations.
#[derive(Clone)]
pub struct DistanceField {
    function: Arc<dyn ErasedDistance>,
    half_extents: [f64; 3],
}

impl DistanceField {
    /// Makes a field of a function, with the half extents (m) of a box about the origin that contains the body. The function is evaluated near that box only.
    ///
    /// # Panics
    /// If a half extent is negative or not finite.
    pub fn new(function: impl DistanceFunction, half_extents: [f64; 3]) -> Self {
        for x in half_extents {
            Domain::NotNegative.check("half extent of a signed distance", x);
        }
        Self {
            function: Arc::new(function),
            half_extents,
        }
    }

    /// Half the edges of the box that holds the body, m.
    pub fn half_extents(&self) -> [f64; 3] {
        self.half_extents
    }

    /// Distance and gradient at a point; `None` where these are not finite.
    pub(super) fn value(&self, x: &Vector3<f64>) -> Option<Slope> {
        let found = self.function.slope((*x).into());
        let all = found.gradient.iter().chain([&found.distance]);
        all.into_iter().all(|x| x.is_finite()).then_some(found)
    }

    /// Distance and gradient over the scalar: values from the function, other content of a scalar by the chain rule.
    pub(super) fn at<T: Scalar>(&self, x: &Vector3<T>) -> (T, Vector3<T>) {
        if const { !T::HAS_VALUES } {
            let found = self.function.graph().replay(x.as_slice());
            return (found[0], Vector3::new(found[1], found[2], found[3]));
        }
        assert!(
            T::ORDER <= 1,
            "a signed distance given as a function has first derivatives only"
        );
        // Each lane's jet once: a lane after the other is put into the parts.
        let mut parts = [T::zero(); Jet::PARTS];
        for lane in 0..T::LANES {
            let jet = self.jet::<T>(&x.map(|x| x.value(lane))).parts();
            for (part, own) in parts.iter_mut().zip(jet) {
                let known = *part;
                *part = T::from_values(|k| if k == lane { own } else { known.value(k) });
            }
        }
        let (mut distance, slope) = (parts[0], [parts[1], parts[2], parts[3]]);
        let mut gradient = Vector3::from(slope);
        if is_more_than_values::<T>() {
            for i in 0..3 {
                let moved = x[i] - T::from_values(|lane| x[i].value(lane));
                distance += moved * slope[i];
                for k in 0..3 {
                    gradient[k] += moved * parts[4 + 3 * k + i];
                }
            }
        }
        (distance, gradient)
    }

    /// The jet at a point; far away where it is not finite.
    fn jet<T: Scalar>(&self, x: &Vector3<f64>) -> Jet {
        let far = Jet {
            slope: Slope {
                distance: FAR,
                gradient: [0.0; 3],
            },
            hessian: [[0.0; 3]; 3],
        };
        let Some(slope) = self.value(x) else {
            return far;
        };
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        let hessian = if is_more_than_values::<T>() {
            self.function
                .hessian((*x).into())
                .map_each(|row| row.map_each(finite))
        } else {
            far.hessian
        };
        Jet { slope, hessian }
    }
}

/// Distance where a function has none, m.
const FAR: f64 = 1e100;

/// Two fields are the same if their function is one.
impl PartialEq for DistanceField {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.function, &other.function) && self.half_extents == other.half_extents
    }
}

impl fmt::Debug for DistanceField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DistanceField")
            .field("half_extents", &self.half_extents)
            .finish_non_exhaustive()
    }
}

/// A distance with its gradient.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slope {
    pub(super) distance: f64,
    pub(super) gradient: [f64; 3],
}

/// A distance with its first and second derivatives.
#[derive(Clone, Copy, Debug)]
struct Jet {
    slope: Slope,
    hessian: [[f64; 3]; 3],
}

impl Jet {
    const PARTS: usize = 13;

    /// Distance, gradient and the rows of the second derivatives.
    fn parts(&self) -> [f64; Self::PARTS] {
        let mut all = [self.slope.distance; Self::PARTS];
        all[1..4].copy_from_slice(&self.slope.gradient);
        all[4..].copy_from_slice(self.hessian.as_flattened());
        all
    }
}

/// Distance function with its type erased.
trait ErasedDistance: Send + Sync {
    fn slope(&self, at: [f64; 3]) -> Slope;

    fn hessian(&self, at: [f64; 3]) -> [[f64; 3]; 3];

    /// Distance and gradient as functions of the point, for numbers without values.
    fn graph(&self) -> Graph;
}

impl<F: DistanceFunction> ErasedDistance for F {
    fn slope(&self, at: [f64; 3]) -> Slope {
        let d = self.distance([0, 1, 2].map_each(|k| Dual::<f64, 3>::variable(at[k], k)));
        Slope {
            distance: d.re,
            gradient: d.eps,
        }
    }

    fn hessian(&self, at: [f64; 3]) -> [[f64; 3]; 3] {
        let unit = |k: usize| [0, 1, 2].map_each(|i| if i == k { 1.0.into() } else { 0.0.into() });
        let place = |k: usize| Dual::<Dual<f64, 3>, 3>::new(Dual::variable(at[k], k), unit(k));
        self.distance([0, 1, 2].map_each(place))
            .eps
            .map_each(|row| row.eps)
    }

    fn graph(&self) -> Graph {
        trace(|t| {
            let x = t.input(Port::vector("point", 3));
            let d = self.distance([0, 1, 2].map_each(|k| Dual::<Traced, 3>::variable(x[k], k)));
            t.output(Port::number("distance"), &[d.re]);
            t.output(Port::vector("gradient", 3), &d.eps);
        })
    }
}
