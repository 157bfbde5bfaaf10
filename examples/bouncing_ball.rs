//! A bouncing ball: its height decreases by the square of the restitution at each bounce. Dual numbers give the derivatives of the heights in the
//! restitution and in the initial height.
//!
//! Rigid contact finds each bounce at its time within a step, so the derivatives are correct after several bounces at steps of a millisecond. The
//! derivatives of soft contact are correct if a contact lasts many steps.
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
/// Time steps of rigid and of soft contact, s.
const TIME_STEPS: [f64; 2] = [1e-3, 2e-5];

fn main() -> Result<(), Box<dyn Error>> {
    let [h, e] = FALL;
    let law = Rigid {
        restitution: e,
        ..Rigid::default()
    };
    let hard = on_ground(ContactLaw::Rigid(law), TIME_STEPS[0])?;
    let (heights, slopes) = (hard.heights(&FALL), jacobian(&hard, &FALL));
    for (row, height) in heights.into_iter().enumerate() {
        let power = 2 * (row as i32 + 1);
        let expected = e.powi(power) * h;
        println!(
            "bounce {}: {height:.4} m, e^{power} h = {expected:.4} m",
            row + 1
        );
        assert!((height - expected).abs() < 1e-4);
        let by_fall = (slopes[(row, 0)], e.powi(power));
        let by_restitution = (slopes[(row, 1)], f64::from(power) * e.powi(power - 1) * h);
        for (what, (slope, expected)) in [("the fall", by_fall), ("e", by_restitution)] {
            println!("  grows with {what} by {slope:.4}, exact {expected:.4}");
            assert!((slope - expected).abs() < 1e-3);
        }
    }

    // It lasts 14 ms. Slower impacts bounce better: e = 1 − 0.05 s/m v about, after Hunt and Crossley.
    let speed = (2.0 * GRAVITY * h).sqrt();
    let law = SoftContact::estimate(1.0, 1, 3e-3).with_restitution(e, speed);
    let soft = on_ground(ContactLaw::Soft(law), TIME_STEPS[1])?;
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
                    // Velocities of the integrator are those of half a step ago.
                    let v = v - self.0.time_step() * (0.5 * GRAVITY);
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

fn on_ground(law: ContactLaw, time_step: f64) -> Result<Bounces, Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let simulator = Simulator::new(model).with_contacts(contacts);
    Ok(Bounces(simulator.with_time_step(time_step)))
}

fn save(hard: &Simulator) -> Result<(), Box<dyn Error>> {
    let simulator = hard;
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
