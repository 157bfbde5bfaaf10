//! Robots from description files.
//!
//! [`Model::from_urdf_file`], [`Model::from_sdf_file`] and their `_str` twins load a robot in one call; [`ModelOptions`] says how it stands in the
//! world and returns, beside the model, an [`ImportReport`] of everything that the file holds and the model does not use.
//! Loading starts no program, reads no meshes and never panics on a bad file.
//!
//! | question | function | cost |
//! |---|---|---|
//! | load a robot from a URDF? | [`Model::from_urdf_file`], [`from_urdf_str`](Model::from_urdf_str) | linear in the text |
//! | from what [`urdf_rs`] has read, or a program made of its types? | [`Model::from_urdf`] | linear in links and joints |
//! | from an SDF, with what it includes? | [`Model::from_sdf_file`], [`from_sdf_str`](Model::from_sdf_str) | linear in the texts |
//! | how does it stand, what is it to leave out, where are its packages? | [`ModelOptions`] | |
//! | what does the file hold that the model does not use? | [`ImportReport`] | |
//! | one that somebody else wrote? | [`ModelOptions::with_root`] | |
//! | links that move and have no inertia? | [`MasslessLinks`] | |
//! | write it? | [`Model::to_urdf`], [`Model::to_mjcf`] | linear in the robot; the latter reads its meshes |
//! | meshes in contact with the ground? | [`Contacts::new`](crate::contact::Contacts::new), which is written here | linear in the files, each read once |
//!
//! # What a description can do
//!
//! A description, and all that belongs to it, may come from anyone: none of it makes the program panic, overflow the stack, wait, or
//! take time or memory out of proportion to its size. But it *names files*, and whoever loads, shows or simulates the robot reads them:
//!
//! | what | named in | read by | what of it can be seen |
//! |---|---|---|---|
//! | models of SDF, their `model.config` | `<include>` | loading | the robot, if it is SDF; of anything else, that it is not |
//! | meshes (STL, OBJ, COLLADA) | `<mesh>`, by any path | pages, recordings, contacts, `to_mjcf`; never loading | triangles and colours; of anything else, what is wrong and on which line |
//! | materials | `mtllib` in an OBJ | with the mesh | colours; only files below the folder of the mesh are opened |
//! | any file | each of these | – | whether it is there |
//!
//! References may be absolute, lead upwards, through symbolic links, or by `package://` and `model://` to the folders of
//! [`with_search_path`](ModelOptions::with_search_path) and of the environment. **Descriptions from others are therefore to be loaded with
//! [`with_root`](ModelOptions::with_root)**, which restricts all of it to the folders that are given, and says of what is elsewhere only that
//! it is not found. What the model then holds are the paths of allowed files with all links followed, so that pages and contacts open no others,
//! unless someone who may write to those folders changes them in between.
//!
//! Everywhere, files must be regular and of at most 64 MiB, together for all that is included; pipes and devices are refused without being
//! opened, and nothing is fetched from anywhere. Pages call meshes as the description calls them, not by where they were found. A
//! [recording](crate::view::Recording) saved as JSON holds the paths, from its own folder, of meshes that were added to it as
//! [fixtures](crate::view::Fixture), and one that is read may name any; look through
//! [`Recording::fixtures`](crate::view::Recording::fixtures) before showing one from others. [`to_mjcf`](Model::to_mjcf) reads the meshes of the
//! model, no others, and names them by their whole paths.

// A format is a folder: it reads a tree of elements ([`guard`]) into plain data, reports what it does not use ([`context`], [`schema`]), hands
// the parts to a `ModelBuilder` and ends in [`ModelOptions::finish`]. What formats share is beside the folders: values as attributes or as
// elements ([`values`]), shapes ([`shapes`]), turns ([`rotation`]), versions ([`version`]), remarks ([`remarks`], [`massless`]), and where meshes
// are ([`mesh_path`]).
mod contact_meshes;
mod context;
#[cfg(test)]
mod damage;
mod guard;
mod massless;
pub(crate) mod mesh;
mod mesh_path;
mod remarks;
mod report;
mod roots;
mod rotation;
mod schema;
mod sdf;
mod shapes;
#[cfg(test)]
pub(crate) mod temporary;
mod urdf;
mod values;
mod version;
mod write;
mod xml;

