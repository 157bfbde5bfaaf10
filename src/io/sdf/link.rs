//! Links: inertia, shapes, colours.
//!
//! | `<inertial>` | read as |
//! |---|---|
//! | is missing | mass 1 kg, moments 1 kg·m², as the SDF says, with a warning |
//! | has no `<mass>` or no `<inertia>` | 1 kg; moments of 1 kg·m²; with a warning |
//! | `auto="true"` | the inertia of the collisions as solids, of water if no `<density>` is given |

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::reader::Reader;
use super::scene::{FrameKind, Inertial, LinkEntry, MassEntry, Place, Pose, Shape};
use super::schema;
use super::values::{check_value, number, numbers, required, required_text, text_of, truth};
use crate::error::LoadError;
use crate::io::context::{Node, child, children, is_native, tag};
use crate::io::numbers::parse;
use crate::io::schema::{Known, check};
use crate::model::Geometry;
use crate::spatial::{Inertia, Symmetric3};

/// Row by row: kg·m², where a file says nothing.
const UNIT_MOMENTS: [f64; 6] = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];

/// kg/m³, where a file says nothing.
const DENSITY_OF_WATER: f64 = 1000.0;

impl Reader<'_, '_, '_> {
    /// Reads a link into a scope.
    pub(super) fn link(&mut self, node: Node<'_>, scope: usize) -> Result<(), LoadError> {
        check(&mut self.context, node, &schema::LINK)?;
        let name = self.name(node)?.to_owned();
        let pose = self.pose(node)?;
        let inertial = self.inertial(node)?;
        let visuals = self.shapes(node, "visual", &schema::VISUAL)?;
        let collisions = self.shapes(node, "collision", &schema::COLLISION)?;
        let kind = FrameKind::Link(self.shared.scene.links.len());
        let frame = self.add_frame(node, scope, &name, kind, pose)?;
        self.shared.scene.links.push(LinkEntry {
            frame,
            inertial,
            visuals,
            collisions,
        });
        Ok(())
    }

    fn inertial(&mut self, link: Node<'_>) -> Result<Inertial, LoadError> {
        let Some(node) = child(link, "inertial") else {
            let reason = "no <inertial>: taken as 1 kg and 1 kg·m², as the SDF says";
            self.context.warn(link, reason);
            let (pose, inertia) = (Pose::identity(), central(1.0, UNIT_MOMENTS));
            let mass = MassEntry::Given { pose, inertia };
            return Ok(Inertial {
                mass,
                place: Place::new(&self.context, link),
            });
        };
        let auto = node.attribute("auto").unwrap_or_default();
        let mass = if truth(&self.context, node, "auto", auto)? {
            check(&mut self.context, node, &schema::AUTO_INERTIAL)?;
            let density = number(&mut self.context, node, "density")?;
            MassEntry::Solid {
                density: density.unwrap_or(DENSITY_OF_WATER),
            }
        } else {
            self.given_inertial(node)?
        };
        Ok(Inertial {
            mass,
            place: Place::new(&self.context, node),
        })
    }

    fn given_inertial(&mut self, node: Node<'_>) -> Result<MassEntry, LoadError> {
        check(&mut self.context, node, &schema::INERTIAL)?;
        let mass = number(&mut self.context, node, "mass")?;
        if mass.is_none() {
            let reason = "no <mass>: taken as 1 kg, as the SDF says";
            self.context.warn(node, reason);
        }
        let inertia = central(mass.unwrap_or(1.0), self.moments(node)?);
        Ok(MassEntry::Given {
            pose: self.pose(node)?,
            inertia,
        })
    }

    /// The moments and products, row by row.
    fn moments(&mut self, inertial: Node<'_>) -> Result<[f64; 6], LoadError> {
        let mut moments = UNIT_MOMENTS;
        let Some(node) = child(inertial, "inertia") else {
            let reason = "no <inertia>: taken as 1 kg·m², as the SDF says";
            self.context.warn(inertial, reason);
            return Ok(moments);
        };
        check(&mut self.context, node, &schema::INERTIA)?;
        let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        for (moment, name) in moments.iter_mut().zip(names) {
            match number(&mut self.context, node, name)? {
                Some(x) => *moment = x,
                None => {
                    let reason = format!("no <{name}>: taken as {moment}, as the SDF says");
                    self.context.warn(node, reason);
                }
            }
        }
        Ok(moments)
    }

    fn shapes(
        &mut self,
        link: Node<'_>,
        element: &str,
        known: &Known,
    ) -> Result<Vec<Shape>, LoadError> {
        let mut shapes = Vec::new();
        for node in children(link, element) {
            check(&mut self.context, node, known)?;
            let pose = self.pose(node)?;
            let Some((shape, known)) = self.find_shape(node)? else {
                self.context.ignore(node, "has no shape that is known");
                continue;
            };
            check(&mut self.context, shape, known)?;
            shapes.push(Shape {
                name: node.attribute("name").map(Into::into),
                pose,
                geometry: self.geometry(shape)?,
                color: self.color(node)?,
                density: number(&mut self.context, node, "density")?,
            });
        }
        Ok(shapes)
    }

    /// The first shape of a visual or collision; reports the others.
    fn find_shape<'a>(
        &mut self,
        node: Node<'a>,
    ) -> Result<Option<(Node<'a>, &'static Known)>, LoadError> {
        let Some(geometry) = child(node, "geometry") else {
            return Ok(None);
        };
        check(&mut self.context, geometry, &schema::GEOMETRY)?;
        let mut found = None;
        for shape in geometry.children().filter(|shape| is_native(*shape)) {
            let known = schema::SHAPES.iter().find(|(name, _)| *name == tag(shape));
            match known {
                Some((_, known)) if found.is_none() => found = Some((shape, known)),
                Some(_) => self.context.ignore(shape, "only the first shape is read"),
                None => {}
            }
        }
        Ok(found)
    }

    fn geometry(&mut self, shape: Node<'_>) -> Result<Geometry, LoadError> {
        let context = &mut self.context;
        if tag(shape) == "mesh" {
            return self.mesh(shape);
        }
        if tag(shape) == "box" {
            let size = required::<3>(context, shape, "size")?;
            self.check_lengths(shape, &size);
            return Ok(Geometry::Box { size });
        }
        let [radius] = required::<1>(context, shape, "radius")?;
        if tag(shape) == "sphere" {
            self.check_lengths(shape, &[radius]);
            return Ok(Geometry::Sphere { radius });
        }
        let [length] = required::<1>(context, shape, "length")?;
        self.check_lengths(shape, &[radius, length]);
        Ok(match tag(shape) {
            "capsule" => Geometry::Capsule { radius, length },
            _ => Geometry::Cylinder { radius, length },
        })
    }

    fn check_lengths(&mut self, shape: Node<'_>, lengths: &[f64]) {
        if lengths.iter().any(|&length| length <= 0.0) {
            self.context.warn(shape, "a length is not positive");
        }
    }

    fn mesh(&mut self, shape: Node<'_>) -> Result<Geometry, LoadError> {
        let uri = required_text(&mut self.context, shape, "uri")?;
        let scale = numbers::<3>(&mut self.context, shape, "scale")?.unwrap_or([1.0; 3]);
        let mesh = self.finder.mesh(&uri, scale);
        if let Some(reason) = self.finder.flaw(&mesh) {
            self.context.warn(shape, reason);
        }
        Ok(mesh)
    }

    /// The diffuse colour of a visual. One that cannot be understood costs the colour, not the robot.
    fn color(&mut self, shape: Node<'_>) -> Result<Option<[f64; 4]>, LoadError> {
        let Some(material) = child(shape, "material").filter(|_| tag(shape) == "visual") else {
            return Ok(None);
        };
        check(&mut self.context, material, &schema::MATERIAL)?;
        let Some(diffuse) = child(material, "diffuse") else {
            return Ok(None);
        };
        check_value(&mut self.context, diffuse, &[])?;
        let text = text_of(diffuse);
        let opaque = |[r, g, b]: [f64; 3]| [r, g, b, 1.0];
        let color = parse::<4>(&text).or_else(|_| parse::<3>(&text).map(opaque));
        let color = color
            .ok()
            .filter(|color| color.iter().all(|x| x.is_finite()));
        if color.is_none() {
            let reason = format!("no colour: expected 3 or 4 finite numbers, found \"{text}\"");
            self.context.warn(diffuse, reason);
        }
        Ok(color)
    }
}

/// An inertia in the frame C at the centre of mass.
fn central(mass: f64, [xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Inertia<f64> {
    let J_C = Symmetric3::new(xx, xy, xz, yy, yz, zz);
    Inertia::from_com(mass, &nalgebra::Vector3::zeros(), &J_C)
}
