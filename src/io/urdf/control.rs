//! Inputs of joints: `<ros2_control>` and, in `transmission.rs`, `<transmission>`.
//!
//! A command interface is a quantity *of the joint*: its effort, position or velocity. The law of a position or velocity interface is that of the PID
//! controllers of ROS without integral: effort = p (command − position) − d velocity, or p (command − velocity). A description may contain the gains, as parameters of
//! the interface or of the joint:
//!
//! | gain | names, in any case |
//! |---|---|
//! | proportional, of a position | `pos_kp`, `position_kp`, `kp`, `position_p`, `p` |
//! | proportional, of a velocity | `vel_kp`, `velocity_kp`, `kp`, `velocity_p`, `p` |
//! | derivative, of a position | the same with `d` in place of `p` |
//!
//! Without gains, the input of the joint is its effort, with a warning. Gains, ranges and reductions are needed by simulators only, so that a bad one is
//! a warning and not an error.
//!
//! # References
//! The hardware descriptions of `ros2_control`, `gazebo_ros2_control` (`pos_kp`, …) and `mujoco_ros2_control` (`position_kp`, `kp`, …).

use std::collections::{HashMap, HashSet};

use super::schema;
use crate::error::LoadError;
use crate::io::context::{Context, Node, child, children, tag};
use crate::io::schema::check;
use crate::io::values::parse;
use crate::joint::JointKind;
use crate::scalar::MapEach;
use crate::sim::Servo;

/// A joint with an input.
#[derive(Debug)]
pub(super) struct Command<'a> {
    pub(super) joint: &'a str,
    pub(super) place: Node<'a>,
    /// `None` if the input is the effort, without a range.
    pub(super) servo: Option<Servo>,
    /// Turns of the motor for one of the joint, where a transmission states them.
    pub(super) gear: Option<f64>,
}

/// A joint that may have an input.
#[derive(Clone, Copy, Debug)]
pub(super) struct Movable {
    pub(super) kind: JointKind,
    /// Whether it has no coordinates of its own.
    pub(super) follows: bool,
}

/// Joints with inputs, in the order of the file, and where each joint is among them.
#[derive(Debug, Default)]
pub(super) struct Commands<'a> {
    all: Vec<Command<'a>>,
    of_joint: HashMap<&'a str, usize>,
}

impl<'a> Commands<'a> {
    /// Adds a joint; of a joint that is there already the first stays that of [`find`](Self::find).
    pub(super) fn push(&mut self, command: Command<'a>) {
        let next = self.all.len();
        self.of_joint.entry(command.joint).or_insert(next);
        self.all.push(command);
    }

    pub(super) fn find(&mut self, joint: &str) -> Option<&mut Command<'a>> {
        let index = *self.of_joint.get(joint)?;
        self.all.get_mut(index)
    }
}

/// Quantity of an interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Effort,
    Position,
    Velocity,
}

/// Reason of remarks on a joint whose gains are not in the file.
pub(super) const NO_GAINS: &str = "no gains in the file: the input of the joint is its effort; set a servo of it in the actuation";

impl Quantity {
    /// The quantity of a name of `ros2_control`, where it is modelled.
    fn of(name: &str) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        match name.strip_suffix("_pid").unwrap_or(&name) {
            "effort" => Some(Self::Effort),
            "position" => Some(Self::Position),
            "velocity" => Some(Self::Velocity),
            _ => None,
        }
    }

    /// Names of a gain.
    ///
    /// * `letter` – p or d
    fn names(self, letter: char) -> [String; 5] {
        let [short, long] = match self {
            Self::Velocity => ["vel", "velocity"],
            _ => ["pos", "position"],
        };
        [
            format!("{short}_k{letter}"),
            format!("{long}_k{letter}"),
            format!("k{letter}"),
            format!("{long}_{letter}"),
            letter.to_string(),
        ]
    }
}

