//! The process that starts others, watches them, and reports the case at which one was lost.

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader};
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::findings::Findings;
use crate::options::Options;

/// Processor time of a case: more is a hang. Of unoptimised code, which runs the short run, more is to be expected.
const MAX_TIME: Duration = Duration::from_secs(if cfg!(debug_assertions) { 10 } else { 2 });

/// Time on the clock of a case, which only waits for a busy machine: more counts as a hang.
const MAX_WAIT: Duration = Duration::from_secs(60);

/// Interval between looks at a silent child.
const PERIOD: Duration = Duration::from_millis(100);

pub(crate) fn run(options: &Options) -> ExitCode {
    let findings = Mutex::new(Findings::new(options));
    thread::scope(|scope| {
        for job in 0..options.jobs {
            let findings = &findings;
            scope.spawn(move || {
                let watched = watch_all(options, job, findings);
                watched.unwrap_or_else(|error| panic!("a child cannot be run: {error}"));
            });
        }
    });
    let findings = findings
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner);
    ExitCode::from(u8::from(!findings.close()))
}

/// Runs the cases of a job, in as many processes as it takes.
fn watch_all(options: &Options, job: u64, findings: &Mutex<Findings>) -> io::Result<()> {
    let mut next = job;
    while next < options.executions {
        let mut watch = Watch::start(options, next)?;
        match watch.follow(findings) {
            None => return Ok(()),
            Some((kind, index, reason)) => {
                lock(findings).add(&kind, index, &reason);
                next = index + options.jobs;
            }
        }
    }
    Ok(())
}

fn lock(findings: &Mutex<Findings>) -> std::sync::MutexGuard<'_, Findings> {
    findings.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A child process and its work.
struct Watch {
    child: Child,
    lines: Receiver<String>,
    /// File of its standard error.
    log: std::path::PathBuf,
    kind: String,
    index: u64,
    start: Instant,
    /// Processor time when one first looked at the case.
    used: Option<Duration>,
}

impl Watch {
    fn start(options: &Options, from: u64) -> io::Result<Self> {
        let name = format!("dualbody-fuzz-{}-{from}.log", std::process::id());
        let log = std::env::temp_dir().join(name);
        let mut child = Command::new(std::env::current_exe()?)
            .args(options.for_child(from))
            .stdout(Stdio::piped())
            .stderr(File::create(&log)?)
            .spawn()?;
        let (sender, lines) = channel();
        let out = child
            .stdout
            .take()
            .ok_or_else(|| io::Error::other("no pipe"))?;
        thread::spawn(move || pass_on(BufReader::new(out), &sender));
        Ok(Self {
            child,
            lines,
            log,
            kind: String::new(),
            index: from,
            start: Instant::now(),
            used: None,
        })
    }

    /// Follows the child to its end; where it was lost, at which case and how.
    fn follow(&mut self, findings: &Mutex<Findings>) -> Option<(String, u64, String)> {
        loop {
            match self.lines.recv_timeout(PERIOD) {
                Ok(line) => self.take(&line, findings),
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) if self.hangs() => {
                    // It may have ended by itself in between.
                    let _ = self.child.kill();
                    let _ = self.child.wait();
                    let reason = format!("hang: more than {MAX_TIME:?}");
                    return Some((self.kind.clone(), self.index, reason));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
        let status = self.child.wait();
        match status {
            Ok(status) if status.success() => None,
            status => {
                let log = fs::read_to_string(&self.log).unwrap_or_default();
                let reason = format!("process lost, {status:?}: {}", log.trim());
                Some((self.kind.clone(), self.index, reason))
            }
        }
    }

    fn take(&mut self, line: &str, findings: &Mutex<Findings>) {
        let (mut findings, mut words) = (lock(findings), line.splitn(3, ' '));
        match (words.next(), words.next(), words.next()) {
            (Some("n"), Some(index), Some(kind)) => {
                self.index = index.parse().unwrap_or(self.index);
                if self.kind != kind {
                    self.kind = kind.into();
                }
                (self.start, self.used) = (Instant::now(), None);
                findings.executed(kind);
            }
            (Some("+"), ..) => findings.accepted(&self.kind),
            _ => findings.add(&self.kind, self.index, line.trim_start_matches("v ")),
        }
    }

    /// Whether the case takes too long. On a busy machine time passes in which the child does not run.
    fn hangs(&mut self) -> bool {
        let used = processor_time(self.child.id());
        let before = *self.used.get_or_insert(used.unwrap_or_default());
        let is_busy = used.is_some_and(|used| used - before > MAX_TIME);
        is_busy || self.start.elapsed() > MAX_WAIT
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        // A log that stays does no harm.
        let _ = fs::remove_file(&self.log);
    }
}

fn pass_on(lines: impl BufRead, to: &Sender<String>) {
    for line in lines.lines().map_while(Result::ok) {
        if to.send(line).is_err() {
            return;
        }
    }
}

/// Processor time that a process has used, where the system reports it, as Linux does.
fn processor_time(process: u32) -> Option<Duration> {
    /// Of a tick: 100 a second on every Linux.
    const TICK: Duration = Duration::from_millis(10);
    let text = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // After the name in brackets, which may hold spaces: the times are the 12th and the 13th number.
    let (_, numbers) = text.rsplit_once(')')?;
    let mut ticks = numbers.split_whitespace().skip(11).map(str::parse::<u32>);
    let (user, system) = (ticks.next()?.ok()?, ticks.next()?.ok()?);
    Some(TICK * (user + system))
}
