//! Coordinates of each joint, with damping, armature and springs.

use std::collections::HashMap;

use super::body::{Body, Coupling};
use super::builder::{JointSpec, Mimicry, ModelBuilder};
use super::parts::{Joint, Mimic, Spring};
use crate::error::LoadError;
use crate::nested::IntoNested;
use crate::scalar::Scalar;

/// Number of configuration coordinates; damping, armature and spring along each velocity coordinate.
#[derive(Default)]
pub(super) struct Coordinates {
    pub(super) nq: usize,
    pub(super) damping: Vec<f64>,
    pub(super) armature: Vec<f64>,
    pub(super) springs: Vec<Spring<f64>>,
}

/// Passive forces along the coordinates of a body.
#[derive(Clone, Copy, Default)]
struct Along {
    damping: f64,
    armature: f64,
    spring: Spring<f64>,
}

impl Along {
    /// Of the k-th body of a joint.
    fn of(spec: &JointSpec, k: usize) -> Self {
        match spec.second.as_ref().filter(|_| k > 0) {
            Some(second) => Self {
                damping: second.damping,
                armature: second.armature,
                spring: second.spring,
            },
            None => Self {
                damping: spec.damping,
                armature: spec.armature,
                spring: spec.spring,
            },
        }
    }
}

/// Numbers the coordinates of all joints in the order of the bodies; mimic joints share those of their leaders.
///
/// * `joints`, `specs` – the named joints and what they were built from, in the same order
pub(super) fn assign<T: Scalar>(
    builder: &ModelBuilder,
    bodies: &mut [Body<T>],
    joints: &[Joint],
    specs: &[&JointSpec],
) -> Result<Coordinates, LoadError> {
    let joint_of_body: HashMap<usize, (usize, usize)> = joints
        .iter()
        .enumerate()
        .nested(|(j, joint)| joint.bodies().enumerate().map(move |(k, i)| (i, (j, k))))
        .collect();
    let follows = |j: usize| builder.mimicry == Mimicry::Coupled && specs[j].mimic.is_some();
    let mut out = Coordinates::default();
    for (i, body) in bodies.iter_mut().enumerate() {
        match joint_of_body.get(&i) {
            Some(&(j, _)) if follows(j) => {}
            Some(&(j, k)) => out.number(body, Along::of(specs[j], k)),
            None => out.number(body, Along::default()),
        }
    }
    let mut leaders = Leaders::new(builder, specs);
    for j in (0..joints.len()).filter(|&j| follows(j)) {
        let (leader, coupling) = leaders.of(j)?;
        let Body { q, v, .. } = bodies[joints[leader].body.0];
        let follower = &mut bodies[joints[j].body.0];
        follower.coupling = Some(Coupling {
            ratio: T::constant(coupling.ratio),
            offset: T::constant(coupling.offset),
        });
        (follower.q, follower.v) = (q, v);
        out.couple(v, specs[j], coupling);
    }
    Ok(out)
}

impl Coordinates {
    fn number<T>(&mut self, body: &mut Body<T>, along: Along) {
        (body.q, body.v) = (self.nq, self.damping.len());
        self.nq += body.joint.nq();
        let n = self.damping.len() + body.joint.nv();
        self.damping.resize(n, along.damping);
        self.armature.resize(n, along.armature);
        self.springs.resize(n, along.spring);
    }

    /// Adds damping, armature and spring of a mimic joint to those of its leader: with q = r `q_l` + o, forces by r, rates by r.
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

/// Leaders: the joint with coordinates that each joint follows in the end, and how; found once for every joint on a chain of mimic joints.
struct Leaders<'a> {
    builder: &'a ModelBuilder,
    specs: &'a [&'a JointSpec],
    joint_of_name: HashMap<&'a str, usize>,
    /// Leader of each joint; `None` if not yet computed.
    found: Vec<Option<(usize, Coupling)>>,
}

