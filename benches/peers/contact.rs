//! Our side of the comparison of regularised contact with `MuJoCo`: robots as MJCF, motions, times; `contact.py` runs it.
//!
//! ```sh
//! contact mjcf ROBOT
//! contact motion ROBOT STEPS TIME_STEP LEAST LARGEST     # d of the law; prints q and v of each state
//! contact times ROBOT                                   # of a step at rest, and of its Jacobians
//! ```
//!
//! ROBOT is `ball`, `box` or `quadruped`: thrown with a spin, tilted with a spin, dropped onto feet with springs in its joints.

#[path = "../common/mod.rs"]
mod common;

use common::clock::{Clock, arguments, is_test};
use common::robots::{CROUCH, FEET};
use dualbody::contact::{ContactLaw, Contacts, Impedance, RelaxedRigid, Terrain};
use dualbody::linearize::LinearizeScratch;
use dualbody::model::Spring;
use dualbody::sim::StepScratch;
use dualbody::{Linearization, Model, Simulator, State};

const FRICTION: f64 = 0.6;
/// Springs and dampers in the joints of the quadruped, N·m/rad and N·m·s/rad.
const STIFFNESS: f64 = 60.0;
const DAMPING: f64 = 2.0;
/// After so many steps of a millisecond it stands still.
const STEPS_TO_REST: usize = 5000;

fn main() {
    let arguments = arguments();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] if is_test() => {
            print_motion("box", &["10", "1e-3", "0.9", "0.95"]);
            print_times("quadruped", 10, Clock::ONCE);
        }
        ["mjcf", robot] => println!("{}", model(robot).to_mjcf().expect("a robot for MuJoCo")),
        ["motion", robot, ref numbers @ ..] => print_motion(robot, numbers),
        ["times", robot] => print_times(robot, STEPS_TO_REST, Clock::EXACT),
        _ => println!("usage: see benches/peers/contact.py"),
    }
}

fn model(robot: &str) -> Model {
    let file = if robot == "ball" { "sphere" } else { robot };
    let path = format!("{}/../assets/{file}.urdf", env!("CARGO_MANIFEST_DIR"));
    let model = Model::from_urdf_file(path).expect("a robot of assets/");
    let joints = 6..model.nv();
    joints.fold(model, |model, v| {
        let rest = CROUCH[v % 3];
        let stiffness = STIFFNESS;
        model
            .with_damping(v, DAMPING)
            .with_spring(v, Spring { stiffness, rest })
    })
}

fn simulator(robot: &str, time_step: f64, least: f64, largest: f64) -> Simulator {
    let model = model(robot);
    let standard = RelaxedRigid::default();
    let law = ContactLaw::RelaxedRigid(RelaxedRigid {
        friction: FRICTION,
        impedance: Impedance {
            least,
            largest,
            ..standard.impedance
        },
        ..standard
    });
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let contacts = match robot {
        "quadruped" => contacts.with_links(&model, &FEET).expect("feet"),
        _ => contacts,
    };
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(time_step)
}

fn start(simulator: &Simulator, robot: &str) -> State {
    let mut state = simulator.neutral_state();
    match robot {
        "ball" => {
            state.q[2] = 0.15;
            state.v.copy_from_slice(&[1.0, 0.3, 0.0, 2.0, -6.0, 3.0]);
        }
        "box" => {
            let q = nalgebra::UnitQuaternion::from_euler_angles(0.3, 0.4, 0.2);
            state.q[2] = 0.35;
            state.q.as_mut_slice()[3..].copy_from_slice(&[q.w, q.i, q.j, q.k]);
            state.v.copy_from_slice(&[0.5, 0.2, 0.0, 0.4, -0.3, 0.6]);
        }
        _ => {
            state.q[2] = 0.35;
            for k in 0..12 {
                state.q[7 + k] = CROUCH[k % 3];
            }
        }
    }
    state
}

fn print_motion(robot: &str, numbers: &[&str]) {
    let number = |k: usize| -> f64 { numbers[k].parse().expect("a number") };
    let simulator = simulator(robot, number(1), number(2), number(3));
    let start = start(&simulator, robot);
    let rollout = simulator.rollout(&start, number(0) as usize, |_, _, _| {});
    for state in &rollout.states {
        let numbers = state.q.iter().chain(&state.v);
        let numbers: Vec<String> = numbers.map(|x| format!("{x:.17e}")).collect();
        println!("{}", numbers.join(" "));
    }
}

/// Times in µs, from the state in which the robot has come to rest.
fn print_times(robot: &str, steps_to_rest: usize, clock: Clock) {
    let standard = RelaxedRigid::default().impedance;
    let simulator = simulator(robot, 1e-3, standard.least, standard.largest);
    let u = vec![0.0; simulator.nu()];
    let start = start(&simulator, robot);
    let rollout = simulator.rollout(&start, steps_to_rest, |_, _, _| {});
    let rest = rollout.last();
    let report = simulator.contact_report(rest, &u);
    let touching = report.forces.iter().filter(|f| f.z > 0.0).count();
    println!("touching {touching}");
    println!("speed {:e}", rest.v.amax());
    let (mut scratch, mut next) = (StepScratch::new(&simulator), rest.clone());
    let step = clock.median(|| simulator.step_into(rest, &u, &mut scratch, &mut next));
    println!("step {:.6}", step * 1e6);
    let mut out = Linearization::zeros(&simulator);
    let mut scratch = LinearizeScratch::new(&simulator);
    let jacobians = clock.median(|| simulator.linearize_into(rest, &u, &mut scratch, &mut out));
    println!("linearize {:.6}", jacobians * 1e6);
}
