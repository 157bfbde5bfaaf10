//! Compiled functions beside the library's own code, the folder they are kept in, and errors.
//!
//! Without a C compiler the tests that need one print a line, and pass.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use dualbody::contact::{
    CollisionOptions, ContactLaw, Contacts, LinkShapes, RelaxedRigid, SoftContact, Terrain,
};
use dualbody::joint::JointKind;
use dualbody::linearize::Linearization;
use dualbody::model::{Base, JointSpec, LinkSpec, Mass, ModelBuilder, samples};
use dualbody::sim::RolloutStatus;
use dualbody::trajopt::{
    Activation, Cost, Ddp, InputError, Problem, Robot, StateError, Trajectory,
};
use dualbody::{Integrator, Model, Simulator, State, StopSignal, codegen};
use dualbody_native::{Compiler, NativeError, NativeFunction, NativeScratch, NativeSimulator};

/// Sums in another order, sines of another library.
const ROUNDING: f64 = 1e-12;
/// How far velocities after a compiled step in contact may be from the library's, relative to the change of velocity in the step: thirty times as far as
/// those of a quadruped were found to be along the motion of the test.
const ERROR_OF_CONTACT: f64 = 1e-9;

/// A folder of one test, which goes with it.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("dualbody-native-{}-{test}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        Self(path)
    }

    fn compiler(&self) -> Compiler {
        Compiler::default().with_cache(&self.0)
    }

    /// The compiler; `None`, with a message, if there is none.
    fn compiler_if_any(&self) -> Option<Compiler> {
        let graph = codegen::mass_matrix(&samples::pendulum());
        match NativeFunction::<f64>::new(&graph, "probe", &self.compiler()) {
            Err(NativeError::NoCompiler { command, .. }) => {
                eprintln!("not tested: there is no C compiler \"{command}\"");
                None
            }
            found => {
                found.expect("a function that every compiler takes");
                Some(self.compiler())
            }
        }
    }

    /// Folders of functions called `name`.
    fn kept(&self, name: &str) -> Vec<PathBuf> {
        let entries = fs::read_dir(&self.0)
            .expect("the folder")
            .map(|entry| entry.expect("an entry").path());
        let begins = |path: &PathBuf| {
            let own = path
                .file_name()
                .map(|own| own.to_string_lossy().into_owned());
            own.is_some_and(|own| own.starts_with(name))
        };
        entries.filter(begins).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn state(model: &Model, seed: usize) -> State {
    let number = |k: usize| ((seed * 31 + k * 17) as f64).sin();
    let dq: Vec<f64> = (0..model.nv()).map(number).collect();
    let q = model.integrate(model.neutral().as_slice(), &dq);
    let v: Vec<f64> = (0..model.nv()).map(|k| 2.0 * number(k + 50)).collect();
    State::new(q.as_slice(), &v)
}

fn distance(a: &State, b: &State) -> f64 {
    let off = a
        .numbers()
        .zip(b.numbers())
        .map(|(a, b)| (a - b).abs() / (1.0 + b.abs()));
    off.fold(0.0, f64::max)
}

#[test]
fn steps_and_jacobians_equal_those_of_the_library() {
    let folder = Folder::new("steps");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    let free = samples::random_tree(5, 3);
    let robots = [samples::cartpole(), samples::arm(), free];
    let euler = robots
        .into_iter()
        .map(|model| (model, Integrator::SemiImplicitEuler));
    let others =
        [Integrator::ImplicitVelocity, Integrator::RungeKutta4].map(|i| (samples::cartpole(), i));
    for (model, integrator) in euler.chain(others) {
        let simulator = Simulator::new(model)
            .with_time_step(1e-3)
            .with_integrator(integrator);
        let native = NativeSimulator::new(simulator.clone(), &compiler).expect("a step");
        let native = native.with_jacobians(&compiler).expect("Jacobians");
        let (mut scratch, mut next) = (NativeScratch::new(&native), simulator.neutral_state());
        let mut found = Linearization::zeros(&simulator);
        for seed in 0..5 {
            let state = state(simulator.model(), seed);
            let u: Vec<f64> = (0..simulator.nu()).map(|k| (seed + k) as f64).collect();
            native.step_into(&state, &u, &mut scratch, &mut next);
            let off = distance(&next, &simulator.step(&state, &u));
            assert!(
                off < ROUNDING,
                "{integrator:?}, {}: {off:e}",
                simulator.model().name()
            );
            native.linearize_into(&state, &u, &mut scratch, &mut found);
            let own = simulator.linearize(&state, &u);
            let off = (found.a.clone() - own.a)
                .amax()
                .max((found.b.clone() - own.b).amax());
            assert!(
                off < 1e-10,
                "{integrator:?}, {}: {off:e}",
                simulator.model().name()
            );
        }
    }
}

/// A quadruped on its feet with regularised contact.
fn quadruped() -> Simulator {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let model = Model::from_urdf_file(assets.join("quadruped.urdf")).expect("a robot");
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let feet = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_links(&model, &feet)
        .expect("feet");
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(2e-3)
}

// Compiled for this very machine, products with sums are rounded once, which graphs that are evaluated do twice: near the end of the path to the
// forces that difference grows, and must not keep them from being found.
#[test]
fn compiled_steps_of_a_quadruped_on_its_feet_equal_those_of_the_library() {
    let folder = Folder::new("quadruped");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    let simulator = quadruped();
    let (nq, nv) = (simulator.model().nq(), simulator.model().nv());
    // Long text: with less optimisation, it is compiled in a fraction of the time.
    let flags = if cfg!(target_arch = "x86_64") {
        ["-O1", "-march=native"].as_slice()
    } else {
        &["-O1"]
    };
    let graph = codegen::step(&simulator);
    let compiler = compiler.with_flags(flags);
    let step = NativeFunction::<f64>::new(&graph, "quadruped", &compiler);
    let step = step.expect("a step");
    let mut state = simulator.neutral_state();
    state.q[2] = 0.45;
    state.v[2] = -0.5;
    let (mut own, mut worst, mut touching) = (vec![0.0; step.n_outputs()], 0.0_f64, 0);
    for k in 0..350 {
        // Springs and dampers in the joints, with which it comes to stand; without them, it folds up then and its feet slide.
        let stiffness = if k < 200 { 60.0 } else { 0.0 };
        let u: Vec<f64> = (0..simulator.nu())
            .map(|i| -stiffness * state.q[7 + i] - stiffness / 30.0 * state.v[6 + i])
            .collect();
        let given: Vec<f64> = state.numbers().chain(&u).copied().collect();
        step.call(&given, &mut own).expect("forces are found");
        let next = simulator.step(&state, &u);
        let report = simulator.contact_report(&state, &u);
        touching += usize::from(report.forces.iter().any(|f| f.norm() > 0.0));
        // m/s and rad/s; a change at rest is the rounding of larger ones.
        let (mut off, mut change) = (0.0_f64, 0.01_f64);
        for i in 0..nv {
            off = off.max((own[nq + i] - next.v[i]).abs());
            change = change.max((next.v[i] - state.v[i]).abs());
        }
        worst = worst.max(off / change);
        state = next;
    }
    println!("quadruped: {worst:e}, {touching} steps in contact");
    assert!(touching > 150, "{touching}");
    assert!(worst < ERROR_OF_CONTACT, "{worst:e}");
}

/// A box on a larger one, which is fixed, and a ball that falls on it.
fn stack() -> Simulator {
    let mass = Mass::Kilograms(1.0);
    let mut builder = ModelBuilder::new("stack").with_base(Base::Fixed);
    builder.add_link(LinkSpec::solid_box("table", [1.0, 1.0, 0.1], mass));
    builder.add_link(LinkSpec::solid_box("box", [0.3, 0.2, 0.1], mass));
    builder.add_link(LinkSpec::solid_sphere("ball", 0.1, mass));
    for name in ["box", "ball"] {
        builder.add_joint(JointSpec::new(name, JointKind::Floating, "table", name));
    }
    let model = builder.build().expect("a model");
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 2e-3));
    let options = CollisionOptions::default().with_self_collision();
    let contacts = Contacts::new(&model, Terrain::flat(-10.0), law)
        .with_links(&model, &[])
        .expect("no links")
        .with_link_shapes(&model, law, LinkShapes::without_meshes(&model), &options);
    Simulator::new(model)
        .with_actuated_joints(&[])
        .expect("joints")
        .with_contacts(contacts.expect("links"))
        .with_time_step(5e-4)
}

