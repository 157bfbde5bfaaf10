//! The simulation of a robot that a command runs: step, ground, start.

use std::error::Error;
use std::ops::Range;
use std::str::FromStr;

use clap::{Args, ValueEnum};

use super::robot::Loaded;
use crate::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, SoftContact, Terrain};
use crate::model::Model;
use crate::sim::{Integrator, Simulator, State};

/// Time step for files without one, s.
const TIME_STEP: f64 = 1e-3;
/// Penetration of soft ground by the robot at rest, m.
const SOFT_DEPTH: f64 = 2e-3;

/// Options of the simulation of a robot.
#[derive(Args, Debug)]
pub(super) struct Setup {
    /// Time step, s; by default that of the file, or 0.001.
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    time_step: Option<f64>,
    /// Integration method; by default that of the file, or the one that fits the contact model.
    #[arg(long)]
    integrator: Option<IntegratorWord>,
    /// Ground: none, flat, flat:HEIGHT (m) or incline:ANGLE (rad); by default that of the file, or flat for a robot that floats.
    #[arg(long)]
    terrain: Option<TerrainWord>,
    /// Contact model of the ground; by default that of the file, or relaxed-rigid.
    #[arg(long)]
    law: Option<LawWord>,
    /// Coefficient of friction of the ground.
    #[arg(long, value_parser = not_negative, allow_negative_numbers = true)]
    friction: Option<f64>,
    /// Start of a joint, rad or m; `base` is the floating base: x,y,z or x,y,z,w,i,j,k. May be given several times.
    #[arg(long = "start", value_name = "JOINT=NUMBERS")]
    starts: Vec<Assignment>,
    /// Velocity of a joint at the start, rad/s or m/s. May be given several times.
    #[arg(long = "velocity", value_name = "JOINT=NUMBERS")]
    velocities: Vec<Assignment>,
    /// Start from a keyframe of an MJCF file.
    #[arg(long, value_name = "NAME")]
    keyframe: Option<String>,
    /// Hold the joints at their start by servos with the effort limits of the file.
    #[arg(long)]
    hold: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum IntegratorWord {
    SemiImplicitEuler,
    ImplicitVelocity,
    RungeKutta4,
    ImplicitMidpoint,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum LawWord {
    Soft,
    RelaxedRigid,
    Rigid,
}

#[derive(Clone, Copy, Debug)]
enum TerrainWord {
    None,
    Flat(f64),
    Incline(f64),
}

impl FromStr for TerrainWord {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, number) = text
            .split_once(':')
            .map_or((text, None), |(a, b)| (a, Some(b)));
        let number = number.map(finite).transpose()?;
        match (kind, number) {
            ("none", None) => Ok(Self::None),
            ("flat", height) => Ok(Self::Flat(height.unwrap_or(0.0))),
            ("incline", Some(angle)) if angle.abs() < 1.5 => Ok(Self::Incline(angle)),
            ("incline", Some(angle)) => Err(format!(
                "an incline of {angle} rad is too steep: at most 1.5"
            )),
            _ => Err("expected none, flat, flat:HEIGHT or incline:ANGLE".into()),
        }
    }
}

/// Numbers of a joint by name.
#[derive(Clone, Debug)]
struct Assignment {
    joint: String,
    numbers: Vec<f64>,
}

impl FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (joint, numbers) = text
            .rsplit_once('=')
            .ok_or("expected JOINT=NUMBER or JOINT=NUMBER,NUMBER,…")?;
        let numbers = numbers.split(',').map(finite).collect::<Result<_, _>>()?;
        let joint = joint.to_owned();
        Ok(Self { joint, numbers })
    }
}

fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text
        .trim()
        .parse()
        .map_err(|_| format!("\"{text}\" is not a number"))?;
    Some(number)
        .filter(|x| x.is_finite())
        .ok_or_else(|| format!("{text} is not finite"))
}

/// Reads a number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| {
        if x > 0.0 {
            Ok(x)
        } else {
            Err(format!("{text} is not positive"))
        }
    })
}

fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| {
        if x >= 0.0 {
            Ok(x)
        } else {
            Err(format!("{text} is negative"))
        }
    })
}

