//! Functions and steps per second on a GPU, for thousands of states at once.
//!
//! `cargo bench -p dualbody-cuda --bench throughput` – prints a table; without a driver or NVRTC it says so. Times are from handing the first kernel on to the end of
//! the last one, with all numbers on the device; compiling is measured apart, the first time only.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::model::samples;
use dualbody::scalar::traced::Graph;
use dualbody::{Model, Simulator};
use dualbody_cuda::{
    Compiler, CudaError, CudaFunction, CudaSimulator, Device, Numbers, Real, Status, graphs,
};

/// States at once: enough to fill the largest GPUs some times over.
const COUNT: usize = 1 << 16;
/// Calls of a kernel that are measured.
const CALLS: usize = 50;
/// Steps of a rollout that is measured.
const STEPS: usize = 200;

fn main() -> Result<(), Box<dyn Error>> {
    let device = match Device::new(0) {
        Err(error @ (CudaError::NoDriver { .. } | CudaError::NoDevice { .. })) => {
            eprintln!("SKIPPED: {error}");
            return Ok(());
        }
        found => found?,
    };
    println!("{}, {COUNT} states at once\n", device.name()?);
    println!("| robot, function | numbers | per second | compiled in, s |\n|---|---|---|---|");
    let compiler = Compiler::new();
    let arm = Simulator::new(samples::arm()).with_time_step(1e-3);
    function::<f64>(
        "arm (7), inverse dynamics",
        &graphs::inverse_dynamics(arm.model()),
        &device,
        &compiler,
    )?;
    function::<f64>(
        "arm (7), A and B",
        &graphs::linearization(&arm),
        &device,
        &compiler,
    )?;
    steps::<f64>("arm (7), step", arm, &device, &compiler)?;
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let model = Model::from_urdf_file(assets.join("humanoid.urdf"))?;
    let humanoid = Simulator::new(model.clone()).with_time_step(1e-3);
    steps::<f32>("humanoid (35), step", humanoid.clone(), &device, &compiler)?;
    steps::<f32>(
        "humanoid (35), step with soft contact",
        standing(humanoid, &model),
        &device,
        &compiler,
    )?;
    Ok(())
}

/// The simulator with soft contact of all its shapes on flat ground.
fn standing(simulator: Simulator, model: &Model) -> Simulator {
    /// Depth (m) to which the robot sinks in when it stands on four points.
    const DEPTH: f64 = 1e-3;
    const POINTS: usize = 4;
    /// Height of the ground, m. Whether a foot touches it does not change what is computed.
    const GROUND: f64 = -1.0;
    let law = SoftContact::estimate(model.total_mass(), POINTS, DEPTH);
    let contacts = Contacts::new(model, Terrain::flat(GROUND), ContactLaw::Soft(law));
    simulator.with_contacts(contacts)
}

/// Measures a function.
fn function<R: Real>(
    name: &str,
    graph: &Graph,
    device: &Device,
    compiler: &Compiler,
) -> Result<(), CudaError> {
    let start = Instant::now();
    let function = CudaFunction::<R>::new(graph, "f", &[], device, compiler)?;
    let compiled = start.elapsed().as_secs_f64();
    let sizes = function.sizes();
    let numbers: Vec<R> = (0..sizes.inputs * COUNT)
        .map(|k| R::from_f64((k as f64).sin()))
        .collect();
    let mut inputs = Numbers::zeros(device, sizes.inputs, COUNT)?;
    inputs.upload(&numbers)?;
    let shared = Numbers::zeros(device, 0, 1)?;
    let (mut outputs, mut status) = (
        Numbers::zeros(device, sizes.outputs, COUNT)?,
        Status::new(device, COUNT)?,
    );
    function.call(&inputs, &shared, &mut outputs, &mut status)?;
    device.synchronize()?;
    let start = Instant::now();
    for _ in 0..CALLS {
        function.call(&inputs, &shared, &mut outputs, &mut status)?;
    }
    device.synchronize()?;
    row::<R>(name, CALLS, start.elapsed().as_secs_f64(), compiled);
    Ok(())
}

/// Measures steps in one kernel, from the neutral state, under small inputs.
fn steps<R: Real>(
    name: &str,
    simulator: Simulator,
    device: &Device,
    compiler: &Compiler,
) -> Result<(), CudaError> {
    /// Inputs (N·m, N) that no robot here whirls under.
    const SMALL: f64 = 1e-3;
    let start = Instant::now();
    let gpu = CudaSimulator::<R>::new(simulator.clone(), COUNT, device, compiler)?;
    let compiled = start.elapsed().as_secs_f64();
    let rows = STEPS * simulator.nu();
    let numbers: Vec<R> = (0..rows * COUNT)
        .map(|k| R::from_f64(SMALL * (k as f64).sin()))
        .collect();
    let mut inputs = Numbers::zeros(device, rows, COUNT)?;
    inputs.upload(&numbers)?;
    let mut states = gpu.states(&vec![simulator.neutral_state(); COUNT])?;
    let (schedule, mut kept) = (gpu.schedule(STEPS, 0), Numbers::zeros(device, 0, COUNT)?);
    gpu.run(schedule, &mut states, &inputs, &mut kept)?;
    device.synchronize()?;
    let mut states = gpu.states(&vec![simulator.neutral_state(); COUNT])?;
    let start = Instant::now();
    gpu.run(schedule, &mut states, &inputs, &mut kept)?;
    device.synchronize()?;
    let seconds = start.elapsed().as_secs_f64();
    let taken: u64 = states.taken()?.into_iter().map(u64::from).sum();
    assert_eq!(
        taken,
        (STEPS * COUNT) as u64,
        "{name}: motions have stopped"
    );
    row::<R>(name, STEPS, seconds, compiled);
    Ok(())
}

fn row<R: Real>(name: &str, calls: usize, seconds: f64, compiled: f64) {
    let (real, each) = (std::any::type_name::<R>(), (calls * COUNT) as f64 / seconds);
    println!("| {name} | {real} | {:.1} M | {compiled:.1} |", each * 1e-6);
}
