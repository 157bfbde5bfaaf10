//! The task: a quadruped on position servos walks along x, while it is pushed, and its masses are not those that are known.

use std::error::Error;
use std::f64::consts::{PI, TAU};

use dualbody::model::BodyId;
use dualbody::sim::{BATCH_WIDTH, BatchScalar, BatchSimulator, Environment, Environments, Episode};
use dualbody::{Lanes, Simulator, State};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, RngExt, SeedableRng};

use super::{leg, quadruped};

pub(crate) const TIME_STEP: f64 = 4e-3;
/// Time steps for each action, and seconds of an episode.
pub(crate) const DECIMATION: usize = 5;
pub(crate) const DURATION: f64 = 10.0;
/// Stiffness and damping of the servos, N·m/rad and N·m·s/rad.
const GAINS: [f64; 2] = [80.0, 2.0];

/// Side of each leg, 1 for a left one, and its place in the pattern of a trot.
const SIDES: [f64; 4] = [-1.0, 1.0, -1.0, 1.0];
const PHASES: [f64; 4] = [0.0, 0.5, 0.5, 0.0];
/// Trots a second.
const FREQUENCY: f64 = 2.5;

/// Pushes of an episode, how long each lasts, s, and its least and greatest force, N.
const PUSHES: usize = 4;
const PUSH: f64 = 0.1;
const FORCES: [f64; 2] = [20.0, 60.0];
/// Greatest relative error of the mass of a link, and of friction.
const ERROR: f64 = 0.2;
/// Speed that is rewarded, m/s.
pub(crate) const SPEED: f64 = 0.65;

/// Entries of an action: the way of a foot on the ground and its height in the middle of a swing, m, then offsets of the feet along x, y, z, m.
pub(crate) const ACTIONS: usize = 14;
/// Entries of an observation.
pub(crate) const OBSERVED: usize = 9;

/// The robot: a position servo in each joint, regularised ground under the feet, and a hand at the trunk.
pub(crate) fn robot() -> Result<Simulator, Box<dyn Error>> {
    quadruped::on_servos(GAINS, TIME_STEP)
}

/// Walks along x.
pub(crate) struct Walk {
    stand: State,
}

impl Walk {
    /// Episodes of the task, each on the robot, from the start, and with the pushes of its seed.
    pub(crate) fn episodes(simulator: &Simulator, seeds: &[u64]) -> Environments<Self> {
        let rows = seeds.iter().flat_map(|&seed| another(simulator, seed));
        let batch = BatchSimulator::of_parameters(simulator, &rows.collect::<Vec<_>>());
        let mut stand: State = simulator.neutral_state();
        stand.q[2] = -leg::UNDER[2] + 0.02;
        for (k, side) in SIDES.into_iter().enumerate() {
            let q = leg::joints(side, under(side));
            stand.q.as_mut_slice()[7 + 3 * k..10 + 3 * k].copy_from_slice(&q);
        }
        let mut out = Environments::new(Self { stand }, batch, 0).with_decimation(DECIMATION);
        for (i, &seed) in seeds.iter().enumerate() {
            out.seed(i, seed);
        }
        out
    }
}

/// The parameters of a robot whose masses and friction are not those that are known.
fn another(simulator: &Simulator, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5eed);
    let mut factor = || 1.0 + rng.random_range(-ERROR..ERROR);
    let mut model = simulator.model().clone();
    for k in 0..model.n_bodies() {
        let inertia = model.bodies()[k].inertia.scaled(factor());
        model = model.with_inertia(BodyId(k), inertia);
    }
    let other = simulator.with_model(model).expect("the same structure");
    let mut row = other.parameters().as_slice().to_vec();
    let (layout, friction) = (other.parameter_layout(), factor());
    for (x, name) in row.iter_mut().zip(layout.names()) {
        if name.starts_with("contact ") && name.ends_with(": friction") {
            *x *= friction;
        }
    }
    row
}

fn under(side: f64) -> [f64; 3] {
    let [x, y, z] = leg::UNDER;
    [x, side * y, z]
}

/// Place of a leg in its trot at a time, of [0, 1): on the ground in the first half, in the air in the second one.
pub(crate) fn phase(leg: usize, time: f64) -> f64 {
    (FREQUENCY * time + PHASES[leg]).rem_euclid(1.0)
}

