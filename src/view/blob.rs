//! Arrays of numbers in a page: the bytes of a typed array, little-endian, in base64.

use serde::Serialize;

/// An array of numbers that the page decodes in one go.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Blob {
    /// Which typed array it is.
    #[serde(rename = "type")]
    kind: &'static str,
    data: String,
}

impl Blob {
    pub(super) fn f64(numbers: impl IntoIterator<Item = f64>) -> Self {
        Self::of("f64", numbers.into_iter().flat_map(f64::to_le_bytes))
    }

    /// To single precision: seven digits, more than a screen shows.
    pub(super) fn f32(numbers: impl IntoIterator<Item = f64>) -> Self {
        let bytes = |x: f64| (x as f32).to_le_bytes();
        Self::of("f32", numbers.into_iter().flat_map(bytes))
    }

    /// Numbers in −1..1 to 1 part in 32767.
    pub(super) fn unit(numbers: impl IntoIterator<Item = f64>) -> Self {
        let bytes = |x: f64| ((x * f64::from(i16::MAX)).round() as i16).to_le_bytes();
        Self::of("unit", numbers.into_iter().flat_map(bytes))
    }

    pub(super) fn u32(numbers: impl IntoIterator<Item = u32>) -> Self {
        Self::of("u32", numbers.into_iter().flat_map(u32::to_le_bytes))
    }

    fn of(kind: &'static str, bytes: impl Iterator<Item = u8>) -> Self {
        Self {
            kind,
            data: base64(&bytes.collect::<Vec<u8>>()),
        }
    }
}

/// The bytes in base64 [RFC 4648, section 4].
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let value = bits >> (18 - 6 * digit) & 63;
            let is_padding = digit > chunk.len();
            out.push(if is_padding {
                '='
            } else {
                DIGITS[value as usize].into()
            });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_equals_the_vectors_of_its_standard() {
        let texts = ["", "f", "fo", "foo", "foob", "fooba", "foobar"];
        let expected = [
            "", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy",
        ];
        assert_eq!(texts.map(|text| base64(text.as_bytes())), expected);
    }

    #[test]
    fn blobs_equal_bytes_by_hand() {
        assert_eq!(Blob::f32([1.0]).data, base64(&[0, 0, 128, 63]));
        assert_eq!(Blob::unit([-1.0, 0.5]).data, base64(&[1, 128, 0, 64]));
        assert_eq!(Blob::u32([258]).data, base64(&[2, 1, 0, 0]));
    }
}
