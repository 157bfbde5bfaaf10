//! A gripper lifts a box by friction. Optimisation through the contact finds the least grip force that holds the box: one backward pass through the
//! rollout gives the gradient of a cost of the lift in the grip force.
//!
//! `cargo run --release --example gripper` – writes `out/gripper/index.html`, a page that opens in any browser.

use std::error::Error;

use dualbody::contact::{CollisionOptions, ContactLaw, Rigid, Terrain};
use dualbody::joint::JointKind::Prismatic;
use dualbody::linearize::RolloutCost;
use dualbody::model::{JointSpec, LinkSpec, Mass, ModelBuilder, Object, World};
use dualbody::sim::Rollout;
use dualbody::spatial::Transform;
use dualbody::trajopt::{MinimizeOptions, Minimizer, Objective, minimize};
use dualbody::{Contacts, Recording, Scalar, Simulator, State};
use nalgebra::DVector;

const DT: f64 = 0.005;
const STEPS: usize = 200;
const FRICTION: f64 = 0.5;
/// Masses of palm, finger and box, kg, and the width of the box, m.
const PALM: f64 = 1.0;
const FINGER: f64 = 0.1;
const BOX: f64 = 0.5;
const WIDTH: f64 = 0.06;
/// The palm is driven up with this acceleration for half of the time, then down with it, m/s².
const ACCELERATION: f64 = 1.0;
const GRAVITY: f64 = 9.81;
/// Weights of the height that is missing, 1/m², and of the force, 1/N².
const LIFT: f64 = 1e3;
const EFFORT: f64 = 1e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let lift = Lift {
        simulator: simulator()?,
    };
    let firm = [15.0];
    let found = minimize(&lift, &firm, Minimizer::Lbfgs, &MinimizeOptions::default());
    // Two fingers bear m (g + a) by friction.
    let needed = BOX * (GRAVITY + ACCELERATION) / (2.0 * FRICTION);
    let raised = |force: f64| lift.rollout(force).last().q[2];
    let (held, lost) = (raised(found.x[0]), raised(0.85 * found.x[0]));
    println!(
        "grip force {:.4} N instead of {} N, {} after {} iterations; friction needs {needed:.4} N",
        found.x[0], firm[0], found.status, found.iterations
    );
    println!("the box is raised by {held:.4} m, with 85 % of the force by {lost:.4} m");
    assert!((found.x[0] / needed - 1.0).abs() < 0.03);
    assert!((held - height()).abs() < 0.01 && lost < height() - 0.03);

    std::fs::create_dir_all("out/gripper")?;
    let rollout = lift.rollout(found.x[0]);
    let recording = Recording::of_simulation(&lift.simulator, &rollout).with_title("gripper");
    Ok(recording.save_html("out/gripper/index.html")?)
}

/// Height to which a box that is held gets, m.
fn height() -> f64 {
    let half = DT * STEPS as f64 / 2.0;
    ACCELERATION * half * half
}

/// The box is the first member of the world by its name, the gripper the second: q is the pose of the box, then lift, left, right.
fn simulator() -> Result<Simulator, Box<dyn Error>> {
    let mut builder = ModelBuilder::new("gripper");
    builder.add_link(LinkSpec::new("world"));
    let palm = LinkSpec::solid_box("palm", [0.2, 0.06, 0.03], Mass::Kilograms(PALM));
    builder.add_link(palm);
    let up = JointSpec::new("lift", Prismatic, "world", "palm").with_axis([0.0, 0.0, 1.0]);
    builder.add_joint(up.with_translation([0.0, 0.0, 0.12]));
    for (name, side) in [("left", -1.0), ("right", 1.0)] {
        let finger = LinkSpec::solid_box(name, [0.02, 0.05, 0.08], Mass::Kilograms(FINGER));
        builder.add_link(finger);
        let close = JointSpec::new(format!("close {name}"), Prismatic, "palm", name);
        let at = [side * (WIDTH / 2.0 + 0.01), 0.0, -0.06];
        builder.add_joint(close.with_axis([-side, 0.0, 0.0]).with_translation(at));
    }
    let mut world = World::new("gripper");
    world.add(&builder.build()?, "gripper/", &Transform::identity())?;
    let at = Transform::from_translation([0.0, 0.0, WIDTH / 2.0].into());
    let green = Object::free(Mass::Kilograms(BOX)).with_color([0.3, 0.7, 0.4, 1.0]);
    world.add_box("box", [WIDTH; 3], &green.at(at))?;
    let model = world.build()?;
    let law = ContactLaw::Rigid(Rigid {
        friction: FRICTION,
        restitution: 0.0,
        ..Rigid::default()
    });
    let options = CollisionOptions::default();
    let contacts =
        Contacts::new(&model, Terrain::flat(0.0), law).with_collisions(&model, law, &options)?;
    let inputs = ["gripper/lift", "gripper/close left", "gripper/close right"];
    Ok(Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(DT)
        .with_actuated_joints(&inputs)?)
}

/// The cost of a lift as a function of the grip force.
struct Lift {
    simulator: Simulator,
}

/// Square of the height that the box lacks.
struct Missing;

impl RolloutCost for Missing {
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        let off = last.q[2] - height();
        off * off * LIFT
    }
}

impl Lift {
    /// Palm and box are driven up, then slowed down; the fingers close with a constant force.
    fn inputs(force: f64) -> Vec<DVector<f64>> {
        let mass = PALM + 2.0 * FINGER + BOX;
        let input = |k: usize| {
            let sign = if k < STEPS / 2 { 1.0 } else { -1.0 };
            DVector::from_vec(vec![mass * (GRAVITY + sign * ACCELERATION), force, force])
        };
        (0..STEPS).map(input).collect()
    }

    fn rollout(&self, force: f64) -> Rollout {
        let inputs = Self::inputs(force);
        let start = self.simulator.neutral_state();
        let mut given = inputs.iter();
        self.simulator.rollout(&start, STEPS, |_, _, u| {
            let next = given.next();
            next.iter()
                .for_each(|next| u.copy_from_slice(next.as_slice()));
        })
    }
}

impl Objective for Lift {
    fn value(&self, x: &[f64]) -> f64 {
        Missing.end(self.rollout(x[0]).last()) + 0.5 * EFFORT * x[0] * x[0]
    }

    fn gradient(&self, x: &[f64]) -> DVector<f64> {
        let start = self.simulator.neutral_state();
        let found = self
            .simulator
            .rollout_gradient(&start, &Self::inputs(x[0]), &Missing);
        let by_force = found.inputs.iter().map(|u| u[1] + u[2]);
        DVector::from_element(1, by_force.sum::<f64>() + EFFORT * x[0])
    }
}
