//! The nearest points of two links, with the gradient of their distance.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DVector, Vector3};

use super::kinematics::{BodyPoint, each_jacobian_column};
use super::link_shapes::{LinkShape, LinkShapes};
#[cfg(feature = "trajopt")]
use super::pairs::plain_pose;
use crate::collision::{PairFeature, Witness, nearest_features, witness};
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::error::{UnknownName, message};
use crate::model::{FrameId, Model};
#[cfg(feature = "trajopt")]
use crate::scalar::{MapEach, Scalar};
use crate::spatial::Transform;

/// The nearest points of two links.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// Distance, m. If the links overlap, the negative length of the shortest translation that separates the two nearest shapes. With
    /// [smoothing](LinkShapes::with_smoothing), the soft minimum over near features.
    pub distance: f64,
    /// Nearest points in the world, m, first that of the first link. With smoothing, of the nearest two shapes, rounded.
    pub points: [Vector3<f64>; 2],
    /// Unit normal from the first link to the second, in the world.
    pub normal: Vector3<f64>,
    /// Derivative of the distance in the tangent of q, length `nv`, m/rad or m/m.
    pub gradient: DVector<f64>,
    /// The nearest shapes of the two links, indices in [`LinkShapes::shapes`].
    pub shapes: [usize; 2],
    /// The nearest features of these shapes.
    pub feature: Option<PairFeature>,
}

impl Nearest {
    /// Makes memory for a model, without a distance.
    pub fn new(model: &Model) -> Self {
        Self {
            distance: f64::INFINITY,
            points: [Vector3::zeros(); 2],
            normal: Vector3::z(),
            gradient: DVector::zeros(model.nv()),
            shapes: [0; 2],
            feature: None,
        }
    }

    /// Takes over shapes, points and normal.
    pub(super) fn take(&mut self, shapes: [usize; 2], feature: PairFeature, found: &Witness<f64>) {
        (self.points, self.normal) = (found.points, found.normal);
        (self.shapes, self.feature) = (shapes, Some(feature));
    }
}

/// Reason why two links have no distance.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NearestError {
    /// The robot has no such link, or it has no collision shape.
    #[error(transparent)]
    UnknownName(#[from] UnknownName),
    /// A link has a mesh; this function reads no mesh files.
    #[error("{}", message(format_args!("link \"{link}\": {reason}; LinkShapes::new reads the files of meshes")))]
    MissingShape {
        /// The link.
        link: String,
        /// The reason, as a sentence.
        reason: String,
    },
    /// Both shapes are half-spaces, or a coordinate is not finite.
    #[error("{}", message(format_args!("links \"{first}\" and \"{second}\" have no distance: a coordinate is not finite")))]
    NoDistance {
        /// The first link.
        first: String,
        /// The second link.
        second: String,
    },
}

/// Computes the nearest points of two links, with the gradient of their distance.
///
/// For a single query; [`LinkShapes::nearest_into`] reuses shapes and memory. Meshes are not read: a link with a mesh is an error. Allocates.
///
/// * `q` – configuration, length `nq`
/// * `first`, `second` – names of links
///
/// # Errors
/// If the model has no such link, or one has no collision shape, or one that is a mesh; if q is not finite.
///
/// # Panics
/// If `q` has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{Model, contact};
///
/// let model = Model::from_urdf_str(r#"<robot name="slider">
///   <link name="world"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
///   <link name="box"><collision><geometry><box size="0.2 1 1"/></geometry></collision>
///     <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
///   <joint name="slide" type="prismatic"><parent link="world"/><child link="box"/><axis xyz="1 0 0"/>
///     <limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>"#)?;
/// let near = contact::nearest(&model, &[0.5], "world", "box")?;
/// assert!((near.distance - 0.3).abs() < 1e-15);
/// assert_eq!(near.gradient[0], 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn nearest(
    model: &Model,
    q: &[f64],
    first: &str,
    second: &str,
) -> Result<Nearest, NearestError> {
    LinkShapes::without_meshes(model).nearest(model, q, first, second)
}

impl LinkShapes {
    /// Computes the nearest points of two links. Allocates; see [`nearest_into`](Self::nearest_into).
    ///
    /// # Errors
    /// If the model has no such link, or one has no collision shape, or one that is [missing](Self::missing); if q is not finite.
    ///
    /// # Panics
    /// If `q` has the wrong length, or the shapes are those of another robot.
    pub fn nearest(
        &self,
        model: &Model,
        q: &[f64],
        first: &str,
        second: &str,
    ) -> Result<Nearest, NearestError> {
        let links = self.find_pair(model, first, second)?;
        let mut kinematics = Kinematics::new(model);
        forward_kinematics_into(model, q, &vec![0.0; model.nv()], &mut kinematics);
        let mut out = Nearest::new(model);
        if self.nearest_into(model, &kinematics, links, &mut out) {
            return Ok(out);
        }
        Err(NearestError::NoDistance {
            first: first.to_owned(),
            second: second.to_owned(),
        })
    }

    /// The frames of two links that have all their shapes.
    pub(crate) fn find_pair(
        &self,
        model: &Model,
        first: &str,
        second: &str,
    ) -> Result<[FrameId; 2], NearestError> {
        for link in [first, second] {
            if let Some(missing) = self.missing().iter().find(|missing| missing.link == link) {
                return Err(NearestError::MissingShape {
                    link: link.to_owned(),
                    reason: missing.reason.clone(),
                });
            }
        }
        Ok([
            self.find_link(model, first)?,
            self.find_link(model, second)?,
        ])
    }

