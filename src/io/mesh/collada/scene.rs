//! Draws the scene: from its root along all nodes to the triangles.
//!
//! A node or a shape may be drawn any number of times, and nodes may refer to each other in a circle: what is
//! drawn *again* is bounded, all else is in the file once.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use nalgebra::{Matrix4, Point3};
use roxmltree::NodeId;

use super::Ids;
use super::geometry::{self, Geometry};
use super::material::Colors;
use super::node::{self, SceneNode};
use crate::input::xml::{Node, child, tag};
use crate::io::mesh::soup::{Color, Soup};
use crate::scalar::MapEach;

/// Most nodes that are drawn again.
const MAX_NODES_AGAIN: usize = 100_000;

/// Most triangles that are drawn again.
const MAX_TRIANGLES_AGAIN: usize = 200_000;

/// Draws the scene of a file; without one, all its shapes.
pub(super) fn draw<'a>(
    root: Node<'a>,
    world: &Matrix4<f64>,
    soup: &mut Soup,
) -> Result<(), String> {
    let mut drawing = Drawing {
        ids: Ids::of(root),
        nodes: HashMap::new(),
        shapes: HashMap::new(),
        sources: HashMap::new(),
        colors: Colors::default(),
        instances: 0,
        nodes_again: 0,
        triangles_again: 0,
        soup,
    };
    let instance = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let scene = instance.and_then(|instance| drawing.ids.target(instance, "url"));
    let library = || child(root, "library_visual_scenes").and_then(|l| child(l, "visual_scene"));
    match scene.or_else(library) {
        Some(scene) => drawing.scene(scene, world),
        None => drawing.all_shapes(root, world),
    }
}

struct Drawing<'a, 's> {
    ids: Ids<'a>,
    nodes: HashMap<NodeId, SceneNode<'a>>,
    shapes: HashMap<NodeId, Option<Geometry<'a>>>,
    sources: HashMap<NodeId, Source>,
    colors: Colors<'a>,
    /// Number of shapes drawn so far.
    instances: u32,
    nodes_again: usize,
    triangles_again: usize,
    soup: &'s mut Soup,
}

/// Positions, and where the instance that used each of them last put it.
struct Source {
    positions: Vec<[f32; 3]>,
    placed: Vec<Placed>,
}

#[derive(Clone, Copy, Default)]
struct Placed {
    /// Number of the instance, from 1.
    instance: u32,
    index: u32,
}

