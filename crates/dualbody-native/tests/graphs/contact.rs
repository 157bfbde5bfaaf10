//! Recorded steps on rigid ground and under constraints against the steps themselves, all along motions of robots.

use dualbody::codegen::Precision;
use dualbody::cone::{Block, ConeProblem, ConeSolver, Law};
use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Smoothing, Terrain};
use dualbody::scalar::traced::{Graph, Port, trace};
use dualbody::sim::Actuation;
use dualbody::{Integrator, Scalar, Simulator, State, codegen};

use crate::codegen::{Program, has_compiler};
use crate::common::asset;
use crate::common::ground::hills;

/// How far the velocities after a recorded step may be from those of the library's, relative to the change of velocity in the step. The path ends at a κ of 1e-11
/// of the size of the problem squared, so that errors are larger where contacts slide slowly, or are just between two pieces of their law.
const ERROR: f64 = 2e-6;
/// How far entries of A and B may be, relative to the largest one.
const ERROR_OF_DERIVATIVES: f64 = 1e-4;
/// How far compiled steps may be from recorded ones, which do the same operations.
const ROUNDING: f64 = 1e-12;

const FEET: [&str; 4] = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];

fn on(robot: &str, links: &[&str], terrain: Terrain, law: RelaxedRigid) -> Simulator {
    let model = asset(&format!("{robot}.urdf"));
    let mut contacts = Contacts::new(&model, terrain, ContactLaw::RelaxedRigid(law));
    if !links.is_empty() {
        contacts = contacts.with_links(&model, links).expect("links");
    }
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(2e-3)
}

/// A state at a height (m), with a velocity of its first coordinates.
fn thrown(simulator: &Simulator, height: f64, v: &[f64]) -> State {
    let mut state = simulator.neutral_state();
    state.q[2] = height;
    for (k, &v) in v.iter().enumerate() {
        state.v[k] = v;
    }
    state
}

/// Findings along a motion.
#[derive(Debug, Default)]
struct Found {
    steps: usize,
    touching: usize,
    /// Steps whose forces the graph did not find.
    broken: usize,
    worst: f64,
}

/// Numbers of a state and an input as those of a graph.
fn inputs(state: &State, u: &[f64]) -> Vec<f64> {
    state.numbers().chain(u).copied().collect()
}

/// Inputs that hold legs about where they were at the start, and move them a little.
fn holding(simulator: &Simulator, start: &State, state: &State, t: f64) -> Vec<f64> {
    let of = |i: usize| {
        let (q, v) = (7 + i, 6 + i);
        40.0 * (start.q[q] - state.q[q]) - state.v[v] + 3.0 * (9.0 * t + i as f64).sin()
    };
    (0..simulator.nu()).map(of).collect()
}

/// Follows a motion of the library, and compares each step of it with the recorded one.
fn follow(simulator: &Simulator, graph: &Graph, start: &State, steps: usize) -> Found {
    let nv = simulator.model().nv();
    let (mut found, mut state) = (Found::default(), start.clone());
    for k in 0..steps {
        let t = k as f64 * simulator.time_step();
        let u = holding(simulator, start, &state, t);
        let next = simulator.step(&state, &u);
        let report = simulator.contact_report(&state, &u);
        found.touching += usize::from(report.forces.iter().any(|f| f.norm() > 0.0));
        found.steps += 1;
        match graph.evaluate(&inputs(&state, &u)) {
            Ok(own) => {
                let v = &own[simulator.model().nq()..][..nv];
                let (mut off, mut change) = (0.0_f64, 0.01_f64);
                for i in 0..nv {
                    off = off.max((v[i] - next.v[i]).abs());
                    change = change.max((next.v[i] - state.v[i]).abs());
                }
                found.worst = found.worst.max(off / change);
            }
            Err(error) => {
                println!("  step {k}: {error}");
                found.broken += 1;
            }
        }
        state = next;
    }
    found
}

