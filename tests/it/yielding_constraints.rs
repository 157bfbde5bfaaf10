//! Constraints that give way: springs and dampers, bounded forces, tendons. Against closed forms, other constraints, finite differences, lanes and graphs.

use dualbody::autodiff::{VectorFunction, finite_difference};
use dualbody::codegen::{linearization, step};
use dualbody::constraint::{Anchor, Constraint, Impedance, Reference, Regularisation, Sigmoid};
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, Model, ModelBuilder, samples};
use dualbody::sim::BatchSimulator;
use dualbody::spatial::{Quaternion, Transform};
use dualbody::{Cast, Integrator, Scalar, Simulator, State};
use nalgebra::{DMatrix, Vector3};

use crate::common::everything::INTEGRATORS;
use crate::common::{SAME_ALGEBRA, gripper, random_point};

const EULER: [Integrator; 2] = [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];
const MASSES: [f64; 2] = [2.0, 0.5];
const DT: f64 = 0.01;

/// Two bodies on one level rail.
fn sliders() -> Model {
    let mut builder = ModelBuilder::new("sliders");
    builder.add_link(LinkSpec::new("world"));
    for (name, mass) in ["first", "second"].into_iter().zip(MASSES) {
        builder.add_link(LinkSpec::new(name).with_mass(mass, [0.0; 3], [0.01; 3]));
        let joint = JointSpec::new(format!("{name}_rail"), JointKind::Prismatic, "world", name);
        builder.add_joint(joint.with_axis([1.0, 0.0, 0.0]));
    }
    builder.build().expect("a robot that is known to be right")
}

fn on_rail(integrator: Integrator, constraints: Vec<Constraint>) -> Simulator {
    Simulator::new(sliders())
        .with_time_step(DT)
        .with_integrator(integrator)
        .with_constraints(constraints)
}

fn tendon(model: &Model, joints: &[(&str, f64)], length: f64) -> Constraint {
    Constraint::tendon(model, joints, length).expect("joints of the model")
}

fn frame(model: &Model, name: &str) -> Anchor {
    Anchor::frame(model, name).expect("a frame of the model")
}

/// A rod of 0.7 m between both sliders.
fn rod() -> Constraint {
    let model = sliders();
    Constraint::distance([frame(&model, "first"), frame(&model, "second")], 0.7)
}

/// x(t) and v(t) of  m ẍ + d ẋ + k x = 0, underdamped.
fn oscillator(m: f64, k: f64, d: f64, start: [f64; 2], t: f64) -> [f64; 2] {
    let decay = 0.5 * d / m;
    let omega = (k / m - decay * decay).sqrt();
    let ([x, v], (sin, cos)) = (start, (omega * t).sin_cos());
    let b = (v + decay * x) / omega;
    let e = (-decay * t).exp();
    let at = e * (x * cos + b * sin);
    [at, -decay * at + e * omega * (b * cos - x * sin)]
}

// v⁺ = (v − Δt k c² x / m) / (1 + Δt c² (d + Δt k) / m), x⁺ = x + Δt v⁺.
#[test]
fn tendon_with_a_spring_is_the_implicit_oscillator_at_any_stiffness() {
    let (c, length) = (0.3, 0.12);
    for integrator in EULER {
        for (k, d) in [
            (800.0, 3.0),
            (1e6, 0.0),
            (1e12, 1e5),
            (0.0, 40.0),
            (0.0, 0.0),
        ] {
            let tied = tendon(&sliders(), &[("first_rail", c)], length).with_spring(k, d);
            let simulator = on_rail(integrator, vec![tied]);
            let (mut x, mut v) = (0.2, -1.0);
            let mut state = simulator.state(&[length / c + x, 0.0], &[v, 0.0]);
            for _ in 0..50 {
                state = simulator.step(&state, &[0.0, 0.0]);
                let resistance = DT * c * c * (d + DT * k) / MASSES[0];
                v = (v - DT * k * c * c * x / MASSES[0]) / (1.0 + resistance);
                x += DT * v;
                let (at, error) = (state.q[0] - length / c, (state.v[0] - v).abs());
                assert!(error < 1e-9, "{integrator:?}, {k}, {d}: {error:e}");
                assert!((at - x).abs() < 1e-9, "{integrator:?}, {k}, {d}");
            }
        }
    }
}

