//! Gradients of steps and rollouts: against transposed Jacobians, forward mode, finite differences and known truths.

use dualbody::autodiff::{Dual, VectorFunction, gradient, jacobian};
use dualbody::constraint::{Anchor, Constraint, Regularisation};
use dualbody::contact::{
    ContactLaw, ContactPoint, Contacts, Feature, HeightField, HeightFunction, HuntCrossley,
    RelaxedRigid, Rigid, SoftContact, Terrain, TerrainFunction,
};
use dualbody::linearize::{
    Checkpoints, CostScratch, CostSlopes, RolloutCost, RolloutGradient, RolloutGradientOptions,
    StagePoint, StepGradient, VjpScratch, WantedParameters,
};
use dualbody::model::{LinkSpec, ModelBuilder, Spring, samples};
use dualbody::sim::{
    Actuation, Actuator, BatchSimulator, CoulombFriction, ExternalForce, ForceFunction,
    FrameActuator, PositionLimits, RolloutStatus, Servo, TorqueSpeed, VelocityLimit,
};
use dualbody::spatial::{Force, Motion, Representation, Transform};
use dualbody::{Cast, Integrator, Model, Scalar, Simulator, State};
use nalgebra::{DVector, Vector3};
use rand::RngExt;

use crate::common::everything::INTEGRATORS;
use crate::common::{
    OTHER_ALGORITHM, SAME_ALGEBRA, assert_close_vector, asset, generator, gripper, random_point,
    robots,
};

/// A damped spring to a point that also turns its place: all that a force can follow.
struct Tether;

impl ForceFunction for Tether {
    fn force<T: Scalar>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        parameters: &[T],
    ) -> Force<T> {
        let p = &pose.translation;
        let stiffness = (p.x * p.x + p.y * p.y + p.z * p.z + 1.0).sqrt() * parameters[0];
        let pull = p.map(|x| -x * stiffness) - velocity.linear.map(|x| x * parameters[1]);
        let axis = pose.rotation.column(2).into_owned();
        Force::new(pull, axis - velocity.angular)
    }
}

/// Forces of all sorts on the last link, which may follow it.
fn with_forces(simulator: Simulator) -> Simulator {
    let model = simulator.model();
    if model.nv() == 0 {
        return simulator;
    }
    let links = model.link_names();
    let on = |name: &str| Anchor::frame(model, name).expect("a link of the robot");
    let place = on(links[links.len() - 1]).moved([0.1, 0.2, -0.3]);
    let push = Force::from_array([1.0, -2.0, 3.0, 0.4, 0.5, -0.6]);
    let (mut forces, mut actuators) = (Vec::new(), Vec::new());
    for r in Representation::ALL {
        forces.push(ExternalForce::constant(place, push, r));
        forces.push(ExternalForce::function(place, Tether, &[5.0, 0.7], r));
        actuators.push(FrameActuator::new(format!("{r:?}"), place, push, r));
    }
    let thruster = FrameActuator::thruster("thruster", place, [0.1, 0.2, 0.9], -0.1);
    actuators.push(thruster.with_limits(-10.0, 0.1));
    simulator
        .with_external_forces(forces)
        .with_frame_actuators(actuators)
}

/// Springs, dampers, motors, friction and stops in all joints that can have them.
fn with_stiff_joints(model: Model) -> Simulator {
    let spring = Spring {
        stiffness: 300.0,
        rest: 0.1,
    };
    let own = model.bodies().iter().filter(|body| body.coupling.is_none());
    let single: Vec<usize> = own
        .filter(|body| body.joint.nq() == 1)
        .map(|body| body.v)
        .collect();
    let model = single.iter().fold(model, |model, &k| {
        model.with_damping(k, 3.0).with_spring(k, spring)
    });
    let actuator = |k: usize| Actuator {
        servo: None,
        torque_speed: Some(TorqueSpeed {
            torque: 8.0,
            threshold: 0.5,
            maximum: 3.0,
        }),
        effort: Some(6.0),
        friction: Some(CoulombFriction::smoothed(0.5, 0.02)),
        position: single.contains(&k).then_some(PositionLimits {
            lower: Some(-0.2),
            upper: Some(0.3),
            stop: HuntCrossley::linear(2e3, 30.0),
        }),
        velocity: Some(VelocityLimit {
            speed: 0.7,
            damping: 2.0,
        }),
    };
    let actuators: Vec<_> = (0..model.nv()).map(actuator).collect();
    let actuation = Actuation::ideal(&model).with_actuators(&actuators);
    Simulator::new(model).with_actuation(actuation)
}

/// [`with_stiff_joints`] whose dry friction holds, and which servos drive, some of them at their limits.
fn with_dry_friction(model: Model) -> Simulator {
    let simulator = with_stiff_joints(model);
    let smoothed = simulator.actuation().expect("friction");
    let all = smoothed.actuators().iter().enumerate();
    let exact = all.map(|(k, actuator)| Actuator {
        friction: Some(CoulombFriction::exact(2.0)),
        torque_speed: None,
        servo: match k % 4 {
            0 => None,
            _ if actuator.position.is_none() => {
                Some(Servo::velocity(20.0).with_force_range(-30.0, 2.0))
            }
            _ => Some(
                Servo::position(1e3, 20.0)
                    .with_gear(0.3)
                    .with_input_range(-0.5, 2.0)
                    .with_force_range(-40.0, 60.0),
            ),
        },
        effort: (k % 4 < 3).then_some(3.0),
        ..*actuator
    });
    let actuation = smoothed.with_actuators(&exact.collect::<Vec<_>>());
    simulator.with_actuation(actuation)
}

/// Robots with dry friction of which some joints stick and some slide.
fn dry_friction() -> Vec<Case> {
    let mut all = Vec::new();
    for (seed, model) in robots().into_iter().enumerate() {
        for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
            let simulator = with_dry_friction(model.clone());
            let simulator = simulator.with_integrator(integrator).with_time_step(0.01);
            let mut case = Case::new(simulator, 0.5, "dry friction", seed as u64);
            let slow = case.state.v.iter_mut().enumerate();
            slow.filter(|(k, _)| k % 3 < 2)
                .for_each(|(_, v)| *v *= 1e-3);
            all.push(case);
        }
    }
    all
}

/// A robot, how it is simulated, and where.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) simulator: Simulator,
    pub(crate) state: State,
    pub(crate) u: DVector<f64>,
    adjoint: DVector<f64>,
}

