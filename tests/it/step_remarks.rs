//! Remarks on time steps that are too long: for springs, dampers, limits and rotations, against closed forms and against rollouts.

use std::f64::consts::{PI, TAU};

use dualbody::constraint::{Anchor, Constraint};
use dualbody::dynamics::kinetic_energy;
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, ModelBuilder, samples};
use dualbody::sim::{Actuation, ExternalForce, ForceFunction, SimulatorRemark};
use dualbody::spatial::{Force, Motion, Representation, Transform};
use dualbody::{Integrator, Model, Scalar, Simulator, State};
use nalgebra::Vector3;

use crate::common::asset;

use Integrator::{ImplicitMidpoint, ImplicitVelocity, RungeKutta4, SemiImplicitEuler};

const ALL: [Integrator; 4] = [
    SemiImplicitEuler,
    ImplicitVelocity,
    RungeKutta4,
    ImplicitMidpoint,
];
const MASS: f64 = 2.0;
/// Of a spring on that mass, rad/s.
const OMEGA: f64 = 30.0;
const STIFFNESS: f64 = MASS * OMEGA * OMEGA;
/// N·s/m: a time constant of 5 ms.
const DAMPING: f64 = 400.0;
/// Zero of 1 − |R| of the Runge–Kutta method on the negative axis, x³ − 4 x² + 12 x = 24.
const REAL_BOUND: f64 = 2.785_293_563_405_282;

/// The spring that pulls the mass back.
#[derive(Clone, Copy, Debug)]
enum By {
    Joint,
    Constraint,
    Force,
}

/// A mass on a rail.
fn rail(stiffness: f64, damping: f64) -> Model {
    let mut builder = ModelBuilder::new("rail");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("mass").with_mass(MASS, [0.0; 3], [0.01; 3]));
    let joint = JointSpec::new("rail", JointKind::Prismatic, "world", "mass");
    let joint = joint.with_axis([1.0, 0.0, 0.0]).with_damping(damping);
    builder.add_joint(joint.with_spring(stiffness, 0.0));
    builder.build().expect("a robot that is known to be right")
}

struct Spring;

impl ForceFunction for Spring {
    fn force<T: Scalar>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        parameters: &[T],
    ) -> Force<T> {
        let pull = pose.translation * -parameters[0] - velocity.linear * parameters[1];
        Force::new(pull, Vector3::repeat(T::zero()))
    }
}

fn pulled(by: By, stiffness: f64, damping: f64) -> Simulator {
    let free = rail(0.0, 0.0);
    match by {
        By::Joint => Simulator::new(rail(stiffness, damping)),
        By::Constraint => {
            let tendon = Constraint::tendon(&free, &[("rail", 1.0)], 0.0).expect("a joint");
            let spring = tendon.with_spring(stiffness, damping);
            Simulator::new(free).with_constraints(vec![spring])
        }
        By::Force => {
            let place = Anchor::frame(&free, "mass").expect("a frame");
            let numbers = [stiffness, damping];
            let force = ExternalForce::function(place, Spring, &numbers, Representation::Mixed);
            Simulator::new(free).with_external_forces(vec![force])
        }
    }
}

fn remarks(simulator: &Simulator) -> Vec<SimulatorRemark> {
    simulator.remarks(simulator.model().neutral().as_slice())
}

/// The longest step of the remark on a mode that grows, if there is one.
fn longest(simulator: &Simulator) -> Option<f64> {
    remarks(simulator).iter().find_map(|remark| match remark {
        SimulatorRemark::UnstableMode { longest, mode, .. } => {
            assert_eq!(mode.joint, "rail");
            Some(*longest)
        }
        _ => None,
    })
}

/// How much faster the mass is after many steps than at the start.
fn growth(simulator: &Simulator) -> f64 {
    let start = State::new(&[1e-6], &[1e-6 * OMEGA]);
    let rollout = simulator.rollout(&start, 2000, |_, _, u| u.fill(0.0));
    rollout.last().v[0].abs() / start.v[0]
}

/// The bound for each way to be pulled back: of a spring in 1 / ω, of a damper in m / d; `None` where there is none.
fn bounds(by: By, integrator: Integrator) -> Option<[f64; 2]> {
    match (by, integrator) {
        (_, ImplicitMidpoint) => None,
        (_, RungeKutta4) => Some([8.0_f64.sqrt(), REAL_BOUND]),
        (By::Force, _) => Some([2.0, 2.0]),
        _ => None,
    }
}