// The distance of two bodies on a rail moves as one body of the reduced mass does.
#[test]
fn elastic_rod_between_two_bodies_is_an_oscillator_of_their_reduced_mass() {
    let (k, d) = (200.0, 2.0);
    let reduced = MASSES[0] * MASSES[1] / (MASSES[0] + MASSES[1]);
    for (integrator, dt, tolerance) in [
        (Integrator::RungeKutta4, 1e-3, 1e-9),
        (Integrator::SemiImplicitEuler, 1e-5, 1e-3),
        (Integrator::ImplicitVelocity, 1e-5, 1e-3),
    ] {
        let simulator = on_rail(integrator, vec![rod().with_spring(k, d)]).with_time_step(dt);
        let start = simulator.state(&[0.0, 0.75], &[0.3, 0.8]);
        let seconds = 0.2;
        let steps = (seconds / dt).round() as usize;
        let rollout = simulator.rollout(&start, steps, |_, _, _| {});
        let last = rollout.last();
        let expected = oscillator(reduced, k, d, [0.05, 0.5], seconds);
        let found = [last.q[1] - last.q[0] - 0.7, last.v[1] - last.v[0]];
        for (found, expected) in found.iter().zip(expected) {
            let error = (found - expected).abs();
            assert!(error < tolerance, "{integrator:?}: {error:e}");
        }
        let momentum = |state: &State| MASSES[0] * state.v[0] + MASSES[1] * state.v[1];
        assert!((momentum(last) - momentum(&start)).abs() < 1e-9);
    }
}

#[test]
fn forces_of_springs_in_reports_are_those_that_act() {
    let (k, d) = (200.0, 2.0);
    for integrator in INTEGRATORS {
        let soft = rod().with_spring(k, d);
        let at = |rod: Constraint| {
            let simulator = on_rail(integrator, vec![rod]);
            let start = simulator.state(&[0.0, 0.75], &[0.3, 0.8]);
            let force = simulator.contact_report(&start, &[0.0; 2]).constraints[0];
            let next = simulator.step(&start, &[0.0; 2]);
            let [rate, error] = [next.v[1] - next.v[0], next.q[1] - next.q[0] - 0.7];
            (force, -k * error - d * rate, (next.v[1] - 0.8) / DT)
        };
        let (force, at_end, _) = at(soft.clone());
        match integrator {
            Integrator::RungeKutta4 => assert!((force + k * 0.05 + d * 0.5).abs() < SAME_ALGEBRA),
            _ => assert!((force - at_end).abs() < 1e-9, "{force}, not {at_end}"),
        }
        let (force, _, acceleration) = at(soft.with_largest_force(3.0));
        assert_eq!(force, -3.0);
        assert!(
            (acceleration * MASSES[1] + 3.0).abs() < 1e-9,
            "{integrator:?}"
        );
    }
}

#[test]
fn tendon_over_two_joints_is_a_coupler() {
    let model = gripper()
        .build()
        .expect("a robot that is known to be right");
    let (ratio, offset) = (0.8, 0.1);
    let coupler = Constraint::coupler(&model, ["tip_joint", "elbow_joint"], ratio, offset);
    let coupler = coupler.expect("joints of the gripper");
    let joints = [("tip_joint", 1.0), ("elbow_joint", -ratio)];
    let same = tendon(&model, &joints, offset);
    let state = random_point(&model, 5);
    for integrator in INTEGRATORS {
        for change in [
            |c: Constraint| c,
            |c: Constraint| c.with_spring(300.0, 4.0),
            |c: Constraint| c.with_largest_force(0.5),
        ] {
            let of = |constraint: &Constraint| {
                Simulator::new(model.clone())
                    .with_integrator(integrator)
                    .with_constraints(vec![change(constraint.clone())])
            };
            let (one, two) = (of(&coupler), of(&same));
            let u = vec![0.3; one.nu()];
            let start = State::new(state.q.as_slice(), state.v.as_slice());
            assert_eq!(one.step(&start, &u), two.step(&start, &u), "{integrator:?}");
            assert_eq!(one.linearize(&start, &u).a, two.linearize(&start, &u).a);
        }
    }
}

