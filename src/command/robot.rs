//! The robot that a command is about: its file, and how it is loaded.

use std::error::Error;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::io::{ImportReport, MjcfScene, ModelOptions};
use crate::model::{Base, Model};

/// Bytes at the start of a file in which its format shows.
const HEAD_BYTES: u64 = 4096;

/// A file with a robot, and how to load it.
#[derive(Args, Debug)]
pub(super) struct Robot {
    /// Description of the robot: URDF, SDF or MJCF.
    file: PathBuf,
    /// Format of the file; by default from its extension or its first element.
    #[arg(long)]
    format: Option<Format>,
    /// Base of the robot: from the file, fixed, or floating.
    #[arg(long, default_value = "auto")]
    base: BaseWord,
    /// Gravity, m/s²; by default that of the file.
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], allow_negative_numbers = true)]
    gravity: Option<Vec<f64>>,
    /// Folder with packages and meshes; may be given several times.
    #[arg(long = "search-path", value_name = "FOLDER")]
    search_paths: Vec<PathBuf>,
    /// Open files below this folder only, for untrusted descriptions; may be given several times.
    #[arg(long = "root", value_name = "FOLDER")]
    roots: Vec<PathBuf>,
    /// Model of an SDF file with several models.
    #[arg(long, value_name = "NAME")]
    model: Option<String>,
    /// All models of an SDF file as one world.
    #[arg(long, conflicts_with = "model")]
    all_models: bool,
}

/// Format of a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    Urdf,
    Sdf,
    Mjcf,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum BaseWord {
    Auto,
    Fixed,
    Floating,
}

/// A robot that was loaded.
#[derive(Debug)]
pub(super) struct Loaded {
    pub(super) model: Model,
    pub(super) report: ImportReport,
    /// Further content of an MJCF file.
    pub(super) scene: Option<MjcfScene>,
}

impl Robot {
    pub(super) fn load(&self) -> Result<Loaded, Box<dyn Error>> {
        let options = self.options();
        let format = match self.format {
            Some(format) => format,
            None => Format::of(&self.file)?,
        };
        let plain = |(model, report)| Loaded {
            model,
            report,
            scene: None,
        };
        Ok(match format {
            Format::Urdf => plain(options.load_urdf_file(&self.file)?),
            Format::Sdf => plain(options.load_sdf_file(&self.file)?),
            Format::Mjcf => {
                let (scene, report) = options.load_mjcf_scene_file(&self.file)?;
                Loaded {
                    model: scene.model.clone(),
                    report,
                    scene: Some(scene),
                }
            }
        })
    }

    /// Name of the file without folder and ending.
    pub(super) fn stem(&self) -> String {
        let stem = self.file.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    fn options(&self) -> ModelOptions {
        let mut options = ModelOptions::default().with_base(match self.base {
            BaseWord::Auto => Base::Auto,
            BaseWord::Fixed => Base::Fixed,
            BaseWord::Floating => Base::Floating,
        });
        if let Some([x, y, z]) = self.gravity.as_deref() {
            options = options.with_gravity([*x, *y, *z]);
        }
        for folder in &self.search_paths {
            options = options.with_search_path(folder);
        }
        for folder in &self.roots {
            options = options.with_root(folder);
        }
        if let Some(name) = &self.model {
            options = options.with_model_name(name);
        }
        if self.all_models {
            options = options.with_all_models();
        }
        options
    }
}

impl Format {
    /// The format of a file by its ending, or, of `.xml` and unknown ones, by the first element that one of them begins with.
    fn of(path: &Path) -> Result<Self, Box<dyn Error>> {
        match Self::by_ending(path) {
            Some(format) => Ok(format),
            None => Self::by_content(path),
        }
    }

    pub(super) fn by_ending(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_lowercase();
        match ending.as_str() {
            "urdf" => Some(Self::Urdf),
            "sdf" | "world" => Some(Self::Sdf),
            "mjcf" => Some(Self::Mjcf),
            _ => None,
        }
    }

    fn by_content(path: &Path) -> Result<Self, Box<dyn Error>> {
        let shown = path.display();
        // A pipe would be waited for.
        if path.exists() && !path.is_file() {
            return Err(format!("{shown} is not a regular file").into());
        }
        let mut head = Vec::new();
        File::open(path)
            .and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head))
            .map_err(|error| format!("{shown} cannot be read: {error}"))?;
        let head = String::from_utf8_lossy(&head);
        let known = [
            ("<robot", Self::Urdf),
            ("<sdf", Self::Sdf),
            ("<mujoco", Self::Mjcf),
        ];
        let first = known
            .iter()
            .filter_map(|(tag, format)| Some((head.find(tag)?, *format)));
        match first.min_by_key(|(at, _)| *at) {
            Some((_, format)) => Ok(format),
            None => Err(format!(
                "{shown}: no <robot>, <sdf> or <mujoco> near its start; give its format with --format"
            )
            .into()),
        }
    }
}
