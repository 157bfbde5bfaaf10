//! Diffuse colours.

use crate::nested::IntoNested;
use std::collections::HashMap;

use roxmltree::NodeId;

use super::{Ids, numbers};
use crate::input::xml::{Node, child, children};
use crate::io::mesh::soup::Color;
use crate::scalar::MapEach;

/// The colour of an effect that gives none, or a picture.
const DEFAULT: Color = Some([0.6, 0.6, 0.6, 1.0]);

/// The elements under `<technique>` that hold colours.
const SHADERS: [&str; 4] = ["phong", "lambert", "blinn", "constant"];

/// The colours of materials, each found once.
#[derive(Default)]
pub(super) struct Colors<'a> {
    /// Colours of materials and effects.
    known: HashMap<NodeId, Color>,
    /// Colours of the instances that draw a shape, by the names that the shape uses.
    bound: HashMap<NodeId, HashMap<&'a str, Color>>,
}

impl<'a> Colors<'a> {
    /// The colours that an instance of a shape binds to the names of materials.
    pub(super) fn bound(
        &mut self,
        instance: Node<'a>,
        ids: &Ids<'a>,
    ) -> Result<&HashMap<&'a str, Color>, String> {
        if !self.bound.contains_key(&instance.id()) {
            let technique =
                child(instance, "bind_material").and_then(|bind| child(bind, "technique_common"));
            let mut bound = HashMap::new();
            for node in technique
                .into_iter()
                .nested(|technique| children(technique, "instance_material"))
            {
                let material = ids.target(node, "target");
                if let (Some(name), Some(material)) = (node.attribute("symbol"), material) {
                    bound.insert(name, self.of_material(material, ids)?);
                }
            }
            self.bound.insert(instance.id(), bound);
        }
        Ok(&self.bound[&instance.id()])
    }

    /// The colour of a `<material>`; `None` if it refers to no effect.
    fn of_material(&mut self, material: Node<'a>, ids: &Ids<'a>) -> Result<Color, String> {
        if let Some(&known) = self.known.get(&material.id()) {
            return Ok(known);
        }
        let effect = child(material, "instance_effect").and_then(|node| ids.target(node, "url"));
        let color = effect.map_or(Ok(None), |effect| self.of_effect(effect))?;
        self.known.insert(material.id(), color);
        Ok(color)
    }

    fn of_effect(&mut self, effect: Node<'_>) -> Result<Color, String> {
        if let Some(&known) = self.known.get(&effect.id()) {
            return Ok(known);
        }
        let technique = child(effect, "profile_COMMON").and_then(|node| child(node, "technique"));
        let shader = technique.and_then(|node| SHADERS.iter().find_map(|name| child(node, name)));
        let diffuse = shader.and_then(|node| child(node, "diffuse"));
        let color = match diffuse.and_then(|node| child(node, "color")) {
            Some(color) => Some(numbers::<4>(color)?.map_each(|x| x as f32)),
            None => DEFAULT,
        };
        self.known.insert(effect.id(), color);
        Ok(color)
    }
}