// Σ cᵢ qᵢ stays, and forces are in the ratio of the coefficients: with one force λ the accelerations are cᵢ λ / mᵢ beside the inputs.
#[test]
fn rigid_tendon_keeps_its_length() {
    let (a, b, u) = (2.0, -3.0, [1.5, 0.7]);
    for integrator in INTEGRATORS {
        let tied = tendon(&sliders(), &[("first_rail", a), ("second_rail", b)], 0.4);
        let simulator = on_rail(integrator, vec![tied]);
        let start = simulator.state(&[0.2, 0.0], &[0.3, 0.2]);
        let next = simulator.step(&start, &u);
        assert!(simulator.constraint_errors(&next)[0].abs() < SAME_ALGEBRA);
        let weighted = a * a / MASSES[0] + b * b / MASSES[1];
        let force = -(a * u[0] / MASSES[0] + b * u[1] / MASSES[1]) / weighted;
        for (k, c) in [a, b].into_iter().enumerate() {
            let expected = (u[k] + c * force) / MASSES[k];
            let found = (next.v[k] - start.v[k]) / DT;
            assert!((found - expected).abs() < 1e-9, "{integrator:?}: {found}");
        }
        let report = simulator.contact_report(&start, &u);
        assert!((report.constraints[0] - force).abs() < 1e-9);
    }
}

#[test]
fn mass_that_is_pulled_harder_than_the_bound_slides_and_otherwise_stays() {
    let bound = 3.0;
    let brake = tendon(&sliders(), &[("first_rail", 1.0)], 0.0).with_largest_force(bound);
    for integrator in INTEGRATORS {
        let simulator = on_rail(integrator, vec![brake.clone()]);
        let rest = simulator.neutral_state();
        for pull in [-2.9, 0.0, 1.0, 2.9] {
            let held = simulator.rollout(&rest, 20, |_, _, u| u[0] = pull);
            assert!(held.last().v[0].abs() < SAME_ALGEBRA, "{integrator:?}");
            assert!(held.last().q[0].abs() < SAME_ALGEBRA, "{integrator:?}");
        }
        for (pull, force) in [(5.0, 2.0), (-4.0, -1.0)] {
            let slid = simulator.rollout(&rest, 20, |_, _, u| u[0] = pull);
            let expected = 20.0 * DT * force / MASSES[0];
            let error = (slid.last().v[0] - expected).abs();
            assert!(error < 1e-9, "{integrator:?}, {pull}: {error:e}");
        }
    }
}

// A damper with a bounded force is dry friction: v falls by Δt b / m a step, and then rests.
#[test]
fn damper_with_a_bounded_force_is_dry_friction() {
    let (bound, damping) = (4.0, 1e6);
    for integrator in EULER {
        let brake = tendon(&sliders(), &[("first_rail", 1.0)], 0.0);
        let brake = brake.with_spring(0.0, damping).with_largest_force(bound);
        let simulator = on_rail(integrator, vec![brake]);
        let mut state = simulator.state(&[0.3, 0.0], &[0.11, 0.0]);
        let mut v: f64 = 0.11;
        for _ in 0..20 {
            state = simulator.step(&state, &[0.0; 2]);
            v = (v - DT * bound / MASSES[0]).max(0.0);
            assert!((state.v[0] - v).abs() < 1e-5, "{}, not {v}", state.v[0]);
        }
        let pushed = simulator.step(&state, &[3.9, 0.0]);
        assert!(pushed.v[0].abs() < 1e-5, "{integrator:?}");
        let pushed = simulator.step(&state, &[6.0, 0.0]);
        let expected = DT * 2.0 / MASSES[0];
        assert!((pushed.v[0] - expected).abs() < 1e-5, "{integrator:?}");
    }
}

#[test]
fn springs_and_bounded_forces_never_give_energy() {
    let (k, d) = (5e3, 0.5);
    for (rod, stored) in [
        (rod().with_spring(k, d), k),
        (rod().with_spring(0.0, 50.0).with_largest_force(1.0), 0.0),
    ] {
        for integrator in EULER {
            let simulator = on_rail(integrator, vec![rod.clone()]);
            let start = simulator.state(&[0.0, 0.9], &[0.5, -0.3]);
            let rollout = simulator.rollout(&start, 400, |_, _, _| {});
            let energy = |state: &State| {
                let error = state.q[1] - state.q[0] - 0.7;
                let kinetic = (0..2).map(|i| 0.5 * MASSES[i] * state.v[i] * state.v[i]);
                kinetic.sum::<f64>() + 0.5 * stored * error * error
            };
            let all: Vec<f64> = rollout.states.iter().map(energy).collect();
            for pair in all.windows(2) {
                assert!(pair[1] <= pair[0] * (1.0 + 1e-12), "{pair:?}");
            }
            assert!(all[400] < 0.9 * all[0]);
        }
    }
}

