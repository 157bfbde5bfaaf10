//! Identification of the mass distribution of a load: the densities of five solids in the hand of an arm, from the torques of a motion.
//!
//! The densities are parameters of `Hardware`. Torques are linear in inertias, and inertias in densities, so the Jacobian is the regressor times the
//! derivatives of the inertias. The measured torques are those of an arm with other densities, with noise.
//!
//! `cargo run --release --example payload` – writes a page of the motion to `out/payload/`.

#[allow(dead_code, reason = "there is no plan to watch and save")]
mod common;

use std::error::Error;

use dualbody::dynamics::{inverse_dynamics, joint_torque_regressor};
use dualbody::joint::JointKind;
use dualbody::least_squares::{Options, Residuals, solve};
use dualbody::model::{Dimension, Hardware, JointSpec, LinkSpec, Mass, ScaledLink};
use dualbody::sim::Rollout;
use dualbody::spatial::Inertia;
use dualbody::{Model, State};
use nalgebra::{DMatrix, DVector};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/ur5.urdf");
/// Four canisters at the corners of a tray and a battery in its middle, each a cube; their edge, m, and where their middles are in the frame of the tool, m.
const EDGE: f64 = 0.08;
const SOLIDS: [(&str, [f64; 3]); 5] = [
    ("front left", [0.12, 0.12, 0.04]),
    ("front right", [0.12, -0.12, 0.04]),
    ("back left", [-0.12, 0.12, 0.04]),
    ("back right", [-0.12, -0.12, 0.04]),
    ("battery", [0.0, 0.0, 0.08]),
];
/// Their contents: sand, cork, water, wood; lead-acid. kg/m³.
const TRUTH: [f64; 5] = [1600.0, 200.0, 1000.0, 600.0, 2300.0];
/// The guess: equal densities.
const GUESS: f64 = 500.0;
/// Measurements, 10 ms apart, and the standard deviation of a torque, N·m.
const SAMPLES: usize = 600;
const DT: f64 = 0.01;
const NOISE: f64 = 0.1;

fn main() -> Result<(), Box<dyn Error>> {
    let hardware = arm_with_payload()?;
    let mut fit = Fit::new(hardware)?;
    let options = Options::default().with_bounds(&[1.0; 5], &[2e4; 5]);
    let found = solve(&mut fit, &[GUESS; 5], &options);
    let covariance = found
        .covariance()
        .ok_or("densities that torques do not tell")?;
    println!(
        "{} after {} iterations; kg/m³:",
        found.status, found.iterations
    );
    for (k, (name, _)) in SOLIDS.iter().enumerate() {
        let (deviation, off) = (covariance[(k, k)].sqrt(), found.x[k] - TRUTH[k]);
        println!(
            "{name:>12} {:7.1} ± {:4.1}, true value {:6.1}",
            found.x[k],
            2.0 * deviation,
            TRUTH[k]
        );
        assert!(off.abs() < 4.0 * deviation && off.abs() < 80.0, "{name}");
    }
    let noise = found
        .variance()
        .ok_or("as many torques as densities")?
        .sqrt();
    println!("noise of the torques: {noise:.4} N·m, true value {NOISE}");
    assert!(found.is_converged() && found.held.is_empty());
    assert!((noise / NOISE - 1.0).abs() < 0.05);

    let (found, truth) = (fit.payload(&found.x)?, fit.payload(&TRUTH)?);
    let off = (found.com() - truth.com()).norm();
    println!(
        "payload of {:.3} kg (true value {:.3}); its centre of mass is {:.2} mm off; its moments\n{:.5} kg·m², true values{:.5}",
        found.mass,
        truth.mass,
        1e3 * off,
        found.about_com().to_matrix(),
        truth.about_com().to_matrix()
    );
    assert!((found.mass / truth.mass - 1.0).abs() < 0.005 && off < 1e-3);
    let moments = found.about_com().to_matrix() - truth.about_com().to_matrix();
    assert!(moments.amax() < 0.02 * truth.about_com().to_matrix().amax());
    fit.save()
}

/// The arm with cubes on its tool, whose densities are parameters.
fn arm_with_payload() -> Result<Hardware, Box<dyn Error>> {
    let mut builder = Model::from_urdf_file(FILE)?.to_builder();
    for (name, at) in SOLIDS {
        let cube = LinkSpec::solid_box(name, [EDGE; 3], Mass::Density(GUESS));
        let joint = JointSpec::new(format!("{name} fixed"), JointKind::Fixed, "tool0", name);
        builder.add_link(cube);
        builder.add_joint(joint.with_translation(at));
    }
    let chosen = SOLIDS.map(|(name, _)| ScaledLink::new(name, &[Dimension::Density]));
    Ok(Hardware::new(&builder.build()?, &chosen)?)
}

