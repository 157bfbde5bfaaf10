//! A simulation in the Rerun viewer, as a file or while it runs.
//!
//! `cargo run --release --features rerun --example rerun` – writes `out/rerun/motion.rrd`. With `-- --live` at the end, and a running viewer
//! (`pip install rerun-sdk==0.27.3`, then `rerun`), the robot moves in the viewer in real time.

use std::error::Error;
use std::time::Duration;

use dualbody::dynamics::kinetic_energy;
use dualbody::view::{Recording, RerunStream};
use dualbody::{Model, Simulator, State};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/ur5.urdf");
const OUT: &str = "out/rerun/motion.rrd";
const DT: f64 = 0.005;
const STEPS: usize = 1000;

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = Simulator::new(Model::from_urdf_file(FILE)?).with_time_step(DT);
    let model = simulator.model();
    let scene = Recording::new(model).with_title("an arm that falls");
    let is_live = std::env::args().any(|word| word == "--live");
    let mut stream = match is_live {
        true => RerunStream::connect(RerunStream::VIEWER, &scene)?,
        false => RerunStream::save(OUT, &scene)?,
    };
    let mut state = State::neutral(model);
    for k in 0..STEPS {
        let time = DT * k as f64;
        let energy = kinetic_energy(model, state.q.as_slice(), state.v.as_slice());
        stream.push(time, &state, &[]);
        stream.push_scalar(time, "kinetic energy [J]", energy);
        state = simulator.step(&state, &[0.0; 6]);
        if is_live {
            std::thread::sleep(Duration::from_secs_f64(DT));
        }
    }
    assert!(state.v.norm() > 1.0, "it swings");
    stream.flush()?;
    drop(stream);
    if !is_live {
        let bytes = std::fs::read(OUT)?;
        assert!(bytes.starts_with(b"RRF2"), "the mark of Rerun's files");
        println!("{OUT}: {} bytes; open it with: rerun {OUT}", bytes.len());
    }
    Ok(())
}
