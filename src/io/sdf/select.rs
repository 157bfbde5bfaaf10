//! Selects the model of a file that becomes the robot, or reads them all.

use super::entry::{name, read_model};
use super::reader::{Reader, candidates};
use super::scene::WORLD;
use super::world::{self, Joined};
use crate::error::LoadError;
use crate::io::context::{Node, children, tag};

/// Reads the robot, and what the joints of its world join to it; returns the index of its model.
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
    let world = chosen.parent_element().filter(|parent| *parent != root);
    let joined = world.map(|world| Joined::to(world, chosen));
    let is_joined = |model: Node<'_>| joined.as_ref().is_some_and(|joined| joined.has(model));
    for &other in &models {
        if other != chosen && !is_joined(other) {
            let reason = "another model than the one that is loaded";
            reader.context.ignore(other, reason);
        }
    }
    let Some(joined) = joined else {
        return read_model(reader, chosen);
    };
    joined.read_around(reader)?;
    let robot = read_model(reader, chosen)?;
    joined.read(reader)?;
    Ok(robot)
}

/// Reads all models of a file, with what stands around them, as one world.
pub(super) fn read_all(reader: &mut Reader<'_, '_, '_>, root: Node<'_>) -> Result<(), LoadError> {
    // No model is the robot, whose names would have no prefix.
    reader.shared.scene.robot = Some(WORLD);
    let worlds: Vec<Node<'_>> = children(root, "world").collect();
    if worlds.len() > 1 {
        return Err(LoadError::ModelChoice {
            file: reader.context.file.into(),
            reason: "there are several worlds, of which a file to be read whole has one".into(),
            names: worlds.iter().map(|world| name(*world)).collect(),
        });
    }
    for model in candidates(root) {
        read_model(reader, model)?;
    }
    if let Some(&world) = worlds.first() {
        world::read_all(reader, world)?;
    }
    if reader.shared.scene.links.is_empty() {
        return Err(reader.context.missing(root, "link"));
    }
    Ok(())
}

fn choose<'a>(
    reader: &Reader<'_, '_, '_>,
    models: &[Node<'a>],
    wanted: Option<&str>,
) -> Result<Node<'a>, LoadError> {
    let is_wanted = |model: &&Node<'_>| wanted.is_none_or(|wanted| name(**model) == wanted);
    let mut fitting = models.iter().filter(is_wanted);
    if wanted.is_none()
        && let Some(first) = all_joined(models)
    {
        return Ok(first);
    }
    let reason = match (fitting.next(), fitting.next(), wanted) {
        (Some(model), None, _) => return Ok(*model),
        (Some(_), Some(_), Some(wanted)) => format!("there are several models \"{wanted}\""),
        (Some(_), Some(_), None) => {
            "there are several models: choose one by the option model_name".to_owned()
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

/// The first of models that the joints of their world make one robot.
fn all_joined<'a>(models: &[Node<'a>]) -> Option<Node<'a>> {
    let first = *models.first()?;
    let world = first
        .parent_element()
        .filter(|parent| tag(*parent) == "world")?;
    let joined = Joined::to(world, first);
    let is_one = models.iter().all(|model| joined.has(*model));
    is_one.then_some(first)
}
