//! Costs and constraints: their derivatives against finite differences and against one another.

use approx::assert_relative_eq;
use dualbody::contact::{ContactLaw, SoftContact, Terrain};
use dualbody::model::{FrameId, Model, samples};
use dualbody::spatial::{Quaternion, Representation, Transform};
use dualbody::trajopt::{
    Activation, CenterOfMass, CentroidalMomentum, Constraint, Cost, Dependence, FrameDistance,
    FrameOrientation, FramePose, FramePosition, FrameVelocity, InputError, Node, Obstacle,
    Residual, ResidualJacobian, Robot, StateError, System, effort_barrier, position_barrier,
    position_bounds, velocity_barrier,
};
use dualbody::{Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector, Vector3};
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use crate::common::ground::on;
use crate::common::{FINITE_DIFFERENCE, OTHER_ALGORITHM, SAME_ALGEBRA, asset};

/// Step of the differences of fourth order below.
const STEP: f64 = 2e-3;

/// The gradient of f in (δx, δu) by central differences of fourth order.
fn numeric_gradient(
    simulator: &Simulator,
    x: &[f64],
    u: &[f64],
    f: impl Fn(&[f64], &[f64]) -> f64,
) -> DVector<f64> {
    let ndx = simulator.ndx();
    DVector::from_fn(ndx + u.len(), |i, _| {
        let at = |step: f64| {
            let (mut dx, mut u) = (vec![0.0; ndx], u.to_vec());
            if i < ndx {
                dx[i] = step;
            } else {
                u[i - ndx] += step;
            }
            let mut moved = vec![0.0; x.len()];
            simulator.integrate(x, &dx, &mut moved);
            f(&moved, &u)
        };
        (8.0 * (at(STEP) - at(-STEP)) - (at(2.0 * STEP) - at(-2.0 * STEP))) / (12.0 * STEP)
    })
}

fn point(simulator: &Simulator, seed: u64) -> (DVector<f64>, Vec<f64>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let contact = DVector::from_fn(simulator.n_contact(), |k, _| 0.1 * (k as f64).sin());
    let state = State::random(simulator.model(), &mut rng, 1.0).with_contact(contact);
    let x = simulator.pack(&state);
    let u = (0..Simulator::nu(simulator)).map(|k| (k as f64).cos());
    (x, u.collect())
}

fn rotation() -> nalgebra::Matrix3<f64> {
    Quaternion::exp(&Vector3::new(0.3, -0.5, 0.2)).to_matrix()
}

/// Each residual of a robot, with a name for messages, in a cost of its own.
fn costs(
    simulator: &Simulator,
    activation: impl Fn(usize) -> Activation,
) -> Vec<(&'static str, Cost)> {
    let model = simulator.model();
    let frame = FrameId(model.frames().len() - 1);
    let other = FrameId(model.frames().len() / 2);
    let target = Vector3::new(0.1, -0.4, 0.7);
    let nu = Simulator::nu(simulator);
    let near = simulator.pack(&simulator.neutral_state());
    vec![
        (
            "state",
            Cost::new().with(
                0.7,
                activation(simulator.ndx()),
                StateError::to(near.as_slice()),
            ),
        ),
        (
            "input",
            Cost::new().with(0.7, activation(nu), InputError::to(&vec![0.3; nu])),
        ),
        (
            "position",
            Cost::new().with(0.7, activation(3), FramePosition { frame, target }),
        ),
        (
            "orientation",
            Cost::new().with(
                0.7,
                activation(3),
                FrameOrientation {
                    frame,
                    target: rotation(),
                },
            ),
        ),
        (
            "pose",
            Cost::new().with(
                0.7,
                activation(6),
                FramePose {
                    frame,
                    target: Transform::new(rotation(), target),
                },
            ),
        ),
        (
            "velocity",
            Cost::new().with(
                0.7,
                activation(6),
                FrameVelocity {
                    frame,
                    representation: Representation::Mixed,
                    target: [0.2; 6],
                },
            ),
        ),
        (
            "distance to a point",
            Cost::new().with(
                0.7,
                activation(1),
                FrameDistance {
                    frame,
                    from: Obstacle::Point(target),
                },
            ),
        ),
        (
            "distance of frames",
            Cost::new().with(
                0.7,
                activation(1),
                FrameDistance {
                    frame,
                    from: Obstacle::Frame(other),
                },
            ),
        ),
        (
            "centre of mass",
            Cost::new().with(0.7, activation(3), CenterOfMass { target }),
        ),
        (
            "momentum",
            Cost::new().with(0.7, activation(6), CentroidalMomentum { target: [0.1; 6] }),
        ),
    ]
}

