//! States in the coordinates of other engines.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DVector, Vector3};

use super::state::State;
use crate::joint::JointKind;
use crate::model::Model;
use crate::model::manifold::{q_range, v_range};
use crate::spatial::Quaternion;

/// Whose coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Engine {
    /// Quaternions (x, y, z, w); continuous joints and the angle of planar joints as (cos, sin); velocities as here.
    Pinocchio,
    /// Quaternions (w, x, y, z); the linear velocity of a floating base in the world, its angular velocity in the base; a planar
    /// joint is two slides and a hinge.
    MuJoCo,
    /// Quaternions (w, x, y, z); base velocity in the mixed representation, linear first.
    JaxSim,
}

impl State<f64> {
    /// The configuration and velocity in the coordinates of another engine, joint after joint in *this* model's order; reorder by
    /// joint name where the other engine has another order. Allocates.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{State, model::samples, sim::Engine};
    ///
    /// let model = samples::pendulum();
    /// let (q, v) = State::new(&[0.0], &[2.0]).to_engine(&model, Engine::Pinocchio);
    /// assert_eq!((q.as_slice(), v.as_slice()), (&[1.0, 0.0][..], &[2.0][..]));
    /// ```
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn to_engine(&self, model: &Model, engine: Engine) -> (DVector<f64>, DVector<f64>) {
        model.check_q(self.q.as_slice());
        model.check_v(self.v.as_slice());
        let (mut q, mut v) = (Vec::new(), Vec::new());
        for body in model.independent() {
            let (own_q, own_v) = (
                &self.q.as_slice()[q_range(body)],
                &self.v.as_slice()[v_range(body)],
            );
            q.extend(configuration_to(engine, body.joint, own_q));
            v.extend(velocity(engine, body.joint, own_q, own_v, Direction::To));
        }
        (DVector::from_vec(q), DVector::from_vec(v))
    }

    /// The state of an engine's configuration and velocity, the inverse of [`to_engine`](Self::to_engine). Angles given as (cos,
    /// sin) come back in (−π, π]. Numbers are taken as they are: [`check`](Self::check) says whether they are a state. Allocates.
    ///
    /// # Panics
    /// If `q` or `v` are shorter than the model needs.
    pub fn from_engine(model: &Model, engine: Engine, q: &[f64], v: &[f64]) -> Self {
        let mut state = Self::neutral(model);
        let (mut q, mut v) = (q, v);
        for body in model.independent() {
            let (own_q, rest_q) = q.split_at(width(engine, body.joint));
            let (own_v, rest_v) = v.split_at(body.joint.nv());
            (q, v) = (rest_q, rest_v);
            let own_q = configuration_from(engine, body.joint, own_q);
            let own_v = velocity(engine, body.joint, &own_q, own_v, Direction::From);
            state.q.as_mut_slice()[q_range(body)].copy_from_slice(&own_q);
            state.v.as_mut_slice()[v_range(body)].copy_from_slice(&own_v);
        }
        state
    }
}

/// Number of configuration coordinates that the engine has for a joint.
fn width(engine: Engine, joint: JointKind) -> usize {
    match (engine, joint) {
        (Engine::Pinocchio, JointKind::Continuous | JointKind::Planar) => joint.nq() + 1,
        _ => joint.nq(),
    }
}

fn configuration_to(engine: Engine, joint: JointKind, q: &[f64]) -> Vec<f64> {
    let split = |at: usize| [&q[..at], &[q[at].cos(), q[at].sin()]].concat();
    match (engine, joint) {
        (Engine::Pinocchio, JointKind::Continuous) => split(0),
        (Engine::Pinocchio, JointKind::Planar) => split(2),
        (Engine::Pinocchio, JointKind::Spherical | JointKind::Floating) => {
            moved_scalar_part(q, Direction::To)
        }
        _ => q.to_vec(),
    }
}

fn configuration_from(engine: Engine, joint: JointKind, q: &[f64]) -> Vec<f64> {
    let join = |at: usize| [&q[..at], &[q[at + 1].atan2(q[at])]].concat();
    match (engine, joint) {
        (Engine::Pinocchio, JointKind::Continuous) => join(0),
        (Engine::Pinocchio, JointKind::Planar) => join(2),
        (Engine::Pinocchio, JointKind::Spherical | JointKind::Floating) => {
            moved_scalar_part(q, Direction::From)
        }
        _ => q.to_vec(),
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    To,
    From,
}

/// The quaternion at the end of `q` with its scalar part moved to its end, or back to its start.
fn moved_scalar_part(q: &[f64], direction: Direction) -> Vec<f64> {
    let mut out = q.to_vec();
    let quaternion = out.len() - 4;
    match direction {
        Direction::To => out[quaternion..].rotate_left(1),
        Direction::From => out[quaternion..].rotate_right(1),
    }
    out
}

/// A joint's velocity, whose parts some engines give with the axes of the parent (for a floating base: of the world).
fn velocity(
    engine: Engine,
    joint: JointKind,
    q: &[f64],
    v: &[f64],
    direction: Direction,
) -> Vec<f64> {
    let R = match joint {
        JointKind::Floating => Quaternion::from_slice(&q[3..]).to_matrix(),
        JointKind::Planar => joint.transform(q).rotation,
        _ => return v.to_vec(),
    };
    let turn = |x: Vector3<f64>| {
        if direction == Direction::To {
            R * x
        } else {
            R.transpose() * x
        }
    };
    let linear = |v: &[f64]| {
        turn(Vector3::new(
            v[0],
            v[1],
            if joint == JointKind::Floating {
                v[2]
            } else {
                0.0
            },
        ))
    };
    let mut out = v.to_vec();
    if engine == Engine::Pinocchio {
        return out;
    }
    let n = v.len().min(3) - usize::from(joint == JointKind::Planar);
    out[..n].copy_from_slice(&linear(v).as_slice()[..n]);
    if (engine, joint) == (Engine::JaxSim, JointKind::Floating) {
        out[3..].copy_from_slice(turn(Vector3::new(v[3], v[4], v[5])).as_slice());
    }
    out
}
