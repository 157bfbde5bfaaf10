//! Recordings as tables of comma-separated values (RFC 4180).
//!
//! One row a time: `time`, then for each robot q, v, u and forces, then the series. Columns are named as those of
//! [`Rollout::write_csv`](crate::sim::Rollout::write_csv); with several robots each name starts with `<robot>/`. What is unknown is
//! an empty cell.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;

use nalgebra::Vector3;

use super::files::{first_disorder, malformed, other_robots, read, write};
use super::recording::{Recording, Series};
use super::track::{ForceTrack, Rows, Track};
use crate::error::RecordingError;
use crate::model::{FrameId, Model};

impl Recording {
    /// The recording as a table; see [`save_csv`](Self::save_csv).
    pub fn to_csv(&self) -> String {
        let mut out = "time".to_owned();
        let names = self.robots.iter().flat_map(|track| self.own_columns(track));
        let series = self.series.iter().map(|series| series.name.clone());
        for name in names.chain(series) {
            out.push(',');
            out.push_str(&quoted(&name));
        }
        for (k, time) in self.times.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(out, "\n{time}");
            let robots = self.robots.iter().flat_map(|track| track.row(k));
            for x in robots.chain(self.series.iter().map(|series| series.values[k])) {
                out.push(',');
                if !x.is_nan() {
                    let _ = write!(out, "{x}");
                }
            }
        }
        out.push('\n');
        out
    }

    /// Writes all numbers as a table of comma-separated values: one row a time; `time`, `q.<joint>`, `v.<joint>`, `u<k>`,
    /// `f.<frame>.<axis>`, and the series. Numbers read back exactly. Makes the folder.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save_csv(&self, path: impl AsRef<Path>) -> Result<(), RecordingError> {
        write(path.as_ref(), self.to_csv())
    }

    /// Reads what [`save_csv`](Self::save_csv) wrote: the numbers, not what of the robots is to be traced or shown.
    ///
    /// * `models` – the robots, in the order of the recording
    ///
    /// # Errors
    /// If the file cannot be read, is no such table, or holds other robots.
    ///
    /// # Panics
    /// If there is no robot.
    pub fn read_csv(path: impl AsRef<Path>, models: &[&Model]) -> Result<Self, RecordingError> {
        let path = path.as_ref();
        let table = Table::read(path)?;
        let mut recording = Self::of_robots(models);
        let mut taken = table.taker(path);
        recording.times = taken.column("time")?;
        for i in 0..recording.robots.len() {
            let prefix = recording.prefix(&recording.robots[i]);
            fill(&mut recording.robots[i], &prefix, &mut taken)?;
        }
        recording.series = taken.rest();
        match first_disorder(&recording.times) {
            None => Ok(recording),
            Some(k) => {
                let reason = "the time is missing or not after the one before";
                Err(malformed(path, table.lines[k], reason))
            }
        }
    }

    /// What the names of a robot's columns start with.
    pub(super) fn prefix(&self, track: &Track) -> String {
        if self.robots.len() == 1 {
            String::new()
        } else {
            format!("{}/", track.name)
        }
    }

    /// The names of a robot's columns.
    pub(super) fn own_columns(&self, track: &Track) -> Vec<String> {
        let prefix = self.prefix(track);
        let names = track.column_names().into_iter();
        names.map(|name| format!("{prefix}{name}")).collect()
    }
}

/// Fills a robot that has no rows yet.
fn fill(track: &mut Track, prefix: &str, taken: &mut Taker<'_>) -> Result<(), RecordingError> {
    let names = track.column_names();
    let (q, v) = names.split_at(track.model.nq());
    let is_there = |name: &String| taken.has(&format!("{prefix}{name}"));
    let inputs = (0..).map(|k| format!("u{k}")).take_while(is_there);
    let inputs: Vec<_> = inputs.collect();
    track.q = taken.rows(prefix, q)?;
    track.v = taken.rows(prefix, v)?;
    track.u = taken.rows(prefix, &inputs)?;
    for (frame, id) in track.model.frame_names().into_iter().zip(0..) {
        let of = |axis: &str| format!("f.{frame}.{axis}");
        let axes = ["x", "y", "z"].map(of);
        if axes
            .iter()
            .all(|name| taken.has(&format!("{prefix}{name}")))
        {
            let rows = taken.rows(prefix, &axes)?;
            let values = rows.numbers.chunks_exact(3).map(Vector3::from_column_slice);
            track.forces.push(ForceTrack {
                frame: FrameId(id),
                values: values.collect(),
            });
        }
    }
    Ok(())
}

