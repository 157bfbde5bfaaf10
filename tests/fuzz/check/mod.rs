//! Properties that every file must have. A check returns whether the file was accepted, or the property that fails.

mod description;
mod mesh;
mod pair;
mod recording;

use std::path::{Path, PathBuf};

use crate::input::{Case, Kind};

/// Bytes that a message may have, beside the lists that a report cuts.
const MAX_MESSAGE: usize = 20_000;

/// Data shared by all checks: made once, so that the cost of a case is that of its own file.
pub(crate) struct Checks {
    recordings: recording::Recordings,
    meshes: mesh::Meshes,
    folder: Folder,
}

/// A folder for the files of a process, in memory where the system has such.
struct Folder(PathBuf);

impl Checks {
    pub(crate) fn new() -> Self {
        let memory = Path::new("/dev/shm");
        let parent = if memory.is_dir() {
            memory.into()
        } else {
            std::env::temp_dir()
        };
        let folder = Folder(parent.join(format!("dualbody-fuzz-{}", std::process::id())));
        std::fs::create_dir_all(&folder.0).unwrap_or_else(|error| panic!("{error}"));
        Self {
            recordings: recording::Recordings::new(),
            meshes: mesh::Meshes::new(&folder.0),
            folder,
        }
    }

    /// Whether the file was accepted; an error is the property that fails.
    pub(crate) fn run(&self, case: &Case) -> Result<bool, String> {
        match case.kind {
            Kind::Urdf | Kind::Sdf | Kind::Mjcf => description::check(case),
            Kind::Csv | Kind::Json => self.recordings.check(case, &self.folder.0),
            Kind::Pairs => pair::check(case),
            Kind::Stl | Kind::Obj | Kind::Dae | Kind::Msh => {
                self.meshes.check(case, &self.folder.0)
            }
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that cannot be removed must not hide a finding.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A message names its source, is short, and steers nothing that shows it.
fn check_message(text: &str, source: &str) -> Result<(), String> {
    if !text.contains(source) {
        return Err(format!("message does not name its source: {text:?}"));
    }
    check_text(text)
}

/// Text from outside has no control characters.
fn check_characters(text: &str) -> Result<(), String> {
    if text.chars().any(|c| c.is_control() && c != '\n') {
        return Err(format!("text with control characters: {:?}", head(text)));
    }
    Ok(())
}

fn check_text(text: &str) -> Result<(), String> {
    check_characters(text)?;
    if text.len() > MAX_MESSAGE {
        return Err(format!(
            "message too long, {} bytes: {:?}",
            text.len(),
            head(text)
        ));
    }
    Ok(())
}

/// The start of a text.
fn head(text: &str) -> String {
    const LENGTH: usize = 300;
    text.chars().take(LENGTH).collect()
}

/// The data of a page is JSON.
fn check_page(page: &str) -> Result<(), String> {
    let start = "id=\"data\">";
    let data = page
        .split_once(start)
        .and_then(|(_, rest)| rest.split_once("</script>"));
    let (data, _) = data.ok_or("page without data")?;
    let data: Result<serde::de::IgnoredAny, _> = serde_json::from_str(data);
    data.map(drop)
        .map_err(|error| format!("data of the page: {error}"))
}
