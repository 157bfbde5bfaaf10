//! Robots from descriptions.

use std::path::{Path, PathBuf};

use dualbody::error::LoadError;
use dualbody::io::MasslessLinks;
use dualbody::model::{Base, BodyId, UpAxis};
use dualbody::{ImportReport, ModelOptions};

use super::report::{PyImportReport, base_of};
use crate::prelude::*;

/// Reads the keywords of a loader.
fn options_of(keywords: &Bound<'_, PyDict>) -> PyResult<ModelOptions> {
    keywords
        .iter()
        .try_fold(ModelOptions::default(), |options, (name, value)| {
            let name: String = name.extract()?;
            with_option(options, &name, &value)
        })
}

/// Options with that of a keyword; what has the wrong type is a `TypeError` that names it.
fn with_option(
    options: ModelOptions,
    name: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<ModelOptions> {
    let wrong = |error: PyErr| wrong_type!("{name}: {}", error.value(value.py()));
    let text = || value.extract::<String>().map_err(wrong);
    let paths = || value.extract::<Vec<PathBuf>>().map_err(wrong);
    Ok(match name {
        "base" => options.with_base(base_of(&text()?)?),
        "gravity" => options.with_gravity(value.extract().map_err(wrong)?),
        "independent_mimic_joints" => match value.extract().map_err(wrong)? {
            true => options.with_independent_mimic_joints(),
            false => options,
        },
        "kept_joints" => options.with_kept_joints(value.extract::<Vec<String>>().map_err(wrong)?),
        "locked_joints" => {
            let given = value.cast::<PyDict>();
            let positions = by_name(given.map_err(|error| wrong(error.into()))?)?;
            let lock = |options: ModelOptions, (name, x): &(String, Vec<f64>)| {
                options.with_locked_joint(name.clone(), x)
            };
            positions.iter().fold(options, lock)
        }
        "massless_links" => options.with_massless_links(massless(value)?),
        "mesh_up_axis" => {
            let all = [UpAxis::Auto, UpAxis::Honour, UpAxis::Ignore];
            options.with_mesh_up_axis(variant(name, &text()?, &all)?)
        }
        "all_models" => match value.extract().map_err(wrong)? {
            true => options.with_all_models(),
            false => options,
        },
        "model_name" => options.with_model_name(text()?),
        "search_paths" => (paths()?.into_iter()).fold(options, ModelOptions::with_search_path),
        "roots" => paths()?.into_iter().fold(options, ModelOptions::with_root),
        _ => {
            return Err(wrong_type!("\"{name}\" is not a keyword of a loader"));
        }
    })
}

/// "kept", "refused", or (mass, radius) of a ball that such links get.
fn massless(value: &Bound<'_, PyAny>) -> PyResult<MasslessLinks> {
    if let Ok((mass, radius)) = value.extract() {
        return Ok(MasslessLinks::SolidBall { mass, radius });
    }
    match value.extract::<String>().as_deref() {
        Ok("kept") => Ok(MasslessLinks::Kept),
        Ok("refused") => Ok(MasslessLinks::Refused),
        _ => Err(value_error(
            "massless_links is not \"kept\", \"refused\" or (mass, radius)",
        )),
    }
}

/// Whether it is a description, and not the path of one: XML, after a byte-order mark perhaps.
pub(crate) fn is_text(text: &str) -> bool {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    text.starts_with('<')
}

impl PyModel {
    /// The robot of a description in a format, "urdf", "sdf" or "mjcf": a text that begins like XML, or a file.
    pub(crate) fn of_description(
        format: &'static str,
        description: &Bound<'_, PyAny>,
        keywords: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        of_description(_load_model, format, description, keywords)
    }
}

/// Hands a description to a function of format, text, path and keywords.
pub(super) fn of_description<'py, T>(
    load: impl FnOnce(
        Python<'py>,
        &str,
        Option<String>,
        Option<PathBuf>,
        &Bound<'py, PyDict>,
    ) -> PyResult<T>,
    format: &str,
    description: &Bound<'py, PyAny>,
    keywords: Option<&Bound<'py, PyDict>>,
) -> PyResult<T> {
    let py = description.py();
    let none = PyDict::new(py);
    let keywords = keywords.unwrap_or(&none);
    match description.extract::<String>() {
        Ok(text) if is_text(&text) => load(py, format, Some(text), None, keywords),
        _ => {
            let path = description.extract::<PathBuf>();
            let path = path.map_err(|_| type_error("description is neither a text nor a path"))?;
            load(py, format, None, Some(path), keywords)
        }
    }
}

/// A description.
pub(super) struct Source {
    options: ModelOptions,
    text: Option<String>,
    path: Option<PathBuf>,
    /// Whether the file has this text.
    is_there: bool,
}

impl Source {
    pub(super) fn new(
        text: Option<String>,
        path: Option<PathBuf>,
        keywords: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        // A pickle may be read in another folder.
        let path = path.map(|path| std::path::absolute(&path).unwrap_or(path));
        let read = path.as_ref();
        let read = read.and_then(|path| std::fs::read_to_string(path).ok());
        Ok(Self {
            options: guarded(|| options_of(keywords))??,
            is_there: path.is_some() && (text.is_none() || text == read),
            text: text.or(read),
            path,
        })
    }