use std::path::{Path, PathBuf};

pub use massless::MasslessLinks;
pub use report::{ImportNote, ImportReport};

use crate::error::{EditError, LoadError};
use crate::input::{self, MAX_TEXT_BYTES};
use crate::model::{Base, Mimicry, Model, ModelBuilder, UpAxis};
use context::Context;
use massless::Remark;
use mesh_path::MeshFinder;
use roots::Roots;

/// Name of the source in errors and reports for a description that is not in a file.
const TEXT_SOURCE: &str = "URDF text";

/// Name of the source in errors and reports for SDF that is not in a file.
const SDF_TEXT_SOURCE: &str = "SDF text";

/// Options for loading a robot.
///
/// # Examples
/// ```
/// use dualbody::io::ModelOptions;
/// use dualbody::model::Base;
///
/// let xml = r#"<robot name="ball"><link name="ball"><inertial>
///   <mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
/// </inertial></link></robot>"#;
/// let (model, report) = ModelOptions::default().with_base(Base::Floating).load_urdf_str(xml)?;
/// assert_eq!((model.nv(), model.total_mass()), (6, 2.0));
/// assert!(report.ignored.is_empty());
/// # Ok::<(), dualbody::LoadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ModelOptions {
    /// Base of the robot, fixed or floating; by default as the name of its root link says.
    base: Base,
    /// Gravity in the world, m/s²; by default as the file says, else 9.81 down z.
    gravity: Option<[f64; 3]>,
    /// Whether joints that mimic others have coordinates of their own; by default they do not.
    mimicry: Mimicry,
    /// Where packages and relative mesh files are looked for first; by default nowhere.
    search_paths: Vec<PathBuf>,
    /// The folders below which files may be; by default anywhere.
    roots: Roots,
    /// Treatment of the up axis that a COLLADA file states; by default as the file says, with an exception.
    up_axis: UpAxis,
    /// Which model of an SDF file to load; by default the only one.
    model_name: Option<String>,
    /// The joints that stay joints; by default all.
    kept_joints: Option<Vec<String>>,
    /// Joints that become fixed, with where; by default none.
    locked_joints: Vec<(String, Vec<f64>)>,
    /// Treatment of links that nothing resists the motion of; by default they stay.
    massless_links: MasslessLinks,
}

impl Default for ModelOptions {
    fn default() -> Self {
        Self {
            base: Base::Auto,
            gravity: None,
            mimicry: Mimicry::default(),
            search_paths: Vec::new(),
            roots: Roots::default(),
            up_axis: UpAxis::default(),
            model_name: None,
            kept_joints: None,
            locked_joints: Vec::new(),
            massless_links: MasslessLinks::default(),
        }
    }
}

impl ModelOptions {
    /// Sets how the robot stands in the world. Without this call it floats unless its root link is called `world`: an arm whose root is called
    /// `base_link` floats, until [`Base::Fixed`] holds it. [`ImportReport::base_note`] says which base was chosen.
    #[must_use]
    pub fn with_base(mut self, base: Base) -> Self {
        self.base = base;
        self
    }

    /// Sets gravity in the world, m/s².
    #[must_use]
    pub fn with_gravity(mut self, gravity: [f64; 3]) -> Self {
        self.gravity = Some(gravity);
        self
    }

    /// Keeps these joints and locks all others, at zero or where [`with_locked_joint`](Self::with_locked_joint) says; links and
    /// frames stay, on fewer bodies. See [`ModelBuilder::keep_joints`]. Names are those of the model.
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let options = ModelOptions::default().with_kept_joints(["pivot"]);
    /// let (model, _) = options.load_urdf_file("assets/cartpole.urdf")?;
    /// assert_eq!(model.joint_names(), ["pivot"]);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    #[must_use]
    pub fn with_kept_joints<S: Into<String>>(mut self, names: impl IntoIterator<Item = S>) -> Self {
        self.kept_joints = Some(names.into_iter().map(Into::into).collect());
        self
    }

