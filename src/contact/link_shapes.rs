//! The collision shapes of links, for distances between them.

use std::sync::Arc;

use nalgebra::Vector3;

use super::material::Material;
use super::relations::Relations;
use super::shapes::{MeshHulls, NoMeshes, ShapeWithoutPoints};
use crate::collision::{Groups, Hull, Shape, Surface, TriangleSides};
use crate::error::UnknownName;
use crate::model::{BodyId, Collision, FrameId, Geometry, Model, Structure, short_reference};
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// A collision shape of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkShape {
    /// Frame of the link.
    pub link: FrameId,
    /// Place of the link in [`Model::links`].
    pub(super) number: usize,
    /// Body that carries it; `None` for a shape that is fixed to the world.
    pub body: Option<BodyId>,
    /// Pose `X_BS` of the shape in the body, or in the world.
    pub placement: Transform<f64>,
    /// The shape; for a mesh its convex hull.
    pub shape: Shape,
    /// Groups of shapes that may touch it.
    pub groups: Groups,
    /// Distance below which it counts as touching in lists of [pairs](LinkShapes::pairs), m; that of a pair is the sum. Forces begin at the [margin of its
    /// material](Material::margin).
    pub margin: f64,
    /// Friction, restitution and compliance of its surface against other bodies; `None` for those of the contact model.
    pub material: Option<Material>,
    /// Number of its kind of surface, by which pairs have materials; 0 without.
    pub(super) kind: u32,
    /// For a triangle of a surface: its allowed contact normals.
    pub(super) sides: Option<Box<TriangleSides>>,
}

/// The collision shapes of the links of a robot.
///
/// [`LinkShapes::new`] reads their mesh files; [`LinkShapes::with_meshes`] takes vertices from the caller.
#[derive(Clone, Debug)]
pub struct LinkShapes {
    shapes: Vec<LinkShape>,
    missing: Vec<ShapeWithoutPoints>,
    /// Pairs of links that never touch, the smaller first.
    pub(super) excluded: Vec<[FrameId; 2]>,
    /// Materials between two kinds of surfaces, in order, the smaller kind first.
    pair_materials: Vec<([u32; 2], Material)>,
    relations: Relations,
    structure: Structure,
    /// Width of the soft minimum over near features, m; 0 for exact distances.
    pub(super) smoothing: f64,
}

impl LinkShapes {
    /// The collision shapes of a robot, with mesh vertices from the caller. Allocates.
    ///
    /// Invalid shapes (a mesh without vertices, a scale of zero, a size that is negative or not finite) are listed in [`missing`](Self::missing).
    pub fn with_meshes(model: &Model, meshes: &mut dyn MeshHulls) -> Self {
        let mut own = Self {
            shapes: Vec::new(),
            missing: Vec::new(),
            excluded: Vec::new(),
            pair_materials: Vec::new(),
            relations: Relations::new(model),
            structure: model.structure(),
            smoothing: 0.0,
        };
        let is_masked = model
            .links()
            .iter()
            .any(|link| !link.collide_bitmasks.is_empty());
        let unmasked = match is_masked {
            true => groups_of(u16::MAX),
            false => Groups::default(),
        };
        for (number, link) in model.links().iter().enumerate() {
            let frame = &model.frames()[link.frame.0];
            let masks = &link.collide_bitmasks;
            for (k, collision) in link.collisions.iter().enumerate() {
                match shape(collision, meshes) {
                    Ok(shape) => own.shapes.push(LinkShape {
                        link: link.frame,
                        number,
                        body: frame.body,
                        placement: frame.placement * collision.placement,
                        shape,
                        groups: masks.get(k).map_or(unmasked, |&mask| groups_of(mask)),
                        margin: 0.0,
                        material: None,
                        kind: 0,
                        sides: None,
                    }),
                    Err(reason) => own.missing.push(ShapeWithoutPoints {
                        link: frame.name.clone(),
                        reason,
                    }),
                }
            }
        }
        own
    }

    /// The collision shapes of a robot except its meshes; reads no files. Allocates.
    pub fn without_meshes(model: &Model) -> Self {
        Self::with_meshes(model, &mut NoMeshes)
    }

