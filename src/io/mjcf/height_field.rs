//! Height fields: grids of heights, of which the first on the world is the ground.

use std::path::Path;

use super::entry::Entry;
use crate::contact::HeightField;
use crate::error::LoadError;
use crate::input::{self, MAX_TEXT_BYTES};
use crate::memory;
use crate::scalar::MapEach;
use crate::spatial::Transform;

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
            Some(file) => stored(file, path),
        };
        Ok(grid.map(|(points, heights)| Self {
            half: [size[0], size[1]],
            top: size[2],
            points,
            heights: normalized(heights),
        }))
    }

    /// The ground that it is with its geom at a place.
    ///
    /// # Errors
    /// The reason why it cannot be.
    pub(super) fn at(&self, place: &Transform<f64>) -> Result<HeightField, String> {
        let turn = place.rotation - nalgebra::Matrix3::identity();
        if turn.amax() > 1e-9 {
            return Err("a height field that is turned is not modelled".into());
        }
        let [x, y, z]: [f64; 3] = place.translation.into();
        let gaps = self.points.map_each(|n| (n - 1) as f64);
        let spacing = [0, 1].map_each(|k| 2.0 * self.half[k] / gaps[k]);
        let origin = [x - self.half[0], y - self.half[1]];
        let heights: Vec<f64> = self.heights.iter().map(|h| z + h * self.top).collect();
        let steepest = spacing.map_each(|gap| self.top / gap);
        let mut numbers = (origin.iter().chain(&spacing).chain(&heights)).chain(&steepest);
        if !numbers.all(|x| x.is_finite()) {
            return Err("a height field of this size is beyond the range of numbers".into());
        }
        Ok(HeightField::new(origin, spacing, self.points, &heights))
    }
}

type Grid = ([usize; 2], Vec<f64>);

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

/// The numbers of a binary file: rows and columns as 32-bit integers, then the heights in single precision.
fn stored(file: &str, path: Option<&Path>) -> Result<Grid, String> {
    let is_picture = Path::new(file).extension().is_some_and(|own| own == "png");
    if is_picture {
        return Err("is a picture, which is not read: give its heights as elevation".into());
    }
    let path = path.ok_or_else(|| format!("has a file \"{file}\" that is not found"))?;
    let bytes = input::read(path, MAX_TEXT_BYTES)
        .map_err(|error| format!("has a file \"{file}\" that {}", input::reason(&error)))?;
    let (words, _) = bytes.as_chunks::<4>();
    let count = |k: usize| {
        let n = words.get(k).map(|&word| i32::from_le_bytes(word));
        usize::try_from(n?).ok().filter(|&n| n >= 2)
    };
    let (Some(rows), Some(columns)) = (count(0), count(1)) else {
        let reason = "that does not begin with two or more rows and columns";
        return Err(format!("has a file \"{file}\" {reason}"));
    };
    let n = checked([columns, rows])?;
    let heights: Vec<f64> = words[2..]
        .iter()
        .map(|&x| f32::from_le_bytes(x).into())
        .collect();
    let is_whole = heights.len() == n && bytes.len() == 4 * words.len();
    match is_whole && heights.iter().all(|x| x.is_finite()) {
        true => Ok(([columns, rows], heights)),
        false => Err(format!(
            "has a file \"{file}\" without {rows} × {columns} finite heights"
        )),
    }
}

/// Number of points of a grid, if there is memory for it.
fn checked([columns, rows]: [usize; 2]) -> Result<usize, String> {
    let n = rows.saturating_mul(columns);
    let what = format_args!("a height field of {rows} × {columns} points");
    // The grid, its spline, and their work space.
    memory::check(what, n.saturating_mul(64)).map_err(|error| error.to_string())?;
    Ok(n)
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
