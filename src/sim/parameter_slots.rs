//! Groups of the parameters of a simulator, and their positions.

use std::ops::Range;

use super::simulator::Simulator;
use crate::model::ParameterGroup;
use crate::scalar::Scalar;

/// A group in the parameter vector of a simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SimulatorParameterGroup {
    /// A group of the model.
    Model(ParameterGroup),
    /// The actuator of a velocity coordinate.
    Actuator(usize),
    /// A kinematic constraint, in the order of [`Simulator::constraints`].
    Constraint(usize),
    /// A contact point, in the order of [`Contacts::points`](crate::contact::Contacts::points).
    ContactPoint(usize),
    /// The contact model of a contact point, then its torsional and rolling friction and its margin, if points have some.
    ContactLaw(usize),
    /// The ground.
    Terrain,
    /// The sizes of a collision shape that can touch others, then friction, restitution and (if materials have some) margin of its material, if set, torsional and rolling friction, if
    /// shapes have some, and the compliance of the material, if set.
    CollisionShape(usize),
    /// The material of a pair of links, as that of a shape.
    PairMaterial(usize),
    /// The contact model between bodies, then torsional and rolling friction between shapes without materials, if some have any.
    PairLaw,
    /// An external force, in the order of [`Simulator::external_forces`].
    ExternalForce(usize),
    /// A frame actuator, in the order of [`Simulator::frame_actuators`].
    FrameActuator(usize),
    /// A servo of a tendon, in the order of [`Simulator::tendon_servos`].
    TendonServo(usize),
    /// The activation of an input, in the order in which the simulator got them.
    Activation(usize),
    /// The time step, which is the last parameter.
    TimeStep,
}

use SimulatorParameterGroup as Group;

/// Positions of the parameters of each part in the parameter vector.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartSlots {
    /// Of the actuator of each velocity coordinate.
    pub(crate) actuators: Vec<Range<usize>>,
    /// Of each kinematic constraint.
    pub(crate) constraints: Vec<Range<usize>>,
    /// Of each contact point.
    pub(crate) points: Vec<Range<usize>>,
    /// Of the law of each point.
    pub(crate) laws: Vec<Range<usize>>,
    pub(crate) terrain: Range<usize>,
    /// Of the sizes and the material of each shape that can touch others.
    pub(crate) shapes: Vec<Range<usize>>,
    /// Of the materials of pairs of links.
    pub(crate) pair_materials: Vec<Range<usize>>,
    /// Of the law of bodies that touch each other.
    pub(crate) pair_law: Range<usize>,
    /// Of each external force, then of each frame actuator.
    pub(crate) frame_terms: Vec<Range<usize>>,
    /// Of each servo of a tendon.
    pub(crate) tendons: Vec<Range<usize>>,
}

impl PartSlots {
    /// Those of a simulator. Allocates.
    pub(crate) fn new(simulator: &Simulator) -> Self {
        let n_points = simulator.contacts().map_or(0, |c| c.points().len());
        let n_shapes = simulator.contacts().map_or(0, |c| c.n_shapes());
        let n_pairs = simulator.contacts().map_or(0, |c| c.n_pair_materials());
        let forces = simulator.external_forces().len();
        let n_terms = forces + simulator.frame_actuators().len();
        let mut slots = Self {
            actuators: vec![0..0; simulator.model().nv()],
            constraints: vec![0..0; simulator.constraints().len()],
            points: vec![0..0; n_points],
            laws: vec![0..0; n_points],
            terrain: 0..0,
            shapes: vec![0..0; n_shapes],
            pair_materials: vec![0..0; n_pairs],
            pair_law: 0..0,
            frame_terms: vec![0..0; n_terms],
            tendons: vec![0..0; simulator.tendon_servos().len()],
        };
        // Without the names of a layout, which take longer than a step.
        let mut next = simulator.model().parameters().len();
        simulator.clone().each_number(&mut |group, _, _| {
            if let Some(range) = slots.range_mut(group, forces) {
                if range.start == range.end {
                    *range = next..next;
                }
                range.end = next + 1;
            }
            next += 1;
        });
        slots
    }

    /// [`new`](Self::new), for derivatives of forces on frames, constraints and servos of tendons: empty where there are none. Allocates.
    pub(crate) fn of_placed_parts(simulator: &Simulator) -> Self {
        let is_bare = simulator.frame_terms().is_empty()
            && simulator.constraints().is_empty()
            && simulator.tendon_servos().is_empty();
        match is_bare {
            true => Self::default(),
            false => Self::new(simulator),
        }
    }

    /// Those of a group; `None` for groups that are not of a part.
    ///
    /// * `forces` – number of external forces
    fn range_mut(&mut self, group: Group, forces: usize) -> Option<&mut Range<usize>> {
        Some(match group {
            Group::Model(_) | Group::Activation(_) | Group::TimeStep => return None,
            Group::Constraint(k) => &mut self.constraints[k],
            Group::Actuator(k) => &mut self.actuators[k],
            Group::ContactPoint(i) => &mut self.points[i],
            Group::ContactLaw(i) => &mut self.laws[i],
            Group::Terrain => &mut self.terrain,
            Group::CollisionShape(k) => &mut self.shapes[k],
            Group::PairMaterial(k) => &mut self.pair_materials[k],
            Group::PairLaw => &mut self.pair_law,
            Group::ExternalForce(k) => &mut self.frame_terms[k],
            Group::FrameActuator(k) => &mut self.frame_terms[forces + k],
            Group::TendonServo(k) => &mut self.tendons[k],
        })
    }
}

/// Adds a derivative to the last of all parameters, the time step.
pub(crate) fn add_to_last<T: Scalar>(parameters: &mut [T], slope: T) {
    if let Some(last) = parameters.last_mut() {
        *last += slope;
    }
}

/// Adds derivatives with a weight to the parameters of a part, as many as it has; nothing where parameters are not wanted.
pub(crate) fn add_to_part<T: Scalar>(
    parameters: &mut [T],
    part: &Range<usize>,
    slopes: &[T],
    weight: T,
) {
    if let Some(own) = parameters.get_mut(part.clone()) {
        let pairs = own.iter_mut().zip(slopes);
        pairs.for_each(|(own, &slope)| *own += weight * slope);
    }
}
