//! Animations as GIF.
//!
//! GIF is the only animation format that browsers, notebooks and code hosts show like a picture, without a codec. Unchanged pixels take no space.

use crate::nested::IntoNested;
use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, Frame, Repeat};

use super::Picture;
use crate::scalar::MapEach;

/// Colours of an animation; one more is reserved for unchanged pixels.
const COLORS: usize = 255;
const UNCHANGED: u8 = 255;

/// Pictures from which the colours are taken.
const LOOKED_AT: usize = 6;

/// Pixels of them that the network of colours learns from, at most: one of so many.
const SAMPLED: i32 = 7;

/// Bits of red, green and blue by which the nearest colour is looked up.
const BITS: u32 = 5;

/// An animation with a time from one picture to the next.
#[derive(Debug)]
pub(super) struct Animation {
    /// Hundredths of a second: what a GIF counts in.
    delay: u16,
}

impl Animation {
    /// The one whose rate is nearest, pictures a second.
    pub(super) fn of_rate(rate: f64) -> Self {
        let delay = (100.0 / rate).round().clamp(2.0, f64::from(u16::MAX));
        Self {
            delay: delay as u16,
        }
    }

    /// Time from one picture to the next, s.
    pub(super) fn seconds(&self) -> f64 {
        0.01 * f64::from(self.delay)
    }

    /// Encodes so many pictures, one at least, of which each may be asked for twice.
    pub(super) fn encode(&self, count: usize, picture: &dyn Fn(usize) -> Picture) -> Vec<u8> {
        let colors = Colors::of(count, picture);
        let (mut out, mut last) = (Vec::new(), Vec::new());
        let Picture { width, height, .. } = picture(0);
        let [width, height] = [width, height].map_each(|n| u16::try_from(n).unwrap_or(u16::MAX));
        let written = (|| {
            let mut encoder = Encoder::new(&mut out, width, height, &colors.palette)?;
            encoder.set_repeat(Repeat::Infinite)?;
            for k in 0..count {
                let indices = colors.indices(&picture(k));
                encoder.write_frame(&Frame {
                    width,
                    height,
                    delay: self.delay,
                    dispose: DisposalMethod::Keep,
                    transparent: Some(UNCHANGED),
                    buffer: changes(&last, &indices).into(),
                    ..Frame::default()
                })?;
                last = indices;
            }
            Ok::<(), gif::EncodingError>(())
        })();
        // Memory takes whatever is written, and sizes are checked.
        written.unwrap_or_else(|error| unreachable!("{error}"));
        out
    }
}

/// The pixels of a picture that differ from those of the last one.
fn changes(last: &[u8], now: &[u8]) -> Vec<u8> {
    let is_same = |k: usize| last.get(k) == Some(&now[k]);
    (0..now.len())
        .map(|k| if is_same(k) { UNCHANGED } else { now[k] })
        .collect()
}

/// The colours of an animation.
struct Colors {
    palette: Vec<u8>,
    /// The nearest one for each colour of [`BITS`] bits.
    nearest: Vec<u8>,
}

impl Colors {
    fn of(count: usize, picture: &dyn Fn(usize) -> Picture) -> Self {
        let step = count.div_ceil(LOOKED_AT).max(1);
        let pixels: Vec<u8> = (0..count)
            .step_by(step)
            .nested(|k| picture(k).pixels)
            .collect();
        let opaque: Vec<u8> = pixels
            .chunks(3)
            .nested(|p| [p[0], p[1], p[2], 255])
            .collect();
        let network = NeuQuant::new(SAMPLED, COLORS, &opaque);
        let levels = 1_usize << BITS;
        let middle = |k: usize| ((2 * k + 1) * 256 / (2 * levels)) as u8;
        let nearest = (0..levels.pow(3)).map(|k| {
            let [r, g, b] =
                [k / (levels * levels), k / levels % levels, k % levels].map_each(middle);
            network.index_of(&[r, g, b, 255]) as u8
        });
        let mut palette = network.color_map_rgb();
        palette.resize(3 * (COLORS + 1), 0);
        Self {
            nearest: nearest.collect(),
            palette,
        }
    }

    fn indices(&self, picture: &Picture) -> Vec<u8> {
        let of = |pixel: &[u8]| {
            let part = |k: usize| usize::from(pixel[k] >> (8 - BITS));
            self.nearest[(part(0) << (2 * BITS)) + (part(1) << BITS) + part(2)]
        };
        picture.pixels.chunks(3).map(of).collect()
    }
}
