//! A ball bounces: heights fall by the square of the restitution, and dual numbers tell how they depend on it and on
//! the fall.
//!
//! Rigid contact acts at whole steps. Its derivatives hold up to the first bounce only, and not in where the ball falls
//! from: they know nothing of the step in which it lands. Soft contact lasts many steps; its derivatives hold bounce
//! after bounce.
//!
//! `cargo run --release --example bouncing_ball` – writes `out/bouncing_ball/rollout.csv` and a page beside it.

use std::error::Error;
use std::fs::File;

use dualbody::autodiff::{VectorFunction, jacobian};
use dualbody::contact::{ContactLaw, Contacts, Rigid, SoftContact, Terrain};
use dualbody::sim::StepScratch;
use dualbody::view::Recording;
use dualbody::{Cast, Model, Scalar, Simulator};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sphere.urdf");
const RADIUS: f64 = 0.1;
const GRAVITY: f64 = 9.81;
const BOUNCES: usize = 3;
/// Height of the fall, m, and the restitution.
const FALL: [f64; 2] = [1.0, 0.8];
const TIME_STEP: f64 = 2e-5;

fn main() -> Result<(), Box<dyn Error>> {
    let [h, e] = FALL;
    let hard = on_ground(ContactLaw::Rigid(Rigid {
        restitution: e,
        ..Rigid::default()
    }))?;
    let (heights, slopes) = (hard.heights(&FALL), jacobian(&hard, &FALL));
    for (height, k) in heights.into_iter().zip(1..) {
        let expected = e.powi(2 * k) * h;
        println!("bounce {k}: {height:.4} m, e^2k h = {expected:.4} m");
        // Each bounce begins within a step, v Δt above the ground.
        let within_a_step = (2.0 * GRAVITY * h).sqrt() * TIME_STEP;
        assert!((height - expected).abs() < f64::from(k) * within_a_step);
    }
    let (slope, expected) = (slopes[(0, 1)], 2.0 * e * h);
    println!("the first height grows with e by {slope:.4} m, 2 e h = {expected:.4} m");
    assert!((slope - expected).abs() < 1e-3 * expected);

    // It lasts 14 ms. Slower impacts bounce better: e = 1 − 0.05 s/m v about, after Hunt and Crossley.
    let speed = (2.0 * GRAVITY * h).sqrt();
    let law = SoftContact::estimate(1.0, 1, 3e-3).with_restitution(e, speed);
    let soft = on_ground(ContactLaw::Soft(law))?;
    let (heights, slopes) = (soft.heights(&[h, e]), jacobian(&soft, &[h, e]));
    let [above, below] = [1e-4, -1e-4].map(|by| soft.heights(&[h + by, e]));
    assert!((heights[0] - e * e * h).abs() < 1e-2 * h);
    for k in 0..BOUNCES {
        let (exact, numeric) = (slopes[(k, 0)], (above[k] - below[k]) / 2e-4);
        let height = heights[k];
        println!("soft: {height:.4} m, by its fall {exact:.4}, by differences {numeric:.4}");
        assert!((exact - numeric).abs() < 1e-2 * numeric);
    }
    save(&hard.0)
}

/// Heights of bounces, m, as a function of the height of the fall, m, and the restitution, which soft contact does not
/// use.
struct Bounces(Simulator);

impl VectorFunction for Bounces {
    fn n_outputs(&self) -> usize {
        BOUNCES
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let contacts = self.0.contacts().expect("a ball on the ground");
        let mut law: ContactLaw<T> = contacts.laws()[0].cast();
        if let ContactLaw::Rigid(rigid) = &mut law {
            rigid.restitution = x[1];
        }
        let simulator = self.0.cast::<T>().with_contacts(contacts.with_laws(&[law]));
        let mut state = simulator.neutral_state();
        state.q[2] = x[0] + RADIUS;
        let (mut next, mut scratch) = (state.clone(), StepScratch::new(&simulator));
        let mut advance = || {
            simulator.step_into(&state, &[], &mut scratch, &mut next);
            std::mem::swap(&mut state, &mut next);
            (state.q[2] - RADIUS, state.v[2])
        };
        for top in y {
            while advance().1.value(0) <= 0.0 {}
            *top = loop {
                let (z, v) = advance();
                if v.value(0) <= 0.0 {
                    break z + v * v * (0.5 / GRAVITY);
                }
            };
        }
    }
}

impl Bounces {
    fn heights(&self, x: &[f64]) -> [f64; BOUNCES] {
        let mut y = [0.0; BOUNCES];
        self.eval(x, &mut y);
        y
    }
}

fn on_ground(law: ContactLaw) -> Result<Bounces, Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let simulator = Simulator::new(model).with_contacts(contacts);
    Ok(Bounces(simulator.with_time_step(TIME_STEP)))
}

fn save(hard: &Simulator) -> Result<(), Box<dyn Error>> {
    let simulator = hard.clone().with_time_step(1e-3);
    let mut start = simulator.neutral_state();
    start.q[2] = FALL[0] + RADIUS;
    start.v[0] = 0.5; // aside, for the page to have arcs to show
    let rollout = simulator.rollout(&start, 3000, |_, _, _| {});
    std::fs::create_dir_all("out/bouncing_ball")?;
    let file = File::create("out/bouncing_ball/rollout.csv")?;
    rollout.write_csv(simulator.model(), file)?;
    let recording = Recording::from_rollout(simulator.model(), &rollout);
    let mut recording = recording.with_title("bouncing ball");
    recording.robot_mut(0).trace("sphere")?;
    Ok(recording.save_html("out/bouncing_ball/index.html")?)
}
