//! The ground.

use dualbody::contact::{HeightField, Terrain};

use crate::prelude::*;

pub(crate) fn terrain_of(value: &Bound<'_, PyAny>) -> PyResult<Terrain> {
    check_kind(
        "terrain",
        value,
        "contact",
        &["Terrain"],
        ", as Terrain.flat()",
    )?;
    if kind_of(value)? == "Plane" {
        let (point, normal) = (
            read_numbers("point", value)?,
            read_numbers("normal", value)?,
        );
        return guarded(|| Terrain::plane(point, normal));
    }
    grid_of(value).map(Terrain::HeightField)
}

fn grid_of(value: &Bound<'_, PyAny>) -> PyResult<HeightField> {
    check_kind("a grid", value, "contact", &["HeightField"], "")?;
    let (origin, spacing) = (
        read_numbers("origin", value)?,
        read_numbers("spacing", value)?,
    );
    let heights = value.getattr("heights")?;
    let shape = heights.getattr("shape").and_then(|shape| shape.extract());
    if let Ok((nx, ny)) = shape {
        check_grid(nx, ny)?;
    }
    let heights = read_matrix("heights", &heights)?;
    let (nx, ny) = heights.shape();
    // x varies fastest, as the rows of a column do.
    guarded(|| HeightField::new(origin, spacing, [nx, ny], heights.as_slice()))
}

functions! {
    /// Height and slope (h, ∂h/∂x, ∂h/∂y) of a terrain at (x, y).
    fn _terrain_surface(terrain, x: f64, y: f64) -> PyResult<(f64, f64, f64)> {
        let ground = terrain_of(terrain)?.surface(&x, &y);
        Ok((ground.height, ground.slope[0], ground.slope[1]))
    }

    /// Heights and shifts (n, 2) of grids that are laid side by side.
    fn _tiled(py: Python, tiles: Vec<Bound<'py, PyAny>>, columns) -> PyResult<[Array<'py>; 2]> {
        let tiles: Vec<HeightField> = tiles.iter().map(grid_of).collect::<PyResult<_>>()?;
        let (field, shifts) = HeightField::tiled(&tiles, whole("columns", columns)?);
        let ([nx, ny], rows) = (field.size(), shifts.iter().map(|x| &x[..]));
        let heights = DMatrix::from_column_slice(nx, ny, field.heights());
        Ok([matrix(py, &heights), stack(py, &[shifts.len()], &[2], rows)])
    }
}