/// A name as a cell.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.into()
    }
}

/// A table of numbers with the names of its columns.
struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
    /// The line on which each row starts.
    lines: Vec<usize>,
}

impl Table {
    fn read(path: &Path) -> Result<Self, RecordingError> {
        let text = read(path)?;
        let mut records = records(&text);
        let (_, names) = records
            .next()
            .ok_or_else(|| malformed(path, 1, "is empty"))?;
        let (mut columns, mut lines) = (vec![Vec::new(); names.len()], Vec::new());
        for (line, cells) in records {
            if cells.len() != names.len() {
                let (given, expected) = (cells.len(), names.len());
                let reason = format!("{given} cells under {expected} names");
                return Err(malformed(path, line, reason));
            }
            for ((cell, column), name) in cells.iter().zip(&mut columns).zip(&names) {
                let number = number(cell).ok_or_else(|| {
                    malformed(path, line, format!("{name}: \"{cell}\" is no number"))
                })?;
                column.push(number);
            }
            lines.push(line);
        }
        Ok(Self {
            names,
            columns,
            lines,
        })
    }

    fn taker<'a>(&'a self, path: &'a Path) -> Taker<'a> {
        let names = self.names.iter().map(String::as_str);
        Taker {
            path,
            table: self,
            // The first column of a name is the robot's; further ones are series that happen to be called so.
            index: names.rev().zip((0..self.names.len()).rev()).collect(),
            left: vec![true; self.names.len()],
        }
    }
}

/// Takes columns out of a table by name.
struct Taker<'a> {
    path: &'a Path,
    table: &'a Table,
    index: HashMap<&'a str, usize>,
    left: Vec<bool>,
}

impl Taker<'_> {
    fn has(&self, name: &str) -> bool {
        self.index.get(name).is_some_and(|&i| self.left[i])
    }

    fn column(&mut self, name: &str) -> Result<Vec<f64>, RecordingError> {
        if !self.has(name) {
            return Err(other_robots(
                self.path,
                format!("there is no column \"{name}\""),
            ));
        }
        let i = self.index[name];
        self.left[i] = false;
        Ok(self.table.columns[i].clone())
    }

    fn rows(&mut self, prefix: &str, names: &[String]) -> Result<Rows, RecordingError> {
        let columns = names
            .iter()
            .map(|name| self.column(&format!("{prefix}{name}")));
        let columns = columns.collect::<Result<Vec<_>, _>>()?;
        let columns: Vec<_> = columns.iter().map(Vec::as_slice).collect();
        Ok(Rows::from_columns(&columns, self.table.lines.len()))
    }

    /// What nothing has taken.
    fn rest(self) -> Vec<Series> {
        let columns = self.table.names.iter().zip(&self.table.columns);
        let left = columns.zip(self.left).filter(|(_, left)| *left);
        let series = left.map(|((name, values), _)| Series {
            name: name.clone(),
            values: values.clone(),
        });
        series.collect()
    }
}

/// A cell; an empty one is unknown.
fn number(cell: &str) -> Option<f64> {
    match cell.trim() {
        "" => Some(f64::NAN),
        cell => cell.parse().ok(),
    }
}

/// Splits a text into records of cells, each with the line on which it starts, from 1. Empty lines are no records.
fn records(text: &str) -> impl Iterator<Item = (usize, Vec<String>)> + '_ {
    let mut lines = text.lines().zip(1..);
    std::iter::from_fn(move || {
        let (first, number) = lines.find(|(line, _)| !line.trim().is_empty())?;
        let mut record = first.to_owned();
        // A quote that is open goes on on the next line.
        while record.matches('"').count() % 2 == 1 {
            let Some((line, _)) = lines.next() else { break };
            record.push('\n');
            record.push_str(line);
        }
        Some((number, cells(&record)))
    })
}

fn cells(record: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let (mut is_quoted, mut chars) = (false, record.chars().peekable());
    while let Some(c) = chars.next() {
        let cell = cells.last_mut();
        match (c, cell) {
            ('"', Some(cell)) if is_quoted && chars.peek() == Some(&'"') => {
                chars.next();
                cell.push('"');
            }
            ('"', _) => is_quoted = !is_quoted,
            (',', _) if !is_quoted => cells.push(String::new()),
            (c, Some(cell)) => cell.push(c),
            (_, None) => {}
        }
    }
    cells
}
