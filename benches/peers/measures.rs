//! Measures of published comparisons of contact solvers: errors against the time step, under each contact model. `measures.py` prints those of `MuJoCo`.
//!
//! ```sh
//! cargo bench --bench measures && VENV/bin/python benches/peers/measures.py
//! ```
//!
//! By their descriptions in [Le Lidec, Jallet, Montaut, Laptev, Schmid, Carpentier 2024] (violations of Signorini's condition, of Coulomb's cone and of maximum dissipation) and
//! in `SimBenchmark` of ETH Zürich (sliding and rolling against closed forms, bouncing, penetration of a heap of balls, momentum and energy of a legged robot).

#[path = "../common/robots.rs"]
#[expect(dead_code, reason = "shared with other benches")]
mod robots;

use dualbody::contact::{CollisionOptions, ContactLaw, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::dynamics::{centroidal_momentum, kinetic_energy, potential_energy};
use dualbody::model::{Mass, Object, World};
use dualbody::sim::StepScratch;
use dualbody::spatial::Transform;
use dualbody::{Contacts, Integrator, Model, Simulator, State};
use nalgebra::Vector3;
use robots::asset;

/// Time steps, s.
const TIME_STEPS: [f64; 5] = [0.01, 0.005, 0.002, 0.001, 0.0005];
const GRAVITY: f64 = 9.81;
const FRICTION: f64 = 0.4;
/// Speed of the box and of the ball at the start, m/s.
const SPEED: f64 = 2.0;
/// Slip from which on a direction of friction is compared, m/s.
const SLIP: f64 = 1e-2;
/// Balls in a row of the heap.
const ROW: usize = 3;

type Row = (&'static str, ContactLaw, Integrator);

/// The contact models with the integrators that suit them; points of `soft` carry so much, kg.
fn rows(friction: f64, soft: f64) -> Vec<Row> {
    use Integrator::{ImplicitVelocity, RungeKutta4, SemiImplicitEuler};
    let rigid = ContactLaw::Rigid(Rigid {
        friction,
        ..Rigid::default()
    });
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid {
        friction,
        ..RelaxedRigid::default()
    });
    let soft = ContactLaw::Soft(SoftContact {
        friction,
        ..SoftContact::estimate(soft, 1, 1e-3)
    });
    vec![
        ("rigid, semi-implicit Euler", rigid, SemiImplicitEuler),
        ("rigid, implicit velocity", rigid, ImplicitVelocity),
        (
            "relaxed rigid, semi-implicit Euler",
            relaxed,
            SemiImplicitEuler,
        ),
        (
            "relaxed rigid, implicit velocity",
            relaxed,
            ImplicitVelocity,
        ),
        ("soft, implicit velocity", soft, ImplicitVelocity),
        ("soft, Runge–Kutta 4", soft, RungeKutta4),
    ]
}

fn main() {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let steps = if is_test {
        &TIME_STEPS[..1]
    } else {
        &TIME_STEPS[..]
    };
    let head: String = steps
        .iter()
        .map(|dt| format!(" {} ms |", dt * 1e3))
        .collect();
    println!("| measure | model, integrator |{head}");
    println!("|---|---|{}", "---|".repeat(steps.len()));
    let print = |measure: &str, name: &str, of: &dyn Fn(f64) -> f64| {
        let all: String = steps.iter().map(|&dt| cell(of(dt))).collect();
        println!("| {measure} | {name} |{all}");
    };
    for (k, measure) in SLIDING.iter().enumerate() {
        for (name, law, integrator) in rows(FRICTION, 0.25) {
            print(measure, name, &|dt| sliding_box(law, integrator, dt)[k]);
        }
    }
    for (name, law, integrator) in rows(FRICTION, 1.0) {
        print("rolling ball: speed", name, &|dt| {
            rolling_ball(law, integrator, dt)
        });
    }
    for (measure, restitution, k) in [
        (
            "ball bouncing with e = 0.8: height of the first bounce",
            0.8,
            0,
        ),
        ("elastic ball: energy after 5 s", 1.0, 1),
    ] {
        let law = ContactLaw::Rigid(Rigid {
            restitution,
            ..Rigid::default()
        });
        let integrator = Integrator::SemiImplicitEuler;
        print(measure, "rigid, semi-implicit Euler", &|dt| {
            bouncing_ball(law, integrator, dt)[k]
        });
    }
    for (name, law, integrator) in rows(0.0, 1.0) {
        print(
            "heap of 27 balls: mean penetration, in radii",
            name,
            &|dt| heap(law, integrator, dt),
        );
    }
    for (measure, k) in [
        ("quadruped in flight: momentum", 0),
        ("quadruped in flight: energy", 1),
    ] {
        for (name, integrator) in [
            ("semi-implicit Euler", Integrator::SemiImplicitEuler),
            ("implicit velocity", Integrator::ImplicitVelocity),
            ("Runge–Kutta 4", Integrator::RungeKutta4),
        ] {
            print(measure, name, &|dt| flight(integrator, dt)[k]);
        }
    }
}

/// A number of a table; what grows without bounds is none.
fn cell(x: f64) -> String {
    const DIVERGED: f64 = 1e3;
    if x.is_finite() && x < DIVERGED {
        format!(" {x:.1e} |")
    } else {
        " diverges |".to_owned()
    }
}

fn on_ground(model: Model, law: ContactLaw, integrator: Integrator, dt: f64) -> Simulator {
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    Simulator::new(model)
        .with_contacts(contacts)
        .with_integrator(integrator)
        .with_time_step(dt)
}

/// Steps without input, with what each leaves and leads to.
fn run(
    simulator: &Simulator,
    start: &State,
    duration: f64,
    mut each: impl FnMut(&State, &State),
) -> State {
    let (mut state, mut next) = (start.clone(), start.clone());
    let mut scratch = StepScratch::new(simulator);
    let inputs = vec![0.0; simulator.nu()];
    for _ in 0..(duration / simulator.time_step()).round() as usize {
        simulator.step_into(&state, &inputs, &mut scratch, &mut next);
        each(&state, &next);
        std::mem::swap(&mut state, &mut next);
    }
    state
}

const SLIDING: [&str; 5] = [
    "sliding box: stopping distance",
    "sliding box: Signorini, mean force × normal speed, W",
    "sliding box: force beyond the cone",
    "sliding box: angle to maximum dissipation, rad",
    "sliding box: penetration, mm",
];

/// A box that slides along the diagonal until it stops: distance against v² / (2 μ g), relative; and the worst violations on the way.
fn sliding_box(law: ContactLaw, integrator: Integrator, dt: f64) -> [f64; 5] {
    let simulator = on_ground(asset("box"), law, integrator, dt);
    let mut start = simulator.neutral_state();
    start.q[2] = 0.06;
    // At rest before it slides, so that soft ground carries it.
    let mut start = run(&simulator, &start, 0.5, |_, _| {});
    let from = [start.q[0], start.q[1]];
    let diagonal = std::f64::consts::FRAC_1_SQRT_2;
    (start.v[0], start.v[1]) = (SPEED * diagonal, SPEED * diagonal);
    let [mut signorini, mut cone, mut angle, mut depth] = [0.0_f64; 4];
    let mut n = 0;
    let end = run(&simulator, &start, 1.0, |state, next| {
        let (now, after) = (
            simulator.contact_report(state, &[]),
            simulator.contact_report(next, &[]),
        );
        for (point, (force, now)) in after.points.iter().zip(now.forces.iter().zip(&now.points)) {
            let (f, v) = (force, &point.velocity);
            let (push, drag) = (f.z, f.x.hypot(f.y));
            signorini += (push * v.z).abs();
            n += 1;
            depth = depth.max(now.depth);
            if push > 1e-6 {
                cone = cone.max(drag / (FRICTION * push) - 1.0);
            }
            if v.x.hypot(v.y) > SLIP && drag > 1e-6 {
                let [cos, sin] = [-(f.x * v.x + f.y * v.y), f.x * v.y - f.y * v.x];
                angle = angle.max(sin.atan2(cos).abs());
            }
        }
    });
    let distance = (end.q[0] - from[0]).hypot(end.q[1] - from[1]);
    let exact = SPEED * SPEED / (2.0 * FRICTION * GRAVITY);
    [
        (distance / exact - 1.0).abs(),
        signorini / f64::from(n),
        cone,
        angle,
        depth * 1e3,
    ]
}

/// A ball that slides until it rolls: its speed against 5/7 of that at the start, relative.
fn rolling_ball(law: ContactLaw, integrator: Integrator, dt: f64) -> f64 {
    let simulator = on_ground(asset("sphere"), law, integrator, dt);
    let mut start = simulator.neutral_state();
    start.q[2] = 0.1;
    let mut start = run(&simulator, &start, 0.5, |_, _| {});
    start.v[0] = SPEED;
    let end = run(&simulator, &start, 1.0, |_, _| {});
    let speed = (end.q[0], run(&simulator, &end, 0.1, |_, _| {}).q[0]);
    ((speed.1 - speed.0) / 0.1 / (SPEED * 5.0 / 7.0) - 1.0).abs()
}

/// A ball dropped from 1 m: the height of its first bounce against e², and its energy after 5 s against that at the start, relative.
fn bouncing_ball(law: ContactLaw, integrator: Integrator, dt: f64) -> [f64; 2] {
    let ContactLaw::Rigid(Rigid { restitution, .. }) = law else {
        return [f64::NAN; 2];
    };
    let simulator = on_ground(asset("sphere"), law, integrator, dt);
    let mut start = simulator.neutral_state();
    start.q[2] = 1.1;
    let (mut has_bounced, mut height, mut is_over) = (false, 0.0_f64, false);
    let end = run(&simulator, &start, 5.0, |state, next| {
        let is_bounce = state.v[2] < 0.0 && next.v[2] > 0.0;
        is_over |= has_bounced && is_bounce;
        has_bounced |= is_bounce;
        if has_bounced && !is_over {
            height = height.max(next.q[2] - 0.1);
        }
    });
    let energy = |state: &State| GRAVITY * (state.q[2] - 0.1) + 0.5 * state.v[2] * state.v[2];
    let bounce = (height / (restitution * restitution) - 1.0).abs();
    [bounce, (energy(&end) / energy(&start) - 1.0).abs()]
}

/// Balls in a cube, a little beside each other, that fall apart without friction and restitution: penetration of those that touch, in radii, on the mean over a second.
fn heap(law: ContactLaw, integrator: Integrator, dt: f64) -> f64 {
    const RADIUS: f64 = 0.1;
    let mut world = World::new("heap");
    for k in 0..ROW.pow(3) {
        let at = [k % ROW, k / ROW % ROW, k / (ROW * ROW)].map(|i| i as f64 * 2.1 * RADIUS);
        let beside = 1e-3 * (k % 7) as f64;
        let place = Vector3::new(at[0] + beside, at[1] - beside, at[2] + RADIUS);
        let object = Object::free(Mass::Kilograms(10.0)).at(Transform::from_translation(place));
        world
            .add_sphere(&format!("ball{k}"), RADIUS, &object)
            .expect("a ball");
    }
    let model = world.build().expect("a heap");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("balls");
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_integrator(integrator)
        .with_time_step(dt);
    let (mut sum, mut n) = (0.0, 0);
    run(&simulator, &simulator.neutral_state(), 1.0, |_, state| {
        let report = simulator.contact_report(state, &[]);
        let between = report.pairs.iter().map(|pair| pair.point.depth);
        let all = report.points.iter().map(|point| point.depth).chain(between);
        for depth in all.filter(|depth| *depth > 0.0) {
            sum += depth / RADIUS;
            n += 1;
        }
    });
    sum / f64::from(n.max(1))
}

/// A quadruped that tumbles with moving legs where nothing acts on it: change of its momentum and of its energy in a second, relative.
fn flight(integrator: Integrator, dt: f64) -> [f64; 2] {
    let model = asset("quadruped").with_gravity(Vector3::zeros());
    let damped = (6..model.nv()).fold(model, |model, k| model.with_damping(k, 0.0));
    let simulator = Simulator::new(damped)
        .with_integrator(integrator)
        .with_time_step(dt);
    let mut start = simulator.neutral_state();
    for (k, v) in start.v.iter_mut().enumerate() {
        *v = 2.0 * (1.7 * k as f64 + 0.3).sin();
    }
    let end = run(&simulator, &start, 1.0, |_, _| {});
    let model = simulator.model();
    let of = |state: &State| {
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        let momentum = centroidal_momentum(model, q, v);
        // About the centre of mass, the axes of the world.
        (
            momentum.to_array(),
            kinetic_energy(model, q, v) + potential_energy(model, q),
        )
    };
    let ((p, e), (p_end, e_end)) = (of(&start), of(&end));
    let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let change: Vec<f64> = p.iter().zip(&p_end).map(|(a, b)| a - b).collect();
    [norm(&change) / norm(&p), (e_end / e - 1.0).abs()]
}
