//! Our side of the comparison of scenes in contact with `MuJoCo`, which reads the same MJCF; `scenes.py` runs it.
//!
//! ```sh
//! scenes mjcf ROBOT                              # a robot of assets/
//! scenes load FILE                               # µs from the text to a simulator
//! scenes times FILE CONTROLS                     # µs of a step and of its Jacobians along the motion
//! scenes batch FILE CONTROLS STATES THREADS      # steps a second, all states kept, sensors read
//! ```
//!
//! A motion starts at the first keyframe of the file; each line of CONTROLS has a number for each actuator of the file, for one step.

#[path = "../common/mod.rs"]
mod common;

use std::time::Instant;

use common::clock::{Clock, arguments, is_test};
use common::robots::asset;
use dualbody::io::MjcfScene;
use dualbody::linearize::LinearizeScratch;
use dualbody::sim::{BatchMoment, BatchRollout, BatchScalar, BatchSimulator, Sensors, StepScratch};
use dualbody::{Linearization, ModelOptions, Simulator, State};

/// Runs of a motion, of which the median counts, and of a batch, of which the fastest does.
const ROUNDS: usize = 9;
/// Jacobians are taken at every so many states of a motion.
const EVERY: usize = 20;
/// By how much the coordinates of the starts of a batch differ, rad or m.
const SPREAD: f64 = 0.01;

fn main() {
    let arguments = arguments();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let number = |text: &str| text.parse().expect("a number");
    match arguments[..] {
        [] if is_test() => Scene::new(&xml("quadruped"), vec![Vec::new(); 3]).print_times(1),
        ["mjcf", robot] => println!("{}", xml(robot)),
        ["load", file] => print_loading(&read(file)),
        ["times", file, controls] => scene(file, controls).print_times(ROUNDS),
        ["batch", file, controls, states, threads] => {
            scene(file, controls).print_rate(number(states), number(threads));
        }
        _ => println!("usage: see benches/peers/scenes.py"),
    }
}

fn xml(robot: &str) -> String {
    asset(robot).to_mjcf().expect("a robot for MuJoCo")
}

fn read(file: &str) -> String {
    std::fs::read_to_string(file).expect("a file")
}

fn print_loading(text: &str) {
    let options = ModelOptions::default();
    let load = || {
        let (scene, _) = options.load_mjcf_scene_str(text).expect("a scene");
        drop(scene.simulator());
    };
    println!("load {:.3}", Clock::EXACT.median(load) * 1e6);
}

fn scene(file: &str, controls: &str) -> Scene {
    let row = |line: &str| {
        let numbers = line.split_whitespace();
        numbers.map(|x| x.parse().expect("a number")).collect()
    };
    Scene::new(&read(file), read(controls).lines().map(row).collect())
}

/// A scene, its start, and an input for each step.
struct Scene {
    simulator: Simulator,
    sensors: Sensors,
    start: State,
    inputs: Vec<Vec<f64>>,
}

impl Scene {
    fn new(text: &str, controls: Vec<Vec<f64>>) -> Self {
        let options = ModelOptions::default();
        let (scene, report) = options.load_mjcf_scene_str(text).expect("a scene");
        eprintln!("{report}");
        let start = scene.keyframes.first().map(|key| &key.state);
        let simulator = scene.simulator();
        Self {
            start: start_of(&simulator, start.unwrap_or(&scene.reference)),
            sensors: scene.known_sensors(),
            inputs: controls.iter().map(|u| inputs(&scene, u)).collect(),
            simulator,
        }
    }

    fn print_times(&self, rounds: usize) {
        let states = self.motion();
        let last = states.last().expect("a start");
        println!("steps {}", self.inputs.len());
        println!("touching {:.2}", self.touching(&states));
        println!("speed {:.3}", last.v.amax());
        println!("step {:.4}", 1e6 * typical(rounds, || self.steps()));
        let jacobians = typical(rounds.div_ceil(3), || self.jacobians(&states));
        println!("linearize {:.4}", 1e6 * jacobians);
    }

    fn motion(&self) -> Vec<State> {
        let mut states = vec![self.start.clone()];
        let mut scratch = StepScratch::new(&self.simulator);
        for u in &self.inputs {
            let mut next = self.start.clone();
            let state = &states[states.len() - 1];
            self.simulator.step_into(state, u, &mut scratch, &mut next);
            assert!(next.q.iter().all(|x| x.is_finite()), "a motion");
            states.push(next);
        }
        states
    }

    /// Contact points that carry something, on average.
    fn touching(&self, states: &[State]) -> f64 {
        let samples = states.iter().zip(&self.inputs).step_by(EVERY);
        let n = samples.clone().count();
        let all = samples.map(|(state, u)| {
            let report = self.simulator.contact_report(state, u);
            let pairs = report.pairs.iter().map(|pair| pair.force);
            let forces = report.forces.iter().copied().chain(pairs);
            forces.filter(|force| force.norm() > 0.0).count()
        });
        all.sum::<usize>() as f64 / n as f64
    }

