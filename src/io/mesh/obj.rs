//! OBJ: positions, polygons, and the diffuse colours of materials in files beside it.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use super::material_library::{MaterialLibraries, key_and_value};
use super::soup::Soup;

/// Reads the polygons of a file, cut into triangles from their first corner, with colours from the material libraries
/// below a folder.
pub(super) fn read(bytes: &[u8], folder: &Path) -> Result<Soup, String> {
    let text = String::from_utf8_lossy(bytes);
    read_with(&text, MaterialLibraries::below(folder))
}

/// Reads the polygons of a text that is in no file: it opens no material libraries.
pub(super) fn read_alone(text: &str) -> Result<Soup, String> {
    read_with(text, MaterialLibraries::none())
}

fn read_with(text: &str, libraries: MaterialLibraries) -> Result<Soup, String> {
    let mut reader = Reader {
        soup: Soup::default(),
        libraries,
        materials: Materials::default(),
        polygon: Vec::new(),
    };
    for (number, line) in logical_lines(text) {
        let (key, value) = key_and_value(&line);
        let read = reader.statement(key, value);
        read.map_err(|reason| format!("{reason} on line {number}"))?;
    }
    Ok(reader.finish())
}

struct Reader {
    soup: Soup,
    libraries: MaterialLibraries,
    materials: Materials,
    /// The corners of the current polygon.
    polygon: Vec<u32>,
}

/// Triangles by material, as the libraries may come after them.
#[derive(Default)]
struct Materials {
    number_of: HashMap<String, usize>,
    triangles: Vec<(String, Vec<[u32; 3]>)>,
    current: usize,
}

impl Materials {
    fn choose(&mut self, name: &str) {
        self.current = match self.number_of.get(name) {
            Some(&number) => number,
            None => {
                let number = self.triangles.len();
                self.number_of.insert(name.into(), number);
                self.triangles.push((name.into(), Vec::new()));
                number
            }
        };
    }

    fn push(&mut self, triangle: [u32; 3]) {
        if self.triangles.is_empty() {
            self.choose("");
        }
        self.triangles[self.current].1.push(triangle);
    }
}

