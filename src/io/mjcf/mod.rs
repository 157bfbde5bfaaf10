//! The reader of MJCF files, the XML of `MuJoCo`.
//!
//! Steps: [include] reads all files into one [tree], [documents] adds attached models, [defaults] and [compiler] define the values; [walk] finds the
//! elements of bodies with their poses and names, [body] reads them, [assemble] makes links and joints. The other [sections] become a [scene]. At the
//! end, [unused] lists content that was not read.
//!
//! | in MJCF | here |
//! |---|---|
//! | several joints of a body | joints, separated by links without inertia, `JOINT::link` |
//! | `ref` of a hinge or slide | in the placement of the joint: coordinates are those of `qpos` |
//! | single free body on the world | floating base, as for a URDF robot |
//! | several bodies on the world | a link `world`; free joints are joints of kind floating |
//! | site | frame |
//! | geom of group 0 to 2 | visual |
//! | geom with `contype` or `conaffinity` | collision |
//! | first plane or level height field of the world | the ground of [`MjcfContacts`] |
//! | other planes and height fields of the world | collision shapes of the link `world` |
//! | `gravcomp` between 0 and 1 | a second link, `BODY::balanced`, without weight |
//!
//! # References
//! The XML reference of `MuJoCo` 3 and 4; unspecified details were measured with its library 4.0.0.

mod actuator;
mod actuator_law;
mod assemble;
mod assets;
mod body;
mod compiler;
mod contact;
mod defaults;
mod documents;
mod entry;
mod equality;
mod equality_inertia;
mod geom;
mod ground;
mod height_field;
mod height_file;
mod include;
mod inertial;
mod joint;
mod keyframe;
mod mesh_inertia;
mod naming;
mod option;
mod orientation;
mod pairs;
mod scene;
mod scenery;
mod sections;
mod sensor;
mod simulator;
mod site;
mod softness;
mod solids;
mod solver_parameters;
mod springs;
mod surfaces;
mod tendon;
#[cfg(test)]
mod tests;
mod touching;
mod tree;
mod unused;
mod vertices;
mod walk;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use super::ModelOptions;
use super::context::Context;
use super::massless::Remark;
use super::options::close;
use super::place::{ImportNote, SourcePlace};
use super::report::ImportReport;
use super::sensors;
use crate::error::LoadError;
use crate::model::{Base, JointId, Model, ModelBuilder};
use crate::sim::State;
use actuator::ActuatorEntry;
use documents::Source;
use include::Files;
use naming::Naming;
use sections::Names;
use softness::InverseInertias;
use walk::{Part, Walk};

pub use scene::{
    MjcfActuator, MjcfContacts, MjcfGeom, MjcfKeyframe, MjcfOptions, MjcfPair, MjcfScene,
    MjcfTendon, MjcfTransmission,
};

/// Loads a description from text; `file` is what errors and the report call its source, `path` where it is, if it is in a file.
pub(super) fn load(
    file: &str,
    text: &str,
    path: Option<&Path>,
    options: &ModelOptions,
) -> Result<(MjcfScene, ImportReport), LoadError> {
    let path = path.and_then(|path| std::path::absolute(path).ok());
    let mut files = Files::new(options);
    let documents = documents::read(&mut files, file, text, path.as_deref())?;
    let mut context = Context::new(file, text);
    context.ignored = files.ignored;
    let sources = documents
        .iter()
        .map(|document| Source::of(document, options));
    let sources = sources.collect::<Result<Vec<_>, _>>()?;
    let loaded = scene(&sources, options, &mut context)?;
    for document in &documents {
        unused::note(&document.tree, &mut context);
    }
    Ok(loaded.finish(context))
}