/// A sample of the motion and its torques.
struct Sample {
    q: DVector<f64>,
    v: DVector<f64>,
    a: DVector<f64>,
    tau: DVector<f64>,
}

/// Torques that are measured, beside those of densities.
struct Fit {
    hardware: Hardware,
    bare: Model,
    samples: Vec<Sample>,
}

impl Fit {
    fn new(hardware: Hardware) -> Result<Self, Box<dyn Error>> {
        let (truth, mut rng) = (
            hardware.model(&TRUTH)?,
            Xoshiro256PlusPlus::seed_from_u64(1),
        );
        // The sum of twelve uniform numbers is nearly Gaussian, of variance one.
        let mut normal = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
        let samples = (0..SAMPLES).map(|k| {
            let mut sample = motion(truth.nv(), k as f64 * DT);
            let (q, v, a) = (
                sample.q.as_slice(),
                sample.v.as_slice(),
                sample.a.as_slice(),
            );
            sample.tau = inverse_dynamics(&truth, q, v, a).map(|tau| tau + NOISE * normal());
            sample
        });
        Ok(Self {
            samples: samples.collect(),
            bare: Model::from_urdf_file(FILE)?,
            hardware,
        })
    }

    /// Inertia of all solids together, in the frame of the tool.
    fn payload(&self, x: &[f64]) -> Result<Inertia<f64>, Box<dyn Error>> {
        let (model, tool) = (self.hardware.model(x)?, self.bare.find_frame("tool0")?);
        let with = model.bodies().last().ok_or("no body")?.inertia;
        let without = self.bare.bodies().last().ok_or("no body")?.inertia;
        let tool_of_body = self.bare.frames()[tool.0].placement.inverse();
        Ok(tool_of_body.inertia(&(with + without.scaled(-1.0))))
    }

    fn save(&self) -> Result<(), Box<dyn Error>> {
        let samples = self.samples.iter();
        let states = samples
            .clone()
            .map(|s| State::new(s.q.as_slice(), s.v.as_slice()));
        let torques = samples.map(|s| s.tau.clone()).collect();
        let model = self.hardware.model(&TRUTH)?;
        let motion = Rollout::new(&model, DT, states.collect(), torques);
        common::save_page(
            "payload",
            &common::record("payload", &model, &motion, "tool0")?,
        )
    }
}

/// Three harmonics in each joint; functions of amplitude, frequency (rad/s) and phase.
fn motion(nv: usize, t: f64) -> Sample {
    let at = |f: fn(f64, f64, f64) -> f64| {
        DVector::from_fn(nv, |i, _| {
            (1..=3)
                .map(|k| {
                    let w = 2.0 * k as f64;
                    f(0.5 / k as f64, w, w * t + (i * (k + 1)) as f64)
                })
                .sum::<f64>()
        })
    };
    Sample {
        q: at(|a, _, phase| a * phase.sin()),
        v: at(|a, w, phase| a * w * phase.cos()),
        a: at(|a, w, phase| -a * w * w * phase.sin()),
        tau: DVector::zeros(nv),
    }
}

impl Residuals for Fit {
    fn n_residuals(&self) -> usize {
        self.samples.len() * self.bare.nv()
    }

    fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
        let Ok(model) = self.hardware.model(x) else {
            return out.fill(f64::NAN);
        };
        for (sample, out) in self.samples.iter().zip(out.chunks_exact_mut(model.nv())) {
            let (q, v, a) = (
                sample.q.as_slice(),
                sample.v.as_slice(),
                sample.a.as_slice(),
            );
            let off = inverse_dynamics(&model, q, v, a) - &sample.tau;
            out.copy_from_slice(off.as_slice());
        }
    }

    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) {
        let (model, all) = (self.hardware.model(x), self.hardware.parameter_jacobian(x));
        let (Ok(model), Ok(all)) = (model, all) else {
            return out.fill(f64::NAN);
        };
        let inertial = model.parameter_layout().inertial();
        let inertias = all.rows(inertial.start, inertial.len());
        for (k, sample) in self.samples.iter().enumerate() {
            let (q, v, a) = (
                sample.q.as_slice(),
                sample.v.as_slice(),
                sample.a.as_slice(),
            );
            let rows = joint_torque_regressor(&model, q, v, a) * inertias;
            out.rows_mut(k * model.nv(), model.nv()).copy_from(&rows);
        }
    }
}
