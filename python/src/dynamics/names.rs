//! What arguments name: frames, representations, frames of momentum.

use dualbody::Model;
use dualbody::dynamics::MomentumFrame;
use dualbody::model::FrameId;
use dualbody::spatial::Representation;
use pyo3::prelude::*;

use crate::errors::{OrRaise, choice};

/// Something that an argument gives by its name.
pub(crate) trait Named: Copy {
    fn find(model: &Model, name: &str) -> PyResult<Self>;
}

impl Named for FrameId {
    fn find(model: &Model, name: &str) -> PyResult<Self> {
        model.find_frame(name).or_raise()
    }
}

impl Named for Representation {
    fn find(_: &Model, name: &str) -> PyResult<Self> {
        let choices = [
            ("body", Self::Body),
            ("mixed", Self::Mixed),
            ("inertial", Self::Inertial),
        ];
        choice("representation", name, &choices)
    }
}

impl Named for MomentumFrame {
    fn find(_: &Model, name: &str) -> PyResult<Self> {
        let choices = [
            ("centroidal", Self::Centroidal),
            ("world", Self::World),
            ("base", Self::Base),
        ];
        choice("frame", name, &choices)
    }
}
