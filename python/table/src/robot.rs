//! The robot that a function belongs to.

use dualbody::{Model, Over, Scalar, Simulator};

/// A model, or a simulator with its own.
#[derive(Clone, Copy)]
pub enum Robot<'a, T: Scalar> {
    /// Of what moves.
    Model(&'a Model<T>),
    /// Of what acts on it besides.
    Simulator(&'a Simulator<T>),
}

/// [`Robot`], owned.
pub enum Own<T: Scalar> {
    /// Of what moves.
    Model(Box<Model<T>>),
    /// Of what acts on it besides.
    Simulator(Box<Simulator<T>>),
}

impl<'a, P: Scalar> Robot<'a, P> {
    /// The model.
    pub fn model(self) -> &'a Model<P> {
        match self {
            Self::Model(model) => model,
            Self::Simulator(simulator) => simulator.model(),
        }
    }

    /// The simulator.
    ///
    /// # Panics
    /// If there is a model only.
    pub fn simulator(self) -> &'a Simulator<P> {
        match self {
            Self::Simulator(simulator) => simulator,
            Self::Model(_) => panic!("the function is one of a Simulator, not of a Model"),
        }
    }

    /// The robot over another scalar, with other parameters of the model if they are given.
    ///
    /// # Panics
    /// If these are not as many as the model's, or if one is not finite.
    pub fn over<T: Over<P>>(self, parameters: Option<&[T]>) -> Own<T> {
        let changed = |model: &Model<P>| match parameters {
            Some(all) => model.with_parameters(all),
            None => model.cast(),
        };
        match self {
            Self::Model(model) => Own::Model(Box::new(changed(model))),
            Self::Simulator(simulator) => {
                let changed = simulator.with_model(changed(simulator.model()));
                Own::Simulator(Box::new(changed.expect("the structure is the same")))
            }
        }
    }
}

impl<T: Scalar> Own<T> {
    /// The robot.
    pub fn robot(&self) -> Robot<'_, T> {
        match self {
            Self::Model(model) => Robot::Model(model),
            Self::Simulator(simulator) => Robot::Simulator(simulator),
        }
    }
}