    /// Locks a joint at a configuration (rad, m, unit quaternion; as long as the `nq` of its kind).
    #[must_use]
    pub fn with_locked_joint(mut self, name: impl Into<String>, position: &[f64]) -> Self {
        self.locked_joints.push((name.into(), position.to_vec()));
        self
    }

    /// Gives joints that mimic others coordinates of their own, as if they did not. A joint to mimic that does not exist is then
    /// not an error but a warning.
    #[must_use]
    pub fn with_independent_mimic_joints(mut self) -> Self {
        self.mimicry = Mimicry::Independent;
        self
    }

    /// Sets what becomes of moving links without inertia, which make the mass matrix singular.
    ///
    /// # Examples
    /// ```
    /// use dualbody::io::MasslessLinks;
    /// use dualbody::{ModelOptions, Simulator};
    ///
    /// let xml = r#"<robot name="vane"><link name="world"/><link name="vane"/><joint name="pivot" type="continuous">
    ///   <parent link="world"/><child link="vane"/></joint></robot>"#;
    /// let (vane, report) = ModelOptions::default().load_urdf_str(xml)?;
    /// assert!(vane.check_mass_matrix().is_err() && report.warnings.len() == 2); // and that it has no axis
    ///
    /// let ball = MasslessLinks::SolidBall { mass: 0.1, radius: 0.01 };
    /// let (vane, _) = ModelOptions::default().with_massless_links(ball).load_urdf_str(xml)?;
    /// assert_eq!(Simulator::new(vane).nu(), 1);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    #[must_use]
    pub fn with_massless_links(mut self, massless_links: MasslessLinks) -> Self {
        self.massless_links = massless_links;
        self
    }

    /// Adds a folder in which to look for meshes and included models: a package, or a folder of packages.
    ///
    /// A reference `package://name/rest` or `model://name/rest` is looked for as `dir/name/rest`, then, as `dir` may be the package
    /// itself under another name, as `dir/rest`; in the folders added here, then in those of the environment variables
    /// `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`, then around the description file, upwards.
    #[must_use]
    pub fn with_search_path(mut self, dir: impl Into<PathBuf>) -> Self {
        self.search_paths.push(dir.into());
        self
    }

    /// Allows files below a folder only: the description, what it includes, its meshes and what those refer to. Called several times,
    /// below any of the folders. See [what a description can do](self#what-a-description-can-do).
    ///
    /// A mesh elsewhere is not found, which the report says; a description or an included model elsewhere is an error. The folder, and
    /// what is in it, are taken with all symbolic links followed, the folder where it is now. Of one that does not exist, nothing is allowed.
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let options = ModelOptions::default().with_root("assets");
    /// assert!(options.load_urdf_file("assets/cartpole.urdf").is_ok());
    /// let error = options.load_urdf_file("assets/../Cargo.toml").unwrap_err().to_string();
    /// assert_eq!(error, "assets/../Cargo.toml: cannot be read: is not found below the folders of with_root");
    /// ```
    #[must_use]
    pub fn with_root(mut self, dir: impl AsRef<Path>) -> Self {
        self.roots.add(dir.as_ref());
        self
    }

    /// Sets what becomes of the axis that COLLADA meshes call up; see [`UpAxis`].
    #[must_use]
    pub fn with_mesh_up_axis(mut self, up_axis: UpAxis) -> Self {
        self.up_axis = up_axis;
        self
    }

    /// Chooses a model of an SDF file that holds several, or a world with several.
    #[must_use]
    pub fn with_model_name(mut self, name: impl Into<String>) -> Self {
        self.model_name = Some(name.into());
        self
    }

