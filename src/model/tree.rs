//! The robot as an indented tree of text.

use std::fmt;

use super::parts::{Base, Limits};
use super::walk::Step;
use super::{JointSpec, Model, ModelBuilder};
use crate::joint::JointKind;

/// Levels of indentation that are drawn; deeper links show the innermost ones after an ellipsis, so that the text of a chain of any
/// length is linear in it.
const MAX_LEVELS: usize = 24;

/// A printable tree of links and joints; see [`Model::tree`].
#[derive(Clone, Debug)]
pub struct ModelTree {
    builder: ModelBuilder,
    summary: String,
}

impl Model<f64> {
    /// The robot as text: one line per link with its mass and its joint, indented by depth in the tree.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::samples;
    ///
    /// let text = samples::pendulum().tree().to_string();
    /// assert_eq!(text.lines().nth(2), Some("└── rod, 1 kg · pivot: continuous about (1, 0, 0)"));
    /// ```
    pub fn tree(&self) -> ModelTree {
        let base = if self.has_floating_base() {
            Base::Floating
        } else {
            Base::Fixed
        };
        let (nv, mass) = (self.nv(), self.total_mass());
        let plural = if nv == 1 { "" } else { "s" };
        let base = format!("{base:?}").to_lowercase();
        let summary = format!("{base} base, {nv} degree{plural} of freedom, {mass} kg");
        ModelTree {
            builder: self.to_builder(),
            summary,
        }
    }
}

impl fmt::Display for ModelTree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.builder.name, self.summary)?;
        // Whether the link at each level is the last of its parent.
        let mut is_last: Vec<bool> = Vec::new();
        for step in self.builder.walk() {
            is_last.truncate(step.depth);
            is_last.push(step.is_last);
            writeln!(f)?;
            indent(f, &is_last[1..])?;
            line(f, &step)?;
        }
        Ok(())
    }
}

fn indent(f: &mut fmt::Formatter<'_>, is_last: &[bool]) -> fmt::Result {
    let Some((&own, above)) = is_last.split_last() else {
        return Ok(());
    };
    let hidden = above.len().saturating_sub(MAX_LEVELS);
    if hidden > 0 {
        write!(f, "… ")?;
    }
    for &is_last in &above[hidden..] {
        f.write_str(if is_last { "    " } else { "│   " })?;
    }
    f.write_str(if own { "└── " } else { "├── " })
}

fn line(f: &mut fmt::Formatter<'_>, step: &Step<'_>) -> fmt::Result {
    write!(f, "{}", step.link.name)?;
    let mass = step.link.inertia.mass;
    if mass != 0.0 {
        write!(f, ", {mass} kg")?;
    }
    if let Some(joint) = step.joint {
        write!(f, " · {}: {}", joint.name, joint.kind)?;
        describe_motion(f, joint)?;
    }
    Ok(())
}

fn describe_motion(f: &mut fmt::Formatter<'_>, joint: &JointSpec) -> fmt::Result {
    let ([x, y, z], kind) = (<[f64; 3]>::from(joint.axis), joint.kind);
    if kind.has_axis() {
        let preposition = match kind {
            JointKind::Prismatic => "along",
            JointKind::Planar => "across",
            _ => "about",
        };
        write!(f, " {preposition} ({x}, {y}, {z})")?;
    }
    if let JointKind::Screw(pitch) = kind {
        write!(f, ", {} m/rad", pitch.metres_per_radian())?;
    }
    if kind != JointKind::Fixed {
        describe_limits(f, &joint.limits, kind)?;
    }
    if let Some(second) = &joint.second {
        let [x, y, z] = <[f64; 3]>::from(second.axis);
        write!(f, ", then ({x}, {y}, {z})")?;
        describe_limits(f, &second.limits, kind)?;
    }
    if let Some(mimic) = &joint.mimic {
        let (leader, ratio, offset) = (&mimic.leader, mimic.multiplier, mimic.offset);
        write!(f, ", = {ratio} · {leader} + {offset}")?;
    }
    Ok(())
}

fn describe_limits(f: &mut fmt::Formatter<'_>, limits: &Limits, kind: JointKind) -> fmt::Result {
    let (length, force) = match kind {
        JointKind::Prismatic => ("m", "N"),
        _ => ("rad", "N·m"),
    };
    if limits.lower.is_some() || limits.upper.is_some() {
        let end = |limit: Option<f64>| limit.map_or_else(String::new, |limit| limit.to_string());
        write!(f, ", {}..{} {length}", end(limits.lower), end(limits.upper))?;
    }
    if let Some(velocity) = limits.velocity {
        write!(f, ", {velocity} {length}/s")?;
    }
    if let Some(effort) = limits.effort {
        write!(f, ", {effort} {force}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{LinkSpec, Mimic, samples};

    #[test]
    fn printed_tree_equals_what_a_person_expects() {
        let mut builder = samples::cartpole().to_builder();
        builder.add_link(LinkSpec::new("camera"));
        builder.add_joint(JointSpec::new("mount", JointKind::Fixed, "cart", "camera"));
        builder.add_link(LinkSpec::new("bob").with_mass(0.25, [0.0; 3], [0.01; 3]));
        let hinge = JointSpec::new("hinge", JointKind::Revolute, "pole", "bob");
        let leader = "pivot".into();
        builder.add_joint(hinge.with_mimic(Mimic {
            leader,
            multiplier: 2.0,
            offset: 0.5,
        }));
        let text = builder.build().unwrap().tree().to_string();
        let expected = "\
cartpole: fixed base, 2 degrees of freedom, 1.75 kg
world
└── cart, 1 kg · linear: prismatic along (0, 1, 0), -2.4..2.4 m, 10 m/s, 500 N
    ├── pole, 0.5 kg · pivot: continuous about (1, 0, 0)
    │   └── bob, 0.25 kg · hinge: revolute about (1, 0, 0), = 2 · pivot + 0.5
    └── camera · mount: fixed";
        assert_eq!(text, expected);
    }

    #[test]
    fn text_of_a_long_chain_is_linear_in_its_length() {
        let chain = |n: usize| {
            let mut builder = ModelBuilder::new("chain").with_base(Base::Fixed);
            builder.add_link(LinkSpec::new("0"));
            for i in 0..n {
                let child = (i + 1).to_string();
                builder.add_link(LinkSpec::new(&child).with_mass(1.0, [0.0; 3], [1.0; 3]));
                let kind = JointKind::Continuous;
                builder.add_joint(JointSpec::new(format!("j{i}"), kind, i.to_string(), child));
            }
            builder.build().unwrap().tree().to_string().len()
        };
        let (short, long) = (chain(2_000), chain(20_000));
        assert!(long < 11 * short, "{short} and {long} bytes");
    }
}
