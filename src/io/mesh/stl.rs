//! STL: binary, and as text.
//!
//! Binary: 80 bytes of anything, the number of triangles, and 50 bytes a triangle: the normal, three corners, two bytes
//! of anything; little endian. Text: `solid`, `facet normal`, `outer loop`, `vertex`, `endloop`, `endfacet`,
//! `endsolid`.

use super::soup::Soup;
use crate::scalar::from_each;

const HEADER: usize = 80;
const COUNT: usize = 4;
const TRIANGLE: usize = 50;
const NUMBER: usize = 4;

/// Reads the triangles of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, String> {
    if is_text(bytes) {
        read_text(&String::from_utf8_lossy(bytes))
    } else {
        read_binary(bytes)
    }
}

/// Binary files may begin with `solid` as well, but no text has a zero byte.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let word = start.get(..5).unwrap_or_default();
    let has_zero = bytes
        .iter()
        .take(HEADER + COUNT + TRIANGLE)
        .any(|&b| b == 0);
    word.eq_ignore_ascii_case(b"solid") && !has_zero
}

fn read_binary(bytes: &[u8]) -> Result<Soup, String> {
    let Some((header, triangles)) = bytes.split_at_checked(HEADER + COUNT) else {
        return Err(format!("has {} bytes, less than any STL file", bytes.len()));
    };
    let count = header[HEADER..].iter().rev();
    let count = count.fold(0, |count, &byte| count << 8 | usize::from(byte));
    let whole = triangles.len() / TRIANGLE;
    if count > whole {
        return Err(format!(
            "is cut off: its header counts {count} triangles, it holds {whole}"
        ));
    }
    let mut soup = Soup::default();
    let mut used = count;
    if count < whole && triangles.len().is_multiple_of(TRIANGLE) {
        used = whole;
        soup.remark(format!(
            "counts {count} triangles in its header and holds {whole}, which are all read"
        ));
    }
    for triangle in triangles.chunks_exact(TRIANGLE).take(used) {
        let (numbers, _) = triangle[3 * NUMBER..].as_chunks::<NUMBER>();
        let [ax, ay, az, bx, by, bz, cx, cy, cz] = from_each(|i| f32::from_le_bytes(numbers[i]));
        push(&mut soup, [[ax, ay, az], [bx, by, bz], [cx, cy, cz]]);
    }
    Ok(soup)
}

fn push(soup: &mut Soup, corners: [[f32; 3]; 3]) {
    let first = soup.positions.len() as u32;
    soup.positions.extend(corners);
    soup.triangles(None).push([first, first + 1, first + 2]);
}

fn read_text(text: &str) -> Result<Soup, String> {
    let mut soup = Soup::default();
    let (mut corners, mut is_closed) = (Vec::new(), false);
    for (number, line) in (1..).zip(text.lines()) {
        let fail = |reason| Err(format!("{reason} on line {number}"));
        let mut words = line.split_ascii_whitespace();
        while let Some(word) = words.next() {
            let word = word.to_ascii_lowercase();
            is_closed = word == "endsolid";
            match word.as_str() {
                // A name follows.
                "solid" | "endsolid" if corners.is_empty() => break,
                "facet" if corners.is_empty() => {}
                "normal" => drop(words.by_ref().take(3).count()),
                "vertex" if corners.len() < 3 => corners.push(vertex(&mut words, number)?),
                "outer" | "loop" | "endloop" => {}
                "endfacet" => match corners[..] {
                    [a, b, c] => {
                        push(&mut soup, [a, b, c]);
                        corners.clear();
                    }
                    _ => return fail("has a facet of fewer than three vertices"),
                },
                _ => return fail("has a word out of place"),
            }
        }
    }
    if !corners.is_empty() {
        return Err("is cut off within a facet".into());
    }
    if !is_closed {
        soup.remark("ends without \"endsolid\": it may be cut off");
    }
    Ok(soup)
}

fn vertex<'a>(words: &mut impl Iterator<Item = &'a str>, line: u32) -> Result<[f32; 3], String> {
    let mut number = || words.next()?.parse().ok();
    let vertex = (number(), number(), number());
    let (Some(x), Some(y), Some(z)) = vertex else {
        return Err(format!("has a vertex without three numbers on line {line}"));
    };
    Ok([x, y, z])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles, with the count of a header.
    fn binary(count: u32) -> Vec<u8> {
        let mut bytes = b"solid in name only".to_vec();
        bytes.resize(HEADER, 0);
        bytes.extend(count.to_le_bytes());
        for z in [0.0, 1.0] {
            let corners = [0.0, 0.0, z, 1.0, 0.0, z, 0.0, 1.0, z];
            let numbers = [0.0, 0.0, 1.0].into_iter().chain(corners);
            bytes.extend(numbers.flat_map(f32::to_le_bytes));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const TEXT: &str = "solid a name\n facet normal 0 0 1\nouter loop\nvertex 0 0 2e0\nvertex 1 0 2\nvertex 0 1 2\nendloop\nendfacet\n";

    #[test]
    fn binary_triangles_equal_those_written() {
        let soup = read(&binary(2)).unwrap();
        assert_eq!(
            soup.positions[3..],
            [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]
        );
        let mesh = soup.finish().unwrap();
        assert_eq!(mesh.parts[0].triangles, [[0, 1, 2], [3, 4, 5]]);
        assert!(mesh.remarks.is_empty());
    }

    #[test]
    fn files_that_are_cut_off_say_so() {
        let whole = binary(2);
        for length in [84, 100, 134, 183] {
            let error = read(&whole[..length]).unwrap_err();
            let held = (length - 84) / 50;
            let expected = format!("is cut off: its header counts 2 triangles, it holds {held}");
            assert_eq!(error, expected);
        }
        assert!(read(&whole[..83]).unwrap_err().contains("83 bytes"));
        assert!(read(&binary(10_000_000)).unwrap_err().contains("10000000"));

        let text = TEXT.to_owned() + "endsolid a name\n";
        assert!(read(text.as_bytes()).unwrap().remarks.is_empty());
        let remark = &read(TEXT.as_bytes()).unwrap().remarks[0];
        assert!(remark.contains("cut off"), "{remark}");
        let (start, _) = TEXT.split_once("vertex 0 1").unwrap();
        let error = read(start.as_bytes()).unwrap_err();
        assert_eq!(error, "is cut off within a facet");
    }

    #[test]
    fn counts_that_are_too_small_are_remarked_on() {
        let soup = read(&binary(0)).unwrap();
        assert_eq!((soup.positions.len(), soup.remarks.len()), (6, 1));
        let mut with_more = binary(2);
        with_more.push(b'\n');
        let soup = read(&with_more).unwrap();
        assert_eq!((soup.positions.len(), soup.remarks.len()), (6, 0));
    }

    #[test]
    fn broken_text_says_where() {
        let broken = TEXT.replace("2e0", "x");
        let error = read(broken.as_bytes()).unwrap_err();
        assert_eq!(error, "has a vertex without three numbers on line 4");
        let broken = TEXT.replace("outer", "inner");
        let error = read(broken.as_bytes()).unwrap_err();
        assert_eq!(error, "has a word out of place on line 3");
        let broken = TEXT.replace("vertex 0 1 2\n", "");
        let error = read(broken.as_bytes()).unwrap_err();
        assert_eq!(error, "has a facet of fewer than three vertices on line 7");
    }
}