impl<'a> Drawing<'a, '_> {
    fn scene(&mut self, root: Node<'a>, world: &Matrix4<f64>) -> Result<(), String> {
        let mut open = vec![(root, *world)];
        while let Some((element, above)) = open.pop() {
            match tag(element) {
                "instance_geometry" => {
                    if let Some(shape) = self.ids.target(element, "url") {
                        self.shape(shape, Some(element), &above)?;
                    }
                }
                "instance_controller" => {
                    let controller = self.ids.target(element, "url");
                    let skin = controller.and_then(|controller| child(controller, "skin"));
                    if let Some(shape) = skin.and_then(|skin| self.ids.target(skin, "source")) {
                        self.shape(shape, Some(element), &above)?;
                    }
                }
                "instance_node" => {
                    open.extend(self.ids.target(element, "url").map(|node| (node, above)));
                }
                _ => self.open(element, &above, &mut open)?,
            }
        }
        Ok(())
    }

    /// Puts the children of a node on the list, so that the first comes next.
    fn open(
        &mut self,
        element: Node<'a>,
        above: &Matrix4<f64>,
        open: &mut Vec<(Node<'a>, Matrix4<f64>)>,
    ) -> Result<(), String> {
        match self.nodes.get(&element.id()) {
            Some(known) => {
                self.nodes_again += 1 + known.content.len();
                if self.nodes_again > MAX_NODES_AGAIN {
                    return Err("has nodes that contain each other, or too many nodes".into());
                }
            }
            None => drop(self.nodes.insert(element.id(), node::read(element)?)),
        }
        let node = &self.nodes[&element.id()];
        if node.is_approximate && !node.content.is_empty() {
            self.soup
                .remark("has a <lookat> or <skew>, which is not applied");
        }
        let placement = above * node.placement;
        open.extend(
            node.content
                .iter()
                .rev()
                .map(|&element| (element, placement)),
        );
        Ok(())
    }

    fn all_shapes(&mut self, root: Node<'a>, world: &Matrix4<f64>) -> Result<(), String> {
        let shapes = root.descendants().filter(|node| tag(*node) == "geometry");
        for shape in shapes {
            self.shape(shape, None, world)?;
        }
        Ok(())
    }

    /// Draws a `<geometry>`, with the materials that an instance gives.
    fn shape(
        &mut self,
        element: Node<'a>,
        instance: Option<Node<'a>>,
        placement: &Matrix4<f64>,
    ) -> Result<(), String> {
        let is_again = self.shapes.contains_key(&element.id());
        if !is_again {
            let read = geometry::read(element, &self.ids)?;
            self.shapes.insert(element.id(), read);
        }
        let Some(shape) = &self.shapes[&element.id()] else {
            return Ok(());
        };
        let triangles = shape.primitives.iter().map(|p| 1 + p.triangles.len());
        self.triangles_again += if is_again { triangles.sum() } else { 0 };
        if self.triangles_again > MAX_TRIANGLES_AGAIN {
            return Err("draws the same triangles too often".into());
        }
        self.instances += 1;
        if let Entry::Vacant(entry) = self.sources.entry(shape.source.id()) {
            entry.insert(Source::new(geometry::positions(shape.source)?));
        }
        let Some(source) = self.sources.get_mut(&shape.source.id()) else {
            return Ok(());
        };
        let materials = match instance {
            Some(instance) => Some(self.colors.bound(instance, &self.ids)?),
            None => None,
        };
        for primitive in &shape.primitives {
            let color = materials.zip(primitive.material);
            let drawn = Instance {
                number: self.instances,
                placement,
                color: color.and_then(|(materials, name)| *materials.get(name)?),
            };
            source.draw(&primitive.triangles, &drawn, self.soup)?;
        }
        Ok(())
    }
}

/// One drawing of a shape.
struct Instance<'a> {
    number: u32,
    placement: &'a Matrix4<f64>,
    color: Color,
}

impl Source {
    fn new(positions: Vec<[f32; 3]>) -> Self {
        let placed = vec![Placed::default(); positions.len()];
        Self { positions, placed }
    }

    fn draw(
        &mut self,
        triangles: &[[u32; 3]],
        instance: &Instance<'_>,
        soup: &mut Soup,
    ) -> Result<(), String> {
        let mut drawn = Vec::with_capacity(triangles.len());
        for &[a, b, c] in triangles {
            let mut place = |corner| self.place(corner, instance, &mut soup.positions);
            drawn.push([place(a)?, place(b)?, place(c)?]);
        }
        soup.triangles(instance.color).extend(drawn);
        Ok(())
    }

    /// The index among the positions of the soup of one of its own.
    fn place(
        &mut self,
        corner: u32,
        instance: &Instance<'_>,
        positions: &mut Vec<[f32; 3]>,
    ) -> Result<u32, String> {
        let i = corner as usize;
        let placed = self.placed.get_mut(i);
        let placed = placed.ok_or_else(|| format!("has no vertex {corner}"))?;
        if placed.instance != instance.number {
            let index = positions.len() as u32;
            *placed = Placed {
                instance: instance.number,
                index,
            };
            let position = Point3::from(self.positions[i].map_each(f64::from));
            let position = instance.placement.fixed_view::<3, 4>(0, 0) * position.to_homogeneous();
            positions.push([position.x, position.y, position.z].map_each(|x| x as f32));
        }
        Ok(placed.index)
    }
}
