//! Equalities as constraints.
//!
//! Constrained quantities are measured from the configuration of the bodies in the file, as in `MuJoCo`:
//! `connect` holds the points together that coincide there, `weld` without a pose keeps that of the second body in the first, and
//! `joint` ties displacements, q₁ − q₁⁰ = p(q₂ − q₂⁰) with a polynomial p. The constraints are [soft](super::softness), as there. The row of a curved p
//! contains the acceleration p″ q̇₂², which `MuJoCo` leaves out.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::{BTreeMap, HashMap};

use super::entry::Entry;
use super::orientation::pose_of;
use super::scene::MjcfTendon;
use super::sections::Names;
use super::softness::{InverseInertias, soften, torque_scale};
use super::walk::Part;
use crate::constraint::Constraint;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::model::Model;
use crate::nested::IntoNested;
use crate::spatial::Transform;

/// Model with the configuration of the file, names and tendons.
pub(super) struct Reference<'a> {
    pub(super) model: &'a Model,
    pub(super) q: &'a [f64],
    pub(super) names: &'a Names,
    /// Fixed tendons by name.
    pub(super) tendons: HashMap<&'a str, &'a MjcfTendon>,
    pub(super) inverses: InverseInertias<'a>,
    /// s.
    pub(super) time_step: f64,
}

/// Reads an equality; `None`, with a remark, if it is not active or cannot be modelled.
pub(super) fn read(
    part: &Part<'_, '_>,
    at: &Reference<'_>,
    context: &mut Context<'_>,
) -> Result<Option<Constraint>, LoadError> {
    let entry = part.entry(&["equality"])?;
    let place = entry.node.place();
    check(&entry)?;
    if !entry.flag("active", true)? {
        entry.node.read_all();
        context.ignore(&place, "is not active");
        return Ok(None);
    }
    let found = match entry.node.tag() {
        "connect" => at.connect(part, &entry)?,
        "weld" => at.weld(part, &entry)?,
        "joint" => at.joint(part, &entry)?,
        "tendon" => at.tendon(part, &entry)?,
        _ => Err("is not modelled"),
    };
    let found = found.and_then(|constraint| match is_finite(&constraint) {
        true => Ok(constraint),
        false => Err(OUT_OF_RANGE),
    });
    match found {
        Ok(constraint) => {
            let inverses = at.inverses_of(part, &entry, constraint.kind());
            soften(constraint, &entry, inverses, at.time_step).map(Some)
        }
        Err(reason) => {
            entry.node.read_all();
            context.ignore(&place, reason);
            Ok(None)
        }
    }
}

/// Checks that an equality names two different elements.
fn check(entry: &Entry<'_, '_>) -> Result<(), LoadError> {
    const BOTH: [[&str; 2]; 4] = [
        ["body1", "body2"],
        ["site1", "site2"],
        ["joint1", "joint2"],
        ["tendon1", "tendon2"],
    ];
    for [one, other] in BOTH {
        if entry
            .text(other)
            .is_some_and(|text| entry.text(one) == Some(text))
        {
            return Err(entry.malformed(other, "is the same as the first one"));
        }
    }
    Ok(())
}

/// Reason of a constraint with numbers that overflow.
const OUT_OF_RANGE: &str = "has numbers that are out of range";

fn is_finite(constraint: &Constraint) -> bool {
    let anchors = constraint.kind().anchors().iter();
    let mut numbers = anchors.nested(|anchor| {
        let X = &anchor.placement;
        X.translation.iter().chain(X.rotation.iter())
    });
    numbers.all(|x| x.is_finite())
}

/// A constraint, or the reason why it is not supported.
type Found = Result<Constraint, &'static str>;

