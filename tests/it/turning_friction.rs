//! Torsional and rolling friction: closed forms of balls that spin and roll, soft fingers, conservation, and derivatives beside differences.

use dualbody::contact::{
    CollisionOptions, ContactLaw, Contacts, Material, RelaxedRigid, Rigid, SoftContact, Terrain,
    TurningFriction,
};
use dualbody::joint::JointKind;
use dualbody::model::{Base, JointSpec, LinkSpec, Mass, ModelBuilder};
use dualbody::sim::{BatchSimulator, SimulatorParameterGroup};
use dualbody::{Integrator, Model, ModelOptions, Simulator, State};
use nalgebra::{DMatrix, DVector, Vector3};

const MASS: f64 = 2.0;
const RADIUS: f64 = 0.1;
/// Of a solid sphere.
const INERTIA: f64 = 0.4 * MASS * RADIUS * RADIUS;
const G: f64 = 9.81;

fn rigid() -> ContactLaw {
    ContactLaw::Rigid(Rigid {
        restitution: 0.1,
        ..Rigid::default()
    })
}

/// Stiffly regularised contact, which creeps little.
fn relaxed() -> ContactLaw {
    let mut law = RelaxedRigid::default();
    law.impedance.least = 0.99;
    law.impedance.largest = 0.999;
    ContactLaw::RelaxedRigid(law)
}

fn soft() -> ContactLaw {
    ContactLaw::Soft(SoftContact::estimate(MASS, 1, 1e-3))
}

fn turning(torsional: f64, rolling: f64) -> TurningFriction {
    TurningFriction { torsional, rolling }
}

/// Free bodies, each with seven coordinates.
fn free(links: Vec<LinkSpec>, gravity: f64) -> Model {
    let mut builder = ModelBuilder::new("bodies")
        .with_base(Base::Fixed)
        .with_gravity([0.0, 0.0, -gravity]);
    builder.add_link(LinkSpec::new("floor"));
    for link in links {
        let name = link.name.clone();
        builder.add_link(link);
        let joint = JointSpec::new(format!("{name} free"), JointKind::Floating, "floor", name);
        builder.add_joint(joint);
    }
    builder.build().expect("a model")
}

fn sphere(name: &str) -> LinkSpec {
    LinkSpec::solid_sphere(name, RADIUS, Mass::Kilograms(MASS))
}

/// A ball on flat ground.
fn ball(law: ContactLaw, friction: TurningFriction, dt: f64) -> Simulator {
    let model = free(vec![sphere("ball")], G);
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_turning_friction(&model, "ball", friction)
        .expect("a ball");
    Simulator::new(model)
        .with_contacts(contacts)
        .with_actuated_joints(&[])
        .expect("joints")
        .with_time_step(dt)
}

/// At rest on the ground, with a velocity: linear and angular.
fn resting(simulator: &Simulator, v: [f64; 6]) -> State {
    let mut state = simulator.neutral_state();
    state.q[2] = RADIUS - 1e-4;
    for _ in 0..400 {
        let still = simulator.step(&state, &[]);
        (state.q[2], state.v[2]) = (still.q[2], still.v[2]);
    }
    state.v.copy_from_slice(&v);
    state.contact.fill(0.0);
    state
}

fn advance(simulator: &Simulator, state: &State, steps: usize) -> State {
    (0..steps).fold(state.clone(), |state, _| simulator.step(&state, &[]))
}

/// Laws with integrators, and the accuracy of closed forms with them.
fn all() -> [(ContactLaw, Integrator, f64); 5] {
    let (euler, implicit) = (Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity);
    [
        (rigid(), euler, 1e-6),
        (rigid(), implicit, 1e-6),
        (relaxed(), euler, 5e-3),
        (soft(), euler, 5e-3),
        (soft(), implicit, 5e-3),
    ]
}

// I ω̇ = −c m g until it stops, at t = I Ω / (c m g); a larger moment than that of friction does nothing else.
#[test]
fn a_spinning_ball_stops_by_the_closed_form() {
    let (c, rate, dt) = (0.004, 3.0, 1e-3);
    for (law, integrator, accuracy) in all() {
        let simulator = ball(law, turning(c, 0.0), dt).with_integrator(integrator);
        let start = resting(&simulator, [0.0, 0.0, 0.0, 0.0, 0.0, rate]);
        let brake = c * MASS * G / INERTIA;
        let half = (0.5 * rate / brake / dt).round() as usize;
        let moving = advance(&simulator, &start, half);
        let expected = rate - brake * half as f64 * dt;
        let error = (moving.v[5] - expected).abs();
        assert!(
            error < accuracy * rate,
            "{law:?}: {} {expected}",
            moving.v[5]
        );
        let still = advance(&simulator, &moving, half + 200);
        assert!(still.v.norm() < 1e-2 * rate, "{law:?}: {}", still.v);
    }
}

