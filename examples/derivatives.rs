//! Derivatives by choice of scalar: a Jacobian, a Hessian, and a derivative in a mass, from one source.
//!
//! `cargo run --release --example derivatives` – writes a page with the robot and a heavier one to `out/derivatives/`.

use dualbody::autodiff::{VectorFunction, finite_difference, hessian, jacobian};
use dualbody::dynamics::{forward_dynamics, kinetic_energy};
use dualbody::model::{BodyId, Model, samples};
use dualbody::view::{Recording, RecordingError};
use dualbody::{Over, Scalar, Simulator, State};
use num_dual::Dual64;

/// Accelerations of the double pendulum as a function of (q, v, τ).
struct Acceleration<'a>(&'a Model);

impl VectorFunction for Acceleration<'_> {
    fn n_outputs(&self) -> usize {
        2
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        y.copy_from_slice(forward_dynamics(self.0, &x[..2], &x[2..4], &x[4..]).as_slice());
    }
}

/// Kinetic energy as a function of v: its Hessian is the mass matrix.
struct Kinetic<'a>(&'a Model);

impl VectorFunction for Kinetic<'_> {
    fn n_outputs(&self) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, v: &[T], y: &mut [T]) {
        y[0] = kinetic_energy(self.0, &[0.3, 0.4].map(T::constant), v);
    }
}

/// Returns the robot with the second rod's mass scaled.
fn with_scaled_rod<T: Over<f64>>(model: &Model, factor: T) -> Model<T> {
    let body = BodyId(1);
    let scaled = model.cast::<T>();
    let inertia = scaled.body(body).inertia.scaled(factor);
    scaled.with_inertia(body, inertia)
}

const OUT: &str = "out/derivatives/index.html";

fn main() -> Result<(), RecordingError> {
    let model = samples::double_pendulum();
    let x = [0.3, 0.4, -1.0, 2.0, 0.1, -0.2];

    let exact = jacobian(&Acceleration(&model), &x);
    let numeric = finite_difference::jacobian(&Acceleration(&model), &x);
    println!("∂v̇/∂(q, v, τ) of the double pendulum{exact:.6}");
    let error = (&exact - numeric).amax();
    println!("largest difference to finite differences: {error:.1e}\n");
    assert!(error < 1e-8);

    let second = hessian(&Kinetic(&model), &[-1.0, 2.0]);
    let mass_matrix = dualbody::dynamics::mass_matrix(&model, &[0.3, 0.4]);
    println!("∂²T/∂v², which is the mass matrix{:.6}", second.hessian);
    assert!((&second.hessian - mass_matrix).amax() < 1e-14);

    // The model itself on dual numbers: derivative of the accelerations in the mass of the second rod.
    let heavier = with_scaled_rod(&model, Dual64::new(1.0, 1.0));
    let lift = |x: &[f64]| x.iter().map(|&x| x.into()).collect::<Vec<Dual64>>();
    let a = forward_dynamics(&heavier, &lift(&x[..2]), &lift(&x[2..4]), &lift(&x[4..]));
    let step = 1e-6;
    for (k, a) in a.iter().enumerate() {
        let of =
            |m: f64| forward_dynamics(&with_scaled_rod(&model, m), &x[..2], &x[2..4], &x[4..])[k];
        let numeric = (of(1.0 + step) - of(1.0 - step)) / (2.0 * step);
        println!(
            "∂v̇{k}/∂m₂ = {:.9} rad/s²/kg (differences: {numeric:.9})",
            a.eps
        );
        assert!((a.eps - numeric).abs() < 1e-6);
    }
    save(&model, &with_scaled_rod(&model, 1.05))
}

/// Writes a page of both robots, let go at the same state: the difference that a derivative in the mass grows to.
fn save(model: &Model, heavier: &Model) -> Result<(), RecordingError> {
    let start = State::new(&[2.0, 0.5], &[0.0; 2]);
    let [a, b] = [model, heavier].map(|model| {
        let simulator = Simulator::new(model.clone()).with_time_step(0.005);
        simulator.rollout(&start, 2000, |_, _, _| {})
    });
    let mut recording = Recording::of_robots(&[model, heavier]);
    for (k, time) in a.times().enumerate() {
        recording.push_all(time, &[(&a.states[k], &[]), (&b.states[k], &[])]);
    }
    let apart = a
        .states
        .iter()
        .zip(&b.states)
        .map(|(a, b)| (&b.q - &a.q).norm());
    recording.add_series("apart [rad]", apart);
    recording.save_html(OUT)
}
