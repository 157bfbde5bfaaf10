//! A one-legged hopper is optimised together with its jump, through the contact of its foot: the lengths of thigh and shank, and all torques.
//!
//! One backward pass through the rollout gives the gradient of the cost of a jump: in the inputs, in the start, which depends on the lengths, and in all
//! parameters of the model. `Hardware` converts the latter to a gradient in the lengths. The foot is a separate body on a spring.
//!
//! `cargo run --release --example hopper_codesign` – writes the robot and a page of both jumps to `out/hopper_codesign/`.

#[allow(dead_code, reason = "there is no plan to watch and save")]
mod common;

use std::cell::RefCell;
use std::error::Error;

use dualbody::contact::{ContactLaw, Contacts, HuntCrossley, SoftContact, Terrain};
use dualbody::joint::JointKind::{Prismatic, Revolute};
use dualbody::linearize::{RolloutCost, RolloutGradientOptions, WantedParameters};
use dualbody::model::{
    Dimension, Geometry, Hardware, JointSpec, LinkSpec, Mass, ModelBuilder, ScaledLink, Visual,
};
use dualbody::scalar::Dual;
use dualbody::spatial::{Inertia, Transform};
use dualbody::trajopt::{MinimizeOptions, Minimizer, Minimum, Objective, minimize};
use dualbody::view::Recording;
use dualbody::{Integrator, Model, Scalar, Simulator, State};
use nalgebra::{DVector, Vector3};

const NAME: &str = "hopper_codesign";
const DT: f64 = 0.004;
/// 0.24 s, and the steps for which a torque is held.
const STEPS: usize = 60;
const HELD: usize = 5;
const VARIABLES: usize = 2 + 2 * STEPS / HELD;
/// Top of the jump, m: as far and as high.
const GOAL: [f64; 2] = [0.2, 0.8];
/// Weights of that, 1/m², of the effort, 1/(N²m² s), and of the speeds of the leg, s.
const ARRIVE: f64 = 200.0;
const EFFORT: f64 = 1e-2;
const LEG: f64 = 1e-3;
/// Inertia that the motors reflect, kg·m².
const ROTOR: f64 = 0.01;
/// Length of thigh and shank to begin with, by how much they may be longer or shorter, and their radius, m.
const UNIFORM: f64 = 0.2;
const REACH: f64 = 0.08;
const RADIUS: f64 = 0.015;
/// Radius of the foot, its depth in the mat and that of the toe in the shank, m, and the angle of the knee, rad.
const FOOT: f64 = 0.02;
const DEPTH: f64 = 0.01;
const TOE: f64 = 0.01;
const KNEE: f64 = 1.2;
/// Mass that the mat and the toe are made for, kg.
const MASS: f64 = 4.0;
const GRAVITY: f64 = 9.81;

fn main() -> Result<(), Box<dyn Error>> {
    let robot = hopper()?;
    let lengths = ["thigh", "shank"].map(|link| ScaledLink::new(link, &[Dimension::Length]));
    let hardware = Hardware::new(&robot, &lengths)?;
    let mut design = Design {
        simulator: simulator(robot)?,
        hardware,
        frees_lengths: false,
        last: RefCell::default(),
    };
    let guess = design.guess();
    println!("standing up: cost {:.3}", design.value(&guess));
    let motion = solve(&design, &guess);
    report("jump of the uniform leg", &motion);
    (design.frees_lengths, design.last) = (true, RefCell::default());
    let both = solve(&design, &motion.x);
    report("leg and jump together", &both);
    assert!(both.value < 0.97 * motion.value, "no better leg");
    // Not at the end, where the foot is about to leave the ground: there the cost has an edge.
    check_gradient(&design, &guess);
    save(&design, &motion.x, &both.x)
}