impl Case {
    fn new(simulator: Simulator, speed: f64, what: &str, seed: u64) -> Self {
        let model = simulator.model();
        let (point, mut rng) = (random_point(model, seed), generator(seed + 7));
        let mut numbers = |n: usize| DVector::from_fn(n, |_, _| rng.random_range(-1.0..1.0));
        let contact = numbers(simulator.n_contact()) * 1e-3;
        let state = State::new(point.q.as_slice(), (point.v * speed).as_slice());
        Self {
            name: format!("{}, {what}, {:?}", model.name(), simulator.integrator()),
            state: state.with_contact(contact),
            u: numbers(simulator.nu()),
            adjoint: numbers(simulator.n_tangent()),
            simulator,
        }
    }

    /// Robots of every sort without rows.
    pub(crate) fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for (seed, model) in robots().into_iter().enumerate() {
            for integrator in INTEGRATORS {
                // Explicit steps of stiff and fast robots would diverge.
                let fast = match integrator {
                    Integrator::RungeKutta4 => 2.0,
                    _ => 150.0,
                };
                let plain = Simulator::new(model.clone());
                let stiff = with_stiff_joints(model.clone());
                for (simulator, what, speed) in [
                    (plain.clone(), "plain", 1.0),
                    (with_forces(plain.clone()), "forces", 1.0),
                    (stiff.clone(), "stiff", 1.0),
                    (plain, "whirling", fast),
                    (with_forces(stiff), "stiff and whirling", fast),
                ] {
                    let simulator = simulator.with_integrator(integrator).with_time_step(0.01);
                    all.push(Self::new(simulator, speed, what, seed as u64));
                }
            }
        }
        all.extend(soft_contact());
        all.extend(dry_friction());
        all
    }

    fn vjp(&self) -> StepGradient {
        let (state, u, adjoint) = (&self.state, self.u.as_slice(), self.adjoint.as_slice());
        let mut out = StepGradient::zeros(&self.simulator);
        let mut scratch = VjpScratch::new(&self.simulator);
        // Twice, so that an effect of the first call would show.
        for _ in 0..2 {
            (self.simulator).vjp_into(state, u, adjoint, &mut scratch, &mut out);
        }
        out
    }
}

/// A robot that touches an incline with its feet, or with all that it has.
fn touching(simulator: Simulator, law: ContactLaw, feet: &[&str], seed: u64) -> Case {
    touching_ground(simulator, Terrain::incline(0.1), law, feet, seed)
}

/// A robot that touches some ground.
fn touching_ground(
    simulator: Simulator,
    ground: Terrain,
    law: ContactLaw,
    feet: &[&str],
    seed: u64,
) -> Case {
    let contacts = Contacts::new(simulator.model(), ground, law);
    let contacts = match feet {
        [] => contacts,
        feet => contacts.with_links(simulator.model(), feet).expect("feet"),
    };
    let simulator = simulator.with_contacts(contacts);
    let mut case = Case::new(simulator, 0.5, &format!("{law:?}"), seed);
    case.state
        .q
        .copy_from(&case.simulator.neutral_state::<f64>().q);
    case.state.v[2] -= 0.5;
    let contacts = case.simulator.contacts().expect("contacts");
    let (q, v) = (case.state.q.as_slice(), case.state.v.as_slice());
    let points = contacts.states(case.simulator.model(), q, v);
    let deepest = points.iter().map(|s| s.depth).fold(f64::MIN, f64::max);
    case.state.q[2] += deepest - 1e-3;
    case
}

const FEET: [&str; 4] = ["FL_foot", "FR_foot", "RL_foot", "RR_foot"];

fn soft() -> ContactLaw {
    ContactLaw::Soft(SoftContact::estimate(10.0, 4, 1e-3))
}

/// Robots in soft contact whose forces are those of the start of a step.
fn soft_contact() -> Vec<Case> {
    let mut all = Vec::new();
    for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
        for (robot, feet) in [("box.urdf", &[][..]), ("quadruped.urdf", &FEET[..])] {
            let simulator = Simulator::new(asset(robot)).with_integrator(integrator);
            all.push(touching(simulator, soft(), feet, 5));
        }
    }
    all
}

/// Waves along x and y.
struct Waves;

impl HeightFunction for Waves {
    fn height<T: Scalar>(&self, x: T, y: T, parameters: &[T]) -> T {
        let along = (x * parameters[1] + y * parameters[2]).sin_cos().0;
        along * parameters[0]
    }
}

/// A grid of ground that is nowhere level.
fn grid() -> HeightField {
    let heights: Vec<f64> = (0..42).map(|k| 0.02 * (1.7 * f64::from(k)).sin()).collect();
    HeightField::new([-1.3, -1.1], [0.45, 0.5], [7, 6], &heights)
}

/// Robots on ground that is not a plane, which the force of a step follows or a solver finds.
pub(crate) fn uneven_ground() -> Vec<Case> {
    let waves = TerrainFunction::new(Waves, &[0.03, 2.0, -1.5]);
    let grounds = [Terrain::HeightField(grid()), Terrain::Function(waves)];
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let rigid = ContactLaw::Rigid(Rigid::default());
    let [explicit, implicit] = [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];
    let mut all = Vec::new();
    for (law, integrator) in [
        (relaxed, explicit),
        (rigid, implicit),
        (soft(), explicit),
        (soft(), implicit),
    ] {
        for (seed, (robot, feet)) in [
            ("sphere.urdf", &[][..]),
            ("box.urdf", &[][..]),
            ("quadruped.urdf", &FEET[..]),
        ]
        .into_iter()
        .enumerate()
        {
            for ground in &grounds {
                let simulator = Simulator::new(asset(robot)).with_integrator(integrator);
                let (ground, seed) = (ground.clone(), 20 + seed as u64);
                all.push(touching_ground(simulator, ground, law, feet, seed));
            }
        }
    }
    all
}

