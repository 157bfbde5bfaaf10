//! Checks of numbers, with errors that name the part of the description.

use nalgebra::Matrix3;

use crate::error::{LARGEST_NUMBER, LoadError};
use crate::model::builder::ModelBuilder;
use crate::spatial::Transform;

/// Largest deviation of `RᵀR` from the identity: well above rounding and six printed digits, well below a slip of the pen.
const ROTATION_TOLERANCE: f64 = 1e-5;

/// A part of a description, as messages name it.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    builder: &'a ModelBuilder,
    element: &'a str,
    name: &'a str,
}

impl<'a> Part<'a> {
    pub(super) fn new(builder: &'a ModelBuilder, element: &'a str, name: &'a str) -> Self {
        Self {
            builder,
            element,
            name,
        }
    }

    pub(super) fn finite(self, quantity: &str, numbers: &[f64]) -> Result<(), LoadError> {
        if numbers.iter().all(|x| x.is_finite()) {
            return Ok(());
        }
        Err(LoadError::NonFinite {
            at: self.builder.position(self.element, self.name),
            element: self.element.into(),
            name: self.name.into(),
            quantity: quantity.into(),
        })
    }

    /// Finite numbers of which products of three, which the dynamics take, are finite.
    pub(super) fn bounded(self, quantity: &str, numbers: &[f64]) -> Result<(), LoadError> {
        self.finite(quantity, numbers)?;
        let Some(&value) = numbers.iter().find(|x| x.abs() > LARGEST_NUMBER) else {
            return Ok(());
        };
        Err(LoadError::TooLarge {
            at: self.builder.position(self.element, self.name),
            element: self.element.into(),
            name: self.name.into(),
            quantity: quantity.into(),
            value,
        })
    }
}

pub(super) fn malformed(
    builder: &ModelBuilder,
    [element, name, attribute]: [&str; 3],
    value: f64,
    reason: &str,
) -> Result<(), LoadError> {
    Err(LoadError::Malformed {
        at: builder.position(element, name),
        element: element.into(),
        name: name.into(),
        attribute: attribute.into(),
        value: value.to_string(),
        reason: reason.into(),
    })
}

pub(in crate::model) fn check_pose(
    builder: &ModelBuilder,
    element: &str,
    name: &str,
    pose: &Transform<f64>,
) -> Result<(), LoadError> {
    let position = pose.translation.as_slice();
    let part = Part::new(builder, element, name);
    part.bounded("position", position)?;
    part.finite("rotation", pose.rotation.as_slice())?;
    let defect = (pose.rotation.transpose() * pose.rotation - Matrix3::identity()).norm();
    if defect < ROTATION_TOLERANCE && pose.rotation.determinant() > 0.0 {
        return Ok(());
    }
    Err(LoadError::Malformed {
        at: builder.position(element, name),
        element: element.into(),
        name: name.into(),
        attribute: "rotation".into(),
        value: format!("{:?}", pose.rotation.as_slice()),
        reason: "is not a rotation matrix".into(),
    })
}