    /// Computes the nearest points of two links, without allocation. Returns `false` and an infinite distance if there is no distance: a link without
    /// shapes, two half-spaces, a coordinate that is not finite.
    ///
    /// The distance is that of the nearest pair of shapes of both links; of equally near pairs the first. Its gradient is ∂d/∂q = n · (J₂ − J₁) with
    /// the Jacobians of the links at the two points. Where features switch, it is the gradient of one side; with
    /// [smoothing](Self::with_smoothing) it is continuous.
    ///
    /// * `links` – frames of the links, see [`Model::find_frame`]
    ///
    /// # Panics
    /// If `out`, the kinematics or the shapes are those of another robot.
    pub fn nearest_into(
        &self,
        model: &Model,
        kinematics: &Kinematics<f64>,
        links: [FrameId; 2],
        out: &mut Nearest,
    ) -> bool {
        self.check(model);
        kinematics.check(model);
        assert_eq!(out.gradient.len(), model.nv(), "length of the gradient");
        out.distance = f64::INFINITY;
        out.feature = None;
        out.gradient.fill(0.0);
        let Some((shapes, feature, found)) =
            self.nearest_shapes(links, |shape| pose(kinematics, shape))
        else {
            return false;
        };
        if self.smoothing > 0.0 {
            self.smooth_into(model, kinematics, links, found.distance, out);
            return true;
        }
        out.distance = found.distance;
        out.take(shapes, feature, &found);
        self.add_gradient(model, kinematics, (shapes, &found), 1.0, &mut out.gradient);
        true
    }

    /// The nearest shapes of two links, of equally near ones the first, and their features.
    fn nearest_shapes(
        &self,
        links: [FrameId; 2],
        pose: impl Fn(&LinkShape) -> Transform<f64>,
    ) -> Option<([usize; 2], PairFeature, Witness<f64>)> {
        let mut nearest: Option<([usize; 2], PairFeature, Witness<f64>)> = None;
        self.each_distance(links, pose, |shapes, feature, found| {
            let least = nearest.map_or(f64::INFINITY, |(_, _, near)| near.distance);
            if found.distance < least {
                nearest = Some((shapes, feature, found));
            }
        });
        nearest
    }

    /// Passes each pair of shapes of two links, with their nearest features, to `each`.
    pub(super) fn each_distance(
        &self,
        links: [FrameId; 2],
        pose: impl Fn(&LinkShape) -> Transform<f64>,
        mut each: impl FnMut([usize; 2], PairFeature, Witness<f64>),
    ) {
        let of = |link: FrameId| {
            let shapes = self.shapes().iter().enumerate();
            shapes.filter(move |(_, shape)| shape.link == link)
        };
        for (i, a) in of(links[0]) {
            let X_WA = pose(a);
            for (j, b) in of(links[1]) {
                if let Some((feature, found)) = nearest_of_shapes(a, &X_WA, b, &pose(b)) {
                    each([i, j], feature, found);
                }
            }
        }
    }

    /// The distance of two links over the scalar, by the features that are nearest on plain values; `None` where there is none.
    #[cfg(feature = "trajopt")]
    pub(crate) fn distance<T: Scalar>(
        &self,
        kinematics: &Kinematics<T>,
        links: [FrameId; 2],
    ) -> Option<T> {
        let plain = |own: &LinkShape| plain_pose(&kinematics.pose(own.body), 0) * own.placement;
        let (shapes, feature, found) = self.nearest_shapes(links, plain)?;
        if self.smoothing > 0.0 {
            return Some(self.soft_distance(kinematics, links, found.distance));
        }
        let [a, b] = shapes.map_each(|k| &self.shapes()[k]);
        let [X_WA, X_WB] = [a, b].map_each(|own| kinematics.pose(own.body) * own.placement.lift());
        Some(witness(&feature, &a.shape, &X_WA, &b.shape, &X_WB).distance)
    }

    /// Adds ∂d/∂q = n · (J₂ − J₁), with the points as those of the bodies, times a share.
    pub(super) fn add_gradient(
        &self,
        model: &Model,
        kinematics: &Kinematics<f64>,
        (shapes, found): ([usize; 2], &Witness<f64>),
        share: f64,
        gradient: &mut DVector<f64>,
    ) {
        for ((shape, point), sign) in shapes.iter().zip(&found.points).zip([-share, share]) {
            let body = self.shapes()[*shape].body;
            let in_body = kinematics.pose(body).inverse().point(point);
            let point = BodyPoint {
                body,
                in_body: &in_body,
            };
            each_jacobian_column(model, kinematics, point, |k, velocity| {
                gradient[k] += sign * found.normal.dot(&velocity);
            });
        }
    }
}

/// The pose `X_WS` of a shape.
pub(super) fn pose(kinematics: &Kinematics<f64>, shape: &LinkShape) -> Transform<f64> {
    kinematics.pose(shape.body) * shape.placement
}

/// The nearest features of two shapes, with their distance, which is finite.
pub(super) fn nearest_of_shapes(
    a: &LinkShape,
    X_WA: &Transform<f64>,
    b: &LinkShape,
    X_WB: &Transform<f64>,
) -> Option<(PairFeature, Witness<f64>)> {
    let feature = nearest_features(&a.shape, X_WA, &b.shape, X_WB)?;
    let found = witness(&feature, &a.shape, X_WA, &b.shape, X_WB);
    found.distance.is_finite().then_some((feature, found))
}

crate::error::debug_by_message! { NearestError }