/// Robots with forces that a solver finds: of contact, and of stops beside it.
pub(crate) fn solved_contact() -> Vec<Case> {
    let rigid = Rigid {
        restitution: 0.3,
        ..Rigid::default()
    };
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let euler = [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];
    let mut all = Vec::new();
    for (law, integrator) in [ContactLaw::Rigid(rigid), relaxed, soft()]
        .into_iter()
        .flat_map(|law| euler.map(|by| (law, by)))
    {
        let robots = [
            (Simulator::new(asset("sphere.urdf")), &[][..]),
            (Simulator::new(asset("quadruped.urdf")), &FEET[..]),
            (with_stiff_joints(asset("quadruped.urdf")), &FEET[..]),
            (
                with_forces(with_stiff_joints(asset("quadruped.urdf"))),
                &FEET[..],
            ),
            (with_dry_friction(asset("quadruped.urdf")), &FEET[..]),
        ];
        for (seed, (simulator, feet)) in robots.into_iter().enumerate() {
            let simulator = simulator.with_integrator(integrator).with_time_step(5e-3);
            all.push(touching(simulator, law, feet, seed as u64));
        }
    }
    all
}

/// λᵀ x⁺ as a function of all parameters.
struct Weighted<'a>(&'a Case);

impl VectorFunction for Weighted<'_> {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let Case {
            simulator,
            state,
            u,
            adjoint,
            ..
        } = self.0;
        let variant = simulator.with_parameters(x);
        let next = variant.step(&state.cast::<T>(), u.map(T::constant).as_slice());
        let here = simulator.step(state, u.as_slice()).cast::<T>();
        let change = next.deviation(simulator.model(), &here);
        let products = change.iter().zip(adjoint);
        y[0] = products.fold(T::zero(), |sum, (&x, &weight)| sum + x * weight);
    }
}

#[test]
fn step_vjp_equals_the_transposed_jacobians_of_every_robot_and_term() {
    let mut pushing = 0;
    for case in Case::all() {
        let jacobians = case.simulator.linearize(&case.state, case.u.as_slice());
        let found = case.vjp();
        let expected = jacobians.a.tr_mul(&case.adjoint);
        assert_close_vector(&found.state, &expected, OTHER_ALGORITHM, &case.name);
        let expected = jacobians.b.tr_mul(&case.adjoint);
        assert_close_vector(&found.input, &expected, OTHER_ALGORITHM, &case.name);
        pushing += usize::from(case.name.contains("stiff") && case.state.q.amax() > 0.3);
    }
    assert!(pushing > 20, "{pushing} robots beyond the stops");
}

#[test]
fn step_vjp_in_parameters_equals_forward_mode_of_every_robot_and_term() {
    for case in Case::all() {
        let parameters = case.simulator.parameters();
        let expected = gradient(&Weighted(&case), parameters.as_slice());
        let found = case.vjp();
        assert_close_vector(&found.parameters, &expected, OTHER_ALGORITHM, &case.name);
    }
}

#[test]
fn step_vjp_through_solved_contact_equals_the_transposed_jacobians_and_forward_mode() {
    let mut pressed = 0;
    for case in solved_contact() {
        let (simulator, state, u) = (&case.simulator, &case.state, case.u.as_slice());
        let jacobians = simulator.linearize(state, u);
        let found = case.vjp();
        let expected = jacobians.a.tr_mul(&case.adjoint);
        assert_close_vector(&found.state, &expected, OTHER_ALGORITHM, &case.name);
        let expected = jacobians.b.tr_mul(&case.adjoint);
        assert_close_vector(&found.input, &expected, OTHER_ALGORITHM, &case.name);
        let parameters = simulator.parameters();
        let expected = gradient(&Weighted(&case), parameters.as_slice());
        assert_close_vector(&found.parameters, &expected, OTHER_ALGORITHM, &case.name);
        let forces = simulator.contact_report(state, u).forces;
        pressed += forces.iter().filter(|f| f.norm() > 0.0).count();
    }
    assert!(pressed > 30, "{pressed} points that touch");
}

#[test]
fn step_vjp_over_uneven_ground_equals_forward_mode_and_central_differences() {
    let mut moved = 0;
    for case in uneven_ground() {
        let parameters = case.simulator.parameters();
        let expected = gradient(&Weighted(&case), parameters.as_slice());
        let found = case.vjp().parameters;
        assert_close_vector(&found, &expected, OTHER_ALGORITHM, &case.name);
        assert_central_differences(&case, &found, |name| name.starts_with("terrain"));
        let ground = |name: &str| name.starts_with("terrain");
        moved += usize::from(select(&case.simulator, &found, ground).amax() > 1e-4);
    }
    assert!(moved > 20, "{moved} robots that feel the ground");
}

/// Compares the slope of λᵀ x⁺ along a change of all chosen parameters, each by its size, with central differences.
fn assert_central_differences(case: &Case, slopes: &DVector<f64>, chosen: impl Fn(&str) -> bool) {
    const BY: f64 = 1e-6;
    let Case {
        simulator,
        state,
        u,
        adjoint,
        name,
    } = case;
    let (p, layout) = (simulator.parameters(), simulator.parameter_layout());
    let along = DVector::from_fn(p.len(), |k, _| {
        let name = &layout.names()[k];
        let size = match name.contains("shift") || name.contains("turn") {
            true => 0.1,
            false => p[k],
        };
        let is_free = size.is_finite() && chosen(name);
        if is_free {
            size * (k as f64 + 1.0).sin()
        } else {
            0.0
        }
    });
    let here = simulator.step(state, u.as_slice());
    let [after, before] = [BY, -BY].map(|by| {
        let mut moved = p.clone();
        for (x, along) in moved
            .iter_mut()
            .zip(&along)
            .filter(|(_, along)| **along != 0.0)
        {
            *x += by * along;
        }
        let next = simulator
            .with_parameters(moved.as_slice())
            .step(state, u.as_slice());
        next.deviation(simulator.model(), &here).dot(adjoint)
    });
    let (found, expected) = (slopes.dot(&along), (after - before) / (2.0 * BY));
    let error = (found - expected).abs() / (1.0 + expected.abs());
    assert!(error < 1e-6, "{name}: {found}, not {expected}: {error:e}");
}

#[test]
fn step_vjp_in_parameters_equals_central_differences_of_every_law() {
    let mut moved = 0;
    for case in solved_contact().into_iter().chain(soft_contact()) {
        let slopes = case.vjp().parameters;
        assert_central_differences(&case, &slopes, |_| true);
        let mut of_model = StepGradient::zeros(&case.simulator);
        of_model = of_model.with_model_parameters_only(&case.simulator);
        let mut scratch = VjpScratch::new(&case.simulator);
        let (u, adjoint) = (case.u.as_slice(), case.adjoint.as_slice());
        (case.simulator).vjp_into(&case.state, u, adjoint, &mut scratch, &mut of_model);
        let n = of_model.parameters.len();
        assert_eq!(of_model.parameters, slopes.rows(0, n), "{}", case.name);
        let of_parts = |name: &str| name.starts_with("contact ") || name.starts_with("terrain");
        moved += usize::from(select(&case.simulator, &slopes, of_parts).amax() > 1e-6);
    }
    assert!(moved > 5, "{moved} robots whose contact has slopes");
}

