//! Resting islands that sleep: where they rest, what wakes them, and what ignores it.

use std::f64::consts::PI;
use std::panic::{AssertUnwindSafe, catch_unwind};

use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{
    CollisionOptions, ContactLaw, Contacts, RelaxedRigid, Rigid, SoftContact, Terrain,
};
use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::linearize::RolloutCost;
use dualbody::model::{Mass, Object, World, samples};
use dualbody::sim::{BatchSimulator, ExternalForce, Sleeping, StepScratch};
use dualbody::spatial::{Force, Representation, Transform};
use dualbody::trajopt::Robot as _;
use dualbody::{Cast, Integrator, Lanes, Scalar, Simulator, State};
use nalgebra::{DVector, Vector3};

const DT: f64 = 2e-3;
/// Sleep after a short rest, so that tests are short.
const SOON: Sleeping = Sleeping {
    speed: 1e-3,
    time: 0.05,
};

fn at(x: f64, y: f64, z: f64) -> Transform<f64> {
    Transform::from_translation([x, y, z].into())
}

fn rigid() -> ContactLaw {
    ContactLaw::Rigid(Rigid::default())
}

fn simulator(world: &World, law: ContactLaw) -> Simulator {
    let model = world.build().expect("a world");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("links");
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(DT)
}

fn object(x: f64, y: f64, z: f64) -> Object {
    Object::free(Mass::Kilograms(1.0)).at(at(x, y, z))
}

/// Boxes of 0.2 m on each other, and balls of 0.1 m at some places.
fn tower(boxes: usize, balls: &[[f64; 3]]) -> World {
    let mut world = World::default();
    for k in 0..boxes {
        let place = object(0.0, 0.0, 0.1 + 0.2 * k as f64);
        let name = format!("tower/box {k}");
        world.add_box(&name, [0.2; 3], &place).expect("a box");
    }
    for (k, &[x, y, z]) in balls.iter().enumerate() {
        let name = format!("ball {k}");
        world
            .add_sphere(&name, 0.1, &object(x, y, z))
            .expect("a ball");
    }
    world
}

/// The state after so many steps.
fn after(simulator: &Simulator, state: &State, steps: usize) -> State {
    let rollout = simulator.rollout(state, steps, |_, _, _| {});
    assert_eq!(rollout.inputs.len(), steps, "{:?}", rollout.status);
    rollout.last().clone()
}

/// The state where all of it sleeps, within 2 s.
fn asleep(simulator: &Simulator) -> State {
    let rollout = simulator.rollout(&simulator.neutral_state(), 1000, |_, _, _| {});
    let links = simulator.asleep(rollout.last()).len();
    let moving = simulator.model().bodies().len();
    assert_eq!(links, moving, "of {moving} bodies");
    rollout.last().clone()
}

/// The same configuration and velocity, awake.
fn awake(simulator: &Simulator, state: &State) -> State {
    let all = simulator.state(state.q.as_slice(), state.v.as_slice());
    all.with_contact(state.contact.clone())
}

fn same_motion(a: &State, b: &State) -> bool {
    a.q == b.q && a.v == b.v && a.contact == b.contact
}

fn free_v(simulator: &Simulator, name: &str) -> usize {
    let joint = simulator.model().find_joint(name).expect("an object");
    simulator.model().joint_v(joint).start
}

fn free_q(simulator: &Simulator, name: &str) -> usize {
    let joint = simulator.model().find_joint(name).expect("an object");
    simulator.model().joint_q(joint).start
}

fn energy(simulator: &Simulator, state: &State) -> f64 {
    let (model, q) = (simulator.model(), state.q.as_slice());
    kinetic_energy(model, q, state.v.as_slice()) + potential_energy(model, q)
}

