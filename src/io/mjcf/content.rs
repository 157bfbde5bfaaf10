//! What a description has: bodies, then what refers to them, and the report on both.

use std::collections::{HashMap, HashSet};

use nalgebra::DVector;

use super::actuator::{self, ActuatorEntry};
use super::assemble::{self, Assembly};
use super::body::{self, Bodies};
use super::documents::Source;
use super::joint::Kind;
use super::naming::Naming;
use super::references::References;
use super::scene::{MjcfContacts, MjcfKeyframe, MjcfScene, MjcfTendon};
use super::sections::{self, Names};
use super::softness::InverseInertias;
use super::walk::{Part, Walk};
use super::{
    actuator_joint, equality, keyframe, option, pairs, reference, sensor, springs, tendon,
};
use crate::constraint::Constraint;
use crate::error::LoadError;
use crate::io::ModelOptions;
use crate::io::context::Context;
use crate::io::massless::{self, Remark};
use crate::io::options::close;
use crate::io::place::{ImportNote, SourcePlace};
use crate::io::report::ImportReport;
use crate::io::sensors::{self, ImportedSensor};
use crate::model::{Base, JointId, Model, ModelBuilder};
use crate::sim::State;

/// A scene with what the report is made of.
pub(super) struct Loaded {
    scene: MjcfScene,
    remarks: Vec<Remark>,
    /// Places of joints by name.
    places: HashMap<String, SourcePlace>,
    whole: SourcePlace,
    /// The base that the options or the file want.
    base: Base,
    /// Joints whose links have no inertia by construction.
    between: HashSet<String>,
}

impl Loaded {
    pub(super) fn finish(mut self, mut context: Context<'_>) -> (MjcfScene, ImportReport) {
        let place_of = |remark: &Remark| {
            let joint = remark.joint.as_ref()?;
            self.places.get(joint)
        };
        let is_usual = |remark: &Remark| {
            let joint = remark.joint.as_ref();
            remark.is_carried && joint.is_some_and(|joint| self.between.contains(joint))
        };
        let remarks = std::mem::take(&mut self.remarks);
        let remarks = remarks.into_iter().filter(|remark| !is_usual(remark));
        let notes: Vec<ImportNote> = remarks
            .map(|remark| place_of(&remark).unwrap_or(&self.whole).note(remark.reason))
            .collect();
        context.warnings.extend(notes);
        // Replicas say the same of the same line.
        for notes in [&mut context.warnings, &mut context.ignored] {
            let mut seen = HashSet::new();
            notes.retain(|note| seen.insert((note.line, note.path.clone(), note.reason.clone())));
        }
        let (model, mut report) = close(self.scene.model, context, self.base);
        self.scene.model = model;
        report.sensors = sensors::with_names(self.scene.sensors.clone());
        (self.scene, report)
    }
}

/// The most numbers of state of all activations.
const MOST_ACTIVATIONS: usize = 1_000_000;