#[test]
fn parameters_of_a_simulator_begin_with_the_models_and_have_names_of_their_own() {
    for case in solved_contact().into_iter().take(3).chain(Case::all()) {
        let Case {
            simulator, name, ..
        } = &case;
        let (p, layout) = (simulator.parameters(), simulator.parameter_layout());
        let of_model = simulator.model().parameter_layout();
        let n = of_model.names().len();
        assert_eq!(
            (p.len(), &layout.names()[..n]),
            (layout.names().len(), of_model.names()),
            "{name}"
        );
        assert_eq!(p.rows(0, n), simulator.model().parameters(), "{name}");
        let ranges: Vec<usize> = layout
            .groups()
            .iter()
            .flat_map(|(_, r)| r.clone())
            .collect();
        assert!(ranges.into_iter().eq(0..p.len()), "{name}");
        let names: std::collections::HashSet<_> = layout.names().iter().collect();
        assert_eq!(names.len(), p.len(), "{name}");
        assert_eq!(
            simulator.with_parameters(p.as_slice()).parameters(),
            p,
            "{name}"
        );
    }
}

#[test]
#[should_panic(expected = "the force of Coulomb friction is -1: negative or not finite")]
fn parameters_that_make_no_sense_are_refused_by_their_name() {
    let simulator = with_stiff_joints(samples::arm());
    let mut p = simulator.parameters();
    let layout = simulator.parameter_layout();
    let k = layout
        .names()
        .iter()
        .position(|name| name.ends_with("Coulomb friction"));
    p[k.expect("a joint with friction")] = -1.0;
    let _ = simulator.with_parameters(p.as_slice());
}

/// λᵀ x⁺ as a function of the friction of all points.
struct OfFriction<'a>(&'a Case);

/// The coefficient of friction of a law.
fn friction_of<T>(law: &mut ContactLaw<T>) -> &mut T {
    match law {
        ContactLaw::Soft(law) => &mut law.friction,
        ContactLaw::RelaxedRigid(law) => &mut law.friction,
        ContactLaw::Rigid(law) => &mut law.friction,
        _ => panic!("a law that the test does not know"),
    }
}

impl VectorFunction for OfFriction<'_> {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let Case {
            simulator,
            state,
            u,
            adjoint,
            ..
        } = self.0;
        let contacts = simulator.contacts().expect("contacts");
        let laws: Vec<ContactLaw<T>> = (contacts.laws().iter().zip(x))
            .map(|(law, &x)| {
                let mut law = law.cast::<T>();
                *friction_of(&mut law) = x;
                law
            })
            .collect();
        let variant = simulator
            .cast::<T>()
            .with_contacts(contacts.with_laws(&laws));
        let next = variant.step(&state.cast::<T>(), u.map(T::constant).as_slice());
        let here = simulator.step(state, u.as_slice()).cast::<T>();
        let change = next.deviation(simulator.model(), &here);
        let products = change.iter().zip(adjoint);
        y[0] = products.fold(T::zero(), |sum, (&x, &weight)| sum + x * weight);
    }
}

/// The entries of a vector over all parameters whose names are chosen.
fn select(simulator: &Simulator, x: &DVector<f64>, chosen: impl Fn(&str) -> bool) -> DVector<f64> {
    let layout = simulator.parameter_layout();
    let named = layout.names().iter().zip(x);
    let own = named.filter(|(name, _)| chosen(name)).map(|(_, &x)| x);
    DVector::from_vec(own.collect())
}

#[test]
fn step_vjp_in_friction_equals_forward_mode_of_every_law() {
    let mut slipping = 0;
    for case in solved_contact().into_iter().chain(soft_contact()) {
        let contacts = case.simulator.contacts().expect("contacts");
        let laws = contacts.laws().iter();
        let friction: Vec<f64> = laws.map(|&law| *friction_of(&mut law.clone())).collect();
        let expected = gradient(&OfFriction(&case), &friction);
        let found = select(&case.simulator, &case.vjp().parameters, |name| {
            name.starts_with("contact ") && name.ends_with(": friction")
        });
        assert_close_vector(&found, &expected, OTHER_ALGORITHM, &case.name);
        slipping += expected.iter().filter(|x| x.abs() > 1e-6).count();
    }
    assert!(slipping > 10, "{slipping} points that slip");
}

// Steps of v⁺ = v − μ g Δt until the block would turn back: N of them, d = Δt Σ (v₀ − k μ g Δt), close to v₀² / (2 μ g).
#[test]
fn gradient_of_the_stopping_distance_of_a_block_equals_the_closed_form() {
    const STEPS: usize = 300;
    let (start, friction, g, dt) = (1.0, 0.5, 9.81, 1e-3);
    let model = asset("box.urdf");
    let law = ContactLaw::Rigid(Rigid {
        friction,
        ..Rigid::default()
    });
    let all = Contacts::new(&model, Terrain::flat(0.0), law);
    let center = ContactPoint {
        center: Vector3::zeros(),
        feature: Feature::Corner,
        ..all.points()[0]
    };
    let contacts = all.with_selection(|_| false).with_point(center, law);
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(dt);
    let mut state = simulator.neutral_state();
    (state.q[2], state.v[0]) = (0.0, start);
    let inputs = vec![DVector::zeros(simulator.nu()); STEPS];
    let found = simulator.rollout_gradient(&state, &inputs, &Coordinate(0));
    let n = (start / (friction * g * dt)).floor();
    let distance = dt * (n * start - friction * g * dt * n * (n + 1.0) / 2.0);
    let by_friction = -g * dt * dt * n * (n + 1.0) / 2.0;
    assert!((found.cost - distance).abs() < 1e-9, "{}", found.cost);
    assert!((found.start[6] - n * dt).abs() < 1e-9);
    let slope = simulator.parameter_layout();
    let slope = slope.find("contact 0 of box: friction").expect("friction");
    let slope = found.parameters[slope];
    assert!((slope - by_friction).abs() < 1e-8);
    let continuous = -start * start / (2.0 * friction * friction * g);
    assert!((slope / continuous - 1.0).abs() < 0.01);
    let gravity = simulator.model().parameter_layout();
    let gravity = gravity.find("world: gravity z").expect("gravity");
    let by_gravity = found.parameters[gravity];
    assert!((by_gravity - -by_friction * friction / g).abs() < 1e-8);
}

