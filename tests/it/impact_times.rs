//! Impacts at their time within a step: motions and derivatives beside closed forms and central differences, at any time step.

use dualbody::contact::{CollisionOptions, ContactLaw, Contacts, Rigid, Terrain};
use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::joint::JointKind;
use dualbody::linearize::{LinearizeScratch, RolloutCost};
use dualbody::model::{Base, JointSpec, LinkSpec, Mass, ModelBuilder};
use dualbody::sim::BatchSimulator;
use dualbody::{Integrator, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

const RADIUS: f64 = 0.1;
const TIME_STEPS: [f64; 4] = [1e-4, 1e-3, 3.3e-3, 1e-2];

fn rigid(friction: f64, restitution: f64) -> ContactLaw {
    ContactLaw::Rigid(Rigid {
        friction,
        restitution,
        ..Rigid::default()
    })
}

/// A ball of 1 kg over a ground.
fn ball(terrain: Terrain, gravity: f64, law: ContactLaw) -> Simulator {
    let mut builder = ModelBuilder::new("ball");
    builder.add_link(LinkSpec::solid_sphere("ball", RADIUS, Mass::Kilograms(1.0)));
    let model = builder.build().expect("a ball");
    let model = model.with_gravity(Vector3::new(0.0, 0.0, -gravity));
    let contacts = Contacts::new(&model, terrain, law);
    Simulator::new(model).with_contacts(contacts)
}

fn falling(simulator: &Simulator, height: f64, speed: f64) -> State {
    let mut state = simulator.neutral_state();
    state.q[2] = height;
    state.v[2] = -speed;
    state
}

/// A coordinate of the configuration at the end.
struct Coordinate(usize);

impl RolloutCost for Coordinate {
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        last.q[self.0]
    }
}

fn no_inputs(simulator: &Simulator, steps: usize) -> Vec<DVector<f64>> {
    vec![DVector::zeros(simulator.nu()); steps]
}

/// The last state of a motion without input, and the product of the Jacobians of its steps.
fn chained(simulator: &Simulator, start: &State, steps: usize) -> (State, DMatrix<f64>) {
    let n = simulator.n_tangent();
    let (mut state, mut product) = (start.clone(), DMatrix::identity(n, n));
    let mut scratch = LinearizeScratch::new(simulator);
    let mut step = simulator.linearize(&state, &vec![0.0; simulator.nu()]);
    let u = vec![0.0; simulator.nu()];
    for _ in 0..steps {
        simulator.linearize_into(&state, &u, &mut scratch, &mut step);
        product = &step.a * product;
        state = simulator.step(&state, &u);
    }
    (state, product)
}

/// The place of a parameter whose name ends so.
fn parameter(simulator: &Simulator, name: &str) -> usize {
    let layout = simulator.parameter_layout();
    let mut names = layout.names().iter().enumerate();
    let found = names.find(|(_, own)| own.ends_with(name));
    found.unwrap_or_else(|| panic!("no parameter {name}")).0
}

// h(T) = r + e (|ḣ| T − h₀ + r), so that ∂h/∂h₀ = −e, ∂h/∂ḣ = −e T, ∂h/∂e = |ḣ| T − h₀ + r, ∂h/∂r = 1 + e.
#[test]
fn ball_without_gravity_has_the_closed_form_at_every_time_step() {
    const E: f64 = 0.6;
    for dt in TIME_STEPS {
        let simulator = ball(Terrain::flat(0.0), 0.0, rigid(0.5, E)).with_time_step(dt);
        let steps = (1.0 / dt).round() as usize;
        let time = dt * steps as f64;
        let start = falling(&simulator, 1.0, 2.0);
        let (end, product) = chained(&simulator, &start, steps);
        let expected = RADIUS + E * (2.0 * time - 1.0 + RADIUS);
        assert!((end.q[2] - expected).abs() < 1e-10, "{dt}: {}", end.q[2]);
        assert!(
            (product[(2, 2)] + E).abs() < 1e-9,
            "{dt}: {}",
            product[(2, 2)]
        );
        assert!((product[(2, 8)] + E * time).abs() < 1e-9, "{dt}");
        let inputs = no_inputs(&simulator, steps);
        let found = simulator.rollout_gradient(&start, &inputs, &Coordinate(2));
        for (name, found, expected) in [
            ("h0", found.start[2], -E),
            ("hdot", found.start[8], -E * time),
            (
                "e",
                found.parameters[parameter(&simulator, "restitution")],
                2.0 * time - 1.0 + RADIUS,
            ),
            (
                "r",
                found.parameters[parameter(&simulator, "radius")],
                1.0 + E,
            ),
        ] {
            assert!(
                (found - expected).abs() < 1e-8,
                "{dt}, {name}: {found}, not {expected}"
            );
        }
    }
}

