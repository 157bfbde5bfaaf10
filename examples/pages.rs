//! Pages of the HTML viewer: moving robots, a robot with sliders, a batch, a motion of an hour, and names that contain HTML. The checks in
//! `tests/browser/` open them.
//!
//! `cargo run --release --example pages` – writes to `out/pages/`.

use std::error::Error;
use std::fs;

use dualbody::dynamics::forward_kinematics;
use dualbody::model::{BodyId, Geometry, samples};
use dualbody::spatial::{Quaternion, Transform};
use dualbody::view::{Recording, model_page};
use dualbody::{Model, Simulator, State};
use nalgebra::Vector3;
use rand::{SeedableRng, rngs::Xoshiro256PlusPlus};

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");
const OUT: &str = "out/pages";

type Outcome = Result<(), Box<dyn Error>>;

fn main() -> Outcome {
    fs::create_dir_all(OUT)?;
    moving()?;
    by_hand()?;
    batch()?;
    hour()?;
    hostile()
}

/// Ten seconds of a cart-pole that falls, with its path, the force on the cart, and the numbers beside it.
fn moving() -> Outcome {
    let model = Model::from_urdf_file(format!("{ROBOTS}/cartpole.urdf"))?;
    let simulator = Simulator::new(model)
        .with_time_step(0.01)
        .with_actuated_joints(&["linear"])?;
    let start = State::new(&[0.0, 0.3], &[0.0; 2]);
    let rollout = simulator.rollout(&start, 1000, |time, _, u| u[0] = 2.0 * (2.0 * time).cos());
    let mut recording = Recording::from_rollout(simulator.model(), &rollout);
    let track = recording.robot_mut(0);
    let push = |k: usize| rollout.inputs.get(k).map_or(0.0, |u| u[0]);
    let forces: Vec<_> = (0..=1000).map(|k| Vector3::y() * push(k)).collect();
    track.add_force("cart", forces)?.trace("cart")?;
    recording.save_csv(format!("{OUT}/cartpole.csv"))?;
    recording.save_html(format!("{OUT}/cartpole.html"))?;
    recording.save_html(format!("{OUT}/index.html"))?;
    let size = fs::metadata(format!("{OUT}/cartpole.html"))?.len();
    println!("ten seconds of a cart-pole: {size} bytes");
    assert!(size < 300_000);
    Ok(())
}

/// A humanoid with sliders, and poses that the sliders must lead to.
fn by_hand() -> Outcome {
    let model = Model::from_urdf_file(format!("{ROBOTS}/humanoid.urdf"))?;
    fs::write(format!("{OUT}/humanoid.html"), model_page(&model))?;
    let mut q = model.random_configuration(&mut Xoshiro256PlusPlus::seed_from_u64(1));
    q.rows_mut(0, 7).copy_from(&model.neutral().rows(0, 7));
    let kinematics = forward_kinematics(&model, q.as_slice(), &vec![0.0; model.nv()]);
    let pose = |body: usize| {
        let pose = kinematics.pose(Some(BodyId(body)));
        let (p, r) = (pose.translation, Quaternion::from_matrix(&pose.rotation));
        [p.x, p.y, p.z, r.w, r.xyz.x, r.xyz.y, r.xyz.z]
    };
    let poses: Vec<_> = (0..model.n_bodies()).map(pose).collect();
    let text = format!("{{\"q\": {:?}, \"poses\": {poses:?}}}", q.as_slice());
    Ok(fs::write(format!("{OUT}/humanoid.json"), text)?)
}

/// Nine double pendulums side by side that start almost alike.
fn batch() -> Outcome {
    let simulator = Simulator::new(samples::double_pendulum()).with_time_step(0.01);
    let start = |k: usize| State::new(&[2.0 + 0.01 * k as f64, 1.0], &[0.0; 2]);
    let starts: Vec<State> = (0..9).map(start).collect();
    let mut batch = dualbody::sim::BatchSimulator::new(simulator, 9);
    let rollout = batch.rollout(&starts, 1000, |_, _, _| {});
    let mut recording = Recording::from_batch(&batch, &rollout, &[0, 1, 2, 3, 4, 5, 6, 7, 8]);
    recording.spread(3.0);
    Ok(recording.save_html(format!("{OUT}/batch.html"))?)
}

/// An hour of a pendulum, a hundred states a second.
fn hour() -> Outcome {
    let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01);
    let start = State::new(&[0.0, 3.0], &[0.0; 2]);
    let rollout = simulator.rollout(&start, 360_000, |_, _, _| {});
    let recording = Recording::from_rollout(simulator.model(), &rollout);
    recording.save_html(format!("{OUT}/hour.html"))?;
    let size = fs::metadata(format!("{OUT}/hour.html"))?.len();
    println!("an hour of a cart-pole: {size} bytes");
    assert!(size < 40_000_000);
    Ok(())
}

/// A robot whose names would run as code if they were not shown as text.
fn hostile() -> Outcome {
    let xml = "<robot name=\"&lt;script&gt;hacked = 1&lt;/script&gt;\"><link name=\"world\"/>\
        <link name=\"&lt;img src=x onerror='hacked = 2'&gt; &quot;quoted&quot;\"><inertial><mass value=\"1\"/>\
        <inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>\
        <visual><geometry><mesh filename=\"&lt;b&gt;.stl\"/></geometry></visual></link>\
        <joint name=\"&lt;/script&gt;'\" type=\"continuous\"><parent link=\"world\"/>\
        <child link=\"&lt;img src=x onerror='hacked = 2'&gt; &quot;quoted&quot;\"/></joint></robot>";
    let model = Model::from_urdf_str(xml)?;
    let mut recording = Recording::new(&model);
    recording.push(0.0, &State::new(&[0.0], &[1.0]), &[]);
    recording.push(1.0, &State::new(&[1.0], &[1.0]), &[]);
    recording.add_series("</script><script>hacked = 3</script>", [0.0, 1.0]);
    let (ball, color) = (Geometry::Sphere { radius: 0.1 }, [0.9, 0.3, 0.2, 0.5]);
    let beside = Transform::from_translation(Vector3::x() * 0.3);
    recording.add_shape("<img src=x onerror='hacked = 4'>", ball, beside, color);
    recording.add_axes("\"goal\" </script>", beside);
    Ok(recording.save_html(format!("{OUT}/hostile.html"))?)
}
