//! Which shapes of a robot or a world can touch each other.

use nalgebra::Vector3;

use super::{BodyShape, ShapePairs};
use crate::collision::{Hull, Shape};
use crate::contact::Contacts;
use crate::contact::laws::ContactLaw;
use crate::contact::shapes::{MeshHulls, ShapeWithoutPoints};
use crate::error::UnknownName;
use crate::model::{BodyId, Collision, Geometry, Model};

/// Which bodies collide with each other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CollisionOptions {
    /// Whether links of one robot collide, too; those that a joint connects never do.
    pub self_collision: bool,
    /// Links that do not collide, by name.
    pub excluded: Vec<[String; 2]>,
}

impl CollisionOptions {
    /// Lets links of one robot collide, too.
    #[must_use]
    pub fn with_self_collision(mut self) -> Self {
        self.self_collision = true;
        self
    }

    /// Excludes a pair of links.
    #[must_use]
    pub fn without(mut self, first: &str, second: &str) -> Self {
        self.excluded.push([first.to_owned(), second.to_owned()]);
        self
    }
}

impl Contacts<f64> {
    /// As [`with_collisions`](Self::with_collisions), with the vertices of meshes from elsewhere than files. Allocates.
    ///
    /// # Errors
    /// If the model has no link of an excluded name.
    ///
    /// # Panics
    /// As [`with_collisions`](Self::with_collisions).
    pub fn with_collisions_and_meshes(
        mut self,
        model: &Model,
        law: ContactLaw,
        options: &CollisionOptions,
        meshes: &mut dyn MeshHulls,
    ) -> Result<Self, UnknownName> {
        self.check(model);
        assert!(
            !matches!(law, ContactLaw::Soft(_)),
            "contact between bodies is rigid or relaxed rigid: a soft law has a state of its own for each point"
        );
        let excluded = options.excluded.iter();
        let named = |[a, b]: &[String; 2]| Ok([model.find_frame(a)?, model.find_frame(b)?]);
        let excluded = excluded
            .map(named)
            .collect::<Result<Vec<_>, UnknownName>>()?;
        let mut without = Vec::new();
        let shapes = shapes_of(model, meshes, &mut without);
        let may_touch = |a: &BodyShape<f64>, b: &BodyShape<f64>| {
            let links = [a.link, b.link];
            let is_excluded = |own: &[_; 2]| *own == links || *own == [links[1], links[0]];
            let own = options.self_collision || !are_of_one_robot(model, a, b);
            own && !are_joined(model, a.body, b.body) && !excluded.iter().any(is_excluded)
        };
        let pairs = pairs_of(&shapes, may_touch);
        self.set_shape_pairs(ShapePairs { shapes, pairs }, law);
        self.add_shapes_without_points(without);
        Ok(self)
    }
}

/// The pairs that may touch; the first shape of each is on a body that moves.
fn pairs_of(
    shapes: &[BodyShape<f64>],
    may_touch: impl Fn(&BodyShape<f64>, &BodyShape<f64>) -> bool,
) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for (i, a) in shapes.iter().enumerate() {
        for (j, b) in shapes.iter().enumerate().skip(i + 1) {
            if may_touch(a, b) {
                let swap = a.body.is_none();
                pairs.push(if swap { [j, i] } else { [i, j] });
            }
        }
    }
    pairs
}

/// Whether bodies are one, or a joint of less than six degrees of freedom connects them.
fn are_joined(model: &Model, a: Option<BodyId>, b: Option<BodyId>) -> bool {
    let on = |child: Option<BodyId>, parent: Option<BodyId>| {
        child.is_some_and(|child| {
            let body = model.body(child);
            let is_free = body.parent.is_none() && body.joint.nv() == 6;
            body.parent == parent && !is_free
        })
    };
    a == b || on(a, b) || on(b, a)
}

/// Whether shapes belong to one robot: by the joints between them, or, for what is fixed to the world, by the prefix of the name.
fn are_of_one_robot(model: &Model, a: &BodyShape<f64>, b: &BodyShape<f64>) -> bool {
    let prefix = |shape: &BodyShape<f64>| {
        let name = &model.frame_of(shape.link).name;
        name.split_once('/').map(|(prefix, _)| prefix)
    };
    let by_name = || prefix(a).is_some() && prefix(a) == prefix(b);
    match (a.body, b.body) {
        (Some(a), Some(b)) => root(model, a) == root(model, b),
        _ => by_name(),
    }
}

/// The body on the world that carries a body.
fn root(model: &Model, body: BodyId) -> BodyId {
    let mut body = body;
    while let Some(parent) = model.body(body).parent {
        body = parent;
    }
    body
}

/// All collision shapes; those of which there is no convex shape go to `without`.
fn shapes_of(
    model: &Model,
    meshes: &mut dyn MeshHulls,
    without: &mut Vec<ShapeWithoutPoints>,
) -> Vec<BodyShape<f64>> {
    let mut shapes = Vec::new();
    for link in model.links() {
        let frame = model.frame_of(link.frame);
        for own in &link.collisions {
            match shape_of(own, meshes) {
                Ok(shape) => shapes.push(BodyShape {
                    link: link.frame,
                    body: frame.body,
                    X_BS: frame.placement * own.placement,
                    shape,
                }),
                Err(reason) => without.push(ShapeWithoutPoints {
                    link: frame.name.clone(),
                    reason,
                }),
            }
        }
    }
    shapes
}

/// The convex shape of a description, or why there is none.
fn shape_of(own: &Collision, meshes: &mut dyn MeshHulls) -> Result<Shape, String> {
    Ok(match &own.geometry {
        Geometry::Sphere { radius } => Shape::Sphere { radius: *radius },
        Geometry::Box { size } => Shape::Box {
            half_extents: size.map(|x| 0.5 * x),
        },
        Geometry::Capsule { radius, length } => Shape::Capsule {
            radius: *radius,
            half_length: 0.5 * length,
        },
        Geometry::Cylinder { radius, length } => Shape::Cylinder {
            radius: *radius,
            half_length: 0.5 * length,
        },
        mesh @ Geometry::Mesh { uri, scale, .. } => {
            let named = |reason: String| format!("the mesh {uri} {reason}");
            let vertices = meshes.vertices(mesh).map_err(named)?;
            let point = |v: &[f32; 3]| Vector3::from(v.map(f64::from));
            let hull = Hull::new(vertices.iter().map(point).collect());
            Shape::Hull {
                hull: hull.map_err(|error| named(error.to_string()))?.into(),
                scale: *scale,
            }
        }
    })
}