/// A scene with what the report is made of.
struct Loaded {
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
    fn finish(mut self, mut context: Context<'_>) -> (MjcfScene, ImportReport) {
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
fn scene(
    sources: &[Source<'_>],
    options: &ModelOptions,
    context: &mut Context<'_>,
) -> Result<Loaded, LoadError> {
    let main = &sources[0];
    let root = Part::of(main.root, main, Naming::plain());
    let settings = option::read(&root, context)?;
    let mut walk = Walk::new(sources);
    let mut bodies = body::read(sources, &mut walk, context)?;
    let beside = Beside {
        sources,
        walk: &walk,
    };
    let kinds = Names::of(&bodies).kinds;
    let mut actuators = beside.read("actuator", context, |part, context| {
        let time_step = settings.simulation.time_step;
        actuator::read(part, &kinds, time_step, context).map(Some)
    })?;
    if actuators.iter().map(ActuatorEntry::states).sum::<usize>() > MOST_ACTIVATIONS {
        let reason = "delays of actuators keep more than a million inputs";
        return Err(main.root.place().unsupported(reason));
    }
    actuator::share(&mut actuators, &mut bodies, context);
    let tendons = beside.read("tendon", context, |part, _| match part.node.tag() {
        "fixed" => tendon::read(part, &kinds).map(Some),
        _ => Ok(None),
    })?;

    let contacts = beside.contacts(&mut bodies, settings.neighbours_touch, context)?;

    let name = main.root.filled("model").unwrap_or_default();
    let gravity = options.gravity.unwrap_or(settings.gravity);
    let builder = ModelBuilder::new(name)
        .with_source(context.file)
        .with_gravity(gravity);
    let assembly = assemble::assemble(&bodies, builder, options.base, context);
    let (builder, base) = assembly.finish();
    let builder = springs::add(builder, &bodies, base, assembly.floats())?;
    let model = options.build_on(builder, base)?;
    let q = assemble::reference(&model, &bodies, assembly.floats());
    for own in &mut actuators {
        own.mount(&assembly.names, &tendons, &model, context);
    }
    damp(&mut actuators, &tendons, &model, q.as_slice())?;

    let target = keyframe::Target {
        floats: assembly.floats() && model.has_floating_base(),
        model: &model,
        bodies: &bodies,
        ids: (model.joints().iter().zip(0..))
            .map(|(joint, i)| (joint.name.as_str(), JointId(i)))
            .collect(),
        reference: &q,
        actuators: actuators.len(),
        activations: actuators.iter().filter(|own| own.has_dynamics).count(),
    };
    let keyframes = beside.read("keyframe", context, |part, context| {
        keyframe::read(part, &target, context)
    })?;
    let reference = equality::Reference {
        model: &model,
        q: q.as_slice(),
        names: &assembly.names,
        inverses: InverseInertias::new(&model, q.as_slice(), &bodies),
        time_step: settings.simulation.time_step,
        tendons: tendons.iter().map(|own| (own.name.as_str(), own)).collect(),
    };
    let constraints = beside.read("equality", context, |part, context| {
        equality::read(part, &reference, context)
    })?;
    let measured = sensor::Target {
        model: &model,
        sites: &assembly.names.sites,
        magnetic: settings.magnetic,
    };
    let has_dynamics: Vec<bool> = actuators.iter().map(|own| own.has_dynamics).collect();
    let mut scene = MjcfScene {
        reference: State::new(q.as_slice(), &vec![0.0; model.nv()]),
        constraints,
        contacts: contacts.placed(&bodies, assembly.floats()),
        sensors: beside.read("sensor", context, |part, context| {
            sensor::read(part, &measured, context).map(Some)
        })?,
        actuation: actuators.into_iter().map(|entry| entry.actuator).collect(),
        tendons,
        keyframes: Vec::new(),
        options: settings.simulation,
        model,
    };
    scene.activate(keyframes, &has_dynamics);
    let joints = bodies.entries.iter().flat_map(|body| &body.joints);
    let places = joints.map(|joint| (joint.name.clone(), joint.place.clone()));
    Ok(Loaded {
        remarks: super::massless::remarks(&scene.model),
        places: places.collect(),
        whole: main.root.place(),
        base: match options.base {
            Base::Auto => base,
            wanted => wanted,
        },
        between: assembly.between,
        scene,
    })
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
}

impl<'t, 'c> Beside<'_, 't, 'c> {
    fn read<T>(
        &self,
        section: &'static str,
        context: &mut Context<'_>,
        one: impl FnMut(&Part<'t, 'c>, &mut Context<'_>) -> Result<Option<T>, LoadError>,
    ) -> Result<Vec<T>, LoadError> {
        sections::read(self.sources, self.walk, section, context, one)
    }

    /// The pairs that touch or do not, of which bodies take the shapes that touch.
    fn contacts(
        &self,
        bodies: &mut body::Bodies,
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
