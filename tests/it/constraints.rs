//! Kinematic constraints against closed forms: linkages, rods, welds, couplers; drift, redundancy, assembly,
//! derivatives.

use std::f64::consts::PI;

use dualbody::autodiff::{VectorFunction, finite_difference, jacobian};
use dualbody::constraint::{Anchor, Constraint, ConstraintKind};
use dualbody::contact::{ContactLaw, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::joint::JointKind;
use dualbody::model::{Base, BodyId, JointSpec, LinkSpec, Model, ModelBuilder, samples};
use dualbody::sim::{BatchSimulator, StepScratch};
use dualbody::spatial::{Quaternion, Transform};
use dualbody::{Cast, Integrator, Scalar, Simulator, State};
use nalgebra::{DMatrix, Vector3, vector};
use num_dual::{Dual2_64, DualNum};

use crate::common::everything::INTEGRATORS;
use crate::common::ground::{differences, energy, on};
use crate::common::{
    OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA, asset, floating_robot, gripper, statue,
};

const G: f64 = 9.81;

fn frame(model: &Model, name: &str) -> Anchor {
    Anchor::frame(model, name).expect("a frame of the model")
}

pub(crate) fn four_bar() -> Simulator {
    let model = asset("four_bar.urdf");
    let pin = Constraint::ball([frame(&model, "loop_a"), frame(&model, "loop_b")]);
    Simulator::new(model).with_constraints(vec![pin])
}

/// A crank of 0.1 m and a rod of 0.3 m, thin and of 1 kg/m, that push a slider of 0.5 kg along x.
pub(crate) fn slider_crank() -> Simulator {
    let bar = |name: &str, l: f64| {
        let across = l * l * l / 12.0;
        LinkSpec::new(name).with_mass(l, [0.5 * l, 0.0, 0.0], [0.0, across, across])
    };
    let mut builder = ModelBuilder::new("slider_crank");
    builder.add_link(LinkSpec::new("world"));
    builder
        .add_link(bar("crank", CRANK))
        .add_link(bar("rod", ROD));
    builder.add_link(LinkSpec::new("slider").with_mass(SLIDER, [0.0; 3], [1e-3; 3]));
    let axis = [0.0, 1.0, 0.0];
    builder.add_joint(
        JointSpec::new("pivot", JointKind::Continuous, "world", "crank").with_axis(axis),
    );
    builder.add_joint(
        JointSpec::new("pin", JointKind::Continuous, "crank", "rod")
            .with_axis(axis)
            .with_translation([CRANK, 0.0, 0.0]),
    );
    builder.add_joint(
        JointSpec::new("rail", JointKind::Prismatic, "world", "slider").with_axis([1.0, 0.0, 0.0]),
    );
    let model = builder.build().expect("a robot that is known to be right");
    let end = frame(&model, "rod").moved([ROD, 0.0, 0.0]);
    let closed = Constraint::ball([end, frame(&model, "slider")]);
    Simulator::new(model).with_constraints(vec![closed])
}

const CRANK: f64 = 0.1;
const ROD: f64 = 0.3;
const SLIDER: f64 = 0.5;

/// A part of a linkage with one degree of freedom: where its mass is and how it is turned, as functions of the crank.
struct Part {
    mass: f64,
    inertia: f64,
    x: Dual2_64,
    z: Dual2_64,
    angle: Dual2_64,
}

/// θ̈ of a linkage under gravity along −z and a torque on the crank, by Lagrange:
/// I θ̈ + ½ I' θ̇² + V' = τ with I = Σ m (x'² + z'²) + J φ'².
fn lagrange(parts: &[Part], rate: f64, torque: f64) -> f64 {
    let (mut inertia, mut slope, mut gravity) = (0.0, 0.0, 0.0);
    for part in parts {
        let of = |weight: f64, x: &Dual2_64| (weight * x.v1 * x.v1, 2.0 * weight * x.v1 * x.v2);
        for (i, di) in [
            of(part.mass, &part.x),
            of(part.mass, &part.z),
            of(part.inertia, &part.angle),
        ] {
            inertia += i;
            slope += di;
        }
        gravity += part.mass * G * part.z.v1;
    }
    (torque - 0.5 * slope * rate * rate - gravity) / inertia
}

/// The slider-crank at a crank angle: the tree's joints, and its parts. Positive angles about y turn x to −z.
fn slider_crank_at(crank: f64) -> ([Dual2_64; 3], Vec<Part>) {
    let q = Dual2_64::from(crank).derivative();
    let (sin, cos) = q.sin_cos();
    let rod = (sin * (CRANK / ROD)).asin(); // above the rail, as the crank is below it
    let part = |mass: f64, inertia: f64, x: Dual2_64, z: Dual2_64, angle: Dual2_64| Part {
        mass,
        inertia,
        x,
        z,
        angle,
    };
    let end = cos * CRANK + rod.cos() * ROD;
    let parts = vec![
        part(
            CRANK,
            CRANK.powi(3) / 12.0,
            cos * (0.5 * CRANK),
            -sin * (0.5 * CRANK),
            q,
        ),
        part(
            ROD,
            ROD.powi(3) / 12.0,
            cos * CRANK + rod.cos() * (0.5 * ROD),
            -sin * (0.5 * CRANK),
            rod,
        ),
        part(SLIDER, 0.0, end, Dual2_64::from(0.0), Dual2_64::from(0.0)),
    ];
    ([q, -rod - q, end], parts)
}

/// The four-bar at a crank angle: the tree's joints, and its parts; cylinders of 1 kg/m. Angles about y turn z to x.
fn four_bar_at(crank: f64) -> ([Dual2_64; 3], Vec<Part>) {
    let q = Dual2_64::from(crank).derivative();
    let (sin, cos) = q.sin_cos();
    let (px, pz) = (sin * 0.12, cos * 0.12);
    // The pin lies where circles about the crank's end (0.5 m) and the rocker's pivot (0.42 m) meet, on the far side.
    let (dx, dz) = (-px + 0.4, -pz);
    let d = (dx * dx + dz * dz).sqrt();
    let along = (d * d + (0.25 - 0.42 * 0.42)) / (d * 2.0);
    let across = (-along * along + 0.25).sqrt();
    let (rx, rz) = (
        px + (dx * along - dz * across) / d,
        pz + (dz * along + dx * across) / d,
    );
    // The coupler lies along (0.4, 0.3) at zero.
    let (cx, cz) = (rx - px, rz - pz);
    let coupler = (cx * 0.3 - cz * 0.4).atan2(cx * 0.4 + cz * 0.3);
    let rocker = (rx - 0.4).atan2(rz);
    let cylinder = |l: f64| l * (3.0 * 1e-4 + l * l) / 12.0;
    let part = |l: f64, x: Dual2_64, z: Dual2_64, angle: Dual2_64| Part {
        mass: l,
        inertia: cylinder(l),
        x,
        z,
        angle,
    };
    let parts = vec![
        part(0.12, px * 0.5, pz * 0.5, q),
        part(0.5, px + cx * 0.5, pz + cz * 0.5, coupler),
        part(0.42, (rx - 0.4) * 0.5 + 0.4, rz * 0.5, rocker),
    ];
    ([q, coupler - q, rocker], parts)
}

/// The state of a linkage, and the accelerations of its joints in closed form.
fn linkage(
    (joints, parts): ([Dual2_64; 3], Vec<Part>),
    rate: f64,
    torque: f64,
) -> (State, [f64; 3]) {
    let acceleration = lagrange(&parts, rate, torque);
    let q = joints.map(|q| q.re);
    let v = joints.map(|q| q.v1 * rate);
    let a = joints.map(|q| q.v1 * acceleration + q.v2 * rate * rate);
    (State::new(&q, &v), a)
}

#[test]
fn accelerations_of_linkages_equal_their_closed_forms() {
    type At = fn(f64) -> ([Dual2_64; 3], Vec<Part>);
    let linkages: [(Simulator, At); 2] =
        [(slider_crank(), slider_crank_at), (four_bar(), four_bar_at)];
    for (simulator, at) in linkages {
        for (crank, rate, torque) in [
            (0.3, 0.0, 0.0),
            (0.3, 4.0, 0.0),
            (-2.0, -7.0, 0.4),
            (2.9, 1.0, -0.1),
        ] {
            let (state, expected) = linkage(at(crank), rate, torque);
            let open = simulator.constraint_errors(&state);
            assert!(
                open.iter().all(|error| error.abs() < 10.0 * ROUNDING),
                "{open:?}"
            );
            let mut scratch = StepScratch::new(&simulator);
            let a = simulator.acceleration_into(&state, &[torque, 0.0, 0.0], &mut scratch);
            for (a, expected) in a.iter().zip(expected) {
                let error = (a - expected).abs() / expected.abs().max(1.0);
                let name = simulator.model().name();
                assert!(
                    error < OTHER_ALGORITHM,
                    "{name} at {crank}: {a}, not {expected}"
                );
            }
        }
    }
}

// Without stabilisation worth the name, J̇ v alone keeps the loop closed, to the order of the integrator.
#[test]
fn loop_stays_closed_and_energy_stays_as_the_integrator_is_exact() {
    let model = asset("four_bar.urdf");
    let pin = Constraint::ball([frame(&model, "loop_a"), frame(&model, "loop_b")]);
    let free = pin.clone().with_time_constant(1e6);
    let (start, _) = linkage(four_bar_at(0.4), 8.0, 0.0);
    let mut errors = Vec::new();
    for dt in [2e-3, 1e-3] {
        let simulator = Simulator::new(model.clone())
            .with_time_step(dt)
            .with_integrator(Integrator::RungeKutta4)
            .with_constraints(vec![free.clone()]);
        let steps = (1.0 / dt) as usize;
        let last = simulator
            .rollout(&start, steps, |_, _, _| {})
            .last()
            .clone();
        let open = simulator.constraint_errors(&last);
        errors.push(open.iter().fold(0.0, |most: f64, x| most.max(x.abs())));
        let lost = energy(&model, &last) - energy(&model, &start);
        assert!(lost.abs() < 1e-5, "{lost}");
    }
    assert!(
        errors[0] < 1e-5 && errors[0] > 8.0 * errors[1],
        "{errors:?}"
    );
    for integrator in INTEGRATORS {
        let simulator = Simulator::new(model.clone())
            .with_integrator(integrator)
            .with_constraints(vec![pin.clone()]);
        let long = simulator.rollout(&start, 5000, |_, _, _| {});
        for state in long.states.iter().step_by(100) {
            let open = simulator.constraint_errors(state);
            assert!(
                open.iter().all(|error| error.abs() < 1e-3),
                "{integrator:?}: {open:?}"
            );
        }
    }
}

/// A free ball of 2 kg.
fn ball() -> Model {
    let mut builder = ModelBuilder::new("ball");
    builder.add_link(LinkSpec::new("ball").with_mass(2.0, [0.0; 3], [0.01; 3]));
    builder.build().expect("a robot that is known to be right")
}

// A ball on a massless rod is a pendulum of a point mass, the ball does not turn: θ̈ = −g sin θ / l.
#[test]
fn ball_on_a_rod_is_a_pendulum() {
    const LENGTH: f64 = 0.8;
    let model = ball();
    let rod = Constraint::distance([Anchor::world(), frame(&model, "ball")], LENGTH);
    let simulator = Simulator::new(model)
        .with_integrator(Integrator::RungeKutta4)
        .with_constraints(vec![rod]);
    let (angle, rate) = (1.1_f64, 2.0);
    let at = [LENGTH * angle.sin(), 0.0, -LENGTH * angle.cos()];
    let v = [
        rate * LENGTH * angle.cos(),
        0.0,
        rate * LENGTH * angle.sin(),
    ];
    let start = State::new(
        &[at[0], at[1], at[2], 1.0, 0.0, 0.0, 0.0],
        &[v[0], v[1], v[2], 0.0, 0.0, 0.0],
    );
    let force = simulator.contact_report(&start, &[]).constraints[0];
    // Pulled towards the pivot by m (l ω² + g cos θ).
    let expected = -2.0 * (LENGTH * rate * rate + G * angle.cos());
    assert!(
        (force - expected).abs() < OTHER_ALGORITHM,
        "{force}, not {expected}"
    );
    let point = pendulum_of_a_point(angle, rate, LENGTH, 1.5);
    let last = simulator.rollout(&start, 1500, |_, _, _| {}).last().clone();
    let swung = last.q[0].atan2(-last.q[2]);
    assert!((swung - point).abs() < 1e-8, "{swung}, not {point}");
    assert!(last.v.rows(3, 3).amax() < SAME_ALGEBRA);
}

/// By Runge–Kutta with a step of 0.1 ms.
fn pendulum_of_a_point(angle: f64, rate: f64, length: f64, seconds: f64) -> f64 {
    let f = |x: [f64; 2]| [x[1], -G * x[0].sin() / length];
    let (dt, mut x) = (1e-4, [angle, rate]);
    for _ in 0..(seconds / dt).round() as usize {
        let ahead = |k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
        let k_1 = f(x);
        let k_2 = f(ahead(k_1, 0.5 * dt));
        let k_3 = f(ahead(k_2, 0.5 * dt));
        let k_4 = f(ahead(k_3, dt));
        x = [0, 1].map(|i| x[i] + dt / 6.0 * (k_1[i] + 2.0 * k_2[i] + 2.0 * k_3[i] + k_4[i]));
    }
    x[0]
}

#[test]
fn weld_holds_a_body_and_carries_its_weight_even_twice() {
    let model = ball();
    let pose = Transform::new(
        Quaternion::exp(&vector![0.4, -0.3, 0.9]).to_matrix(),
        vector![0.3, -0.2, 0.7],
    );
    let wall = Anchor::new(None, pose);
    // Held 0.1 m beside the centre of mass: the weight has a moment.
    let held = frame(&model, "ball").moved([0.1, 0.0, 0.0]);
    let weld = Constraint::weld([wall, held]);
    for welds in [vec![weld.clone()], vec![weld.clone(), weld.clone()]] {
        for integrator in INTEGRATORS {
            let n = welds.len() as f64;
            let simulator = Simulator::new(model.clone())
                .with_integrator(integrator)
                .with_constraints(welds.clone());
            let start = simulator
                .assemble(&simulator.neutral_state())
                .expect("in reach")
                .state;
            let arm = held.pose_in_world(&model, start.q.as_slice());
            assert!((arm.translation - pose.translation).amax() < SAME_ALGEBRA);
            assert!((arm.rotation - pose.rotation).amax() < SAME_ALGEBRA);
            let later = simulator.rollout(&start, 1000, |_, _, _| {}).last().clone();
            assert!(
                later.deviation(&model, &start).amax() < OTHER_ALGORITHM,
                "{integrator:?}"
            );
            let forces = simulator.contact_report(&later, &[]).constraints;
            let moment =
                (pose.rotation * vector![-0.1, 0.0, 0.0]).cross(&vector![0.0, 0.0, -2.0 * G]);
            let expected = [0.0, 0.0, 2.0 * G, -moment.x, -moment.y, -moment.z];
            for (k, expected) in expected.into_iter().enumerate() {
                let sum: f64 = forces.iter().skip(k).step_by(6).sum();
                assert!(
                    (sum - expected).abs() < 1e-6,
                    "row {k} of {n}: {sum}, not {expected}"
                );
            }
        }
    }
}

// A constraint replaces a mimic joint by forces; motion and accelerations are the same.
#[test]
fn coupler_moves_like_a_follower() {
    let tied = gripper()
        .build()
        .expect("a robot that is known to be right");
    let mut loose = gripper();
    loose.mimicry = dualbody::model::Mimicry::Independent;
    let loose = loose.build().expect("a robot that is known to be right");
    let pairs = [
        (["right_joint", "left_joint"], 1.0, 0.0),
        (["thumb_joint", "shoulder_joint"], -0.7, 0.3),
        (["tip_joint", "thumb_joint"], 2.0, -0.1),
    ];
    let couplers = pairs.map(|(joints, ratio, offset)| {
        Constraint::coupler(&loose, joints, ratio, offset).expect("joints of the gripper")
    });
    let coupled = Simulator::new(loose).with_constraints(couplers.to_vec());
    let tied = Simulator::new(tied);
    let (q, v) = ([0.2, -0.4, 0.03], [0.5, 1.0, -0.2]);
    let full = |x: [f64; 3], offset: f64| {
        let thumb = -0.7 * x[0] + 0.3 * offset;
        // Limb after limb: the thumb and its tip are on the left finger.
        [x[0], x[1], x[2], thumb, 2.0 * thumb - 0.1 * offset, x[2]]
    };
    let state = State::new(&full(q, 1.0), &full(v, 0.0));
    let (mut one, mut two) = (StepScratch::new(&tied), StepScratch::new(&coupled));
    let expected = tied.acceleration_into(&State::new(&q, &v), &[0.3, -0.2, 0.1], &mut one);
    let a = coupled.acceleration_into(&state, &[0.3, -0.2, 0.1, 0.0, 0.0, 0.0], &mut two);
    let expected = full([expected[0], expected[1], expected[2]], 0.0);
    for (a, expected) in a.iter().zip(expected) {
        assert!(
            (a - expected).abs() < OTHER_ALGORITHM * expected.abs().max(1.0),
            "{a}, not {expected}"
        );
    }
}

#[test]
fn loops_assemble_from_bad_starts_and_say_when_they_cannot() {
    let simulator = four_bar();
    for start in [
        [0.3, -0.2, 0.5],
        [PI, 1.0, -2.0],
        [-1.5, 3.0, 0.1],
        [5.0, -4.0, 2.0],
    ] {
        let start = State::new(&start, &[1.0, -2.0, 0.5]);
        let closed = simulator.assemble(&start).expect("in reach");
        assert!(closed.error < SAME_ALGEBRA, "{closed:?}");
        // The velocity has been projected: the rate of the errors is zero.
        let model = simulator.model();
        let [a, b] = ["loop_a", "loop_b"].map(|name| model.find_frame(name).expect("a frame"));
        let velocity = |frame| {
            let (q, v) = (closed.state.q.as_slice(), closed.state.v.as_slice());
            let mixed = dualbody::spatial::Representation::Mixed;
            dualbody::dynamics::frame_velocity(model, q, v, frame, mixed).linear
        };
        assert!((velocity(a) - velocity(b)).amax() < SAME_ALGEBRA);
        assert!(closed.state.v.amax() > 0.01);
    }
    // Half a turn away, where a rotation has no direction to turn back.
    let model = ball();
    let weld = Constraint::weld([Anchor::world(), frame(&model, "ball")]);
    let simulator = Simulator::new(model).with_constraints(vec![weld]);
    let turned = State::new(&[1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0], &[0.0; 6]);
    let closed = simulator.assemble(&turned).expect("in reach").state;
    assert!(
        closed
            .deviation(simulator.model(), &simulator.neutral_state())
            .amax()
            < 1e-11
    );
    // Out of reach.
    let model = samples::double_pendulum();
    let far = Anchor::world().moved([0.0, 0.0, 2.5]);
    let tip = frame(&model, "lower").moved([0.0, 0.0, -1.0]);
    let torn = Simulator::new(model).with_constraints(vec![Constraint::ball([tip, far])]);
    let error = torn
        .assemble(&State::new(&[0.1, 0.2], &[0.0; 2]))
        .unwrap_err();
    assert!((error.error - 0.5).abs() < 1e-3, "{error}");
    assert!(error.to_string().contains("double_pendulum"), "{error}");
}

fn all_integrators() -> impl Iterator<Item = Integrator> {
    INTEGRATORS
        .into_iter()
        .chain([Integrator::ImplicitMidpoint])
}

// A bead of unit mass on a parabola, y = x², in weightlessness: with its inertia m(x) = 1 + 4 x² its energy is ½ m ẋ² at all times.
#[test]
fn bead_on_a_parabola_keeps_its_energy() {
    let slider = |name: &str, axis: [f64; 3]| {
        format!(
            "<joint name='{name}' type='slide' axis='{} {} {}'/>",
            axis[0], axis[1], axis[2]
        )
    };
    let xml = format!(
        "<mujoco><option gravity='0 0 0'/><worldbody><body>{}{}<geom size='0.1' mass='1'/></body></worldbody></mujoco>",
        slider("x", [1.0, 0.0, 0.0]),
        slider("y", [0.0, 1.0, 0.0])
    );
    let model = Model::from_mjcf_str(&xml).expect("two sliders");
    let parabola = [0.0, 0.0, 1.0, 0.0, 0.0];
    let wire = Constraint::polynomial_coupler(&model, ["y", "x"], parabola).expect("joints");
    for (integrator, largest) in [
        (Integrator::SemiImplicitEuler, 2e-3),
        (Integrator::RungeKutta4, 1e-8),
    ] {
        let simulator = Simulator::new(model.clone())
            .with_integrator(integrator)
            .with_time_step(1e-3)
            .with_constraints(vec![wire.clone()]);
        let start = simulator.state(&[-1.0, 1.0], &[1.0, -2.0]);
        let energy = |state: &State| state.v.norm_squared();
        let all = simulator.rollout(&start, 2000, |_, _, _| {});
        for state in &all.states {
            let off = state.q[1] - state.q[0] * state.q[0];
            assert!(off.abs() < 1e-5, "{integrator:?}: {off:e}");
            let lost = energy(state) / energy(&start) - 1.0;
            assert!(lost.abs() < largest, "{integrator:?}: {lost:e}");
        }
        assert!(all.last().q[0] > 1.0, "{:?}", all.last());
    }
}

#[test]
#[should_panic(expected = "couple that one by a polynomial")]
fn followers_are_not_tied_by_polynomials() {
    let model = gripper().build();
    let model = model.expect("a robot with followers");
    let body = model
        .bodies()
        .iter()
        .position(|body| body.coupling.is_some());
    let body = BodyId(body.expect("a follower"));
    let mut names = model.joint_names().into_iter();
    let follower =
        names.find(|name| model.joint_body(model.joint(name).expect("its joint")) == body);
    let tied = ["elbow_joint", follower.expect("its name")];
    let _ = Constraint::polynomial_coupler(&model, tied, [0.0, 1.0, 1.0, 0.0, 0.0]);
}

/// A floating robot that hangs by a weld, holds on by a ball joint and a rod, and has two joints coupled.
pub(crate) fn tangled(integrator: Integrator) -> (Simulator, State) {
    let model = floating_robot();
    let mut rng = crate::common::generator(5);
    let state = State::random(&model, &mut rng, 1.0);
    let here = |name: &str| {
        let anchor = frame(&model, name);
        let pose = anchor.pose_in_world(&model, state.q.as_slice());
        (anchor, Anchor::new(None, pose))
    };
    let ((tip, tip_at), (ball, ball_at)) = (here("hinge_tip"), here("ball_tip"));
    let coupled = ["slide_joint", "plate_elbow"];
    let coupler = Constraint::polynomial_coupler(&model, coupled, [0.1, 0.4, -0.5, 0.2, 0.3]);
    let constraints = vec![
        Constraint::weld([tip_at.moved([0.01, 0.0, -0.02]), tip]),
        Constraint::ball([ball, ball_at.moved([0.0, 0.02, 0.0])]),
        Constraint::distance([frame(&model, "slide_tip"), Anchor::world()], 0.9),
        coupler.expect("joints of the robot"),
    ];
    let simulator = Simulator::new(model)
        .with_integrator(integrator)
        .with_time_step(1e-2)
        .with_constraints(constraints);
    (simulator, state)
}

// Also where the constraints are not closed: the step is the same function there.
#[test]
fn jacobians_of_the_step_equal_finite_differences() {
    for integrator in all_integrators() {
        let (simulator, state) = tangled(integrator);
        let exact = simulator.linearize(&state, &vec![0.0; simulator.nu()]).a;
        let numeric = differences(&simulator, &state, 1e-6);
        let error = (&exact - &numeric).amax() / numeric.amax();
        assert!(error < 1e-6, "{integrator:?}: {error:e}");
        // Redundant rows as well: the pin of a plane linkage has one.
        let linkage = four_bar().with_integrator(integrator);
        let (state, _) = self::linkage(four_bar_at(0.4), 8.0, 0.0);
        let exact = linkage.linearize(&state, &[0.0; 3]).a;
        let numeric = differences(&linkage, &state, 1e-6);
        let error = (&exact - &numeric).amax() / numeric.amax();
        assert!(error < 1e-6, "{integrator:?}: {error:e}");
    }
}

/// The velocity after a step as a function of the length of a rod and of where it is held.
struct InLengths(Simulator, State);

impl VectorFunction for InLengths {
    fn n_outputs(&self) -> usize {
        self.1.v.len()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let simulator: Simulator<T> = self.0.cast();
        let mut constraints = simulator.constraints().to_vec();
        for constraint in &mut constraints {
            if let ConstraintKind::Distance { anchors, .. } = constraint.kind() {
                let mut anchors = *anchors;
                anchors[0].placement.translation.x += x[1];
                let (anchors, length) = (anchors, x[0]);
                *constraint = constraint.with_kind(ConstraintKind::Distance { anchors, length });
            }
        }
        let u = vec![T::zero(); simulator.nu()];
        let next = simulator
            .with_constraints(constraints)
            .step(&self.1.cast(), &u);
        y.copy_from_slice(next.v.as_slice());
    }
}

#[test]
fn derivatives_in_lengths_equal_finite_differences() {
    for integrator in all_integrators() {
        let (simulator, state) = tangled(integrator);
        let f = InLengths(simulator, state);
        let exact = jacobian(&f, &[0.9, 0.0]);
        let numeric = finite_difference::jacobian(&f, &[0.9, 0.0]);
        let error = (&exact - &numeric).amax() / numeric.amax();
        assert!(
            error < 1e-7 && exact.amax() > 0.1,
            "{integrator:?}: {error:e}"
        );
    }
}

#[test]
fn constraints_and_contact_hold_together() {
    let laws = [
        ContactLaw::Soft(SoftContact::estimate(2.0, 4, 1e-3)),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid::default()),
    ];
    for law in laws {
        for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
            // A box on the ground, its centre held above x = 0.1 by a rod to a far nail: it slides nowhere.
            let model = asset("box.urdf");
            let nail = Anchor::world().moved([1.1, 0.0, 0.06]);
            let rod = Constraint::distance([frame(&model, "box"), nail], 1.0);
            let simulator = on(model, Terrain::flat(0.0), law)
                .with_integrator(integrator)
                .with_constraints(vec![rod]);
            let start = simulator.state(
                &[0.1, 0.0, 0.0605, 1.0, 0.0, 0.0, 0.0],
                &[-0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
            );
            let start = simulator.assemble(&start).expect("in reach").state;
            let last = crate::common::ground::run(&simulator, &start, 1.0);
            let report = simulator.contact_report(&last, &[]);
            assert!(report.certificate.is_converged(), "{law:?} {integrator:?}");
            assert!(
                (last.q[0] - 0.1).abs() < 1e-3 && last.v.amax() < 1e-3,
                "{law:?} {integrator:?}: {}",
                last.v
            );
            let sum = report
                .forces
                .iter()
                .fold(Vector3::zeros(), |sum, f| sum + f);
            assert!((sum.z - G).abs() < 0.02, "{law:?} {integrator:?}: {sum}");
        }
    }
}

#[test]
fn batches_and_robots_without_freedom_have_constraints_too() {
    let simulator = four_bar();
    let starts: Vec<State> = (0..11)
        .map(|k| linkage(four_bar_at(0.3 * f64::from(k)), 3.0 - f64::from(k), 0.0).0)
        .collect();
    let mut batch = BatchSimulator::new(simulator.clone(), starts.len());
    let mut states = batch.states(&starts);
    batch.step(&mut states, &vec![0.1; 3 * starts.len()]);
    for (k, start) in starts.iter().enumerate() {
        let single = simulator.step(start, &[0.1; 3]);
        let apart = (states.state(k).v - single.v).amax();
        assert!(apart < OTHER_ALGORITHM, "{k}: {apart:e}");
    }
    let model = statue();
    let weld = Constraint::weld([Anchor::world(), frame(&model, "stone")]);
    let stone = Simulator::new(model).with_constraints(vec![weld]);
    let start = stone.neutral_state();
    assert!(stone.step(&start, &[]).is_finite());
    assert!(stone.assemble(&start).is_ok());
    let matrix = stone.linearize(&start, &[]).a;
    assert_eq!(matrix, DMatrix::zeros(0, 0));
    assert_eq!(stone.model().to_builder().base, Base::Fixed);
}