#[test]
fn compiled_steps_of_bodies_that_touch_each_other_equal_those_of_the_library() {
    let folder = Folder::new("bodies");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    let simulator = stack();
    let graph = codegen::step(&simulator);
    let compiler = compiler.with_flags(&["-O1"]);
    let step = NativeFunction::<f64>::new(&graph, "stack", &compiler).expect("a step");
    let mut state = simulator.neutral_state();
    state.q[2] = 0.101;
    state.q.rows_mut(7, 3).copy_from_slice(&[0.06, 0.03, 0.26]);
    state.v.rows_mut(3, 3).copy_from_slice(&[0.1, -0.2, 0.4]);
    let (mut own, mut touching) = (vec![0.0; step.n_outputs()], 0);
    for k in 0..600 {
        let given: Vec<f64> = state.numbers().copied().collect();
        step.call(&given, &mut own).expect("slow motion");
        let next = simulator.step(&state, &[]);
        let report = simulator.contact_report(&state, &[]);
        touching += usize::from(report.pairs.len() > 4);
        let off = next.numbers().zip(&own).map(|(a, b)| (a - b).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-10, "step {k}: {off:e}");
        state = next;
    }
    assert!(touching > 100, "{touching}");
}

#[test]
fn states_beyond_the_conditions_of_the_graph_are_stepped_by_the_library() {
    let folder = Folder::new("conditions");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    let simulator = Simulator::new(samples::double_pendulum()).with_time_step(1e-3);
    let native = NativeSimulator::new(simulator.clone(), &compiler).expect("a step");
    let graph = codegen::step(&simulator);
    // Something turns by more than a tenth of a radian in a step.
    let whirling = State::new(&[0.3, -0.4], &[150.0, -300.0]);
    let inputs: Vec<f64> = whirling.numbers().copied().chain([0.0; 2]).collect();
    graph
        .evaluate(&inputs)
        .expect_err("a condition that does not hold");
    let function = NativeFunction::<f64>::new(&graph, "whirl", &compiler).expect("a function");
    let broken = function.call(&inputs, &mut [0.0; 4]).expect_err("the same");
    assert!(!broken.condition.is_empty());
    let (mut scratch, mut next) = (NativeScratch::new(&native), whirling.clone());
    native.step_into(&whirling, &[0.0; 2], &mut scratch, &mut next);
    assert_eq!(next, simulator.step(&whirling, &[0.0; 2]));
    let calm = State::new(&[0.1, 0.2], &[0.3, 0.4]);
    let mut all = [
        calm.clone(),
        whirling.clone(),
        calm.clone(),
        whirling.clone(),
        calm.clone(),
    ];
    let u: Vec<f64> = (0..10).map(f64::from).collect();
    native.step_states(&mut all, &u);
    for (i, (found, start)) in all
        .iter()
        .zip([&calm, &whirling, &calm, &whirling, &calm])
        .enumerate()
    {
        let expected = simulator.step(start, &u[2 * i..2 * i + 2]);
        assert!(distance(found, &expected) < ROUNDING, "state {i}");
    }
}

