//! Makes the plots of the guide, and asserts what the guide says that they show.
//!
//! `cargo run --release --features plot --example guide_pictures -- guide/src/pictures` – without a folder, writes to
//! `out/guide/`.

use std::error::Error;
use std::path::PathBuf;

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::dynamics::kinetic_energy;
use dualbody::model::{LinkSpec, ModelBuilder, samples};
use dualbody::view::Plot;
use dualbody::{Integrator, Model, Simulator, State};

const INTEGRATORS: [(&str, Integrator); 4] = [
    ("semi-implicit Euler", Integrator::SemiImplicitEuler),
    ("implicit velocity", Integrator::ImplicitVelocity),
    ("Runge-Kutta 4", Integrator::RungeKutta4),
    ("implicit midpoint", Integrator::ImplicitMidpoint),
];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or("out/guide".into());
    for (name, plot) in [
        ("integrators", integrators()),
        ("tumbling", tumbling()?),
        ("contact_laws", contact_laws()?),
        ("creep", creep()?),
    ] {
        let path = PathBuf::from(&folder).join(name).with_extension("svg");
        plot.with_size(720, 360).save_svg(&path)?;
        println!("{}", path.display());
    }
    Ok(())
}

/// Error of a free double pendulum after half a second against the step, for each integrator.
fn integrators() -> Plot {
    const STEPS: [usize; 8] = [8, 16, 32, 64, 128, 256, 512, 1024];
    let at_end = |integrator, steps: usize| {
        let simulator = Simulator::new(samples::double_pendulum())
            .with_integrator(integrator)
            .with_time_step(0.5 / steps as f64);
        let start = State::new(&[1.0, 2.0], &[0.0; 2]);
        let rollout = simulator.rollout(&start, steps, |_, _, _| {});
        rollout.last().q.clone()
    };
    let exact = at_end(Integrator::RungeKutta4, 1 << 14);
    let mut plot = Plot::new("Double pendulum: error after half a second")
        .with_axes("step [s]", "error [rad]")
        .with_logarithmic_axes();
    for (name, integrator) in INTEGRATORS {
        let error = |steps: usize| (at_end(integrator, steps) - &exact).amax();
        let order = (error(128) / error(256)).log2();
        println!("{name}: order {order:.2}");
        let expected = match integrator {
            Integrator::RungeKutta4 => 4.0,
            Integrator::ImplicitMidpoint => 2.0,
            _ => 1.0,
        };
        assert!((order - expected).abs() < 0.2, "{name} of order {order}");
        plot = plot.with_line(name, STEPS.map(|n| (0.5 / n as f64, error(n))));
    }
    plot
}

/// Kinetic energy of a free body that tumbles at 20 rad/s, in steps of 10 ms.
fn tumbling() -> Result<Plot, Box<dyn Error>> {
    const DT: f64 = 0.01;
    let mut builder = ModelBuilder::new("body").with_gravity([0.0; 3]);
    builder.add_link(LinkSpec::new("body").with_mass(1.0, [0.0; 3], [0.1, 0.2, 0.25]));
    let model = builder.build()?;
    let mut plot = Plot::new("A free body that tumbles at 20 rad/s, steps of 10 ms")
        .with_axes("t [s]", "kinetic energy [J]");
    for (name, integrator) in INTEGRATORS {
        let simulator = Simulator::new(model.clone())
            .with_integrator(integrator)
            .with_time_step(DT);
        let start = State::new(
            model.neutral().as_slice(),
            &[0.0, 0.0, 0.0, 2.0, 20.0, 10.0],
        );
        let rollout = simulator.rollout(&start, 80, |_, _, _| {});
        let energy = |s: &State| kinetic_energy(&model, s.q.as_slice(), s.v.as_slice());
        let gain = energy(rollout.last()) / energy(&start) - 1.0;
        println!("{name}: energy changes by {gain:.1e} of itself in 0.8 s");
        let gains = integrator == Integrator::SemiImplicitEuler;
        assert_eq!(gain.abs() > 1e-2, gains, "{name} gains {gain}");
        let energies = rollout.times().zip(rollout.states.iter().map(energy));
        plot = plot.with_line(name, energies.collect::<Vec<_>>());
    }
    Ok(plot)
}