// The moment r m g against rolling and friction F: m v̇ = −F, I v̇ / ρ = −r m g + F ρ, so v̇ = −r g ρ / (ρ² + I / m), in any direction.
#[test]
fn a_rolling_ball_decelerates_by_the_closed_form_in_any_direction() {
    let (r, speed, dt) = (0.002, 0.8, 1e-3);
    let a = r * G * RADIUS / (RADIUS * RADIUS + INERTIA / MASS);
    for (law, integrator, accuracy) in all() {
        for angle in [0.0, 0.7, 2.5_f64] {
            let along = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let simulator = ball(law, turning(0.0, r), dt).with_integrator(integrator);
            let v = along * speed;
            let turn = Vector3::z().cross(&v) / RADIUS;
            let start = resting(&simulator, [v.x, v.y, 0.0, turn.x, turn.y, turn.z]);
            let moved = advance(&simulator, &start, 300);
            // The floating joint has its linear velocity in the axes of the body.
            let pose = dualbody::dynamics::frame_pose(
                simulator.model(),
                moved.q.as_slice(),
                simulator.model().frame("ball").expect("a ball"),
            );
            let found = pose.rotation * moved.v.fixed_rows::<3>(0);
            let expected = along * (speed - a * 0.3);
            let error = (found - expected).norm();
            assert!(
                error < accuracy.max(1e-4) * speed,
                "{law:?}: {found} {expected}"
            );
        }
    }
}

// Below its bound the moment holds: a ball on a slope rolls if r < ρ tan α, and stays if not.
#[test]
fn a_ball_on_a_slope_stays_below_the_angle_of_rolling_friction() {
    let slope = 0.05_f64;
    for (r, stays) in [(1.1, true), (0.9, false)] {
        let model = free(vec![sphere("ball")], G);
        let contacts = Contacts::new(&model, Terrain::incline(slope), rigid())
            .with_turning_friction(&model, "ball", turning(0.0, r * RADIUS * slope.tan()))
            .expect("a ball");
        let simulator = Simulator::new(model)
            .with_contacts(contacts)
            .with_actuated_joints(&[])
            .expect("joints");
        let mut state = simulator.neutral_state();
        state.q[2] = RADIUS / slope.cos();
        let moved = advance(&simulator, &state, 200);
        let way = moved.q[0].hypot(moved.q[1]);
        assert_eq!(way < 1e-6, stays, "{way}");
    }
}

/// A plate of 0.2 kg that two fingers hold by its end, each pressing with 20 N along x; without gravity of the fingers.
fn grasp(law: ContactLaw, friction: TurningFriction) -> Simulator {
    let mut builder = ModelBuilder::new("grasp").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("hand"));
    let kilogram = Mass::Kilograms(0.1);
    for (name, side) in [("left", -1.0), ("right", 1.0)] {
        builder.add_link(LinkSpec::solid_sphere(name, 0.01, kilogram));
        let rail = JointSpec::new(name.to_owned(), JointKind::Prismatic, "hand", name);
        let at = [side * 0.02, 0.0, 0.0];
        builder.add_joint(rail.with_axis([-side, 0.0, 0.0]).with_translation(at));
    }
    let plate = LinkSpec::solid_box("plate", [0.02, 0.2, 0.04], Mass::Kilograms(0.2));
    builder.add_link(plate);
    builder.add_joint(JointSpec::new("free", JointKind::Floating, "hand", "plate"));
    let model = builder.build().expect("a grasp");
    let soft = Material {
        friction: 1.0,
        turning: friction,
        ..Material::default()
    };
    let options = CollisionOptions::default()
        .with_self_collision()
        .with_material("left", soft)
        .with_material("right", soft);
    let contacts = Contacts::new(&model, Terrain::flat(-1.0), law)
        .with_collisions(&model, law, &options)
        .expect("links");
    Simulator::new(model)
        .with_contacts(contacts)
        .with_actuated_joints(&["left", "right"])
        .expect("joints")
        .with_time_step(1e-3)
}