#[test]
fn rollouts_equal_those_of_the_library_and_end_for_the_same_reasons() {
    let folder = Folder::new("rollouts");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01);
    let simulator = simulator
        .with_actuated_joints(&["linear"])
        .expect("a joint")
        .with_divergence_bound(50.0);
    let native = NativeSimulator::new(simulator.clone(), &compiler).expect("a step");
    let start = State::new(&[0.0, 0.2], &[0.0, 0.0]);
    for (push, status) in [
        (1.0, RolloutStatus::Completed),
        (f64::NAN, RolloutStatus::NonFiniteInput { step: 3 }),
        (1e6, RolloutStatus::Diverged { step: 3 }),
    ] {
        let control =
            |time: f64, _: &State, u: &mut [f64]| u[0] = if time > 0.025 { push } else { 0.0 };
        let (found, own) = (
            native.rollout(&start, 200, control),
            simulator.rollout(&start, 200, control),
        );
        assert_eq!((found.status, own.status), (status, status));
        assert_eq!(found.states.len(), own.states.len());
        assert_eq!(found.input_names, own.input_names);
        assert!(distance(found.last(), own.last()) < 1e-9);
    }
}

#[test]
fn functions_in_single_precision_have_seven_digits() {
    let folder = Folder::new("single");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    let graph = codegen::mass_matrix(&samples::arm());
    let function = NativeFunction::<f32>::new(&graph, "mass", &compiler).expect("a function");
    let (q, mut m) = ([0.1_f32, -0.4, 0.3, 0.8, -0.2, 0.5, 0.7], vec![0.0_f32; 49]);
    function.call(&q, &mut m).expect("no conditions");
    let expected = graph.evaluate(&q.map(f64::from)).expect("no conditions");
    let size = expected.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    let off = m
        .iter()
        .zip(&expected)
        .map(|(m, x)| (f64::from(*m) - x).abs() / size);
    let off = off.fold(0.0, f64::max);
    assert!(1e-12 < off && off < 1e-6, "{off:e}");
}

