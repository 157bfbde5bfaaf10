//! `dualbody bench`: times of a robot on this machine.

use std::error::Error;
use std::fmt::Write;
use std::hint::black_box;
use std::time::{Duration, Instant};

use clap::Args;
use serde::Serialize;

use super::output::{Outcome, heading};
use super::robot::Robot;
use super::setup::{Setup, positive};
use crate::dynamics::{
    AbaScratch, CrbaScratch, RneaScratch, forward_dynamics_into, inverse_dynamics_into,
    mass_matrix_into,
};
use crate::linearize::{Linearization, LinearizeScratch};
use crate::sim::{Simulator, State, StepScratch};

/// Samples of which the median is taken.
const SAMPLES: usize = 15;

/// Measure the dynamics, the step and its Jacobians of a robot on one core of this machine.
#[derive(Args, Debug)]
pub(super) struct Bench {
    #[command(flatten)]
    robot: Robot,
    #[command(flatten)]
    setup: Setup,
    /// Time for each function, s.
    #[arg(long, default_value = "0.3", value_parser = positive, allow_negative_numbers = true)]
    seconds: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Median time of a call.
#[derive(Serialize)]
struct Timing {
    function: &'static str,
    seconds: f64,
}

impl Bench {
    pub(super) fn run(self) -> Result<Outcome, Box<dyn Error>> {
        let loaded = self.robot.load()?;
        let (simulator, start) = self.setup.simulation(&loaded)?;
        let timings = timings(&simulator, &start, self.seconds);
        if self.json {
            return Ok(Outcome::of(serde_json::to_string_pretty(&timings)?));
        }
        let title = format!(
            "{}: nv = {}, one core, median of {SAMPLES}",
            simulator.model().name(),
            simulator.model().nv()
        );
        let mut text = format!("{}\n", heading(title));
        for Timing { function, seconds } in &timings {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{function:28} {:10.3} µs", 1e6 * seconds);
        }
        Ok(Outcome::of(text))
    }
}

fn timings(simulator: &Simulator, start: &State, seconds: f64) -> Vec<Timing> {
    let (model, u) = (simulator.model(), vec![0.0; simulator.nu()]);
    let (q, v) = (start.q.as_slice(), start.v.as_slice());
    let zero = vec![0.0; model.nv()];
    let mut out = zero.clone();
    let mut rnea = RneaScratch::new(model);
    let inverse = median(seconds, || {
        inverse_dynamics_into(model, q, v, black_box(&zero), &[], &mut rnea, &mut out);
    });
    let mut aba = AbaScratch::new(model);
    let forward = median(seconds, || {
        forward_dynamics_into(model, q, v, black_box(&zero), &[], &mut aba, &mut out);
    });
    let (mut crba, mut matrix) = (
        CrbaScratch::new(model),
        nalgebra::DMatrix::zeros(model.nv(), model.nv()),
    );
    let mass_matrix = median(seconds, || {
        mass_matrix_into(model, black_box(q), &mut crba, &mut matrix);
    });
    let (mut scratch, mut next) = (StepScratch::new(simulator), start.clone());
    let step = median(seconds, || {
        simulator.step_into(black_box(start), &u, &mut scratch, &mut next);
    });
    let (mut scratch, mut jacobians) = (
        LinearizeScratch::new(simulator),
        Linearization::zeros(simulator),
    );
    let linearize = median(seconds, || {
        simulator.linearize_into(black_box(start), &u, &mut scratch, &mut jacobians);
    });
    let all = [
        ("inverse dynamics (RNEA)", inverse),
        ("forward dynamics (ABA)", forward),
        ("mass matrix (CRBA)", mass_matrix),
        ("step", step),
        ("A and B of the step", linearize),
    ];
    all.into_iter()
        .map(|(function, seconds)| Timing { function, seconds })
        .collect()
}

/// Median time of a call, s, of samples that take so long together.
fn median(seconds: f64, mut call: impl FnMut()) -> f64 {
    call();
    let of_sample = Duration::from_secs_f64(seconds.min(60.0) / SAMPLES as f64);
    let mut samples: Vec<f64> = (0..SAMPLES)
        .map(|_| {
            let (began, mut calls) = (Instant::now(), 0_u32);
            while began.elapsed() < of_sample || calls == 0 {
                call();
                calls += 1;
            }
            began.elapsed().as_secs_f64() / f64::from(calls)
        })
        .collect();
    samples.sort_by(f64::total_cmp);
    samples[SAMPLES / 2]
}
