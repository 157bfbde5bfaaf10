//! All numbers that a simulation depends on, as one vector: those of the [model](crate::Model::parameters), then those of what acts on it.
//!
//! | group | numbers | unit |
//! |---|---|---|
//! | the model's | inertias, placements of joints, gravity, damping, armature, springs, placements of frames | see [`Model::parameters`](crate::Model::parameters) |
//! | actuator of each velocity coordinate, those that it has | torque, threshold and largest speed of its motor; effort limit; force and slip velocity of Coulomb friction; lower and upper end, stiffness, damping and their exponents of its stops; speed limit and its damping | N·m, rad/s, rad; or N, m/s, m |
//! | each kinematic constraint | origins of its anchors in their frames; turns of those that are welded; coefficients of a tendon; length, or ratio and offset; time constant, or stiffness and damping of a spring; largest force | m; rad; m, or rad or m; s, or N/m, N·s/m; N |
//! | each point of contact | centre in the body frame, radius | m |
//! | law of each point | friction and all other numbers of [the law](crate::contact::ContactLaw) | |
//! | the ground | of a plane height and slopes along x and y; of a grid the height of each node; of a function its parameters | m, 1; m; the function's |
//! | each external force, then each frame actuator | origin of its place in its frame, turn of the place; force or wrench, or the parameters of a function; limits of an actuator | m, rad; N, N·m, or the function's |
//! | each servo of a tendon | coefficients; gear, gains and ranges; effort limit | |
//! | each activation of an input | ends of its ranges; time constant, or the parameters of a function | ; s, or the function's |
//! | the method | time step | s |
//!
//! Turns are increments, zero as they are, about the axes of the place. Not among them: axes of rims, which are unit vectors (the placement of the joint that
//! carries them turns them); grids' origins and spacings, and angles on rims, which are `f64` over any scalar; other numbers of the method, as smoothing.

use nalgebra::DVector;

use super::names::velocity_names;
use super::parameter_slots::SimulatorParameterGroup as Group;
use super::simulator::Simulator;
use super::{Actuation, Actuator, TendonServo};
use crate::contact::{ContactLaw, ContactPart, Contacts};
use crate::model::ParameterLayout;
use crate::numbers::{Domain, EachIn, Number, Numbers, of};
use crate::scalar::{Over, Scalar};

impl<P: Scalar> Simulator<P> {
    /// Collects all numbers that a step depends on: first those of the [model](crate::Model::parameters), then those of actuators, constraints, points of contact,
    /// their laws, the ground and forces on frames, and last the time step; [`parameter_layout`](Self::parameter_layout) says where each stands. Allocates.
    ///
    /// The module's table lists them; axes of rims and other numbers of the method, as smoothing, are not among them. A grid gives the ground as many numbers as it has nodes:
    /// the gradient in all of them costs each step that touches it a pass over the grid.
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
    /// Names begin with what a number belongs to, as in `elbow: Coulomb friction`, `constraint 0: length`, `contact 3 of foot: friction`, `terrain: height`; the
    /// last is `time step`.
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

    /// The simulator with other parameters, over their scalar: over dual numbers, the way to derivatives in all of them.
    ///
    /// Placements are relative to this model's, as in [`Model::with_parameters`](crate::Model::with_parameters).
    ///
    /// # Panics
    /// If there are not as many as [`parameters`](Self::parameters) gives, or if one makes no sense: one of the model that is not finite, a negative
    /// stiffness, damping or friction, a limit below the other one, a length or a time step that is not positive, and so on; the message names it.
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
        let actuators = out.actuation().into_iter().flat_map(Actuation::actuators);
        let of_tendons = out.tendon_servos().iter().map(TendonServo::actuator);
        actuators.chain(of_tendons).for_each(Actuator::check);
        let laws = out.contacts().into_iter().flat_map(Contacts::laws);
        laws.for_each(ContactLaw::check);
        (out.activations().iter()).for_each(|activation| activation.own.check());
        out.with_resistance_found()
    }

    /// Hands each number of what acts on the model, and the time step, with its group and name to `each`, group after group: the one place that says the order.
    fn each_number(&mut self, each: &mut EachIn<'_, Group, P>) {
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
                    ContactPart::Law(i) => Group::ContactLaw(i),
                    ContactPart::Terrain => Group::Terrain,
                    ContactPart::Shape(k) | ContactPart::ShapeMaterial(k) => {
                        Group::CollisionShape(k)
                    }
                    ContactPart::PairLaw => Group::PairLaw,
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

    /// Name of what the numbers of a group belong to; `None` for the simulator itself.
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
            Group::PairLaw => "contact of bodies".to_owned(),
            Group::ExternalForce(k) => format!("external force {k}"),
            Group::FrameActuator(k) => self.frames.actuators[k].name().to_owned(),
            Group::TendonServo(k) => self.tendons[k].name().to_owned(),
            Group::Activation(k) => format!("activation of {}", self.activations[k].name),
        })
    }
}