// Boxes that fall on each other: bit by bit as without sleep until the first island sleeps; then nothing moves, and where they rest
// differs by less than speed · time.
#[test]
fn a_poured_pile_sleeps_where_it_rests_without_sleep() {
    let mut world = World::default();
    for k in 0..8 {
        let x = 0.32 * (k % 2) as f64 + 0.02 * (k / 2) as f64;
        let place = object(x, 0.03 * (k % 3) as f64, 0.15 + 0.22 * (k / 2) as f64);
        let size = [0.3, 0.3 - 0.02 * (k % 4) as f64, 0.15];
        world
            .add_box(&format!("body {k}"), size, &place)
            .expect("a box");
    }
    let plain = simulator(&world, rigid());
    let sleepy = plain.clone().with_sleeping(SOON);
    let (mut scratch, mut own) = (StepScratch::new(&plain), StepScratch::new(&sleepy));
    let (mut a, mut b) = (plain.neutral_state(), sleepy.neutral_state());
    let (mut next_a, mut next_b) = (a.clone(), b.clone());
    let mut before = f64::INFINITY;
    let mut some = false;
    for step in 0..2000 {
        plain.step_into(&a, &[], &mut scratch, &mut next_a);
        sleepy.step_into(&b, &[], &mut own, &mut next_b);
        std::mem::swap(&mut a, &mut next_a);
        std::mem::swap(&mut b, &mut next_b);
        let count = sleepy.asleep(&b).len();
        some |= count > 0;
        assert!(some || same_motion(&a, &b), "step {step}");
        if count > 0 {
            let now = energy(&sleepy, &b);
            assert!(now <= before + 1e-6, "step {step}: {now} J of {before} J");
            before = now;
        }
    }
    assert_eq!(sleepy.asleep(&b).len(), 8);
    let apart = (&a.q - &b.q).amax();
    assert!(apart < SOON.speed * SOON.time, "{apart}");
    // Asleep, a step is the identity.
    assert_eq!(sleepy.step(&b, &[]), b);
    assert!(b.v.iter().all(|v| *v == 0.0));
}

// A ball flies for 0.2 s to a sleeping tower. In the step in which it arrives the tower wakes as a whole, and moves as one that never slept.
#[test]
fn a_thrown_ball_wakes_a_tower_which_then_moves_as_one_that_never_slept() {
    let plain = simulator(&tower(4, &[[-1.0, 0.0, 0.1]]), rigid());
    let sleepy = plain.clone().with_sleeping(SOON);
    let mut state = asleep(&sleepy);
    let (first, z) = (free_v(&sleepy, "ball 0"), free_q(&sleepy, "ball 0") + 2);
    state.q[z] = 0.6;
    state.v[first] = 4.0;
    let names = ["tower/box 0", "tower/box 1", "tower/box 2", "tower/box 3"];
    let rest = state.clone();
    assert_eq!(sleepy.asleep(&state), names);
    let mut steps = 0;
    loop {
        let next = sleepy.step(&state, &[]);
        if sleepy.asleep(&next).is_empty() {
            break;
        }
        assert_eq!(sleepy.asleep(&next), names);
        let moved = (0..next.q.len()).filter(|&i| next.q[i] != rest.q[i]);
        let ball = z - 2..z + 5;
        assert!({ moved }.all(|i| ball.contains(&i)), "the tower moves");
        (state, steps) = (next, steps + 1);
    }
    assert!((80..120).contains(&steps), "{steps} steps of flight");
    let (mut slept, mut never) = (state.clone(), awake(&plain, &state));
    // As long as nothing could fall asleep again.
    for step in 0..20 {
        (slept, never) = (sleepy.step(&slept, &[]), plain.step(&never, &[]));
        assert!(same_motion(&slept, &never), "step {step}");
    }
    assert!(slept.v.amax() > 0.1, "the tower is hit");
}

