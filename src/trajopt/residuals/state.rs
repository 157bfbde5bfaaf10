//! Errors of state and input: their differences from a reference.

use super::away_from;
use crate::scalar::{Scalar, lift_into};
use crate::sim::State;
use crate::trajopt::residual::{Dependence, Node, Residual, ResidualJacobian, compiled_here};
use crate::trajopt::robot::Robot;
use crate::trajopt::system::Sizes;

/// Reference value: the same at all stages, or one for each.
#[derive(Clone, Debug, PartialEq)]
enum Reference {
    Constant(Vec<f64>),
    /// Stages after the last one take the last.
    Trajectory(Vec<Vec<f64>>),
}

impl Reference {
    fn trajectory(points: &[impl AsRef<[f64]>]) -> Self {
        assert!(
            !points.is_empty(),
            "a reference trajectory has 0 points, expected at least 1"
        );
        Self::Trajectory(points.iter().map(|x| x.as_ref().to_vec()).collect())
    }

    fn at(&self, stage: usize) -> &[f64] {
        match self {
            Self::Constant(x) => x,
            Self::Trajectory(points) => &points[stage.min(points.len() - 1)],
        }
    }
}

/// x ⊖ reference, length `ndx`.
#[derive(Clone, Debug, PartialEq)]
pub struct StateError {
    reference: Reference,
}

impl StateError {
    /// Makes the error from a state x, length `nx`. Angles are not wrapped: π and −π are different targets.
    pub fn to(x: &[f64]) -> Self {
        Self {
            reference: Reference::Constant(x.to_vec()),
        }
    }

    /// Makes the error from a robot's neutral configuration at rest.
    pub fn to_neutral<R: Robot>(robot: &R) -> Self {
        let neutral = robot.pack(&State::neutral(robot.model()));
        Self::to(neutral.as_slice())
    }

    /// Makes the error from one state per stage, each of length `nx`; stages beyond the end use the last state.
    ///
    /// # Panics
    /// If the list is empty.
    pub fn along(states: &[impl AsRef<[f64]>]) -> Self {
        Self {
            reference: Reference::trajectory(states),
        }
    }
}

impl Residual for StateError {
    compiled_here!();

    fn dim(&self, node: &Node<'_>) -> usize {
        node.dynamics.ndx()
    }

    fn depends_on(&self) -> Dependence {
        Dependence::State
    }

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        with_lifted(self.reference.at(node.stage), |reference| {
            node.dynamics.difference(reference, x, r);
        });
    }

    fn value(&self, node: &Node<'_>, x: &[f64], _: &[f64], r: &mut [f64]) {
        node.dynamics
            .difference(self.reference.at(node.stage), x, r);
    }

    fn linearize(&self, node: &Node<'_>, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        if !node.dynamics.is_vector_space() {
            return out.fill_by_duals(self, node, x, u);
        }
        self.value(node, x, u, &mut out.values);
        for i in 0..out.ndx() {
            out.row_mut(i)[i] = 1.0;
        }
    }
}

/// u − reference, length `nu`.
#[derive(Clone, Debug, PartialEq)]
pub struct InputError {
    reference: Reference,
}

impl InputError {
    /// Makes the error from an input u, length `nu`.
    pub fn to(u: &[f64]) -> Self {
        Self {
            reference: Reference::Constant(u.to_vec()),
        }
    }

    /// Makes the error from zero input.
    pub fn to_zero(dynamics: &dyn Sizes) -> Self {
        Self::to(&vec![0.0; dynamics.nu()])
    }

    /// Makes the error from one input per stage, each of length `nu`; stages beyond the end use the last input.
    ///
    /// # Panics
    /// If the list is empty.
    pub fn along(inputs: &[impl AsRef<[f64]>]) -> Self {
        Self {
            reference: Reference::trajectory(inputs),
        }
    }
}

impl Residual for InputError {
    compiled_here!();

    fn dim(&self, node: &Node<'_>) -> usize {
        node.dynamics.nu()
    }

    fn depends_on(&self) -> Dependence {
        Dependence::Input
    }

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, _: &[T], u: &[T], r: &mut [T]) {
        away_from(self.reference.at(node.stage), u, r);
    }

    fn linearize(&self, node: &Node<'_>, _: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        away_from(self.reference.at(node.stage), u, &mut out.values);
        let first = out.ndx();
        for i in 0..u.len() {
            out.row_mut(i)[first + i] = 1.0;
        }
    }
}

/// States up to this length are lifted on the stack: a humanoid's are.
const ON_STACK: usize = 80;

/// Hands plain numbers on another scalar to a function, without allocation unless there are many.
fn with_lifted<T: Scalar>(x: &[f64], f: impl FnOnce(&[T])) {
    if x.len() > ON_STACK {
        let lifted: Vec<T> = x.iter().map(|&x| T::constant(x)).collect();
        return f(&lifted);
    }
    let mut lifted = [T::zero(); ON_STACK];
    lift_into(x, &mut lifted);
    f(&lifted[..x.len()]);
}
