//! The program `dualbody`; see [`dualbody::command`].

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(dualbody::command::run(std::env::args_os()))
}
