//! Remarks on elements and attributes that were not read.

use std::collections::HashMap;

use super::actuator;
use super::tree::{Node, Tree};
use crate::io::context::Context;

/// Reason of an element that is not listed.
const ELEMENT: &str = "not read: no element of the format that is known here";

/// Reason of an attribute that is not listed.
const ATTRIBUTE: &str = "not read: no attribute of the format that is known here";

/// Remarks on all elements and attributes that were not read, with their lines.
pub(super) fn note(tree: &Tree, context: &mut Context<'_>) {
    let mut looks: HashMap<(&str, &str), (Node<'_>, usize)> = HashMap::new();
    let mut order = Vec::new();
    // Children come behind their parents: those of an element that was not read are not named again.
    let mut is_inside = vec![false; tree.elements.len()];
    for node in tree.nodes() {
        let element = node.element();
        if !element.is_read.get() || is_inside[node.index] {
            if !is_inside[node.index] {
                context.ignore(&node.place(), element_reason(node.tag()));
            }
            element
                .children
                .iter()
                .for_each(|&child| is_inside[child] = true);
            continue;
        }
        let in_defaults = tree.node(element.section).tag() == "default";
        for attribute in element.attributes.iter().filter(|own| !own.is_read.get()) {
            let pair = (node.tag(), &*attribute.name);
            if is_idle(pair.1) || in_defaults && is_known(tree, pair) {
                continue;
            }
            if is_look(pair) {
                let first = looks.entry(pair).or_insert_with(|| {
                    order.push(pair);
                    (node, 0)
                });
                first.1 += 1;
                continue;
            }
            let mut place = node.place();
            place.note.path.extend(["@", &attribute.name]);
            context.ignore(&place, attribute_reason(pair));
        }
    }
    for pair in order {
        let (node, times) = looks[&pair];
        let mut place = node.place();
        place.note.path.extend(["@", pair.1]);
        let reason = match times {
            1 => "visual attributes are not read".to_owned(),
            _ => format!("visual attributes are not read: {times} times, first here"),
        };
        context.ignore(&place, reason);
    }
}

/// A default counts as read if elements of its tag are requested it, or if there are none; those of actuators that are not modelled are
/// remarked on one by one.
fn is_known(tree: &Tree, (tag, name): (&str, &str)) -> bool {
    actuator::KINDS.contains(&tag)
        || matches!(tag, "pair" | "camera" | "light")
        || tree.was_asked(tag, name)
        || !tree.has_asked(tag)
}

/// Attributes without effect on the motion.
fn is_idle(name: &str) -> bool {
    matches!(name, "name" | "class" | "user" | "childclass" | "info")
}

/// Attributes that change how something is drawn.
fn is_look((tag, name): (&str, &str)) -> bool {
    match tag {
        "material" | "texture" => true,
        _ => matches!(
            name,
            "group"
                | "width"
                | "rgba"
                | "material"
                | "normal"
                | "texcoord"
                | "facenormal"
                | "facetexcoord"
                | "smoothnormal"
                | "maxhullvert"
        ),
    }
}

fn element_reason(tag: &str) -> &'static str {
    match tag {
        "camera" | "light" | "visual" | "texture" | "skin" => "not a part of a robot",
        "statistic" => "scales of another viewer",
        "size" => "memory of another simulator",
        "custom" => "values for other programs",
        "extension" | "plugin" => "plug-ins of another simulator",
        "spatial" => "spatial tendons are not modelled",
        "deformable" | "flexcomp" | "composite" | "flex" => {
            "deformable and composite bodies are not modelled"
        }
        "inertial" => "the world has no inertia",
        "flag" | "lengthrange" => "settings of another simulator",
        _ => ELEMENT,
    }
}

fn attribute_reason((tag, name): (&str, &str)) -> &'static str {
    match (tag, name) {
        ("option", "wind" | "density" | "viscosity") => "fluid forces are not modelled",
        ("option", "magnetic") => "magnetic fields are not modelled",
        ("option", _) => "a setting of another simulator",
        ("flag", "actuation" | "spring" | "damper" | "clampctrl") => {
            "not modelled: these forces act here"
        }
        ("flag", _) => "a setting of another simulator",
        ("compiler", _) => "a setting of another simulator's compiler",
        (_, "solreflimit" | "solimplimit") => {
            "joint limits act in simulators with the actuation of the model, which chooses their stiffness and damping"
        }
        (_, "solreffriction" | "solimpfriction") => "friction of joints is Coulomb's",
        ("joint", "margin") | ("tendon" | "fixed", "margin") => "limits act from the limit itself",
        ("joint", "actuatorgravcomp") => "gravity compensation does not count as an actuator force",
        ("geom", "fluidshape" | "fluidcoef") => "fluid forces are not modelled",
        ("geom", "fitscale") => "belongs to a shape that is not read",
        ("fixed" | "tendon", "range" | "limited" | "frictionloss" | "armature") => {
            "limits, friction and inertia of tendons are not modelled"
        }
        ("key", "act" | "mpos" | "mquat") => "belongs to something that is not modelled",
        ("body", "sleep") => {
            "where islands sleep, all bodies without inputs and external forces may"
        }
        ("mesh", _) => "meshes are read as they are in their files",
        _ => ATTRIBUTE,
    }
}
