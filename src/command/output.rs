//! Text for a terminal or a file: colour, and the exit status.

use std::fmt::Display;
use std::io::{ErrorKind, Write};

use clap::builder::styling::{AnsiColor, Style, Styles};

use crate::sim::{Integrator, Simulator};

/// Exit status of a successful command.
pub(super) const SUCCESS: u8 = 0;
/// Exit status of one that found a flaw.
pub(super) const FLAWED: u8 = 1;
/// Exit status of words or files that cannot be used; clap's own.
pub(super) const UNUSABLE: u8 = 2;

/// Colours of the help.
pub(super) const STYLES: Styles = Styles::styled()
    .header(HEADING)
    .usage(HEADING)
    .literal(AnsiColor::Cyan.on_default())
    .placeholder(Style::new().dimmed());

const HEADING: Style = AnsiColor::Green.on_default().bold();
const GOOD: Style = AnsiColor::Green.on_default();
const BAD: Style = AnsiColor::Red.on_default().bold();
const DOUBTFUL: Style = AnsiColor::Yellow.on_default();

/// Text that a subcommand prints, and its exit status.
#[derive(Debug)]
pub(super) struct Outcome {
    text: String,
    status: u8,
}

impl Outcome {
    pub(super) fn of(text: impl Display) -> Self {
        let mut text = text.to_string();
        if !text.is_empty() && !text.ends_with('\n') {
            text.push('\n');
        }
        Self {
            text,
            status: SUCCESS,
        }
    }

    /// The text, with the exit status of a flaw.
    pub(super) fn flawed_if(mut self, is_flawed: bool) -> Self {
        self.status = if is_flawed { FLAWED } else { SUCCESS };
        self
    }

    /// Prints it and returns the exit status. A reader that closed its end is not an error.
    pub(super) fn print(self) -> u8 {
        let mut out = anstream::stdout();
        match out
            .write_all(self.text.as_bytes())
            .and_then(|()| out.flush())
        {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                complain("error", &error.to_string());
                UNUSABLE
            }
            _ => self.status,
        }
    }
}

/// Writes a line to the standard error: `error: …`, `warning: …`, `note: …`.
pub(super) fn complain(kind: &str, text: &str) {
    let style = match kind {
        "error" => BAD,
        "warning" => DOUBTFUL,
        _ => HEADING,
    };
    // The standard error may be closed.
    let _ = writeln!(anstream::stderr(), "{style}{kind}:{style:#} {text}");
}

/// The time step and the integration method in words.
pub(super) fn method(simulator: &Simulator) -> String {
    let name = match simulator.integrator() {
        Integrator::SemiImplicitEuler => "semi-implicit Euler",
        Integrator::ImplicitVelocity => "implicit in velocity",
        Integrator::RungeKutta4 => "Runge-Kutta of order 4",
        Integrator::ImplicitMidpoint => "implicit midpoint",
    };
    format!("{}, {name}", seconds(simulator.time_step()))
}

/// A time without hundreds of digits.
pub(super) fn seconds(time: f64) -> String {
    match time {
        1e-6..1e6 => format!("{time} s"),
        _ => format!("{time:e} s"),
    }
}

pub(super) fn good(text: impl Display) -> String {
    format!("{GOOD}{text}{GOOD:#}")
}

pub(super) fn bad(text: impl Display) -> String {
    format!("{BAD}{text}{BAD:#}")
}

pub(super) fn doubtful(text: impl Display) -> String {
    format!("{DOUBTFUL}{text}{DOUBTFUL:#}")
}

pub(super) fn heading(text: impl Display) -> String {
    format!("{HEADING}{text}{HEADING:#}")
}
