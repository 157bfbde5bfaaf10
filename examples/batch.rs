//! Domain randomisation: thousands of cart-poles, each with its own masses and length, balanced by one gain, which was designed for the cart-pole of the
//! description.
//!
//! `cargo run --release --example batch` – writes a page with some of them to `out/batch/`.

use std::error::Error;
use std::time::Instant;

use dualbody::control::Lqr;
use dualbody::model::BodyId;
use dualbody::sim::{BatchScalar, BatchSimulator, RolloutStatus};
use dualbody::spatial::Transform;
use dualbody::view::Recording;
use dualbody::{Model, Scalar, Simulator, State};
use nalgebra::{DMatrix, Vector3};
use rand::{Rng, RngExt, SeedableRng, rngs::Xoshiro256PlusPlus};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
const ROBOTS: usize = 4096;
const STEPS: usize = 1000;
/// Masses and length are drawn between the nominal value divided by this and multiplied by it.
const SPREAD: f64 = 1.5;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let simulator = Simulator::new(model)
        .with_time_step(0.01)
        .with_actuated_joints(&["linear"])?;
    let upright = State::neutral(simulator.model());
    let step = simulator.linearize(&upright, &[0.0]);
    let (q, r) = (DMatrix::identity(4, 4), DMatrix::identity(1, 1).scale(0.01));
    let gain = Lqr::discrete(&step.a, &step.b, &q, &r).gain;

    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let models = (0..ROBOTS).map(|_| variant(simulator.model(), &mut rng));
    let mut batch = BatchSimulator::of_variants(&simulator, models.collect())?;
    // 5° to 20° off upright
    let starts: Vec<State> = (0..ROBOTS)
        .map(|_| {
            State::new(
                &[0.0, rng.random_range(5.0..20_f64).to_radians()],
                &[0.0; 2],
            )
        })
        .collect();

    let clock = Instant::now();
    let rollout = batch.rollout(&starts, STEPS, |_, state, u| {
        // u = −K x, in every lane
        let x = state.q.iter().chain(&state.v);
        let feedback = x.zip(gain.iter()).map(|(&x, &k)| x * -k);
        u[0] = feedback.fold(BatchScalar::constant(0.0), |sum, x| sum + x);
    });
    let rate = (ROBOTS * STEPS) as f64 / clock.elapsed().as_secs_f64();

    let stands = |i: usize| {
        rollout.status(i) == RolloutStatus::Completed && rollout.last(i).q[1].abs() < 0.02
    };
    let (standing, stopped) = (
        (0..ROBOTS).filter(|&i| stands(i)).count(),
        (0..ROBOTS).filter(|&i| rollout.status(i) != RolloutStatus::Completed),
    );
    println!("{standing} of {ROBOTS} cart-poles stand after {STEPS} steps");
    println!("{} diverged", stopped.count());
    println!(
        "{:.1} million steps a second on {} threads",
        rate * 1e-6,
        batch.threads()
    );
    check_one_alone(&batch, &starts, &gain, |i| rollout.last(i));
    assert!(standing > ROBOTS * 9 / 10, "a gain with a margin");
    // A dozen of them on rails side by side.
    let mut recording = Recording::from_batch(&batch, &rollout, &Vec::from_iter(0..12));
    for i in 0..12 {
        let aside = Transform::from_translation(Vector3::x() * (0.4 * i as f64));
        recording.robot_mut(i).place(aside);
    }
    Ok(recording.save_html("out/batch/index.html")?)
}

/// A cart-pole with other masses and another length of the pole.
fn variant(nominal: &Model, rng: &mut impl Rng) -> Model {
    let mut factor = || SPREAD.powf(rng.random_range(-1.0..1.0));
    let (cart, pole) = (BodyId(0), BodyId(1));
    let inertia = |body: BodyId, factor: f64| nominal.body(body).inertia.scaled(factor);
    let (cart_inertia, mut pole_inertia) = (inertia(cart, factor()), inertia(pole, factor()));
    // Longer by a factor: first moments grow with it, second ones with its square.
    let longer = factor();
    pole_inertia.first_moment *= longer;
    let j = &mut pole_inertia.rotational;
    (j.xx, j.yy) = (j.xx * longer * longer, j.yy * longer * longer);
    let model = nominal.clone().with_inertia(cart, cart_inertia);
    model.with_inertia(pole, pole_inertia)
}

/// The first robots, simulated one by one, end with the very same bits.
fn check_one_alone(
    batch: &BatchSimulator,
    starts: &[State],
    gain: &DMatrix<f64>,
    last: impl Fn(usize) -> State,
) {
    for i in 0..10 {
        let alone = batch
            .simulator(i)
            .rollout(&starts[i], STEPS, |_, state, u| {
                let x = state.q.iter().chain(&state.v);
                u[0] = x
                    .zip(gain.iter())
                    .map(|(&x, &k)| x * -k)
                    .fold(0.0, |sum, x| sum + x);
            });
        assert_eq!(*alone.last(), last(i), "robot {i}");
    }
}
