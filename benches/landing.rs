//! Time of a step while a robot falls and comes to lie, under relaxed and under rigid contact: mean, median and largest over the steps, the
//! quotient of the means, the worst status, and how many points carry at the end.
//!
//! ```sh
//! cargo bench --bench landing [-- FILE.urdf …]
//! ```
//!
//! Robots of `assets/`, or those of files with all collision shapes, let go at their neutral configuration with limp joints 0.1 m above flat
//! ground, in steps of 10 ms. Each step is taken some times, and its shortest time counts.

mod common;

use std::path::Path;
use std::time::Instant;

use common::robots::path;
use dualbody::cone::Status;
use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, Terrain};
use dualbody::sim::StepScratch;
use dualbody::{Base, Model, ModelOptions, Simulator, State};

const HEIGHT: f64 = 0.1;
const TIME_STEP: f64 = 0.01;
const STEPS: usize = 400;
/// Times that a step is taken.
const REPEATS: usize = 3;

/// Cost of a fall.
struct Fall {
    /// Of each step, s.
    times: Vec<f64>,
    worst: Status,
    carrying: usize,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // Without it, as a test: everything is called, nothing is known.
    let steps = if arguments.iter().any(|a| a == "--bench") {
        STEPS
    } else {
        2
    };
    let mut files: Vec<String> = arguments;
    files.retain(|a| !a.starts_with('-'));
    if files.is_empty() {
        files = ["quadruped", "humanoid"].map(path).to_vec();
    }
    for file in files {
        measure(&file, steps);
    }
}

fn measure(file: &str, steps: usize) {
    let options = ModelOptions::default().with_base(Base::Floating);
    let (model, _) = options.load_urdf_file(file).expect("a robot");
    let name = Path::new(file).file_stem().unwrap_or_default();
    let laws = [
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid::default()),
    ];
    let [relaxed, rigid] = laws.map(|law| fall(&model, law, steps));
    println!("{}", name.display());
    for (law, fall) in [("relaxed", &relaxed), ("rigid", &rigid)] {
        let [median, largest] = [fall.quantile(0.5), fall.quantile(1.0)].map(|t| t * 1e6);
        println!(
            "  {law:8} mean {:7.1}  median {median:7.1}  largest {largest:7.1} µs  {:?}, {} points carry",
            fall.mean() * 1e6,
            fall.worst,
            fall.carrying
        );
    }
    println!("  rigid / relaxed {:.2}", rigid.mean() / relaxed.mean());
}

fn fall(model: &Model, law: ContactLaw, steps: usize) -> Fall {
    let contacts = Contacts::new(model, Terrain::flat(0.0), law);
    let simulator = Simulator::new(model.clone())
        .with_contacts(contacts)
        .with_time_step(TIME_STEP);
    let u = vec![0.0; simulator.nu()];
    let mut state: State = simulator.neutral_state();
    let points = simulator.contact_report(&state, &u).points;
    let deepest = points.iter().map(|p| p.depth).fold(f64::MIN, f64::max);
    state.q[2] += deepest + HEIGHT;
    let (mut next, mut scratch) = (state.clone(), StepScratch::new(&simulator));
    let (mut times, mut worst) = (Vec::new(), Status::Converged);
    for _ in 0..steps {
        let mut step = || {
            let start = Instant::now();
            simulator.step_into(&state, &u, &mut scratch, &mut next);
            start.elapsed().as_secs_f64()
        };
        times.push((0..REPEATS).map(|_| step()).fold(f64::MAX, f64::min));
        worst = worst.max(scratch.solver_status(0));
        std::mem::swap(&mut state, &mut next);
    }
    let forces = simulator.contact_report(&state, &u).forces;
    Fall {
        times,
        worst,
        carrying: forces.iter().filter(|f| f.amax() > 0.0).count(),
    }
}

impl Fall {
    fn mean(&self) -> f64 {
        self.times.iter().sum::<f64>() / self.times.len() as f64
    }

    fn quantile(&self, share: f64) -> f64 {
        let mut sorted = self.times.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[(share * (sorted.len() - 1) as f64) as usize]
    }
}