#[test]
fn batches_of_steps_have_the_gradients_of_each() {
    let models: Vec<Model> = (0..5)
        .map(|k| samples::arm().with_damping(2, 0.1 * f64::from(k)))
        .collect();
    let simulator = Simulator::new(models[0].clone());
    let batch = BatchSimulator::of_variants(&simulator, models.clone()).expect("variants");
    let case = Case::new(simulator, 1.0, "batch", 2);
    let states = vec![case.state.clone(); 5];
    let repeat = |x: &DVector<f64>| [x.as_slice(); 5].concat();
    let all = batch.vjp(&states, &repeat(&case.u), &repeat(&case.adjoint));
    for (model, found) in models.into_iter().zip(all) {
        let own = Simulator::new(model);
        let (u, adjoint) = (case.u.as_slice(), case.adjoint.as_slice());
        assert_eq!(found, own.vjp(&case.state, u, adjoint));
    }
}

#[test]
fn scratch_serves_the_robot_with_other_dampers_too() {
    let case = Case::new(Simulator::new(samples::arm()), 1.0, "damped", 2);
    let mut scratch = VjpScratch::new(&case.simulator);
    let model = case.simulator.model().clone().with_damping(1, 0.7);
    let (other, mut out) = (Simulator::new(model), StepGradient::zeros(&case.simulator));
    let (u, adjoint) = (case.u.as_slice(), case.adjoint.as_slice());
    other.vjp_into(&case.state, u, adjoint, &mut scratch, &mut out);
    let mut expected = StepGradient::zeros(&other);
    let mut own = VjpScratch::new(&other);
    other.vjp_into(&case.state, u, adjoint, &mut own, &mut expected);
    assert_eq!(out, expected);
}

/// Robots with kinematic constraints.
pub(crate) fn closed_loops() -> Vec<Case> {
    let mut all = Vec::new();
    for (model, loops) in [tree_with_loops(), gripper_with_loops(), tree_with_cams()] {
        for tied in loops {
            for integrator in INTEGRATORS {
                let plain = Simulator::new(model.clone());
                for (simulator, what, speed) in [
                    (plain.clone(), "plain", 1.0),
                    (with_stiff_joints(model.clone()), "stiff", 1.0),
                    (with_forces(plain), "whirling", 20.0),
                ] {
                    let simulator = simulator
                        .with_constraints(tied.clone())
                        .with_integrator(integrator)
                        .with_time_step(0.002);
                    let what = format!("{what}, {tied:?}");
                    all.push(Case::new(simulator, speed, &what, 4));
                }
            }
        }
    }
    all
}

/// A tree of joints of all kinds, with constraints of each kind between links and to the world.
fn tree_with_loops() -> (Model, Vec<Vec<Constraint>>) {
    let model = samples::random_tree(8, 2);
    let on = |name: &str| Anchor::frame(&model, name).expect("a link");
    let q = random_point(&model, 4).q;
    let welded = on("link3").brought_to(&on("link6"), &model, q.as_slice());
    let end = on("link6").moved([0.1, -0.2, 0.3]);
    let nail = Anchor::world().moved([0.3, 0.2, -0.4]);
    let rod = Constraint::distance([on("link3").moved([0.2, 0.1, 0.0]), end], 0.4);
    let other = rod.clone();
    let ball = Constraint::ball([nail, end]).with_time_constant(0.05);
    let weld = Constraint::weld([welded, on("link6")]);
    (
        model.clone(),
        vec![
            vec![rod.clone()],
            vec![weld.clone()],
            vec![ball.clone(), rod.clone()],
            vec![weld.with_spring(300.0, 20.0), rod.with_largest_force(9.0)],
            vec![
                ball.with_spring(50.0, 3.0).with_largest_force(4.0),
                other.with_spring(400.0, 2.0).with_largest_force(300.0),
            ],
        ],
    )
}

/// A tree of joints of all kinds, two of which a polynomial ties.
fn tree_with_cams() -> (Model, Vec<Vec<Constraint>>) {
    let model = samples::random_tree(9, 2);
    let names = model.joint_names();
    let single = names.iter().filter(|name| {
        let joint = model.joint(name).expect("a joint of the tree");
        model.joint_q(joint).len() == 1
    });
    let single: Vec<&str> = single.copied().collect();
    let tied = [single[0], single[single.len() - 1]];
    let polynomial = [0.1, 0.8, -0.5, 0.3, 0.2];
    let cam = Constraint::polynomial_coupler(&model, tied, polynomial).expect("two joints");
    let square = [0.0, 0.0, 1.5, 0.0, 0.0];
    let square = Constraint::polynomial_coupler(&model, tied, square).expect("two joints");
    let on = |name: &str| Anchor::frame(&model, name).expect("a link");
    let rod = Constraint::distance([on("link6").moved([0.1, 0.0, 0.2]), Anchor::world()], 0.7);
    (
        model.clone(),
        vec![
            vec![square],
            vec![rod, cam.clone()],
            vec![cam.clone().with_spring(30.0, 1.0)],
            vec![cam.clone().with_spring(30.0, 1.0).with_largest_force(0.3)],
            vec![cam.clone().with_largest_force(0.3)],
            vec![cam.with_regularisation(Regularisation::default())],
        ],
    )
}

/// A robot with mimic joints, which constraints hold too.
fn gripper_with_loops() -> (Model, Vec<Vec<Constraint>>) {
    let model = gripper().build().expect("a robot with followers");
    let tip = Anchor::frame(&model, "tip").expect("a link");
    let rod = Constraint::distance([tip.moved([0.1, 0.0, 0.2]), Anchor::world()], 0.7);
    let couple = |joints| Constraint::coupler(&model, joints, 0.8, 0.1).expect("two joints");
    let coupler = couple(["tip_joint", "elbow_joint"]);
    let joints = [
        ("tip_joint", 0.8),
        ("left_joint", -0.5),
        ("elbow_joint", 0.3),
    ];
    let tendon = Constraint::tendon(&model, &joints, 0.1).expect("joints");
    (
        model.clone(),
        vec![
            vec![coupler.clone()],
            vec![rod.clone(), coupler.clone()],
            vec![tendon.clone(), rod.with_spring(90.0, 2.0)],
            vec![coupler.with_spring(30.0, 1.0).with_largest_force(0.3)],
            vec![tendon.clone().with_spring(30.0, 1.0)],
            vec![tendon.with_largest_force(0.3)],
        ],
    )
}

