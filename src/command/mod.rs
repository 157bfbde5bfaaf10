//! The program `dualbody`: checks, shows, simulates and converts robots in a terminal.
//!
//! `cargo install --path . --features cli` installs it; `python -m dualbody` is the same program.
//!
//! | command | result |
//! |---|---|
//! | `dualbody check FILE` | unused content of the file, physically inconsistent inertias, steps that are too long |
//! | `dualbody info FILE` | the tree, masses and limits, also as JSON |
//! | `dualbody view FILE` | an HTML viewer with a slider for each joint, opened in the browser |
//! | `dualbody live FILE` | a running simulation in the browser: pull bodies with the mouse, move joints by sliders |
//! | `dualbody simulate FILE` | a motion as a table, JSON, an HTML viewer or an animated picture |
//! | `dualbody convert FROM TO` | the robot in another format, and a list of lost content |
//! | `dualbody bench FILE` | times of the dynamics, the step and its Jacobians on this machine |
//! | `dualbody completions SHELL` | completions of these commands for a shell |
//!
//! Results are written to the standard output, remarks and progress to the standard error, in colour on a terminal. The exit status is 0; 1 if
//! `check` or `simulate` finds a flaw; 2 for invalid arguments or files.

mod bench;
mod check;
mod contents;
mod convert;
mod info;
mod live;
mod output;
mod robot;
mod setup;
mod simulate;
mod view;

use std::error::Error;
use std::ffi::OsString;

use clap::{CommandFactory, Parser, Subcommand};

use output::{Outcome, SUCCESS, UNUSABLE};

/// Differentiable multibody dynamics: checks, shows, simulates and converts robots.
#[derive(Debug, Parser)]
#[command(name = "dualbody", version, arg_required_else_help = true, styles = output::STYLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Check(check::Check),
    Info(info::Info),
    View(view::View),
    Live(live::Live),
    Simulate(simulate::Simulate),
    Convert(convert::Convert),
    Bench(bench::Bench),
    /// Print completions of the subcommands and options for a shell.
    Completions {
        shell: clap_complete::Shell,
    },
}

/// Runs the program with the arguments of a process (the first is the program name) and returns its exit status.
///
/// # Examples
/// ```
/// use dualbody::command::run;
///
/// assert_eq!(run(["dualbody", "check", "assets/cartpole.urdf"]), 0);
/// assert_eq!(run(["dualbody", "check", "assets/no_such_file.urdf"]), 2);
/// ```
pub fn run<A: Into<OsString> + Clone>(arguments: impl IntoIterator<Item = A>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Nothing can be done where even this cannot be written.
            let _ = error.print();
            return if error.use_stderr() {
                UNUSABLE
            } else {
                SUCCESS
            };
        }
    };
    match execute(cli.command) {
        Ok(outcome) => outcome.print(),
        Err(error) => {
            output::complain("error", &error.to_string());
            UNUSABLE
        }
    }
}

fn execute(command: Command) -> Result<Outcome, Box<dyn Error>> {
    match command {
        Command::Check(check) => check.run(),
        Command::Info(info) => info.run(),
        Command::View(view) => view.run(),
        Command::Live(live) => live.run(),
        Command::Simulate(simulate) => simulate.run(),
        Command::Convert(convert) => convert.run(),
        Command::Bench(bench) => bench.run(),
        Command::Completions { shell } => Ok(completions(shell)),
    }
}

fn completions(shell: clap_complete::Shell) -> Outcome {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "dualbody", &mut text);
    Outcome::of(String::from_utf8_lossy(&text))
}