// x(T) = x₀ + T v + (1 + e) (|vₙ| T − d) n with d = n·x₀ − r: without friction, the derivative in x₀ is 1 − (1 + e) n nᵀ, and that in v is T times it.
#[test]
fn ball_on_an_inclined_plane_has_the_closed_form() {
    const E: f64 = 0.7;
    let angle: f64 = 0.4;
    let normal = Vector3::new(-angle.sin(), 0.0, angle.cos());
    for dt in [1e-3, 1e-2] {
        let simulator = ball(Terrain::incline(angle), 0.0, rigid(0.0, E)).with_time_step(dt);
        // The plane goes up along x, or down.
        let contacts = simulator.contacts().expect("contacts");
        let start = falling(&simulator, 0.6, 2.0);
        let (q, v) = (start.q.as_slice(), start.v.as_slice());
        let seen = contacts.states(simulator.model(), q, v)[0].normal;
        let normal = if seen.x * normal.x > 0.0 {
            normal
        } else {
            Vector3::new(-normal.x, 0.0, normal.z)
        };
        let (end, product) = chained(&simulator, &start, (0.5 / dt).round() as usize);
        let place = Vector3::new(0.0, 0.0, 0.6);
        let velocity = Vector3::new(0.0, 0.0, -2.0);
        let distance = normal.dot(&place) - RADIUS;
        let approach = -normal.dot(&velocity);
        let expected = place + velocity * 0.5 + normal * ((1.0 + E) * (0.5 * approach - distance));
        let found = Vector3::from_column_slice(&end.q.as_slice()[..3]);
        assert!(
            (found - expected).amax() < 1e-10,
            "{dt}: {found} {expected}"
        );
        let reflected = Matrix3::identity() - normal * normal.transpose() * (1.0 + E);
        let by_place = product.view((0, 0), (3, 3)) - reflected;
        let by_velocity = product.view((0, 6), (3, 3)) - reflected * 0.5;
        assert!(
            by_place.amax() < 1e-8 && by_velocity.amax() < 1e-8,
            "{dt}: {by_place} {by_velocity}"
        );
    }
}

/// Two balls of 1 kg and 0.15 m.
fn two_balls(restitution: f64) -> Simulator {
    let mut builder = ModelBuilder::new("balls").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("floor"));
    for name in ["a", "b"] {
        let link = LinkSpec::solid_sphere(name, 0.15, Mass::Kilograms(1.0));
        builder.add_link(link);
        let joint = JointSpec::new(format!("{name} free"), JointKind::Floating, "floor", name);
        builder.add_joint(joint);
    }
    let model = builder
        .build()
        .expect("balls")
        .with_gravity(Vector3::zeros());
    let law = rigid(0.0, restitution);
    let contacts = Contacts::new(&model, Terrain::flat(-5.0), law);
    let contacts = contacts
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("links");
    Simulator::new(model)
        .with_actuated_joints(&[])
        .expect("joints")
        .with_contacts(contacts)
}

// Equal masses and e = 1: the second ball goes on as the first one would, ahead by both radii, x₂(T) = x₁ + 2 r + v T.
#[test]
fn second_of_two_balls_has_the_closed_form() {
    for dt in [1e-3, 3.3e-3, 1e-2] {
        let simulator = two_balls(1.0).with_time_step(dt);
        let steps = (1.0 / dt).round() as usize;
        let time = dt * steps as f64;
        let mut start = simulator.neutral_state();
        (start.q[0], start.q[7], start.v[0]) = (-0.3, 0.5, 1.6);
        let (end, product) = chained(&simulator, &start, steps);
        let expected = -0.3 + 0.3 + 1.6 * time;
        assert!((end.q[7] - expected).abs() < 1e-10, "{dt}: {}", end.q[7]);
        assert!((end.q[0] - 0.2).abs() < 1e-10, "{dt}: {}", end.q[0]);
        let inputs = no_inputs(&simulator, steps);
        let found = simulator.rollout_gradient(&start, &inputs, &Coordinate(7));
        for (k, expected) in [(0, 1.0), (6, 0.0), (12, time), (18, 0.0)] {
            let by_chain = product[(6, k)];
            let by_rollout = found.start[k];
            assert!((by_chain - expected).abs() < 1e-8, "{dt}, {k}: {by_chain}");
            assert!(
                (by_rollout - expected).abs() < 1e-8,
                "{dt}, {k}: {by_rollout}"
            );
        }
    }
}