#[test]
fn longest_steps_for_springs_and_dampers_equal_closed_forms_and_rollouts_grow_beyond_them() {
    for by in [By::Joint, By::Constraint, By::Force] {
        for integrator in ALL {
            if matches!((by, integrator), (By::Constraint, ImplicitMidpoint)) {
                continue; // it takes none
            }
            let cases = [
                (STIFFNESS, 0.0, 1.0 / OMEGA),
                (0.0, DAMPING, MASS / DAMPING),
            ];
            for (k, (stiffness, damping, unit)) in cases.into_iter().enumerate() {
                let what = format!("{by:?} {integrator:?} {stiffness} {damping}");
                let simulator = pulled(by, stiffness, damping).with_integrator(integrator);
                let with = |dt| simulator.clone().with_time_step(dt);
                let Some(bound) = bounds(by, integrator).map(|bounds| bounds[k] * unit) else {
                    assert_eq!(longest(&with(20.0 * unit)), None, "{what}");
                    assert!(growth(&with(20.0 * unit)) < 10.0, "{what}");
                    continue;
                };
                for dt in [1.01 * bound, 7.0 * bound] {
                    let found = longest(&with(dt)).unwrap_or_else(|| panic!("{what}: none"));
                    assert!((found / bound - 1.0).abs() < 2e-3, "{what}: {found}");
                }
                assert_eq!(longest(&with(0.99 * bound)), None, "{what}");
                assert!(growth(&with(0.99 * bound)) < 10.0, "{what}");
                assert!(growth(&with(1.01 * bound)) > 100.0, "{what}");
            }
        }
    }
}

#[test]
fn a_remark_names_an_integrator_with_which_nothing_grows() {
    let stable = |by| match &remarks(
        &pulled(by, STIFFNESS, 0.0)
            .with_time_step(0.2)
            .with_integrator(RungeKutta4),
    )[..]
    {
        [SimulatorRemark::UnstableMode { stable, .. }] => *stable,
        other => panic!("{other:?}"),
    };
    assert_eq!(stable(By::Joint), Some(SemiImplicitEuler));
    assert_eq!(stable(By::Force), None);
    let said = remarks(
        &pulled(By::Joint, STIFFNESS, 0.0)
            .with_time_step(0.2)
            .with_integrator(RungeKutta4),
    );
    // 2√2 / 30 s = 0.0943 s, rounded down.
    let expected = "use steps of at most 9.4e-2 s, or Integrator::SemiImplicitEuler";
    assert!(said[0].to_string().ends_with(expected), "{}", said[0]);
}

#[test]
fn vibrations_with_less_than_ten_steps_a_period_are_remarked_unless_they_die_in_one() {
    let period = TAU / OMEGA;
    for integrator in ALL {
        let said = |damping: f64, dt| {
            let simulator = pulled(By::Joint, STIFFNESS, damping).with_integrator(integrator);
            remarks(&simulator.with_time_step(dt))
        };
        let found = said(0.0, period / 9.9);
        let [SimulatorRemark::UnresolvedMode { mode, .. }] = &found[..] else {
            panic!("{integrator:?}: {found:?}")
        };
        assert!((mode.frequency * period - 1.0).abs() < 1e-6 && mode.joint == "rail");
        assert_eq!(said(0.0, period / 10.1), []);
        // Damping ratio 0.7: 0.2 % of the amplitude is left.
        assert_eq!(said(1.4 * MASS * OMEGA, period / 9.0), []);
    }
}

// Both methods of Euler multiply the amplitude by (1 + x²)^(−½) in a step, x = ω Δt.
#[test]
fn euler_leaves_as_much_of_a_vibration_as_is_documented() {
    let left = |steps: usize, integrator| {
        let dt = TAU / OMEGA / steps as f64;
        let simulator = pulled(By::Joint, STIFFNESS, 0.0).with_integrator(integrator);
        let simulator = simulator.with_time_step(dt);
        let rollout = simulator.rollout(&State::new(&[1.0], &[0.0]), steps, |_, _, u| u.fill(0.0));
        rollout.last().q[0].hypot(rollout.last().v[0] / OMEGA)
    };
    for integrator in [SemiImplicitEuler, ImplicitVelocity] {
        assert!((0.17..0.21).contains(&left(10, integrator)));
        assert!((0.81..0.83).contains(&left(100, integrator)));
    }
    assert!((0.99..1.0).contains(&left(10, RungeKutta4)));
    assert!((left(10, ImplicitMidpoint) - 1.0).abs() < 1e-9);
}