    /// Reads the file if it is there; else the text, with meshes beside the file.
    pub(super) fn load<T>(
        &self,
        of_file: fn(&ModelOptions, &Path) -> Result<T, LoadError>,
        of_text: fn(&ModelOptions, &str) -> Result<T, LoadError>,
    ) -> PyResult<T> {
        let text = self.text.as_deref().unwrap_or_default();
        let loaded = guarded(|| match &self.path {
            Some(path) if self.is_there => of_file(&self.options, path),
            path => of_text(&beside(self.options.clone(), path.as_ref()), text),
        });
        loaded?.or_raise()
    }

    /// The arguments that read it again: format, text, path and keywords.
    pub(super) fn recipe<'py>(
        self,
        format: &str,
        options: &Bound<'py, PyDict>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        // As text: for a path as such PyO3 imports `pathlib`, which takes longer than a small robot to load.
        let path = self.path.map(PathBuf::into_os_string);
        (format, self.text, path, options).into_pyobject(options.py())
    }
}

functions! {
    /// Loads a robot: `format` is "urdf", "sdf" or "mjcf", `text` the description, `path` the file that it is from, if it is from one.
    ///
    /// A pickled robot is loaded from its text again; its meshes are looked for beside the file if that is there.
    fn _load_model(py: Python, format: &str, text: Option<String>, path: Option<PathBuf>, options: &Bound<'py, PyDict>) -> PyResult<PyModel> {
        let source = Source::new(text, path, options)?;
        let (model, report) = py.detach(|| match format {
            "sdf" => source.load(|own, path| own.load_sdf_file(path), |own, text| own.load_sdf_str(text)),
            "mjcf" => source.load(|own, path| own.load_mjcf_file(path), |own, text| own.load_mjcf_str(text)),
            _ => source.load(|own, path| own.load_urdf_file(path), |own, text| own.load_urdf_str(text)),
        })?;
        warn_of_floating_arm(py, &model, &report)?;
        let report = Py::new(py, PyImportReport { report })?;
        let model = PyModel::new(model, ("_load_model", source.recipe(format, options)?));
        Ok(PyModel {
            report: Some(report),
            ..model
        })
    }
}

/// Warns of a robot that floats unasked and whose base carries one chain only: as a rule an arm that was meant to stand.
pub(super) fn warn_of_floating_arm(
    py: Python<'_>,
    model: &Model,
    report: &ImportReport,
) -> PyResult<()> {
    let on_base = |body: &&dualbody::model::Body<f64>| body.parent == Some(BodyId(0));
    let is_unasked = (report.wanted_base, report.base) == (Base::Auto, Base::Floating);
    if !is_unasked || model.bodies().iter().filter(on_base).count() != 1 {
        return Ok(());
    }
    warn(
        py,
        &format!(
            "\"{}\" floats, with 6 degrees of freedom more than its joints have, as its root link \"{}\" is not called \"world\": \
             base=\"fixed\" holds it, base=\"floating\" says that this is meant",
            model.name(),
            report.root_link
        ),
    )
}

/// Options that look for meshes beside a file too.
fn beside(options: ModelOptions, path: Option<&PathBuf>) -> ModelOptions {
    match path.and_then(|path| path.parent()) {
        Some(dir) if dir.is_dir() => options.with_search_path(dir),
        _ => options,
    }
}

/// Positions by name: a number, or a vector for a joint with several coordinates.
pub(super) fn by_name(given: &Bound<'_, PyDict>) -> PyResult<Vec<(String, Vec<f64>)>> {
    let one = |(name, x): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let x = x
            .extract::<f64>()
            .map(|x| vec![x])
            .or_else(|_| read_vector("positions", &x, None));
        Ok((name.extract::<String>()?, x?))
    };
    given.iter().map(one).collect()
}

methods! { PyModel {
    /// Loads a robot from a URDF: a text that begins with "<", or the path of a file.
    ///
    /// base: "auto" (fixed if the root link is called "world"; else it floats, an arm too, with a warning), "fixed" or "floating"; gravity: m/s², (0, 0, -9.81) if left out;
    /// independent_mimic_joints: joints that mimic others get coordinates of their own; kept_joints: names, the others are held;
    /// locked_joints: {name: position}; search_paths, roots: directories of meshes; massless_links: "kept", "refused" or (mass, radius);
    /// mesh_up_axis: "auto", "honour" or "ignore". What the loader remarks is in `import_report`.
    #[staticmethod]
    fn from_urdf(description, **keywords) -> PyResult<Self> {
        Self::of_description("urdf", description, keywords)
    }

    /// Loads a robot from an SDF: a text that begins with "<", or the path of a file. The keywords are those of from_urdf, and
    /// model_name where there are several.
    #[staticmethod]
    fn from_sdf(description, **keywords) -> PyResult<Self> {
        Self::of_description("sdf", description, keywords)
    }

    /// Loads a robot from an MJCF, the XML of MuJoCo: a text that begins with "<", or the path of a file. The keywords are those of from_urdf; with base
    /// "auto" the robot stands or floats as the file says. Joints, bodies and sites keep their names, and q has the numbers of qpos. What the model
    /// cannot hold, such as actuators and sensors, is in `import_report`.
    #[staticmethod]
    fn from_mjcf(description, **keywords) -> PyResult<Self> {
        Self::of_description("mjcf", description, keywords)
    }
} }