// Without its lowest box, by hand or as a world of fewer objects, a tower falls: 5 g t² = 0.2 m after 0.2 s.
#[test]
fn a_tower_falls_without_its_lowest_box() {
    let sleepy = simulator(&tower(3, &[]), rigid()).with_sleeping(SOON);
    let rest = asleep(&sleepy);
    let (low, top) = (
        free_q(&sleepy, "tower/box 0"),
        free_q(&sleepy, "tower/box 2"),
    );
    let mut moved = rest.clone();
    moved.q[low] += 3.0;
    assert!(sleepy.asleep(&moved).is_empty(), "one changes, all wake");
    let fallen = after(&sleepy, &moved, 60);
    assert!(fallen.q[top + 2] < rest.q[top + 2] - 0.06);

    let mut world = tower(3, &[]);
    world.remove("tower/box 0").expect("a member");
    let fewer = simulator(&world, rigid()).with_sleeping(SOON);
    let carried = fewer.carried_state(&sleepy, &rest).expect("a state");
    assert!(fewer.asleep(&carried).is_empty());
    let fallen = after(&fewer, &carried, 60);
    let top = free_q(&fewer, "tower/box 2");
    assert!(fallen.q[top + 2] < rest.q[free_q(&sleepy, "tower/box 2") + 2] - 0.06);
    // With another object nothing sleeps, and all falls asleep anew.
    let more = simulator(&tower(3, &[[1.0, 1.0, 0.1]]), rigid()).with_sleeping(SOON);
    let carried = more.carried_state(&sleepy, &rest).expect("a state");
    assert!(more.asleep(&carried).is_empty());
    assert_eq!(more.asleep(&after(&more, &carried, 100)).len(), 4);
}

// Any change of q or v, in the last bit, wakes; numbers from elsewhere that are none of a sleeper count as awake.
#[test]
fn changed_and_strange_states_are_awake() {
    let plain = simulator(&tower(2, &[]), rigid());
    let sleepy = plain.clone().with_sleeping(SOON);
    let rest = asleep(&sleepy);
    for i in 0..rest.q.len() {
        let mut state = rest.clone();
        state.q[i] = state.q[i].next_up();
        assert!(sleepy.asleep(&state).is_empty(), "q[{i}]");
    }
    for i in 0..rest.v.len() {
        let mut state = rest.clone();
        state.v[i] = f64::MIN_POSITIVE;
        assert!(sleepy.asleep(&state).is_empty(), "v[{i}]");
        let (next, never) = (
            sleepy.step(&state, &[]),
            plain.step(&awake(&plain, &state), &[]),
        );
        assert!(same_motion(&next, &never));
    }
    for strange in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.5, -7.0] {
        let mut state = rest.clone();
        state.sleep.fill(strange);
        let next = sleepy.step(&state, &[]);
        assert!(sleepy.asleep(&state).is_empty(), "{strange}");
        assert!(same_motion(&next, &plain.step(&awake(&plain, &rest), &[])));
    }
    // No numbers at all: awake too, and the next state has them.
    let bare = State::new(rest.q.as_slice(), rest.v.as_slice());
    let next = sleepy.step(&bare, &[]);
    assert_eq!(next.sleep.len(), sleepy.n_sleep());
}

// At the top of its throw v is 0 to rounding, after 10 steps of 2 ms; a time of 0 must not stop it there.
#[test]
fn a_ball_at_the_top_of_its_throw_is_not_at_rest() {
    let sleeping = Sleeping {
        speed: 1e-2,
        time: 0.0,
    };
    let sleepy = simulator(&tower(0, &[[0.0, 0.0, 1.0]]), rigid()).with_sleeping(sleeping);
    let mut state = sleepy.neutral_state();
    state.v[2] = 9.81 * 10.0 * DT;
    let mut slowest = f64::INFINITY;
    // From where it was added, 1 m above the ground.
    while state.q[2] > -0.85 {
        state = sleepy.step(&state, &[]);
        slowest = slowest.min(state.v[2].abs());
        assert!(sleepy.asleep(&state).is_empty());
    }
    assert!(slowest < 1e-12);
    let landed = after(&sleepy, &state, 100);
    assert_eq!(sleepy.asleep(&landed), ["ball 0"]);
}

fn pendulum(passive: bool) -> Simulator {
    let plain = Simulator::new(samples::pendulum());
    let plain = match passive {
        true => plain.with_actuated_joints(&[]).expect("no names"),
        false => plain,
    };
    plain.with_time_step(DT).with_sleeping(SOON)
}