fn activations() -> Vec<fn(usize) -> Activation> {
    vec![
        |_| Activation::Quadratic,
        |n| Activation::Weighted((0..n).map(|k| 1.0 + k as f64).collect()),
        |_| Activation::SmoothAbs { width: 0.4 },
        |n| Activation::barrier(&vec![-0.05; n], &vec![0.02; n]),
        |_| Activation::Flat { width: 1.5 },
    ]
}

fn robots() -> Vec<Model> {
    vec![
        samples::cartpole(),
        samples::arm(),
        samples::random_tree(7, 5),
    ]
}

#[test]
fn gradient_of_every_cost_equals_finite_differences() {
    let mut simulators: Vec<_> = robots().into_iter().map(Simulator::new).collect();
    // Bristles make the configuration less than half of the state.
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
    simulators.push(on(asset("double_pendulum.urdf"), Terrain::flat(0.0), law));
    for (seed, simulator) in simulators.into_iter().enumerate() {
        let (x, u) = point(&simulator, seed as u64);
        for activation in activations() {
            for (name, cost) in costs(&simulator, activation) {
                let value = |x: &[f64], u: &[f64]| cost.value(&simulator, 0, x, u);
                let expected = numeric_gradient(&simulator, x.as_slice(), &u, value);
                let exact = cost.expand(&simulator, 0, x.as_slice(), &u);
                assert_relative_eq!(
                    exact.value,
                    value(x.as_slice(), &u),
                    max_relative = SAME_ALGEBRA
                );
                let error = (&exact.gradient - &expected).amax() / expected.amax().max(1.0);
                let robot = simulator.model().name();
                assert!(
                    error < 1e2 * FINITE_DIFFERENCE,
                    "{robot}, {name}: {error:e}"
                );
            }
        }
    }
}

/// r of a residual, and the rows of its Jacobian.
fn linearized<R: Residual>(
    simulator: &Simulator,
    residual: R,
    x: &[f64],
    u: &[f64],
) -> (Vec<f64>, Vec<DVector<f64>>) {
    let n = residual.dim(&Node::new(simulator, 0));
    let constraint = Constraint::within(residual, &vec![-1.0; n], &vec![1.0; n]);
    let mut out = ResidualJacobian::new(simulator, n);
    constraint.linearize(simulator, 0, x, u, &mut out);
    let rows = (0..n).map(|i| DVector::from_column_slice(out.row(i)));
    let rows = rows.collect();
    (out.values, rows)
}

#[test]
fn jacobian_of_every_constraint_equals_finite_differences() {
    fn check<R: Residual + Clone>(simulator: &Simulator, residual: R) {
        let (x, u) = point(simulator, 6);
        let (_, rows) = linearized(simulator, residual.clone(), x.as_slice(), &u);
        for (i, row) in rows.iter().enumerate() {
            let entry = |x: &[f64], u: &[f64]| linearized(simulator, residual.clone(), x, u).0[i];
            let expected = numeric_gradient(simulator, x.as_slice(), &u, entry);
            let error = (row - &expected).amax() / expected.amax().max(1.0);
            let robot = simulator.model().name();
            let what = std::any::type_name::<R>();
            assert!(
                error < 1e2 * FINITE_DIFFERENCE,
                "{robot}, {what}, {i}: {error:e}"
            );
        }
    }
    for model in robots() {
        let simulator = &Simulator::new(model);
        let frame = FrameId(simulator.model().frames().len() - 1);
        let target = Vector3::new(0.1, -0.4, 0.7);
        check(simulator, StateError::to_neutral(simulator));
        check(simulator, InputError::to_zero(simulator));
        check(simulator, FramePosition { frame, target });
        let turned = rotation();
        let orientation = FrameOrientation {
            frame,
            target: turned,
        };
        check(simulator, orientation);
        let pose = Transform::new(turned, target);
        check(
            simulator,
            FramePose {
                frame,
                target: pose,
            },
        );
        let representations = [
            Representation::Body,
            Representation::Mixed,
            Representation::Inertial,
        ];
        for representation in representations {
            let velocity = FrameVelocity {
                frame,
                representation,
                target: [0.2; 6],
            };
            check(simulator, velocity);
        }
        let from = Obstacle::Point(target);
        check(simulator, FrameDistance { frame, from });
        check(simulator, CenterOfMass { target });
        check(simulator, CentroidalMomentum { target: [0.1; 6] });
    }
}

