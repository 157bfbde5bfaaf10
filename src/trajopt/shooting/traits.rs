//! The rollout as a function to be minimised, by [`minimize`](crate::minimize::minimize) or by argmin itself.

use nalgebra::{DMatrix, DVector};

use super::SingleShooting;
use crate::minimize::{Objective, Status, objective_for_argmin};

impl Objective for SingleShooting<'_> {
    fn value(&self, z: &[f64]) -> f64 {
        Self::value(self, z)
    }

    fn gradient(&self, z: &[f64]) -> DVector<f64> {
        Self::gradient(self, z)
    }

    fn hessian(&self, z: &[f64]) -> DMatrix<f64> {
        Self::hessian(self, z)
    }

    fn try_hessian(&self, z: &[f64]) -> Result<DMatrix<f64>, Status> {
        match (self.options().curvature).is_known_of(self.problem().dynamics()) {
            true => Ok(self.hessian(z)),
            false => Err(Status::NoStepHessian),
        }
    }
}

objective_for_argmin!([] SingleShooting<'_>);
