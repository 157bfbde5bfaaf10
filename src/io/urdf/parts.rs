//! Links and joints of a URDF before they become those of a model. Colours of materials that are named elsewhere, and
//! joints to mimic, are looked up when all parts are read.

use std::collections::{HashMap, HashSet};

use super::control::{self, Commands, Movable};
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::massless::Remark;
use crate::io::motion::without_leader;
use crate::io::names::Names;
use crate::io::place::{Place, SourcePlace};
use crate::io::sensors::{self, SensorElement};
use crate::io::{ImportReport, ModelOptions};
use crate::model::{
    Collision, DEFAULT_GRAVITY, JointSpec, LinkSpec, Mimic, Mimicry, Model, ModelBuilder, Visual,
    inertia_flaw,
};
use crate::nested::IntoNested;
use crate::spatial::{Inertia, Transform};

/// Name of a robot without one.
const DEFAULT_NAME: &str = "robot";

/// All parts of a robot.
pub(super) struct Parts<'a> {
    place: Place<'a>,
    name: &'a str,
    pub(super) links: Vec<LinkPart<'a>>,
    pub(super) joints: Vec<JointPart<'a>>,
    /// Materials beside the links.
    pub(super) materials: Vec<Material<'a>>,
    /// Inputs of joints, if the file states any.
    pub(super) commands: Option<Commands<'a>>,
    pub(super) sensors: Vec<SensorPart>,
}

/// A sensor of Gazebo's settings.
pub(super) struct SensorPart {
    pub(super) place: SourcePlace,
    pub(super) element: SensorElement,
    /// Pose in the link, or in the frame of the joint.
    pub(super) placement: Transform<f64>,
}

/// A link, and its shapes apart, visuals with their materials.
pub(super) struct LinkPart<'a> {
    /// The element of the link.
    pub(super) place: Place<'a>,
    spec: LinkSpec,
    pub(super) visuals: Vec<(Collision, Option<Material<'a>>)>,
    pub(super) collisions: Vec<Collision>,
}

/// A joint, and the joint that it mimics apart.
pub(super) struct JointPart<'a> {
    pub(super) name: &'a str,
    pub(super) place: Place<'a>,
    pub(super) spec: JointSpec,
    pub(super) mimic: Option<(Place<'a>, Mimic)>,
}

/// A material, which may be named without saying its colour.
pub(super) struct Material<'a> {
    pub(super) place: Place<'a>,
    pub(super) name: &'a str,
    pub(super) color: Option<[f64; 4]>,
    /// Whether it gives only its name.
    pub(super) is_reference: bool,
}

impl<'a> LinkPart<'a> {
    /// A link without shapes.
    ///
    /// * `place` – place for a remark on the inertia
    pub(super) fn new(
        context: &mut Context<'_>,
        place: Place<'a>,
        name: &str,
        inertia: Inertia<f64>,
    ) -> Self {
        if let Some(flaw) = inertia_flaw(&inertia) {
            context.warn(place, flaw.to_string());
        }
        Self {
            place,
            spec: LinkSpec::new(name).with_inertia(inertia),
            visuals: Vec::new(),
            collisions: Vec::new(),
        }
    }

    /// Name of the link.
    pub(super) fn name(&self) -> &str {
        &self.spec.name
    }

    /// Lets gravity not act on the link.
    pub(super) fn take_gravity(&mut self) {
        self.spec = self.spec.clone().without_gravity();
    }

    /// The link with its shapes; visuals are of their own colour, or of that of the material that they name.
    fn finish(self, context: &mut Context<'_>, colors: &HashMap<&str, [f64; 4]>) -> LinkSpec {
        let mut spec = self.spec;
        for (shape, material) in self.visuals {
            spec = spec.with_visual(Visual {
                name: shape.name,
                placement: shape.placement,
                geometry: shape.geometry,
                color: material.and_then(|material| material.find_color(context, colors)),
            });
        }
        let collisions = self.collisions.into_iter();
        collisions.fold(spec, LinkSpec::with_collision)
    }
}

impl Material<'_> {
    /// Its own colour, or that of its name.
    fn find_color(
        self,
        context: &mut Context<'_>,
        colors: &HashMap<&str, [f64; 4]>,
    ) -> Option<[f64; 4]> {
        let color = self.color.or_else(|| colors.get(self.name).copied());
        if color.is_none() && self.is_reference {
            let reason = format!("there is no material \"{}\" with a colour", self.name);
            context.warn(self.place, reason);
        }
        color
    }
}

/// Returns the position of a link or joint in a text.
fn set_position(
    builder: &mut ModelBuilder,
    context: &Context<'_>,
    is_joint: bool,
    place: Place<'_>,
    name: &str,
) {
    if let Place::Element(node) = place {
        builder.set_position(is_joint, name, context.position(node));
    }
}

