//! Known content of a format's elements: whatever is not listed as read is reported as ignored.

use super::context::{Context, Node, is_native, tag};
use crate::error::LoadError;

/// Attributes and children that are read of a kind of element.
#[derive(Debug)]
pub(super) struct Known {
    attributes: &'static str,
    once: &'static str,
    repeated: &'static str,
}

fn has(names: &str, name: &str) -> bool {
    names.split(' ').any(|own| own == name)
}

/// An element with its attributes, the child elements of which the first is read, and those that are all read: names with spaces between.
pub(super) const fn known(
    attributes: &'static str,
    once: &'static str,
    repeated: &'static str,
) -> Known {
    Known {
        attributes,
        once,
        repeated,
    }
}

/// An element with attributes only.
pub(super) const fn leaf(attributes: &'static str) -> Known {
    known(attributes, "", "")
}

/// Reports what an element holds beyond what is read.
///
/// # Errors
/// If something is left for xacro to expand.
pub(super) fn check(
    context: &mut Context<'_>,
    node: Node<'_>,
    known: &Known,
) -> Result<(), LoadError> {
    check_attributes(context, node, known.attributes)?;
    let mut seen = Vec::new();
    for child in node.children() {
        if child.is_element() {
            check_child(context, child, known, &mut seen)?;
        } else if child.is_text() && !child.text().unwrap_or_default().trim().is_empty() {
            context.ignore(node, "text between the elements");
        }
    }
    Ok(())
}

/// Reports the attributes of an element beyond those that are read.
///
/// # Errors
/// If something is left for xacro to expand.
pub(super) fn check_attributes(
    context: &mut Context<'_>,
    node: Node<'_>,
    known: &str,
) -> Result<(), LoadError> {
    for attribute in node.attributes() {
        let (name, value) = (attribute.name(), attribute.value());
        if is_expression(value) {
            return Err(context.not_expanded(node, format!("{name}=\"{value}\"")));
        }
        if attribute.namespace().is_some() || !has(known, name) {
            context.ignore_attribute(
                node,
                name,
                "not read: no attribute of the format that is known here",
            );
        }
    }
    Ok(())
}

fn check_child<'a>(
    context: &mut Context<'_>,
    child: Node<'a>,
    known: &Known,
    seen: &mut Vec<&'a str>,
) -> Result<(), LoadError> {
    let name = tag(child);
    let namespace = child.tag_name().namespace().unwrap_or_default();
    if namespace.contains("xacro") && !is_native(child) {
        return Err(context.not_expanded(child, format!("<xacro:{name}>")));
    }
    if is_native(child) && has(known.once, name) {
        if seen.contains(&name) {
            context.ignore(child, format!("only the first <{name}> is read"));
        }
        seen.push(name);
    } else if !is_native(child) || !has(known.repeated, name) {
        match name {
            "gazebo" => ignore_settings(context, child),
            _ => context.ignore(child, reason(name)),
        }
    }
    Ok(())
}

/// Reason of an element that is not listed.
pub(super) const UNKNOWN: &str = "not read: no element of the format that is known here";

/// Settings of another simulator that change the motion, each with its counterpart here.
const PHYSICS: [(&str, &str); 15] = [
    ("kinematic", "links move by forces"),
    (
        "springStiffness",
        "set the spring of the joint in the model",
    ),
    (
        "springReference",
        "set the spring of the joint in the model",
    ),
    (
        "implicitSpringDamper",
        "Euler steps treat springs and dampers implicitly",
    ),
    ("dampingFactor", "velocities do not decay by themselves"),
    ("fudgeFactor", "joint limits are springs of Actuation"),
    ("stopCfm", "joint limits are springs of Actuation"),
    ("stopErp", "joint limits are springs of Actuation"),
    ("mu1", "the contact model sets the friction"),
    ("mu2", "the contact model sets the friction"),
    ("mu", "the contact model sets the friction"),
    ("kp", "the contact model sets the stiffness"),
    ("kd", "the contact model sets the damping"),
    ("minDepth", "the contact model sets the penetration depth"),
    (
        "selfCollide",
        "links of one robot have no contact with each other",
    ),
];

/// Settings that are read, of links and joints of a robot.
const READ: [&str; 3] = ["gravity", "turnGravityOff", "sensor"];

/// Reports settings of another simulator: those that change the motion one by one, the others together.
fn ignore_settings(context: &mut Context<'_>, gazebo: Node<'_>) {
    let of_robot = gazebo.parent().is_some_and(|parent| tag(parent) == "robot");
    let is_of_link = of_robot && gazebo.has_attribute("reference");
    let mut others = gazebo.children().filter(Node::is_element).count();
    for setting in gazebo.children().filter(Node::is_element) {
        if is_of_link && READ.contains(&tag(setting)) {
            others -= 1;
            continue;
        }
        let known = PHYSICS.iter().find(|(name, _)| *name == tag(setting));
        if let Some((name, instead)) = known {
            let text = setting.text().unwrap_or_default().trim();
            let reason = format!("<{name}> {text} of another simulator is not modelled: {instead}");
            context.ignore(setting, reason);
            others -= 1;
        }
    }
    if others > 0 || !gazebo.has_children() {
        context.ignore(gazebo, reason("gazebo"));
    }
}

/// Reason why an element is not read.
pub(super) fn reason(element: &str) -> &'static str {
    match element {
        "transmission" | "ros2_control" => {
            "inputs of joints are read of URDF files only, below <robot>"
        }
        "gpio" => "inputs and outputs of hardware are not modelled",
        "gazebo" | "plugin" => "settings of another simulator",
        "physics" | "ode" | "bullet" | "simbody" => "settings of a physics engine",
        "light" | "camera" | "scene" | "gui" | "projector" => "not a part of a robot",
        "self_collide" | "surface" | "max_contacts" => "contact settings are not read",
        "gripper" | "actor" | "audio_source" | "audio_sink" | "battery" => "not modelled",
        "sensor" | "force_torque" => "sensors are not modelled",
        "always_on" | "visualize" | "topic" | "enable_metrics" => {
            "concerns the programs of another simulator"
        }
        "calibration" => "reference positions for calibration are not used",
        "safety_controller" => "safety controllers are not modelled",
        "texture" => "textures are not shown",
        "stiffness" | "dissipation" => {
            "joint limits act in simulators with the actuation of the model, which chooses their stiffness and damping: set others as position limits of its actuators"
        }
        "verbose" | "contact_coefficients" | "contact" => "contact settings are not read",
        _ => UNKNOWN,
    }
}

/// `true` for what xacro replaces.
fn is_expression(text: &str) -> bool {
    text.contains("${") || text.contains("$(")
}