    /// Adds the triangles of a surface to a link that is fixed to the world, each as a shape in all groups. Allocates; O(n log n) in the triangles.
    /// A step costs O(log n) for each shape that moves, and time for each triangle that is near to it.
    ///
    /// # Errors
    /// If the model has no link of that name.
    ///
    /// # Panics
    /// If the link moves, or the shapes are those of another robot.
    pub(crate) fn add_surface(
        &mut self,
        model: &Model,
        link: &str,
        surface: &Surface,
    ) -> Result<(), UnknownName> {
        let own = self.fixed(model, link, Transform::identity())?;
        self.shapes
            .extend(surface.each().map(|(vertices, sides)| LinkShape {
                shape: Shape::Triangle { vertices },
                sides: Some(Box::new(sides)),
                ..own.clone()
            }));
        Ok(())
    }

    /// Adds a half-space to a link that is fixed to the world, in all groups: z ≤ 0 of a frame at a pose in the link.
    ///
    /// # Errors
    /// If the model has no link of that name.
    ///
    /// # Panics
    /// As [`add_surface`](Self::add_surface).
    pub(crate) fn add_half_space(
        &mut self,
        model: &Model,
        link: &str,
        pose: Transform<f64>,
    ) -> Result<(), UnknownName> {
        let own = self.fixed(model, link, pose)?;
        self.shapes.push(own);
        Ok(())
    }

    /// A half-space at a pose in a link that is fixed to the world.
    fn fixed(
        &self,
        model: &Model,
        link: &str,
        pose: Transform<f64>,
    ) -> Result<LinkShape, UnknownName> {
        self.check(model);
        let links = || {
            let links = model.links().iter().map(|own| own.frame);
            links.map(|frame| (frame, model.frames()[frame.0].name.as_str()))
        };
        let found = links().enumerate().find(|(_, (_, name))| *name == link);
        let (number, (frame, _)) = found.ok_or_else(|| UnknownName {
            model: model.name().to_owned(),
            element: "link".into(),
            name: link.into(),
            known: links().map(|(_, name)| name.to_owned()).collect(),
        })?;
        let place = &model.frames()[frame.0];
        assert!(
            place.body.is_none(),
            "a surface is fixed to the world, but its link \"{link}\" moves"
        );
        let everything = Groups {
            own: u32::MAX,
            mask: u32::MAX,
        };
        Ok(LinkShape {
            link: frame,
            number,
            body: None,
            placement: place.placement * pose,
            shape: Shape::HalfSpace,
            groups: everything,
            margin: 0.0,
            material: None,
            kind: 0,
            sides: None,
        })
    }

    /// Lets links touch that a joint connects: all, or those of which one is fixed to the world.
    pub(crate) fn let_neighbours_touch(&mut self, model: &Model, all: bool) {
        self.check(model);
        let is_fixed = |link: usize| {
            let frame = model.links()[link].frame;
            model.frames()[frame.0].body.is_none()
        };
        self.relations
            .separate(|[a, b]| all || is_fixed(a) || is_fixed(b));
    }

    /// The shapes, link by link in the order of the model, then those of [surfaces](super::CollisionOptions::with_surface).
    pub fn shapes(&self) -> &[LinkShape] {
        &self.shapes
    }

    /// The shapes, mutable: sizes, groups and margins.
    pub fn shapes_mut(&mut self) -> &mut [LinkShape] {
        &mut self.shapes
    }

    /// The shapes that are missing, with the reason.
    pub fn missing(&self) -> &[ShapeWithoutPoints] {
        &self.missing
    }

    /// Gives a kind of surface, above 0, to a shape.
    pub(crate) fn set_kind(&mut self, shape: usize, kind: u32) {
        self.shapes[shape].kind = kind;
    }

    /// Sets the material between two kinds of surfaces, in place of the mean of both.
    pub(crate) fn set_pair_material(&mut self, kinds: [u32; 2], material: Material) {
        let kinds = sorted(kinds);
        match self.find_kinds(kinds) {
            Ok(k) => self.pair_materials[k].1 = material,
            Err(k) => self.pair_materials.insert(k, (kinds, material)),
        }
    }