impl Setup {
    /// The simulator and its start; an error where the options do not fit one another or the robot.
    pub(super) fn simulation(&self, loaded: &Loaded) -> Result<(Simulator, State), Box<dyn Error>> {
        loaded.model.check_mass_matrix()?;
        let simulator = self.on_ground(loaded, self.in_free_space(loaded)?)?;
        let simulator = match self.hold {
            true => simulator.with_holding_servos(),
            false => simulator,
        };
        let start = self.start(loaded, &simulator)?;
        Ok((simulator, start))
    }

    /// Whether servos hold the joints.
    pub(super) fn holds(&self) -> bool {
        self.hold
    }

    /// The simulator without ground, except for that of a file.
    fn in_free_space(&self, loaded: &Loaded) -> Result<Simulator, Box<dyn Error>> {
        let simulator = match &loaded.scene {
            Some(scene) => scene.simulator(),
            None => {
                let simulator = loaded.report.simulator(loaded.model.clone());
                simulator.with_time_step(TIME_STEP)
            }
        };
        let integrator = match self.integrator {
            Some(IntegratorWord::SemiImplicitEuler) => Integrator::SemiImplicitEuler,
            Some(IntegratorWord::ImplicitVelocity) => Integrator::ImplicitVelocity,
            Some(IntegratorWord::RungeKutta4) => Integrator::RungeKutta4,
            Some(IntegratorWord::ImplicitMidpoint) => Integrator::ImplicitMidpoint,
            None if self.law == Some(LawWord::Soft) => Integrator::ImplicitVelocity,
            None => simulator.integrator(),
        };
        let refuses = match integrator {
            Integrator::ImplicitMidpoint => self.has_ground(loaded, &simulator),
            // Bounces are those of whole steps.
            Integrator::RungeKutta4 => self.law == Some(LawWord::Rigid),
            Integrator::SemiImplicitEuler | Integrator::ImplicitVelocity => false,
        };
        if refuses {
            return Err(format!("Integrator::{integrator:?} does not simulate this contact: choose another, or --terrain none").into());
        }
        let time_step = self.time_step.unwrap_or(simulator.time_step());
        Ok(simulator
            .with_time_step(time_step)
            .with_integrator(integrator))
    }

    fn has_ground(&self, loaded: &Loaded, simulator: &Simulator) -> bool {
        self.ground(loaded).is_some() || simulator.contacts().is_some()
    }

    /// The ground of the options, or that of a robot that floats; `None` where that of the file stays.
    fn ground(&self, loaded: &Loaded) -> Option<TerrainWord> {
        let is_asked = self.law.is_some() || self.friction.is_some();
        let floats = loaded.scene.is_none() && loaded.model.has_floating_base();
        self.terrain
            .or((is_asked || floats).then_some(TerrainWord::Flat(0.0)))
    }

    fn on_ground(
        &self,
        loaded: &Loaded,
        simulator: Simulator,
    ) -> Result<Simulator, Box<dyn Error>> {
        let terrain = match self.ground(loaded) {
            None => return Ok(simulator),
            Some(TerrainWord::None) => return Ok(simulator.without_contacts()),
            Some(TerrainWord::Flat(height)) => Terrain::flat(height),
            Some(TerrainWord::Incline(angle)) => Terrain::incline(angle),
        };
        let model = simulator.model().clone();
        let contacts = Contacts::new(&model, terrain, self.law(&model, 1)?);
        let points = contacts.points().len();
        let laws = vec![self.law(&model, points.max(1))?; points];
        Ok(simulator.with_contacts(contacts.with_laws(&laws)))
    }