// It falls by z in t₁ = √(2 z / g), leaves with e g t₁, and is at e g t₁ s − g s² / 2 after s more: the derivative in z is (1 + e) s / t₁ − e. The error is of first order
// in the time step, as that of the flight is.
#[test]
fn ball_under_gravity_has_the_closed_form_within_the_order_of_the_integrator() {
    const G: f64 = 9.81;
    const E: f64 = 0.8;
    for dt in [1e-3, 3.3e-3, 1e-2] {
        let simulator = ball(Terrain::flat(0.0), G, rigid(0.5, E)).with_time_step(dt);
        for fall in [0.3, 0.3 + 0.4 * dt, 0.3 + 0.9 * dt] {
            let start = falling(&simulator, RADIUS + fall, 0.0);
            let steps = (0.5 / dt).round() as usize;
            let (end, product) = chained(&simulator, &start, steps);
            let lands = (2.0 * fall / G).sqrt();
            let rest = dt * steps as f64 - lands;
            let height = E * G * lands * rest - 0.5 * G * rest * rest;
            let slope = (1.0 + E) * rest / lands - E;
            assert!(
                (end.q[2] - RADIUS - height).abs() < 5.0 * dt,
                "{dt}: {}",
                end.q[2]
            );
            assert!(
                (product[(2, 2)] - slope).abs() < 20.0 * dt,
                "{dt}: {} {slope}",
                product[(2, 2)]
            );
        }
    }
}

// The velocity of a state is that of half a step ago, so that its energy differs from that of the motion by ½ g v Δt, up and down. Neither grows.
#[test]
fn energy_of_elastic_bounces_neither_grows_nor_falls() {
    const G: f64 = 9.81;
    for dt in [2e-3, 1e-2] {
        let simulator = ball(Terrain::flat(0.0), G, rigid(0.5, 1.0)).with_time_step(dt);
        let start = falling(&simulator, RADIUS + 0.5, 0.0);
        let model = simulator.model();
        let energy = |state: &State| {
            let (q, v) = (state.q.as_slice(), state.v.as_slice());
            kinetic_energy(model, q, v) + potential_energy(model, q)
        };
        let scale = G * (2.0 * G * 0.5_f64).sqrt() * dt;
        let rollout = simulator.rollout(&start, (30.0 / dt) as usize, |_, _, _| {});
        assert_eq!(rollout.solver_failure, None);
        let changes = rollout
            .states
            .iter()
            .map(|state| energy(state) - energy(&start));
        let largest = changes.fold(0.0, |largest: f64, x| largest.max(x.abs()));
        assert!(largest < 3.0 * scale, "{dt}: {largest} of {scale}");
    }
}

#[test]
fn bouncing_ball_comes_to_rest() {
    for dt in [1e-3, 1e-2] {
        for e in [0.3, 0.5, 0.8] {
            let simulator = ball(Terrain::flat(0.0), 9.81, rigid(0.5, e)).with_time_step(dt);
            let start = falling(&simulator, RADIUS + 0.2137, 0.0);
            let rollout = simulator.rollout(&start, (5.0 / dt) as usize, |_, _, _| {});
            let last = rollout.last();
            assert!(
                (last.q[2] - RADIUS).abs() < 1e-8,
                "{dt}, {e}: {}",
                last.q[2]
            );
            assert!(last.v.amax() < 1e-6, "{dt}, {e}: {}", last.v);
        }
    }
}

/// An arm of two links with a ball at its end, above the ground.
fn arm(integrator: Integrator) -> (Simulator, State) {
    let mut builder = ModelBuilder::new("arm").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("floor"));
    builder.add_link(LinkSpec::new("upper").with_mass(
        0.7,
        [0.2, 0.01, 0.02],
        [0.01, 0.012, 0.013],
    ));
    builder.add_link(LinkSpec::solid_sphere("hand", 0.08, Mass::Kilograms(0.5)));
    let shoulder = JointSpec::new("shoulder", JointKind::Revolute, "floor", "upper");
    builder.add_joint(shoulder.with_axis([0.0, 1.0, 0.0]).with_damping(0.05));
    let elbow = JointSpec::new("elbow", JointKind::Spherical, "upper", "hand");
    builder.add_joint(elbow.with_translation([0.4, 0.0, 0.0]));
    let model = builder.build().expect("an arm");
    let contacts = Contacts::new(&model, Terrain::incline(0.2), rigid(0.3, 0.6));
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(2e-3)
        .with_integrator(integrator);
    let mut start = simulator.neutral_state();
    (start.q[0], start.v[0]) = (-0.6, 1.0);
    start
        .v
        .rows_mut(1, 3)
        .copy_from(&Vector3::new(0.5, -2.0, 1.0));
    (simulator, start)
}

