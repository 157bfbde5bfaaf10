//! Shapes: positions, and polygons over them cut into triangles.

use super::{Ids, number, words};
use crate::input::xml::{Node, child, children, tag};
use crate::nested::IntoNested;

/// A shape of a file.
pub(super) struct Geometry<'a> {
    /// The element that holds its positions.
    pub(super) source: Node<'a>,
    pub(super) primitives: Vec<Primitive<'a>>,
}

/// Triangles of one material.
pub(super) struct Primitive<'a> {
    /// The name by which whoever draws the shape gives the material.
    pub(super) material: Option<&'a str>,
    /// Indices of positions, not checked.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Reads a `<geometry>`; `None` if it is not a mesh.
pub(super) fn read<'a>(node: Node<'a>, ids: &Ids<'a>) -> Result<Option<Geometry<'a>>, String> {
    let Some(mesh) = child(node, "mesh") else {
        return Ok(None);
    };
    let vertices = child(mesh, "vertices").ok_or("has a <mesh> without <vertices>")?;
    let source = input(vertices, "POSITION").and_then(|input| ids.target(input, "source"));
    let source = source.ok_or("has <vertices> without positions")?;
    let primitives = mesh.children().filter(Node::is_element);
    let primitives = primitives.filter_map(|node| primitive(node).transpose());
    Ok(Some(Geometry {
        source,
        primitives: primitives.collect::<Result<_, _>>()?,
    }))
}

/// The positions of a `<source>`.
pub(super) fn positions(source: Node<'_>) -> Result<Vec<[f32; 3]>, String> {
    let array = child(source, "float_array").ok_or("has positions without <float_array>")?;
    let accessor = child(source, "technique_common").and_then(|node| child(node, "accessor"));
    let (stride, offset) = match accessor {
        Some(accessor) => (count(accessor, "stride", 3)?, count(accessor, "offset", 0)?),
        None => (3, 0),
    };
    if stride < 3 {
        return Err(format!("has positions of {stride} numbers each"));
    }
    let mut positions = Vec::new();
    let mut position = [0.0; 3];
    let mut place = 0;
    for word in words(array).skip(offset) {
        if let Some(x) = position.get_mut(place) {
            *x = number(word).ok_or("has a position that is not three numbers")?;
        }
        place += 1;
        if place == 3 {
            positions.push(position);
        }
        if place == stride {
            place = 0;
        }
    }
    if (1..3).contains(&place) {
        return Err("has a position that is not three numbers".into());
    }
    Ok(positions)
}

/// The triangles of an element, if it is one with polygons.
fn primitive<'a>(node: Node<'a>) -> Result<Option<Primitive<'a>>, String> {
    let cut: fn(&[u32], &mut Vec<[u32; 3]>) = match tag(node) {
        "triangles" | "polylist" | "polygons" | "trifans" => fan,
        "tristrips" => strip,
        _ => return Ok(None),
    };
    let Some(vertex) = input(node, "VERTEX") else {
        return Ok(None);
    };
    let tuple = Tuple::read(node, vertex)?;
    let mut triangles = Vec::new();
    for indices in children(node, "p").chain(children(node, "ph").filter_map(|ph| child(ph, "p"))) {
        let corners = tuple.corners(indices)?;
        match tag(node) {
            "triangles" => each(&corners, std::iter::repeat(3), cut, &mut triangles)?,
            "polylist" => each(&corners, polygon_sizes(node), cut, &mut triangles)?,
            _ => cut(&corners, &mut triangles),
        }
    }
    Ok(Some(Primitive {
        material: node.attribute("material"),
        triangles,
    }))
}

/// Numbers of corners; one that is none ends them.
fn polygon_sizes<'a>(polylist: Node<'a>) -> impl Iterator<Item = usize> {
    let sizes = children(polylist, "vcount").nested(words);
    sizes.map_while(|size| size.parse().ok())
}

/// Triangulates consecutive polygons.
fn each(
    mut corners: &[u32],
    mut sizes: impl Iterator<Item = usize>,
    cut: fn(&[u32], &mut Vec<[u32; 3]>),
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), String> {
    while !corners.is_empty() {
        let size = sizes.next().filter(|&size| size > 0);
        let split = size.and_then(|size| corners.split_at_checked(size));
        let (polygon, rest) =
            split.ok_or("has polygons with more or fewer corners than there are")?;
        cut(polygon, triangles);
        corners = rest;
    }
    Ok(())
}

fn fan(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    if let [first, rest @ ..] = corners {
        triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
    }
}

/// Adds the triangles of a strip, every second of which turns the other way.
fn strip(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let turned = corners.windows(3).enumerate();
    triangles.extend(turned.map(|(i, t)| {
        if i % 2 == 0 {
            [t[0], t[1], t[2]]
        } else {
            [t[1], t[0], t[2]]
        }
    }));
}

/// Layout of the indices of a corner.
struct Tuple {
    /// Indices a corner.
    stride: usize,
    /// Index of the position among them.
    vertex: usize,
}

impl Tuple {
    fn read(node: Node<'_>, vertex: Node<'_>) -> Result<Self, String> {
        let mut offsets = children(node, "input").map(|input| count(input, "offset", 0));
        let last = offsets.try_fold(0, |last, offset| Ok::<_, String>(last.max(offset?)))?;
        Ok(Self {
            stride: last.saturating_add(1),
            vertex: count(vertex, "offset", 0)?,
        })
    }

    /// The positions of the corners.
    fn corners(&self, indices: Node<'_>) -> Result<Vec<u32>, String> {
        let mut corners = Vec::new();
        let mut place = 0;
        for word in words(indices) {
            if place == self.vertex {
                let corner = word
                    .parse()
                    .map_err(|_| "has a corner that is not a vertex")?;
                corners.push(corner);
            }
            place += 1;
            if place == self.stride {
                place = 0;
            }
        }
        if place != 0 {
            return Err("has polygons with more or fewer indices than corners need".into());
        }
        Ok(corners)
    }
}

/// The input of a meaning.
fn input<'a>(node: Node<'a>, semantic: &str) -> Option<Node<'a>> {
    children(node, "input").find(|input| input.attribute("semantic") == Some(semantic))
}

fn count(node: Node<'_>, attribute: &str, default: usize) -> Result<usize, String> {
    let Some(text) = node.attribute(attribute) else {
        return Ok(default);
    };
    let count = text.trim().parse();
    count.map_err(|_| {
        format!(
            "has a <{}> with an {attribute} that is not a count",
            tag(node)
        )
    })
}