/// A body on a boom, which moves along x and z, on a leg of two bars and a toe.
fn hopper() -> Result<Model, Box<dyn Error>> {
    let mut builder = ModelBuilder::new("hopper");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("boom").with_mass(0.1, [0.0; 3], [1e-4; 3]));
    builder.add_link(LinkSpec::solid_box(
        "body",
        [0.2, 0.12, 0.08],
        Mass::Kilograms(3.0),
    ));
    builder.add_link(bar("thigh", [0.2, 0.4, 0.8, 1.0]));
    builder.add_link(bar("shank", [0.9, 0.5, 0.1, 1.0]));
    builder.add_link(LinkSpec::solid_sphere("foot", FOOT, Mass::Kilograms(0.1)));
    let joint =
        |name: &str, kind, parent: &str, child: &str| JointSpec::new(name, kind, parent, child);
    builder.add_joint(joint("along", Prismatic, "world", "boom"));
    builder.add_joint(joint("up", Prismatic, "boom", "body").with_axis([0.0, 0.0, 1.0]));
    let hip = joint("hip", Revolute, "body", "thigh").with_axis([0.0, 1.0, 0.0]);
    builder.add_joint(hip.with_damping(0.1).with_armature(ROTOR));
    let knee = joint("knee", Revolute, "thigh", "shank").with_axis([0.0, 1.0, 0.0]);
    builder.add_joint(
        knee.with_translation([0.0, 0.0, -UNIFORM])
            .with_damping(0.1)
            .with_armature(ROTOR),
    );
    // The weight compresses it by so much.
    let stiffness = MASS * GRAVITY / TOE;
    let toe = joint("toe", Prismatic, "shank", "foot").with_axis([0.0, 0.0, 1.0]);
    let toe = toe
        .with_translation([0.0, 0.0, -UNIFORM])
        .with_spring(stiffness, 0.0);
    builder.add_joint(toe.with_damping((stiffness * MASS).sqrt()));
    Ok(builder.build()?)
}

/// A solid bar that hangs from its joint; nothing of it touches the ground.
fn bar(name: &str, color: [f64; 4]) -> LinkSpec {
    let geometry = Geometry::Cylinder {
        radius: RADIUS,
        length: UNIFORM,
    };
    let placement = Transform::from_translation(Vector3::new(0.0, 0.0, -0.5 * UNIFORM));
    let inertia = geometry
        .inertia(Mass::Kilograms(0.4))
        .unwrap_or_else(Inertia::zero);
    LinkSpec::new(name)
        .with_inertia(placement.inertia(&inertia))
        .with_visual(Visual {
            name: None,
            placement,
            geometry,
            color: Some(color),
        })
}

/// The robot on a mat. Both exponents are 3/2, not the 3/2 and 5/2 of `SoftContact::estimate`: a damper of 5/2 that is critical where the robot
/// stands lets go what leaves faster than 0.1 m/s, and the search stalls at that edge. Its jump starts on the ground, so that no derivative leads
/// through an impact.
fn simulator(model: Model) -> Result<Simulator, Box<dyn Error>> {
    let exponent: f64 = 1.5;
    let slope = (1.0 + exponent) * MASS * GRAVITY / DEPTH;
    let law = SoftContact {
        friction: 0.8,
        normal: HuntCrossley {
            stiffness: MASS * GRAVITY / DEPTH.powf(1.0 + exponent),
            damping: 2.0 * (slope * MASS).sqrt() / DEPTH.powf(exponent),
            stiffness_exponent: exponent,
            damping_exponent: exponent,
        },
    };
    let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Soft(law));
    let contacts = contacts.with_links(&model, &["foot"])?;
    Ok(Simulator::new(model)
        .with_contacts(contacts)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(DT)
        .with_actuated_joints(&["hip", "knee"])?)
}

/// Crouched with the foot under the hip: along, up, hip, knee, toe.
fn crouched<T: Scalar>([thigh, shank]: [T; 2]) -> [T; 5] {
    let shank = shank - TOE;
    let (sin, cos) = KNEE.sin_cos();
    let (across, down) = (shank * sin, thigh + shank * cos);
    let leg = (across * across + down * down).sqrt();
    let knee = T::constant(KNEE);
    [
        T::zero(),
        leg + (FOOT - DEPTH),
        -across.atan2(down),
        knee,
        T::constant(TOE),
    ]
}

