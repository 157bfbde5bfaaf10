//! Recordings as tables of comma-separated values [RFC 4180].
//!
//! One row a time: `time`, then for each robot q, v, contact state, activations, u and forces, then the series. Columns are named
//! as those of [`Rollout::write_csv`](crate::sim::Rollout::write_csv); with several robots each name starts with
//! `<robot>/`. An unknown value is an empty cell.
//!
//! A series whose name could be taken for a column of a robot, or by a spreadsheet for a formula, stands as
//! `series.<name>`, a robot of such a name as `robot.<name>`; so do names that start in this way themselves. A name
//! that occurs several times means its columns in their order.

use crate::nested::IntoNested;
use std::collections::{HashMap, VecDeque};
use std::iter::Peekable;
use std::path::Path;
use std::str::Chars;

use nalgebra::Vector3;

use super::files::{first_disorder, malformed, other_robots, read, write};
use super::recording::{Recording, Series};
use super::rows::Rows;
use super::track::{ForceTrack, Track, force_names};
use crate::error::RecordingError;
use crate::model::Model;
use crate::scalar::MapEach;
use crate::sim::write_cells;

/// Prefix added to the name of a series that could be mistaken.
const SERIES: &str = "series.";

/// Prefix added to the name of a robot that could be mistaken.
const ROBOT: &str = "robot.";

/// A cell that starts with one of these is a formula to spreadsheets.
const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];

impl Recording {
    /// Writes the recording as a table; see [`save_csv`](Self::save_csv).
    pub fn to_csv(&self) -> String {
        let names = self.robots.iter().nested(|track| self.own_columns(track));
        let series = self.series.iter();
        let series = series.map(|series| self.series_column(&series.name));
        let names = names.chain(series).map(|name| quoted(&name));
        let header: Vec<String> = std::iter::once("time".into()).chain(names).collect();
        let mut out = (header.join(",") + "\n").into_bytes();
        for (k, &time) in self.times.iter().enumerate() {
            let robots = self.robots.iter().nested(|track| track.row(k));
            let cells = robots.chain(self.series.iter().map(|series| series.values[k]));
            let cells = cells.map(|x| Some(x).filter(|x| !x.is_nan()));
            // Writing to memory cannot fail.
            let _ = write_cells(&mut out, time, cells);
        }
        String::from_utf8(out).unwrap_or_default()
    }

    /// Writes all values as a table of comma-separated values, one row for each time. Columns: `time`, `q.<joint>`, `v.<joint>`,
    /// `contact<k>`, `activation<k>`, `u.<input>` (`u<k>` where names of inputs are unknown), `f.<frame>.<axis>`, and the series. Numbers
    /// read back exactly. Makes the folder.
    ///
    /// A series is named `series.<name>` if its name could be confused with another column or with a formula of a spreadsheet.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save_csv(&self, path: impl AsRef<Path>) -> Result<(), RecordingError> {
        write(path.as_ref(), self.to_csv())
    }

    /// Reads a file of [`save_csv`](Self::save_csv): values only, without display settings. A simulation can continue from any of its states, see
    /// [`Track::state`].
    ///
    /// * `models` – the robots, in the order of the recording
    ///
    /// # Errors
    /// If the file cannot be read, is not such a table, or contains other robots: no robot is given, or a joint has no column.
    pub fn read_csv(path: impl AsRef<Path>, models: &[&Model]) -> Result<Self, RecordingError> {
        let path = path.as_ref();
        if models.is_empty() {
            return Err(other_robots(path, "no robot was given"));
        }
        let table = Table::read(path)?;
        let mut recording = Self::of_robots(models);
        let mut taken = table.taker(path);
        recording.times = taken.column("time")?;
        let prefixes = recording.robots.iter().map(|track| recording.prefix(track));
        let prefixes: Vec<_> = prefixes.collect();
        for (track, prefix) in recording.robots.iter_mut().zip(&prefixes) {
            let inputs = named_inputs(&table.names, prefix, &prefixes);
            fill(track, prefix, inputs, &mut taken)?;
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

    /// Prefix of the names of a robot's columns; empty where there is one robot only.
    pub(super) fn prefix(&self, track: &Track) -> String {
        match track.name.as_str() {
            _ if self.robots.len() == 1 => String::new(),
            name if name.starts_with(FORMULA) || name.starts_with(ROBOT) => {
                format!("{ROBOT}{name}/")
            }
            name => format!("{name}/"),
        }
    }

    /// The name of the column of a series.
    fn series_column(&self, name: &str) -> String {
        let prefixes = self.robots.iter().map(|track| self.prefix(track));
        let is_of_robot = |prefix: String| name.strip_prefix(&prefix).is_some_and(is_state);
        let is_mistaken = name == "time"
            || name.starts_with(FORMULA)
            || name.starts_with(SERIES)
            || prefixes.into_iter().any(is_of_robot);
        if is_mistaken {
            format!("{SERIES}{name}")
        } else {
            name.into()
        }
    }

    /// The names of a robot's columns.
    pub(super) fn own_columns(&self, track: &Track) -> Vec<String> {
        let prefix = self.prefix(track);
        let names = track.column_names().into_iter();
        names.map(|name| format!("{prefix}{name}")).collect()
    }
}

/// Whether a name could be that of a column of a robot.
fn is_state(name: &str) -> bool {
    let numbers = ["u", "contact", "activation"].map_each(|kind| name.strip_prefix(kind));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|c| c.is_ascii_digit());
    let is_numbered = numbers.into_iter().flatten().any(is_number);
    is_numbered
        || ["q.", "v.", "u.", "f."]
            .iter()
            .any(|kind| name.starts_with(kind))
}

