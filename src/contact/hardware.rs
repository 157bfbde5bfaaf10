//! Contact points as functions of the sizes of links.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::contacts::Contacts;
use super::point::{ContactPoint, Feature};
use crate::error::EditError;
use crate::model::{Hardware, Model, Stretch};
use crate::scalar::{Cast, Scalar};
use crate::spatial::linear::{lift_vector, rotate};

impl Contacts<f64> {
    /// Returns the contacts of the robot with other link sizes (design parameters), over the scalar of the parameters. Points move with their link
    /// and radii change with its shapes; contact models and ground stay unchanged.
    ///
    /// The result equals the contacts of [`Hardware::model`] if the shapes are parallel or perpendicular to the axes of the shape whose sizes change.
    /// Corners of rotated shapes move as points, so a rotated box does not remain a box.
    ///
    /// * `x` – all design parameters, each positive
    ///
    /// # Errors
    /// If one is not positive and finite; the error names it.
    ///
    /// # Panics
    /// If `x` has the wrong length, or the contacts belong to another robot.
    pub fn with_hardware<T: Scalar>(
        &self,
        hardware: &Hardware,
        x: &[T],
    ) -> Result<Contacts<T>, EditError> {
        self.check(hardware.nominal_model());
        let model = hardware.model(x)?;
        let points = self.points().iter();
        let moved = points.map(|point| moved(point, hardware, &model, x));
        Ok(self.with_points(&moved.collect::<Vec<_>>()))
    }
}

/// A point after a change of sizes.
fn moved<T: Scalar>(
    point: &ContactPoint,
    hardware: &Hardware,
    model: &Model<T>,
    x: &[T],
) -> ContactPoint<T> {
    let mut out = point.cast::<T>();
    let before = hardware.nominal_model().frames()[point.link.0].placement;
    let after = model.frames()[point.link.0].placement;
    out.center += after.translation - lift_vector::<f64, T>(&before.translation);
    let Some((stretch, X_LF)) = hardware.stretch_of(point.link, x) else {
        return out;
    };
    // From the frame's own displacement, which the model has, to that of the point.
    let X_BL = before * X_LF.inverse();
    let p_L = X_BL.inverse().point(&point.center);
    let own = stretch.displacement(&p_L) - stretch.displacement(&X_LF.translation);
    out.center += rotate(&X_BL.rotation, &own);
    let in_link = |axis: &Vector3<f64>| X_BL.rotation.transpose() * axis;
    resize(&mut out.feature, &point.feature, &stretch, in_link);
    out
}

fn resize<T: Scalar>(
    out: &mut Feature<T>,
    before: &Feature,
    stretch: &Stretch<T>,
    in_link: impl Fn(&Vector3<f64>) -> Vector3<f64>,
) {
    match (out, before) {
        (Feature::Sphere { radius }, _) => *radius *= stretch.ball(),
        (Feature::Rim { radius, .. }, Feature::Rim { axis, .. }) => {
            *radius *= stretch.across(&in_link(axis));
        }
        (Feature::Ellipsoid { semi_axes }, Feature::Ellipsoid { semi_axes: before }) => {
            for (mut own, before) in semi_axes.column_iter_mut().zip(before.column_iter()) {
                let factor = stretch.along(&in_link(&before.normalize()));
                own.iter_mut().for_each(|x| *x *= factor);
            }
        }
        _ => {}
    }
}
