//! Joints as the file states them.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::compiler::Compiler;
use super::entry::Entry;
use super::orientation::direction;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::place::SourcePlace;
use crate::model::{Limits, SecondAxis as Axis, Spring};
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// Kinds of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Hinge,
    Slide,
    Ball,
    Free,
}

const KINDS: [(&str, Kind); 4] = [
    ("hinge", Kind::Hinge),
    ("slide", Kind::Slide),
    ("ball", Kind::Ball),
    ("free", Kind::Free),
];

impl Kind {
    pub(super) fn nq(self) -> usize {
        match self {
            Self::Hinge | Self::Slide => 1,
            Self::Ball => 4,
            Self::Free => 7,
        }
    }

    pub(super) fn nv(self) -> usize {
        match self {
            Self::Hinge | Self::Slide => 1,
            Self::Ball => 3,
            Self::Free => 6,
        }
    }

    pub(super) fn is_single(self) -> bool {
        self.nv() == 1
    }
}

/// A joint of a body.
#[derive(Clone, Debug)]
pub(super) struct JointEntry {
    /// Its name; empty until one is made up, where it has none.
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Point on the axes, in the body, m.
    pub(super) anchor: Vector3<f64>,
    /// Axis in the body, limits, forces along it.
    pub(super) axis: Axis,
    /// Coordinate of the pose that the file states, rad or m.
    pub(super) reference: f64,
    /// Time constant (s) and damping ratio of a spring and damper, if they are requested.
    pub(super) springdamper: Option<[f64; 2]>,
    pub(super) place: SourcePlace,
}

impl JointEntry {
    /// `true` if a force acts on the joint by itself.
    pub(super) fn is_passive(&self) -> bool {
        let Axis {
            damping,
            friction,
            armature,
            ..
        } = self.axis;
        [damping, friction, armature] != [0.0; 3]
    }
}

/// Reads a joint.
///
/// * `X_BF` – pose of its parent frame, in the body
pub(super) fn read(
    entry: &Entry<'_, '_>,
    compiler: &Compiler,
    X_BF: &Transform<f64>,
    context: &mut Context<'_>,
) -> Result<JointEntry, LoadError> {
    let kind = match entry.node.tag() {
        "freejoint" => Kind::Free,
        _ => entry.word("type", &KINDS)?.unwrap_or(Kind::Hinge),
    };
    let place = entry.node.place();
    let axis = entry.numbers::<3>("axis")?.unwrap_or([0.0, 0.0, 1.0]);
    let unit = direction(&axis.into()).unwrap_or_default();
    let anchor = entry.numbers::<3>("pos")?.unwrap_or_default();
    let turns = if kind == Kind::Hinge {
        compiler.angle
    } else {
        1.0
    };
    let mut out = JointEntry {
        name: String::new(),
        kind,
        anchor: X_BF.point(&anchor.into()),
        reference: entry.number("ref")?.unwrap_or_default() * turns,
        axis: Axis {
            axis: X_BF.rotation * unit,
            limits: limits(entry, compiler, kind, context)?,
            damping: first(entry, "damping", context)?,
            friction: entry.number("frictionloss")?.unwrap_or_default(),
            armature: entry.number("armature")?.unwrap_or_default(),
            spring: Spring {
                stiffness: first(entry, "stiffness", context)?,
                rest: entry.number("springref")?.unwrap_or_default() * turns,
            },
        },
        springdamper: entry.numbers::<2>("springdamper")?,
        place,
    };
    if !kind.is_single() {
        without_springs(&mut out, context);
    }
    Ok(out)
}

/// A coefficient; those of higher powers are not used.
pub(super) fn first(
    entry: &Entry<'_, '_>,
    name: &'static str,
    context: &mut Context<'_>,
) -> Result<f64, LoadError> {
    /// Most coefficients that a file can hold.
    const MAX_POWERS: usize = 10;
    let numbers = entry.list(name, MAX_POWERS)?.unwrap_or_default();
    if numbers.iter().skip(1).any(|&x| x != 0.0) {
        let reason = format!("only the first number of {name} is used: forces are linear");
        context.ignore(&entry.node.place(), reason);
    }
    Ok(numbers.first().copied().unwrap_or_default())
}

fn limits(
    entry: &Entry<'_, '_>,
    compiler: &Compiler,
    kind: Kind,
    context: &mut Context<'_>,
) -> Result<Limits, LoadError> {
    let mut limits = Limits::default();
    // Free joints have no limits, whatever they or a default say.
    if kind == Kind::Free {
        for name in ["limited", "range", "actuatorfrclimited", "actuatorfrcrange"] {
            let _ = entry.value(name);
        }
        return Ok(limits);
    }
    let range = entry.range("range", "limited", compiler.autolimits)?;
    match (range, kind) {
        (Some(range), Kind::Hinge) => {
            [limits.lower, limits.upper] = range.map_each(|x| Some(x * compiler.angle));
        }
        (Some(range), Kind::Slide) => [limits.lower, limits.upper] = range.map_each(Some),
        (Some(_), Kind::Ball) => {
            context.ignore(
                &entry.node.place(),
                "the range of a ball joint is not modelled",
            );
        }
        _ => {}
    }
    let efforts = entry.range(
        "actuatorfrcrange",
        "actuatorfrclimited",
        compiler.autolimits,
    )?;
    limits.effort = efforts.map(|range| symmetric(range, &entry.node.place(), context));
    Ok(limits)
}

/// The size of a range; remarks on one whose ends are not opposite.
pub(super) fn symmetric(
    [lower, upper]: [f64; 2],
    place: &SourcePlace,
    context: &mut Context<'_>,
) -> f64 {
    let size = upper.abs().max(lower.abs());
    if lower != -upper {
        let reason = format!("the range of efforts {lower} to {upper} is taken as ±{size}");
        context.warn(place, reason);
    }
    size
}

/// Springs need one coordinate.
fn without_springs(joint: &mut JointEntry, context: &mut Context<'_>) {
    let wanted = joint.axis.spring.stiffness != 0.0 || joint.springdamper.is_some();
    if wanted {
        context.ignore(&joint.place, "springs act on hinges and slides only");
    }
    joint.axis.spring = Spring::default();
    joint.springdamper = None;
    joint.reference = 0.0;
    if joint.kind == Kind::Free && joint.axis.armature != 0.0 {
        let reason =
            "the rotor inertia of a free joint acts along the axes of the body, not of the world";
        context.warn(&joint.place, reason);
    }
}