/// The cost of a jump.
struct Jump;

impl RolloutCost for Jump {
    fn stage<T: Scalar>(&self, _: usize, state: &State<T>, u: &[T]) -> T {
        let effort = u[0] * u[0] + u[1] * u[1];
        let leg = state.v[2] * state.v[2] + state.v[3] * state.v[3];
        (effort * EFFORT + leg * LEG) * DT
    }

    /// From the last state on the body flies: z + `v_z`² / 2g is the top, x + `v_x` `v_z` / g where it is.
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        let (q, v) = (last.q.as_slice(), last.v.as_slice());
        let far = q[0] + v[0] * v[1] * (1.0 / GRAVITY) - GOAL[0];
        let high = q[1] + v[1] * v[1].abs() * (0.5 / GRAVITY) - GOAL[1];
        (far * far + high * high) * ARRIVE
    }
}

/// The cost as a function of two variables, whose sines are the lengths within the buildable range, and of the torques.
struct Design {
    simulator: Simulator,
    hardware: Hardware,
    /// Whether the lengths are variables, or stay.
    frees_lengths: bool,
    /// The last point with its value and gradient.
    last: RefCell<Option<Known>>,
}

/// A point, and its value and gradient.
type Known = (Vec<f64>, f64, DVector<f64>);

impl Design {
    fn lengths(x: &[f64]) -> [f64; 2] {
        [x[0], x[1]].map(|x| UNIFORM + REACH * x.sin())
    }

    fn inputs(x: &[f64]) -> Vec<DVector<f64>> {
        let held = |k: usize| 2 + 2 * (k / HELD);
        (0..STEPS)
            .map(|k| DVector::from_row_slice(&x[held(k)..held(k) + 2]))
            .collect()
    }

    /// Lengths as they are; torques that stand up, the knee against the weight.
    fn guess(&self) -> Vec<f64> {
        let mut x = vec![0.0; VARIABLES];
        for torque in x[2..].chunks_exact_mut(2).take(8) {
            torque[1] = -8.0;
        }
        x
    }

    /// The simulator of a leg, and the start.
    fn at(&self, lengths: [f64; 2]) -> Option<(Simulator, State)> {
        let model = self.hardware.model(&lengths).ok()?;
        let simulator = self.simulator.with_model(model).ok()?;
        let start = simulator.state(&crouched(lengths), &[0.0; 5]);
        Some((simulator, start))
    }

    fn evaluate(&self, x: &[f64]) -> Option<(f64, DVector<f64>)> {
        let lengths = Self::lengths(x);
        let (simulator, start) = self.at(lengths)?;
        let options = RolloutGradientOptions {
            parameters: WantedParameters::Model,
            ..Default::default()
        };
        let inputs = [Self::inputs(x)];
        let mut all = simulator.rollout_gradients(&[start], &inputs, &Jump, &options);
        let jump = all.swap_remove(0);
        let mut gradient = DVector::zeros(x.len());
        for (k, u) in jump.inputs.iter().enumerate() {
            let mut held = gradient.rows_mut(2 + 2 * (k / HELD), 2);
            held += u;
        }
        if self.frees_lengths {
            let by_model =
                self.hardware.parameter_jacobian(&lengths).ok()?.transpose() * jump.parameters;
            let start = crouched([0, 1].map(|k| Dual::<f64, 2>::variable(lengths[k], k)));
            for (k, x) in x[..2].iter().enumerate() {
                let moved = start
                    .iter()
                    .zip(&jump.start)
                    .map(|(q, slope)| q.eps[k] * slope);
                gradient[k] = REACH * x.cos() * (by_model[k] + moved.sum::<f64>());
            }
        }
        Some((jump.cost, gradient))
    }