/// The angle by which the plate has turned about the axis of the fingers after some steps.
fn swing(simulator: &Simulator, steps: usize) -> f64 {
    let mut state = simulator.neutral_state();
    let first = simulator.model().joint("free").expect("a joint");
    let q = simulator.model().joint_q(first);
    state.q[q.start + 1] = 0.08;
    for _ in 0..steps {
        state = simulator.step(&state, &[20.0, 20.0]);
    }
    let turn = |k: usize| state.q[q.start + 3 + k];
    2.0 * turn(1).atan2(turn(0))
}

// The weight acts 0.08 m beside the fingers: 0.157 N m, which two moments of 20 N · c hold for c > 3.9 mm.
#[test]
fn a_plate_between_point_fingers_swings_and_between_soft_ones_does_not() {
    // Regularised moments creep like friction, by the same ratio.
    let ContactLaw::RelaxedRigid(mut held) = relaxed() else {
        return;
    };
    held.friction_impedance_ratio = 1e3;
    for law in [rigid(), ContactLaw::RelaxedRigid(held)] {
        let angle = |c: f64| swing(&grasp(law, turning(c, 0.0)), 150).abs();
        let angles = [0.0, 0.003, 0.006].map(angle);
        assert!(angles[0] > 0.1 && angles[1] > 0.1 * angles[0], "{angles:?}");
        assert!(angles[2] < 1e-2 * angles[0], "{angles:?}");
    }
}

/// Two balls, one on the other in space, that spin against each other.
fn pair(law: ContactLaw, friction: TurningFriction) -> (Simulator, State) {
    let model = free(vec![sphere("one"), sphere("two")], 0.0);
    let options = CollisionOptions {
        turning: friction,
        ..CollisionOptions::default()
    };
    let contacts = Contacts::new(&model, Terrain::flat(-10.0), law)
        .with_collisions(&model, law, &options)
        .expect("links");
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_actuated_joints(&[])
        .expect("joints")
        .with_time_step(1e-3);
    let mut state = simulator.neutral_state();
    state.q[7 + 2] = 2.0 * RADIUS - 7e-4;
    state.v.copy_from_slice(&[
        0.02, -0.01, 0.1, 0.3, -0.2, 5.0, -0.03, 0.02, -0.2, -0.5, 0.7, -2.0,
    ]);
    (simulator, state)
}

/// Momentum and angular momentum about the origin.
fn momentum(simulator: &Simulator, state: &State) -> DVector<f64> {
    let model = simulator.model();
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    let own = dualbody::dynamics::centroidal_momentum(model, q, v);
    let center = dualbody::dynamics::center_of_mass(model, q);
    let about = own.angular + center.cross(&own.linear);
    DVector::from_iterator(6, own.linear.iter().chain(&about).copied())
}

#[test]
fn moments_between_bodies_conserve_momentum() {
    for law in [rigid(), relaxed(), soft()] {
        let (simulator, state) = pair(law, turning(0.003, 0.001));
        let free = pair(law, turning(0.0, 0.0)).0;
        let [next, without] = [&simulator, &free].map(|s| s.step(&state, &[]));
        assert!((next.v - without.v).norm() > 1e-4, "{law:?}");
        let (before, after) = (
            momentum(&simulator, &state),
            momentum(&simulator, &simulator.step(&state, &[])),
        );
        // Euler's step keeps angular momentum of bodies that turn to first order.
        assert!((after - before).norm() < 2e-5, "{law:?}");
    }
}

/// A state after a displacement in tangent coordinates: position, velocity, contact.
fn displaced(simulator: &Simulator, state: &State, k: usize, by: f64) -> State {
    let (model, mut out) = (simulator.model(), state.clone());
    let nv = model.nv();
    let mut change = vec![0.0; nv];
    match k {
        _ if k < nv => {
            change[k] = by;
            out.q = model.integrate(state.q.as_slice(), &change);
        }
        _ if k < 2 * nv => out.v[k - nv] += by,
        _ => out.contact[k - 2 * nv] += by,
    }
    out
}

/// The difference of two states in the tangent space of the first.
fn difference(simulator: &Simulator, from: &State, to: &State) -> DVector<f64> {
    let dq = (simulator.model()).difference(from.q.as_slice(), to.q.as_slice());
    let (dv, dm) = (&to.v - &from.v, &to.contact - &from.contact);
    let all = dq.iter().chain(dv.iter()).chain(dm.iter());
    DVector::from_vec(all.copied().collect())
}

