//! What the examples of trajectory optimisation share: a progress bar, and files for a trajectory.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, IsTerminal};

use dualbody::sim::{Rollout, RolloutStatus};
use dualbody::trajopt::{Progress, Robot, ShootingProgress, Trajectory};
use dualbody::view::Recording;
use dualbody::{Model, Simulator};
use indicatif::{ProgressBar, ProgressStyle};

/// What a bar shows of an iteration.
pub(crate) trait Iteration {
    fn number(&self) -> usize;
    fn message(&self) -> String;
}

impl Iteration for Progress {
    fn number(&self) -> usize {
        self.iteration
    }

    fn message(&self) -> String {
        format!(
            "cost {:.6}  step {:.3}  regularisation {:.0e}  violation {:.1e}",
            self.cost, self.step, self.regularization, self.violation
        )
    }
}

impl Iteration for ShootingProgress {
    fn number(&self) -> usize {
        self.iteration
    }

    fn message(&self) -> String {
        format!(
            "cost {:.6}  step {:.1e}  gradient {:.1e}  violation {:.1e}",
            self.cost, self.step, self.gradient, self.violation
        )
    }
}

/// A bar with cost, step and violation, where the output is a terminal; nothing elsewhere.
pub(crate) fn progress_bar<I: Iteration>(iterations: usize) -> impl FnMut(&I) {
    let bar = match std::io::stderr().is_terminal() {
        true => ProgressBar::new(iterations as u64),
        false => ProgressBar::hidden(),
    };
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len}  {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    move |progress: &I| {
        bar.set_position(progress.number() as u64);
        bar.set_message(progress.message());
    }
}

/// Writes a plan to `out/<name>/plan.csv` and its page beside it.
///
/// * `traced` – frame whose path the page draws
pub(crate) fn save(
    name: &str,
    simulator: &Simulator,
    plan: &Trajectory,
    traced: &str,
) -> Result<(), Box<dyn Error>> {
    let (folder, time_step) = (format!("out/{name}"), simulator.time_step());
    std::fs::create_dir_all(&folder)?;
    let file = File::create(format!("{folder}/plan.csv"))?;
    plan.write_csv(time_step, BufWriter::new(file))?;
    let states = plan.states.iter().map(|x| simulator.unpack(x.as_slice()));
    let motion = Rollout {
        time_step,
        states: states.collect(),
        inputs: plan.inputs.clone(),
        status: RolloutStatus::Completed,
    };
    save_page(name, simulator.model(), &motion, traced)
}

/// Writes the page of a motion to `out/<name>/index.html`.
pub(crate) fn save_page(
    name: &str,
    model: &Model,
    motion: &Rollout,
    traced: &str,
) -> Result<(), Box<dyn Error>> {
    let mut recording = Recording::from_rollout(model, motion).with_title(name.replace('_', " "));
    recording.robot_mut(0).trace(traced)?;
    Ok(recording.save_html(format!("out/{name}/index.html"))?)
}
