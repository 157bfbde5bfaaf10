//! Results: as JSON, which is written whole after each row, and as a table at the end.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A value of a row.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Text(String),
    Number(f64),
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<usize> for Value {
    fn from(number: usize) -> Self {
        Self::Number(number as f64)
    }
}

/// Names and values of a row.
pub(crate) type Row = Vec<(&'static str, Value)>;

/// The report of a run, which ends in time.
pub(crate) struct Report {
    file: Option<PathBuf>,
    start: Instant,
    limit: Duration,
    rows: Vec<Row>,
    lines: Vec<String>,
    failed: Vec<String>,
    left_out: Vec<String>,
}

impl Report {
    pub(crate) fn new(file: Option<PathBuf>, seconds: f64) -> Self {
        Self {
            file,
            start: Instant::now(),
            limit: Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX),
            rows: Vec::new(),
            lines: Vec::new(),
            failed: Vec::new(),
            left_out: Vec::new(),
        }
    }

    /// Seconds since the beginning.
    pub(crate) fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Whether there is time for something, which is left out if not.
    ///
    /// * `share` – of the time of the run that may be over
    pub(crate) fn has_time(&mut self, share: f64, what: &str) -> bool {
        let is_in_time = self.start.elapsed() < self.limit.mul_f64(share);
        if !is_in_time {
            self.left_out.push(what.to_owned());
        }
        is_in_time
    }

    /// Adds a row, and its line of the table.
    pub(crate) fn add(&mut self, row: Row, line: String) {
        eprintln!("{:6.1} s  {line}", self.seconds());
        self.rows.push(row);
        self.lines.push(line);
        self.save();
    }

    /// Adds a row that goes into the JSON only.
    pub(crate) fn note(&mut self, row: Row) {
        self.rows.push(row);
        self.save();
    }

    /// Adds something that is wrong.
    pub(crate) fn fail(&mut self, what: String) {
        eprintln!("{:6.1} s  FAILED: {what}", self.seconds());
        self.failed.push(what);
        self.save();
    }

    /// Whether nothing is wrong.
    pub(crate) fn is_right(&self) -> bool {
        self.failed.is_empty()
    }

    /// Prints the table.
    pub(crate) fn print(&self) {
        for line in &self.lines {
            println!("{line}");
        }
        for what in &self.left_out {
            println!("left out, for the time was over: {what}");
        }
        for what in &self.failed {
            println!("FAILED: {what}");
        }
        let (rows, seconds) = (self.rows.len(), self.seconds());
        let failed = self.failed.len();
        println!("{rows} rows, {failed} failed, in {seconds:.0} s");
    }

    fn save(&self) {
        let Some(file) = &self.file else { return };
        if let Err(error) = fs::write(file, self.json()) {
            eprintln!("{}: {error}", file.display());
        }
    }

    fn json(&self) -> String {
        let rows: Vec<String> = self.rows.iter().map(object).collect();
        let texts = |all: &[String]| {
            let all: Vec<String> = all.iter().map(|text| quoted(text)).collect();
            all.join(",\n")
        };
        format!(
            "{{\"seconds\": {:.1},\n\"failed\": [{}],\n\"left_out\": [{}],\n\"rows\": [\n{}\n]}}\n",
            self.seconds(),
            texts(&self.failed),
            texts(&self.left_out),
            rows.join(",\n")
        )
    }
}

fn object(row: &Row) -> String {
    let fields: Vec<String> = row
        .iter()
        .map(|(name, value)| match value {
            Value::Text(text) => format!("\"{name}\": {}", quoted(text)),
            Value::Number(x) if x.is_finite() => format!("\"{name}\": {x}"),
            Value::Number(_) => format!("\"{name}\": null"),
        })
        .collect();
    format!("{{{}}}", fields.join(", "))
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => {
                // Writing to a string does not fail.
                let _ = write!(out, "\\u{:04x}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out + "\""
}

/// A number with the prefix of its thousands: `5.13 G`.
pub(crate) fn short(x: f64) -> String {
    let all = [(1e9, "G"), (1e6, "M"), (1e3, "k")];
    let found = all.iter().find(|(size, _)| x >= *size);
    let (size, prefix) = found.copied().unwrap_or((1.0, ""));
    let x = x / size;
    let digits = if x >= 100.0 {
        0
    } else if x >= 10.0 {
        1
    } else {
        2
    };
    format!("{x:.digits$} {prefix}")
}
