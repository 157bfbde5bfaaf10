//! The ground.

use dualbody::contact::{HeightField, Terrain};
use pyo3::prelude::*;

use super::law::numbers_of;
use crate::errors::{guarded, value_error};
use crate::kinds::check_kind;
use crate::python::functions;

pub(crate) fn terrain_of(value: &Bound<'_, PyAny>) -> PyResult<Terrain> {
    check_kind(
        "terrain",
        value,
        "contact",
        &["Terrain"],
        ", as Terrain.flat()",
    )?;
    let (kind, x, size): (String, Vec<f64>, [usize; 2]) = numbers_of(value)?;
    guarded(|| match (kind.as_str(), x.as_slice()) {
        ("plane", &[px, py, pz, nx, ny, nz]) => Ok(Terrain::plane([px, py, pz], [nx, ny, nz])),
        ("height_field", &[x, y, dx, dy, ref heights @ ..]) => Ok(Terrain::HeightField(
            HeightField::new([x, y], [dx, dy], size, heights),
        )),
        _ => Err(value_error(format_args!(
            "terrain is of the unknown kind \"{kind}\""
        ))),
    })?
}

functions! {
    /// Height and slope (h, ∂h/∂x, ∂h/∂y) of a terrain at (x, y).
    fn _terrain_surface(terrain, x: f64, y: f64) -> PyResult<(f64, f64, f64)> {
        let ground = terrain_of(terrain)?.surface(&x, &y);
        Ok((ground.height, ground.slope[0], ground.slope[1]))
    }
}