/// A weighted sum of all entries of the last state.
struct End;

impl RolloutCost for End {
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        let numbers = last.numbers().enumerate();
        numbers.fold(T::zero(), |sum, (k, &x)| sum + x * (k as f64 + 0.4).cos())
    }
}

fn differences(x: f64, f: impl Fn(f64) -> f64) -> f64 {
    let step = 1e-6 * (1.0 + x.abs());
    (f(x + step) - f(x - step)) / (2.0 * step)
}

// Through an impact with friction of an arm with damping, on a slope, in all entries of the start, the inputs, and all parameters.
#[test]
fn gradient_of_an_arm_that_hits_the_ground_equals_central_differences() {
    const STEPS: usize = 90;
    for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
        let (simulator, start) = arm(integrator);
        let rollout = simulator.rollout(&start, STEPS, |_, _, _| {});
        let jumps = rollout
            .states
            .windows(2)
            .filter(|pair| (pair[1].v[0] - pair[0].v[0]).abs() > 0.3);
        let bounces = jumps.count();
        assert_eq!(bounces, 1, "{integrator:?}");
        let inputs = no_inputs(&simulator, STEPS);
        let found = simulator.rollout_gradient(&start, &inputs, &End);
        let cost = |simulator: &Simulator, start: &State, inputs: &[DVector<f64>]| {
            let set = |k: usize, u: &mut [f64]| u.copy_from_slice(inputs[k].as_slice());
            let steps = 0..STEPS;
            let last = steps.fold(start.clone(), |state, k| {
                let mut u = vec![0.0; simulator.nu()];
                set(k, &mut u);
                simulator.step(&state, &u)
            });
            End.end(&last)
        };
        let close = |found: f64, by: f64| (found - by).abs() < 2e-5 * (1.0 + by.abs());
        let nv = simulator.model().nv();
        for k in 0..2 * nv {
            let by = differences(0.0, |x| {
                let mut dx = DVector::zeros(2 * nv);
                dx[k] = x;
                let mut moved = start.clone();
                moved.q = simulator
                    .model()
                    .integrate(start.q.as_slice(), dx.rows(0, nv).as_slice());
                moved.v += dx.rows(nv, nv);
                cost(&simulator, &moved, &inputs)
            });
            assert!(
                close(found.start[k], by),
                "{integrator:?}, start {k}: {} {by}",
                found.start[k]
            );
        }
        for step in [3, 40, 80] {
            for k in 0..simulator.nu() {
                let by = differences(0.0, |x| {
                    let mut moved = inputs.clone();
                    moved[step][k] = x;
                    cost(&simulator, &start, &moved)
                });
                assert!(
                    close(found.inputs[step][k], by),
                    "{integrator:?}, input {step} {k}: {} {by}",
                    found.inputs[step][k]
                );
            }
        }
        let p = simulator.parameters();
        for k in 0..p.len() {
            let by = differences(p[k], |x| {
                let mut moved = p.clone();
                moved[k] = x;
                cost(
                    &simulator.with_parameters(moved.as_slice()),
                    &start,
                    &inputs,
                )
            });
            let name = simulator.parameter_layout().names()[k].clone();
            assert!(
                close(found.parameters[k], by),
                "{integrator:?}, {name}: {} {by}",
                found.parameters[k]
            );
        }
    }
}

#[test]
fn jacobians_of_a_step_with_an_impact_equal_central_differences_and_its_gradients() {
    let (simulator, start) = arm(Integrator::SemiImplicitEuler);
    let rollout = simulator.rollout(&start, 90, |_, _, _| {});
    let jump = rollout
        .states
        .windows(2)
        .find(|pair| (pair[1].v[0] - pair[0].v[0]).abs() > 0.3);
    let before = &jump.expect("an impact")[0];
    let (n, nu) = (simulator.n_tangent(), simulator.nu());
    let u: Vec<f64> = (0..nu).map(|k| 0.1 * k as f64).collect();
    let exact = simulator.linearize(before, &u);
    let options = dualbody::autodiff::finite_difference::Options::default();
    let by = simulator.estimate_linearization(before, &u, &options);
    let far = (&exact.a - &by.linearization.a)
        .amax()
        .max((&exact.b - &by.linearization.b).amax());
    assert!(far < 1e-6, "{far}: {} {}", exact.a, by.linearization.a);
    for i in 0..n {
        let lambda: Vec<f64> = (0..n).map(|k| if k == i { 1.0 } else { 0.0 }).collect();
        let row = simulator.vjp(before, &u, &lambda);
        assert!((row.state.transpose() - exact.a.row(i)).amax() < 1e-12);
        assert!((row.input.transpose() - exact.b.row(i)).amax() < 1e-12);
    }
}

