//! Worlds: robots and objects in one model, with unique names.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod member;
mod object;

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::graph::WORLD;
use super::{DEFAULT_GRAVITY, LinkSpec, Model, ModelBuilder};
use crate::error::{EditError, UnknownName};
use crate::spatial::Transform;

pub(crate) use member::BASE_JOINT;
use member::{Member, Stand};
pub use object::Object;

/// Collects robots and objects, then [builds](Self::build) one [`Model`].
///
/// The result is an ordinary model: a tree with the world as its fixed root, for all simulators, derivatives, batches and recordings. Its mass matrix
/// has a block for each member that is not mounted on another one.
///
/// | member | names in the model | joint on the world |
/// |---|---|---|
/// | robot with a fixed base | links, joints and frames with the prefix | fixed, `{prefix}attachment` |
/// | robot with a floating base | likewise | floating, `{prefix}floating_base` |
/// | object | link `{name}` | floating or fixed, `{name}` |
///
/// Members are ordered by prefix and name: the model and all results do not depend on the order of addition.
///
/// A floating joint on the world is [passive](super::JointSpec::passive): it has no input. Its configuration is relative to the pose at which the
/// member was added, so in the [neutral](Model::neutral) configuration all members are at their initial poses.
/// [`State::set_free_pose`](crate::State::set_free_pose) sets a pose in the world. [`State::carried`](crate::State::carried) transfers a state to a
/// world with other members.
///
/// # Examples
/// ```
/// use dualbody::model::{Mass, Object, World, samples};
/// use dualbody::{Simulator, spatial::Transform};
///
/// let at = |x: f64, z: f64| Transform::from_translation([x, 0.0, z].into());
/// let mut world = World::new("cell");
/// world.add(&samples::arm(), "left/", &at(-0.4, 0.7))?.add(&samples::arm(), "right/", &at(0.4, 0.7))?;
/// world.add_box("table", [1.2, 0.8, 0.1], &Object::fixed().at(at(0.0, 0.65)))?;
/// world.add_sphere("ball", 0.05, &Object::free(Mass::Kilograms(0.2)).at(at(0.0, 1.0)))?;
/// let model = world.build()?;
/// assert_eq!((model.nv(), model.total_mass()), (7 + 7 + 6, 2.0 * samples::arm().total_mass() + 0.2));
/// assert_eq!(Simulator::new(model).nu(), 14);
/// # Ok::<(), dualbody::EditError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    name: String,
    gravity: Vector3<f64>,
    members: BTreeMap<String, Member>,
}

impl Default for World {
    /// An empty world called `world`.
    fn default() -> Self {
        Self::new("world")
    }
}

impl World {
    /// Makes an empty world in [`DEFAULT_GRAVITY`].
    ///
    /// * `name` – name of the model
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            gravity: DEFAULT_GRAVITY.into(),
            members: BTreeMap::new(),
        }
    }

    /// Sets gravity in the world, m/s², which acts on all members; their own gravity has no effect.
    #[must_use]
    pub fn with_gravity(mut self, gravity: [f64; 3]) -> Self {
        self.gravity = gravity.into();
        self
    }

    /// Adds a robot, or all members of another world. Its base is fixed or floating as in `model`.
    ///
    /// * `prefix` – prefix of the names of all links, joints and frames; by convention it ends in a separator: `left/`
    /// * `X_WL` – pose of the root link in the world; the initial one if the base floats
    ///
    /// # Errors
    /// If there is a member of this prefix, or the pose is not finite or not a rotation. [`build`](Self::build) reports other name clashes.
    pub fn add(
        &mut self,
        model: &Model,
        prefix: &str,
        X_WL: &Transform<f64>,
    ) -> Result<&mut Self, EditError> {
        self.insert(prefix, Member::robot(model, prefix, Stand::InWorld, X_WL))
    }

    /// Adds a robot and fixes its base to a frame of another member, even if the base floats in `model`.
    ///
    /// * `frame` – link or frame with its prefix, for example `table` or `left/tool`; it may be added later
    /// * `X_FL` – pose of the root link in that frame
    ///
    /// # Errors
    /// As for [`add`](Self::add); [`build`](Self::build) reports an unknown frame, and members that are mounted on each other in a cycle.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::{World, samples};
    /// use dualbody::spatial::Transform;
    ///
    /// let mut world = World::default();
    /// world.add_on(&samples::pendulum(), "bob/", "arm/tool", &Transform::identity())?;
    /// assert_eq!(world.build().unwrap_err().to_string(), "model \"world\" has no frame \"arm/tool\"; it has: world, bob/world, bob/rod");
    /// world.add(&samples::arm(), "arm/", &Transform::identity())?;
    /// assert_eq!(world.build()?.joint_names()[7], "bob/pivot");
    /// # Ok::<(), dualbody::EditError>(())
    /// ```
    pub fn add_on(
        &mut self,
        model: &Model,
        prefix: &str,
        frame: &str,
        X_FL: &Transform<f64>,
    ) -> Result<&mut Self, EditError> {
        self.insert(
            prefix,
            Member::robot(model, prefix, Stand::On(frame.into()), X_FL),
        )
    }

    /// Removes a robot by its prefix, or an object by its name.
    ///
    /// # Errors
    /// If there is no such member.
    pub fn remove(&mut self, member: &str) -> Result<&mut Self, UnknownName> {
        match self.members.remove(member) {
            Some(_) => Ok(self),
            None => Err(UnknownName {
                model: self.name.clone(),
                element: "member".into(),
                name: member.into(),
                known: self.members().map(Into::into).collect(),
            }),
        }
    }

    /// Prefixes of the robots and names of the objects, in their order in the model.
    pub fn members(&self) -> impl Iterator<Item = &str> {
        self.members.keys().map(String::as_str)
    }

    fn insert(&mut self, name: &str, member: Member) -> Result<&mut Self, EditError> {
        member.check(name)?;
        if self.members.contains_key(name) {
            let (element, name) = ("member".into(), name.into());
            return Err(EditError::DuplicateName { element, name });
        }
        self.members.insert(name.into(), member);
        Ok(self)
    }

    /// Builds the model, in time linear in the number of links.
    ///
    /// # Errors
    /// If a name is duplicate, a mounting frame is unknown, members are mounted on each other in a cycle, or gravity is not finite.
    pub fn build(&self) -> Result<Model, EditError> {
        Ok(self.to_builder()?.build()?)
    }

    /// Returns the description of the model, for changes before it is built.
    ///
    /// # Errors
    /// If a mounting frame is unknown.
    pub fn to_builder(&self) -> Result<ModelBuilder, EditError> {
        let mut parts = ModelBuilder::new(&self.name)
            .with_source(format!("world \"{}\"", self.name))
            .with_gravity(self.gravity.into());
        parts.add_link(LinkSpec::new(WORLD));
        for member in self.members.values() {
            parts.append(&member.parts);
        }
        for member in self.members.values() {
            let mount = member.mount_on(&parts)?;
            parts.add_joint(mount);
        }
        Ok(parts)
    }
}