    /// The contact model of a robot with a given number of support points.
    fn law(&self, model: &Model, points: usize) -> Result<ContactLaw, Box<dyn Error>> {
        let friction = self.friction;
        Ok(match self.law.unwrap_or(LawWord::RelaxedRigid) {
            LawWord::Soft => {
                let mass = model.total_mass();
                if mass <= 0.0 {
                    return Err(format!(
                        "\"{}\" has no mass: soft ground has no stiffness for it",
                        model.name()
                    )
                    .into());
                }
                let law = SoftContact::estimate(mass, points, SOFT_DEPTH);
                ContactLaw::Soft(SoftContact {
                    friction: friction.unwrap_or(law.friction),
                    ..law
                })
            }
            LawWord::RelaxedRigid => {
                let law = RelaxedRigid::default();
                ContactLaw::RelaxedRigid(RelaxedRigid {
                    friction: friction.unwrap_or(law.friction),
                    ..law
                })
            }
            LawWord::Rigid => {
                let law = Rigid::default();
                ContactLaw::Rigid(Rigid {
                    friction: friction.unwrap_or(law.friction),
                    ..law
                })
            }
        })
    }

    /// The start: that of the file, changed by the options; a floating robot without a placement option starts on the ground.
    fn start(&self, loaded: &Loaded, simulator: &Simulator) -> Result<State, Box<dyn Error>> {
        let model = simulator.model();
        let (q, v) = self.start_of_file(loaded)?;
        let mut state = simulator.state(q.as_slice(), v.as_slice());
        for own in &self.starts {
            let range = q_range(model, &own.joint, own.numbers.len())?;
            assign(own, &mut state.q.as_mut_slice()[range])?;
        }
        for own in &self.velocities {
            let range = v_range(model, &own.joint)?;
            assign(own, &mut state.v.as_mut_slice()[range])?;
        }
        state.check(model)?;
        let is_placed = self.starts.iter().any(|own| own.joint == BASE) || self.keyframe.is_some();
        if model.has_floating_base() && !is_placed && self.ground(loaded).is_some() {
            stand_on_ground(simulator, &mut state);
        }
        Ok(state)
    }

    fn start_of_file(&self, loaded: &Loaded) -> Result<(Vec<f64>, Vec<f64>), Box<dyn Error>> {
        let numbers = |state: &State| (state.q.as_slice().to_vec(), state.v.as_slice().to_vec());
        let scene = loaded.scene.as_ref();
        match (&self.keyframe, scene) {
            (None, None) => Ok(numbers(&State::neutral(&loaded.model))),
            (None, Some(scene)) => Ok(numbers(&scene.reference)),
            (Some(name), _) => {
                let keyframes = scene.map_or(&[][..], |scene| &scene.keyframes);
                let found = keyframes.iter().find(|own| own.name == *name);
                let known: Vec<&str> = keyframes.iter().map(|own| own.name.as_str()).collect();
                let unknown = || format!("there is no keyframe \"{name}\"; known: {known:?}");
                Ok(numbers(&found.ok_or_else(unknown)?.state))
            }
        }
    }
}

/// Name of the floating base in options.
const BASE: &str = "base";

/// The part of q of a joint, or of the position of a base of which as many numbers are given.
fn q_range(model: &Model, joint: &str, given: usize) -> Result<Range<usize>, Box<dyn Error>> {
    match joint {
        BASE if model.has_floating_base() => Ok(0..if given == 3 { 3 } else { 7 }),
        _ => Ok(model.joint_q(model.find_joint(joint)?)),
    }
}

fn v_range(model: &Model, joint: &str) -> Result<Range<usize>, Box<dyn Error>> {
    match joint {
        BASE if model.has_floating_base() => Ok(0..6),
        _ => Ok(model.joint_v(model.find_joint(joint)?)),
    }
}

fn assign(own: &Assignment, out: &mut [f64]) -> Result<(), Box<dyn Error>> {
    if own.numbers.len() != out.len() {
        let (joint, given, expected) = (&own.joint, own.numbers.len(), out.len());
        return Err(format!("{given} numbers for \"{joint}\", expected {expected}").into());
    }
    out.copy_from_slice(&own.numbers);
    Ok(())
}

/// Lifts a robot, or lets it down, until its deepest point just touches the ground.
fn stand_on_ground(simulator: &Simulator, state: &mut State) {
    let report = simulator.contact_report(state, &vec![0.0; simulator.nu()]);
    // Along the normal, so that more is needed up an incline.
    let rise = report
        .points
        .iter()
        .map(|point| point.depth / point.normal.z);
    let rise = rise.fold(f64::NEG_INFINITY, f64::max);
    if rise.is_finite() {
        state.q[2] += rise;
    }
}
