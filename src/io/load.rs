//! Loads a robot from a file, a text, or a `urdf-rs` robot.

use std::path::Path;

use super::mesh_path::MeshFinder;
use super::report::ImportReport;
use super::{MjcfScene, ModelOptions, mjcf, sdf, urdf};
use crate::error::LoadError;
use crate::input::{self, MAX_TEXT_BYTES};
use crate::model::Model;

/// Name of the source in errors and reports for a description that is not in a file.
const TEXT_SOURCE: &str = "URDF text";

/// Name of the source in errors and reports for SDF that is not in a file.
const SDF_TEXT_SOURCE: &str = "SDF text";

/// Name of the source in errors and reports for MJCF that is not in a file.
const MJCF_TEXT_SOURCE: &str = "MJCF text";

impl ModelOptions {
    /// Makes a robot from a [`urdf_rs`] robot, version 0.10, read or built by a program. The result equals that of loading the text, if the text
    /// contains nothing else.
    ///
    /// Meshes with a relative path are searched in the [search paths](Self::with_search_path). `urdf_rs::Robot` does not distinguish some cases,
    /// which are read as follows. A limit with all values zero, the default of that crate, means no limit; other zeros mean zero, also for an effort
    /// that the text omits. Infinite limits mean no limit, and an empty robot name means no name. The line of remarks is 0.
    ///
    /// Cost: linear in the number of links and joints.
    ///
    /// # Errors
    /// See [`LoadError`]: for example if a value is not finite, a mass is negative, an axis is zero, a name is duplicate, a link is unknown, or the
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
        let (file, text) = self.read_file(path)?;
        let mut meshes = MeshFinder::new(path.parent(), self);
        urdf::load(&file, &text, self, &mut meshes)
    }

    /// Loads a robot from the text of an SDF file, version 1.5 to 1.11.
    ///
    /// A robot with a joint to the world is fixed, other robots float; a static model is fixed. Parts of nested models are called `model::part`,
    /// unless they are merged. Joints of a world fix the robot, or connect other models to it, whose parts are also called `model::part`; if they
    /// connect all models, no selection is needed and the name is that of the first model. If the frame of a joint is not that of its child, a link
    /// without inertia with the name of the joint is inserted. A universal joint becomes two joints, `name::axis` and `name::axis2`.
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
    /// Included models are searched like meshes, as a file or as a folder; in a folder, `model.config` names the file, by default `model.sdf`.
    /// `model://name` finds the folder of that name. Nothing is downloaded.
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn load_sdf_file(
        &self,
        path: impl AsRef<Path>,
    ) -> Result<(Model, ImportReport), LoadError> {
        let path = path.as_ref();
        let (file, text) = self.read_file(path)?;
        sdf::load(&file, &text, Some(path), self)
    }

    /// Loads a robot from the text of an MJCF file, with all content that a model can contain.
    ///
    /// Bodies are links; joints, bodies and sites keep their names. Coordinates equal `qpos`: the reference of a hinge or slide is in the placement
    /// of the joint. A single free body on the world is a floating base, without a joint name; several free bodies have named floating joints on a
    /// link `world`. Several joints of a body are separated by links without inertia, `JOINT::link`. Masses of bodies without `<inertial>` come from
    /// their geoms; mesh files are read if they contribute, and must be closed.
    ///
    /// Cost: linear in the length of the text and in what replicas add.
    ///
    /// # Errors
    /// See [`LoadError`].
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let xml = r#"<mujoco><worldbody><body name="rod"><joint name="hinge" axis="0 1 0" range="-90 90"/>
    ///   <geom type="capsule" fromto="0 0 0 0 0 -1" size="0.02" mass="1"/></body></worldbody></mujoco>"#;
    /// let (model, report) = ModelOptions::default().load_mjcf_str(xml)?;
    /// assert_eq!((model.joint_names(), model.total_mass()), (vec!["hinge"], 1.0));
    /// assert!(report.ignored.is_empty(), "{report}");
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn load_mjcf_str(&self, xml: &str) -> Result<(Model, ImportReport), LoadError> {
        let (scene, report) = self.load_mjcf_scene_str(xml)?;
        Ok((scene.model, report))
    }

    /// Loads a robot from an MJCF file, as [`load_mjcf_str`](Self::load_mjcf_str) does, with the files that it includes and attaches.
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn load_mjcf_file(
        &self,
        path: impl AsRef<Path>,
    ) -> Result<(Model, ImportReport), LoadError> {
        let (scene, report) = self.load_mjcf_scene_file(path)?;
        Ok((scene.model, report))
    }

    /// Loads all supported content from the text of an MJCF file.
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn load_mjcf_scene_str(&self, xml: &str) -> Result<(MjcfScene, ImportReport), LoadError> {
        mjcf::load(MJCF_TEXT_SOURCE, xml, None, self)
    }

    /// Loads all supported content from an MJCF file.
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn load_mjcf_scene_file(
        &self,
        path: impl AsRef<Path>,
    ) -> Result<(MjcfScene, ImportReport), LoadError> {
        let path = path.as_ref();
        let (file, text) = self.read_file(path)?;
        mjcf::load(&file, &text, Some(path), self)
    }

    /// The name of a file, as errors and the report call it, and its text.
    pub(super) fn read_file(&self, path: &Path) -> Result<(String, String), LoadError> {
        let file = path.display().to_string();
        let text = self.read_text(&file, path)?;
        Ok((file, text))
    }

    /// The text of a file that may be read.
    pub(super) fn read_text(&self, file: &str, path: &Path) -> Result<String, LoadError> {
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
    /// Loads a robot from a URDF file with the default [`ModelOptions`]: it floats, even an arm, unless its root link is called `world`
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

    /// Loads a robot from an MJCF file with the default [`ModelOptions`]; see [`ModelOptions::load_mjcf_str`].
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn from_mjcf_file(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Ok(ModelOptions::default().load_mjcf_file(path)?.0)
    }

    /// Loads a robot from the text of an MJCF file with the default [`ModelOptions`].
    ///
    /// # Errors
    /// See [`LoadError`].
    pub fn from_mjcf_str(xml: &str) -> Result<Self, LoadError> {
        Ok(ModelOptions::default().load_mjcf_str(xml)?.0)
    }
}