// Dual numbers through the step itself.
#[test]
fn steps_over_dual_numbers_have_the_derivatives_of_the_time_of_impact() {
    use dualbody::autodiff::Dual;
    let simulator = ball(Terrain::flat(0.0), 0.0, rigid(0.5, 0.6)).with_time_step(1e-2);
    let mut start = simulator.neutral_state::<Dual<f64, 2>>();
    start.q[2] = Dual::variable(1.0, 0);
    start.v[2] = Dual::variable(-2.0, 1);
    let end = simulator
        .rollout_over(&start, 100, |_, _, _| {})
        .last()
        .clone();
    let slopes = end.q[2].eps;
    assert!(
        (slopes[0] + 0.6).abs() < 1e-10 && (slopes[1] + 0.6).abs() < 1e-10,
        "{slopes:?}"
    );
}

#[test]
fn states_of_a_batch_are_those_of_single_simulators() {
    let simulator = ball(Terrain::flat(0.0), 9.81, rigid(0.5, 0.6)).with_time_step(1e-2);
    let starts: Vec<State> = (0..11)
        .map(|k| falling(&simulator, 0.2 + 0.031 * f64::from(k), 0.4))
        .collect();
    let mut batch = BatchSimulator::new(simulator.clone(), starts.len());
    let mut states = batch.states(&starts);
    for _ in 0..60 {
        batch.step(&mut states, &[]);
    }
    for (k, start) in starts.iter().enumerate() {
        let single = simulator.rollout(start, 60, |_, _, _| {});
        assert_eq!(&states.state(k), single.last());
    }
}

// Four corners at once are not an isolated impact: the box leaves at the end of the step in which it would land, with the speed of its contact model.
#[test]
fn box_that_lands_flat_bounces_in_whole_steps() {
    const E: f64 = 0.5;
    let mut builder = ModelBuilder::new("box");
    builder.add_link(LinkSpec::solid_box(
        "box",
        [0.4, 0.3, 0.2],
        Mass::Kilograms(1.0),
    ));
    let model = builder
        .build()
        .expect("a box")
        .with_gravity(Vector3::zeros());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), rigid(0.5, E));
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(1e-2);
    let start = falling(&simulator, 0.115, 2.0);
    let next = simulator.step(&start, &[]);
    assert!(
        (next.v[2] - 2.0 * E).abs() < 1e-9 && (next.q[2] - 0.125).abs() < 1e-9,
        "{} {}",
        next.v,
        next.q
    );
    assert!(next.v.rows(3, 3).amax() < 1e-9);
}

// A box that lands on one corner turns: that corner is alone, the next ones come in later steps, and no energy is gained.
#[test]
fn box_that_lands_on_a_corner_does_not_gain_energy() {
    let mut builder = ModelBuilder::new("box");
    builder.add_link(LinkSpec::solid_box(
        "box",
        [0.4, 0.3, 0.2],
        Mass::Kilograms(1.0),
    ));
    let model = builder.build().expect("a box");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), rigid(0.5, 0.4));
    for dt in [1e-3, 5e-3] {
        let simulator = Simulator::new(model.clone())
            .with_contacts(contacts.clone())
            .with_time_step(dt);
        let mut start = falling(&simulator, 0.6, 0.0);
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.4, 0.35, 0.2);
        for (k, x) in [turn.w, turn.i, turn.j, turn.k].into_iter().enumerate() {
            start.q[3 + k] = x;
        }
        let rollout = simulator.rollout(&start, (4.0 / dt) as usize, |_, _, _| {});
        let energy = |state: &State| {
            let (q, v) = (state.q.as_slice(), state.v.as_slice());
            kinetic_energy(&model, q, v) + potential_energy(&model, q)
        };
        let most = rollout.states.iter().map(energy).fold(f64::MIN, f64::max);
        assert!(
            most < energy(&start) * (1.0 + 10.0 * dt),
            "{dt}: {most} {}",
            energy(&start)
        );
        let last = rollout.last();
        assert!(last.v.amax() < 1e-3, "{dt}: {}", last.v);
        let corners = simulator.contacts().expect("contacts");
        let states = corners.states(&model, last.q.as_slice(), last.v.as_slice());
        assert!(states.iter().all(|corner| corner.depth < 1e-4));
    }
}