    fn known(&self, x: &[f64]) -> (f64, DVector<f64>) {
        let mut last = self.last.borrow_mut();
        if let Some((_, value, gradient)) = last.as_ref().filter(|(at, ..)| at == x) {
            return (*value, gradient.clone());
        }
        let found = self.evaluate(x);
        let (value, gradient) = found.unwrap_or_else(|| (f64::INFINITY, DVector::zeros(x.len())));
        *last = Some((x.to_vec(), value, gradient.clone()));
        (value, gradient)
    }
}

impl Objective for Design {
    fn value(&self, x: &[f64]) -> f64 {
        self.known(x).0
    }

    fn gradient(&self, x: &[f64]) -> DVector<f64> {
        self.known(x).1
    }
}

fn solve(design: &Design, start: &[f64]) -> Minimum {
    let options = MinimizeOptions {
        max_iterations: 600,
        tolerance: 1e-5,
        memory: 30,
        ..MinimizeOptions::default()
    };
    minimize(design, start, Minimizer::Lbfgs, &options)
}

fn report(what: &str, found: &Minimum) {
    let [thigh, shank] = Design::lengths(&found.x);
    println!(
        "{what}: cost {:.4}, {} after {} iterations; thigh {thigh:.4} m, shank {shank:.4} m",
        found.value, found.status, found.iterations
    );
}

/// The gradient against central differences, in both lengths and some torques.
fn check_gradient(design: &Design, x: &[f64]) {
    let gradient = design.gradient(x);
    let mut worst = 0.0_f64;
    for k in [0, 1, 2, 3, 20, 21] {
        let step = if k < 2 { 1e-6 } else { 1e-4 };
        let at = |sign: f64| {
            let mut moved = x.to_vec();
            moved[k] += sign * step;
            design.evaluate(&moved).map_or(f64::NAN, |(value, _)| value)
        };
        let numeric = (at(1.0) - at(-1.0)) / (2.0 * step);
        let off = (gradient[k] - numeric).abs() / gradient.amax().max(1.0);
        worst = worst.max(off);
        assert!(
            off < 1e-6,
            "variable {k}: {} against {numeric}",
            gradient[k]
        );
    }
    println!("difference of the gradient from central differences: {worst:.1e}");
}

/// Writes the robot that was found, and both jumps.
fn save(design: &Design, uniform: &[f64], both: &[f64]) -> Result<(), Box<dyn Error>> {
    let played = [uniform, both].map(|x| {
        let (simulator, start) = design
            .at(Design::lengths(x))
            .expect("lengths that were found");
        let inputs = Design::inputs(x);
        let jump = simulator.rollout(&start, STEPS, |t, _, u| {
            u.copy_from_slice(inputs[(t / DT).round() as usize].as_slice());
        });
        (simulator.model().clone(), jump)
    });
    for (name, (_, jump)) in ["uniform", "designed"].iter().zip(&played) {
        let (q, v) = (&jump.last().q, &jump.last().v);
        let top = q[1] + v[1] * v[1] / (2.0 * GRAVITY);
        let far = q[0] + v[0] * v[1] / GRAVITY;
        let torque = jump.inputs.iter().map(|u| u.amax()).fold(0.0, f64::max);
        println!("{name}: top at ({far:.3}, {top:.3}) m, with at most {torque:.1} N·m");
        assert!((far - GOAL[0]).abs() < 0.05 && (top - GOAL[1]).abs() < 0.05);
    }
    std::fs::create_dir_all(format!("out/{NAME}"))?;
    std::fs::write(format!("out/{NAME}/hopper.urdf"), played[1].0.to_urdf()?)?;
    let mut recording =
        Recording::of_robots(&[&played[0].0, &played[1].0]).with_title(NAME.replace('_', " "));
    for (k, time) in played[0].1.times().enumerate() {
        let [a, b] = [0, 1].map(|i: usize| (&played[i].1.states[k], &[][..]));
        recording.push_all(time, &[a, b]);
    }
    recording.spread(0.5);
    common::save_page(NAME, &recording)
}
