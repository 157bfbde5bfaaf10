//! Multipliers of single shooting.

use crate::trajopt::lagrangian::no_multipliers;
use crate::trajopt::problem::Problem;

/// The multipliers of constraints: of each stage the λ of its constraints, in sequence.
#[derive(Clone, Debug)]
pub(super) struct Lambdas {
    pub(super) lambda: Vec<Vec<f64>>,
    pub(super) mu: f64,
}

impl Lambdas {
    pub(super) fn new(problem: &Problem, mu: f64) -> Self {
        let stages = 0..=problem.horizon();
        let lambda = stages.map(|stage| no_multipliers(problem, stage));
        Self {
            lambda: lambda.collect(),
            mu,
        }
    }
}