/// Reads an element `<ros2_control>`, except for its transmissions.
pub(super) fn read<'a>(
    context: &mut Context<'_>,
    control: Node<'a>,
    commands: &mut Commands<'a>,
) -> Result<(), LoadError> {
    check(context, control, &schema::CONTROL)?;
    for hardware in children(control, "hardware") {
        context.ignore(
            hardware,
            "drivers of hardware and their parameters are not used",
        );
    }
    for joint in children(control, "joint") {
        check(context, joint, &schema::CONTROLLED)?;
        read_joint(context, joint, commands);
    }
    Ok(())
}

/// Reads the interfaces of a joint: the first that is modelled, with gains if it needs them, becomes its input.
fn read_joint<'a>(context: &mut Context<'_>, joint: Node<'a>, commands: &mut Commands<'a>) {
    let name = joint.attribute("name").unwrap_or_default();
    for state in children(joint, "state_interface") {
        for param in children(state, "param") {
            context.ignore(param, "not used: states start where the program says");
        }
    }
    let mut shared = Parameters::of(joint);
    let (mut taken, mut seen) = (None, Vec::new());
    let mut without_gains = Vec::new();
    for interface in children(joint, "command_interface") {
        let kind = interface.attribute("name").unwrap_or_default();
        let Some(quantity) = Quantity::of(kind) else {
            context.ignore(
                interface,
                format!("commands of \"{kind}\" are not modelled"),
            );
            continue;
        };
        if taken.is_some() || seen.contains(&quantity) {
            context.ignore(interface, "the joint has another input");
            continue;
        }
        seen.push(quantity);
        let mut own = Parameters::of(interface);
        match servo(context, quantity, [&mut own, &mut shared], interface) {
            Some(servo) => {
                own.ignore_others(context);
                taken = Some((interface, servo));
            }
            None => without_gains.push(interface),
        }
    }
    for interface in &without_gains {
        match taken.is_some() {
            true => context.ignore(
                *interface,
                "no gains in the file: the joint has another input",
            ),
            false => context.warn(*interface, NO_GAINS),
        }
    }
    shared.ignore_others(context);
    let first = without_gains.first().map(|&interface| (interface, None));
    if let Some((place, servo)) = taken.or(first) {
        commands.push(Command {
            joint: name,
            place,
            servo,
            gear: None,
        });
    }
}

/// The law of an interface: its servo, or `None` in it for an effort without a range; `None` without gains.
fn servo(
    context: &mut Context<'_>,
    quantity: Quantity,
    mut parameters: [&mut Parameters<'_>; 2],
    interface: Node<'_>,
) -> Option<Option<Servo>> {
    let mut gain = |letter| {
        let names = quantity.names(letter);
        (parameters.iter_mut()).find_map(|own| own.take(context, &names))
    };
    let servo = match quantity {
        Quantity::Effort => Servo::torque(1.0),
        Quantity::Position => Servo::position(gain('p')?, gain('d').unwrap_or(0.0)),
        Quantity::Velocity => Servo::velocity(gain('p')?),
    };
    let [own, _] = parameters;
    let range = range(context, own, interface);
    let is_plain = quantity == Quantity::Effort && range.is_none();
    Some(match range {
        Some([lower, upper]) => Some(servo.with_input_range(lower, upper)),
        None => (!is_plain).then_some(servo),
    })
}

/// Least and largest command of an interface, if it has any that count.
fn range(
    context: &mut Context<'_>,
    own: &mut Parameters<'_>,
    interface: Node<'_>,
) -> Option<[f64; 2]> {
    let limits = child(interface, "limits").and_then(|limits| limits.attribute("enable"));
    if limits.is_some_and(|enable| enable.trim().eq_ignore_ascii_case("false")) {
        return None;
    }
    let [lower, upper] = ["min", "max"].map_each(|name| own.take(context, &[name.to_owned()]));
    // Ends of ranges are finite.
    let range = [lower.unwrap_or(f64::MIN), upper.unwrap_or(f64::MAX)];
    if range[0] > range[1] {
        context.warn(interface, "the range of its commands is empty: not used");
        return None;
    }
    lower.or(upper).map(|_| range)
}

/// The elements `<param>` of an element, and whether they are used.
struct Parameters<'a>(Vec<(Node<'a>, bool)>);

