//! Which model of a file becomes the robot, and what the world around it says.

use super::reader::{Overrides, Reader, attribute, candidates};
use super::scene::{FrameKind, ModelEntry, WORLD};
use super::schema;
use super::values::{numbers, text_of};
use crate::error::LoadError;
use crate::io::context::{Node, child, children, tag};
use crate::io::schema::check;

/// Gravity where a world does not say it, m/s²: the default of the SDF.
const GRAVITY_OF_WORLD: [f64; 3] = [0.0, 0.0, -9.8];

/// Reads the robot; returns the index of its model.
pub(super) fn read(
    reader: &mut Reader<'_, '_, '_>,
    root: Node<'_>,
    wanted: Option<&str>,
) -> Result<usize, LoadError> {
    let mut models: Vec<Node<'_>> = candidates(root).collect();
    for world in children(root, "world") {
        models.extend(candidates(world));
    }
    let chosen = choose(reader, &models, wanted)?;
    for other in models.iter().filter(|model| **model != chosen) {
        reader
            .context
            .ignore(*other, "another model than the one that is loaded");
    }
    if let Some(world) = chosen.parent_element().filter(|parent| *parent != root) {
        read_world(reader, world, chosen)?;
    }
    if tag(chosen) == "include" {
        return reader.include(chosen, WORLD);
    }
    reader.model(chosen, WORLD, Overrides::default())
}

fn choose<'a>(
    reader: &Reader<'_, '_, '_>,
    models: &[Node<'a>],
    wanted: Option<&str>,
) -> Result<Node<'a>, LoadError> {
    let is_wanted = |model: &&Node<'_>| wanted.is_none_or(|wanted| name(**model) == wanted);
    let mut fitting = models.iter().filter(is_wanted);
    let reason = match (fitting.next(), fitting.next(), wanted) {
        (Some(model), None, _) => return Ok(*model),
        (Some(_), Some(_), Some(wanted)) => format!("there are several models \"{wanted}\""),
        (Some(_), Some(_), None) => {
            "there are several models: choose one by with_model_name".to_owned()
        }
        (None, _, Some(wanted)) => format!("there is no model \"{wanted}\""),
        (None, _, None) => "there is no model".to_owned(),
    };
    Err(LoadError::ModelChoice {
        file: reader.context.file.into(),
        reason,
        names: models.iter().map(|model| name(*model)).collect(),
    })
}

/// The name of a model, or of an include: its own, or else the last part of its reference.
fn name(model: Node<'_>) -> String {
    let of_child = |name| {
        child(model, name)
            .map(text_of)
            .filter(|text| !text.is_empty())
    };
    let of_uri = || {
        let uri = of_child("uri")?;
        uri.rsplit('/')
            .find(|part| !part.is_empty())
            .map(Into::into)
    };
    if tag(model) == "model" {
        return attribute(model, "name").unwrap_or_default();
    }
    of_child("name").or_else(of_uri).unwrap_or_default()
}

/// Reads gravity, and the frames that the pose of the robot may be relative to.
fn read_world(
    reader: &mut Reader<'_, '_, '_>,
    world: Node<'_>,
    chosen: Node<'_>,
) -> Result<(), LoadError> {
    check(&mut reader.context, world, &schema::WORLD)?;
    let gravity = numbers::<3>(&mut reader.context, world, "gravity")?;
    if gravity.is_none() {
        let reason = "no <gravity>: taken as 0 0 -9.8, as the SDF says";
        reader.context.warn(world, reason);
    }
    reader.shared.scene.gravity = Some(gravity.unwrap_or(GRAVITY_OF_WORLD));
    for frame in children(world, "frame") {
        reader.frame(frame, WORLD)?;
    }
    for other in children(world, "model").filter(|model| *model != chosen) {
        read_neighbour(reader, other)?;
    }
    Ok(())
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