// Franka's data sheet, as in the file: ±2.8973 rad, 2.175 rad/s and 87 N·m at the first joint, −3.0718 … −0.0698 rad at
// the fourth, 2.61 rad/s and 12 N·m at the seventh.
#[test]
fn limits_of_a_robot_are_its_bounds_and_barriers() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/panda.urdf");
    let model = Model::from_urdf_file(file).unwrap();
    let simulator = Simulator::new(model);
    let (lower, upper) = position_bounds(&simulator);
    assert_eq!((lower[0], upper[0]), (-2.8973, 2.8973));
    assert_eq!((lower[3], upper[3]), (-3.0718, -0.0698));
    let nv = simulator.model().nv();
    assert_eq!((lower.len(), upper.len()), (2 * nv, 2 * nv));
    let free = |k: usize| lower[k] == f64::NEG_INFINITY && upper[k] == f64::INFINITY;
    assert!((nv..2 * nv).all(free));
    // ½ excess²: 0.1 rad too far at the fourth joint, 0.2 rad/s too fast at the first.
    let mut x = vec![0.0; 2 * nv];
    (x[3], x[nv]) = (0.0302, -2.375);
    let (activation, residual) = position_barrier(&simulator);
    let cost = Cost::new().with(1.0, activation, residual);
    assert_relative_eq!(
        cost.value(&simulator, 0, &x, &[]),
        0.005,
        max_relative = SAME_ALGEBRA
    );
    let (activation, residual) = velocity_barrier(&simulator);
    let cost = Cost::new().with(1.0, activation, residual);
    assert_relative_eq!(
        cost.value(&simulator, 0, &x, &[]),
        0.02,
        max_relative = SAME_ALGEBRA
    );

    // In the order of the inputs, not of the joints
    let both = simulator.with_actuated_joints(&["panda_joint7", "panda_joint1"]);
    let simulator = both.unwrap();
    assert_eq!(
        simulator.effort_bounds(),
        (vec![-12.0, -87.0], vec![12.0, 87.0])
    );
    let (activation, residual) = effort_barrier(&simulator);
    let cost = Cost::new().with(1.0, activation, residual);
    let value = cost.value(&simulator, 0, &x, &[11.0, -88.0]);
    assert_relative_eq!(value, 0.5, max_relative = SAME_ALGEBRA);
}

#[test]
fn bounds_of_a_robot_in_contact_are_as_long_as_its_state() {
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
    let simulator = on(asset("double_pendulum.urdf"), Terrain::flat(0.0), law);
    assert!(simulator.n_contact() > 0);
    assert_eq!(position_bounds(&simulator).0.len(), simulator.n_tangent());
    let (position, velocity) = (position_barrier(&simulator), velocity_barrier(&simulator));
    let cost = Cost::new()
        .with(1.0, position.0, position.1)
        .with(1.0, velocity.0, velocity.1);
    let x = simulator.pack(&simulator.neutral_state());
    assert_eq!(cost.value(&simulator, 0, x.as_slice(), &[]), 0.0);
}

#[cfg(feature = "second-order")]
#[test]
fn exact_hessian_equals_differences_of_the_gradient_and_gauss_newton_at_zero_residual() {
    let simulator = Simulator::new(samples::arm());
    let (x, u) = point(&simulator, 3);
    for (name, cost) in costs(&simulator, |_| Activation::Quadratic) {
        let exact = cost.expand_exactly(&simulator, 0, x.as_slice(), &u);
        let gauss_newton = cost.expand(&simulator, 0, x.as_slice(), &u);
        assert!(
            (&exact.gradient - &gauss_newton.gradient).amax() < 1e-10,
            "{name}"
        );
        let n = exact.gradient.len();
        for i in 0..n {
            let column = numeric_gradient(&simulator, x.as_slice(), &u, |x, u| {
                cost.expand(&simulator, 0, x, u).gradient[i]
            });
            let error = (exact.hessian.column(i) - column).amax();
            assert!(
                error < 1e-6 * exact.hessian.amax().max(1.0),
                "{name}: {error:e}"
            );
        }
    }
}

#[cfg(feature = "second-order")]
#[test]
fn gauss_newton_hessian_equals_the_exact_one_where_residuals_are_linear() {
    let simulator = Simulator::new(samples::arm());
    let (x, u) = point(&simulator, 3);
    for (name, cost) in costs(&simulator, |_| Activation::Quadratic)
        .into_iter()
        .take(2)
    {
        let exact = cost.expand_exactly(&simulator, 0, x.as_slice(), &u).hessian;
        let gauss_newton = cost.expand(&simulator, 0, x.as_slice(), &u).hessian;
        assert!((exact - gauss_newton).amax() < SAME_ALGEBRA, "{name}");
    }
}

/// A residual without the short ways that it may know.
struct ByDuals<R>(R);

impl<R: Residual> Residual for ByDuals<R> {
    fn dim(&self, node: &Node<'_>) -> usize {
        self.0.dim(node)
    }
    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], u: &[T], r: &mut [T]) {
        self.0.eval(node, x, u, r);
    }
}