/// Reads bodies, then what refers to them.
pub(super) fn read(
    sources: &[Source<'_>],
    options: &ModelOptions,
    context: &mut Context<'_>,
) -> Result<Loaded, LoadError> {
    let main = &sources[0];
    let root = Part::of(main.root, main, Naming::plain());
    let settings = option::read(&root, context)?;
    let mut walk = Walk::new(sources);
    let mut bodies = body::read(sources, &mut walk, context)?;
    let mut beside = Beside {
        sources,
        walk: &walk,
        references: std::mem::take(&mut bodies.references),
    };
    let kinds = Names::of(&bodies).kinds;
    let tendons = beside.read("tendon", context, |part, context| match part.node.tag() {
        "fixed" => tendon::read(part, &kinds, context).map(Some),
        _ => Ok(None),
    })?;
    let (tendons, of_tendons): (Vec<_>, Vec<_>) = tendons.into_iter().unzip();
    let mut actuators = beside.actuators(&kinds, settings.simulation.time_step, context)?;
    actuator_joint::share(&mut actuators, &mut bodies, context);
    bodies.let_act(settings.acting);
    let contacts = beside.contacts(&mut bodies, settings.neighbours_touch, context)?;
    beside.references.check_unread(main)?;
    let built = Built::new(&bodies, &settings, options, main, context)?;
    for own in &mut actuators {
        own.mount(&built.assembly.names, &tendons, &built.model, context);
    }
    damp(&mut actuators, &tendons, &built.model, built.q.as_slice())?;
    let keyframes = built.keyframes(&mut beside, &actuators, context)?;
    let mut constraints = built.equalities(&mut beside, &tendons, &settings, context)?;
    let springs = tendon::springs(&tendons, &of_tendons, &built.model, &bodies, context);
    constraints.extend(springs);
    let sensors = built.sensors(&mut beside, &settings, context)?;

    let has_dynamics: Vec<bool> = actuators.iter().map(|own| own.has_dynamics).collect();
    let mut scene = MjcfScene {
        reference: State::new(built.q.as_slice(), &vec![0.0; built.model.nv()]),
        constraints,
        contacts: match settings.acting.contact {
            true => contacts.placed(&bodies, built.assembly.floats()),
            false => MjcfContacts::default(),
        },
        sensors,
        actuation: actuators.into_iter().map(|entry| entry.actuator).collect(),
        tendons,
        keyframes: Vec::new(),
        options: settings.simulation,
        model: built.model,
    };
    scene.activate(keyframes, &has_dynamics);
    let joints = bodies.entries.iter().flat_map(|body| &body.joints);
    let places = joints.map(|joint| (joint.name.clone(), joint.place.clone()));
    Ok(Loaded {
        remarks: massless::remarks(&scene.model),
        places: places.collect(),
        whole: main.root.place(),
        base: match options.base {
            Base::Auto => built.base,
            wanted => wanted,
        },
        between: built.assembly.between,
        scene,
    })
}

/// The model of the bodies, in the configuration in which the file has them, and what refers to it.
struct Built<'a> {
    bodies: &'a Bodies,
    assembly: Assembly<'a>,
    model: Model,
    base: Base,
    q: DVector<f64>,
}

impl<'a> Built<'a> {
    fn new(
        bodies: &'a Bodies,
        settings: &option::Options,
        options: &ModelOptions,
        main: &Source<'_>,
        context: &mut Context<'_>,
    ) -> Result<Self, LoadError> {
        let name = main.root.filled("model").unwrap_or_default();
        let gravity = options.gravity.unwrap_or(settings.gravity);
        let builder = ModelBuilder::new(name)
            .with_source(context.file)
            .with_gravity(gravity);
        let assembly = assemble::assemble(bodies, builder, options.base, context);
        let (builder, base) = assembly.finish();
        let builder = springs::add(builder, bodies, base, assembly.floats())?;
        let model = options.build_on(builder, base)?;
        Ok(Self {
            q: reference::reference(&model, bodies, assembly.floats()),
            bodies,
            assembly,
            model,
            base,
        })
    }

    fn keyframes(
        &self,
        beside: &mut Beside<'_, '_, '_>,
        actuators: &[ActuatorEntry],
        context: &mut Context<'_>,
    ) -> Result<Vec<MjcfKeyframe>, LoadError> {
        let joints = self.model.joints().iter().zip(0..);
        let target = keyframe::Target {
            floats: self.assembly.floats() && self.model.has_floating_base(),
            model: &self.model,
            bodies: self.bodies,
            ids: joints
                .map(|(joint, i)| (joint.name.as_str(), JointId(i)))
                .collect(),
            reference: &self.q,
            actuators: actuators.len(),
            activations: actuators.iter().filter(|own| own.has_dynamics).count(),
        };
        beside.read("keyframe", context, |part, context| {
            keyframe::read(part, &target, context)
        })
    }