#[test]
fn step_vjp_of_closed_loops_equals_the_transposed_jacobians_and_forward_mode() {
    for case in closed_loops() {
        let (state, u) = (&case.state, case.u.as_slice());
        let jacobians = case.simulator.linearize(state, u);
        let mut found = StepGradient::zeros(&case.simulator).without_parameters();
        let mut scratch = VjpScratch::new(&case.simulator);
        let adjoint = case.adjoint.as_slice();
        (case.simulator).vjp_into(state, u, adjoint, &mut scratch, &mut found);
        let whole = case.vjp();
        assert_eq!((&whole.state, &whole.input), (&found.state, &found.input));
        let expected = jacobians.a.tr_mul(&case.adjoint);
        assert_close_vector(&found.state, &expected, OTHER_ALGORITHM, &case.name);
        let expected = jacobians.b.tr_mul(&case.adjoint);
        assert_close_vector(&found.input, &expected, OTHER_ALGORITHM, &case.name);
        let parameters = case.simulator.parameters();
        let expected = gradient(&Weighted(&case), parameters.as_slice());
        assert_close_vector(&whole.parameters, &expected, OTHER_ALGORITHM, &case.name);
        if case.name.contains("plain") {
            assert_central_differences(&case, &whole.parameters, |_| true);
        }
    }
}

/// A cost of all entries of a trajectory.
struct Everything;

impl RolloutCost for Everything {
    fn stage<T: Scalar>(&self, step: usize, state: &State<T>, u: &[T]) -> T {
        let weight = 1.0 + (step as f64).sin();
        let numbers = state.numbers().chain(u);
        numbers.fold(T::zero(), |sum, &x| sum + x * x * weight)
    }

    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        let numbers = last.numbers().enumerate();
        numbers.fold(T::zero(), |sum, (k, &x)| {
            sum + x.sin_cos().0 * (1.0 + k as f64)
        })
    }
}

/// The same cost with derivatives of its own.
struct ByHand;

impl RolloutCost for ByHand {
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        Everything.end(last)
    }

    fn stage_slopes(
        &self,
        at: &StagePoint<'_>,
        _: &mut CostScratch,
        out: &mut CostSlopes<'_>,
    ) -> f64 {
        let weight = 1.0 + (at.step as f64).sin();
        let slopes = out.state.iter_mut().chain(out.input.iter_mut());
        let numbers = at.state.numbers().chain(at.u);
        let mut value = 0.0;
        for (slope, x) in slopes.zip(numbers) {
            *slope += 2.0 * weight * x;
            value += weight * x * x;
        }
        value
    }
}

/// A rollout: robot, start, inputs.
fn rollout(model: Model, integrator: Integrator, steps: usize) -> (Case, Vec<DVector<f64>>) {
    let simulator = Simulator::new(model).with_time_step(0.01);
    let case = Case::new(simulator.with_integrator(integrator), 1.0, "rollout", 11);
    let mut rng = generator(12);
    let input = |_| DVector::from_fn(case.simulator.nu(), |_, _| rng.random_range(-1.0..1.0));
    let inputs = (0..steps).map(input).collect();
    (case, inputs)
}

/// The cost of a rollout as a function of start (tangent), inputs and parameters.
struct Total<'a>(&'a Case, &'a [DVector<f64>]);

impl VectorFunction for Total<'_> {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let Self(
            Case {
                simulator, state, ..
            },
            inputs,
        ) = self;
        let (model, nv, nu) = (simulator.model(), simulator.model().nv(), simulator.nu());
        let (start, rest) = x.split_at(2 * nv);
        let (u, parameters) = rest.split_at(nu * inputs.len());
        let variant = simulator.with_parameters(parameters);
        let q = model.integrate(state.q.map(T::constant).as_slice(), &start[..nv]);
        let v: Vec<T> = (0..nv).map(|k| start[nv + k] + state.v[k]).collect();
        let mut step = 0;
        let trajectory = variant.rollout_over(
            &State::new(q.as_slice(), &v),
            inputs.len(),
            |_, _, input| {
                for (k, input) in input.iter_mut().enumerate() {
                    *input = u[nu * step + k] + inputs[step][k];
                }
                step += 1;
            },
        );
        y[0] = Everything.end(trajectory.last());
        for (k, (state, u)) in trajectory.states.iter().zip(&trajectory.inputs).enumerate() {
            y[0] += Everything.stage(k, state, u.as_slice());
        }
    }
}

#[test]
fn rollout_gradient_equals_forward_mode_and_finite_differences() {
    let follower = gripper().build().expect("a robot with a follower");
    let robots = [samples::arm(), samples::random_tree(6, 4), follower];
    for (model, integrator) in robots
        .into_iter()
        .flat_map(|model| INTEGRATORS.map(|by| (model.clone(), by)))
    {
        let (case, inputs) = rollout(model, integrator, 12);
        let found = case
            .simulator
            .rollout_gradient(&case.state, &inputs, &Everything);
        assert_eq!(found.status, RolloutStatus::Completed);
        let parameters = case.simulator.parameters();
        let zeros = 2 * case.simulator.model().nv() + inputs.len() * case.simulator.nu();
        let x: Vec<f64> = std::iter::repeat_n(0.0, zeros)
            .chain(parameters.iter().copied())
            .collect();
        let expected = gradient(&Total(&case, &inputs), &x);
        let inputs_slopes = found.inputs.iter().flatten();
        let all = found.start.iter().chain(inputs_slopes);
        let all: Vec<f64> = all.chain(&found.parameters).copied().collect();
        let all = DVector::from_vec(all);
        assert_close_vector(&all, &expected, 1e-10, &case.name);
        // The cost itself, and the slope along all directions at once by differences.
        let mut y = [0.0];
        Total(&case, &inputs).eval(&x, &mut y);
        assert!((found.cost - y[0]).abs() < SAME_ALGEBRA * y[0].abs());
        let mut rng = generator(3);
        let along = DVector::from_fn(x.len(), |k, _| {
            let size = if k < zeros { 1.0 } else { x[k].abs() };
            size * rng.random_range(-1.0..1.0)
        });
        let at = |h: f64| {
            let moved: Vec<f64> = x.iter().zip(&along).map(|(x, d)| x + h * d).collect();
            let mut y = [0.0];
            Total(&case, &inputs).eval(&moved, &mut y);
            y[0]
        };
        let h = 1e-4;
        let central = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
        let slope = all.dot(&along);
        let error = (slope - central).abs() / slope.abs().max(1.0);
        assert!(error < 1e-6, "{}: {slope} {central}", case.name);
    }
}