impl Reader {
    fn statement(&mut self, key: &str, value: &str) -> Result<(), String> {
        match key {
            "v" => self.soup.positions.push(position(value)?),
            "f" => self.face(value)?,
            "usemtl" => self.materials.choose(value),
            "mtllib" => {
                if let Err(reason) = self.libraries.add(value) {
                    let remark = "has no colours from a material library";
                    self.soup.remark(format!("{remark}: {reason}"));
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn face(&mut self, value: &str) -> Result<(), String> {
        self.polygon.clear();
        let words = value.split_ascii_whitespace();
        for word in words.take_while(|word| !word.starts_with('#')) {
            let corner = corner(word, self.soup.positions.len());
            let corner = corner.ok_or("has a face with a corner that is not a vertex")?;
            self.polygon.push(corner);
        }
        if let [first, rest @ ..] = &self.polygon[..] {
            for pair in rest.windows(2) {
                self.materials.push([*first, pair[0], pair[1]]);
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Soup {
        for (material, triangles) in self.materials.triangles {
            let color = self.libraries.color(&material);
            self.soup.triangles(color).extend(triangles);
        }
        self.soup
    }
}

/// The first three numbers of a line.
fn position(value: &str) -> Result<[f32; 3], String> {
    let mut words = value.split_ascii_whitespace();
    let mut number = || words.next()?.parse().ok();
    let (Some(x), Some(y), Some(z)) = (number(), number(), number()) else {
        return Err("has a vertex without three numbers".into());
    };
    Ok([x, y, z])
}

/// The position that a corner `position/texture/normal` names: from 1, or from the latest backwards.
fn corner(word: &str, latest: usize) -> Option<u32> {
    let index = word.split('/').next()?.parse::<i64>().ok()?;
    let from_zero = match index {
        0 => return None,
        1.. => index - 1,
        _ => i64::try_from(latest).ok()? + index,
    };
    u32::try_from(from_zero).ok()
}

/// The lines with their numbers, from 1; lines that end with a backslash are one with the next.
fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = (1..).zip(text.lines());
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let Some(start) = line.strip_suffix('\\') else {
            return Some((number, Cow::Borrowed(line)));
        };
        let mut whole = start.to_owned();
        for (_, next) in lines.by_ref() {
            whole.push(' ');
            whole.push_str(next.trim_end_matches('\\'));
            if !next.ends_with('\\') {
                break;
            }
        }
        Some((number, Cow::Owned(whole)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::mesh::soup::{Color, Mesh};
    use crate::io::temporary::Folder;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0 1\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\n";

    fn mesh(text: &str, folder: &Folder) -> Mesh {
        let soup = read(text.as_bytes(), &folder.path("")).unwrap();
        soup.finish().unwrap()
    }

    fn colors(mesh: &Mesh) -> Vec<Color> {
        mesh.parts.iter().map(|part| part.color).collect()
    }

    #[test]
    fn polygons_equal_fans_of_triangles_however_their_corners_are_written() {
        let folder = Folder::new();
        for face in [
            "f 1 2 3 4",
            "f 1/7/7 2//3 \\\r\n 3/1 4",
            "f -4 -3 -2 -1",
            "f 1 2 \\\n 3\\\n 4",
        ] {
            let mesh = mesh(
                &format!("# f 1 2 3\n{SQUARE}{face}\nl 1 2\nf 1 2\n"),
                &folder,
            );
            assert_eq!(mesh.parts[0].triangles, [[0, 1, 2], [0, 2, 3]], "{face}");
            assert_eq!(mesh.parts[0].vertices[2], [1.0, 1.0, 0.0]);
        }
        for (face, reason) in [
            (
                "f 1 2 0",
                "has a face with a corner that is not a vertex on line 5",
            ),
            (
                "f 1 2 -5",
                "has a face with a corner that is not a vertex on line 5",
            ),
            (
                "f 1 2 x",
                "has a face with a corner that is not a vertex on line 5",
            ),
            ("v 1 2", "has a vertex without three numbers on line 5"),
        ] {
            let error = read(format!("{SQUARE}{face}").as_bytes(), &folder.path(""));
            assert_eq!(error.unwrap_err(), reason);
        }
        let soup = read(format!("{SQUARE}f 1 2 5").as_bytes(), &folder.path("")).unwrap();
        assert_eq!(soup.finish().unwrap_err(), "has no vertex 4");
    }

    #[test]
    fn colours_equal_those_of_the_materials_across_groups_and_libraries() {
        let folder = Folder::new();
        folder.write(
            "a.mtl",
            "newmtl red\nKa 0 0 0\nKd 1 0 0\nd 0.5\nnewmtl none\n",
        );
        folder.write("sub/b c.mtl", "newmtl grey one\n  Kd 0.5\n");
        let text = format!(
            "mtllib a.mtl\n{SQUARE}f 1 2 3\nusemtl red\ng x\nf 1 2 4\nusemtl none\nf 1 3 4\nusemtl grey one\nf 1 2 3\n\
             usemtl red\nf 2 3 4\nmtllib sub/b c.mtl\n"
        );
        let mesh = mesh(&text, &folder);
        let (red, grey) = (Some([1.0, 0.0, 0.0, 1.0]), Some([0.5, 0.5, 0.5, 1.0]));
        assert_eq!(colors(&mesh), [None, red, grey]);
        assert_eq!(mesh.parts[1].triangles.len(), 2);
        assert!(mesh.remarks.is_empty(), "{:?}", mesh.remarks);
    }

    #[test]
    fn libraries_are_opened_below_the_folder_of_the_mesh_only() {
        let outside = Folder::new();
        let secret = outside.write("secret.mtl", "newmtl m\nKd 1 0 0\n");
        let folder = Folder::new();
        folder.write("large.mtl", vec![b' '; 1 + (1 << 20)]);
        let up = format!(
            "../{}/secret.mtl",
            outside.path("").file_name().unwrap().display()
        );
        assert!(folder.path(&up).is_file());
        let mut names = vec![
            up,
            secret.display().to_string(),
            "none.mtl".into(),
            "large.mtl".into(),
            ".".into(),
            String::new(),
        ];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&secret, folder.path("link.mtl")).unwrap();
            let made = std::process::Command::new("mkfifo")
                .arg(folder.path("pipe.mtl"))
                .status();
            assert!(made.unwrap().success());
            names.extend(["link.mtl", "pipe.mtl", "/dev/zero"].map(Into::into));
        }
        for name in names {
            let mesh = mesh(
                &format!("mtllib {name}\n{SQUARE}usemtl m\nf 1 2 3\n"),
                &folder,
            );
            assert_eq!(colors(&mesh), [None], "{name}");
            assert_eq!(mesh.remarks.len(), 1, "{name}");
        }
        let many = "mtllib none.mtl\n".repeat(100_000);
        let mesh = mesh(&format!("{many}{SQUARE}f 1 2 3\n"), &folder);
        assert_eq!(mesh.remarks.len(), 2, "{:?}", mesh.remarks);
    }

    /// Both took minutes, or gigabytes, where groups copied the table of positions or polygons were cut by searching.
    #[test]
    fn large_polygons_and_many_groups_take_linear_time() {
        let folder = Folder::new();
        let corners: String = (0..500_000).map(|i| format!(" {}", 1 + i % 4)).collect();
        let polygon = mesh(&format!("{SQUARE}f{corners}\n"), &folder);
        assert_eq!(polygon.parts[0].triangles.len(), 499_998);
        let groups: String = (0..100_000)
            .map(|i| format!("g {i}\nusemtl {i}\nf 1 2 3\n"))
            .collect();
        let groups = mesh(&format!("{SQUARE}{groups}"), &folder);
        assert_eq!(groups.parts[0].triangles.len(), 100_000);
        let continued = mesh(
            &format!("{SQUARE}f 1 2 3{}\n", " \\\n".repeat(200_000)),
            &folder,
        );
        assert_eq!(continued.parts[0].triangles.len(), 1);
    }
}