/// A and B, and gradients in state and parameters, beside central differences of the step.
fn check_derivatives(what: &str, simulator: &Simulator, state: &State, u: &[f64]) {
    const BY: f64 = 1e-6;
    let found = simulator.linearize(state, u);
    let n = found.a.nrows();
    let next = simulator.step(state, u);
    let slope = |at: &dyn Fn(f64) -> State| {
        let [after, before] = [BY, -BY].map(|by| difference(simulator, &next, &at(by)));
        (after - before) / (2.0 * BY)
    };
    let columns: Vec<_> = (0..n)
        .map(|k| slope(&|by| simulator.step(&displaced(simulator, state, k, by), u)))
        .collect();
    let expected = DMatrix::from_columns(&columns);
    let size = expected.amax().max(1.0);
    let error = (&found.a - &expected).amax() / size;
    assert!(error < 1e-5, "{what}: A differs by {error:e}");
    let weights = DVector::from_fn(n, |k, _| (k as f64 + 0.5).sin());
    let gradient = simulator.vjp(state, u, weights.as_slice());
    let error = (found.a.tr_mul(&weights) - &gradient.state).amax() / size;
    assert!(error < 1e-9, "{what}: adjoint differs by {error:e}");
    let (layout, parameters) = (simulator.parameter_layout(), simulator.parameters());
    for (group, range) in layout.groups() {
        use SimulatorParameterGroup as Group;
        let is_own = matches!(
            group,
            Group::ContactLaw(_) | Group::PairLaw | Group::CollisionShape(_) | Group::TimeStep
        );
        // Numbers at the end of their range have no differences to both sides.
        for k in range.clone().filter(|k| is_own && parameters[*k] != 0.0) {
            let expected = slope(&|by| {
                let mut moved = parameters.clone();
                moved[k] += by * moved[k].abs().max(1e-3);
                simulator.with_parameters(moved.as_slice()).step(state, u)
            });
            let expected = expected.dot(&weights) / parameters[k].abs().max(1e-3);
            let (own, size) = (gradient.parameters[k], expected.abs().max(1.0));
            assert!(
                (own - expected).abs() < 1e-4 * size,
                "{what}: {group:?} {k}: {own} {expected}"
            );
        }
    }
}

/// Laws whose rows are regular functions of all parameters, with an integrator.
fn smooth_cases() -> [(ContactLaw, Integrator); 5] {
    let (euler, implicit) = (Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity);
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let soft = ContactLaw::Soft(SoftContact::estimate(MASS, 1, 2e-3));
    [
        (rigid(), euler),
        (relaxed, euler),
        (relaxed, implicit),
        (soft, euler),
        (soft, implicit),
    ]
}

#[test]
fn derivatives_with_the_ground_equal_differences_when_moments_slip_and_when_they_hold() {
    for (law, integrator) in smooth_cases() {
        for (name, friction) in [
            ("slip", turning(0.003, 0.002)),
            ("hold", turning(0.3, 0.2)),
            ("spin", turning(0.003, 0.0)),
            ("roll", turning(0.0, 0.2)),
        ] {
            let simulator = ball(law, friction, 2e-3).with_integrator(integrator);
            let mut state = simulator.neutral_state();
            state.q[2] = RADIUS - 2e-3;
            let v = [0.02, -0.03, -0.2, 0.4, -0.3, 1.3];
            state.v.copy_from_slice(&v);
            let what = format!("{} {integrator:?} {name}", law_name(&law));
            check_derivatives(&what, &simulator, &state, &[]);
        }
    }
}

#[test]
fn derivatives_between_bodies_equal_differences() {
    for (law, integrator) in smooth_cases() {
        for friction in [turning(0.003, 0.001), turning(0.3, 0.2)] {
            let (simulator, state) = pair(law, friction);
            let simulator = simulator.with_integrator(integrator);
            let what = format!("{} {integrator:?} {friction:?}", law_name(&law));
            check_derivatives(&what, &simulator, &state, &[]);
        }
        // Rigid rolling friction of two fingers against their friction is redundant, and contradicts it in states nearby.
        let rolling = if law == rigid() { 0.0 } else { 0.001 };
        let simulator = grasp(law, turning(0.004, rolling)).with_integrator(integrator);
        let mut state = simulator.neutral_state();
        let q = simulator
            .model()
            .joint_q(simulator.model().joint("free").expect("a joint"));
        state.q[q.start + 1] = 0.03;
        for (k, v) in state.v.iter_mut().enumerate() {
            *v = 0.02 * (k as f64 + 1.0).sin();
        }
        state.q[0] = 3e-4;
        state.q[1] = 7e-4;
        let what = format!("grasp {} {integrator:?}", law_name(&law));
        check_derivatives(&what, &simulator, &state, &[20.0, 21.0]);
    }
}