impl Reference<'_> {
    fn connect(&self, part: &Part<'_, '_>, entry: &Entry<'_, '_>) -> Result<Found, LoadError> {
        if let Some(anchors) = self.sites(part, entry)? {
            return Ok(Ok(Constraint::ball(anchors)));
        }
        let [X_W1, X_W2] = self.bodies(part, entry)?;
        let point = entry.numbers::<3>("anchor")?;
        let point = point.ok_or_else(|| entry.missing("anchor"))?;
        let X_1A = Transform::from_translation(point.into());
        let X_2A = X_W2.X_WB.inverse() * X_W1.X_WB * X_1A;
        Ok(Ok(Constraint::ball([X_W1.anchor(X_1A), X_W2.anchor(X_2A)])))
    }

    fn weld(&self, part: &Part<'_, '_>, entry: &Entry<'_, '_>) -> Result<Found, LoadError> {
        // Without a torque scale nothing holds the orientation.
        let made = match torque_scale(entry)? {
            0.0 => Constraint::ball,
            _ => Constraint::weld,
        };
        if let Some(anchors) = self.sites(part, entry)? {
            return Ok(Ok(made(anchors)));
        }
        let [first, second] = self.bodies(part, entry)?;
        let point = entry.some_numbers("anchor", [0.0; 3])?;
        let X_2A = Transform::from_translation(point.into());
        let relative = entry.numbers::<7>("relpose")?;
        let given = relative.and_then(pose_of);
        // A given pose is that of the anchor, as in `MuJoCo`.
        let X_1A = given.unwrap_or_else(|| first.X_WB.inverse() * second.X_WB * X_2A);
        let anchors = [first.anchor(X_1A), second.anchor(X_2A)];
        Ok(Ok(made(anchors)))
    }

    fn joint(&self, part: &Part<'_, '_>, entry: &Entry<'_, '_>) -> Result<Found, LoadError> {
        let coefficients = entry.some_numbers("polycoef", [0.0, 1.0, 0.0, 0.0, 0.0])?;
        let one = self.joint_named(part, entry, "joint1")?;
        let one = one.ok_or_else(|| entry.missing("joint1"))?;
        let other = self.joint_named(part, entry, "joint2")?;
        let (Some(q1), Some(q2)) = (
            self.rest(&one),
            other.as_deref().map_or(Some(0.0), |j| self.rest(j)),
        ) else {
            return Ok(Err("a joint that it ties is locked"));
        };
        Ok(match other {
            None => self.tied(&[(&one, 1.0)], q1 + coefficients[0]),
            Some(other) => {
                let mut own = moved_by(coefficients, q2);
                own[0] += q1;
                if own.iter().any(|c| !c.is_finite()) {
                    return Ok(Err(OUT_OF_RANGE));
                }
                let made = Constraint::polynomial_coupler(self.model, [&one, &other], own);
                made.map_err(|_| "ties a joint that is not there")
            }
        })
    }

    fn tendon(&self, part: &Part<'_, '_>, entry: &Entry<'_, '_>) -> Result<Found, LoadError> {
        let [c0, c1, higher @ ..] = entry.some_numbers("polycoef", [0.0, 1.0, 0.0, 0.0, 0.0])?;
        let find = |name: &'static str| {
            let own = entry.text(name).map(|text| part.naming.of(text));
            own.map(|own| self.tendons.get(own.as_str()).copied())
        };
        let one = find("tendon1").ok_or_else(|| entry.missing("tendon1"))?;
        let other = find("tendon2");
        let (Some(one), true) = (one, other != Some(None)) else {
            return Ok(Err("ties a tendon that is not modelled"));
        };
        let other = other.flatten();
        if other.is_some() && higher != [0.0; 3] {
            return Ok(Err("is not linear"));
        }
        // L₁ − L₁⁰ = c₀ + c₁ (L₂ − L₂⁰)
        let mut sum: BTreeMap<&str, f64> = BTreeMap::new();
        let mut length = c0;
        let second = other.map(|tendon| (tendon, -c1));
        for (tendon, factor) in [(one, 1.0)].into_iter().chain(second) {
            for (joint, c) in &tendon.joints {
                let Some(q) = self.rest(joint) else {
                    return Ok(Err("a joint that it ties is locked"));
                };
                length += factor * c * q;
                *sum.entry(joint).or_default() += factor * c;
            }
        }
        let sum: Vec<(&str, f64)> = sum.into_iter().collect();
        Ok(self.tied(&sum, length))
    }

    fn tied(&self, joints: &[(&str, f64)], length: f64) -> Found {
        if joints.iter().all(|&(_, c)| c == 0.0) {
            return Err("ties nothing");
        }
        if !length.is_finite() || joints.iter().any(|(_, c)| !c.is_finite()) {
            return Err(OUT_OF_RANGE);
        }
        let made = Constraint::tendon(self.model, joints, length);
        made.map_err(|_| "ties a joint that is not there")
    }

    /// Coordinate of a hinge or slide in the configuration of the file; `None` if the model has no such joint.
    fn rest(&self, joint: &str) -> Option<f64> {
        let range = self.model.joint_q(self.model.joint(joint)?);
        (range.len() == 1).then(|| self.q[range.start])
    }

    fn joint_named(
        &self,
        part: &Part<'_, '_>,
        entry: &Entry<'_, '_>,
        name: &'static str,
    ) -> Result<Option<String>, LoadError> {
        let Some(own) = entry.text(name).map(|text| part.naming.of(text)) else {
            return Ok(None);
        };
        match self.names.kinds.get(&own) {
            Some(kind) if kind.is_single() => Ok(Some(own)),
            Some(_) => Err(entry.malformed(name, "is neither a hinge nor a slide")),
            None => Err(entry.malformed(name, "there is no joint of that name")),
        }
    }
}

/// The coefficients of p(x − d) as a polynomial in x, by synthetic division.
fn moved_by(mut p: [f64; 5], d: f64) -> [f64; 5] {
    for first in 0..p.len() {
        for k in (first..p.len() - 1).rev() {
            p[k] -= d * p[k + 1];
        }
    }
    p
}
