//! Triangles as the formats give them, and parts of one colour as those who need meshes want them.

use std::collections::HashMap;

use crate::nested::IntoNested;
use crate::spatial::geometry::hull;

/// Red, green, blue, opacity; `None` where a file gives no colour.
pub(super) type Color = Option<[f32; 4]>;

/// Content of a mesh file.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    /// The parts, at least one, each with at least one triangle.
    pub(crate) parts: Vec<Part>,
    /// Remarks for a person on how the file was read, each an end of the sentence "the mesh …".
    pub(crate) remarks: Vec<String>,
}

/// Triangles of one colour.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Corners of triangles, each once, finite, m before the scale of the description.
    pub(crate) vertices: Vec<[f32; 3]>,
    /// Vertices of the triangles, at least one.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The colour in the file, red, green, blue, opacity.
    pub(crate) color: Color,
}

impl Mesh {
    /// The convex hull of all parts.
    pub(crate) fn hull(self) -> Result<Self, String> {
        let parts = self.parts.into_iter();
        Soup::hull(parts.nested(|part| part.vertices).collect())?.finish()
    }
}

/// Triangles over one table of positions.
#[derive(Debug, Default)]
pub(super) struct Soup {
    /// Positions, in any number of copies, m.
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) remarks: Vec<String>,
    /// Triangles by colour, in the order in which colours come.
    groups: Vec<(Color, Vec<[u32; 3]>)>,
    group_of: HashMap<Option<[u32; 4]>, usize>,
}

impl Soup {
    /// The triangles of a colour: indices of positions, which are checked at the end.
    pub(super) fn triangles(&mut self, color: Color) -> &mut Vec<[u32; 3]> {
        let bits = color.map(|color| color.map(f32::to_bits));
        let group = *self.group_of.entry(bits).or_insert_with(|| {
            self.groups.push((color, Vec::new()));
            self.groups.len() - 1
        });
        &mut self.groups[group].1
    }

    /// Says something once.
    pub(super) fn remark(&mut self, remark: impl Into<String>) {
        let remark = remark.into();
        if !self.remarks.contains(&remark) {
            self.remarks.push(remark);
        }
    }

    /// The surface of the convex hull of the positions.
    pub(super) fn hull(positions: Vec<[f32; 3]>) -> Result<Self, String> {
        if let Some(position) = positions.iter().find(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(format!("has the vertex {position:?}"));
        }
        if positions.is_empty() {
            return Err("has no vertices".into());
        }
        let hull = hull(&positions)?;
        if hull.triangles.is_empty() {
            return Err("has no triangles, and its vertices are in one plane".into());
        }
        let mut soup = Self {
            positions: hull.vertices,
            ..Self::default()
        };
        *soup.triangles(None) = hull.triangles;
        hull.remark
            .into_iter()
            .for_each(|remark| soup.remark(remark));
        Ok(soup)
    }

    /// The parts, without the repetitions of positions that STL files have, or the reason why there are none.
    pub(super) fn finish(self) -> Result<Mesh, String> {
        let first_of = first_of_equals(&self.positions);
        let mut numbering = Numbering::new(&self.positions, &first_of);
        let groups = self.groups.into_iter();
        let groups = groups.filter(|(_, triangles)| !triangles.is_empty());
        let parts = groups.map(|(color, triangles)| numbering.part(triangles, color));
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        if parts.is_empty() {
            return Err("has no triangles".into());
        }
        Ok(Mesh {
            parts,
            remarks: self.remarks,
        })
    }
}

/// The first of the positions that equal each one.
fn first_of_equals(positions: &[[f32; 3]]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len() / 4);
    let indices = (0..).zip(positions);
    let first_of = indices.map(|(i, p): (u32, _)| *first.entry(p.map(f32::to_bits)).or_insert(i));
    first_of.collect()
}

/// The numbers of vertices in a part, in the order in which its triangles use them.
struct Numbering<'a> {
    positions: &'a [[f32; 3]],
    first_of: &'a [u32],
    /// Number of each position in the current part, or `UNUSED`.
    number_of: Vec<u32>,
}

const UNUSED: u32 = u32::MAX;

impl<'a> Numbering<'a> {
    fn new(positions: &'a [[f32; 3]], first_of: &'a [u32]) -> Self {
        Self {
            positions,
            first_of,
            number_of: vec![UNUSED; positions.len()],
        }
    }

    fn part(&mut self, mut triangles: Vec<[u32; 3]>, color: Color) -> Result<Part, String> {
        let mut used = Vec::new();
        for corner in triangles.iter_mut().flatten() {
            *corner = self.number(*corner, &mut used)?;
        }
        let vertices = used.iter().map(|&i| self.positions[i as usize]).collect();
        for i in used {
            self.number_of[i as usize] = UNUSED;
        }
        Ok(Part {
            vertices,
            triangles,
            color,
        })
    }

    fn number(&mut self, corner: u32, used: &mut Vec<u32>) -> Result<u32, String> {
        let first = self.first_of.get(corner as usize);
        let first = *first.ok_or_else(|| format!("has no vertex {corner}"))?;
        let number = &mut self.number_of[first as usize];
        if *number == UNUSED {
            let position = self.positions[first as usize];
            if !position.iter().all(|x| x.is_finite()) {
                return Err(format!("has the vertex {position:?}"));
            }
            *number = used.len() as u32;
            used.push(first);
        }
        Ok(*number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hold_each_vertex_once_in_the_order_of_use() {
        let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut soup = Soup {
            positions: vec![a, b, c, b, c, d],
            ..Soup::default()
        };
        let red = Some([1.0, 0.0, 0.0, 1.0]);
        soup.triangles(None).push([2, 1, 0]);
        soup.triangles(red).push([5, 4, 3]);
        soup.triangles(None).push([3, 4, 5]);
        let parts = soup.finish().unwrap().parts;
        assert_eq!(parts[0].vertices, [c, b, a, d]);
        assert_eq!(parts[0].triangles, [[0, 1, 2], [1, 0, 3]]);
        assert_eq!(
            (&parts[1].vertices[..], parts[1].color),
            (&[d, c, b][..], red)
        );
    }

    /// As many colours as triangles, each over positions of its own: time and memory by the square would show.
    #[test]
    fn parts_of_many_colours_take_linear_time() {
        const N: u32 = 200_000;
        let mut soup = Soup::default();
        for i in 0..N {
            soup.positions.push([i as f32, 0.0, 0.0]);
            let color = Some([i as f32, 0.0, 0.0, 1.0]);
            soup.triangles(color).push([i; 3]);
        }
        assert_eq!(soup.finish().unwrap().parts.len(), N as usize);
    }
}