#[track_caller]
fn assert_follows(simulator: &Simulator, starts: &[State], steps: usize, what: &str) {
    let graph = codegen::step(simulator);
    println!(
        "{what}: {} operations, {} alive",
        graph.counts().operations(),
        graph.live_values()
    );
    for (k, start) in starts.iter().enumerate() {
        let found = follow(simulator, &graph, start, steps);
        println!("  start {k}: {found:?}");
        assert!(found.touching > steps / 10, "{what}, start {k}: {found:?}");
        assert!(found.broken == 0, "{what}, start {k}: {found:?}");
        assert!(found.worst < ERROR, "{what}, start {k}: {found:?}");
    }
}

#[test]
fn recorded_steps_of_a_ball_that_rolls_and_slides_equal_steps() {
    for law in [
        RelaxedRigid::default(),
        RelaxedRigid {
            friction: 0.05,
            friction_impedance_ratio: 10.0,
            ..RelaxedRigid::default()
        },
    ] {
        let ball = on("sphere", &[], Terrain::incline(0.1), law);
        let starts = [
            thrown(&ball, 0.1, &[1.0, 0.5]),
            thrown(&ball, 0.15, &[0.0, 0.0, -1.0, 5.0, -20.0, 3.0]),
        ];
        assert_follows(&ball, &starts, 300, "ball");
    }
}

#[test]
fn recorded_steps_of_a_box_that_slides_and_tumbles_equal_steps() {
    let law = RelaxedRigid::default();
    let brick = on("box", &[], Terrain::flat(0.0), law);
    let starts = [
        thrown(&brick, 0.0595, &[1.5, -0.4, 0.0, 0.0, 0.0, 1.0]),
        thrown(&brick, 0.25, &[1.0, 0.0, 0.0, 4.0, 7.0, -2.0]),
    ];
    assert_follows(&brick, &starts, 300, "box");
}

#[test]
fn recorded_steps_of_a_quadruped_on_four_feet_equal_steps() {
    for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
        let law = RelaxedRigid::default();
        let robot = on("quadruped", &FEET, Terrain::flat(0.0), law).with_integrator(integrator);
        let start = thrown(&robot, 0.45, &[0.3, 0.0, -0.5]);
        assert_follows(&robot, &[start], 250, "quadruped");
    }
}

/// Compares A and B at some states of a motion without inputs.
#[track_caller]
fn assert_linearizes(simulator: &Simulator, start: &State, steps: usize) {
    let graph = codegen::linearization(simulator);
    let u = vec![0.0; simulator.nu()];
    let rollout = simulator.rollout(start, steps, |_, _, _| {});
    let mut worst = 0.0_f64;
    for state in rollout.states.iter().step_by(8) {
        let exact = simulator.linearize(state, &u);
        let exact: Vec<f64> = exact.a.iter().chain(&exact.b).copied().collect();
        let found = graph
            .evaluate(&inputs(state, &u))
            .expect("forces are found");
        let size = exact.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let off = found.iter().zip(&exact).map(|(a, b)| (a - b).abs());
        worst = worst.max(off.fold(0.0, f64::max) / size);
    }
    println!(
        "A and B of {}: {} operations, {worst:e}",
        simulator.model().name(),
        graph.counts().operations()
    );
    assert!(worst < ERROR_OF_DERIVATIVES, "{worst:e}");
}

#[test]
fn recorded_linearizations_on_relaxed_ground_equal_those_of_the_simulator() {
    let law = RelaxedRigid::default();
    let ball = on("sphere", &[], Terrain::incline(0.1), law);
    assert_linearizes(&ball, &thrown(&ball, 0.1, &[1.0, 0.5]), 40);
    let brick = on("box", &[], Terrain::flat(0.0), law);
    let start = thrown(&brick, 0.0595, &[1.5, -0.4, 0.0, 0.0, 0.0, 1.0]);
    assert_linearizes(&brick, &start, 200);
}

#[test]
fn recorded_steps_on_smoothed_ground_equal_steps() {
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let model = asset("sphere.urdf");
    let contacts =
        Contacts::new(&model, Terrain::flat(0.0), law).with_smoothing(Smoothing::new(0.1));
    let ball = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(2e-3);
    let start = thrown(&ball, 0.12, &[1.0, 0.5, -0.2]);
    assert_follows(&ball, &[start], 200, "smoothed ball");
}