impl<'a> Parts<'a> {
    /// A robot without parts.
    pub(super) fn new(context: &mut Context<'_>, place: Place<'a>, name: Option<&'a str>) -> Self {
        if name.is_none() {
            context.warn(place, "the robot has no name: called \"robot\"");
        }
        Self {
            place,
            name: name.unwrap_or(DEFAULT_NAME),
            links: Vec::new(),
            joints: Vec::new(),
            materials: Vec::new(),
            commands: None,
            sensors: Vec::new(),
        }
    }

    /// Makes a model of the parts.
    pub(super) fn finish(
        self,
        mut context: Context<'_>,
        options: &ModelOptions,
    ) -> Result<(Model, ImportReport), LoadError> {
        let mut builder = ModelBuilder::new(self.name)
            .with_source(context.file)
            .with_mimicry(options.mimicry)
            .with_gravity(options.gravity.unwrap_or(DEFAULT_GRAVITY));
        let colors = self.colors();
        if let Some(commands) = &self.commands {
            let movable = self.movable(options.mimicry);
            context.commands = Some(control::finish(commands, &movable, &mut context));
        }
        let frames = self.add_sensor_frames(&mut context, &mut builder);
        for link in self.links {
            let place = link.place;
            let spec = link.finish(&mut context, &colors);
            set_position(&mut builder, &context, false, place, &spec.name);
            builder.add_link(spec);
        }
        let joints = self.joints.iter().map(|joint| (joint.name, joint.place));
        let joints: HashMap<&str, Place<'_>> = joints.collect();
        for JointPart {
            spec, mimic, place, ..
        } in self.joints
        {
            set_position(&mut builder, &context, true, place, &spec.name);
            builder.add_joint(match mimic {
                Some((place, mimic))
                    if options.mimicry == Mimicry::Independent
                        && !joints.contains_key(&*mimic.leader) =>
                {
                    context.warn(place, without_leader(&mimic.leader));
                    spec
                }
                Some((_, mimic)) => spec.with_mimic(mimic),
                None => spec,
            });
        }
        let finished = options.finish(builder, context, |context, remarks| {
            let place = |remark: &Remark| joints.get(remark.joint.as_deref()?).copied();
            let remarks = remarks.into_iter();
            remarks
                .map(|remark| context.note(place(&remark).unwrap_or(self.place), remark.reason))
                .collect()
        });
        let (model, mut report) = finished?;
        let sensors = self.sensors.iter().zip(&frames);
        let found = sensors.nested(|(own, frame)| own.element.in_model(&model, frame));
        report.sensors = sensors::with_names(found.collect());
        Ok((model, report))
    }

    /// Adds a frame for each sensor that is not in the frame of its link; returns the names of the frames of all sensors, empty where there is none. The
    /// frame of a joint is that of its child.
    fn add_sensor_frames(
        &self,
        context: &mut Context<'_>,
        builder: &mut ModelBuilder,
    ) -> Vec<String> {
        let links: HashSet<&str> = self.links.iter().map(LinkPart::name).collect();
        let joints = self.joints.iter();
        let children: HashMap<&str, &str> = joints
            .map(|joint| (joint.name, joint.spec.child.as_str()))
            .collect();
        let mut names = Names::of(links.iter().copied());
        let mut frame_of = |sensor: &SensorPart| {
            let object = sensor.element.object.as_str();
            let own = links.get(object).or_else(|| children.get(object));
            let Some(&link) = own else {
                let reason = format!("there is no link or joint \"{object}\"");
                context.warn(&sensor.place, reason);
                return String::new();
            };
            if sensor.placement == Transform::identity() {
                return link.to_owned();
            }
            let name = names.fresh(sensor.element.frame_name());
            builder.add_frame(&name, link, sensor.placement);
            name
        };
        self.sensors.iter().map(&mut frame_of).collect()
    }

    /// The joints by their names, as what may have inputs.
    fn movable(&self, mimicry: Mimicry) -> HashMap<&'a str, Movable> {
        let movable = |own: &JointPart<'a>| Movable {
            kind: own.spec.kind,
            follows: own.mimic.is_some() && mimicry == Mimicry::Coupled,
        };
        let joints = self.joints.iter();
        joints.map(|own| (own.name, movable(own))).collect()
    }

    /// The colours by the names of their materials: those of the robot, then those that links define.
    fn colors(&self) -> HashMap<&'a str, [f64; 4]> {
        let visuals = self.links.iter().nested(|link| &link.visuals);
        let of_links = visuals.filter_map(|(_, material)| material.as_ref());
        let mut colors = HashMap::new();
        for material in self.materials.iter().chain(of_links) {
            if let (Some(color), false) = (material.color, material.name.is_empty()) {
                colors.entry(material.name).or_insert(color);
            }
        }
        colors
    }
}
