//! Options for loading a robot from any format.

use std::path::{Path, PathBuf};

use super::context::Context;
use super::massless::{self, MasslessLinks, Remark};
use super::place::ImportNote;
use super::report::{self, ImportReport};
use super::roots::Roots;
use crate::error::{EditError, LoadError};
use crate::model::{Base, Mimicry, Model, ModelBuilder, UpAxis};

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
    /// Base of the robot, fixed or floating; by default according to the name of its root link.
    pub(super) base: Base,
    /// Gravity in the world, m/s²; by default according to the file, else 9.81 down z.
    pub(super) gravity: Option<[f64; 3]>,
    /// Whether joints that mimic others have coordinates of their own; by default they do not.
    pub(super) mimicry: Mimicry,
    /// Folders where packages and relative mesh files are looked for first; by default none.
    pub(super) search_paths: Vec<PathBuf>,
    /// The folders below which files may be; by default anywhere.
    pub(super) roots: Roots,
    /// Treatment of the up axis that a COLLADA file states; by default according to the file, with an exception.
    pub(super) up_axis: UpAxis,
    /// Name of the model of an SDF file to load; by default the only one.
    pub(super) model_name: Option<String>,
    /// Whether all models of an SDF file are loaded, as one world.
    pub(super) all_models: bool,
    /// The joints that stay joints; by default all.
    pub(super) kept_joints: Option<Vec<String>>,
    /// Joints that become fixed, with where; by default none.
    pub(super) locked_joints: Vec<(String, Vec<f64>)>,
    /// Treatment of links that nothing resists the motion of; by default they stay.
    pub(super) massless_links: MasslessLinks,
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
            all_models: false,
            kept_joints: None,
            locked_joints: Vec::new(),
            massless_links: MasslessLinks::default(),
        }
    }
}

impl ModelOptions {
    /// Sets the base: fixed or floating. Without this call the robot floats unless its root link is called `world`: an arm whose root is called
    /// `base_link` floats; use [`Base::Fixed`] to fix it. [`ImportReport::base_note`] reports the base.
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

    /// Keeps these joints and locks all others, at zero or at the position of [`with_locked_joint`](Self::with_locked_joint). Links and frames
    /// remain, on fewer bodies. See [`Model::with_kept_joints`]. Names are those of the model.
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

    /// Locks a joint at a configuration (rad, m, unit quaternion; length `nq` of its kind).
    #[must_use]
    pub fn with_locked_joint(mut self, name: impl Into<String>, position: &[f64]) -> Self {
        self.locked_joints.push((name.into(), position.to_vec()));
        self
    }

    /// Makes mimic joints independent, with their own coordinates. A missing leader is then a warning instead of an error.
    #[must_use]
    pub fn with_independent_mimic_joints(mut self) -> Self {
        self.mimicry = Mimicry::Independent;
        self
    }

    /// Sets the treatment of moving links without inertia, which make the mass matrix singular.
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

    /// Adds a search folder for meshes and included models: a package, or a folder of packages.
    ///
    /// A reference `package://name/rest` or `model://name/rest` is searched as `dir/name/rest`, then as `dir/rest` (if `dir` is the package itself):
    /// in the folders added here, in those of the environment variables `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`, and in the folder of the
    /// description file and its parents.
    #[must_use]
    pub fn with_search_path(mut self, dir: impl Into<PathBuf>) -> Self {
        self.search_paths.push(dir.into());
        self
    }

    /// Restricts file access to a folder: for the description, included files, meshes and their references. Several calls allow several folders. See
    /// [what a description can do](super#what-a-description-can-do).
    ///
    /// Meshes elsewhere are reported as not found; a description or an included model elsewhere is an error. Symbolic links of folder and files are
    /// resolved, for the folder at the time of this call. A folder that does not exist allows nothing.
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let options = ModelOptions::default().with_root("assets");
    /// assert!(options.load_urdf_file("assets/cartpole.urdf").is_ok());
    /// let error = options.load_urdf_file("assets/../Cargo.toml").unwrap_err().to_string();
    /// assert_eq!(error, "assets/../Cargo.toml: cannot be read: not found below the root folders");
    /// ```
    #[must_use]
    pub fn with_root(mut self, dir: impl AsRef<Path>) -> Self {
        self.roots.add(dir.as_ref());
        self
    }

    /// Sets the treatment of the up axis of COLLADA meshes; see [`UpAxis`].
    #[must_use]
    pub fn with_mesh_up_axis(mut self, up_axis: UpAxis) -> Self {
        self.up_axis = up_axis;
        self
    }

    /// Selects a model of an SDF file or world with several models.
    #[must_use]
    pub fn with_model_name(mut self, name: impl Into<String>) -> Self {
        self.model_name = Some(name.into());
        self
    }

    /// Loads all models of an SDF file or of its world as one model, a [world](crate::model::World): names are `model::part`; static models are
    /// fixed; models without a joint to the world float, from the pose in the file, on a joint `model::floating_base` without input.
    /// [`with_base`](Self::with_base) with [`Base::Fixed`] fixes all models. No effect on URDF files, which contain one robot.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{ModelOptions, State};
    ///
    /// let ball = |name: &str, z: f64| format!("<model name='{name}'><pose>0 0 {z} 0 0 0</pose><link name='l'/></model>");
    /// let xml = format!("<sdf version='1.9'><world name='two'>{}{}</world></sdf>", ball("a", 1.0), ball("b", 2.0));
    /// let (world, _) = ModelOptions::default().with_all_models().load_sdf_str(&xml)?;
    /// assert_eq!((world.name(), world.nv()), ("two", 12));
    /// let b = State::<f64>::neutral(&world).free_pose(&world, "b::floating_base").unwrap();
    /// assert_eq!(b.translation.z, 2.0);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    #[must_use]
    pub fn with_all_models(mut self) -> Self {
        self.all_models = true;
        self
    }

    /// The model of the parts that a file holds.
    fn build(&self, parts: ModelBuilder) -> Result<Model, LoadError> {
        self.build_on(parts, self.base)
    }

    /// The model of the parts that a file holds; the file says on which base, where the options leave it open.
    pub(super) fn build_on(&self, parts: ModelBuilder, base: Base) -> Result<Model, LoadError> {
        let base = match self.base {
            Base::Auto => base,
            wanted => wanted,
        };
        let mut parts = parts.with_base(base).with_mimicry(self.mimicry);
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
                file: parts.source,
                source: Box::new(source),
            }),
        }
    }

    /// Builds the model of the parts and closes the report on them.
    ///
    /// * `notes` – positions in the description for remarks on joints
    pub(super) fn finish<'c>(
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
        Ok(close(model, context, self.base))
    }
}

/// Closes the report on a model, which keeps its remarks.
pub(super) fn close(model: Model, context: Context<'_>, wanted: Base) -> (Model, ImportReport) {
    let report = report::report(context, wanted, &model);
    (model.with_remarks(report.remarks()), report)
}