    /// Seconds of each step.
    fn steps(&self) -> Vec<f64> {
        let mut scratch = StepScratch::new(&self.simulator);
        let (mut state, mut next) = (self.start.clone(), self.start.clone());
        let step = |u: &Vec<f64>| {
            let start = Instant::now();
            self.simulator.step_into(&state, u, &mut scratch, &mut next);
            let time = start.elapsed().as_secs_f64();
            std::mem::swap(&mut state, &mut next);
            time
        };
        self.inputs.iter().map(step).collect()
    }

    /// Seconds for A and B at each of the states where they are taken.
    fn jacobians(&self, states: &[State]) -> Vec<f64> {
        let mut scratch = LinearizeScratch::new(&self.simulator);
        let mut out = Linearization::zeros(&self.simulator);
        let samples = states.iter().zip(&self.inputs).step_by(EVERY);
        let jacobians = |(state, u): (&State, &Vec<f64>)| {
            let start = Instant::now();
            (self.simulator).linearize_into(state, u, &mut scratch, &mut out);
            start.elapsed().as_secs_f64()
        };
        samples.map(jacobians).collect()
    }

    fn print_rate(&self, states: usize, threads: usize) {
        let starts: Vec<State> = (0..states).map(|k| self.near(k)).collect();
        let mut batch = BatchSimulator::new(self.simulator.clone(), states).with_threads(threads);
        let least = match self.sensors.len() {
            0 => self.fastest_rollout(&starts, &mut batch),
            _ => self.fastest_with_readings(&starts, &mut batch),
        };
        println!("rate {:.1}", (states * self.inputs.len()) as f64 / least);
    }

    fn fastest_rollout(&self, starts: &[State], batch: &mut BatchSimulator) -> f64 {
        let mut out = BatchRollout::default();
        let control = |moment: &BatchMoment, _: &State<BatchScalar>, u: &mut [BatchScalar]| {
            let given = u.iter_mut().zip(&self.inputs[moment.step]);
            given.for_each(|(u, &x)| *u = BatchScalar::from(x));
        };
        fastest(|| batch.rollout_into(starts, self.inputs.len(), control, &mut out))
    }

    fn fastest_with_readings(&self, starts: &[State], batch: &mut BatchSimulator) -> f64 {
        let (n, width) = (starts.len(), self.sensors.len());
        let mut states = batch.states(starts);
        let row = self.start.numbers().count();
        let mut rows = vec![0.0; n * row * self.inputs.len()];
        let mut readings = vec![0.0; n * width * self.inputs.len()];
        fastest(|| {
            starts
                .iter()
                .enumerate()
                .for_each(|(i, start)| states.set(i, start));
            let memory = rows.chunks_mut(n * row).zip(readings.chunks_mut(n * width));
            for (u, (rows, readings)) in self.inputs.iter().zip(memory) {
                batch.step_and_read(&mut states, &u.repeat(n), &self.sensors, readings);
                states.copy_rows_to(rows);
            }
        })
    }

    /// The k-th start of a batch.
    fn near(&self, k: usize) -> State {
        let model = self.simulator.model();
        let small = |j: usize| SPREAD * ((1 + k * (2 * j + 3)) as f64).sin();
        let dv: Vec<f64> = (0..model.nv()).map(small).collect();
        let mut state = self.start.clone();
        state.q = model.integrate(self.start.q.as_slice(), &dv);
        state
    }
}

/// A state of the file with everything that the simulator adds to it.
fn start_of(simulator: &Simulator, state: &State) -> State {
    simulator.state(state.q.as_slice(), state.v.as_slice())
}

fn inputs(scene: &MjcfScene, control: &[f64]) -> Vec<f64> {
    match control.is_empty() {
        true => vec![0.0; scene.simulator().nu()],
        false => scene.inputs(control),
    }
}

/// Of each call the median over the rounds, which leaves out interruptions; then the mean over the calls.
fn typical(rounds: usize, seconds: impl FnMut() -> Vec<f64>) -> f64 {
    let all: Vec<Vec<f64>> = std::iter::repeat_with(seconds).take(rounds).collect();
    let median = |k: usize| {
        let mut times: Vec<f64> = all.iter().map(|times| times[k]).collect();
        times.sort_unstable_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let n = all[0].len();
    (0..n).map(median).sum::<f64>() / n as f64
}

fn fastest(mut run: impl FnMut()) -> f64 {
    let mut seconds = || {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..ROUNDS).map(|_| seconds()).fold(f64::INFINITY, f64::min)
}
