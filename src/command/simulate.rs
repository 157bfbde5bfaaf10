//! `dualbody simulate`: a motion, and its files.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::output::{Outcome, bad, complain, good, heading, method, seconds};
use super::robot::Robot;
use super::setup::{Setup, positive};
use super::view;
use crate::cone::Status;
use crate::contact::Contacts;
use crate::io::ImportReport;
use crate::sim::{Rollout, RolloutStatus, Simulator, SolverFailure, State};
use crate::view::{PictureOptions, Recording};

/// Most steps of a simulation, for which a bar can count.
const MOST_STEPS: f64 = 1e12;

/// Most pixels along a side of a picture: all that has so many can be drawn.
const MOST_PIXELS: u32 = 2048;

/// Simulate a robot and write its motion as a table, JSON, an HTML viewer or an animated picture.
///
/// The exit status is 1 if the motion diverges.
#[derive(Args, Debug)]
pub(super) struct Simulate {
    #[command(flatten)]
    robot: Robot,
    /// Duration, s.
    #[arg(long, short, default_value = "5", value_parser = positive, allow_negative_numbers = true)]
    duration: f64,
    #[command(flatten)]
    setup: Setup,
    /// Write a table with time, q, v and u of each step.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write a recording as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write an HTML viewer of the motion.
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    /// Write an animated picture, a GIF.
    #[arg(long, value_name = "FILE")]
    gif: Option<PathBuf>,
    /// Write a picture of the end, a PNG.
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Size of pictures, pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "640x480", value_parser = size)]
    size: [u32; 2],
    /// Open the HTML viewer in the browser.
    #[arg(long, requires = "page")]
    open: bool,
    /// Show no progress and no remarks.
    #[arg(long, short)]
    quiet: bool,
}

impl Simulate {
    pub(super) fn run(self) -> Result<Outcome, Box<dyn Error>> {
        let loaded = self.robot.load()?;
        let (simulator, start) = self.setup.simulation(&loaded)?;
        if !self.quiet {
            warn_of_file(&loaded.report);
            warn(&simulator, &start);
        }
        let began = Instant::now();
        let rollout = self.roll_out(&simulator, &start)?;
        let text = summary(&simulator, &rollout, began.elapsed().as_secs_f64());
        self.save(&Recording::of_simulation(&simulator, &rollout))?;
        let is_flawed =
            rollout.status != RolloutStatus::Completed || rollout.solver_failure.is_some();
        Ok(Outcome::of(text).flawed_if(is_flawed))
    }

    fn roll_out(&self, simulator: &Simulator, start: &State) -> Result<Rollout, Box<dyn Error>> {
        let steps = (self.duration / simulator.time_step()).round();
        if steps > MOST_STEPS {
            return Err(format!("{steps:.1e} steps, more than {MOST_STEPS:.0e}").into());
        }
        if steps < 1.0 {
            let [duration, step] = [self.duration, simulator.time_step()].map(seconds);
            return Err(format!("a duration of {duration} has no step of {step}").into());
        }
        let targets = match self.setup.holds() {
            true => simulator.holding_targets(start),
            false => vec![0.0; simulator.nu()],
        };
        let bar = self.bar(steps as u64);
        let rollout = simulator.rollout(start, steps as usize, |_, _, u| {
            u.copy_from_slice(&targets);
            bar.inc(1);
        });
        bar.finish_and_clear();
        Ok(rollout)
    }

    /// A bar on the standard error, where that is a terminal.
    fn bar(&self, steps: u64) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("{bar:40.green} {pos}/{len} steps, {eta} left");
        let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::new(steps).with_style(style)
    }

    fn save(&self, recording: &Recording) -> Result<(), Box<dyn Error>> {
        if let Some(path) = &self.csv {
            recording.save_csv(path)?;
        }
        if let Some(path) = &self.json {
            recording.save_json(path)?;
        }
        let [width, height] = self.size;
        let options = PictureOptions {
            width,
            height,
            ..PictureOptions::default()
        };
        if let Some(path) = &self.gif {
            recording.save_gif(path, options)?;
        }
        if let Some(path) = &self.png {
            recording.save_png(path, f64::INFINITY, options)?;
        }
        if let Some(path) = &self.page {
            recording.save_html(path)?;
            if self.open {
                view::open(path);
            }
        }
        Ok(())
    }
}

/// Reads the size of a picture, at most [`MOST_PIXELS`] along each side.
fn size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once('x').ok_or("expected WIDTHxHEIGHT")?;
    let side = |text: &str| match text.parse() {
        Ok(n) if (1..=MOST_PIXELS).contains(&n) => Ok(n),
        _ => Err(format!(
            "\"{text}\" is not a number from 1 to {MOST_PIXELS}"
        )),
    };
    Ok([side(width)?, side(height)?])
}

/// Warns of content of the file that has no effect.
fn warn_of_file(report: &ImportReport) {
    let count = report.ignored.len();
    if count > 0 {
        let part = if count == 1 { "part" } else { "parts" };
        let what = format!("{count} {part} of the file not used: `dualbody check` names them");
        complain("warning", &what);
    }
}

/// Warns of steps that are too long, and of meshes that cannot touch the ground.
fn warn(simulator: &Simulator, start: &State) {
    let remarks = simulator.remarks(start.q.as_slice());
    let of_meshes = simulator.contacts().map_or(&[][..], Contacts::mesh_remarks);
    let all = remarks
        .iter()
        .map(ToString::to_string)
        .chain(of_meshes.iter().cloned());
    all.for_each(|remark| complain("warning", &remark));
}

/// Status and computing time of the motion.
fn summary(simulator: &Simulator, rollout: &Rollout, elapsed: f64) -> String {
    let steps = rollout.states.len() - 1;
    let simulated = steps as f64 * rollout.time_step;
    let name = match simulator.model().name() {
        "" => "the model",
        name => name,
    };
    let mut out = format!(
        "{}: {}\n{steps} steps of {}: {simulated:.4} s in {elapsed:.3} s, {:.1} times real time\n",
        heading(name),
        status(rollout.status),
        method(simulator),
        simulated / elapsed.max(f64::MIN_POSITIVE),
    );
    if let Some(failure) = &rollout.solver_failure {
        out += &format!("{}\n", bad(reason(failure)));
    }
    let fastest = rollout
        .last()
        .v
        .iter()
        .fold(0.0_f64, |most, v| v.abs().max(most));
    out += &format!("largest velocity at the end: {fastest:.4} rad/s or m/s\n");
    out
}

fn status(of: RolloutStatus) -> String {
    match of {
        RolloutStatus::Completed => good("completed"),
        RolloutStatus::NonFiniteInput { step } => {
            bad(format!("stopped at step {step}: an input is not finite"))
        }
        RolloutStatus::Diverged { step } => bad(format!("diverged in step {step}")),
        RolloutStatus::OutOfMemory { step } => {
            bad(format!("stopped at step {step}: the limit of memory"))
        }
    }
}

fn reason(failure: &SolverFailure) -> String {
    let reason = match failure.status {
        Status::Regularized => "constraints contradict each other, or bodies are squeezed",
        Status::NotFinite => "a number is not finite",
        _ => "too many iterations",
    };
    format!(
        "step {} is the first without exact forces of contact and constraints: {reason}; the motion follows the best forces found",
        failure.step
    )
}