impl<'a> Parameters<'a> {
    fn of(node: Node<'a>) -> Self {
        Self(children(node, "param").map(|own| (own, false)).collect())
    }

    /// The number of the first parameter with one of these names, if it is one.
    fn take(&mut self, context: &mut Context<'_>, names: &[String]) -> Option<f64> {
        let named = |(node, _): &(Node<'_>, bool), name: &str| {
            let own = node.attribute("name");
            own.is_some_and(|own| own.trim().eq_ignore_ascii_case(name))
        };
        let places = |name: &String| self.0.iter().position(|own| named(own, name));
        let (node, used) = names.iter().find_map(places).map(|k| &mut self.0[k])?;
        *used = true;
        number(context, *node)
    }

    /// Reports those that are not used.
    fn ignore_others(&self, context: &mut Context<'_>) {
        for (node, _) in self.0.iter().filter(|(_, used)| !used) {
            context.ignore(*node, "not used: no gain or range that is modelled");
        }
    }
}

/// The finite number in the text of an element, or a warning.
pub(super) fn number(context: &mut Context<'_>, node: Node<'_>) -> Option<f64> {
    let text = node.text().unwrap_or_default().trim();
    match parse(text) {
        Ok([x]) if f64::is_finite(x) => Some(x),
        _ => {
            let shown: String = text.chars().take(40).collect();
            context.warn(
                node,
                format!("\"{shown}\" is not a finite number: not used"),
            );
            None
        }
    }
}

impl Command<'_> {
    /// Its servo, with the law that it has at the joint stated for a motor behind the gear.
    fn servo(&self, context: &mut Context<'_>) -> Option<Servo> {
        let Some(n) = self.gear.filter(|&n| n != 1.0) else {
            return self.servo;
        };
        let own = self.servo.unwrap_or(Servo::torque(1.0));
        let geared = Servo {
            gear: n,
            gain: own.gain / n,
            position_gain: own.position_gain / (n * n),
            velocity_gain: own.velocity_gain / (n * n),
            ..own
        };
        let gains = [
            geared.gain,
            geared.position_gain,
            geared.velocity_gain,
            n * n,
        ];
        if gains.iter().all(|x| x.is_finite()) {
            return Some(geared);
        }
        let reason = format!("not used: gains behind a reduction of {n} are not finite");
        context.warn(self.place, reason);
        self.servo
    }

    /// Why the joint has no input.
    fn lack(joint: Option<&Movable>) -> Option<&'static str> {
        let Some(joint) = joint else {
            return Some("there is no joint of this name");
        };
        if joint.follows {
            return Some("the joint follows another one");
        }
        match (joint.kind.nq(), joint.kind.nv()) {
            (_, 0) => Some("the joint does not move"),
            (1, 1) => None,
            _ => Some("the joint has several degrees of freedom"),
        }
    }
}

/// The joints that have inputs, with their servos; reports the others.
pub(super) fn finish(
    commands: &Commands<'_>,
    joints: &HashMap<&str, Movable>,
    context: &mut Context<'_>,
) -> Vec<(String, Option<Servo>)> {
    let mut taken = HashSet::new();
    let mut out = Vec::new();
    for own in &commands.all {
        let lack = Command::lack(joints.get(own.joint));
        let twice = (!taken.insert(own.joint)).then_some("the joint has another input");
        match lack.or(twice) {
            Some(lack) => {
                let (kind, joint) = (tag(own.place), own.joint);
                context.ignore(own.place, format!("<{kind}> of \"{joint}\": {lack}"));
            }
            None => {
                let servo = own.servo(context);
                out.push((own.joint.to_owned(), servo));
            }
        }
    }
    out
}
