//! Which coordinates each joint has, and what acts along them.

use std::collections::HashMap;

use super::body::{Body, Coupling};
use super::builder::{JointSpec, Mimicry, ModelBuilder};
use super::parts::{Joint, Spring};
use crate::error::LoadError;

/// What acts along each velocity coordinate.
#[derive(Default)]
pub(super) struct Coordinates {
    pub(super) nq: usize,
    pub(super) damping: Vec<f64>,
    pub(super) armature: Vec<f64>,
    pub(super) springs: Vec<Spring<f64>>,
}

/// Numbers the coordinates of all joints in the order of the bodies; followers share those of their leaders.
///
/// * `joints`, `specs` – the named joints and what they were built from, in the same order
pub(super) fn assign(
    builder: &ModelBuilder,
    bodies: &mut [Body<f64>],
    joints: &[Joint],
    specs: &[&JointSpec],
) -> Result<Coordinates, LoadError> {
    let joint_of_body: HashMap<usize, usize> = joints
        .iter()
        .enumerate()
        .map(|(j, joint)| (joint.body.0, j))
        .collect();
    let follows = |j: usize| builder.mimicry == Mimicry::Coupled && specs[j].mimic.is_some();
    let mut out = Coordinates::default();
    for (i, body) in bodies.iter_mut().enumerate() {
        match joint_of_body.get(&i) {
            Some(&j) if follows(j) => {}
            Some(&j) => out.number(body, Some(specs[j])),
            None => out.number(body, None),
        }
    }
    for j in (0..joints.len()).filter(|&j| follows(j)) {
        let (leader, coupling) = resolve(builder, specs, j)?;
        let (q, v) = (
            bodies[joints[leader].body.0].q,
            bodies[joints[leader].body.0].v,
        );
        let follower = &mut bodies[joints[j].body.0];
        (follower.q, follower.v, follower.coupling) = (q, v, Some(coupling));
        out.couple(v, specs[j], coupling);
    }
    Ok(out)
}

impl Coordinates {
    fn number(&mut self, body: &mut Body<f64>, spec: Option<&JointSpec>) {
        (body.q, body.v) = (self.nq, self.damping.len());
        self.nq += body.joint.nq();
        let n = self.damping.len() + body.joint.nv();
        self.damping
            .resize(n, spec.map_or(0.0, |spec| spec.damping));
        self.armature
            .resize(n, spec.map_or(0.0, |spec| spec.armature));
        self.springs
            .resize(n, spec.map_or(Spring::default(), |spec| spec.spring));
    }

    /// What acts along a follower acts on its leader: with q = r `q_l` + o, forces by r, rates by r.
    fn couple(&mut self, v: usize, spec: &JointSpec, Coupling { ratio, offset }: Coupling) {
        self.damping[v] += ratio * ratio * spec.damping;
        self.armature[v] += ratio * ratio * spec.armature;
        let (own, stiffness) = (self.springs[v], ratio * ratio * spec.spring.stiffness);
        let total = own.stiffness + stiffness;
        if stiffness != 0.0 && total != 0.0 {
            // Two springs in parallel rest where their forces balance.
            let rest = (own.stiffness * own.rest + stiffness * (spec.spring.rest - offset) / ratio)
                / total;
            self.springs[v] = Spring {
                stiffness: total,
                rest,
            };
        }
    }
}

/// The joint with coordinates that joint `j` follows in the end, and how.
fn resolve(
    builder: &ModelBuilder,
    specs: &[&JointSpec],
    j: usize,
) -> Result<(usize, Coupling), LoadError> {
    let mut at = j;
    let mut coupling = Coupling {
        ratio: 1.0,
        offset: 0.0,
    };
    for _ in 0..specs.len() {
        let Some(mimic) = &specs[at].mimic else {
            return Ok((at, coupling));
        };
        coupling = Coupling {
            ratio: coupling.ratio * mimic.multiplier,
            offset: coupling.ratio * mimic.offset + coupling.offset,
        };
        match specs.iter().position(|spec| spec.name == mimic.leader) {
            Some(leader) => at = leader,
            None => {
                return Err(invalid(
                    builder,
                    specs[j],
                    "the joint that it follows is fixed",
                ));
            }
        }
    }
    Err(invalid(
        builder,
        specs[j],
        "the joints follow one another in a circle",
    ))
}

fn invalid(builder: &ModelBuilder, spec: &JointSpec, reason: &str) -> LoadError {
    LoadError::InvalidMimic {
        file: builder.source.clone(),
        joint: spec.name.clone(),
        leader: spec
            .mimic
            .as_ref()
            .map_or_else(String::new, |mimic| mimic.leader.clone()),
        reason: reason.into(),
    }
}
