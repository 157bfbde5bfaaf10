//! All parameters of a simulation as one vector: those of the [model](crate::Model::parameters), then those of forces and constraints on it.
//!
//! | group | parameters | unit |
//! |---|---|---|
//! | the model's | inertias, placements of joints, gravity, damping, armature, springs, placements of frames | see [`Model::parameters`](crate::Model::parameters) |
//! | actuator of each velocity coordinate, as far as set | torque, threshold and largest speed of its motor; effort limit; force and slip velocity of Coulomb friction; lower and upper position limit, their stiffness, damping and exponents; speed limit and its damping | N·m, rad/s, rad; or N, m/s, m |
//! | each kinematic constraint | origins of its attachment frames; rotations of welded ones; coefficients of a tendon, or of the powers of a coupler; length, or ratio and offset; time constant, or stiffness and damping of a spring; maximum force | m; rad; m, or rad or m; s, or N/m, N·s/m; N |
//! | each contact point | centre in the body frame, radius | m |
//! | contact model of each point | friction and all other parameters of [the model](crate::contact::ContactLaw) | |
//! | the ground | height and slopes along x and y of a plane; height of each node of a grid; parameters of a function | m, 1; m; the function's |
//! | each external force, then each frame actuator | origin and rotation of its attachment frame; force or wrench, or the parameters of a function; limits of an actuator | m, rad; N, N·m, or the function's |
//! | each tendon servo | coefficients; gear, gains and ranges; effort limit | |
//! | each activation of an input | ends of its ranges; time constant, or the parameters of a function | ; s, or the function's |
//! | integrator | time step | s |
//!
//! Rotations are increments about the axes of the attachment frame, zero at the current value. These values are not parameters: axes of wheel rims,
//! which are unit vectors (the placement of their joint rotates them); origins and spacings of grids, and angles on rims, which are `f64` over any
//! scalar; other numerical settings, such as smoothing.

use nalgebra::DVector;

use super::names::velocity_names;
use super::parameter_slots::SimulatorParameterGroup as Group;
use super::simulator::Simulator;
use super::{Actuation, Actuator, TendonServo};
use crate::contact::{ContactLaw, ContactPart, Contacts, MaterialOf};
use crate::model::ParameterLayout;
use crate::nested::IntoNested;
use crate::numbers::{Domain, EachIn, Number, Numbers, of};
use crate::scalar::{Over, Scalar};