// An unstable equilibrium counts as rest; a joint with an input does not sleep.
#[test]
fn a_pendulum_at_rest_sleeps_if_it_has_no_input() {
    let free = pendulum(true);
    let rest = after(&free, &free.state(&[PI], &[0.0]), 100);
    assert_eq!(free.asleep(&rest), ["rod"]);
    assert!((rest.q[0] - PI).abs() < SOON.speed * SOON.time);
    let pushed = State {
        v: DVector::from_element(1, 1e-12),
        ..rest.clone()
    };
    assert!(free.asleep(&pushed).is_empty());
    let driven = pendulum(false);
    let rest = driven.rollout(&driven.state(&[0.0], &[0.0]), 100, |_, _, _| {});
    assert!(driven.asleep(rest.last()).is_empty());
}

// A block creeps down a slope of 10° by the compliance of regularised friction: faster than the threshold it never sleeps, with the same bits; slower it
// stops.
#[test]
fn creep_below_the_threshold_stops_and_above_it_does_not() {
    let mut world = World::default();
    let place = Transform::from_translation([0.0, 0.0, 0.0].into());
    world
        .add_box(
            "block",
            [0.4, 0.4, 0.2],
            &Object::free(Mass::Kilograms(1.0)).at(place),
        )
        .expect("a block");
    let model = world.build().expect("a world");
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let angle = 10f64.to_radians();
    let contacts = Contacts::new(&model, Terrain::incline(angle), law);
    let plain = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(DT);
    let mut start = plain.neutral_state();
    let (sin, cos) = (0.5 * angle).sin_cos();
    let normal = Vector3::new(-angle.sin(), 0.0, angle.cos()) * 0.1;
    start.q.rows_mut(0, 3).copy_from(&normal);
    start
        .q
        .rows_mut(3, 4)
        .copy_from_slice(&[cos, 0.0, -sin, 0.0]);
    let settled = after(&plain, &start, 1000);
    let creep = settled.v.amax();
    assert!(creep > 1e-9, "it creeps at {creep} m/s");
    let with = |speed: f64| plain.clone().with_sleeping(Sleeping { speed, time: 0.05 });
    let (slow, fast) = (with(0.1 * creep), with(10.0 * creep));
    let creeps = after(
        &slow,
        &slow.state(settled.q.as_slice(), settled.v.as_slice()),
        200,
    );
    assert!(slow.asleep(&creeps).is_empty());
    assert!(same_motion(&creeps, &after(&plain, &settled, 200)));
    let stops = after(
        &fast,
        &fast.state(settled.q.as_slice(), settled.v.as_slice()),
        200,
    );
    assert_eq!(fast.asleep(&stops), ["block"]);
    let apart = (&stops.q - &creeps.q).amax();
    assert!(apart > 0.0 && apart < 1.1 * creep * 200.0 * DT, "{apart}");
}

// Two balls side by side, apart by less than gravity moves them in a step, of which one lands later: neither keeps the other awake, nor wakes it in turn.
#[test]
fn neighbours_that_nearly_touch_fall_asleep_together() {
    let gap = 0.5 * 9.81 * DT * DT;
    let world = tower(0, &[[0.0, 0.0, 0.1], [0.2 + gap, 0.0, 0.104]]);
    let sleepy = simulator(&world, rigid()).with_sleeping(SOON);
    let rollout = sleepy.rollout(&sleepy.neutral_state(), 200, |_, _, _| {});
    let counts = rollout
        .states
        .iter()
        .map(|state| sleepy.asleep(state).len());
    let counts: Vec<usize> = counts.collect();
    let first = counts.iter().position(|&n| n > 0).expect("some sleep");
    assert!(counts[first..].iter().all(|&n| n == 2), "{counts:?}");
}

