//! Position of each parameter of a robot in its parameter vector.

use nalgebra::Vector3;

use crate::model::{Body, BodyId, FrameId, Model, ParameterGroup};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::dot;

/// Indices into [`Model::parameters`], by the place that a number has in the dynamics.
#[derive(Clone, Debug)]
pub(crate) struct ParameterSlots {
    /// Number of parameters.
    pub(crate) len: usize,
    /// The first inertial parameter of each body.
    pub(crate) inertia: Vec<usize>,
    /// Index of the first placement parameter of the joint of each body; `None` if the joint has no name or is the outer part of a joint of two bodies.
    pub(crate) placement: Vec<Option<usize>>,
    /// The first component of gravity; `None` for a motion in which nothing has weight.
    pub(crate) gravity: Option<usize>,
    /// Damping of the first coordinate.
    pub(crate) damping: usize,
    /// Armature of the first coordinate.
    pub(crate) armature: usize,
    /// Stiffness, before the rest position, of the spring along each coordinate; `None` where there can be none.
    pub(crate) spring: Vec<Option<usize>>,
    /// Ratio, before the offset, of the joint that carries each body; `None` where it follows none.
    pub(crate) coupling: Vec<Option<usize>>,
    /// Index of the first placement parameter of each frame.
    pub(crate) frames: Vec<usize>,
}

impl ParameterSlots {
    /// Those of a model. Allocates.
    pub(crate) fn new<P: Scalar>(model: &Model<P>) -> Self {
        let layout = model.parameter_layout();
        let mut slots = Self {
            len: layout.len(),
            inertia: vec![0; model.n_bodies()],
            placement: vec![None; model.n_bodies()],
            gravity: None,
            damping: 0,
            armature: 0,
            spring: vec![None; model.nv()],
            coupling: vec![None; model.n_bodies()],
            frames: vec![0; model.frames().len()],
        };
        for (group, range) in layout.groups() {
            // Without a wildcard, so that no group can be left out.
            match *group {
                ParameterGroup::Inertia(BodyId(i)) => slots.inertia[i] = range.start,
                ParameterGroup::Placement(joint) => {
                    let first = model.joint_bodies(joint).next();
                    if let Some(BodyId(i)) = first {
                        slots.placement[i] = Some(range.start);
                    }
                }
                ParameterGroup::Gravity => slots.gravity = Some(range.start),
                ParameterGroup::Damping => slots.damping = range.start,
                ParameterGroup::Armature => slots.armature = range.start,
                ParameterGroup::Frame(FrameId(i)) => slots.frames[i] = range.start,
                ParameterGroup::Coupling(joint) => {
                    let BodyId(i) = model.joint_body(joint);
                    slots.coupling[i] = Some(range.start);
                }
                ParameterGroup::Spring(joint) => {
                    for (k, v) in model.joint_v(joint).enumerate() {
                        slots.spring[v] = Some(range.start + 2 * k);
                    }
                }
            }
        }
        slots
    }

    /// Adds the gradient in mass m and first moment h of a body from that in its [centre](Body::center)  c = h / m,  δc = (δh − c δm) / m;  nothing
    /// where parameters are not wanted.
    pub(crate) fn add_center<P: Scalar, T: Over<P>>(
        &self,
        id: BodyId,
        body: &Body<P>,
        by_center: &Vector3<T>,
        parameters: &mut [T],
    ) {
        let first = self.inertia[id.0];
        let Some([mass, first_moment @ ..]) = parameters.get_mut(first..first + 4) else {
            return;
        };
        let by_moment = by_center.map(|x| x * body.per_mass());
        *mass -= dot(&by_moment, &body.center());
        let own = first_moment.iter_mut().zip(&by_moment);
        own.for_each(|(own, &x)| *own += x);
    }
}