    /// The model of the parts that a file holds.
    fn build(&self, parts: ModelBuilder) -> Result<Model, LoadError> {
        let mut parts = parts.with_base(self.base).with_mimicry(self.mimicry);
        let locked = self.locked_joints.iter();
        let locked: Vec<(&str, &[f64])> = locked
            .map(|(name, q)| (name.as_str(), q.as_slice()))
            .collect();
        let chosen = match &self.kept_joints {
            Some(kept) => {
                let kept: Vec<&str> = kept.iter().map(String::as_str).collect();
                parts.keep_joints(&kept, &locked)
            }
            None if locked.is_empty() => Ok(&mut parts),
            None => parts.lock_joints(&locked),
        };
        match chosen {
            Ok(parts) => self.massless_links.build(parts),
            Err(EditError::Load(error)) => Err(error),
            Err(source) => Err(LoadError::JointChoice {
                file: parts.source().into(),
                source: Box::new(source),
            }),
        }
    }

    /// Builds the model of the parts and closes the report on them.
    ///
    /// * `notes` – places remarks on joints in the description
    fn finish<'c>(
        &self,
        parts: ModelBuilder,
        mut context: Context<'c>,
        notes: impl FnOnce(&Context<'c>, Vec<Remark>) -> Vec<ImportNote>,
    ) -> Result<(Model, ImportReport), LoadError> {
        let model = self.build(parts)?;
        let remarks = massless::remarks(&model);
        if !remarks.is_empty() {
            let notes = notes(&context, remarks);
            context.warnings.extend(notes);
        }
        let report = report::report(context, self.base, &model);
        Ok((model, report))
    }

    /// Makes a robot of what [`urdf_rs`], version 0.10, has read or a program has put together: the same as from the text, where the
    /// text holds no more.
    ///
    /// A mesh with a relative path is looked for in the [search paths](Self::with_search_path). What `urdf_rs::Robot` cannot tell is taken
    /// so: a limit whose numbers are all zero, as that crate fills in where there is none, is no limit; other zeros mean zero, also of an
    /// effort that a text leaves out; infinite limits are none; an empty name of the robot is none. Remarks have no lines: theirs is 0.
    ///
    /// Cost: linear in the number of links and joints.
    ///
    /// # Errors
    /// See [`LoadError`]: among others if a number is not finite, a mass negative, an axis zero, a name there twice, a link unknown, or if the
    /// joints close a loop. The error names element and reason.
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    /// use dualbody::urdf_rs;
    ///
    /// let mut robot = urdf_rs::read_file("assets/cartpole.urdf")?;
    /// robot.links[1].inertial.mass.value = 3.0;
    /// let (cartpole, report) = ModelOptions::default().load_urdf(&robot)?;
    /// assert_eq!(cartpole.joint_names(), ["linear", "pivot"]);
    /// assert!(report.ignored.is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn load_urdf(&self, robot: &urdf_rs::Robot) -> Result<(Model, ImportReport), LoadError> {
        let mut meshes = MeshFinder::new(None, self);
        urdf::load_robot(robot, self, &mut meshes)
    }

    /// Loads a robot from the text of a URDF file.
    ///
    /// Cost: linear in the length of the text.
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn load_urdf_str(&self, xml: &str) -> Result<(Model, ImportReport), LoadError> {
        let mut meshes = MeshFinder::new(None, self);
        urdf::load(TEXT_SOURCE, xml, self, &mut meshes)
    }

    /// Loads a robot from a URDF file.
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn load_urdf_file(
        &self,
        path: impl AsRef<Path>,
    ) -> Result<(Model, ImportReport), LoadError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text = self.read_text(&file, path)?;
        let mut meshes = MeshFinder::new(path.parent(), self);
        urdf::load(&file, &text, self, &mut meshes)
    }

    /// Loads a robot from the text of an SDF file, version 1.5 to 1.11.
    ///
    /// A robot that a joint attaches to the world is fixed, any other floats; a static model is fixed. Parts of nested models are
    /// called `model::part`, unless they are merged. Joints of a world hold the robot, or join other models to it, whose parts are
    /// called `model::part` as well; if they join all models, no choice is needed and the first one gives its name. Where a
    /// joint's frame is not that of its child, a link without inertia, called like the joint, is put between. A universal joint
    /// becomes two joints, `name::axis` and `name::axis2`.
    ///
    /// Cost: linear in the length of the text.
    ///
    /// # Errors
    /// See [`LoadError`].
    ///
    /// # Examples
    /// ```
    /// use dualbody::io::ModelOptions;
    ///
    /// let xml = r#"<sdf version="1.9"><model name="ball"><link name="ball"><inertial>
    ///   <mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>
    /// </inertial></link></model></sdf>"#;
    /// let (model, _) = ModelOptions::default().load_sdf_str(xml)?;
    /// assert_eq!((model.nv(), model.total_mass()), (6, 2.0));
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn load_sdf_str(&self, xml: &str) -> Result<(Model, ImportReport), LoadError> {
        sdf::load(SDF_TEXT_SOURCE, xml, None, self)
    }

    /// Loads a robot from an SDF file, version 1.5 to 1.11, as [`load_sdf_str`](Self::load_sdf_str) does.
    ///
    /// Included models are looked for like meshes, as a file or as a folder, in which `model.config` names the file or else it is
    /// `model.sdf`; `model://name` finds the folder of that name. Nothing is fetched.
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn load_sdf_file(
        &self,
        path: impl AsRef<Path>,
    ) -> Result<(Model, ImportReport), LoadError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text = self.read_text(&file, path)?;
        sdf::load(&file, &text, Some(path), self)
    }

    /// The text of a file that may be read.
    fn read_text(&self, file: &str, path: &Path) -> Result<String, LoadError> {
        let path = self.roots.admit(path);
        let bytes = path.and_then(|path| input::read(&path, MAX_TEXT_BYTES));
        let bytes = bytes.map_err(|source| LoadError::Io {
            file: file.into(),
            source,
        })?;
        String::from_utf8(bytes).map_err(|error| LoadError::NotUtf8 {
            file: file.into(),
            offset: error.utf8_error().valid_up_to(),
        })
    }
}