// Bristles of soft contact stay with what sleeps, and a change of one wakes it.
#[test]
fn soft_contact_sleeps_with_its_bristles() {
    let world = tower(1, &[[1.0, 0.0, 0.1]]);
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
    let model = world.build().expect("a world");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let plain = Simulator::new(model)
        .with_contacts(contacts)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(DT);
    let sleepy = plain.clone().with_sleeping(SOON);
    let mut start = sleepy.neutral_state();
    start.v[free_v(&sleepy, "tower/box 0")] = 0.05;
    let rest = after(&sleepy, &start, 1000);
    assert_eq!(sleepy.asleep(&rest).len(), 2);
    assert!(rest.contact.amax() > 0.0);
    assert_eq!(after(&sleepy, &rest, 5), rest);
    let used = rest.contact.iamax();
    let mut bent = rest.clone();
    bent.contact[used] += 1e-12;
    assert_eq!(sleepy.asleep(&bent).len(), 1);
}

// A ball is tied to a box by a rod of 2 m: while it rolls about the box, the box stays awake with it. At rest, both sleep.
#[test]
fn trees_tied_by_a_constraint_sleep_together_only() {
    let world = tower(1, &[[2.0, 0.0, 0.1]]);
    let build = |push: f64| {
        let base = simulator(&world, rigid());
        let anchor = |name: &str| Anchor::frame(base.model(), name).expect("a link");
        let rod = Constraint::distance([anchor("tower/box 0"), anchor("ball 0")], 2.0);
        let sleepy = base.clone().with_constraints(vec![rod]).with_sleeping(SOON);
        let mut start = sleepy.neutral_state();
        // Across the rod: the ball rolls on the ground.
        let first = free_v(&sleepy, "ball 0");
        start.v[first + 1] = push;
        start.v[first + 3] = -push / 0.1;
        (after(&sleepy, &start, 100), sleepy)
    };
    let (state, sleepy) = build(0.0);
    assert_eq!(sleepy.asleep(&state).len(), 2);
    let (state, sleepy) = build(0.2);
    assert!(sleepy.asleep(&state).is_empty());
}

// Friction holds a box against 1 N from the side: at rest, but awake.
#[test]
fn external_forces_keep_trees_awake() {
    let plain = simulator(&tower(1, &[[1.0, 0.0, 0.1]]), rigid());
    let place = Anchor::frame(plain.model(), "tower/box 0").expect("a link");
    let push = Force::new(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros());
    let push = ExternalForce::constant(place, push, Representation::Mixed);
    let sleepy = plain.clone().with_sleeping(SOON);
    let pushed = sleepy.clone().with_external_forces(vec![push]);
    let rest = asleep(&sleepy);
    // The same state, in a simulator with the force.
    assert_eq!(pushed.asleep(&rest), ["ball 0"]);
    let state = after(&pushed, &pushed.neutral_state(), 200);
    assert_eq!(pushed.asleep(&state), ["ball 0"]);
}

struct Height;

impl RolloutCost for Height {
    fn end<T: Scalar>(&self, state: &State<T>) -> T {
        state.q.iter().fold(T::zero(), |sum, &q| sum + q * q)
    }
}

// Derivatives, other scalars and planning take the step awake, from the same state.
#[test]
fn derivatives_and_other_scalars_ignore_sleep() {
    let plain = simulator(&tower(2, &[]), rigid());
    let sleepy = plain.clone().with_sleeping(SOON);
    let rest = asleep(&sleepy);
    let same = awake(&plain, &rest);
    let (a, b) = (sleepy.linearize(&rest, &[]), plain.linearize(&same, &[]));
    assert!(a.a == b.a && a.b == b.b);
    let weights = vec![1.0; plain.n_tangent()];
    assert_eq!(sleepy.n_tangent(), plain.n_tangent());
    let (a, b) = (
        sleepy.vjp(&rest, &[], &weights),
        plain.vjp(&same, &[], &weights),
    );
    assert!(a.state == b.state && a.parameters == b.parameters);
    let inputs = vec![DVector::zeros(0); 5];
    let (a, b) = (
        sleepy.rollout_gradient(&rest, &inputs, &Height),
        plain.rollout_gradient(&same, &inputs, &Height),
    );
    assert_eq!((a.cost, a.start), (b.cost, b.start));
    let lanes = rest.cast::<Lanes<2>>();
    let (a, b) = (
        sleepy.step(&lanes, &[]),
        plain.step(&same.cast::<Lanes<2>>(), &[]),
    );
    assert!(a.q == b.q && a.v == b.v);
    assert!(a.sleep.iter().all(|x| x.0 == [0.0; 2]));
    let x = sleepy.pack(&rest);
    assert_eq!(sleepy.unpack(x.as_slice()).q, rest.q);
}

