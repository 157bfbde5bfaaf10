//! Arrays of numbers in an HTML viewer: the bytes of a typed array, little-endian, in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

use crate::nested::IntoNested;

/// An array of numbers that the HTML viewer decodes in one go.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Blob {
    /// Name of the typed array.
    #[serde(rename = "type")]
    kind: &'static str,
    data: String,
}

impl Blob {
    pub(super) fn f64(numbers: impl IntoIterator<Item = f64>) -> Self {
        Self::of("f64", numbers.into_iter().nested(f64::to_le_bytes))
    }

    /// Converts to single precision: seven digits, more than a screen shows.
    pub(super) fn f32(numbers: impl IntoIterator<Item = f64>) -> Self {
        let bytes = |x: f64| (x as f32).to_le_bytes();
        Self::of("f32", numbers.into_iter().nested(bytes))
    }

    /// Numbers in −1..1 to 1 part in 32767.
    pub(super) fn unit(numbers: impl IntoIterator<Item = f64>) -> Self {
        let bytes = |x: f64| ((x * f64::from(i16::MAX)).round() as i16).to_le_bytes();
        Self::of("unit", numbers.into_iter().nested(bytes))
    }

    pub(super) fn u32(numbers: impl IntoIterator<Item = u32>) -> Self {
        Self::of("u32", numbers.into_iter().nested(u32::to_le_bytes))
    }

    fn of(kind: &'static str, bytes: impl Iterator<Item = u8>) -> Self {
        Self {
            kind,
            data: STANDARD.encode(bytes.collect::<Vec<u8>>()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blobs_equal_bytes_by_hand() {
        assert_eq!(Blob::f32([1.0]).data, "AACAPw==");
        assert_eq!(Blob::unit([-1.0, 0.5]).data, "AYAAQA==");
        assert_eq!(Blob::u32([258]).data, "AgEAAA==");
    }
}
