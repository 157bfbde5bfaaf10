//! The nearest features of two shapes, as plain values.

use nalgebra::Vector3;

/// Maximum number of points of a [`Manifold`].
pub const MAX_POINTS: usize = 8;

/// A feature of a shape.
///
/// Numbers of vertices: of a box by its sides (bit k set: the positive side along axis k); of a hull as in [`Hull::vertices`](super::Hull::vertices);
/// of a sphere its centre; of an ellipsoid its centre, then the ends of its axes, x below and above first; of a capsule and a cylinder the ends of
/// their axis (below, above). Further vertices of a cylinder are fixed points on its rims, alternately below and above, a sixteenth of a revolution
/// apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Feature {
    /// A vertex.
    Vertex(u32),
    /// The line through two vertices; the axis of a cylinder represents its side.
    Edge([u32; 2]),
    /// A rim of a cylinder: 0 below, 1 above.
    Rim(u32),
    /// The surface of an ellipsoid.
    Surface,
}

/// A flat face of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Face {
    /// The face through three vertices, counter-clockwise as seen from outside.
    Vertices([u32; 3]),
    /// An end of a cylinder: 0 below, 1 above.
    Cap(u32),
    /// A side of an ellipsoid with a semi-axis of zero: 2 k below and 2 k + 1 above along that axis k.
    Flat(u32),
    /// The plane of a half-space.
    Plane,
}

impl Face {
    /// A point in the plane of the face.
    pub(super) fn vertex(&self) -> Feature {
        Feature::Vertex(match self {
            Self::Vertices([k, _, _]) => *k,
            Self::Cap(end) => *end,
            Self::Flat(_) | Self::Plane => 0,
        })
    }
}

/// The source of the normal of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum NormalSource {
    /// The features themselves: the direction in which they are nearest.
    Features,
    /// A face of the first shape. The first feature is on that face; for two edges, the points are where they cross as seen along the normal.
    First(Face),
    /// A face of the second shape, likewise.
    Second(Face),
}

/// Identity of a pair of nearest features from step to step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FeatureId {
    /// The feature of each shape.
    pub features: [Feature; 2],
    /// The source of the normal.
    pub normal: NormalSource,
}

/// A pair of nearest features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairFeature {
    /// The features.
    pub id: FeatureId,
    /// Unit normal from the first shape to the second in the world, without derivatives: the start of Newton's method on curved shapes, and the
    /// normal if the features coincide.
    pub seed: Vector3<f64>,
}

/// Distance, points and normal of a pair of features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness<T> {
    /// Distance along the normal, m; negative where the shapes overlap.
    pub distance: T,
    /// Point on each shape, in the world, m.
    pub points: [Vector3<T>; 2],
    /// Unit normal from the first shape to the second, in the world.
    pub normal: Vector3<T>,
}

/// The contact manifold of two shapes: up to eight pairs of features.
#[derive(Clone, Copy, Debug)]
pub struct Manifold {
    pairs: [PairFeature; MAX_POINTS],
    len: usize,
}

/// Fills the unused places of a manifold.
const NOTHING: PairFeature = PairFeature {
    id: FeatureId {
        features: [Feature::Vertex(0); 2],
        normal: NormalSource::Features,
    },
    seed: Vector3::new(0.0, 0.0, 1.0),
};

impl Default for Manifold {
    fn default() -> Self {
        Self {
            pairs: [NOTHING; MAX_POINTS],
            len: 0,
        }
    }
}

impl Manifold {
    /// The pairs.
    pub fn pairs(&self) -> &[PairFeature] {
        &self.pairs[..self.len]
    }

    /// Removes all pairs.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds a pair; one that has no room is left out.
    pub(super) fn push(&mut self, pair: PairFeature) {
        if self.len < MAX_POINTS {
            self.pairs[self.len] = pair;
            self.len += 1;
        }
    }
}