/// The inputs of a robot, by the columns of a table.
///
/// * `prefixes` – of all robots: a name that starts with a longer one is not an input of this robot
fn named_inputs(columns: &[String], prefix: &str, prefixes: &[String]) -> Vec<String> {
    let is_other = |name: &str| {
        let mut longer = prefixes.iter().filter(|other| other.len() > prefix.len());
        longer.any(|other| name.starts_with(other.as_str()))
    };
    let own = columns.iter().filter(|name| !is_other(name));
    let input = own.filter_map(|name| name.strip_prefix(prefix)?.strip_prefix("u."));
    input.map(str::to_owned).collect()
}

/// Fills a robot that has no rows yet.
///
/// * `inputs` – what its inputs act on, if they are not numbered
fn fill(
    track: &mut Track,
    prefix: &str,
    inputs: Vec<String>,
    taken: &mut Taker<'_>,
) -> Result<(), RecordingError> {
    let names = track.state_names();
    let (q, v) = names.split_at(track.model.nq());
    track.q = taken.rows(prefix, q)?;
    track.v = taken.rows(prefix, v)?;
    track.contact = taken.numbered_rows(prefix, "contact")?;
    track.activation = taken.numbered_rows(prefix, "activation")?;
    track.sleep = Rows::from_columns(&[], track.q.length);
    track.u = taken.numbered_rows(prefix, "u")?;
    if track.u.width == 0 && !inputs.is_empty() {
        let names: Vec<_> = inputs.iter().map(|name| format!("u.{name}")).collect();
        track.u = taken.rows(prefix, &names)?;
        track.inputs = inputs;
    }
    for name in &taken.table.names {
        let Some(frame) = force_on(name, prefix).and_then(|frame| track.model.frame(frame)) else {
            continue;
        };
        let axes = force_names(track.frame_name(frame));
        if axes
            .iter()
            .all(|name| taken.has(&format!("{prefix}{name}")))
        {
            let rows = taken.rows(prefix, &axes)?;
            let values = rows.numbers.chunks_exact(3).map(Vector3::from_column_slice);
            let values = values.collect();
            track.forces.push(ForceTrack { frame, values });
        }
    }
    Ok(())
}

