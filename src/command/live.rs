//! `dualbody live`: a simulation in the browser while it runs.

use std::error::Error;

use clap::Args;

use super::output::{Outcome, complain};
use super::robot::Robot;
use super::setup::Setup;
use super::view::open;
use crate::view;

/// Simulate a robot in the browser in real time: pause, step, reset, pull bodies with the mouse, move joints by sliders.
///
/// Runs until Ctrl-C. The address is printed; it is known to this user only.
#[derive(Args, Debug)]
pub(super) struct Live {
    #[command(flatten)]
    robot: Robot,
    #[command(flatten)]
    setup: Setup,
    /// Print the address only.
    #[arg(long)]
    no_open: bool,
}

impl Live {
    pub(super) fn run(self) -> Result<Outcome, Box<dyn Error>> {
        let loaded = self.robot.load()?;
        let (simulator, start) = self.setup.simulation(&loaded)?;
        let remarks = simulator.remarks(start.q.as_slice());
        remarks
            .iter()
            .for_each(|remark| complain("warning", &remark.to_string()));
        let live = view::Live::start(simulator, &start)?;
        let status = Outcome::of(live.url()).print();
        if !self.no_open {
            open(live.url());
        }
        live.wait();
        Ok(Outcome::of("").flawed_if(status != 0))
    }
}