#[test]
fn assembly_closes_what_is_rigid_and_leaves_springs() {
    let model = sliders();
    let pull = tendon(&model, &[("first_rail", 1.0)], 3.0).with_spring(100.0, 1.0);
    let simulator = on_rail(Integrator::default(), vec![pull, rod()]);
    let start = simulator.state(&[0.1, 0.9], &[0.2, 0.0]);
    let closed = simulator.assemble(&start).expect("in reach").state;
    let errors = simulator.constraint_errors(&closed);
    assert!(errors[1].abs() < 1e-12 && errors[0] < -2.5, "{errors:?}");
    assert!((closed.v[0] - closed.v[1]).abs() < SAME_ALGEBRA);
}

fn slow_point(model: &Model, seed: u64) -> State {
    let at = random_point(model, seed);
    State::new(at.q.as_slice(), (at.v * 0.3).as_slice())
}

/// A regularisation whose impedance rises over a width.
fn soft(width: f64) -> Regularisation {
    Regularisation {
        reference: Reference::TimeConstant {
            time_constant: 0.03,
            damping_ratio: 0.8,
        },
        impedance: Impedance {
            least: 0.6,
            largest: 0.9,
            width,
            sigmoid: Sigmoid::new(0.4, 3.0),
        },
        inverse_mass: 0.7,
        inverse_inertia: 3.0,
        lever: 0.3,
    }
}

fn direct() -> Regularisation {
    Regularisation {
        reference: Reference::Direct {
            stiffness: 900.0,
            damping: 40.0,
        },
        impedance: Impedance {
            width: 0.4,
            ..Impedance::default()
        },
        ..soft(1.0)
    }
}

/// Constraints of each kind, rigid, elastic and regularised, with and without bounds, some at them and some not.
pub(crate) fn all_sorts() -> Vec<(Simulator, State)> {
    let tree = samples::random_tree(8, 2);
    let state = slow_point(&tree, 4);
    let end = frame(&tree, "link6").moved([0.1, -0.2, 0.3]);
    let nail = Anchor::world().moved([0.3, 0.2, -0.4]);
    let rod = Constraint::distance([frame(&tree, "link3").moved([0.2, 0.1, 0.0]), end], 0.4);
    let welded =
        frame(&tree, "link3").brought_to(&frame(&tree, "link6"), &tree, state.q.as_slice());
    let weld = Constraint::weld([welded.moved([0.01, 0.02, 0.0]), frame(&tree, "link6")]);
    let turned = Quaternion::exp(&Vector3::new(0.3, -0.2, 0.5)).to_matrix();
    let mut apart = welded;
    apart.placement = apart.placement * Transform::new(turned, Vector3::new(0.01, 0.02, 0.0));
    let weld_apart = Constraint::weld([apart, frame(&tree, "link6")]);
    let ball = Constraint::ball([nail, end]);
    let sets = [
        vec![weld.clone().with_spring(900.0, 20.0), rod.clone()],
        vec![
            ball.clone().with_largest_force(4.0),
            rod.clone().with_spring(300.0, 2.0),
        ],
        vec![
            rod.clone().with_largest_force(1e5),
            weld.with_largest_force(0.7),
        ],
        vec![
            weld_apart.with_regularisation(soft(0.9)),
            rod.clone().with_regularisation(direct()),
        ],
        vec![
            ball.clone()
                .with_regularisation(soft(0.3))
                .with_largest_force(2.0),
            rod.clone(),
        ],
        vec![
            ball.with_spring(200.0, 3.0).with_largest_force(60.0),
            rod.with_spring(300.0, 5.0).with_largest_force(9.0),
        ],
    ];
    let mut out: Vec<_> = sets
        .into_iter()
        .map(|set| {
            (
                Simulator::new(tree.clone()).with_constraints(set),
                state.clone(),
            )
        })
        .collect();
    let hand = gripper()
        .build()
        .expect("a robot that is known to be right");
    let state = slow_point(&hand, 5);
    let joints = [
        ("tip_joint", 0.8),
        ("elbow_joint", -0.5),
        ("left_joint", 1.3),
    ];
    let tied = tendon(&hand, &joints, 0.1);
    for set in [
        vec![tied.clone()],
        vec![tied.clone().with_spring(80.0, 2.0)],
        vec![tied.clone().with_largest_force(0.4)],
        vec![tied.clone().with_regularisation(soft(2.0))],
        vec![tied.with_spring(80.0, 2.0).with_largest_force(0.2)],
    ] {
        out.push((
            Simulator::new(hand.clone()).with_constraints(set),
            state.clone(),
        ));
    }
    out
}

