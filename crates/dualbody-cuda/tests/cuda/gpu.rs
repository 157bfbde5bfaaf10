//! Kernels on a GPU. Without a driver these tests print a line, and pass.

use dualbody::model::samples;
use dualbody::sim::{BatchSimulator, RolloutStatus};
use dualbody::{Simulator, State};
use dualbody_cuda::{Compiler, CudaError, CudaSimulator, Device, Ending, LinearFeedback, Numbers};
use nalgebra::{DMatrix, DVector};

use crate::checks;
use crate::errors::Folder;
use crate::machine::Gpu;

const COUNT: usize = 300;
const STEPS: usize = 20;

/// The first device; prints a line if there is none.
fn device() -> Option<Device> {
    match Device::new(0) {
        Err(error @ (CudaError::NoDriver { .. } | CudaError::NoDevice { .. })) => {
            eprintln!("not tested: {error}");
            None
        }
        found => Some(found.expect("a device")),
    }
}

fn starts() -> Vec<State> {
    let start = |k: usize| State::new(&[0.01 * k as f64, 0.3], &[0.0, 0.001 * k as f64]);
    (0..COUNT).map(start).collect()
}

fn cartpole() -> Simulator {
    Simulator::new(samples::cartpole()).with_time_step(1e-3)
}

fn cuda(device: &Device, compiler: &Compiler) -> CudaSimulator {
    CudaSimulator::new(cartpole(), COUNT, device, compiler).expect("a simulator")
}

fn inputs(steps: usize) -> Vec<f64> {
    (0..COUNT * steps * 2).map(|k| (k as f64).sin()).collect()
}

#[track_caller]
fn close(found: &State, expected: &State) {
    let both = found.numbers().zip(expected.numbers());
    let off = both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-9, "{off:e}");
}

#[test]
fn kernels_on_a_gpu_equal_the_library() {
    if let Some(device) = device() {
        let folder = Folder::new("gpu");
        checks::all(&Gpu {
            device,
            compiler: folder.compiler(),
        });
    }
}

#[test]
fn steps_and_motions_equal_those_of_the_batch_simulator() {
    let Some(device) = device() else { return };
    let folder = Folder::new("motions");
    let gpu = cuda(&device, &folder.compiler());
    let (starts, u) = (starts(), inputs(STEPS));
    let mut own = BatchSimulator::new(cartpole(), COUNT);
    let expected = own.rollout_inputs(&starts, STEPS, &u);
    let found = gpu
        .rollout_inputs(&starts, STEPS, 5, &u)
        .expect("a rollout");
    let again = gpu
        .rollout_inputs(&starts, STEPS, 5, &u)
        .expect("a rollout");
    for i in 0..COUNT {
        assert_eq!(found.ending(i), Ending::Rollout(RolloutStatus::Completed));
        assert_eq!((found.n_states(i), found.steps(i)), (5, STEPS));
        (0..5).for_each(|k| close(found.state(i, k), &expected.state(i, 5 * k)));
        assert_eq!(found.last(i), again.last(i), "the same bits on every run");
    }
    let (mut states, mut batch) = (gpu.states(&starts).expect("states"), own.states(&starts));
    for _ in 0..3 {
        gpu.step(&mut states, &u[..2 * COUNT]).expect("a step");
        own.step(&mut batch, &u[..2 * COUNT]);
    }
    let found = states.to_vec().expect("states");
    (0..COUNT).for_each(|i| close(&found[i], &batch.state(i)));
}

#[test]
fn motions_under_feedback_equal_those_of_the_library() {
    let Some(device) = device() else { return };
    let folder = Folder::new("feedback");
    let gpu = cuda(&device, &folder.compiler())
        .with_feedback(&folder.compiler())
        .expect("feedback");
    let feedback = LinearFeedback {
        reference: State::new(&[0.1, 0.0], &[0.0, 0.0]),
        input: DVector::from_vec(vec![0.5, 0.0]),
        gain: DMatrix::from_fn(2, 4, |i, j| (1.0 + i as f64) * (j as f64 - 1.5)),
    };
    let found = gpu
        .rollout_feedback(&starts(), STEPS, 0, &feedback)
        .expect("a rollout");
    for (i, start) in starts().iter().enumerate() {
        let own = cartpole().rollout(start, STEPS, |_, x, u| {
            let deviation = x.deviation(cartpole().model(), &feedback.reference);
            u.copy_from_slice((&feedback.input - &feedback.gain * deviation).as_slice());
        });
        close(found.last(i), own.last());
    }
}

#[test]
fn derivatives_equal_those_of_the_library() {
    let Some(device) = device() else { return };
    let folder = Folder::new("derivatives");
    let compiler = folder.compiler();
    let gpu = cuda(&device, &compiler)
        .with_jacobians(&compiler)
        .expect("Jacobians");
    let gpu = gpu.with_gradients(&compiler).expect("gradients");
    let (starts, u) = (starts(), inputs(1));
    let adjoints: Vec<f64> = (0..4 * COUNT).map(|k| (k as f64).cos()).collect();
    let found = gpu.linearize(&starts, &u).expect("Jacobians");
    let slopes = gpu.gradients(&starts, &u, &adjoints).expect("gradients");
    for (i, start) in starts.iter().enumerate() {
        let own = cartpole().linearize(start, &u[2 * i..2 * i + 2]);
        assert!(
            (&found[i].a - own.a)
                .amax()
                .max((&found[i].b - own.b).amax())
                < 1e-9
        );
        let own = cartpole().vjp(start, &u[2 * i..2 * i + 2], &adjoints[4 * i..4 * i + 4]);
        let state = DVector::from_column_slice(&slopes.state[4 * i..4 * i + 4]);
        assert!((state - own.state).amax() < 1e-9);
    }
}

#[test]
fn what_does_not_fit_is_an_error() {
    let Some(device) = device() else { return };
    let folder = Folder::new("fit");
    let compiler = folder.compiler();
    let error =
        CudaSimulator::<f64>::new(cartpole(), 0, &device, &compiler).expect_err("no states");
    assert!(matches!(error, CudaError::EmptyBatch), "{error}");
    let gpu = cuda(&device, &compiler);
    let error = gpu
        .rollout_inputs(&starts(), STEPS, 1, &[0.0; 7])
        .expect_err("too few inputs");
    assert!(
        matches!(error, CudaError::Length { given: 7, .. }),
        "{error}"
    );
    let error = gpu
        .linearize(&starts(), &inputs(1))
        .expect_err("not compiled");
    assert!(error.to_string().contains("with_jacobians"), "{error}");
    let error = Numbers::<f64>::zeros(&device, 1 << 30, 1 << 20).expect_err("too much");
    assert!(
        matches!(error, CudaError::NoMemory { bytes, .. } if bytes == 1 << 53),
        "{error}"
    );
    let changed = samples::cartpole().with_damping(0, 0.3);
    let error = gpu.check_robot(&changed).expect_err("another robot");
    assert!(error.to_string().contains("trace it again"), "{error}");
    gpu.check_robot(cartpole().model()).expect("the same robot");
}
