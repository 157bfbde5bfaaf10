//! Meshes that are part of a reference: `data:model/obj;name=NAME,TEXT`, with the text of an OBJ file in which `%` escapes bytes.
//!
//! So descriptions that state vertices, and files written of them, need no file for a mesh.
//!
//! # References
//! RFC 2397; the type `model/obj` in the registry of media types.

use std::fmt::Write;

use crate::scalar::MapEach;

/// Begin of a reference with a mesh.
const START: &str = "data:model/obj";

/// Whether a reference contains its mesh.
pub(crate) fn is_inline(uri: &str) -> bool {
    uri.starts_with(START)
}

/// The text of the OBJ file in a reference; `None` if it contains none.
pub(super) fn text(uri: &str) -> Option<String> {
    let (kind, text) = uri.split_once(',')?;
    is_inline(kind).then(|| percent_decoded(text))?
}

/// A reference that contains a mesh.
///
/// * `corners` – vertices of the triangles, from 0
pub(crate) fn reference(name: &str, vertices: &[[f32; 3]], corners: &[[u32; 3]]) -> String {
    let mut out = format!("{START};name=");
    for byte in name.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' => out.push(byte.into()),
            // Writing to a text does not fail.
            _ => drop(write!(out, "%{byte:02X}")),
        }
    }
    out.push(',');
    for [x, y, z] in vertices {
        let _ = write!(out, "v%20{x}%20{y}%20{z}%0A");
    }
    for corners in corners {
        let [a, b, c] = corners.map_each(|k| u64::from(k) + 1);
        let _ = write!(out, "f%20{a}%20{b}%20{c}%0A");
    }
    out
}

/// A text with each `%` and its two hexadecimal digits replaced by the byte that they mean [RFC 3986, section 2.1];
/// `None` if the bytes are not text.
pub(crate) fn percent_decoded(text: &str) -> Option<String> {
    let mut parts = text.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let digits = part
            .get(..2)
            .filter(|digits| digits.bytes().all(|c| c.is_ascii_hexdigit()));
        let byte = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match byte {
            Some(byte) => {
                bytes.push(byte);
                bytes.extend_from_slice(&part.as_bytes()[2..]);
            }
            None => {
                bytes.push(b'%');
                bytes.extend_from_slice(part.as_bytes());
            }
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_contain_the_text_of_an_obj_file() {
        let vertices = [[0.1, -2.0, 1e-9], [0.0; 3], [3.0; 3]];
        let uri = reference("a b,c/é", &vertices, &[[0, 1, 2]]);
        assert!(
            uri.starts_with("data:model/obj;name=a%20b%2Cc%2F%C3%A9,v%200.1"),
            "{uri}"
        );
        let expected = "v 0.1 -2 0.000000001\nv 0 0 0\nv 3 3 3\nf 1 2 3\n";
        assert_eq!(text(&uri).unwrap(), expected);
        assert_eq!(text("data:model/obj,v 1 2 3").unwrap(), "v 1 2 3");
        for other in [
            "data:model/obj",
            "mesh.obj",
            "data:model/stl,solid",
            "a,data:model/obj,",
        ] {
            assert_eq!(text(other), None);
        }
    }
}
