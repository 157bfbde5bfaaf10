//! Objects of a world: single bodies of one shape.

use super::member::{Member, Stand};
use super::{WORLD, World};
use crate::error::EditError;
use crate::joint::JointKind;
use crate::model::hardware::solid_of;
use crate::model::{Collision, Geometry, LinkSpec, Mass, MeshSolids, Visual};
use crate::spatial::{Inertia, Transform};

/// Properties of an object that do not depend on its shape: free or fixed, mass, pose, colour.
///
/// # Examples
/// ```
/// use dualbody::model::{Mass, Object};
/// use dualbody::spatial::Transform;
///
/// let shelf = Object::fixed().at(Transform::from_translation([0.0, 0.0, 1.2].into()));
/// let oak = Object::free(Mass::Density(700.0)).with_color([0.6, 0.4, 0.2, 1.0]);
/// assert_ne!(shelf, oak);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    kind: JointKind,
    mass: Option<Mass>,
    stand: Stand,
    placement: Transform<f64>,
    color: Option<[f64; 4]>,
    has_gravity: bool,
}

impl Object {
    /// A free homogeneous object at the origin of the world.
    pub fn free(mass: Mass) -> Self {
        Self {
            kind: JointKind::Floating,
            mass: Some(mass),
            ..Self::fixed()
        }
    }

    /// An object fixed to the world, at its origin.
    pub fn fixed() -> Self {
        Self {
            kind: JointKind::Fixed,
            mass: None,
            stand: Stand::InWorld,
            placement: Transform::identity(),
            color: None,
            has_gravity: true,
        }
    }

    /// An object fixed to a frame of another member, for example `left/tool`.
    ///
    /// * `mass` – its mass, which adds to the inertia of that member; zero kilograms for an object with shapes only
    pub fn fixed_to(frame: impl Into<String>, mass: Mass) -> Self {
        Self {
            mass: Some(mass),
            stand: Stand::On(frame.into()),
            ..Self::fixed()
        }
    }

    /// Sets the pose in the world, or in the frame to which the object is fixed; for a free object it is the initial pose.
    #[must_use]
    pub fn at(mut self, pose: Transform<f64>) -> Self {
        self.placement = pose;
        self
    }

    /// Sets the colour in the HTML viewer and in pictures: red, green, blue, opacity in 0..1.
    #[must_use]
    pub fn with_color(mut self, color: [f64; 4]) -> Self {
        self.color = Some(color);
        self
    }

    /// Switches off gravity for the object.
    #[must_use]
    pub fn without_gravity(mut self) -> Self {
        self.has_gravity = false;
        self
    }
}

impl World {
    /// Adds a box with full edge lengths `size`, m, centred at the origin of its link.
    ///
    /// # Errors
    /// If a member of this name exists, if a size, the mass, the pose or the colour is not finite or has the wrong sign, or if the pose has no
    /// rotation matrix. A free object needs a positive mass.
    pub fn add_box(
        &mut self,
        name: &str,
        size: [f64; 3],
        object: &Object,
    ) -> Result<&mut Self, EditError> {
        self.add_shape(name, Geometry::Box { size }, object, &mut NoFiles)
    }

    /// Adds a ball, centred at the origin of its link; radius in m.
    ///
    /// # Errors
    /// As for [`add_box`](Self::add_box).
    pub fn add_sphere(
        &mut self,
        name: &str,
        radius: f64,
        object: &Object,
    ) -> Result<&mut Self, EditError> {
        self.add_shape(name, Geometry::Sphere { radius }, object, &mut NoFiles)
    }

    /// Adds a cylinder about z, centred at the origin of its link; radius and full length in m.
    ///
    /// # Errors
    /// As for [`add_box`](Self::add_box).
    pub fn add_cylinder(
        &mut self,
        name: &str,
        radius: f64,
        length: f64,
        object: &Object,
    ) -> Result<&mut Self, EditError> {
        let shape = Geometry::Cylinder { radius, length };
        self.add_shape(name, shape, object, &mut NoFiles)
    }

    /// Adds a capsule about z, centred at the origin of its link; radius, and length of the cylinder without the hemispheres, in m.
    ///
    /// # Errors
    /// As for [`add_box`](Self::add_box).
    pub fn add_capsule(
        &mut self,
        name: &str,
        radius: f64,
        length: f64,
        object: &Object,
    ) -> Result<&mut Self, EditError> {
        let shape = Geometry::Capsule { radius, length };
        self.add_shape(name, shape, object, &mut NoFiles)
    }

    /// Adds an object of any shape, with visual and collision shape, in the frame of its link.
    ///
    /// * `meshes` – source of mesh inertias; `World::add_mesh` reads them from files
    ///
    /// # Errors
    /// As for [`add_box`](Self::add_box); if the mesh of an object with mass is missing, unreadable or not closed.
    pub fn add_shape(
        &mut self,
        name: &str,
        shape: Geometry,
        object: &Object,
        meshes: &mut dyn MeshSolids,
    ) -> Result<&mut Self, EditError> {
        if name == WORLD {
            let (element, name) = ("link".into(), name.into());
            return Err(EditError::DuplicateName { element, name });
        }
        // A size that is none shows as such, not as a mass.
        Member::check_link(object.link(name, shape.clone(), Inertia::zero()))?;
        let inertia = object.inertia(name, &shape, meshes)?;
        let link = object.link(name, shape, inertia);
        Member::check_link(link.clone())?;
        let member = Member::link(link, object.kind, object.stand.clone(), &object.placement);
        self.insert(name, member)
    }
}

impl Object {
    fn inertia(
        &self,
        name: &str,
        shape: &Geometry,
        meshes: &mut dyn MeshSolids,
    ) -> Result<Inertia<f64>, EditError> {
        let Some(mass) = self.mass else {
            return Ok(Inertia::zero());
        };
        let inertia = match shape.inertia(mass) {
            Some(inertia) => inertia,
            None => {
                let solid = solid_of(shape, meshes).map_err(|reason| EditError::Shape {
                    object: name.into(),
                    reason,
                })?;
                solid.scaled(match mass {
                    Mass::Kilograms(mass) => mass / solid.mass,
                    Mass::Density(density) => density,
                })
            }
        };
        let is_mass = inertia.mass > 0.0 && inertia.mass.is_finite();
        if self.kind == JointKind::Floating && !is_mass {
            let (quantity, value) = (format!("mass of \"{name}\""), inertia.mass);
            return Err(EditError::NotPositive { quantity, value });
        }
        Ok(inertia)
    }

    fn link(&self, name: &str, shape: Geometry, inertia: Inertia<f64>) -> LinkSpec {
        let placement = Transform::identity();
        let mut link = LinkSpec::new(name)
            .with_inertia(inertia)
            .with_visual(Visual {
                name: None,
                placement,
                geometry: shape.clone(),
                color: self.color,
            })
            .with_collision(Collision {
                name: None,
                placement,
                geometry: shape,
            });
        link.has_gravity = self.has_gravity;
        link
    }
}

/// No solids, for shapes that are not meshes.
struct NoFiles;

impl MeshSolids for NoFiles {
    fn solid(&mut self, _: &Geometry) -> Result<Inertia<f64>, String> {
        Err("is not read: add it with World::add_mesh".into())
    }
}
