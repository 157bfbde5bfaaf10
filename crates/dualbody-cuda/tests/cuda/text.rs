//! The text of kernels, as C on the CPU.

use dualbody::codegen::{CodeError, CudaKernel, CudaSizes, CudaSource, Precision, RolloutInputs};
use dualbody::model::samples;
use dualbody::scalar::traced::{Graph, Port, Traced, trace};
use dualbody::{Scalar, Simulator};
use dualbody_cuda::graphs;

use crate::checks;
use crate::common::asset;
use crate::host::Host;
use crate::machine::Machine;

#[test]
fn kernels_of_inverse_dynamics_of_all_assets_equal_the_library() {
    if let Some(host) = Host::new() {
        checks::inverse_dynamics::<f64>(&host, &checks::assets(), 1e-11);
    }
}

#[test]
fn kernels_of_motions_of_all_assets_equal_the_library() {
    if let Some(host) = Host::new() {
        checks::rollouts::<f64>(&host, &checks::simulators(checks::assets()), 1e-9);
        checks::rollouts::<f64>(&host, &checks::integrators(), 1e-9);
    }
}

#[test]
fn kernels_of_other_functions_equal_the_library() {
    if let Some(host) = Host::new() {
        checks::others(&host);
    }
}

/// Three numbers after many turns of three operations each, none of which folds.
fn turned<T: Scalar>(x: &[T], turns: usize) -> Vec<T> {
    let mut all = x.to_vec();
    for k in 0..turns {
        all[k % 3] = (all[k % 3] * x[(k + 1) % 3]).tanh() + all[(k + 2) % 3];
    }
    all
}

/// These as a graph.
fn long(turns: usize) -> Graph {
    trace(|t| {
        let x = t.input(Port::vector("x", 3));
        t.output(Port::vector("y", 3), &turned(&x, turns));
    })
}

/// Operations that each kernel computes itself.
fn operations_of_kernels(source: &CudaSource) -> Vec<usize> {
    let computes = |line: &&str| line.contains("const REAL t") && !line.contains("= w[");
    let texts = source.kernels.iter().map(CudaKernel::text);
    texts
        .map(|text| text.lines().filter(computes).count())
        .collect()
}

// A short last part would be handed more numbers than it computes.
#[test]
fn kernels_of_parts_are_as_long_as_each_other() {
    const WHOLE: usize = 10_000;
    const LONGEST: usize = 2_000;
    for turns in [3_000, 3_500, 5_000] {
        let graph = long(turns);
        let all = graph.counts().operations();
        let source = graph.to_cuda("f", Precision::Double, &[]).expect("a name");
        let parts = operations_of_kernels(&source);
        let (least, most) = (parts.iter().min(), parts.iter().max());
        let (least, most) = least.zip(most).expect("parts");
        assert_eq!(parts.iter().sum::<usize>(), all);
        let longest = if all <= WHOLE { WHOLE } else { LONGEST };
        assert_eq!(parts.len(), all.div_ceil(longest));
        assert_eq!(source.sizes.work == 0, parts.len() == 1);
        assert!(*most <= longest && most - least < parts.len(), "{parts:?}");
    }
}

#[test]
fn functions_are_cut_into_parts_of_any_length() {
    let graph = long(300);
    let all = graph.counts().operations();
    for length in [100, 500, all] {
        let source = graph.to_cuda_in_parts("f", Precision::Double, &[], length);
        let parts = operations_of_kernels(&source.expect("a name"));
        assert_eq!(parts.len(), all.div_ceil(length), "{length}");
        assert!(parts.iter().all(|&n| n <= length), "{parts:?}");
    }
}

