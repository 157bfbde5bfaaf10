//! Links: inertia, shapes, colours.
//!
//! | `<inertial>` | read as |
//! |---|---|
//! | is missing | mass 1 kg, moments 1 kg·m², as the SDF says, with a warning |
//! | has no `<mass>` or no `<inertia>` | 1 kg; moments of 1 kg·m²; with a warning |
//! | `auto="true"` | the inertia of the collisions as solids, of water if no `<density>` is given |

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::reader::Reader;
use super::scene::{FrameKind, Inertial, LinkEntry, MassEntry, Pose, Shape};
use super::schema;
use super::values::{Elements, check_value, text_of, truth};
use crate::error::LoadError;
use crate::io::context::{Node, child, children, tag};
use crate::io::schema::{Known, check, reason};
use crate::io::sensors::Carrier;
use crate::io::shapes;
use crate::io::values::{INERTIA_ENTRIES, Values, parse};
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
        let name = self.name(node)?;
        let pose = self.pose(node)?;
        let inertial = self.inertial(node)?;
        let has_gravity = self.has_gravity(node)?;
        let visuals = self.shapes(node, "visual", &schema::VISUAL)?;
        let collisions = self.shapes(node, "collision", &schema::COLLISION)?;
        let kind = FrameKind::Link(self.shared.scene.links.len());
        let frame = self.add_frame(node, scope, &name, kind, pose)?;
        self.sensors(node, scope, Carrier::Link, frame)?;
        self.shared.scene.links.push(LinkEntry {
            frame,
            inertial,
            has_gravity,
            visuals,
            collisions,
        });
        Ok(())
    }

    /// Whether gravity acts on a link, as it does where nothing is said.
    fn has_gravity(&self, link: Node<'_>) -> Result<bool, LoadError> {
        let node = child(link, "gravity");
        let said = node.and_then(|node| Some((node, node.text()?.trim())));
        match said {
            Some((node, text)) if !text.is_empty() => truth(&self.context, node, "gravity", text),
            _ => Ok(true),
        }
    }

    fn inertial(&mut self, link: Node<'_>) -> Result<Inertial, LoadError> {
        let Some(node) = child(link, "inertial") else {
            let reason = "no <inertial>: taken as 1 kg and 1 kg·m², as the SDF says";
            self.context.warn(link, reason);
            let (pose, inertia) = (Pose::identity(), central(1.0, UNIT_MOMENTS));
            let mass = MassEntry::Given { pose, inertia };
            return Ok(Inertial {
                mass,
                place: self.context.keep(link),
            });
        };
        let auto = node.attribute("auto").unwrap_or_default();
        let mass = if truth(&self.context, node, "auto", auto)? {
            check(&mut self.context, node, &schema::AUTO_INERTIAL)?;
            let density = Elements::number(&mut self.context, node, "density")?;
            MassEntry::Solid {
                density: density.unwrap_or(DENSITY_OF_WATER),
            }
        } else {
            self.given_inertial(node)?
        };
        Ok(Inertial {
            mass,
            place: self.context.keep(node),
        })
    }

    fn given_inertial(&mut self, node: Node<'_>) -> Result<MassEntry, LoadError> {
        check(&mut self.context, node, &schema::INERTIAL)?;
        let mass = Elements::number(&mut self.context, node, "mass")?;
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
        for (moment, name) in moments.iter_mut().zip(INERTIA_ENTRIES) {
            match Elements::number(&mut self.context, node, name)? {
                Some(x) => *moment = x,
                // Files leave out products that are zero.
                None if *moment == 0.0 => {}
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
        let mut found = Vec::new();
        for node in children(link, element) {
            check(&mut self.context, node, known)?;
            let pose = self.pose(node)?;
            let Some(shape) = shapes::find(&mut self.context, node, &schema::SHAPES)? else {
                continue;
            };
            found.push(Shape {
                name: node.attribute("name").map(Into::into),
                pose,
                geometry: self.geometry(&shape)?,
                color: self.color(node)?,
                density: Elements::number(&mut self.context, node, "density")?,
                bitmask: self.bitmask(node)?,
            });
        }
        Ok(found)
    }

    /// The bits of `<surface><contact><collide_bitmask>`, of which two shapes that collide have one in common.
    fn bitmask(&mut self, shape: Node<'_>) -> Result<Option<u16>, LoadError> {
        let surface = child(shape, "surface").filter(|_| tag(shape) == "collision");
        let contact = surface.and_then(|node| child(node, "contact"));
        let mask = contact.and_then(|node| child(node, "collide_bitmask"));
        let (Some(surface), Some(contact), Some(mask)) = (surface, contact, mask) else {
            if let Some(surface) = surface {
                self.context.ignore(surface, reason("surface"));
            }
            return Ok(None);
        };
        check(&mut self.context, surface, &schema::SURFACE)?;
        check(&mut self.context, contact, &schema::SURFACE_CONTACT)?;
        check_value(&mut self.context, mask, "")?;
        let text = text_of(mask);
        let own = text.trim();
        let hexadecimal = own.strip_prefix("0x").or_else(|| own.strip_prefix("0X"));
        let bits = match hexadecimal {
            Some(digits) => u16::from_str_radix(digits, 16),
            None => own.parse(),
        };
        bits.map(Some).map_err(|_| {
            let expected = "expected 16 bits as a whole number, decimal or hexadecimal (0x…)";
            (self.context).malformed_value(mask, "collide_bitmask", own, expected)
        })
    }

    fn geometry(&mut self, shape: &shapes::Shape<'_>) -> Result<Geometry, LoadError> {
        let (context, meshes) = (&mut self.context, &mut self.finder);
        let geometry = shapes::read::<Elements>(context, shape, &schema::SHAPES, meshes)?;
        let place = shape.node.into();
        shapes::check_shape(context, &geometry, meshes, [place, place]);
        Ok(geometry)
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
        check_value(&mut self.context, diffuse, "")?;
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