#[test]
fn recorded_steps_of_a_box_on_a_grid_of_heights_equal_steps() {
    let brick = on("box", &[], hills(), RelaxedRigid::default());
    let start = thrown(&brick, 0.12, &[0.8, -0.3, 0.0, 0.0, 2.0, 1.0]);
    assert_follows(&brick, &[start], 300, "box on hills");
}

/// A four-bar linkage that is closed and moves.
fn four_bar() -> (Simulator, State) {
    let model = asset("four_bar.urdf");
    let anchor = |name| Anchor::frame(&model, name).expect("a frame");
    let pin = Constraint::ball([anchor("loop_a"), anchor("loop_b")]);
    let linkage = Simulator::new(model).with_constraints(vec![pin]);
    let mut start = linkage.neutral_state();
    start.q[0] = 0.4;
    start.v[0] = 2.0;
    let start = linkage.assemble(&start).expect("a closed linkage").state;
    (linkage, start)
}

/// A quadruped whose front hips turn together, among the stops of all joints.
fn coupled_quadruped() -> Simulator {
    let model = asset("quadruped.urdf");
    let names = model.joint_names();
    let coupler = Constraint::coupler(&model, [names[0], names[3]], 1.0, 0.0).expect("joints");
    let actuation = Actuation::from_model(&model);
    on(
        "quadruped",
        &FEET,
        Terrain::flat(0.0),
        RelaxedRigid::default(),
    )
    .with_actuation(actuation)
    .with_constraints(vec![coupler])
}

#[test]
fn recorded_steps_of_a_closed_linkage_equal_steps() {
    let (linkage, start) = four_bar();
    for integrator in [
        Integrator::SemiImplicitEuler,
        Integrator::RungeKutta4,
        Integrator::ImplicitVelocity,
    ] {
        let linkage = linkage
            .clone()
            .with_integrator(integrator)
            .with_time_step(2e-3);
        let graph = codegen::step(&linkage);
        println!(
            "four-bar, {integrator:?}: {} operations",
            graph.counts().operations()
        );
        let mut state = start.clone();
        for k in 0..300 {
            let u = vec![0.3 * (0.02 * f64::from(k)).sin(); linkage.nu()];
            let next = linkage.step(&state, &u);
            let own = graph
                .evaluate(&inputs(&state, &u))
                .expect("forces are found");
            let expected = next.numbers();
            for (own, expected) in own.iter().zip(expected) {
                let off = (own - expected).abs();
                assert!(
                    off < 1e-9 * expected.abs().max(1.0),
                    "{integrator:?} {k}: {own}, not {expected}"
                );
            }
            state = next;
        }
    }
}

#[test]
fn recorded_linearizations_of_a_closed_linkage_equal_those_of_the_simulator() {
    let (linkage, start) = four_bar();
    let graph = codegen::linearization(&linkage);
    let rollout = linkage.rollout(&start, 30, |_, _, _| {});
    for state in rollout.states.iter().step_by(10) {
        let u = vec![0.2; linkage.nu()];
        let exact = linkage.linearize(state, &u);
        let exact: Vec<f64> = exact.a.iter().chain(&exact.b).copied().collect();
        let found = graph
            .evaluate(&inputs(state, &u))
            .expect("forces are found");
        let size = exact.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (found, exact) in found.iter().zip(&exact) {
            assert!((found - exact).abs() < 1e-7 * size, "{found}, not {exact}");
        }
    }
}

#[test]
fn recorded_steps_with_stops_beside_contact_and_constraints_equal_steps() {
    let robot = coupled_quadruped();
    let start = thrown(&robot, 0.4, &[0.3, 0.0, -0.5]);
    assert_follows(&robot, &[start], 100, "quadruped with stops");
}

#[test]
fn compiled_steps_on_relaxed_ground_equal_recorded_ones() {
    if !has_compiler() {
        return;
    }
    let law = RelaxedRigid::default();
    let ball = on("sphere", &[], Terrain::incline(0.1), law);
    let start = thrown(&ball, 0.1, &[1.0, 0.5]);
    assert_compiles(&ball, &start);
}