fn law_name(law: &ContactLaw) -> &'static str {
    match law {
        ContactLaw::Rigid(_) => "rigid",
        ContactLaw::RelaxedRigid(_) => "relaxed",
        _ => "soft",
    }
}

// θ = I Ω² / (2 c m g): ∂θ/∂c = −θ / c, through a rollout that ends at rest.
#[test]
fn angle_until_rest_has_the_slope_of_its_closed_form() {
    let (rate, dt) = (3.0, 1e-3);
    let angle = |c: f64| {
        let simulator = ball(rigid(), turning(c, 0.0), dt);
        let mut state = resting(&simulator, [0.0, 0.0, 0.0, 0.0, 0.0, rate]);
        let mut sum = 0.0;
        for _ in 0..600 {
            state = simulator.step(&state, &[]);
            sum += dt * state.v[5];
        }
        sum
    };
    let c = 0.004;
    let expected = -INERTIA * rate * rate / (2.0 * c * c * MASS * G);
    let slope = (angle(c + 1e-4) - angle(c - 1e-4)) / 2e-4;
    assert!((slope / expected - 1.0).abs() < 0.02, "{slope} {expected}");
}

#[test]
fn none_is_the_same_to_the_last_bit_and_has_no_parameters() {
    for law in [rigid(), relaxed(), soft()] {
        let none = ball(law, TurningFriction::default(), 1e-3);
        let model = none.model().clone();
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
        let plain = Simulator::new(model)
            .with_contacts(contacts)
            .with_actuated_joints(&[])
            .expect("joints")
            .with_time_step(1e-3);
        let start = resting(&plain, [0.3, -0.2, 0.0, 1.0, -2.0, 3.0]);
        let ends = [&plain, &none].map(|simulator| advance(simulator, &start, 50));
        assert_eq!(ends[0], ends[1]);
        assert_eq!(plain.parameters().len(), none.parameters().len());
        let some = ball(law, turning(0.01, 0.0), 1e-3);
        assert_eq!(some.parameters().len(), plain.parameters().len() + 2);
        let layout = some.parameter_layout();
        let mut names = layout.names().iter();
        assert!(names.any(|name| name.contains("torsional friction")));
    }
}

/// Also those whose squares are zero, and those that count as none.
#[test]
fn tiny_coefficients_change_next_to_nothing() {
    let v = [1.0, 0.0, 0.0, 0.0, 10.0, 5.0];
    for (law, integrator, dt) in all() {
        // Explicit soft contact amplifies rounding at long steps.
        let dt = dt.min(1e-3);
        let after = |c: f64| {
            let simulator = ball(law, turning(c, c), dt).with_integrator(integrator);
            advance(&simulator, &resting(&simulator, v), 20)
        };
        let none = after(0.0);
        for c in [1e-300, 1e-155, 1e-20, 1e-9, 1.1e-8, 1e-7] {
            let tiny = after(c);
            let error = (&tiny.q - &none.q).norm() + (&tiny.v - &none.v).norm();
            // Under the weight, and while the ball is pushed out of the ground at less than 1 cm/s.
            let impulse = MASS * (G * 20.0 * dt + 0.01);
            let largest = if c > 1e-8 { c * impulse / INERTIA } else { 0.0 };
            assert!(
                error <= 2.0 * largest,
                "{law:?} {c:e}: {error:e}, {largest:e}"
            );
        }
    }
}