// More states than a tile has, so that the last tile is not full.
#[test]
fn functions_in_parts_equal_their_graph() {
    const COUNT: usize = CudaSizes::TILE + 3;
    let graph = long(12_000);
    let Some(host) = Host::new() else { return };
    let number = |k: usize| 0.7 * (3.0 * k as f64 + 1.0).sin();
    let given: Vec<f64> = (0..3 * COUNT).map(number).collect();
    let found = host.batch(&graph, &[], COUNT, [&given, &[]]);
    for (x, y) in given.chunks(3).zip(found.numbers.chunks(3)) {
        let expected = graph.evaluate(x).expect("no conditions");
        let off = y.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        assert!(
            off.fold(0.0, f64::max) < 1e-9 * (1.0 + expected[0].abs()),
            "{y:?} {expected:?}"
        );
    }
}

// Outputs that are inputs or constants, conditions, shared inputs, and numbers that are not finite, in several kernels.
#[test]
fn functions_in_parts_have_the_status_of_each_state() {
    let graph = trace(|t| {
        let x = t.input(Port::vector("x", 2));
        let scale = t.input(Port::number("scale"));
        let mut all = [x[0] * scale[0], x[1]];
        for k in 0..4_000 {
            all[k % 2] = (all[k % 2] * x[(k + 1) % 2]).tanh() + all[(k + 1) % 2];
        }
        let ratio = Traced::from(1.0) / x[0];
        t.output(
            Port::vector("y", 4),
            &[all[0], x[1], Traced::from(3.0), ratio],
        );
    });
    let source = graph
        .to_cuda("f", Precision::Double, &["scale"])
        .expect("a name");
    assert!(source.kernels.len() > 1);
    let Some(host) = Host::new() else { return };
    let found = host.batch(&graph, &["scale"], 2, [&[0.5, 0.25, 0.0, 0.25], &[2.0]]);
    let expected = graph.evaluate(&[0.5, 0.25, 2.0]).expect("no conditions");
    assert_eq!(found.status, [0, -1]);
    assert!((found.numbers[0] - expected[0]).abs() < 1e-9 * expected[0].abs());
    assert_eq!(found.numbers[1..4], [0.25, 3.0, 2.0]);
    assert_eq!(found.numbers[5..7], [0.25, 3.0]);
}

// One condition on a value of the first kernel, one on a value of the last.
#[test]
fn conditions_of_functions_in_parts_are_those_of_their_graph() {
    const TURNS: usize = 4_000;
    const STATES: [[f64; 3]; 4] = [
        [0.2, 0.3, 0.1],
        [0.9, 0.3, 0.1],
        [0.2, 0.9, 0.4],
        [0.9, 0.9, 0.4],
    ];
    let last = STATES.map(|x| turned(&x, TURNS)[2]);
    let limit = 0.5 * (last[1].max(last[0]) + last[2].min(last[3]));
    let graph = trace(|t| {
        let x = t.input(Port::vector("x", 3));
        assert!((x[0] + x[2] * x[2]).is_at_most(0.5, "the first number is small"));
        let y = turned(&x, TURNS);
        assert!(y[2].is_at_most(limit, "the last number is small"));
        t.output(Port::vector("y", 3), &y);
    });
    let source = graph.to_cuda("f", Precision::Double, &[]).expect("a name");
    assert!(source.kernels.len() > 2);
    let number = |x: &[f64; 3]| graph.evaluate(x).err().map_or(0, |broken| broken.index + 1);
    assert_eq!(STATES.each_ref().map(number), [0, 1, 2, 1]);
    let Some(host) = Host::new() else { return };
    let given = STATES.as_flattened();
    let found = host.batch(&graph, &[], STATES.len(), [given, &[]]);
    assert_eq!(found.status, [0, 1, 2, 1]);
    // A state with a number that is not finite is flagged where no condition is violated.
    let given = [STATES[1], [f64::NAN, 0.3, 0.1]].concat();
    let found = host.batch(&graph, &[], 2, [&given, &[]]);
    assert_eq!(found.status, [1, -1]);
}