impl<P: Scalar> Simulator<P> {
    /// Returns all parameters of a step: first those of the [model](crate::Model::parameters), then those of actuators, constraints, contact points,
    /// contact models, the ground and forces on frames, and last the time step. [`parameter_layout`](Self::parameter_layout) returns their positions.
    /// Allocates.
    ///
    /// The table of the module lists them; axes of wheel rims and numerical settings, such as smoothing, are not parameters. A grid has one parameter
    /// per node: the gradient in all of them costs one pass over the grid for each step in contact.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, model::samples, sim::Actuation};
    ///
    /// let model = samples::cartpole(); // its rail ends at 2.4 m
    /// let actuation = Actuation::from_model(&model);
    /// let simulator = Simulator::new(model).with_actuation(actuation);
    /// let end = simulator.parameter_layout().find("linear: upper limit")?;
    /// assert_eq!(simulator.parameters()[end], 2.4);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn parameters(&self) -> DVector<P> {
        let mut all = self.model().parameters().data.as_vec().clone();
        self.clone().each_number(&mut |_, _, x| all.push(*x));
        DVector::from_vec(all)
    }

    /// Returns the layout of the [`parameters`](Self::parameters): index and name of each. Allocates.
    ///
    /// A name begins with the owner of the parameter, as in `elbow: Coulomb friction`, `constraint 0: length`, `contact 3 of foot: friction`,
    /// `terrain: height`; the last name is `time step`.
    pub fn parameter_layout(&self) -> ParameterLayout<Group> {
        let mut out = self.model().parameter_layout().regrouped(Group::Model);
        let coordinates = velocity_names(self.model());
        self.clone().each_number(&mut |group, own, _| {
            let name = match self.part_name(group, &coordinates) {
                Some(part) => format!("{part}: {}", own.name),
                None => own.name.to_string(),
            };
            out.push(group, name, own.domain);
        });
        out
    }

    /// Returns the simulator with other parameters, over their scalar. Over dual numbers this gives derivatives in all parameters.
    ///
    /// Placements are relative to this model's, as in [`Model::with_parameters`](crate::Model::with_parameters).
    ///
    /// # Panics
    /// If the length differs from that of [`parameters`](Self::parameters), or a value is out of range: a model parameter that is not finite, a
    /// negative stiffness, damping or friction, an upper limit below the lower one, a length or a time step that is not positive, and so on. The
    /// message names it.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, model::samples, sim::Actuation};
    ///
    /// let model = samples::cartpole();
    /// let actuation = Actuation::from_model(&model);
    /// let simulator = Simulator::new(model).with_actuation(actuation);
    /// let mut parameters = simulator.parameters();
    /// parameters[simulator.parameter_layout().find("linear: upper limit")?] = 3.0;
    /// let longer = simulator.with_parameters(parameters.as_slice());
    /// let rail = longer.actuation().and_then(|all| all.actuators()[0].position);
    /// assert_eq!(rail.and_then(|limits| limits.upper), Some(3.0));
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn with_parameters<Q: Over<P>>(&self, parameters: &[Q]) -> Simulator<Q> {
        let (name, expected) = (self.model().name(), self.parameters().len());
        let given = parameters.len();
        assert_eq!(
            given, expected,
            "a simulator of \"{name}\" has {expected} parameters"
        );
        let of_model = self.model().parameters().len();
        let (of_model, of_parts) = parameters.split_at(of_model);
        let mut out = self.with_variant(self.model().with_parameters(of_model));
        let mut rest = of_parts.iter();
        out.each_number(&mut |_, own, x| {
            if let Some(&given) = rest.next() {
                own.domain.check(own.quantity, given);
                *x = given;
            }
        });
        let actuators = out.actuation().into_iter().nested(Actuation::actuators);
        let of_tendons = out.tendon_servos().iter().map(TendonServo::actuator);
        actuators.chain(of_tendons).for_each(Actuator::check);
        out.frame_servos().for_each(|(_, own)| own.check());
        let laws = out.contacts().into_iter().nested(Contacts::laws);
        laws.for_each(ContactLaw::check);
        (out.activations().iter()).for_each(|activation| activation.own.check());
        out.with_resistance_found()
    }

    /// Passes each parameter of forces and constraints, and the time step, with its group and name to `each`, group by group: this function defines the order.
    pub(super) fn each_number(&mut self, each: &mut EachIn<'_, Group, P>) {
        if let Some(actuation) = &mut self.actuation {
            for (k, actuator) in actuation.actuators.iter_mut().enumerate() {
                actuator.each_number(&mut of(Group::Actuator(k), each));
            }
        }
        for (k, constraint) in self.constraints.iter_mut().enumerate() {
            constraint.each_placed_number(&mut of(Group::Constraint(k), each));
        }
        if let Some(contacts) = &mut self.contacts {
            contacts.each_number(&mut |part, own, x| {
                let group = match part {
                    ContactPart::Point(i) => Group::ContactPoint(i),
                    ContactPart::Law(i) | ContactPart::Turning(i) | ContactPart::Margin(i) => {
                        Group::ContactLaw(i)
                    }
                    ContactPart::Terrain => Group::Terrain,
                    ContactPart::Shape(k) | ContactPart::Material(MaterialOf::Shape(k), _) => {
                        Group::CollisionShape(k)
                    }
                    ContactPart::Material(MaterialOf::Pair(k), _) => Group::PairMaterial(k),
                    ContactPart::PairLaw | ContactPart::PairTurning => Group::PairLaw,
                };
                each(group, own, x);
            });
        }
        let mut on_frame = |group, own: Number<'_>, x: &mut P| {
            let quantity = format_args!("{} of a force on a frame", own.name);
            each(group, Number::new(own.name, &quantity, own.domain), x);
        };
        for (k, force) in self.frames.forces.iter_mut().enumerate() {
            force.each_placed_number(&mut of(Group::ExternalForce(k), &mut on_frame));
        }
        for (k, actuator) in self.frames.actuators.iter_mut().enumerate() {
            actuator.each_placed_number(&mut of(Group::FrameActuator(k), &mut on_frame));
        }
        for (k, servo) in self.tendons.iter_mut().enumerate() {
            servo.each_number(&mut of(Group::TendonServo(k), each));
        }
        for (k, activation) in self.activations.iter_mut().enumerate() {
            activation.each_number(&mut of(Group::Activation(k), each));
        }
        let name = "time step";
        let time_step = Number::new(&name, &name, Domain::Positive);
        each(Group::TimeStep, time_step, &mut self.time_step);
    }

    /// Name of the owner of a group; `None` for the simulator itself.
    ///
    /// * `coordinates` – names of the velocity coordinates
    fn part_name(&self, group: Group, coordinates: &[String]) -> Option<String> {
        Some(match group {
            Group::TimeStep => return None,
            Group::Model(_) => self.model().name().to_owned(),
            Group::Actuator(k) => coordinates[k].clone(),
            Group::Constraint(k) => format!("constraint {k}"),
            Group::ContactPoint(i) | Group::ContactLaw(i) => {
                let point = self.contacts.as_ref().map(|contacts| &contacts.points()[i]);
                let link =
                    point.map_or("", |point| self.model().frame_of(point.link).name.as_str());
                format!("contact {i} of {link}")
            }
            Group::Terrain => "terrain".to_owned(),
            Group::CollisionShape(k) => {
                let link = self.contacts.as_ref().map(|c| c.shape_link(k));
                let name = link.map_or("", |link| self.model().frame_of(link).name.as_str());
                format!("shape {k} of {name}")
            }
            Group::PairMaterial(k) => format!("material of pair {k}"),
            Group::PairLaw => "contact of bodies".to_owned(),
            Group::ExternalForce(k) => format!("external force {k}"),
            Group::FrameActuator(k) => self.frames.actuators[k].name().to_owned(),
            Group::TendonServo(k) => self.tendons[k].name().to_owned(),
            Group::Activation(k) => format!("activation of {}", self.activations[k].name),
        })
    }
}
