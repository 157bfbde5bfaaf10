//! The simulation: time, commands, targets, recording.

use std::fmt;
use std::time::{Duration, Instant};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::drag::Drag;
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::memory;
use crate::model::BodyId;
use crate::sim::{RolloutStatus, Simulator, State, StepScratch};
use crate::view::recording::Recording;
use crate::view::shape::{Pose, pose};

/// Maximum computing time of the steps of a frame; slower simulations run slower than requested.
const BUSY: Duration = Duration::from_millis(12);

/// Steps between two looks at the clock.
const STEPS: usize = 8;

/// Maximum absence of a page that is made up for.
const AWAY: Duration = Duration::from_millis(100);

/// Times between recorded moments, s.
const RECORDED: f64 = 1.0 / 60.0;

/// Fastest speed, in seconds of the simulation a second.
const FASTEST: f64 = 100.0;

/// Bytes of a recorded number with what is kept beside it, for the limit of memory.
const NUMBER: usize = 16;

/// Part of the memory limit that a recording may take.
const PART: usize = 8;

/// Sets the input of a step.
pub(super) type Control = Box<dyn FnMut(f64, &State, &mut [f64]) + Send>;

pub(super) struct World {
    simulator: Simulator,
    start: State,
    state: State,
    next: State,
    scratch: StepScratch<f64>,
    u: Vec<f64>,
    start_u: Vec<f64>,
    control: Option<Control>,
    drag: Option<Drag>,
    steps: u64,
    pace: Pace,
    trouble: Option<String>,
    recording: Recording,
}

/// Pace of simulated time.
#[derive(Debug)]
struct Pace {
    is_paused: bool,
    speed: f64,
    last: Instant,
    /// Time that is to be simulated, s.
    debt: f64,
    /// Seconds simulated a second, over some frames.
    factor: f64,
}

/// Commands of a page.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
enum Order {
    Pause(bool),
    /// Takes a step and stays paused.
    Step(u32),
    Speed(f64),
    Reset,
    /// Sets an input.
    Target {
        input: usize,
        value: f64,
    },
    /// Pulls a point of a body, in the body, to a position in the world.
    Drag {
        body: usize,
        at: [f64; 3],
        to: [f64; 3],
    },
    /// Releases the body.
    Release,
}

/// A slider of the page.
#[derive(Debug, Serialize)]
pub(super) struct Slider {
    input: usize,
    name: String,
    lower: f64,
    upper: f64,
    value: f64,
    unit: &'static str,
}

/// Content of a page.
#[derive(Serialize)]
struct Frame {
    time: f64,
    paused: bool,
    speed: f64,
    factor: f64,
    poses: Vec<Pose>,
    /// Place and force of each contact that carries something, m and N.
    contacts: Vec<[f64; 6]>,
    /// The point that is dragged, and where to.
    drag: Option<[f64; 6]>,
    trouble: Option<String>,
}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("World")
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

impl World {
    pub(super) fn new(
        simulator: Simulator,
        start: &State,
        u: Vec<f64>,
        control: Option<Control>,
    ) -> Self {
        let mut out = Self {
            start: start.clone(),
            state: start.clone(),
            next: start.clone(),
            scratch: StepScratch::new(&simulator),
            start_u: u.clone(),
            u,
            control,
            drag: None,
            steps: 0,
            pace: Pace {
                is_paused: false,
                speed: 1.0,
                last: Instant::now(),
                debt: 0.0,
                factor: 0.0,
            },
            trouble: None,
            recording: Recording::new(simulator.model()),
            simulator,
        };
        out.reset();
        out
    }

    pub(super) fn state(&self) -> &State {
        &self.state
    }

    /// The recorded motion, with its ground.
    pub(super) fn recording(&self) -> Recording {
        let mut out = self.recording.clone();
        if let Some(contacts) = self.simulator.contacts() {
            out.show_ground(contacts.terrain());
        }
        out
    }

    /// Sliders of the inputs that are targets of joints.
    pub(super) fn controls(&self) -> Vec<Slider> {
        /// Range of a joint without limits, rad or m, about its start.
        const FREE: f64 = std::f64::consts::PI;
        if self.control.is_some() {
            return Vec::new();
        }
        let names = self.simulator.input_names();
        let inputs = self.simulator.actuated().iter().zip(names).enumerate();
        let sliders = inputs.filter_map(|(input, (&v, name))| {
            let q = self.simulator.coordinate(v)?;
            let model = self.simulator.model();
            let part = model
                .joint_parts()
                .find(|part| model.body(part.body).q == q)?;
            let is_sliding = model.body(part.body).joint == crate::joint::JointKind::Prismatic;
            let value = self.u[input];
            Some(Slider {
                input,
                name,
                lower: part.limits.lower.unwrap_or(value - FREE).min(value),
                upper: part.limits.upper.unwrap_or(value + FREE).max(value),
                value,
                unit: if is_sliding { "m" } else { "rad" },
            })
        });
        sliders.collect()
    }

    /// Restarts the clock after an absence of the page.
    pub(super) fn wake(&mut self) {
        if self.pace.last.elapsed() > AWAY {
            self.pace.last = Instant::now();
        }
    }

    /// Executes a command of a page; ignores other messages.
    pub(super) fn obey(&mut self, text: &str) {
        let Ok(order) = serde_json::from_str(text) else {
            return;
        };
        match order {
            Order::Pause(paused) => self.pace.is_paused = paused,
            Order::Step(steps) => {
                self.pace.is_paused = true;
                self.take_steps(steps.clamp(1, 1000) as usize, Instant::now() + BUSY);
            }
            Order::Speed(speed) if speed > 0.0 => self.pace.speed = speed.min(FASTEST),
            Order::Target { input, value } if value.is_finite() => {
                if let Some(u) = self.u.get_mut(input) {
                    *u = value;
                }
            }
            Order::Drag { body, at, to } => self.pull(body, at, Vector3::from(to)),
            Order::Release => self.release(),
            Order::Reset => self.reset(),
            Order::Speed(_) | Order::Target { .. } => {}
        }
    }