#[test]
fn inputs_that_all_states_share_stand_apart() {
    let graph = trace(|t| {
        let x = t.input(Port::vector("x", 2));
        let k = t.input(Port::vector("k", 2));
        let z = t.input(Port::number("z"));
        t.output(Port::number("y"), [&(x[0] * k[0] + x[1] * k[1] - z[0])]);
    });
    let source = graph
        .to_cuda("f", Precision::Double, &["k"])
        .expect("a name");
    let (sizes, text) = (source.sizes, source.kernels[0].text());
    assert_eq!(
        (sizes.inputs, sizes.shared, sizes.outputs, sizes.each_step),
        (3, 2, 1, 0)
    );
    assert!(text.contains("#define F_IN_Z 2\n"), "{text}");
    let Some(host) = Host::new() else { return };
    let given = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let found = host.batch(&graph, &["k"], 2, [&given, &[10.0, 100.0]]);
    assert_eq!(found.numbers, [207.0, 534.0]);
}

#[test]
fn states_that_have_stopped_are_left_alone() {
    use crate::machine::{Left, Run};
    use dualbody_cuda::Schedule;
    let Some(host) = Host::new() else { return };
    let graph = graphs::step(&Simulator::new(samples::pendulum()), &[]).expect("no parameters");
    let run = Run {
        schedule: Schedule {
            steps: 2,
            every: 0,
            fastest: 1e3,
        },
        count: 2,
        state: vec![0.5, 0.0, 0.5, 0.0],
        constants: Vec::new(),
        each_step: vec![0.0; 4],
        shared: Vec::new(),
        status: vec![0, -1],
        taken: vec![7, 7],
    };
    let Left { run, .. } = host.rollout(&graph, &RolloutInputs::default(), run);
    assert_eq!((run.status, run.taken), (vec![0, -1], vec![9, 7]));
    assert_eq!(run.state[2..], [0.5, 0.0]);
    assert!(run.state[1] < 0.0);
}

#[test]
fn what_cannot_be_written_is_refused_with_the_reason() {
    let simulator = Simulator::new(samples::pendulum());
    let step = graphs::step(&simulator, &[]).expect("no parameters");
    let error = step
        .to_cuda("f", Precision::Double, &["gain"])
        .expect_err("no such input");
    assert_eq!(
        error.to_string(),
        "there is no input \"gain\": the inputs are q, v, u"
    );
    let error = step
        .to_cuda("two words", Precision::Double, &[])
        .expect_err("no name");
    assert!(matches!(error, CodeError::Name { .. }), "{error}");
    let dynamics = graphs::inverse_dynamics(simulator.model());
    let roles = RolloutInputs {
        each_step: vec!["a".to_owned()],
        ..RolloutInputs::default()
    };
    let error = dynamics
        .to_cuda_rollout("f", Precision::Double, &RolloutInputs::default())
        .expect_err("no u");
    assert!(matches!(error, CodeError::NoInput { .. }), "{error}");
    // One output, and a first input of one number: a step, if not of physics. Two outputs are none.
    assert!(
        dynamics
            .to_cuda_rollout("f", Precision::Double, &roles)
            .is_ok()
    );
    let mass = graphs::linearization(&simulator);
    let error = mass
        .to_cuda_rollout("f", Precision::Double, &RolloutInputs::default())
        .expect_err("no step");
    assert!(matches!(error, CodeError::NoStep { outputs: 6 }), "{error}");
    let error = graphs::step(&simulator, &["rod: weight"]).expect_err("no such parameter");
    assert!(error.to_string().contains("rod: weight"), "{error}");
}

#[test]
fn texts_name_the_robot_and_are_the_same_each_time() {
    let model = asset("ur5.urdf");
    let text = || {
        let graph = graphs::inverse_dynamics(&model);
        let source = graph
            .to_cuda("ur5", Precision::Single, &[])
            .expect("a name");
        source.kernels[0].text().to_owned()
    };
    assert_eq!(text(), text());
    assert!(text().contains(&format!("{:016x}", model.fingerprint())));
    assert!(text().contains("#define REAL float"));
}