impl Model<f64> {
    /// Loads a robot from a URDF file with the default [`ModelOptions`]: it floats, an arm too, unless its root link is called `world`
    /// ([`ModelOptions::with_base`]).
    ///
    /// # Errors
    /// See [`LoadError`].
    ///
    /// # Examples
    /// ```
    /// use dualbody::Model;
    ///
    /// let cartpole = Model::from_urdf_file("assets/cartpole.urdf")?;
    /// assert_eq!(cartpole.joint_names(), ["linear", "pivot"]);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn from_urdf_file(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Ok(ModelOptions::default().load_urdf_file(path)?.0)
    }

    /// Makes a robot of what [`urdf_rs`] has read, with the default [`ModelOptions`]; see [`ModelOptions::load_urdf`].
    ///
    /// # Errors
    /// See [`LoadError`].
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Model, urdf_rs};
    ///
    /// let cartpole = Model::from_urdf(&urdf_rs::read_file("assets/cartpole.urdf")?)?;
    /// let same = Model::from_urdf_file("assets/cartpole.urdf")?;
    /// assert_eq!(cartpole.total_mass(), same.total_mass());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_urdf(robot: &urdf_rs::Robot) -> Result<Self, LoadError> {
        Ok(ModelOptions::default().load_urdf(robot)?.0)
    }

    /// Loads a robot from the text of a URDF file with the default [`ModelOptions`].
    ///
    /// # Errors
    /// See [`LoadError`].
    ///
    /// # Examples
    /// ```
    /// use dualbody::Model;
    ///
    /// let model = Model::from_urdf_str(r#"<robot name="nothing"><link name="world"/></robot>"#)?;
    /// assert_eq!((model.name(), model.nv()), ("nothing", 0));
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn from_urdf_str(xml: &str) -> Result<Self, LoadError> {
        Ok(ModelOptions::default().load_urdf_str(xml)?.0)
    }

    /// Loads a robot from an SDF file with the default [`ModelOptions`].
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn from_sdf_file(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Ok(ModelOptions::default().load_sdf_file(path)?.0)
    }

    /// Loads a robot from the text of an SDF file with the default [`ModelOptions`].
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn from_sdf_str(xml: &str) -> Result<Self, LoadError> {
        Ok(ModelOptions::default().load_sdf_str(xml)?.0)
    }
}