    fn pull(&mut self, body: usize, at: [f64; 3], to: Vector3<f64>) {
        if !to.iter().all(|x| x.is_finite()) {
            return;
        }
        if self.drag.is_none() {
            self.drag = Drag::new(&self.simulator, &self.state, body, at);
            if let Some(drag) = &self.drag {
                self.scratch = StepScratch::new(&drag.simulator);
            }
        }
        if let Some(drag) = &mut self.drag {
            drag.to = to;
        }
    }

    fn release(&mut self) {
        if self.drag.take().is_some() {
            self.scratch = StepScratch::new(&self.simulator);
        }
    }

    fn reset(&mut self) {
        self.release();
        self.state = self.start.clone();
        self.u.clone_from(&self.start_u);
        (self.steps, self.trouble, self.pace.debt) = (0, None, 0.0);
        self.recording = Recording::new(self.simulator.model());
        self.recording
            .robot_mut(0)
            .name_inputs(self.simulator.input_names());
        self.record();
    }

    fn time(&self) -> f64 {
        self.steps as f64 * self.simulator.time_step()
    }

    /// Moves to the present, as far as there is time for it.
    pub(super) fn advance(&mut self) {
        let (now, dt) = (Instant::now(), self.simulator.time_step());
        let elapsed = now.duration_since(self.pace.last).min(AWAY).as_secs_f64();
        self.pace.last = now;
        if self.pace.is_paused || elapsed == 0.0 {
            return;
        }
        self.pace.debt += elapsed * self.pace.speed;
        let due = (self.pace.debt / dt) as usize;
        let taken = self.take_steps(due, now + BUSY);
        self.pace.debt = if taken < due {
            0.0
        } else {
            self.pace.debt - taken as f64 * dt
        };
        self.pace.factor += 0.1 * (taken as f64 * dt / elapsed - self.pace.factor);
    }

    /// Takes steps until a time, and returns their number.
    fn take_steps(&mut self, most: usize, until: Instant) -> usize {
        for step in 0..most {
            if self.trouble.is_some() || step % STEPS == 0 && Instant::now() > until {
                return step;
            }
            self.take_step();
        }
        most
    }

    fn take_step(&mut self) {
        let time = self.time();
        if let Some(control) = &mut self.control {
            control(time, &self.state, &mut self.u);
        }
        match &mut self.drag {
            None => {
                let (state, u) = (&self.state, &self.u);
                self.simulator
                    .step_into(state, u, &mut self.scratch, &mut self.next);
            }
            Some(drag) => {
                let (_, force) = drag.force(&self.state);
                let u: Vec<f64> = self.u.iter().chain(force.iter()).copied().collect();
                drag.simulator
                    .step_into(&self.state, &u, &mut self.scratch, &mut self.next);
            }
        }
        let is_input_finite = self.u.iter().all(|u| u.is_finite());
        let bound = self.simulator.divergence_bound();
        if !is_input_finite || RolloutStatus::after(0, &self.next, bound, 0..1).is_some() {
            self.trouble = Some(format!(
                "The motion diverged after {time:.3} s: reset it, or take a shorter step."
            ));
            return;
        }
        std::mem::swap(&mut self.state, &mut self.next);
        self.steps += 1;
        let last = self
            .recording
            .times()
            .last()
            .copied()
            .unwrap_or(f64::NEG_INFINITY);
        if self.time() - last >= RECORDED * (1.0 - 1e-9) {
            self.record();
        }
    }

    /// Adds a moment, as long as there is room.
    fn record(&mut self) {
        let bytes = NUMBER * (self.state.len() + self.u.len() + 1);
        if self.recording.len() < memory::limit() / PART / bytes {
            self.recording.push(self.time(), &self.state, &self.u);
        }
    }

    /// The current content of a page, as JSON.
    pub(super) fn frame(&mut self) -> String {
        let model = self.simulator.model();
        let mut kinematics = Kinematics::new(model);
        forward_kinematics_into(
            model,
            self.state.q.as_slice(),
            self.state.v.as_slice(),
            &mut kinematics,
        );
        let bodies = (0..model.n_bodies()).map(BodyId);
        let frame = Frame {
            time: self.time(),
            paused: self.pace.is_paused,
            speed: self.pace.speed,
            factor: self.pace.factor,
            poses: bodies
                .map(|body| pose(&kinematics.pose(Some(body))))
                .collect(),
            contacts: self.contacts(),
            drag: self.drag.as_mut().map(|drag| {
                let (point, to) = (drag.force(&self.state).0, drag.to);
                [point.x, point.y, point.z, to.x, to.y, to.z]
            }),
            trouble: self.trouble.clone(),
        };
        // Numbers that JSON has no word for become null; there is nothing else that could go wrong.
        serde_json::to_string(&frame).unwrap_or_default()
    }

    fn contacts(&self) -> Vec<[f64; 6]> {
        if self.simulator.contacts().is_none() {
            return Vec::new();
        }
        let report = self.simulator.contact_report(&self.state, &self.u);
        let ground = report
            .points
            .iter()
            .map(|point| point.position)
            .zip(report.forces.iter().copied());
        let pairs = report
            .pairs
            .iter()
            .map(|pair| (pair.point.position, pair.force));
        let all = ground.chain(pairs).filter(|(_, force)| force.norm() > 0.0);
        all.map(|(p, f)| [p.x, p.y, p.z, f.x, f.y, f.z]).collect()
    }
}
