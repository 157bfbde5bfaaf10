//! A world of robots and objects: two arms at one table. A ball falls beside the arms, which hold a pose. Then the ball is removed and a weight is added to
//! the left hand, and the arms continue from their state.
//!
//! `cargo run --release --example two_arms` – writes `out/two_arms/index.html`, a page that opens in any browser.

use std::error::Error;

use dualbody::dynamics::inverse_dynamics;
use dualbody::model::{Mass, Object, World};
use dualbody::sim::Rollout;
use dualbody::spatial::Transform;
use dualbody::view::Recording;
use dualbody::{Base, Integrator, ModelOptions, Simulator, State};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/ur5.urdf");
const DT: f64 = 0.002;
const STEPS: usize = 250;
/// The pose that an arm holds, rad.
const POSE: [f64; 6] = [0.3, -1.2, 1.4, -0.8, 0.5, 0.2];
/// The way to it obeys ë + 2 ω ė + ω² e = 0 with this ω, 1/s.
const RATE: f64 = 10.0;
/// Mass of the weight, kg.
const WEIGHT: f64 = 1.0;

fn main() -> Result<(), Box<dyn Error>> {
    let at = |x: f64, z: f64| Transform::from_translation([x, 0.0, z].into());
    let options = ModelOptions::default().with_base(Base::Fixed);
    let (arm, _) = options.load_urdf_file(FILE)?;
    let mut world = World::new("two arms");
    world.add(&arm, "left/", &at(-0.6, 0.75))?;
    world.add(&arm, "right/", &at(0.6, 0.75))?;
    let oak = Object::fixed().with_color([0.6, 0.45, 0.3, 1.0]);
    world.add_box("table", [1.8, 0.9, 0.05], &oak.at(at(0.0, 0.725)))?;
    let red = Object::free(Mass::Kilograms(0.2)).with_color([0.8, 0.1, 0.1, 1.0]);
    world.add_sphere("ball", 0.05, &red.at(at(0.0, 2.5)))?;
    let with_ball = simulator(world.build()?);
    let first = hold(&with_ball, &with_ball.neutral_state());
    let ball = first.last().free_pose(with_ball.model(), "ball")?;

    world.remove("ball")?;
    let hand = format!("left/{}", arm.link_names().last().ok_or("no link")?);
    world.add_sphere(
        "weight",
        0.05,
        &Object::fixed_to(&hand, Mass::Kilograms(WEIGHT)),
    )?;
    let with_weight = simulator(world.build()?);
    let start = with_weight.carried_state(&with_ball, first.last())?;
    let second = hold(&with_weight, &start);

    let alone = simulator(arm);
    let apart = hold(&alone, &alone.neutral_state());
    check(&first, &second, &apart, ball.translation.z);
    std::fs::create_dir_all("out/two_arms")?;
    let recording = Recording::of_simulation(&with_ball, &first).with_title("two arms");
    Ok(recording.save_html("out/two_arms/index.html")?)
}

fn simulator(model: dualbody::Model) -> Simulator {
    Simulator::new(model)
        .with_time_step(DT)
        .with_integrator(Integrator::ImplicitVelocity)
}

/// Every arm goes to its pose by computed torque. Free objects take no input.
fn hold(simulator: &Simulator, start: &State) -> Rollout {
    let model = simulator.model();
    let hinges = model.joint_names().into_iter().filter_map(|name| {
        let joint = model.joint(name)?;
        let (q, v) = (model.joint_q(joint), model.joint_v(joint));
        (v.len() == 1).then_some((q.start, v.start))
    });
    let hinges: Vec<(usize, usize)> = hinges.collect();
    simulator.rollout(start, STEPS, |_, state, u| {
        let mut wanted = vec![0.0; model.nv()];
        for (k, &(q, v)) in hinges.iter().enumerate() {
            let away = POSE[k % POSE.len()] - state.q[q];
            wanted[v] = RATE * RATE * away - 2.0 * RATE * state.v[v];
        }
        let tau = inverse_dynamics(model, state.q.as_slice(), state.v.as_slice(), &wanted);
        let inputs = u.iter_mut().zip(simulator.actuated());
        inputs.for_each(|(u, &v)| *u = tau[v]);
    })
}

/// The ball falls as one does, each arm moves as it would alone, the carried state is where the arms were, and the left motors bear the weight.
fn check(first: &Rollout, second: &Rollout, apart: &Rollout, ball: f64) {
    let (n, g) = (STEPS as f64, 9.81);
    let fallen = 2.5 - g * DT * DT * n * (n + 1.0) / 2.0;
    // q: seven entries of the ball, then the left and the right arm; afterwards the arms alone.
    let arms = first.last().q.rows(7, 12).into_owned();
    let lone = &apart.last().q;
    let off = (0..12).map(|k| (arms[k] - lone[k % 6]).abs());
    let off = off.fold(0.0, f64::max);
    let jump = (second.states[0].q.rows(0, 12) - &arms).amax();
    let borne = |rollout: &Rollout| {
        let u = &rollout.inputs[STEPS - 1];
        (0..6).map(|k| (u[k] - u[k + 6]).abs()).fold(0.0, f64::max)
    };
    let (before, after) = (borne(first), borne(second));
    println!("the ball is at {ball:.4} m, the arms are within {off:.0e} rad of a single arm");
    println!(
        "state kept within {jump:.0e} rad; the weight adds {after:.1} N·m to a left motor, {before:.0e} before"
    );
    assert!((ball - fallen).abs() < 1e-9 && off < 1e-9);
    assert!(jump == 0.0 && before < 1e-9 && after > 1.0);
}
