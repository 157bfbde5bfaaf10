//! Findings by class, with the first files of each.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::input::Case;
use crate::options::Options;
use crate::seeds::Seeds;

/// Files that are kept of a class.
const MAX_FILES: usize = 3;

/// Where they are kept.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/out/fuzz");

/// Interval between reports of progress.
const INTERVAL: Duration = Duration::from_secs(30);

/// All reports of the children of a run.
pub(crate) struct Findings {
    options: Options,
    seeds: Seeds,
    start: Instant,
    next_line: Instant,
    kinds: BTreeMap<String, Count>,
    classes: BTreeMap<String, Vec<u64>>,
}

#[derive(Default)]
struct Count {
    executed: u64,
    accepted: u64,
}

impl Findings {
    pub(crate) fn new(options: &Options) -> Self {
        let start = Instant::now();
        Self {
            options: options.clone(),
            seeds: Seeds::new(),
            start,
            next_line: start + INTERVAL,
            kinds: BTreeMap::new(),
            classes: BTreeMap::new(),
        }
    }

    pub(crate) fn executed(&mut self, kind: &str) {
        self.kinds.entry(kind.into()).or_default().executed += 1;
        if Instant::now() > self.next_line {
            self.next_line += INTERVAL;
            println!("{}", self.summary());
        }
    }

    pub(crate) fn accepted(&mut self, kind: &str) {
        self.kinds.entry(kind.into()).or_default().accepted += 1;
    }

    /// Notes something that does not hold at a case, and keeps its file if it is one of the first of its class.
    pub(crate) fn add(&mut self, kind: &str, index: u64, reason: &str) {
        let class = class(kind, reason);
        let cases = self.classes.entry(class).or_default();
        cases.push(index);
        if cases.len() > MAX_FILES {
            return;
        }
        let case = Case::new(&self.seeds, &self.options.kinds, self.options.seed, index);
        let path = PathBuf::from(FOLDER).join(format!("{}-{index}.{kind}", self.options.seed));
        let kept = fs::create_dir_all(FOLDER)
            .and_then(|()| fs::write(&path, &case.bytes))
            .and_then(|()| fs::write(path.with_extension("txt"), reason));
        println!("case {index}: {reason}\n  {} {kept:?}", path.display());
    }

    /// Prints everything; `true` if nothing was found.
    pub(crate) fn close(&self) -> bool {
        println!("{}", self.summary());
        for (kind, count) in &self.kinds {
            println!(
                "  {kind}: {} executions, {} accepted",
                count.executed, count.accepted
            );
        }
        for (class, cases) in &self.classes {
            println!("  {} × {class}", cases.len());
        }
        self.classes.is_empty()
    }

    fn summary(&self) -> String {
        let executed: u64 = self.kinds.values().map(|count| count.executed).sum();
        let found: usize = self.classes.values().map(Vec::len).sum();
        let seconds = self.start.elapsed().as_secs_f64();
        let rate = executed as f64 / seconds;
        format!(
            "{executed} executions in {seconds:.0} s ({rate:.0} a second), {found} found in {} classes",
            self.classes.len()
        )
    }
}

/// A reason without the parts that differ from case to case.
fn class(kind: &str, reason: &str) -> String {
    const LENGTH: usize = 90;
    let mut out = format!("{kind}: ");
    for c in reason.chars().take(LENGTH) {
        match c {
            '0'..='9' if out.ends_with('#') => {}
            '0'..='9' => out.push('#'),
            c => out.push(c),
        }
    }
    out
}
