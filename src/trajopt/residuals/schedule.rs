//! Residuals that differ between stages.

use crate::scalar::Scalar;
use crate::trajopt::residual::{Dependence, Node, Residual, ResidualJacobian};

/// A sequence of residuals, one for each stage: a moving target.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples};
/// use dualbody::trajopt::{Activation, Cost, FramePosition, Schedule};
///
/// let arm = Simulator::new(samples::arm());
/// let tool = arm.model().frame("tool").expect("the arm has a tool");
/// let circle = (0..100).map(|k| (0.02 * f64::from(k)).sin_cos());
/// let circle = circle.map(|(y, z)| FramePosition::new(tool, [0.5, 0.2 * y, 0.5 + 0.2 * z]));
/// let follow = Cost::new().with(1.0, Activation::Quadratic, Schedule::new(circle));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule<R> {
    residuals: Vec<R>,
}

impl<R> Schedule<R> {
    /// Makes a schedule of one residual per stage, all of the same dimension and dependence; stages beyond the end use the last residual.
    ///
    /// # Panics
    /// If the list is empty.
    pub fn new(residuals: impl IntoIterator<Item = R>) -> Self {
        let residuals = Vec::from_iter(residuals);
        assert!(
            !residuals.is_empty(),
            "a schedule has 0 residuals, expected at least 1"
        );
        Self { residuals }
    }

    /// The residual of a stage, which has to have `dim` entries.
    fn checked<T: Scalar>(&self, node: &Node<'_, T>, dim: usize) -> &R
    where
        R: Residual,
    {
        let own = &self.residuals[node.stage.min(self.residuals.len() - 1)];
        assert_eq!(
            own.dim(&node.on_plain()),
            dim,
            "entries of the residual of stage {} of a schedule, which must be as many as those of the first",
            node.stage
        );
        own
    }
}

/// # Panics
/// If the residual of a stage has another dimension than that of the first one.
impl<R: Residual> Residual for Schedule<R> {
    fn dim(&self, node: &Node<'_>) -> usize {
        self.residuals[0].dim(node)
    }

    fn depends_on(&self) -> Dependence {
        self.residuals[0].depends_on()
    }

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], u: &[T], r: &mut [T]) {
        self.checked(node, r.len()).eval(node, x, u, r);
    }

    fn value(&self, node: &Node<'_>, x: &[f64], u: &[f64], r: &mut [f64]) {
        self.checked(node, r.len()).value(node, x, u, r);
    }

    fn linearize(&self, node: &Node<'_>, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        let own = self.checked(node, out.values.len());
        own.linearize(node, x, u, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;
    use crate::sim::Simulator;
    use crate::trajopt::{Activation, Cost, StateError};

    #[test]
    fn each_stage_counts_its_own_residual_and_later_ones_the_last() {
        let pendulum = Simulator::new(samples::pendulum());
        let targets = [1.0, 2.0].map(|q| StateError::to(&[q, 0.0]));
        let cost = Cost::new().with(2.0, Activation::Quadratic, Schedule::new(targets));
        let x = [0.5, 0.0];
        for (stage, target) in [(0, 1.0), (1, 2.0), (7, 2.0)] {
            let off: f64 = 0.5 - target;
            let at = cost.expand(&pendulum, stage, &x, &[0.0]);
            assert_eq!((at.value, at.gradient[0]), (off * off, 2.0 * off));
            #[cfg(feature = "second-order")]
            {
                let exact = cost.expand_exactly(&pendulum, stage, &x, &[0.0]);
                assert_eq!((exact.value, exact.hessian[(0, 0)]), (off * off, 2.0));
            }
        }
    }
}
