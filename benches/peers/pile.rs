//! Our side of the comparison of piles with `MuJoCo`: boxes and spheres in a bin, times of a step; `pile.py` runs it. And how a step grows with bodies.
//!
//! ```sh
//! pile scene BODIES                  # `sphere x y z` or `box x y z` of each body, m
//! pile times BODIES LAW STEPS LAST   # ms a step, of all and of so many last ones; LAW: relaxed or rigid
//! pile growth                        # ms a step of spheres that settle on the ground, and the exponent of growth
//! ```

#[path = "../common/mod.rs"]
mod common;

use std::time::Instant;

use common::clock::{arguments, is_test};
use dualbody::cone::Status;
use dualbody::contact::{CollisionOptions, ContactLaw, RelaxedRigid, Rigid, Terrain};
use dualbody::model::{Mass, Object, World};
use dualbody::sim::StepScratch;
use dualbody::spatial::Transform;
use dualbody::{Contacts, Simulator, State};

const TIME_STEP: f64 = 0.002;
/// Half width of a box and radius of a sphere, m; half width of the bin inside, height of its walls.
const HALF: f64 = 0.1;
const BIN: f64 = 0.6;
const HEIGHT: f64 = 1.0;
const WALL: f64 = 0.1;
/// Bodies in a row, and rows in a layer, and their distance.
const ROW: usize = 5;
const APART: f64 = 0.235;
/// Sizes and steps of the measurement of growth.
const SIZES: [usize; 3] = [100, 300, 1000];
const STEPS: usize = 200;

fn main() {
    let arguments = arguments();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let number = |k: usize| -> usize { arguments[k].parse().expect("a number") };
    match arguments[..] {
        [] if is_test() => {
            print_times(10, "relaxed", 3, 1);
            print_growth(&[4, 9], 3);
        }
        ["scene", _] => print_scene(number(1)),
        ["times", _, law, _, _] => print_times(number(1), law, number(3), number(4)),
        ["growth"] => print_growth(&SIZES, STEPS),
        _ => println!("usage: see benches/peers/pile.py"),
    }
}

/// Where a body starts: in layers, each a little beside those below, so that they tumble.
fn place(k: usize) -> [f64; 3] {
    let (i, j, layer) = (k % ROW, k / ROW % ROW, k / (ROW * ROW));
    let middle = (ROW - 1) as f64 / 2.0;
    let along = |i: usize, by: usize| APART * (i as f64 - middle) + 0.004 * (k % by) as f64 - 0.01;
    [along(i, 7), along(j, 5), 0.15 + 0.25 * layer as f64]
}

fn is_box(k: usize) -> bool {
    k % 2 == 1
}

fn print_scene(bodies: usize) {
    for k in 0..bodies {
        let ([x, y, z], kind) = (place(k), if is_box(k) { "box" } else { "sphere" });
        println!("{kind} {x} {y} {z}");
    }
}

fn at([x, y, z]: [f64; 3]) -> Transform<f64> {
    Transform::from_translation([x, y, z].into())
}

fn bin(bodies: usize) -> World {
    let mut world = World::default();
    let (out, long) = (BIN + WALL / 2.0, 2.0 * (BIN + WALL));
    let walls = [
        ("left", [-out, 0.0], [WALL, long, HEIGHT]),
        ("right", [out, 0.0], [WALL, long, HEIGHT]),
        ("front", [0.0, -out], [long, WALL, HEIGHT]),
        ("back", [0.0, out], [long, WALL, HEIGHT]),
    ];
    for (name, [x, y], size) in walls {
        let object = Object::fixed().at(at([x, y, HEIGHT / 2.0]));
        world.add_box(name, size, &object).expect("a wall");
    }
    for k in 0..bodies {
        let object = Object::free(Mass::Kilograms(1.0)).at(at(place(k)));
        let name = format!("body {k:04}");
        let added = match is_box(k) {
            true => world.add_box(&name, [2.0 * HALF; 3], &object),
            false => world.add_sphere(&name, HALF, &object),
        };
        added.expect("a body");
    }
    world
}

/// Spheres beside each other, a little above the ground.
fn spheres(bodies: usize) -> World {
    let mut world = World::default();
    let side = (bodies as f64).sqrt().ceil() as usize;
    for k in 0..bodies {
        let (x, y) = (0.3 * (k % side) as f64, 0.3 * (k / side) as f64);
        let object =
            Object::free(Mass::Kilograms(1.0)).at(at([x, y, HALF + 1e-3 * (k % 13) as f64]));
        let name = format!("ball {k:04}");
        world.add_sphere(&name, HALF, &object).expect("a ball");
    }
    world
}

fn simulator(world: &World, law: ContactLaw) -> Simulator {
    let model = world.build().expect("a world");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("links");
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(TIME_STEP)
}

/// A run of a simulator.
struct Run {
    /// Seconds of each step.
    times: Vec<f64>,
    worst: Status,
    last: State,
}

fn run(simulator: &Simulator, steps: usize) -> Run {
    let mut scratch = StepScratch::<f64>::new(simulator);
    let (mut state, mut next) = (simulator.neutral_state(), simulator.neutral_state());
    let (mut times, mut worst) = (Vec::with_capacity(steps), Status::Converged);
    for _ in 0..steps {
        let start = Instant::now();
        simulator.step_into(&state, &[], &mut scratch, &mut next);
        times.push(start.elapsed().as_secs_f64());
        std::mem::swap(&mut state, &mut next);
        worst = worst.max(scratch.solver_status(0));
    }
    let last = state;
    Run { times, worst, last }
}

fn mean(times: &[f64]) -> f64 {
    1e3 * times.iter().sum::<f64>() / times.len() as f64
}

fn print_times(bodies: usize, law: &str, steps: usize, last: usize) {
    let law = match law {
        "rigid" => ContactLaw::Rigid(Rigid::default()),
        _ => ContactLaw::RelaxedRigid(RelaxedRigid::default()),
    };
    let simulator = simulator(&bin(bodies), law);
    let run = run(&simulator, steps);
    let report = simulator.contact_report(&run.last, &[]);
    let ground = report.forces.iter().filter(|f| f.norm() > 0.0).count();
    println!("points {}", ground + report.pairs.len());
    println!("status {:?}", run.worst);
    println!("speed {:.3}", run.last.v.amax());
    println!("all {:.6}", mean(&run.times));
    println!("last {:.6}", mean(&run.times[steps - last..]));
}

fn print_growth(sizes: &[usize], steps: usize) {
    for (name, law) in [
        ("relaxed", ContactLaw::RelaxedRigid(RelaxedRigid::default())),
        ("rigid", ContactLaw::Rigid(Rigid::default())),
    ] {
        let times = sizes.iter().map(|&bodies| {
            let run = run(&simulator(&spheres(bodies), law), steps);
            assert_eq!(run.worst, Status::Converged);
            let time = mean(&run.times);
            println!("{name} {bodies} spheres: {time:.4} ms a step");
            time
        });
        let times: Vec<f64> = times.collect();
        let (first, last) = (0, sizes.len() - 1);
        let by = sizes[last] as f64 / sizes[first] as f64;
        let exponent = (times[last] / times[first]).ln() / by.ln();
        println!("{name} exponent {exponent:.2}");
    }
}