#[test]
fn lanes_of_a_batch_have_the_bits_of_each_alone() {
    for law in [rigid(), relaxed(), soft()] {
        let simulator = ball(law, turning(0.003, 0.001), 1e-3);
        let starts: Vec<State> = (0..11)
            .map(|k| {
                let x = k as f64;
                let mut state = simulator.neutral_state();
                state.q[2] = RADIUS + [1e-3, 0.0, -1e-3, 3.0][k % 4];
                let v = [0.1 * x, -0.2, -0.3, x.sin(), x.cos(), 3.0 - x];
                state.v.copy_from_slice(&v);
                state
            })
            .collect();
        let mut batch = BatchSimulator::new(simulator.clone(), starts.len()).with_threads(1);
        let together = batch.rollout(&starts, 60, |_, _, _| {});
        for (k, start) in starts.iter().enumerate() {
            let alone = simulator.rollout(start, 60, |_, _, _| {});
            let (a, b) = (together.state(k, 60), alone.last());
            assert_eq!(a.q, b.q, "{} {k}", law_name(&law));
            assert_eq!(a.v, b.v);
        }
    }
}

// A top that spins between many others: forces by islands, each in one piece.
#[test]
fn balls_in_a_world_spin_as_one_does_alone() {
    let links = (0..30).map(|k| sphere(&format!("ball {k}"))).collect();
    let model = free(links, G);
    let mut contacts = Contacts::new(&model, Terrain::flat(0.0), rigid());
    for k in 0..30 {
        let link = format!("ball {k}");
        contacts = contacts
            .with_turning_friction(&model, &link, turning(0.004, 0.001))
            .expect("a ball");
    }
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_actuated_joints(&[])
        .expect("joints")
        .with_time_step(1e-3);
    let alone = ball(rigid(), turning(0.004, 0.001), 1e-3);
    let v = [0.1, 0.0, 0.0, 0.2, 1.0, 4.0];
    let one = resting(&alone, v);
    let mut state = simulator.neutral_state();
    for k in 0..30 {
        state.q.rows_mut(7 * k, 7).copy_from(&one.q);
        state.q[7 * k] = k as f64;
        state.v.rows_mut(6 * k, 6).copy_from_slice(&v);
    }
    let (many, one) = (advance(&simulator, &state, 20), advance(&alone, &one, 20));
    for k in 0..30 {
        let error = (many.v.rows(6 * k, 6) - &one.v).norm();
        assert!(error < 1e-9, "{k}: {error:e}");
    }
}

// qacc of `MuJoCo` 4.0 with elliptic cones; with μ = 1 the compliance of its moments is that of here. Moments that hold have no bound that could differ. Its force
// acts in the middle of the depth, here 0.1 µm.
#[test]
fn held_moments_equal_those_of_mujoco() {
    let v = [0.0, 0.0, 0.0, 0.03, 0.02, 0.4];
    for (condim, friction, expected) in [
        (
            4,
            "1 0.3 0.0001",
            [
                0.05829960637309017,
                -0.08744940955963526,
                -0.9807756134581926,
                -2.1862341458732635,
                -1.4574894305821753,
                -41.89835769011903,
            ],
        ),
        (
            6,
            "1 0.3 0.2",
            [
                0.002031888388407401,
                -0.003047832582611091,
                -0.9807756134581928,
                -3.1240299134738647,
                -2.0826866089825766,
                -41.89835769011903,
            ],
        ),
    ] {
        let contact = format!("condim='{condim}' friction='{friction}'");
        let xml = format!(
            "<mujoco><option cone='elliptic' timestep='0.002'/><worldbody><geom type='plane' size='5 5 1' {contact}/>
             <body name='ball' pos='0 0 0.0999999'><freejoint/><inertial pos='0 0 0' mass='2' diaginertia='0.008 0.008 0.008'/>
             <geom type='sphere' size='0.1' {contact}/></body></worldbody></mujoco>"
        );
        let loaded = ModelOptions::default().load_mjcf_scene_str(&xml);
        let (scene, report) = loaded.expect("a scene");
        let report = format!("{report:?}");
        assert!(!report.contains("condim"), "{report}");
        let simulator = scene.simulator();
        let state = simulator.state(scene.reference.q.as_slice(), &v);
        let found = simulator.acceleration(&state, &[]);
        let error = (&found - DVector::from_column_slice(&expected)).amax();
        assert!(error < 1e-5, "condim {condim}: {error:e} {found}");
    }
}

#[test]
#[should_panic(expected = "torsional and rolling friction is found by a search")]
fn recorded_steps_refuse_moments() {
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let _ = dualbody::codegen::step(&ball(law, turning(0.01, 0.0), 1e-3));
}

#[test]
#[should_panic(expected = "the torsional friction is -0.1: negative or not finite")]
fn negative_torsional_friction_is_refused() {
    let _ = ball(rigid(), turning(-0.1, 0.0), 1e-3);
}