// Batches sleep as single states do, by any number of threads; a state that is set is as awake as it says.
#[test]
fn batches_sleep_as_single_states_do() {
    let sleepy = simulator(&tower(1, &[[1.0, 0.0, 0.12]]), rigid()).with_sleeping(SOON);
    let starts: Vec<State> = (0..9)
        .map(|k| {
            let mut state = sleepy.neutral_state();
            state.q[2] += 1e-3 * f64::from(k);
            state
        })
        .collect();
    let singles: Vec<State> = starts.iter().map(|s| after(&sleepy, s, 100)).collect();
    assert!(singles.iter().any(|s| !sleepy.asleep(s).is_empty()));
    for threads in [1, 2] {
        let mut batch = BatchSimulator::new(sleepy.clone(), 9).with_threads(threads);
        let mut states = batch.states(&starts);
        batch.step_times(&mut states, &[], 100);
        assert_eq!(states.to_vec(), singles, "{threads} threads");
        states.set(
            0,
            &State::new(singles[0].q.as_slice(), singles[0].v.as_slice()),
        );
        assert!(sleepy.asleep(&states.state(0)).is_empty());
        assert_eq!(states.state(1), singles[1]);
    }
}

#[test]
fn thresholds_out_of_range_are_refused_and_zero_is_not() {
    let message = |speed: f64, time: f64| {
        let plain = pendulum(true);
        let made = catch_unwind(AssertUnwindSafe(|| {
            plain.with_sleeping(Sleeping { speed, time })
        }));
        made.err().and_then(|e| e.downcast::<String>().ok())
    };
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        for (speed, time) in [(bad, 0.1), (0.1, bad)] {
            let text = message(speed, time).expect("refused");
            let number = format!("{bad}");
            assert!(
                text.contains(&number) && text.contains("islands sleep"),
                "{text}"
            );
        }
    }
    // Zeros: what does not move at all sleeps after one step.
    let still = pendulum(true).with_sleeping(Sleeping {
        speed: 0.0,
        time: 0.0,
    });
    let next = still.step(&still.state(&[0.0], &[0.0]), &[]);
    assert_eq!(still.asleep(&next), ["rod"]);
    let none = still.clone().with_sleeping(None);
    assert!(none.n_sleep() == 0 && none.asleep(&none.neutral_state()).is_empty());
}

// MJCF has sleep as an option of the file: 2 mm/s, and ten steps of 5 ms.
#[cfg(feature = "formats")]
#[test]
fn sleep_of_mjcf_files_is_read() {
    let read = |option: &str| {
        let xml = format!(
            r#"<mujoco><option timestep="0.005" {option}</option><worldbody><geom type="plane" size="1 1 1"/>
            <body name="crate" pos="0 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body></worldbody></mujoco>"#
        );
        dualbody::ModelOptions::default().load_mjcf_scene_str(&xml)
    };
    let sleepy = r#"sleep_tolerance="0.002"><flag sleep="enable"/>"#;
    let (scene, _) = read(sleepy).expect("a scene");
    let sleeping = Sleeping {
        speed: 0.002,
        time: 10.0 * 0.005,
    };
    let simulator = scene.simulator();
    assert_eq!(simulator.sleeping(), Some(&sleeping));
    let rest = after(&simulator, &scene.reference, 400);
    assert_eq!(simulator.asleep(&rest), ["crate"]);
    let (awake, _) = read(r#"sleep_tolerance="0.002">"#).expect("a scene");
    assert_eq!(awake.simulator().sleeping(), None);
    let error = read(r#"sleep_tolerance="-1"><flag sleep="enable"/>"#).unwrap_err();
    assert!(error.to_string().contains("sleep_tolerance"), "{error}");
}
