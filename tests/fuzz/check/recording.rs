//! Recordings: a file that is read is written and read back as the same file.

use std::fs;
use std::path::Path;

use dualbody::view::Recording;
use dualbody::{Model, RecordingError};

use super::{check_message, check_page};
use crate::input::{Case, Kind};
use crate::seeds::recorded_models;

/// Pages are made of every so many recordings: they cost most.
const PAGES: usize = 8;

/// The robots of each seed.
pub(super) struct Recordings(Vec<Vec<Model>>);

impl Recordings {
    pub(super) fn new() -> Self {
        Self(recorded_models().into())
    }

    pub(super) fn check(&self, case: &Case, folder: &Path) -> Result<bool, String> {
        let models: Vec<&Model> = self.0[case.seed].iter().collect();
        let file = folder.join(format!("case.{}", case.kind.name()));
        let recording = match read(case.kind, &file, &case.bytes, &models)? {
            Ok(recording) => recording,
            Err(error) => {
                check_message(&error.to_string(), &file.display().to_string())?;
                return Ok(false);
            }
        };
        for (kind, write) in [
            (Kind::Csv, Recording::to_csv as fn(&Recording) -> String),
            (Kind::Json, Recording::to_json),
        ] {
            // Tables name robots as recordings do from the start; JSON may name them as it likes.
            if kind != case.kind && names(&recording) != names(&Recording::of_robots(&models)) {
                continue;
            }
            let text = write(&recording);
            let file = folder.join(format!("again.{}", kind.name()));
            let again = read(kind, &file, text.as_bytes(), &models)?;
            let again = again.map_err(|error| format!("written and not read back: {error}"))?;
            if write(&again) != text {
                return Err(format!("{} written, read and written differs", kind.name()));
            }
        }
        if case.bytes.len().is_multiple_of(PAGES) {
            check_page(&recording.to_html())?;
        }
        Ok(true)
    }
}

/// The names of the robots.
fn names(recording: &Recording) -> Vec<&str> {
    recording
        .robots()
        .iter()
        .map(|track| track.name())
        .collect()
}

/// Reads bytes as a file.
fn read(
    kind: Kind,
    file: &Path,
    bytes: &[u8],
    models: &[&Model],
) -> Result<Result<Recording, RecordingError>, String> {
    fs::write(file, bytes).map_err(|error| error.to_string())?;
    Ok(match kind {
        Kind::Csv => Recording::read_csv(file, models),
        _ => Recording::read_json(file, models),
    })
}