/// A ball that rolls over a grid, a closed loop, and an arm.
fn rollouts_of_all_sorts() -> Vec<(Case, Vec<DVector<f64>>)> {
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let ball = Simulator::new(asset("sphere.urdf")).with_time_step(0.002);
    let ball = touching_ground(ball, Terrain::HeightField(grid()), relaxed, &[], 3);
    let model = samples::random_tree(6, 2);
    let on = |name: &str| Anchor::frame(&model, name).expect("a link");
    let ends = [on("link2"), on("link5")];
    let q = random_point(&model, 4).q;
    let [from, to] = ends.map(|end| end.pose_in_world(&model, q.as_slice()).translation);
    let tied = Constraint::distance(ends, (to - from).norm());
    let closed = Simulator::new(model).with_constraints(vec![tied]);
    let mut closed = Case::new(closed.with_time_step(0.002), 0.2, "closed loop", 4);
    let assembled = closed.simulator.assemble(&closed.state);
    closed.state = assembled.expect("a loop that closes").state;
    let (arm, _) = rollout(samples::arm(), Integrator::RungeKutta4, 1);
    let mut rng = generator(8);
    let mut with_inputs = |case: Case| {
        let nu = case.simulator.nu();
        let input = |_| DVector::from_fn(nu, |_, _| rng.random_range(-1.0..1.0));
        let inputs = (0..10).map(input).collect();
        (case, inputs)
    };
    vec![with_inputs(ball), with_inputs(closed), with_inputs(arm)]
}

/// The cost of a rollout under all changes of start, of the input of step 3, and of every eleventh parameter.
struct Changed<'a>(&'a Case, &'a [DVector<f64>]);

impl Changed<'_> {
    const STEP: usize = 3;
    const APART: usize = 11;

    /// Entries of the gradient, of which the changes are.
    fn of(&self, gradient: &RolloutGradient) -> DVector<f64> {
        let parameters = gradient.parameters.iter().step_by(Self::APART);
        let state = gradient.start.iter().chain(&gradient.inputs[Self::STEP]);
        DVector::from_vec(state.chain(parameters).copied().collect())
    }
}

impl VectorFunction for Changed<'_> {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let Self(case, inputs) = self;
        let simulator = &case.simulator;
        let (dx, rest) = x.split_at(simulator.n_tangent());
        let (du, dp) = rest.split_at(simulator.nu());
        let mut parameters = simulator.parameters().map(T::from);
        let changed = parameters.iter_mut().step_by(Self::APART);
        changed.zip(dp).for_each(|(p, &dp)| *p += dp);
        let variant: Simulator<T> = simulator.with_parameters(parameters.as_slice());
        let start = case.state.cast::<T>().integrate(variant.model(), dx);
        let (mut k, mut total) = (0, T::zero());
        let trajectory = variant.rollout_over(&start, inputs.len(), |_, state, u| {
            for (u, &given) in u.iter_mut().zip(&inputs[k]) {
                *u = T::from(given);
            }
            if k == Self::STEP {
                u.iter_mut().zip(du).for_each(|(u, &du)| *u += du);
            }
            total += Everything.stage(k, state, u);
            k += 1;
        });
        y[0] = total + Everything.end(trajectory.last());
    }
}

#[test]
fn gradient_of_rollouts_equals_forward_mode() {
    for (case, inputs) in rollouts_of_all_sorts() {
        let (simulator, start) = (&case.simulator, &case.state);
        let all = simulator.rollout_gradient(start, &inputs, &Everything);
        assert_eq!(all.status, RolloutStatus::Completed, "{}", case.name);
        let changed = Changed(&case, &inputs);
        let found = changed.of(&all);
        let forward = jacobian(&changed, &vec![0.0; found.len()]);
        let expected = DVector::from_iterator(found.len(), forward.iter().copied());
        assert_close_vector(&found, &expected, 1e-10, &case.name);
    }
}

#[test]
fn rollout_gradient_in_the_heights_of_a_grid_equals_central_differences() {
    const BY: f64 = 1e-6;
    let (case, inputs) = rollouts_of_all_sorts().swap_remove(0);
    let (simulator, start) = (&case.simulator, &case.state);
    let found = simulator.rollout_gradient(start, &inputs, &Everything);
    let (p, layout) = (simulator.parameters(), simulator.parameter_layout());
    let terrain = layout.names().iter().enumerate();
    let terrain = terrain.filter(|(_, name)| name.starts_with("terrain: height"));
    let heights: Vec<usize> = terrain.map(|(k, _)| k).collect();
    assert_eq!(heights.len(), grid().heights().len());
    let cost = |p: &DVector<f64>| {
        let other = simulator.with_parameters(p.as_slice());
        other.rollout_gradient(start, &inputs, &Everything).cost
    };
    let mut steepest = 0.0_f64;
    for k in heights {
        let [after, before] = [BY, -BY].map(|by| {
            let mut moved = p.clone();
            moved[k] += by;
            cost(&moved)
        });
        let expected = (after - before) / (2.0 * BY);
        let error = (found.parameters[k] - expected).abs() / (1.0 + expected.abs());
        assert!(error < 1e-6, "{}: {error:e}", layout.names()[k]);
        steepest = steepest.max(expected.abs());
    }
    assert!(steepest > 1e-3, "{steepest}");
}

fn with_options(
    simulator: &Simulator,
    start: &State,
    inputs: &[DVector<f64>],
    options: &RolloutGradientOptions,
) -> RolloutGradient {
    let start = std::slice::from_ref(start);
    simulator
        .rollout_gradients(start, &[inputs], &Everything, options)
        .swap_remove(0)
}