impl<'a> Leaders<'a> {
    fn new(builder: &'a ModelBuilder, specs: &'a [&'a JointSpec]) -> Self {
        Self {
            builder,
            specs,
            joint_of_name: specs
                .iter()
                .map(|spec| spec.name.as_str())
                .zip(0..)
                .collect(),
            found: vec![None; specs.len()],
        }
    }

    /// Follows the chain up to a joint with coordinates, or to one whose leader is known, then notes the leader of all on the way back.
    fn of(&mut self, j: usize) -> Result<(usize, Coupling), LoadError> {
        let mut chain = Vec::new();
        let mut at = j;
        let mut end = loop {
            if let Some(found) = self.found[at] {
                break found;
            }
            let Some(mimic) = &self.specs[at].mimic else {
                break (at, Coupling::IDENTITY);
            };
            chain.push((at, mimic));
            if chain.len() > self.specs.len() {
                let reason = "the mimic joints form a cycle";
                return Err(invalid(self.builder, self.specs[j], reason));
            }
            let leader = self.joint_of_name.get(mimic.leader.as_str());
            let fixed = || {
                invalid(
                    self.builder,
                    self.specs[j],
                    "the joint that it mimics is fixed",
                )
            };
            at = *leader.ok_or_else(fixed)?;
        };
        for (follower, mimic) in chain.into_iter().rev() {
            end.1 = end.1.followed_by(mimic);
            self.found[follower] = Some(end);
        }
        Ok(end)
    }
}

impl Coupling {
    /// Coupling of a joint with coordinates to itself.
    const IDENTITY: Self = Self {
        ratio: 1.0,
        offset: 0.0,
    };

    /// Coupling of a joint which mimics one that follows by this:  q = m (r `q_l` + o) + b.
    fn followed_by(self, mimic: &Mimic) -> Self {
        Self {
            ratio: mimic.multiplier * self.ratio,
            offset: mimic.multiplier * self.offset + mimic.offset,
        }
    }
}

fn invalid(builder: &ModelBuilder, spec: &JointSpec, reason: &str) -> LoadError {
    LoadError::InvalidMimic {
        at: builder.position("joint", &spec.name),
        joint: spec.name.clone(),
        leader: spec
            .mimic
            .as_ref()
            .map_or_else(String::new, |mimic| mimic.leader.clone()),
        reason: reason.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::JointKind;
    use crate::model::{BodyId, LinkSpec};

    /// Sliders on the world, each of which follows the next but the last: q = 0.5 − `q_next`.
    fn chain(n: usize) -> ModelBuilder {
        let mut builder = ModelBuilder::new("chain");
        builder.add_link(LinkSpec::new("world"));
        for k in 0..n {
            builder.add_link(LinkSpec::new(format!("link{k}")).with_mass(1.0, [0.0; 3], [1.0; 3]));
            let name = format!("joint{k}");
            let joint = JointSpec::new(name, JointKind::Prismatic, "world", format!("link{k}"));
            let mimic = Mimic {
                leader: format!("joint{}", k + 1),
                multiplier: -1.0,
                offset: 0.5,
            };
            builder.add_joint(if k + 1 < n {
                joint.with_mimic(mimic)
            } else {
                joint
            });
        }
        builder
    }

    // Walking every chain to its end would be 200 million steps, each with a search among 20,000 names.
    #[test]
    fn followers_in_a_long_chain_follow_the_last_one_by_alternating_signs() {
        const N: usize = 20_000;
        let model = chain(N).build().unwrap();
        assert_eq!((model.nv(), model.n_bodies()), (1, N));
        for k in [0, 1, N / 2, N - 3, N - 2] {
            let is_odd = (N - 1 - k) % 2 == 1;
            let (ratio, offset) = if is_odd { (-1.0, 0.5) } else { (1.0, 0.0) };
            let expected = Some(Coupling { ratio, offset });
            assert_eq!(model.body(BodyId(k)).coupling, expected, "joint {k}");
        }
    }

    #[test]
    fn circles_and_fixed_leaders_are_errors_and_so_are_ratios_out_of_range() {
        let mut circle = chain(4);
        circle.joints[3].mimic = circle.joints[1].mimic.clone();
        let error = circle.build().unwrap_err().to_string();
        assert!(error.contains("form a cycle"), "{error}");
        let mut fixed = chain(4);
        fixed.joints[3].kind = JointKind::Fixed;
        let error = fixed.build().unwrap_err().to_string();
        assert!(
            error.contains("\"joint0\"") && error.contains("is fixed"),
            "{error}"
        );
        let mut steep = chain(40);
        for joint in &mut steep.joints {
            if let Some(mimic) = &mut joint.mimic {
                mimic.multiplier = 1e10;
            }
        }
        let error = steep.build().unwrap_err().to_string();
        assert!(error.contains("ratio or offset to its leader"), "{error}");
    }
}
