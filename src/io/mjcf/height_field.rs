//! Height fields: grids of heights, of which the first level one on the world is the ground.
//!
//! Their heights are numbers in the description, or those of a [file](super::height_file).

use std::path::Path;

use super::entry::Entry;
use super::height_file::{self, Grid, checked};
use super::scenery::MOST_TRIANGLES;
use crate::collision::Surface;
use crate::contact::HeightField;
use crate::error::LoadError;
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// Reason why a grid is not used.
const BEYOND: &str = "a height field of this size is beyond the range of numbers";

/// A grid of heights about the origin of its geom.
#[derive(Clone, Debug)]
pub(super) struct HeightAsset {
    /// Half lengths along x and y, the largest height, m. The fourth number of MJCF, the depth of the base, has no meaning for a ground.
    half: [f64; 2],
    top: f64,
    /// Number of points along x and y.
    points: [usize; 2],
    /// From 0 to 1, row by row along x, y rising.
    heights: Vec<f64>,
}

impl HeightAsset {
    /// Reads a height field, or the reason why its file cannot be used.
    ///
    /// * `path` – of its file, where one is named and found
    pub(super) fn read(
        entry: &Entry<'_, '_>,
        path: Option<&Path>,
    ) -> Result<Result<Self, String>, LoadError> {
        let size = entry.numbers::<4>("size")?;
        let size = size.ok_or_else(|| entry.missing("size"))?;
        if size.iter().any(|&x| x <= 0.0) {
            return Err(entry.malformed("size", "a length is not positive"));
        }
        let grid = match entry.text("file") {
            None => Ok(written(entry)?),
            Some(file) => {
                let is_picture = is_picture(entry, file);
                let read = height_file::read(path, is_picture);
                read.map_err(|reason| format!("has a file \"{file}\" that {reason}"))
            }
        };
        Ok(grid.map(|(points, heights)| Self {
            half: [size[0], size[1]],
            top: size[2],
            points,
            heights: normalized(heights),
        }))
    }

    /// The ground that it is with its geom at a place, which [is level](is_level).
    ///
    /// # Errors
    /// The reason why it cannot be.
    pub(super) fn at(&self, place: &Transform<f64>) -> Result<HeightField, String> {
        let [x, y, z]: [f64; 3] = place.translation.into();
        let spacing = self.spacing();
        let origin = [x - self.half[0], y - self.half[1]];
        let heights: Vec<f64> = self.heights.iter().map(|h| z + h * self.top).collect();
        let steepest = spacing.map_each(|gap| self.top / gap);
        let mut numbers = (origin.iter().chain(&spacing).chain(&heights)).chain(&steepest);
        if !numbers.all(|x| x.is_finite()) {
            return Err(BEYOND.into());
        }
        Ok(HeightField::new(origin, spacing, self.points, &heights))
    }

    /// Its triangles with its geom at any place, in the world.
    ///
    /// # Errors
    /// The reason why it cannot be.
    pub(super) fn surface(&self, place: &Transform<f64>) -> Result<Surface, String> {
        if self.heights.len() > MOST_TRIANGLES {
            return Err("a height field beside the ground has too many points".into());
        }
        let origin = self.half.map_each(|x| -x);
        let heights: Vec<f64> = self.heights.iter().map(|h| h * self.top).collect();
        let flat = Surface::grid(origin, self.spacing(), self.points, &heights);
        let flat = flat.map_err(|error| error.to_string())?;
        let vertices = flat.vertices().iter();
        let vertices = vertices.map(|p| place.rotation * p + place.translation);
        let turned = Surface::new(vertices.collect(), flat.triangles().to_vec());
        turned.map_err(|_| BEYOND.into())
    }

    fn spacing(&self) -> [f64; 2] {
        [0, 1].map_each(|k| 2.0 * self.half[k] / (self.points[k] - 1) as f64)
    }
}

/// Whether the geom of a height field at a place is not turned.
pub(super) fn is_level(place: &Transform<f64>) -> bool {
    let turn = place.rotation - nalgebra::Matrix3::identity();
    turn.amax() <= 1e-9
}

/// The numbers in the description, whose first row has the largest y; zeros if there are none.
fn written(entry: &Entry<'_, '_>) -> Result<Grid, LoadError> {
    let count = |name| {
        let n = entry.integer(name)?.ok_or_else(|| entry.missing(name))?;
        let n = usize::try_from(n).ok().filter(|&n| n >= 2);
        n.ok_or_else(|| entry.malformed(name, "expected 2 or more"))
    };
    let [rows, columns] = [count("nrow")?, count("ncol")?];
    let n = checked([columns, rows]).map_err(|reason| entry.malformed("nrow", &reason))?;
    let Some(numbers) = entry.list("elevation", n)? else {
        return Ok(([columns, rows], vec![0.0; n]));
    };
    if numbers.len() != n {
        let reason = format!("expected {n} numbers, got {}", numbers.len());
        return Err(entry.malformed("elevation", &reason));
    }
    let rows_up = numbers.chunks_exact(columns).rev();
    Ok(([columns, rows], rows_up.flatten().copied().collect()))
}

/// Whether a file is a picture: by its type, or else by its name.
fn is_picture(entry: &Entry<'_, '_>, file: &str) -> bool {
    let extension = Path::new(file).extension().unwrap_or_default();
    let by_type = entry.text("content_type").map(|own| own == "image/png");
    by_type.unwrap_or_else(|| extension.eq_ignore_ascii_case("png"))
}

/// Heights from 0 to 1; zeros if all are equal.
fn normalized(mut heights: Vec<f64>) -> Vec<f64> {
    let size = heights.iter().fold(1.0, |size: f64, h| size.max(h.abs()));
    // So that differences do not overflow.
    heights.iter_mut().for_each(|height| *height /= size);
    let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let range = heights
        .iter()
        .fold(0.0, |range: f64, h| range.max(h - least));
    for height in &mut heights {
        *height = if range > 0.0 {
            (*height - least) / range
        } else {
            0.0
        };
    }
    heights
}