#[test]
fn short_ways_equal_dual_numbers() {
    fn check<R: Residual + Clone>(name: &str, simulator: &Simulator, residual: R) {
        let (x, u) = point(simulator, 8);
        let n = residual.dim(&Node::new(simulator, 0));
        let bounds = (vec![0.0; n], vec![1.0; n]);
        let of = |constraint: Constraint| {
            let mut out = ResidualJacobian::new(simulator, n);
            constraint.linearize(simulator, 0, x.as_slice(), &u, &mut out);
            let rows: Vec<f64> = (0..n).flat_map(|i| out.row(i).to_vec()).collect();
            (
                DVector::from_vec(out.values.clone()),
                DMatrix::from_vec(rows.len() / n, n, rows),
            )
        };
        let short = of(Constraint::within(residual.clone(), &bounds.0, &bounds.1));
        let long = of(Constraint::within(ByDuals(residual), &bounds.0, &bounds.1));
        assert!((short.0 - long.0).amax() < 1e-13, "{name}");
        assert!((short.1 - long.1).amax() < SAME_ALGEBRA, "{name}");
    }
    for model in robots() {
        let simulator = Simulator::new(model);
        let frame = FrameId(simulator.model().frames().len() - 1);
        check("state", &simulator, StateError::to_neutral(&simulator));
        check("input", &simulator, InputError::to_zero(&simulator));
        check(
            "position",
            &simulator,
            FramePosition::new(frame, [0.1, 0.2, 0.3]),
        );
        let velocity = FrameVelocity {
            frame,
            representation: Representation::Body,
            target: [0.0; 6],
        };
        check("velocity", &simulator, velocity);
    }
}

#[test]
fn dependence_leaves_out_no_derivative() {
    assert_eq!(Dependence::default(), Dependence::Both);
    let simulator = Simulator::new(samples::random_tree(7, 5));
    let model = simulator.model();
    let (x, u) = point(&simulator, 4);
    let frame = FrameId(model.frames().len() - 1);
    let plain = Cost::new()
        .with(
            1.0,
            Activation::Quadratic,
            CentroidalMomentum { target: [0.1; 6] },
        )
        .with(
            1.0,
            Activation::Quadratic,
            FrameOrientation {
                frame,
                target: rotation(),
            },
        );
    let full = Cost::new()
        .with(
            1.0,
            Activation::Quadratic,
            ByDuals(CentroidalMomentum { target: [0.1; 6] }),
        )
        .with(
            1.0,
            Activation::Quadratic,
            ByDuals(FrameOrientation {
                frame,
                target: rotation(),
            }),
        );
    let [plain, full] = [plain, full].map(|cost| cost.expand(&simulator, 0, x.as_slice(), &u));
    assert!((plain.gradient - full.gradient).amax() < 1e-13);
    assert!((plain.hessian - full.hessian).amax() < SAME_ALGEBRA);
}

#[test]
fn distance_is_finite_where_frames_touch() {
    let simulator = Simulator::new(samples::arm());
    let frame = simulator.model().frame("tool").unwrap();
    let cost = Cost::new().with(
        1.0,
        Activation::Quadratic,
        FrameDistance {
            frame,
            from: Obstacle::Frame(frame),
        },
    );
    let (x, u) = point(&simulator, 1);
    let at = cost.expand(&simulator, 0, x.as_slice(), &u);
    assert_eq!((at.value, at.gradient.amax()), (0.0, 0.0));
    #[cfg(feature = "second-order")]
    assert!(
        cost.expand_exactly(&simulator, 0, x.as_slice(), &u)
            .hessian
            .iter()
            .all(|h| h.is_finite())
    );
}

// A rotation by the angle θ about the axis n has the rotation vector θ n.
#[test]
fn orientation_error_equals_the_rotation_vector_up_to_half_a_turn() {
    let simulator = Simulator::new(samples::pendulum());
    let frame = simulator.model().frame("rod").unwrap();
    let target = nalgebra::Matrix3::identity();
    for angle in [0.0, 1e-9, 0.3, 1.5, 3.1, -3.1] {
        let cost = Cost::new().with(
            1.0,
            Activation::Quadratic,
            FrameOrientation { frame, target },
        );
        let value = cost.value(&simulator, 0, &[angle, 0.0], &[]);
        assert_relative_eq!(value, 0.5 * angle * angle, max_relative = OTHER_ALGORITHM);
    }
}

#[test]
fn terms_count_at_their_stages_only_and_references_follow_the_stage() {
    let simulator = Simulator::new(samples::pendulum());
    let cost = Cost::new()
        .with_during(1..3, 2.0, Activation::Quadratic, InputError::to(&[1.0]))
        .with(
            2.0,
            Activation::Quadratic,
            StateError::along(&[[0.0, 0.0], [1.0, 0.0]]),
        );
    let at = |stage| cost.value(&simulator, stage, &[0.0, 0.0], &[0.0]);
    assert_eq!([at(0), at(1), at(2), at(3)], [0.0, 2.0, 2.0, 1.0]);
}
