//! `<option>`: time step, gravity, method.

use super::entry::Entry;
use super::scene::MjcfOptions;
use super::tree::Node;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::model::DEFAULT_GRAVITY;
use crate::sim::{Integrator, Sleeping};

/// Default step, s.
const TIME_STEP: f64 = 0.002;

/// Default magnetic field.
const MAGNETIC: [f64; 3] = [0.0, -0.5, 0.0];

/// Default speed of bodies that sleep, m/s, and the steps at rest after which they do: `sleep_tolerance` and `mjMINAWAKE` there, version 4.0.
const SLEEP_SPEED: f64 = 1e-3;
const SLEEP_STEPS: f64 = 10.0;

/// Methods, each with the nearest one here. Euler's is implicit in damping there, and in springs and dampers here.
const INTEGRATORS: [(&str, Integrator); 4] = [
    ("Euler", Integrator::SemiImplicitEuler),
    ("RK4", Integrator::RungeKutta4),
    ("implicit", Integrator::ImplicitVelocity),
    ("implicitfast", Integrator::ImplicitVelocity),
];

/// Settings of the solver there, which is another one here.
const SOLVER: [&str; 13] = [
    "solver",
    "iterations",
    "tolerance",
    "ls_iterations",
    "ls_tolerance",
    "noslip_iterations",
    "noslip_tolerance",
    "ccd_iterations",
    "ccd_tolerance",
    "sdf_iterations",
    "sdf_initpoints",
    "jacobian",
    "actuatorgroupdisable",
];

/// The options of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Options {
    pub(super) simulation: MjcfOptions,
    pub(super) gravity: [f64; 3],
    /// The magnetic field, in any unit.
    pub(super) magnetic: [f64; 3],
    /// Whether bodies touch that a joint connects.
    pub(super) neighbours_touch: bool,
    pub(super) acting: Acting,
}

/// Constraints of the format that act: flags disable them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Acting {
    pub(super) contact: bool,
    pub(super) equality: bool,
    pub(super) limit: bool,
    pub(super) friction: bool,
}

impl Acting {
    fn update(&mut self, flags: &Entry<'_, '_>) -> Result<(), LoadError> {
        for (name, own) in [
            ("contact", &mut self.contact),
            ("equality", &mut self.equality),
            ("limit", &mut self.limit),
            ("frictionloss", &mut self.friction),
        ] {
            *own = flags.word(name, &FLAG)?.unwrap_or(*own);
        }
        Ok(())
    }

    /// Those of a description; no constraint acts if the flag `constraint` is off.
    fn all(is_on: bool) -> Self {
        Self {
            contact: is_on,
            equality: is_on,
            limit: is_on,
            friction: is_on,
        }
    }
}

/// The words of a flag.
const FLAG: [(&str, bool); 2] = [("enable", true), ("disable", false)];

/// Reads the options; later elements win.
pub(super) fn read(world: &Part<'_, '_>, context: &mut Context<'_>) -> Result<Options, LoadError> {
    let mut out = Options {
        simulation: MjcfOptions {
            time_step: TIME_STEP,
            integrator: Integrator::SemiImplicitEuler,
            has_elliptic_cones: false,
            impratio: 1.0,
            sleeping: None,
        },
        gravity: DEFAULT_GRAVITY,
        magnetic: MAGNETIC,
        neighbours_touch: false,
        acting: Acting::all(true),
    };
    let (mut weighs, mut sleeps, mut speed) = (true, false, SLEEP_SPEED);
    let mut is_constrained = true;
    for node in world.node.all("option") {
        let entry = Entry::plain(node, &world.source.classes);
        out.update(&entry)?;
        speed = match entry.number("sleep_tolerance")? {
            Some(x) if x < 0.0 => return Err(entry.malformed("sleep_tolerance", "is negative")),
            given => given.unwrap_or(speed),
        };
        note_solver(node, context);
        for flags in node.all("flag") {
            let entry = Entry::plain(flags, &world.source.classes);
            weighs = entry.word("gravity", &FLAG)?.unwrap_or(weighs);
            sleeps = entry.word("sleep", &FLAG)?.unwrap_or(sleeps);
            is_constrained = (entry.word("constraint", &FLAG)?).unwrap_or(is_constrained);
            out.acting.update(&entry)?;
            if let Some(is_filtered) = entry.word("filterparent", &FLAG)? {
                out.neighbours_touch = !is_filtered;
            }
        }
    }
    if !weighs {
        out.gravity = [0.0; 3];
    }
    if !is_constrained {
        out.acting = Acting::all(false);
    }
    let time = (SLEEP_STEPS * out.simulation.time_step).min(f64::MAX);
    out.simulation.sleeping = sleeps.then_some(Sleeping { speed, time });
    Ok(out)
}

impl Options {
    fn update(&mut self, entry: &Entry<'_, '_>) -> Result<(), LoadError> {
        if let Some(magnetic) = entry.numbers("magnetic")? {
            self.magnetic = magnetic;
        }
        let own = &mut self.simulation;
        let positive = |name, otherwise: f64| match entry.number(name)? {
            Some(x) if x <= 0.0 => Err(entry.malformed(name, "is not positive")),
            x => Ok(x.unwrap_or(otherwise)),
        };
        own.time_step = positive("timestep", own.time_step)?;
        own.impratio = positive("impratio", own.impratio)?;
        let method = entry.word("integrator", &INTEGRATORS)?;
        own.integrator = method.unwrap_or(own.integrator);
        let cones = entry.word("cone", &[("elliptic", true), ("pyramidal", false)])?;
        own.has_elliptic_cones = cones.unwrap_or(own.has_elliptic_cones);
        self.gravity = entry.numbers("gravity")?.unwrap_or(self.gravity);
        Ok(())
    }
}

/// One remark on all settings of the solver of an element.
fn note_solver(node: Node<'_>, context: &mut Context<'_>) {
    let given = SOLVER.iter().filter(|name| node.attribute(name).is_some());
    let given: Vec<&str> = given.copied().collect();
    if !given.is_empty() {
        let reason = format!("{}: the solver here is another one", given.join(", "));
        context.ignore(&node.place(), reason);
    }
}