/// The frame of a column that is the first one of a force.
fn force_on<'a>(name: &'a str, prefix: &str) -> Option<&'a str> {
    let name = name.strip_prefix(prefix)?.strip_prefix("f.")?;
    name.strip_suffix(".x")
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
        let mut records = Records::new(&text);
        let names = records.next().map(|record| record.cells);
        let names = names.ok_or_else(|| malformed(path, 1, "is empty"))?;
        let mut table = Self {
            columns: vec![Vec::new(); names.len()],
            names,
            lines: Vec::new(),
        };
        for record in records {
            let line = record.line;
            table
                .add(record)
                .map_err(|why| malformed(path, line, why))?;
        }
        Ok(table)
    }

    /// Adds a row, or says why it is none.
    fn add(
        &mut self,
        Record {
            line,
            cells,
            is_open,
        }: Record,
    ) -> Result<(), String> {
        let (given, expected) = (cells.len(), self.names.len());
        if is_open {
            return Err("a quote is not closed".into());
        }
        if given != expected {
            return Err(format!("{given} cells under {expected} names"));
        }
        for ((cell, column), name) in cells.iter().zip(&mut self.columns).zip(&self.names) {
            let number = number(cell);
            column.push(number.ok_or_else(|| format!("{name}: \"{cell}\" is not a number"))?);
        }
        self.lines.push(line);
        Ok(())
    }

    fn taker<'a>(&'a self, path: &'a Path) -> Taker<'a> {
        let mut index: HashMap<&str, VecDeque<usize>> = HashMap::new();
        for (i, name) in self.names.iter().enumerate() {
            index.entry(name).or_default().push_back(i);
        }
        Taker {
            path,
            table: self,
            index,
        }
    }
}

/// Takes columns out of a table by name.
struct Taker<'a> {
    path: &'a Path,
    table: &'a Table,
    /// The columns of each name that are left.
    index: HashMap<&'a str, VecDeque<usize>>,
}

impl Taker<'_> {
    fn has(&self, name: &str) -> bool {
        self.index.get(name).is_some_and(|left| !left.is_empty())
    }

    fn column(&mut self, name: &str) -> Result<Vec<f64>, RecordingError> {
        let left = self.index.get_mut(name);
        let Some(i) = left.and_then(VecDeque::pop_front) else {
            let reason = format!("there is no column \"{name}\"");
            return Err(other_robots(self.path, reason));
        };
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

    /// The columns `<kind>0`, `<kind>1`, … as far as there are any.
    fn numbered_rows(&mut self, prefix: &str, kind: &str) -> Result<Rows, RecordingError> {
        let is_there = |name: &String| self.has(&format!("{prefix}{name}"));
        let names = (0..).map(|k| format!("{kind}{k}")).take_while(is_there);
        let names: Vec<_> = names.collect();
        self.rows(prefix, &names)
    }

    /// Series of the columns that nothing has taken.
    fn rest(self) -> Vec<Series> {
        let mut left: Vec<usize> = self.index.into_values().flatten().collect();
        left.sort_unstable();
        let series = left.into_iter().map(|i| {
            let name = &self.table.names[i];
            Series {
                name: name.strip_prefix(SERIES).unwrap_or(name).into(),
                values: self.table.columns[i].clone(),
            }
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

/// A line of a table; of several lines where a name has some.
struct Record {
    /// Number of the line on which it starts, from 1.
    line: usize,
    cells: Vec<String>,
    /// Whether it ends within quotes.
    is_open: bool,
}

/// Splits a text into records, in one pass. Empty lines are skipped.
struct Records<'a> {
    chars: Peekable<Chars<'a>>,
    /// The next line.
    line: usize,
}

impl<'a> Records<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            chars: text.chars().peekable(),
            line: 1,
        }
    }

    fn record(&mut self) -> Record {
        let (mut cells, mut cell, mut is_open) = (Vec::new(), String::new(), false);
        let line = self.line;
        while let Some(c) = self.chars.next() {
            self.line += usize::from(c == '\n');
            match c {
                '"' if is_open && self.chars.next_if_eq(&'"').is_some() => cell.push('"'),
                '"' => is_open = !is_open,
                ',' if !is_open => cells.push(std::mem::take(&mut cell)),
                '\n' if !is_open => break,
                '\r' if !is_open && self.chars.peek() == Some(&'\n') => {}
                c => cell.push(c),
            }
        }
        cells.push(cell);
        Record {
            line,
            cells,
            is_open,
        }
    }
}

impl Iterator for Records<'_> {
    type Item = Record;

    fn next(&mut self) -> Option<Record> {
        while self.chars.peek().is_some() {
            let record = self.record();
            let is_blank = |cells: &[String]| matches!(cells, [only] if only.trim().is_empty());
            if !is_blank(&record.cells) || record.is_open {
                return Some(record);
            }
        }
        None
    }
}