/// Place of a foot at a phase of its trot, relative to where it stands: along a stride, and up along a lift, of 1 m.
fn trot(phase: f64) -> [f64; 2] {
    let swing = PI * (2.0 * phase - 1.0);
    match phase < 0.5 {
        true => [0.5 - 2.0 * phase, 0.0],
        false => [-0.5 * swing.cos(), swing.sin()],
    }
}

impl Environment for Walk {
    fn n_actions(&self) -> usize {
        ACTIONS
    }

    fn n_observations(&self) -> usize {
        OBSERVED
    }

    /// Time and force along x and y of each push.
    fn n_drawn(&self) -> usize {
        3 * PUSHES
    }

    fn start(&self, rng: &mut dyn Rng, state: &mut State, drawn: &mut [f64]) {
        state.clone_from(&self.stand);
        let joints = state.q.as_mut_slice()[7..].iter_mut();
        joints.for_each(|q| *q += rng.random_range(-0.05..0.05));
        for (k, push) in drawn.chunks_exact_mut(3).enumerate() {
            let share = DURATION / PUSHES as f64;
            let (force, angle) = (
                rng.random_range(FORCES[0]..FORCES[1]),
                rng.random_range(0.0..TAU),
            );
            push[0] = share * (k as f64 + rng.random_range(0.2..0.8));
            (push[1], push[2]) = (force * angle.cos(), force * angle.sin());
        }
    }

    fn act(&self, now: &Episode<'_>, action: &[BatchScalar], u: &mut [BatchScalar]) {
        for lane in 0..BATCH_WIDTH {
            let time = now.time.0[lane];
            let action = |j: usize| action[j].0[lane];
            let (stride, lift) = (action(0).clamp(0.0, 0.3), action(1).clamp(0.0, 0.12));
            for (k, &side) in SIDES.iter().enumerate() {
                let ([x, y, z], [along, up]) = (under(side), trot(phase(k, time)));
                let offset = |axis: usize| action(2 + 3 * k + axis).clamp(-0.1, 0.1);
                let x = x + stride * along + offset(0);
                let foot = [x, y + offset(1), z + lift * up + offset(2)];
                let joints = u[3 * k..3 * k + 3].iter_mut().zip(leg::joints(side, foot));
                joints.for_each(|(u, q)| u.0[lane] = q);
            }
            for push in now.drawn.chunks_exact(3) {
                if (push[0].0[lane]..push[0].0[lane] + PUSH).contains(&time) {
                    (u[12].0[lane], u[13].0[lane]) = (push[1].0[lane], push[2].0[lane]);
                }
            }
        }
    }

    /// The phase of the trot; the vertical in the trunk, along x and y; angular velocity; velocity along x and y; direction.
    fn observe(&self, now: &Episode<'_>, out: &mut [BatchScalar]) {
        let (q, v) = (&now.state.q, &now.state.v);
        let [w, x, y, z] = [q[3], q[4], q[5], q[6]];
        out[0] = Lanes(now.time.0.map(|time| phase(0, time)));
        (out[1], out[2]) = ((x * z - w * y) * 2.0, (y * z + w * x) * 2.0);
        out[3..6].copy_from_slice(&v.as_slice()[3..6]);
        out[6..8].copy_from_slice(&v.as_slice()[..2]);
        out[8] = (x * y + w * z) * 2.0;
    }

    /// The speed along x, up to one that is enough, and less for directions and sideways speeds that are not meant.
    fn reward(&self, now: &Episode<'_>, _: &[BatchScalar]) -> BatchScalar {
        let (q, v) = (&now.state.q, &now.state.v);
        let [w, x, y, z] = [q[3], q[4], q[5], q[6]];
        let (yaw, tilt) = ((x * y + w * z) * 2.0, x * x + y * y);
        let speed = Lanes(v[0].0.map(|speed| speed.clamp(-0.5, SPEED)));
        speed + 0.5 - yaw * yaw - tilt * 4.0 - v[1] * v[1] * 0.3 - v[5] * v[5] * 0.02
    }

    fn is_over(&self, now: &Episode<'_>) -> [bool; BATCH_WIDTH] {
        let q = &now.state.q;
        std::array::from_fn(|lane| {
            let [z, x, y] = [q[2], q[4], q[5]].map(|q| q.0[lane]);
            z < 0.15 || 1.0 - 2.0 * (x * x + y * y) < 0.6
        })
    }
}