/// A step in the tangent directions of its state, and the input.
struct Stepped<'a> {
    simulator: &'a Simulator,
    start: &'a State,
    /// The next state, from which changes of it are measured.
    next: State,
}

impl VectorFunction for Stepped<'_> {
    fn n_outputs(&self) -> usize {
        self.simulator.n_tangent()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let (simulator, start) = (self.simulator.cast::<T>(), self.start.cast::<T>());
        let model = simulator.model();
        let nv = model.nv();
        let q = model.integrate(start.q.as_slice(), &x[..nv]);
        let v: Vec<T> = (0..nv).map(|k| start.v[k] + x[nv + k]).collect();
        let u: Vec<T> = x[2 * nv..].iter().map(|&u| u + 0.1).collect();
        let next = simulator.step(&State::new(q.as_slice(), &v), &u);
        let moved = next.deviation(model, &self.next.cast());
        y.copy_from_slice(moved.as_slice());
    }
}

#[test]
fn jacobians_equal_finite_differences() {
    for integrator in INTEGRATORS {
        for (which, (simulator, state)) in all_sorts().into_iter().enumerate() {
            let simulator = simulator.with_integrator(integrator).with_time_step(0.002);
            let (n, nu) = (simulator.n_tangent(), simulator.nu());
            let step = simulator.linearize(&state, &vec![0.1; nu]);
            let mut exact = DMatrix::zeros(n, n + nu);
            exact.columns_mut(0, n).copy_from(&step.a);
            exact.columns_mut(n, nu).copy_from(&step.b);
            let f = Stepped {
                simulator: &simulator,
                start: &state,
                next: simulator.step(&state, &vec![0.1; nu]),
            };
            let numeric = finite_difference::jacobian(&f, &vec![0.0; n + nu]);
            let error = (&exact - &numeric).amax() / numeric.amax();
            assert!(error < 1e-6, "{integrator:?}, {which}: {error:e}");
        }
    }
}

// In attachment frames, lengths and the parameters of the force law, and in the time step.
#[test]
fn gradients_of_regularised_constraints_equal_finite_differences() {
    let is_soft = |tied: &Constraint| tied.regularisation().is_some();
    for integrator in INTEGRATORS {
        let all = all_sorts().into_iter().enumerate();
        for (which, (simulator, state)) in
            all.filter(|(_, (own, _))| own.constraints().iter().any(is_soft))
        {
            let simulator = simulator.with_integrator(integrator).with_time_step(0.002);
            let u = vec![0.1; simulator.nu()];
            let n = simulator.n_tangent();
            let weights: Vec<f64> = (0..n).map(|k| (1.0 + k as f64).sin()).collect();
            let found = simulator.vjp(&state, &u, &weights);
            let next = simulator.step(&state, &u);
            let sum = |by: &[f64]| -> f64 {
                let other = simulator.with_parameters(by);
                let moved = other.step(&state, &u).deviation(simulator.model(), &next);
                moved.iter().zip(&weights).map(|(x, w)| x * w).sum()
            };
            let (own, layout) = (simulator.parameters(), simulator.parameter_layout());
            let of_constraints = (0..own.len()).filter(|&k| {
                let name = &layout.names()[k];
                name.starts_with("constraint") || name.contains("time step")
            });
            let mut count = 0;
            for k in of_constraints {
                let by = 1e-6 * own[k].abs().max(1e-2);
                let at = |by: f64| {
                    let mut moved = own.clone();
                    moved[k] += by;
                    sum(moved.as_slice())
                };
                let expected = (at(by) - at(-by)) / (2.0 * by);
                let error = (found.parameters[k] - expected).abs();
                let name = &layout.names()[k];
                assert!(
                    error < 1e-4 * expected.abs().max(1e-2),
                    "{integrator:?}, {which}, {name}: {} for {expected}",
                    found.parameters[k]
                );
                count += 1;
            }
            assert!(count > 10, "{count}");
        }
    }
}