fn laws(friction: f64, points: usize) -> [(&'static str, ContactLaw); 3] {
    let soft = SoftContact::estimate(1.0, points, 2e-3);
    let (rigid, relaxed) = (Rigid::default(), RelaxedRigid::default());
    [
        ("rigid", ContactLaw::Rigid(Rigid { friction, ..rigid })),
        (
            "regularised",
            ContactLaw::RelaxedRigid(RelaxedRigid {
                friction,
                ..relaxed
            }),
        ),
        ("soft", ContactLaw::Soft(SoftContact { friction, ..soft })),
    ]
}

fn on(model: &Model, terrain: Terrain, law: ContactLaw, dt: f64) -> Simulator {
    let contacts = Contacts::new(model, terrain, law);
    Simulator::new(model.clone())
        .with_contacts(contacts)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(dt)
}

/// Height of a ball under each law with its defaults, around the moment in which it lands.
fn contact_laws() -> Result<Plot, Box<dyn Error>> {
    const DT: f64 = 1e-3;
    let ball = Model::from_urdf_file("assets/sphere.urdf")?;
    let mut plot = Plot::new("A ball of 1 kg lands at 0.6 m/s, steps of 1 ms")
        .with_axes("t [s]", "height of its lowest point [mm]");
    for (name, law) in laws(0.5, 1) {
        let simulator = on(&ball, Terrain::flat(0.0), law, DT);
        let mut start: State = simulator.neutral_state();
        start.q[2] = 0.12;
        let rollout = simulator.rollout(&start, 250, |_, _, _| {});
        let height = |s: &State| 1e3 * (s.q[2] - 0.1);
        let lowest = rollout.states.iter().map(height).fold(f64::MAX, f64::min);
        println!(
            "{name}: {:.2} mm deep at most, {:.2} mm in the end",
            -lowest,
            -height(rollout.last())
        );
        let heights = rollout.times().zip(rollout.states.iter().map(height));
        let shown = heights.filter(|(t, _)| *t >= 0.05);
        plot = plot.with_line(name, shown.collect::<Vec<_>>());
    }
    Ok(plot)
}

/// Draws the creep of a box that friction should hold on a slope.
fn creep() -> Result<Plot, Box<dyn Error>> {
    const ANGLE: f64 = 0.4;
    let model = Model::from_urdf_file("assets/box.urdf")?;
    let mut plot = Plot::new("A box on a slope of 0.4 rad with a friction of 1")
        .with_axes("t [s]", "distance down the slope [mm]");
    for (name, law) in laws(1.0, 4) {
        let simulator = on(&model, Terrain::incline(ANGLE), law, 2e-3);
        let (sin, cos) = (0.5 * ANGLE).sin_cos();
        let at = [-0.06 * ANGLE.sin(), 0.0, 0.06 * ANGLE.cos()];
        let q = [at[0], at[1], at[2], cos, 0.0, -sin, 0.0];
        let start: State = simulator.state(&q, &[0.0; 6]);
        let rollout = simulator.rollout(&start, 500, |_, _, _| {});
        let way =
            |s: &State| 1e3 * ((at[0] - s.q[0]) * ANGLE.cos() + (at[2] - s.q[2]) * ANGLE.sin());
        let speed = 2.0 * (way(rollout.last()) - way(&rollout.states[250]));
        println!("{name}: creeps at {speed:.3} mm/s");
        assert_eq!(speed > 1e-3, name == "regularised");
        let ways = rollout.times().zip(rollout.states.iter().map(way));
        plot = plot.with_line(name, ways.collect::<Vec<_>>());
    }
    Ok(plot)
}