// Of two masses on rails, the one with the stiffer spring.
#[test]
fn the_joint_of_a_remark_is_the_one_that_moves() {
    let mut builder = ModelBuilder::new("rails");
    builder.add_link(LinkSpec::new("world"));
    for (name, stiffness) in [("soft", 1.0), ("stiff", 1e6), ("softer", 0.1)] {
        builder.add_link(LinkSpec::new(name).with_mass(MASS, [0.0; 3], [0.01; 3]));
        let joint = JointSpec::new(format!("{name}_rail"), JointKind::Prismatic, "world", name);
        builder.add_joint(joint.with_spring(stiffness, 0.0));
    }
    let model = builder.build().expect("a robot that is known to be right");
    for integrator in ALL {
        let simulator = Simulator::new(model.clone()).with_time_step(0.01);
        let found = remarks(&simulator.with_integrator(integrator));
        let [
            SimulatorRemark::UnresolvedMode { mode, .. }
            | SimulatorRemark::UnstableMode { mode, .. },
        ] = &found[..]
        else {
            panic!("{integrator:?}: {found:?}")
        };
        assert_eq!(mode.joint, "stiff_rail");
        let frequency = (1e6 / MASS).sqrt() / TAU;
        assert!((mode.frequency / frequency - 1.0).abs() < 1e-3, "{mode}");
    }
}

#[test]
fn what_falls_is_no_mode_that_the_step_makes_grow() {
    for (integrator, dt) in ALL
        .into_iter()
        .flat_map(|by| [1e-3, 0.05].map(|dt| (by, dt)))
    {
        let pendulum = Simulator::new(samples::double_pendulum()).with_time_step(dt);
        let said = pendulum.with_integrator(integrator).remarks(&[PI, 0.0]);
        assert_eq!(said, [], "{integrator:?} {dt}");
    }
}

// Its two frequencies are below 10 rad/s. In a step it falls by centimetres, which is not a small motion.
#[test]
fn a_robot_that_falls_far_in_a_step_has_no_mode_that_grows() {
    let pendulum = Simulator::new(samples::double_pendulum()).with_integrator(RungeKutta4);
    for dt in [0.05, 0.1, 0.2] {
        let said = pendulum.clone().with_time_step(dt).remarks(&[1.2, 0.4]);
        let grows = |x: &SimulatorRemark| matches!(x, SimulatorRemark::UnstableMode { .. });
        assert!(!said.iter().any(grows), "{dt}: {said:?}");
    }
}

// Stops are critically damped with 10 ms, and so are limits of speed for the inertia that the joint feels.
#[test]
fn longest_step_for_limits_equals_that_of_their_time_constant_and_only_runge_kutta_minds() {
    let model = samples::cartpole();
    let simulator = Simulator::new(model.clone()).with_actuation(Actuation::from_model(&model));
    let said = |integrator, dt| {
        let simulator = simulator.clone().with_integrator(integrator);
        remarks(&simulator.with_time_step(dt))
    };
    let bound = 0.01 * REAL_BOUND;
    for integrator in [SemiImplicitEuler, ImplicitVelocity, ImplicitMidpoint] {
        assert_eq!(said(integrator, 2.0 * bound), []);
    }
    assert_eq!(said(RungeKutta4, 0.99 * bound), []);
    let found = said(RungeKutta4, 1.01 * bound);
    let [SimulatorRemark::UnstableLimit { longest, joint, .. }] = &found[..] else {
        panic!("{found:?}")
    };
    assert!(
        (longest / bound - 1.0).abs() < 1e-3 && joint == "linear",
        "{found:?}"
    );
    // A cart beyond the end of its rail comes back, or is thrown out.
    let farthest = |dt| {
        let simulator = simulator
            .clone()
            .with_integrator(RungeKutta4)
            .with_time_step(dt);
        let rollout = simulator.rollout(&State::new(&[2.5, 0.0], &[1.0, 0.0]), 20, |_, _, u| {
            u.fill(0.0);
        });
        rollout
            .states
            .iter()
            .fold(0.0_f64, |far, state| far.max(state.v[0].abs()))
    };
    assert!(farthest(0.5 * bound) < 10.0);
    assert!(farthest(2.0 * bound) > 100.0);
}