#[test]
fn batches_equal_steps_alone_bit_for_bit() {
    for integrator in INTEGRATORS {
        for (simulator, state) in all_sorts() {
            let simulator = simulator.with_integrator(integrator).with_time_step(0.002);
            let starts: Vec<State> = (0..10)
                .map(|k| {
                    let mut start = state.clone();
                    start.v *= 0.3 * f64::from(k) - 1.0;
                    start
                })
                .collect();
            let mut batch = BatchSimulator::new(simulator.clone(), starts.len()).with_threads(1);
            let rollout = batch.rollout(&starts, 5, |_, _, _| {});
            for (i, start) in starts.iter().enumerate() {
                let alone = simulator.rollout(start, 5, |_, _, _| {});
                assert_eq!(&rollout.state(i, 5), alone.last(), "{integrator:?}, {i}");
            }
        }
    }
}

#[test]
fn graphs_give_the_steps_and_jacobians() {
    for integrator in INTEGRATORS {
        for (which, (simulator, state)) in all_sorts().into_iter().enumerate() {
            let simulator = simulator.with_integrator(integrator).with_time_step(0.002);
            let u = vec![0.1; simulator.nu()];
            let inputs: Vec<f64> = state.numbers().chain(&u).copied().collect();
            let next = simulator.step(&state, &u);
            let jacobians = simulator.linearize(&state, &u);
            // Bounded forces are those of a path near its end.
            let bounded = |tied: &Constraint| tied.largest_force().is_some();
            let any = simulator.constraints().iter().any(bounded);
            let tolerance = if any { 1e-5 } else { 1e-8 };
            let expected = [
                next.numbers().copied().collect::<Vec<_>>(),
                jacobians.a.iter().chain(&jacobians.b).copied().collect(),
            ];
            for (graph, expected) in [step(&simulator), linearization(&simulator)]
                .iter()
                .zip(expected)
            {
                let found = graph.evaluate(&inputs).expect("forces are found");
                let largest = expected.iter().fold(1.0, |most: f64, x| x.abs().max(most));
                for (found, expected) in found.iter().zip(&expected) {
                    let off = (found - expected).abs() / largest;
                    assert!(off < tolerance, "{integrator:?}, {which}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn numbers_are_parameters_with_names_and_domains() {
    let hand = gripper()
        .build()
        .expect("a robot that is known to be right");
    let tied = tendon(&hand, &[("tip_joint", 0.8), ("elbow_joint", -0.5)], 0.1);
    let tied = tied.with_spring(80.0, 2.0).with_largest_force(0.2);
    let simulator = Simulator::new(hand).with_constraints(vec![tied]);
    let (layout, mut parameters) = (simulator.parameter_layout(), simulator.parameters());
    for (name, value) in [
        ("coefficient 0", 0.8),
        ("coefficient 1", -0.5),
        ("length", 0.1),
        ("stiffness", 80.0),
        ("damping", 2.0),
        ("largest force", 0.2),
    ] {
        let index = layout
            .find(&format!("constraint 0: {name}"))
            .expect("a parameter");
        assert_eq!(parameters[index], value, "{name}");
        parameters[index] = 2.0 * value;
    }
    let other = simulator.with_parameters(parameters.as_slice());
    let constraint = &other.constraints()[0];
    assert_eq!(constraint.spring(), Some([160.0, 4.0]));
    assert_eq!(constraint.largest_force(), Some(0.4));
}

#[test]
#[should_panic(expected = "the largest force of a constraint is -1: negative or not finite")]
fn negative_largest_force_among_parameters_is_refused() {
    let brake = tendon(&sliders(), &[("first_rail", 1.0)], 0.0).with_largest_force(1.0);
    let simulator = on_rail(Integrator::default(), vec![brake]);
    let mut parameters = simulator.parameters();
    let index = (simulator.parameter_layout()).find("constraint 0: largest force");
    parameters[index.expect("a bound")] = -1.0;
    let _ = simulator.with_parameters(parameters.as_slice());
}

#[test]
#[should_panic(expected = "does not have exactly one degree of freedom to couple")]
fn tendon_over_a_joint_of_several_coordinates_is_refused() {
    let model = samples::random_tree(8, 2);
    let all = model.joint_names();
    let wide = all.iter().find(|name| {
        let joint = model.joint(name).expect("a joint");
        model.joint_q(joint).len() > 1
    });
    let _ = Constraint::tendon(&model, &[(wide.expect("a wide joint"), 1.0)], 0.0);
}

#[test]
fn unknown_joint_of_a_tendon_is_an_error_that_names_it() {
    let joints = [("first_rail", 1.0), ("third_rail", 1.0)];
    let error = Constraint::tendon(&sliders(), &joints, 0.0).unwrap_err();
    assert_eq!(error.name, "third_rail");
}
