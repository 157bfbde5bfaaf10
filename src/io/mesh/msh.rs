//! MSH: the binary format of `MuJoCo`.
//!
//! Four counts (vertices, normals, texture coordinates, faces) as 32-bit integers; the first three tables in single precision, of 3, 3, and 2 numbers
//! each; three vertices a face as 32-bit integers; little endian. A file without faces is the convex hull of its vertices.

use super::soup::Soup;
use crate::scalar::MapEach;

const NUMBER: usize = 4;
const COUNTS: usize = 4;

/// Reads the triangles of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, String> {
    let (words, rest) = bytes.as_chunks::<NUMBER>();
    let Some((counts, tables)) = words.split_at_checked(COUNTS) else {
        return Err(format!("has {} bytes, less than any MSH file", bytes.len()));
    };
    let count = |k: usize| usize::try_from(i32::from_le_bytes(counts[k])).ok();
    let counts = [count(0), count(1), count(2), count(3)];
    let [Some(vertices), Some(normals), Some(textures), Some(faces)] = counts else {
        return Err("has a negative count in its header".into());
    };
    // Counts have 31 bits: their sums do not overflow.
    let sizes = [3 * vertices, 3 * normals + 2 * textures, 3 * faces].map_each(|n| n as u64);
    let needed = sizes.iter().sum::<u64>();
    if needed != tables.len() as u64 || !rest.is_empty() {
        let wanted = (needed + COUNTS as u64) * NUMBER as u64;
        let held = bytes.len();
        return Err(format!("has {held} bytes, but its header counts {wanted}"));
    }
    let (positions, tables) = tables.split_at(3 * vertices);
    let positions = triples(positions, f32::from_le_bytes);
    if faces == 0 {
        return Soup::hull(positions);
    }
    let corners = triples(&tables[tables.len() - 3 * faces..], u32::from_le_bytes);
    let mut soup = Soup::default();
    soup.positions = positions;
    *soup.triangles(None) = corners;
    Ok(soup)
}

fn triples<T>(words: &[[u8; NUMBER]], number: impl Fn([u8; NUMBER]) -> T) -> Vec<[T; 3]> {
    let (triples, _) = words.as_chunks::<3>();
    triples.iter().map(|words| words.map(&number)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [f32; 15] = [
        0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 4.0, 0.5, 0.5, 0.5,
    ];
    const FACES: [i32; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];

    /// Five vertices with two normals and one texture coordinate, and faces.
    fn file(faces: &[i32]) -> Vec<u8> {
        let counts = [5, 2, 1, faces.len() as i32 / 3];
        let numbers = CORNERS.iter().chain(&[9.0; 8]).map(|x| x.to_le_bytes());
        let words = counts.iter().map(|n| n.to_le_bytes()).chain(numbers);
        words
            .chain(faces.iter().map(|n| n.to_le_bytes()))
            .flatten()
            .collect()
    }

    #[test]
    fn triangles_equal_those_written_and_those_of_the_hull() {
        let mesh = read(&file(&FACES)).unwrap().finish().unwrap();
        assert_eq!(mesh.parts[0].triangles[0], [0, 1, 2]);
        assert_eq!(mesh.parts[0].vertices[..2], [[0.0; 3], [0.0, 3.0, 0.0]]);
        let hull = read(&file(&[])).unwrap().finish().unwrap();
        let part = &hull.parts[0];
        assert_eq!((part.vertices.len(), part.triangles.len()), (4, 4));
        assert!(!part.vertices.contains(&[0.5; 3]));
    }

    #[test]
    fn broken_files_say_what_is_wrong() {
        let whole = file(&FACES);
        let reason = |bytes: &[u8]| read(bytes).and_then(Soup::finish).unwrap_err();
        for length in 0..whole.len() {
            let reason = reason(&whole[..length]);
            assert!(reason.contains(&format!("has {length} bytes")), "{reason}");
        }
        let long = [&whole[..], &[0; 4]].concat();
        assert!(
            reason(&long).ends_with("but its header counts 156"),
            "{}",
            reason(&long)
        );
        let changed = |at: usize, by: [u8; 4]| {
            let mut bytes = whole.clone();
            bytes[at..at + 4].copy_from_slice(&by);
            reason(&bytes)
        };
        for at in [0, 4, 8, 12] {
            assert!(changed(at, i32::MAX.to_le_bytes()).contains("its header counts"));
            assert_eq!(
                changed(at, (-1_i32).to_le_bytes()),
                "has a negative count in its header"
            );
        }
        assert_eq!(
            changed(whole.len() - 4, 7_i32.to_le_bytes()),
            "has no vertex 7"
        );
        assert!(changed(whole.len() - 4, (-2_i32).to_le_bytes()).starts_with("has no vertex"));
        assert!(changed(16, f32::NAN.to_le_bytes()).contains("NaN"));
        let mut cloud = file(&[]);
        cloud[16..20].copy_from_slice(&f32::INFINITY.to_le_bytes());
        assert!(reason(&cloud).contains("inf"));
        assert_eq!(reason(&[0; 16]), "has no vertices");
        let mut flat = [0; 64];
        flat[0] = 4;
        assert!(reason(&flat).contains("in one plane"));
    }
}