fn body(inertia: [f64; 3]) -> Model {
    let mut builder = ModelBuilder::new("body");
    builder.add_link(LinkSpec::new("body").with_mass(1.0, [0.0; 3], inertia));
    let model = builder.build().expect("a robot that is known to be right");
    model.with_gravity(Vector3::zeros())
}

/// Of a body that turns with `omega`, with a step of `dt`.
fn rotation(simulator: &Simulator, omega: [f64; 3]) -> Option<(f64, f64)> {
    let v = [[0.3, -0.2, 0.1], omega].concat();
    let said = simulator.remarks_at(simulator.model().neutral().as_slice(), &v);
    said.iter().find_map(|remark| match remark {
        SimulatorRemark::UnresolvedRotation { rate, longest, .. } => Some((*rate, *longest)),
        _ => None,
    })
}

// A symmetric wheel nutates at (C − A) / A of its speed, in axes of the wheel.
#[test]
fn rate_of_a_rotation_equals_the_nutation_of_a_wheel_and_a_ball_has_none() {
    let wheel = Simulator::new(body([0.01, 0.01, 0.019])).with_time_step(5e-3);
    let (rate, longest) = rotation(&wheel, [0.0, 0.0, 30.0]).expect("a remark");
    assert!((rate - 27.0).abs() < 1e-6, "{rate}");
    assert!((longest - 0.01 / 27.0).abs() < 1e-9, "{longest}");
    let short = wheel.clone().with_time_step(0.99 * longest);
    assert_eq!(rotation(&short, [0.0, 0.0, 30.0]), None);
    let implicit = wheel.with_integrator(ImplicitVelocity);
    assert_eq!(rotation(&implicit, [0.0, 0.0, 30.0]), None);
    let ball = Simulator::new(body([0.01; 3])).with_time_step(0.01);
    assert_eq!(rotation(&ball, [10.0, 20.0, 30.0]), None);
    let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.01);
    assert_eq!(pendulum.remarks_at(&[0.3], &[100.0]), []);
}

// A slim body that turns about no axis of its own: with semi-implicit Euler the worst of those that the limits were found with.
#[test]
fn energy_of_a_slim_body_changes_as_documented_in_a_turn_at_the_longest_step() {
    let (model, spin) = (body([0.01, 0.1, 0.1]), 6.0);
    let omega = [spin * 0.5_f64.sqrt(), spin * 0.5_f64.sqrt(), 0.0];
    let loss = |integrator, dt| {
        let simulator = Simulator::new(model.clone()).with_integrator(integrator);
        let simulator = simulator.with_time_step(dt);
        let start = simulator.state(model.neutral().as_slice(), &[[0.0; 3], omega].concat());
        let steps = (TAU / spin / dt).ceil() as usize;
        let end = simulator.rollout(&start, steps, |_, _, _| {});
        let energy = |s: &State| kinetic_energy(&model, s.q.as_slice(), s.v.as_slice());
        (energy(end.last()) / energy(&start) - 1.0).abs()
    };
    let allowed = [(SemiImplicitEuler, 1e-2..6e-2), (RungeKutta4, 5e-5..2e-3)];
    for (integrator, range) in allowed {
        let coarse = Simulator::new(model.clone()).with_integrator(integrator);
        let coarse = coarse.with_time_step(3.0 / spin);
        let (_, longest) = rotation(&coarse, omega).expect("a remark");
        let loss = loss(integrator, longest);
        assert!(range.contains(&loss), "{integrator:?}: {loss}");
    }
}

#[test]
fn robots_of_examples_give_no_remarks_at_steps_of_a_millisecond() {
    let robots = [
        "acrobot",
        "box",
        "cartpole",
        "double_pendulum",
        "four_bar",
        "hopper",
        "humanoid",
        "panda",
        "quadrotor",
        "quadruped",
        "sphere",
        "ur5",
    ];
    let files = robots.map(|name| asset(&format!("{name}.urdf")));
    let built = [samples::pendulum(), samples::arm()];
    for (model, integrator) in files
        .into_iter()
        .chain(built)
        .flat_map(|model| ALL.map(|by| (model.clone(), by)))
    {
        let simulator = Simulator::new(model.clone()).with_integrator(integrator);
        let actuated = simulator
            .clone()
            .with_actuation(Actuation::from_model(&model));
        for simulator in [simulator, actuated] {
            let slow = vec![0.2; model.nv()];
            let said = simulator.remarks_at(model.neutral().as_slice(), &slow);
            assert_eq!(said, [], "{} {integrator:?}", model.name());
        }
    }
}
