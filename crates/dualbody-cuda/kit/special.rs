//! Expected failures, and concurrent work of devices.

use std::error::Error;

use dualbody::codegen::{CudaSource, RolloutInputs};
use dualbody::model::samples;
use dualbody::sim::RolloutStatus;
use dualbody::{Simulator, State};
use dualbody_cuda::{
    Compiler, CudaError, CudaFunction, CudaSimulator, Device, Ending, LinearFeedback, Numbers,
    Real, Status, graphs,
};
use nalgebra::{DMatrix, DVector};

use crate::gpu::{Gpu, word};
use crate::report::Report;

/// States of a batch.
const COUNT: usize = 1_003;
/// Steps of a motion.
const STEPS: usize = 20;
/// Largest difference from the library, over a motion.
const MOTION: f64 = 1e-9;

fn cartpole() -> Simulator {
    Simulator::new(samples::cartpole()).with_time_step(1e-3)
}

fn pendulum() -> Simulator {
    Simulator::new(samples::pendulum())
        .with_time_step(0.01)
        .with_divergence_bound(60.0)
}

const VARIED: [&str; 1] = ["pivot: damping"];

/// Kernels that the checks here need besides.
pub(crate) fn sources<R: Real>() -> Result<Vec<CudaSource>, Box<dyn Error>> {
    let (own, precision, roles) = (cartpole(), R::PRECISION, RolloutInputs::default());
    let feedback = RolloutInputs::of_feedback();
    let step =
        |graph: dualbody::scalar::Graph| graph.to_cuda_rollout("dualbody_step", precision, &roles);
    let variants = graphs::feedback_step(&own, &VARIED)?;
    let chains = crate::ceilings::chains();
    Ok(vec![
        step(graphs::step(&pendulum(), &[])?)?,
        step(graphs::step(&own, &VARIED)?)?,
        variants.to_cuda_rollout("dualbody_feedback", precision, &feedback)?,
        graphs::inverse_dynamics(own.model()).to_cuda("f", precision, &[])?,
        chains.to_cuda_rollout("chains", precision, &crate::ceilings::roles())?,
    ])
}

/// All of these checks.
pub(crate) fn special(gpu: &Gpu, report: &mut Report) {
    check(report, "endings, f64", || endings::<f64>(gpu));
    check(report, "endings, f32", || endings::<f32>(gpu));
    check(report, "variants under feedback", || variants(gpu));
    check(report, "two streams", || streams(gpu));
    check(report, "out of memory", || memory(&gpu.device));
}

/// Runs a check.
fn check(report: &mut Report, what: &str, run: impl FnOnce() -> Result<(), Box<dyn Error>>) {
    let found = run();
    if let Err(error) = &found {
        report.fail(format!("{what}: {error}"));
    }
    let word = if found.is_ok() { "right" } else { "wrong" };
    let row = vec![
        ("part", "correct".into()),
        ("check", what.into()),
        ("found", word.into()),
    ];
    report.add(row, format!("{what}: {word}"));
}

fn expect(is_so: bool, what: impl FnOnce() -> String) -> Result<(), Box<dyn Error>> {
    if is_so { Ok(()) } else { Err(what().into()) }
}

/// Motions that end at an input, by divergence, at a condition; the others go on.
fn endings<R: Real>(gpu: &Gpu) -> Result<(), Box<dyn Error>> {
    const LENGTH: usize = 6;
    let own = pendulum();
    let cuda = CudaSimulator::<R>::new(own.clone(), COUNT, &gpu.device, &gpu.compiler)?;
    let mut starts = vec![State::new(&[0.1], &[0.0]); COUNT];
    let mut u = vec![[0.0; LENGTH]; COUNT];
    for i in 0..COUNT {
        match i % 5 {
            1 => u[i][3] = f64::NAN,
            2 => u[i][2] = 5000.0,
            3 => u[i][4] = f64::INFINITY,
            4 => starts[i].v[0] = 150.0,
            _ => {}
        }
    }
    let found = cuda.rollout_inputs(&starts, LENGTH, 1, u.as_flattened())?;
    for (i, start) in starts.iter().enumerate() {
        let mut step = 0;
        let expected = own.rollout(start, LENGTH, |_, _, input| {
            input[0] = u[i][step];
            step += 1;
        });
        let (ending, steps) = (found.ending(i), found.steps(i));
        let is_so = match i % 5 {
            4 => matches!(ending, Ending::BrokenCondition { step: 0, .. }),
            0 => ending == Ending::Rollout(RolloutStatus::Completed) && steps == LENGTH,
            _ => ending == Ending::Rollout(expected.status),
        };
        expect(is_so, || {
            format!("state {i} ends as {ending:?} after {steps} steps")
        })?;
        let off = match i % 5 {
            4 => deviation(found.last(i), start),
            _ => deviation(found.last(i), expected.last()),
        };
        let most = if size_of::<R>() == 8 { MOTION } else { 1e-4 };
        expect(off <= most, || format!("state {i} is off by {off:e}"))?;
    }
    Ok(())
}

