//! `dualbody check`: what is wrong with a description, or will be in a simulation.

use std::error::Error;
use std::fmt::Write;

use clap::Args;

use super::output::{Outcome, bad, doubtful, good, heading, method};
use super::robot::Robot;
use super::setup::Setup;
use crate::sim::SimulatorRemark;

/// Check a description: unused content, physically inconsistent inertias, steps that are too long.
///
/// The exit status is 0 without flaws, 1 for a physically inconsistent inertia, a singular mass matrix, or a step that is too long, and 2 for a file
/// that cannot be loaded.
#[derive(Args, Debug)]
pub(super) struct Check {
    #[command(flatten)]
    robot: Robot,
    #[command(flatten)]
    setup: Setup,
    /// Count warnings about the file as flaws.
    #[arg(long)]
    strict: bool,
}

impl Check {
    pub(super) fn run(self) -> Result<Outcome, Box<dyn Error>> {
        let loaded = self.robot.load()?;
        let mut text = loaded.report.to_string();
        let mut is_flawed = self.strict && !loaded.report.warnings.is_empty();
        let flaws = loaded.model.inertia_flaws();
        section(
            &mut text,
            "inertias",
            flaws
                .iter()
                .map(|(link, flaw)| format!("link \"{link}\": {flaw}")),
        );
        is_flawed |= !flaws.is_empty();
        if let Err(error) = loaded.model.check_mass_matrix() {
            section(&mut text, "mass matrix", [error.to_string()].into_iter());
            return Ok(Outcome::of(text).flawed_if(true));
        }
        section(&mut text, "mass matrix", [].into_iter());
        let (simulator, start) = self.setup.simulation(&loaded)?;
        let remarks = simulator.remarks(start.q.as_slice());
        let title = format!("steps of {}", method(&simulator));
        section(
            &mut text,
            &title,
            remarks.iter().map(SimulatorRemark::to_string),
        );
        Ok(Outcome::of(text).flawed_if(is_flawed || !remarks.is_empty()))
    }
}

/// A title with what was found, or that nothing was.
fn section(text: &mut String, title: &str, found: impl ExactSizeIterator<Item = String>) {
    let title = heading(title);
    let verdict = match found.len() {
        0 => good("no flaw"),
        _ => bad("flawed"),
    };
    // Writing to a string does not fail.
    let _ = writeln!(text, "{title}: {verdict}");
    for flaw in found {
        let _ = writeln!(text, "  {}", doubtful(flaw));
    }
}