/// Compares the compiled step with the recorded one along a motion without inputs.
#[track_caller]
fn assert_compiles(simulator: &Simulator, start: &State) {
    let graph = codegen::step(simulator);
    let u = vec![0.0; simulator.nu()];
    let rollout = simulator.rollout(start, 200, |_, _, _| {});
    let states = rollout.states.iter().step_by(2);
    let given: Vec<Vec<f64>> = states.map(|state| inputs(state, &u)).collect();
    let name = format!("{}_step", simulator.model().name());
    let mut program = Program::new(&name);
    program.add(&graph, &name, Precision::Double, &given);
    let printed = program.run(std::slice::from_ref(&name));
    assert_eq!(printed[0], 0.0, "{name}: a condition does not hold");
    for (given, own) in given.iter().zip(printed[1..].chunks(graph.n_outputs())) {
        let expected = graph.evaluate(given).expect("forces are found");
        for (own, expected) in own.iter().zip(&expected) {
            let off = (own - expected).abs() / expected.abs().max(1.0);
            assert!(off < ROUNDING, "{name}: {own}, not {expected}");
        }
    }
}

/// A symmetric positive definite matrix of so many rows, by columns, and free velocities.
fn problem(n: usize, seed: usize) -> (Vec<f64>, Vec<f64>) {
    let wave = |k: usize| (1.0 + (13 * k + 7 * seed) as f64).sin();
    let a: Vec<f64> = (0..n * n).map(wave).collect();
    let product = |i: usize, j: usize| -> f64 { (0..n).map(|k| a[k * n + i] * a[k * n + j]).sum() };
    let matrix = (0..n * n).map(|k| product(k % n, k / n)).collect();
    (matrix, (0..n).map(|k| 3.0 * wave(n * n + k)).collect())
}

const BLOCKS: [Block; 4] = [Block::Free(2), Block::Cone, Block::Ray, Block::Cone];
const ROWS: usize = 9;
/// Factors of the inverse masses.
const SIZES: [f64; 3] = [1e-9, 1.0, 1e9];

/// Forces of a problem, with a friction and a regularisation of its last contact.
fn forces<T: Scalar>(matrix: &[T], r: &[T], g: &[T], friction: f64) -> Vec<T> {
    let problem = ConeProblem {
        law: Law::Convex,
        blocks: &BLOCKS,
        friction: &[0.0, 0.6, 0.0, friction].map(T::constant),
        matrix,
        regularization: r,
        free_velocity: g,
    };
    let mut f = vec![T::zero(); ROWS];
    ConeSolver::new(ROWS, BLOCKS.len()).solve(&problem, &mut f);
    f
}

/// Records the forces once, and evaluates the graph at problems that it has not seen.
#[track_caller]
fn assert_finds_forces(friction: f64, last: f64) {
    let graph = trace(|t| {
        let matrix = t.input(Port::matrix("G", ROWS, ROWS));
        let r = t.input(Port::vector("R", ROWS));
        let g = t.input(Port::vector("g", ROWS));
        let f = forces(&matrix, &r, &g, friction);
        t.output(Port::vector("f", ROWS), &f);
    });
    assert_eq!(graph.conditions().len(), 1);
    for seed in 0..100 {
        let (mut matrix, g) = problem(ROWS, seed);
        let mut r = [0.05; ROWS];
        r[ROWS - 3..].fill(last);
        let size = SIZES[seed % SIZES.len()];
        matrix.iter_mut().chain(&mut r).for_each(|x| *x *= size);
        let exact = forces(&matrix, &r, &g, friction);
        let size = exact.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let given = [matrix, r.to_vec(), g].concat();
        let found = graph.evaluate(&given).expect("forces are found");
        for (found, exact) in found.iter().zip(&exact) {
            let off = (found - exact).abs() / size;
            // Forces of rows that are nearly redundant are less exact than the motion under them.
            assert!(
                off < 1e-5,
                "{friction}, {last}, {seed}: {found}, not {exact}"
            );
        }
    }
}

#[test]
fn recorded_forces_equal_those_of_the_active_set() {
    for last in [0.1, f64::INFINITY] {
        assert_finds_forces(0.3, last);
    }
    assert_finds_forces(0.0, 0.1);
    assert_finds_forces(2.0, 0.1);
}
