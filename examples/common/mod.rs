//! What the examples of trajectory optimisation share: a progress bar, and a file for a trajectory.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, IsTerminal};

use dualbody::trajopt::{Progress, Trajectory};
use indicatif::{ProgressBar, ProgressStyle};

/// A bar with cost, step, regularisation and violation, where the output is a terminal; nothing elsewhere.
pub(crate) fn progress_bar(iterations: usize) -> impl FnMut(&Progress) {
    let bar = match std::io::stderr().is_terminal() {
        true => ProgressBar::new(iterations as u64),
        false => ProgressBar::hidden(),
    };
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len}  {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    move |progress| {
        bar.set_position(progress.iteration as u64);
        bar.set_message(format!(
            "cost {:.6}  step {:.3}  regularisation {:.0e}  violation {:.1e}",
            progress.cost, progress.step, progress.regularization, progress.violation
        ));
    }
}

/// Writes `out/<name>/<what>.csv`.
pub(crate) fn save(
    name: &str,
    what: &str,
    time_step: f64,
    plan: &Trajectory,
) -> Result<(), Box<dyn Error>> {
    let folder = format!("out/{name}");
    std::fs::create_dir_all(&folder)?;
    let file = File::create(format!("{folder}/{what}.csv"))?;
    Ok(plan.write_csv(time_step, BufWriter::new(file))?)
}
