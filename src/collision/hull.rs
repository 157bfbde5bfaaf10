//! Vertices of convex hulls.

use std::fmt;

use nalgebra::Vector3;

/// The vertices of a convex hull, in their own frame, m.
///
/// Distances need only vertices: the support edge or face in a direction consists of the farthest vertices. Interior points are allowed, but cost time.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    vertices: Vec<Vector3<f64>>,
}

/// The reason why a hull cannot be made, as a sentence.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum HullError {
    /// There is no point.
    Empty,
    /// A coordinate is infinite or NaN.
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// There are too many points.
    TooMany {
        /// Number of points.
        points: usize,
    },
}

impl fmt::Display for HullError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "a convex hull of no points"),
            Self::NotFinite { point } => {
                write!(
                    f,
                    "point {point} of a convex hull has a coordinate that is not finite"
                )
            }
            Self::TooMany { points } => {
                write!(
                    f,
                    "a convex hull of {points} points has more than {MAX_VERTICES}"
                )
            }
        }
    }
}

impl std::error::Error for HullError {}

/// Most vertices of a hull: enough for any mesh, and few enough for indices of 32 bits.
const MAX_VERTICES: usize = 1 << 24;

impl Hull {
    /// Makes a hull of points; interior points are allowed.
    ///
    /// # Errors
    /// If there are no points, more than 2²⁴, or a coordinate is not finite.
    pub fn new(vertices: Vec<Vector3<f64>>) -> Result<Self, HullError> {
        let points = vertices.len();
        if points == 0 {
            return Err(HullError::Empty);
        }
        if points > MAX_VERTICES {
            return Err(HullError::TooMany { points });
        }
        let infinite = vertices
            .iter()
            .position(|v| !v.iter().all(|x| x.is_finite()));
        match infinite {
            Some(point) => Err(HullError::NotFinite { point }),
            None => Ok(Self { vertices }),
        }
    }

    /// The vertices.
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }
}