#[test]
fn checkpoints_batches_and_own_slopes_change_nothing() {
    let (case, inputs) = rollout(samples::arm(), Integrator::SemiImplicitEuler, 23);
    let simulator = &case.simulator;
    let plain = simulator.rollout_gradient(&case.state, &inputs, &Everything);
    let every = (1..30).map(Checkpoints::Every);
    for checkpoints in every.chain([Checkpoints::SquareRoot]) {
        let options = RolloutGradientOptions {
            checkpoints,
            ..Default::default()
        };
        let other = with_options(simulator, &case.state, &inputs, &options);
        assert_eq!(plain, other, "{checkpoints:?}");
    }
    let (starts, all) = (vec![case.state.clone(); 5], vec![inputs.clone(); 5]);
    let options = RolloutGradientOptions::default();
    for one in simulator.rollout_gradients(&starts, &all, &Everything, &options) {
        assert_eq!(plain, one);
    }
    let own = simulator.rollout_gradient(&case.state, &inputs, &ByHand);
    assert_close_vector(&own.start, &plain.start, SAME_ALGEBRA, "start");
    assert_close_vector(&own.inputs[7], &plain.inputs[7], SAME_ALGEBRA, "inputs");
    let options = RolloutGradientOptions {
        parameters: WantedParameters::None,
        ..Default::default()
    };
    let less = with_options(simulator, &case.state, &inputs, &options);
    assert_eq!((&plain.start, &plain.inputs), (&less.start, &less.inputs));
    assert!(less.parameters.is_empty());
    let options = RolloutGradientOptions {
        parameters: WantedParameters::Model,
        ..Default::default()
    };
    let of_model = with_options(simulator, &case.state, &inputs, &options);
    let n = simulator.model().parameters().len();
    assert_eq!(of_model.parameters, plain.parameters.rows(0, n));
}

#[test]
fn rollouts_that_end_early_say_so_and_have_no_slopes() {
    let (case, mut inputs) = rollout(samples::cartpole(), Integrator::SemiImplicitEuler, 9);
    inputs[4][0] = f64::NAN;
    let found = case
        .simulator
        .rollout_gradient(&case.state, &inputs, &Everything);
    assert_eq!(found.status, RolloutStatus::NonFiniteInput { step: 4 });
    assert_eq!((found.cost, found.start.amax()), (f64::INFINITY, 0.0));
    inputs[4][0] = 1e12;
    let found = case
        .simulator
        .rollout_gradient(&case.state, &inputs, &Everything);
    assert_eq!(found.status, RolloutStatus::Diverged { step: 4 });
    let none = case
        .simulator
        .rollout_gradient(&case.state, &[], &Everything);
    assert_eq!(none.cost, Everything.end(&case.state));
}

/// A coordinate at the end.
struct Coordinate(usize);

impl RolloutCost for Coordinate {
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        last.q[self.0]
    }
}

// T = 2π √(2 l / 3 g) of a rod of length l at small angles. At the end of a quarter q = 0, so δT / 4 = −δq / q̇ there.
#[test]
fn gradient_of_the_period_of_a_pendulum_in_its_length_equals_the_closed_form() {
    const STEPS: usize = 200;
    let period = std::f64::consts::TAU * (2.0 / (3.0 * 9.81_f64)).sqrt();
    let simulator = Simulator::new(samples::pendulum())
        .with_integrator(Integrator::RungeKutta4)
        .with_time_step(0.25 * period / STEPS as f64);
    let inputs = vec![DVector::zeros(1); STEPS];
    let found = simulator.rollout_gradient(&State::new(&[1e-4], &[0.0]), &inputs, &Coordinate(0));
    // A rod of mass m has h = −m l / 2 along z and J = m l² / 3 about x, which is z of the body, l = m = 1.
    let model = simulator.model();
    let (p, layout) = (model.parameters(), model.parameter_layout());
    let by_length: f64 = (layout.names().iter().zip(&p).zip(&found.parameters))
        .map(|((name, &value), slope)| {
            let power = match name.as_str() {
                "rod: hx" | "rod: hy" | "rod: hz" => 1.0,
                name if name.starts_with("rod: J") => 2.0,
                _ => 0.0,
            };
            slope * value * power
        })
        .sum();
    let of_period = -4.0 * by_length / found.last.v[0];
    assert!(
        (of_period - 0.5 * period).abs() < 1e-7,
        "{of_period} {}",
        0.5 * period
    );
}

/// Where a thrown body comes down, to first order about a landing with these velocities.
struct Landing {
    slope: f64,
}

impl RolloutCost for Landing {
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        last.q[0] - last.q[2] * self.slope
    }
}

// R = 2 vₓ v_z / g
#[test]
fn gradient_of_the_range_of_a_throw_in_its_velocity_equals_the_closed_form() {
    const STEPS: usize = 50;
    let (vx, vz, g) = (3.0, 4.0, 9.81);
    let mut builder = ModelBuilder::new("ball");
    builder.add_link(LinkSpec::new("ball").with_mass(0.4, [0.0; 3], [1e-3; 3]));
    let flight = 2.0 * vz / g;
    let simulator = Simulator::new(builder.build().unwrap())
        .with_integrator(Integrator::RungeKutta4)
        .with_time_step(flight / STEPS as f64);
    let mut start = simulator.neutral_state();
    (start.v[0], start.v[2]) = (vx, vz);
    // It lands with (vₓ, −v_z).
    let cost = Landing { slope: -vx / vz };
    let inputs = vec![DVector::zeros(simulator.nu()); STEPS];
    let found = simulator.rollout_gradient(&start, &inputs, &cost);
    assert!((found.cost - 2.0 * vx * vz / g).abs() < 1e-12);
    let by_v = found.start.rows(6, 3);
    let expected = Vector3::new(2.0 * vz / g, 0.0, 2.0 * vx / g);
    assert!((by_v - expected).amax() < 1e-12, "{by_v}");
    let gravity = simulator.model().parameter_layout();
    let gravity = gravity.find("world: gravity z").unwrap();
    let by_g = -found.parameters[gravity];
    assert!((by_g + 2.0 * vx * vz / (g * g)).abs() < 1e-12, "{by_g}");
}

/// Forward over adjoint is not in the way of types: a cost is a function over any scalar.
#[test]
fn cost_over_duals_has_its_slopes() {
    let state = State::new(&[Dual::<f64, 1>::variable(0.3, 0)], &[Dual::from(0.0)]);
    assert!((Everything.end(&state).eps[0] - 0.3_f64.cos()).abs() < 1e-15);
}
