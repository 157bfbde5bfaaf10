//! The world around a robot, and the models that its joints join to it.
//!
//! A joint of the world between a link of the robot and the world holds the robot; one between two models makes them
//! one robot. Their names, and those of the frames that are attached to them, decide which models belong together;
//! their parts are read afterwards.

use std::collections::{HashMap, HashSet};

use super::entry::{name, read_model};
use super::reader::{Reader, attribute, candidates};
use super::scene::{FrameKind, ModelEntry, WORLD};
use super::schema;
use super::values::{Elements, text_of};
use crate::error::LoadError;
use crate::io::context::{Node, child, children};
use crate::io::schema::check;
use crate::io::values::Values;

/// Gravity where a world does not say it, m/s²: the default of the SDF.
const GRAVITY_OF_WORLD: [f64; 3] = [0.0, 0.0, -9.8];

/// The models of a world that its joints join to one of them.
pub(super) struct Joined<'a> {
    world: Node<'a>,
    chosen: Node<'a>,
    names: HashSet<String>,
    anchors: HashMap<String, String>,
}

impl<'a> Joined<'a> {
    /// Follows the joints of the world from a model on.
    pub(super) fn to(world: Node<'a>, chosen: Node<'a>) -> Self {
        let anchors = anchors(world);
        let neighbours = neighbours(world, &anchors);
        let mut names = HashSet::from([name(chosen)]);
        let mut open = vec![name(chosen)];
        while let Some(at) = open.pop() {
            for other in neighbours.get(&at).into_iter().flatten() {
                if names.insert(other.clone()) {
                    open.push(other.clone());
                }
            }
        }
        Self {
            world,
            chosen,
            names,
            anchors,
        }
    }

    /// `true` for the chosen model and those that are joined to it.
    pub(super) fn has(&self, model: Node<'_>) -> bool {
        model.parent_element() == Some(self.world) && self.names.contains(&name(model))
    }

    /// Reads the surroundings of the robot, with the frames that its pose may be relative to.
    pub(super) fn read_around(&self, reader: &mut Reader<'_, '_, '_>) -> Result<(), LoadError> {
        read_surroundings(reader, self.world)?;
        for other in children(self.world, "model").filter(|model| !self.has(*model)) {
            read_neighbour(reader, other)?;
        }
        Ok(())
    }

    /// Reads the models beside the chosen one, and the joints.
    pub(super) fn read(&self, reader: &mut Reader<'_, '_, '_>) -> Result<(), LoadError> {
        for model in candidates(self.world) {
            if model != self.chosen && self.has(model) {
                read_model(reader, model)?;
            }
        }
        for joint in children(self.world, "joint") {
            if ends(joint, &self.anchors).any(|end| self.names.contains(&end)) {
                reader.joint(joint, WORLD)?;
            } else {
                let reason = "joins models that are not loaded";
                reader.context.ignore(joint, reason);
            }
        }
        Ok(())
    }
}

/// Reads what is in a world besides models and joints: gravity, and the frames that poses may be relative to.
fn read_surroundings(reader: &mut Reader<'_, '_, '_>, world: Node<'_>) -> Result<(), LoadError> {
    check(&mut reader.context, world, &schema::WORLD)?;
    let gravity = Elements::numbers::<3>(&mut reader.context, world, "gravity")?;
    if gravity.is_none() {
        let reason = "no <gravity>: taken as 0 0 -9.8, as the SDF says";
        reader.context.warn(world, reason);
    }
    reader.shared.scene.gravity = Some(gravity.unwrap_or(GRAVITY_OF_WORLD));
    for frame in children(world, "frame") {
        reader.frame(frame, WORLD)?;
    }
    Ok(())
}

/// Reads a world with all that is in it.
pub(super) fn read_all(reader: &mut Reader<'_, '_, '_>, world: Node<'_>) -> Result<(), LoadError> {
    read_surroundings(reader, world)?;
    reader.shared.scene.title = attribute(world, "name").filter(|name| !name.is_empty());
    for model in candidates(world) {
        read_model(reader, model)?;
    }
    for joint in children(world, "joint") {
        reader.joint(joint, WORLD)?;
    }
    Ok(())
}

/// Models that hold the frames of a world, directly or by other frames, by name of the frame; the world itself for the
/// others.
fn anchors(world: Node<'_>) -> HashMap<String, String> {
    let attachment = |frame| {
        let to = attribute(frame, "attached_to").unwrap_or_else(|| "world".into());
        Some((attribute(frame, "name")?, top(&to).to_owned()))
    };
    let attached: HashMap<String, String> =
        children(world, "frame").filter_map(attachment).collect();
    let mut anchors: HashMap<String, String> = HashMap::new();
    for mut at in attached.keys() {
        let mut chain = Vec::new();
        // Frames that are attached to each other in a circle, an error for later, are all passed once.
        while let Some(next) = attached.get(at)
            && !anchors.contains_key(at)
            && chain.len() < attached.len()
        {
            chain.push(at);
            at = next;
        }
        let anchor = anchors.get(at).unwrap_or(at).clone();
        anchors.extend(
            chain
                .into_iter()
                .map(|frame| (frame.clone(), anchor.clone())),
        );
    }
    anchors
}

/// Models at the other ends of the joints at each model, by name.
fn neighbours(world: Node<'_>, anchors: &HashMap<String, String>) -> HashMap<String, Vec<String>> {
    let mut neighbours: HashMap<String, Vec<String>> = HashMap::new();
    for joint in children(world, "joint") {
        let mut ends = ends(joint, anchors);
        if let (Some(a), Some(b)) = (ends.next(), ends.next()) {
            neighbours.entry(a.clone()).or_default().push(b.clone());
            neighbours.entry(b).or_default().push(a);
        }
    }
    neighbours
}

/// The models at the ends of a joint, but not the world.
fn ends(joint: Node<'_>, anchors: &HashMap<String, String>) -> impl Iterator<Item = String> {
    let end = move |element| {
        let name = text_of(child(joint, element)?);
        let top = top(&name);
        let model = anchors.get(top).map_or(top, String::as_str);
        (model != "world").then(|| model.to_owned())
    };
    ["parent", "child"].into_iter().filter_map(end)
}

/// The name of an element of the world itself.
fn top(name: &str) -> &str {
    name.split("::").next().unwrap_or_default()
}

/// Of another model, the frame is kept.
fn read_neighbour(reader: &mut Reader<'_, '_, '_>, node: Node<'_>) -> Result<(), LoadError> {
    let (Some(name), Ok(pose)) = (attribute(node, "name"), reader.pose(node)) else {
        return Ok(());
    };
    let scene = &mut reader.shared.scene;
    let index = scene.models.len();
    let mut model = ModelEntry::new(scene.frames.len(), format!("{name}::"));
    model.placement_frame = attribute(node, "placement_frame");
    scene.models.push(model);
    let kind = FrameKind::Model(index);
    reader.add_frame(node, WORLD, &name, kind, pose)?;
    Ok(())
}