    fn equalities(
        &self,
        beside: &mut Beside<'_, '_, '_>,
        tendons: &[MjcfTendon],
        settings: &option::Options,
        context: &mut Context<'_>,
    ) -> Result<Vec<Constraint>, LoadError> {
        let q = self.q.as_slice();
        let at = equality::Reference {
            model: &self.model,
            q,
            names: &self.assembly.names,
            inverses: InverseInertias::new(&self.model, q, self.bodies),
            time_step: settings.simulation.time_step,
            tendons: tendons.iter().map(|own| (own.name.as_str(), own)).collect(),
        };
        beside.read("equality", context, |part, context| {
            match settings.acting.equality {
                true => equality::read(part, &at, context),
                false => Ok(disabled(part, context)),
            }
        })
    }

    fn sensors(
        &self,
        beside: &mut Beside<'_, '_, '_>,
        settings: &option::Options,
        context: &mut Context<'_>,
    ) -> Result<Vec<ImportedSensor>, LoadError> {
        let target = sensor::Target {
            model: &self.model,
            names: &self.assembly.names,
            magnetic: settings.magnetic,
        };
        beside.read("sensor", context, |part, context| {
            sensor::read(part, &target, context).map(Some)
        })
    }
}

/// No element, with a remark.
fn disabled<T>(part: &Part<'_, '_>, context: &mut Context<'_>) -> Option<T> {
    part.node.read_all();
    context.ignore(&part.node.place(), "is disabled by a flag");
    None
}

/// Makes gains of the damping ratios of actuators, if there are any.
fn damp(
    actuators: &mut [ActuatorEntry],
    tendons: &[MjcfTendon],
    model: &Model,
    q: &[f64],
) -> Result<(), LoadError> {
    let mut wanted = actuators
        .iter_mut()
        .filter(|own| own.has_ratio())
        .peekable();
    // Where nothing resists a joint there is no inertia that it feels.
    if wanted.peek().is_none() || model.check_mass_matrix().is_err() {
        return Ok(());
    }
    let inertia = springs::inertia(model, q);
    for (k, actuator) in wanted.enumerate() {
        if k.saturating_mul(model.nv()) > springs::MOST {
            return Err(actuator.too_many());
        }
        actuator.damp(model, tendons, &inertia);
    }
    Ok(())
}

/// The sections beside the bodies.
struct Beside<'w, 't, 'c> {
    sources: &'c [Source<'t>],
    walk: &'w Walk<'t, 'c>,
    references: References,
}

impl<'t, 'c> Beside<'_, 't, 'c> {
    fn read<T>(
        &mut self,
        section: &'static str,
        context: &mut Context<'_>,
        one: impl FnMut(&Part<'t, 'c>, &mut Context<'_>) -> Result<Option<T>, LoadError>,
    ) -> Result<Vec<T>, LoadError> {
        let parts = sections::parts(self.sources, self.walk, section)?;
        let parts = self.references.resolve_all(section, parts, context)?;
        sections::read(&parts, context, one)
    }

    fn actuators(
        &mut self,
        kinds: &HashMap<String, Kind>,
        time_step: f64,
        context: &mut Context<'_>,
    ) -> Result<Vec<ActuatorEntry>, LoadError> {
        let actuators = self.read("actuator", context, |part, context| {
            actuator::read(part, kinds, time_step, context).map(Some)
        })?;
        if actuators.iter().map(ActuatorEntry::states).sum::<usize>() > MOST_ACTIVATIONS {
            let reason = "delays of actuators keep more than a million inputs";
            return Err(self.sources[0].root.place().unsupported(reason));
        }
        Ok(actuators)
    }

    /// The pairs that touch or do not, of which bodies take the shapes that touch.
    fn contacts(
        &mut self,
        bodies: &mut Bodies,
        neighbours_touch: bool,
        context: &mut Context<'_>,
    ) -> Result<MjcfContacts, LoadError> {
        let mut contacts = MjcfContacts {
            neighbours_touch,
            ..MjcfContacts::default()
        };
        self.read("contact", context, |part, context| {
            pairs::read_pair(part, &mut contacts, context).map(Some)
        })?;
        bodies.pair(&contacts.paired());
        contacts.note_kinds(bodies, context);
        if !neighbours_touch {
            pairs::exclude_neighbours(bodies, &mut contacts, context);
        }
        bodies.note_unmodelled(context);
        Ok(contacts)
    }
}
