//! Traits that argmin asks of a function, implemented for the rollout itself and for a reference to it.

use argmin::core::{CostFunction, Error, Gradient, Hessian};
use nalgebra::{DMatrix, DVector};

use super::SingleShooting;
use crate::trajopt::minimizer::{Objective, columns_of};
use crate::trajopt::status::Status;
use crate::trajopt::system::System;

impl<D: System> Objective for SingleShooting<'_, D> {
    fn value(&self, z: &[f64]) -> f64 {
        Self::value(self, z)
    }

    fn gradient(&self, z: &[f64]) -> DVector<f64> {
        Self::gradient(self, z)
    }

    fn hessian(&self, z: &[f64]) -> DMatrix<f64> {
        Self::hessian(self, z)
    }
}

impl<D: System> CostFunction for SingleShooting<'_, D> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, z: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.value(z))
    }
}

impl<D: System> Gradient for SingleShooting<'_, D> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, z: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(Self::gradient(self, z).data.into())
    }
}

impl<D: System> Hessian for SingleShooting<'_, D> {
    type Param = Vec<f64>;
    type Hessian = Vec<Vec<f64>>;

    fn hessian(&self, z: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        let system = self.problem().dynamics();
        if !(self.options().curvature).is_known_of(system) {
            return Err(Error::msg(Status::NoStepHessian));
        }
        Ok(columns_of(&Self::hessian(self, z)))
    }
}

impl<D: System> CostFunction for &SingleShooting<'_, D> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, z: &Vec<f64>) -> Result<f64, Error> {
        CostFunction::cost(*self, z)
    }
}

impl<D: System> Gradient for &SingleShooting<'_, D> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, z: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Gradient::gradient(*self, z)
    }
}

impl<D: System> Hessian for &SingleShooting<'_, D> {
    type Param = Vec<f64>;
    type Hessian = Vec<Vec<f64>>;

    fn hessian(&self, z: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        Hessian::hessian(*self, z)
    }
}