    /// The materials between kinds of surfaces, in order.
    pub(super) fn pair_materials(
        &self,
    ) -> impl Iterator<Item = &([u32; 2], Material)> + Clone + '_ {
        self.pair_materials.iter()
    }

    /// The place of the material of two shapes among those of pairs.
    pub(super) fn pair_place(&self, shapes: [usize; 2]) -> Option<usize> {
        let kinds = shapes.map_each(|shape| self.shapes[shape].kind);
        self.find_kinds(sorted(kinds)).ok()
    }

    fn find_kinds(&self, kinds: [u32; 2]) -> Result<usize, usize> {
        (self.pair_materials).binary_search_by_key(&kinds, |(own, _)| *own)
    }

    /// Relations of the links by joints.
    pub(super) fn relations(&self) -> &Relations {
        &self.relations
    }

    /// Finds the frame of a link with shapes.
    ///
    /// # Errors
    /// If the model has no such frame, or it has no collision shape; the message lists the links with shapes.
    ///
    /// # Panics
    /// If the shapes are those of another robot.
    pub(crate) fn find_link(&self, model: &Model, name: &str) -> Result<FrameId, UnknownName> {
        self.check(model);
        let links = || self.shapes.iter().map(|shape| shape.link);
        let found = model
            .frame(name)
            .filter(|frame| links().any(|link| link == *frame));
        found.ok_or_else(|| {
            let mut known: Vec<String> = links()
                .map(|link| model.frames()[link.0].name.clone())
                .collect();
            known.dedup();
            UnknownName {
                model: model.name().to_owned(),
                element: "link with a collision shape".into(),
                name: name.into(),
                known,
            }
        })
    }

    /// # Panics
    /// If the shapes are those of another robot.
    pub(crate) fn check(&self, model: &Model) {
        assert!(
            self.structure == model.structure(),
            "the shapes are those of another robot than \"{}\"",
            model.name()
        );
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The groups by which shapes touch where their bitmasks have a bit in common.
fn groups_of(bitmask: u16) -> Groups {
    let bits = u32::from(bitmask);
    Groups {
        own: bits,
        mask: bits,
    }
}

/// The shape of a collision geometry, or why there is none, as a sentence about it.
fn shape(collision: &Collision, meshes: &mut dyn MeshHulls) -> Result<Shape, String> {
    let sizes: &[f64] = match &collision.geometry {
        Geometry::Sphere { radius } => &[*radius],
        Geometry::Capsule { radius, length } | Geometry::Cylinder { radius, length } => {
            &[*radius, *length]
        }
        Geometry::Box { size } | Geometry::Ellipsoid { size } => size,
        Geometry::Mesh { .. } => &[],
    };
    if let Some(size) = sizes
        .iter()
        .find(|size| !(**size >= 0.0 && size.is_finite()))
    {
        return Err(format!(
            "a collision shape has the size {size}, which is negative or not finite"
        ));
    }
    Ok(match &collision.geometry {
        Geometry::Sphere { radius } => Shape::Sphere { radius: *radius },
        Geometry::Capsule { radius, length } => Shape::Capsule {
            radius: *radius,
            half_length: length / 2.0,
        },
        Geometry::Cylinder { radius, length } => Shape::Cylinder {
            radius: *radius,
            half_length: length / 2.0,
        },
        Geometry::Box { size } => Shape::Box {
            half_extents: size.map_each(|x| x / 2.0),
        },
        Geometry::Ellipsoid { size } => Shape::Ellipsoid {
            semi_axes: size.map_each(|x| x / 2.0),
        },
        mesh @ Geometry::Mesh { uri, scale, .. } => {
            let found = hull(mesh, scale, meshes);
            found.map_err(|reason| format!("the mesh {} {reason}", short_reference(uri)))?
        }
    })
}

fn hull(mesh: &Geometry, scale: &[f64; 3], meshes: &mut dyn MeshHulls) -> Result<Shape, String> {
    let vertices = meshes
        .vertices(mesh)?
        .iter()
        .map(|v| Vector3::from(*v).map(f64::from));
    let hull = Hull::new(vertices.collect()).map_err(|error| format!("has no hull: {error}"))?;
    if scale.iter().any(|s| *s == 0.0 || !s.is_finite()) {
        return Err(format!(
            "has the scale {scale:?}; each factor must be finite and nonzero"
        ));
    }
    Ok(Shape::Hull {
        hull: Arc::new(hull),
        scale: *scale,
    })
}
