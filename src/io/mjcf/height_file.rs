//! Files of height fields: numbers in single precision, or PNG pictures.
//!
//! As in `MuJoCo`, a height of a picture is the grey or red channel of a pixel in 8 bits: of 16 bits only the upper half counts. The first row of a
//! picture has the largest y, that of numbers the smallest. Measured with `MuJoCo` 4.0.0.

use std::path::Path;

use crate::input::{self, MAX_TEXT_BYTES};
use crate::memory;

/// Number of points along x and y, and their heights, row by row along x, y rising.
pub(super) type Grid = ([usize; 2], Vec<f64>);

/// The heights of a file, or a reason as an end of the sentence "a file that …".
pub(super) fn read(path: Option<&Path>, is_picture: bool) -> Result<Grid, String> {
    let path = path.ok_or("is not found")?;
    let bytes = input::read(path, MAX_TEXT_BYTES).map_err(|error| input::reason(&error))?;
    match is_picture {
        true => pixels(bytes),
        false => numbers(&bytes),
    }
}

/// The numbers of a binary file: rows and columns as 32-bit integers, then the heights in single precision.
fn numbers(bytes: &[u8]) -> Result<Grid, String> {
    let (words, rest) = bytes.as_chunks::<4>();
    let count = |k: usize| {
        let n = words.get(k).map(|&word| i32::from_le_bytes(word));
        usize::try_from(n?).ok().filter(|&n| n >= 2)
    };
    let (Some(rows), Some(columns)) = (count(0), count(1)) else {
        return Err("does not begin with two or more rows and columns".into());
    };
    let n = checked([columns, rows])?;
    let heights: Vec<f64> = words[2..]
        .iter()
        .map(|&x| f32::from_le_bytes(x).into())
        .collect();
    let is_whole = heights.len() == n && rest.is_empty();
    match is_whole && heights.iter().all(|x| x.is_finite()) {
        true => Ok(([columns, rows], heights)),
        false => Err(format!("does not have {rows} × {columns} finite heights")),
    }
}

/// Reads a picture, or returns the reason why it cannot be used, as an end of the sentence "a file that …".
#[cfg(not(feature = "png"))]
fn pixels(_: Vec<u8>) -> Result<Grid, String> {
    Err("is a picture, which is read with the feature `png` of this library only".into())
}

/// The most pixels of a picture: a small file can contain very many.
#[cfg(feature = "png")]
const MOST_PIXELS: usize = 1 << 24;

/// Reads a picture, or returns the reason why it cannot be used, as an end of the sentence "a file that …".
#[cfg(feature = "png")]
fn pixels(bytes: Vec<u8>) -> Result<Grid, String> {
    let fail =
        |error: png::DecodingError| format!("is not a PNG picture that can be read: {error}");
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut picture = decoder.read_info().map_err(fail)?;
    let (width, height) = picture.info().size();
    let size = [width, height].map(|n| n as usize);
    check(size)?;
    let length = picture.output_buffer_size().ok_or("is too large")?;
    let mut pixels = vec![0; length];
    let frame = picture.next_frame(&mut pixels).map_err(fail)?;
    // The checksum of the last row, and what follows.
    picture.finish().map_err(fail)?;
    let channels = frame.color_type.samples();
    let rows = pixels[..frame.buffer_size()]
        .chunks_exact(frame.line_size)
        .rev();
    let heights = rows.flat_map(|row| row.chunks_exact(channels).map(|pixel| f64::from(pixel[0])));
    Ok((size, heights.collect()))
}

/// Checks the size of a picture before its pixels are read.
#[cfg(feature = "png")]
fn check([width, height]: [usize; 2]) -> Result<(), String> {
    if width < 2 || height < 2 {
        return Err(format!(
            "has {width} × {height} pixels: expected 2 × 2 or more"
        ));
    }
    let pixels = checked([width, height])?;
    if pixels > MOST_PIXELS {
        return Err(format!(
            "has {width} × {height} pixels, more than {MOST_PIXELS}"
        ));
    }
    Ok(())
}

/// Number of points of a grid, if there is memory for it.
pub(super) fn checked([columns, rows]: [usize; 2]) -> Result<usize, String> {
    let n = rows.saturating_mul(columns);
    let what = format_args!("a height field of {rows} × {columns} points");
    // The grid, its spline, and their work space.
    memory::check(what, n.saturating_mul(64)).map_err(|error| error.to_string())?;
    Ok(n)
}