#[test]
fn what_was_compiled_is_found_again_by_text_flags_and_compiler() {
    let folder = Folder::new("cache");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    let (light, heavy) = (
        samples::pendulum(),
        samples::pendulum().with_armature(0, 0.1),
    );
    let make = |model: &Model, compiler: &Compiler| {
        let graph = codegen::mass_matrix(model);
        let function = NativeFunction::<f64>::new(&graph, "kept", compiler).expect("a function");
        let mut m = [0.0];
        function.call(&[0.0], &mut m).expect("no conditions");
        m[0]
    };
    let first = make(&light, &compiler);
    let kept = folder.kept("kept");
    assert_eq!(kept.len(), 1);
    let written = |path: &Path| {
        fs::metadata(path.join("kept.c"))
            .and_then(|data| data.modified())
            .expect("a time")
    };
    let time = written(&kept[0]);
    assert_eq!(make(&light, &compiler), first);
    assert_eq!((folder.kept("kept").len(), written(&kept[0])), (1, time));
    assert!((make(&heavy, &compiler) - first - 0.1).abs() < 1e-15);
    assert_eq!(folder.kept("kept").len(), 2);
    make(&light, &compiler.clone().with_flags(&["-O1"]));
    assert_eq!(folder.kept("kept").len(), 3);
    // A file that was damaged is compiled once more.
    for entry in fs::read_dir(&kept[0]).expect("the folder") {
        let path = entry.expect("an entry").path();
        if path
            .extension()
            .is_none_or(|extension| extension != "c" && extension != "h")
        {
            fs::remove_file(&path).expect("a file");
            fs::write(&path, "no code").expect("a file");
        }
    }
    assert_eq!(make(&light, &compiler), first);
}

#[test]
fn without_a_compiler_the_library_serves_and_the_reason_is_said() {
    let folder = Folder::new("none");
    let none = Compiler::new("no-such-compiler -q").with_cache(&folder.0);
    let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    let native = NativeSimulator::or_own(simulator.clone(), &none)
        .with_jacobians(&none)
        .expect("nothing to do");
    let reason = native.reason().expect("a reason").to_string();
    assert!(
        reason.contains("\"no-such-compiler -q\"") && reason.contains("CC"),
        "{reason}"
    );
    let start = State::new(&[0.3], &[1.0]);
    let mut states = [start.clone(), start.clone()];
    native.step_states(&mut states, &[0.5, -0.5]);
    assert_eq!(
        states,
        [
            simulator.step(&start, &[0.5]),
            simulator.step(&start, &[-0.5])
        ]
    );
    let swing = native.rollout(&start, 10, |_, _, _| {});
    assert_eq!(
        swing.last(),
        simulator.rollout(&start, 10, |_, _, _| {}).last()
    );
    let mut found = Linearization::zeros(&simulator);
    native.linearize_into(&start, &[0.5], &mut NativeScratch::new(&native), &mut found);
    assert_eq!(found.a, simulator.linearize(&start, &[0.5]).a);
}

#[test]
fn what_cannot_be_compiled_is_refused_with_the_reason() {
    let folder = Folder::new("refused");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    let graph = codegen::mass_matrix(&samples::pendulum());
    let refused = |name: &str, compiler: &Compiler| {
        NativeFunction::<f64>::new(&graph, name, compiler).expect_err("an error")
    };
    let error = refused("two words", &compiler);
    assert!(
        matches!(error, NativeError::Code(_)) && error.to_string().contains("two words"),
        "{error}"
    );
    let error = refused("m", &compiler.clone().with_flags(&["--no-such-flag"]));
    assert!(
        matches!(error, NativeError::Refused { .. }) && error.to_string().contains("no-such-flag"),
        "{error}"
    );
    fs::write(folder.0.join("file"), "").expect("a file");
    let error = refused("m", &compiler.with_cache(folder.0.join("file")));
    assert!(
        matches!(error, NativeError::File { .. }) && error.to_string().contains("file"),
        "{error}"
    );
}