fn deviation(found: &State, expected: &State) -> f64 {
    let both = found.numbers().zip(expected.numbers());
    both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Motions of variants of a robot, under inputs and under feedback.
fn variants(gpu: &Gpu) -> Result<(), Box<dyn Error>> {
    let own = cartpole();
    let damping: Vec<f64> = (0..COUNT).map(|i| 1e-4 * i as f64).collect();
    let (device, compiler) = (&gpu.device, &gpu.compiler);
    let cuda = CudaSimulator::of_variants(own.clone(), &VARIED, &damping, COUNT, device, compiler)?;
    let cuda: CudaSimulator<f64> = cuda.with_feedback(compiler)?;
    let start = |i: usize| State::new(&[0.01 * i as f64, 0.3], &[0.0, 1e-3 * i as f64]);
    let starts: Vec<State> = (0..COUNT).map(start).collect();
    let nu = own.nu();
    let u: Vec<f64> = (0..COUNT * STEPS * nu).map(|k| (k as f64).sin()).collect();
    let given = cuda.rollout_inputs(&starts, STEPS, 5, &u)?;
    let feedback = LinearFeedback {
        reference: State::new(&[0.1, 0.0], &[0.0, 0.0]),
        input: DVector::from_fn(nu, |i, _| 0.5 - i as f64),
        gain: DMatrix::from_fn(nu, 4, |i, j| (1.0 + i as f64) * (j as f64 - 1.5)),
    };
    let held = cuda.rollout_feedback(&starts, STEPS, 0, &feedback)?;
    let k = own.parameter_layout().find(VARIED[0])?;
    for (i, start) in starts.iter().enumerate() {
        let (states, steps) = (given.n_states(i), held.steps(i));
        let is_whole = states == 1 + STEPS / 5 && steps == STEPS;
        expect(is_whole, || {
            format!("state {i} has ended: {states} states, {steps} steps")
        })?;
        let mut all = own.parameters();
        all[k] = damping[i];
        let variant = own.with_parameters(all.as_slice());
        let mut step = 0;
        let expected = variant.rollout(start, STEPS, |_, _, input| {
            let first = (i * STEPS + step) * nu;
            input.copy_from_slice(&u[first..first + nu]);
            step += 1;
        });
        let off = deviation(given.last(i), expected.last());
        let kept = deviation(given.state(i, 3), &expected.states[15]);
        let expected = variant.rollout(start, STEPS, |_, x, input| {
            let off = x.deviation(variant.model(), &feedback.reference);
            input.copy_from_slice((&feedback.input - &feedback.gain * off).as_slice());
        });
        let off = off.max(kept).max(deviation(held.last(i), expected.last()));
        expect(off <= MOTION, || format!("state {i} is off by {off:e}"))?;
    }
    Ok(())
}

/// The same work on two streams of one GPU at once has the results of one.
fn streams(gpu: &Gpu) -> Result<(), Box<dyn Error>> {
    const ROUNDS: usize = 20;
    let devices = [Device::new(0)?, Device::new(0)?];
    let alone = Stream::new(&gpu.device, &gpu.compiler)?.found()?;
    let mut both = Vec::new();
    for device in &devices {
        both.push(Stream::new(device, &gpu.compiler)?);
    }
    for _ in 0..ROUNDS {
        for stream in &mut both {
            stream.run()?;
        }
    }
    for stream in &mut both {
        expect(stream.found()? == alone, || "another result".to_owned())?;
    }
    let other = Numbers::<f64>::zeros(&devices[0], 3, COUNT)?;
    let mut own = Numbers::<f64>::zeros(&devices[1], 3, COUNT)?;
    let refused = matches!(own.copy_from(&other), Err(CudaError::Mismatch { .. }));
    expect(refused, || "arrays of two streams were mixed".to_owned())
}

/// A function with its arrays in a stream.
struct Stream {
    function: CudaFunction<f64>,
    inputs: Numbers<f64>,
    shared: Numbers<f64>,
    outputs: Numbers<f64>,
    status: Status,
}

impl Stream {
    fn new(device: &Device, compiler: &Compiler) -> Result<Self, Box<dyn Error>> {
        let graph = graphs::inverse_dynamics(cartpole().model());
        let function = CudaFunction::new(&graph, "f", &[], device, compiler)?;
        let sizes = function.sizes();
        let numbers: Vec<f64> = (0..sizes.inputs * COUNT)
            .map(|k| (k as f64).sin())
            .collect();
        Ok(Self {
            inputs: Numbers::from_states(device, sizes.inputs, COUNT, &numbers)?,
            shared: Numbers::zeros(device, sizes.shared, 1)?,
            outputs: Numbers::zeros(device, sizes.outputs, COUNT)?,
            status: Status::new(device, COUNT)?,
            function,
        })
    }

    fn run(&mut self) -> Result<(), CudaError> {
        let (inputs, shared) = (&self.inputs, &self.shared);
        self.function
            .call(inputs, shared, &mut self.outputs, &mut self.status)
    }

    fn found(&mut self) -> Result<Vec<u64>, CudaError> {
        self.run()?;
        let numbers = self.outputs.download()?;
        Ok(numbers.iter().map(|x| x.to_bits()).collect())
    }
}

/// Arrays that do not fit are an error, and smaller ones go on.
fn memory(device: &Device) -> Result<(), Box<dyn Error>> {
    let error = Numbers::<f64>::zeros(device, 1 << 20, 1 << 20);
    let Err(CudaError::NoMemory { bytes, total, .. }) = error else {
        return Err(format!("eight terabytes: {error:?}").into());
    };
    expect(bytes == 1 << 43, || format!("{bytes} bytes were asked for"))?;
    // More than is free, and less than there is.
    let half = total / 2 / size_of::<f64>();
    let first = Numbers::<f64>::zeros(device, half, 1)?;
    let second = Numbers::<f64>::zeros(device, half, 1);
    let refused = matches!(second, Err(CudaError::NoMemory { .. }));
    expect(refused, || {
        "two halves of the memory are more than is free".to_owned()
    })?;
    drop((first, second));
    let mut small = Numbers::<f64>::zeros(device, 3, COUNT)?;
    small.upload(&vec![1.0; 3 * COUNT])?;
    expect(small.download()? == vec![1.0; 3 * COUNT], || {
        format!("{} after the error", word::<f64>())
    })
}
