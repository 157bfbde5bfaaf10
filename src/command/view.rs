//! `dualbody view`: an HTML viewer with sliders.

use std::error::Error;
use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;

use clap::Args;

use super::output::{Outcome, complain};
use super::robot::Robot;
use crate::view::model_page;

/// Show a robot in the browser, with a slider for each joint.
#[derive(Args, Debug)]
pub(super) struct View {
    #[command(flatten)]
    robot: Robot,
    /// The HTML file; by default one in the folder for temporary files.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the file only.
    #[arg(long)]
    no_open: bool,
}

impl View {
    pub(super) fn run(self) -> Result<Outcome, Box<dyn Error>> {
        let page = model_page(&self.robot.load()?.model);
        let path = match self.output {
            Some(path) => path,
            None => temporary(&self.robot.stem())?,
        };
        fs::write(&path, page)
            .map_err(|error| format!("{} cannot be written: {error}", path.display()))?;
        if !self.no_open {
            open(&path);
        }
        Ok(Outcome::of(path.display()))
    }
}

/// A file in a new private folder for temporary files, where no other user can place a link.
fn temporary(stem: &str) -> Result<PathBuf, Box<dyn Error>> {
    for k in 0..1000 {
        let folder = std::env::temp_dir().join(format!("dualbody-{}-{k}", std::process::id()));
        match fs::create_dir(&folder) {
            Ok(()) => return Ok(folder.join(format!("{stem}.html"))),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => {
                return Err(format!("{} cannot be made: {error}", folder.display()).into());
            }
        }
    }
    Err("no folder for temporary files: name a page with --output".into())
}

/// Opens a file or a URL in the browser; warns if there is none.
pub(super) fn open(path: impl AsRef<OsStr>) {
    if let Err(error) = open::that_detached(path) {
        complain("warning", &format!("no browser was started: {error}"));
    }
}
