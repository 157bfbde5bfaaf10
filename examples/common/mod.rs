//! Helpers of the examples of trajectory optimisation: a progress bar, and files for a trajectory.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, IsTerminal};

use dualbody::sim::Rollout;
use dualbody::trajopt::{Progress, Robot, Trajectory};
use dualbody::view::Recording;
use dualbody::{Model, Simulator};
use indicatif::{ProgressBar, ProgressStyle};

/// A bar with cost, step and violation, where the output is a terminal; nothing elsewhere.
pub(crate) fn progress_bar(iterations: usize) -> impl FnMut(&Progress) {
    let bar = match std::io::stderr().is_terminal() {
        true => ProgressBar::new(iterations as u64),
        false => ProgressBar::hidden(),
    };
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len}  {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    move |progress: &Progress| {
        bar.set_position(progress.iteration as u64);
        bar.set_message(message(progress));
    }
}

fn message(progress: &Progress) -> String {
    let (cost, step, violation) = (progress.cost, progress.step, progress.violation);
    let regularization = progress
        .regularization
        .map(|of| format!("  regularisation {of:.0e}"));
    let gradient = progress.gradient.map(|of| format!("  gradient {of:.1e}"));
    let more = regularization.or(gradient).unwrap_or_default();
    format!("cost {cost:.6}  step {step:.1e}{more}  violation {violation:.1e}")
}

/// Writes a plan to `out/<name>/plan.csv`; gives its motion, for a page.
///
/// * `traced` – frame whose path the page draws
#[allow(
    dead_code,
    reason = "a controller that plans as it goes has no plan to save"
)]
pub(crate) fn save_plan(
    name: &str,
    simulator: &Simulator,
    plan: &Trajectory,
    traced: &str,
) -> Result<Recording, Box<dyn Error>> {
    let time_step = simulator.time_step();
    plan.write_csv(time_step, create(name, "plan.csv")?)?;
    let states = plan.states.iter().map(|x| simulator.unpack(x.as_slice()));
    let (model, inputs) = (simulator.model(), plan.inputs.clone());
    let mut motion = Rollout::new(model, time_step, states.collect(), inputs);
    motion.input_names = simulator.input_names();
    record(name, model, &motion, traced)
}

/// A motion for a page.
///
/// * `traced` – frame whose path the page draws
pub(crate) fn record(
    name: &str,
    model: &Model,
    motion: &Rollout,
    traced: &str,
) -> Result<Recording, Box<dyn Error>> {
    let mut recording = Recording::from_rollout(model, motion).with_title(name.replace('_', " "));
    recording.robot_mut(0).trace(traced)?;
    Ok(recording)
}

/// Writes the page of a motion to `out/<name>/index.html`.
pub(crate) fn save_page(name: &str, recording: &Recording) -> Result<(), Box<dyn Error>> {
    Ok(recording.save_html(format!("out/{name}/index.html"))?)
}

/// A file in `out/<name>/`.
pub(crate) fn create(name: &str, file: &str) -> Result<BufWriter<File>, Box<dyn Error>> {
    std::fs::create_dir_all(format!("out/{name}"))?;
    Ok(BufWriter::new(File::create(format!("out/{name}/{file}"))?))
}
