//! Pictures of red, green and blue bytes as PNG [W3C Portable Network Graphics, second edition].

use crate::nested::IntoNested;
use crate::scalar::from_each;
use miniz_oxide::deflate::compress_to_vec_zlib;

/// Level of compression, between speed (1) and size (10).
const COMPRESSION: u8 = 8;

const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Encodes rows of pixels, three bytes each.
pub(super) fn encode(width: u32, height: u32, pixels: &[u8]) -> Vec<u8> {
    let row = 3 * width as usize;
    // Eight bits, three colours; the usual compression, filters and order.
    let header = [
        &width.to_be_bytes()[..],
        &height.to_be_bytes(),
        &[8, 2, 0, 0, 0],
    ]
    .concat();
    // Each row starts with its filter, none.
    let rows: Vec<u8> = pixels
        .chunks(row)
        .nested(|row| [&[0], row].concat())
        .collect();
    let mut out = SIGNATURE.to_vec();
    add_chunk(&mut out, b"IHDR", &header);
    add_chunk(&mut out, b"IDAT", &compress_to_vec_zlib(&rows, COMPRESSION));
    add_chunk(&mut out, b"IEND", &[]);
    out
}

/// Length, name, content, and the check sum of both.
fn add_chunk(out: &mut Vec<u8>, name: &[u8; 4], content: &[u8]) {
    out.extend((content.len() as u32).to_be_bytes());
    let start = out.len();
    out.extend(name);
    out.extend(content);
    out.extend(crc32(&out[start..]).to_be_bytes());
}

/// The cyclic redundancy check of the standard's annex D.
fn crc32(bytes: &[u8]) -> u32 {
    const POLYNOMIAL: u32 = 0xedb8_8320;
    let step = |c: u32| {
        if c & 1 == 1 {
            POLYNOMIAL ^ (c >> 1)
        } else {
            c >> 1
        }
    };
    let table: [u32; 256] = from_each(|n| (0..8).fold(n as u32, |c, _| step(c)));
    !bytes.iter().fold(!0, |c, &byte| {
        table[((c ^ u32::from(byte)) & 0xff) as usize] ^ (c >> 8)
    })
}

/// Width, height and pixels of what [`encode`] made.
#[cfg(test)]
pub(super) fn decode(png: &[u8]) -> (u32, u32, Vec<u8>) {
    let word = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    let (width, height) = (word(16), word(20));
    let data = &png[41..41 + word(33) as usize];
    let rows = miniz_oxide::inflate::decompress_to_vec_zlib(data).unwrap();
    let rows = rows.chunks(3 * width as usize + 1);
    (
        width,
        height,
        rows.flat_map(|row| &row[1..]).copied().collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_sum_equals_that_of_the_standard() {
        assert_eq!(crc32(b"IEND"), 0xae42_6082);
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn decoded_picture_equals_the_encoded_one() {
        let pixels: Vec<u8> = (0..2 * 3 * 3).map(|k| k * 11).collect();
        assert_eq!(decode(&encode(2, 3, &pixels)), (2, 3, pixels));
    }
}