#[test]
fn trajectories_of_native_simulators_are_those_of_the_library() {
    let folder = Folder::new("trajopt");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    fn optimum<D: Robot>(robot: D) -> (f64, Vec<f64>) {
        let stage = Cost::new().with(1e-2, Activation::Quadratic, InputError::to_zero(&robot));
        let last = Cost::new().with(100.0, Activation::Quadratic, StateError::to_neutral(&robot));
        let problem = Problem::new(robot, 40, &[0.0, 0.5, 0.0, 0.0])
            .with_stage_cost(stage)
            .with_final_cost(last);
        let mut ddp = Ddp::new(&problem);
        let found = ddp.solve(&problem, &Trajectory::zero_input(&problem));
        let inputs = found.trajectory.inputs.iter().map(|u| u[0]);
        (found.trajectory.cost(&problem), inputs.collect())
    }
    let simulator = Simulator::new(samples::cartpole()).with_time_step(0.02);
    let simulator = simulator
        .with_actuated_joints(&["linear"])
        .expect("a joint");
    let native = NativeSimulator::new(simulator.clone(), &compiler)
        .and_then(|native| native.with_jacobians(&compiler));
    let (own, found) = (optimum(simulator), optimum(native.expect("a simulator")));
    assert!(
        (found.0 / own.0 - 1.0).abs() < 1e-9,
        "{} {}",
        found.0,
        own.0
    );
    let off = found.1.iter().zip(&own.1).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-6);
}

#[test]
fn functions_are_called_from_several_threads_at_once() {
    let folder = Folder::new("threads");
    let Some(compiler) = folder.compiler_if_any() else {
        return;
    };
    let simulator = Simulator::new(samples::arm()).with_time_step(1e-3);
    let native = NativeSimulator::new(simulator, &compiler).expect("a step");
    let start = state(native.simulator().model(), 1);
    let last = || native.rollout(&start, 200, |_, _, _| {}).last().clone();
    let expected = last();
    let found = thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(last)).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().expect("a state"))
            .collect::<Vec<_>>()
    });
    assert!(found.iter().all(|found| *found == expected));
}

#[test]
#[should_panic(expected = "the inputs of 2 states")]
fn inputs_for_another_number_of_states_are_refused() {
    let folder = Folder::new("inputs");
    let none = Compiler::new("no-such-compiler").with_cache(&folder.0);
    let native = NativeSimulator::or_own(Simulator::new(samples::pendulum()), &none);
    native.step_states(
        &mut [State::new(&[0.0], &[0.0]), State::new(&[0.0], &[0.0])],
        &[1.0],
    );
}

/// A compiler that prints its predefined macros, starts a process that writes into a file for ever, as a compiler starts others, and waits for it.
#[cfg(unix)]
fn endless(folder: &Folder) -> (Compiler, PathBuf) {
    use std::os::unix::fs::PermissionsExt;
    let (script, ticks) = (folder.0.join("cc"), folder.0.join("ticks"));
    let text = format!(
        "#!/bin/sh\ncase \"$*\" in *-dM*) exit 0;; esac\n: > half.o\n\
         while :; do echo tick >> '{}'; sleep 0.02; done &\nwait\n",
        ticks.display()
    );
    fs::create_dir_all(&folder.0).expect("a folder");
    fs::write(&script, text).expect("a file");
    fs::set_permissions(&script, fs::Permissions::from_mode(0o700)).expect("a script");
    let compiler = Compiler::new(&script.display().to_string());
    (compiler.with_cache(folder.0.join("cache")), ticks)
}

#[test]
#[cfg(unix)]
fn a_signal_ends_the_compiler_with_all_that_it_has_started() {
    let folder = Folder::new("stopped");
    let (compiler, ticks) = endless(&folder);
    let size = || fs::metadata(&ticks).map_or(0, |data| data.len());
    let (graph, signal) = (
        codegen::mass_matrix(&samples::pendulum()),
        StopSignal::new(),
    );
    let compile = || NativeFunction::<f64>::new(&graph, "stopped", &compiler);
    let ended = thread::scope(|scope| {
        let compiling = scope.spawn(|| (signal.watch(compile), Instant::now()));
        while size() == 0 && !compiling.is_finished() {
            thread::sleep(Duration::from_millis(5));
        }
        let stopped = Instant::now();
        signal.stop();
        let (found, ended) = compiling.join().expect("no panic");
        let error = found.expect_err("an error");
        assert!(matches!(error, NativeError::Stopped { .. }), "{error}");
        ended - stopped
    });
    // Much less on a machine that does nothing else.
    assert!(ended < Duration::from_secs(5), "{ended:?}");
    let left = size();
    thread::sleep(Duration::from_millis(200));
    assert_eq!(size(), left, "a process of the compiler goes on");
    let kept = fs::read_dir(folder.0.join("cache")).expect("the folder");
    assert_eq!(kept.count(), 0, "files of what was not compiled");
    // A signal that is set already starts nothing.
    let error = signal.watch(compile).expect_err("an error");
    assert!(error.to_string().ends_with("cc\" was stopped"), "{error}");
    assert_eq!(size(), left);
}
