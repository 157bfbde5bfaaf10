//! Errors of state and input: their differences from a reference.

use super::away_from;
use crate::scalar::{Scalar, lift_into};
use crate::sim::State;
use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::residual::{Dependence, Node, Residual, ResidualJacobian};
use crate::trajopt::robot::Robot;

/// Reference value: the same at all stages, or one for each.
#[derive(Clone, Debug, PartialEq)]
enum Reference {
    Constant(Vec<f64>),
    /// Stages after the last one take the last.
    Trajectory(Vec<Vec<f64>>),
}

impl Reference {
    fn trajectory(points: &[impl AsRef<[f64]>]) -> Self {
        assert!(!points.is_empty(), "a reference trajectory has points");
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
    /// To a state x, length `nx`.
    pub fn to(x: &[f64]) -> Self {
        Self {
            reference: Reference::Constant(x.to_vec()),
        }
    }

    /// To a robot's neutral configuration at rest.
    pub fn to_neutral<R: Robot>(robot: &R) -> Self {
        let neutral = robot.pack(&State::neutral(robot.model()));
        Self::to(neutral.as_slice())
    }

    /// To one state after the other; stages beyond their end take the last.
    ///
    /// # Panics
    /// If there is none.
    pub fn along(states: &[impl AsRef<[f64]>]) -> Self {
        Self {
            reference: Reference::trajectory(states),
        }
    }
}

impl<D: Dynamics> Residual<D> for StateError {
    fn dim(&self, dynamics: &D) -> usize {
        dynamics.ndx()
    }

    fn depends_on(&self) -> Dependence {
        Dependence::State
    }

    fn eval<T: Scalar>(&self, node: &Node<'_, D>, x: &[T], _: &[T], r: &mut [T]) {
        with_lifted(self.reference.at(node.stage), |reference| {
            node.dynamics.difference(reference, x, r);
        });
    }

    fn value(&self, node: &Node<'_, D>, x: &[f64], _: &[f64], r: &mut [f64]) {
        node.dynamics
            .difference(self.reference.at(node.stage), x, r);
    }

    fn linearize(&self, node: &Node<'_, D>, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
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
    /// To an input u, length `nu`.
    pub fn to(u: &[f64]) -> Self {
        Self {
            reference: Reference::Constant(u.to_vec()),
        }
    }

    /// To no input.
    pub fn to_zero<D: Dynamics>(dynamics: &D) -> Self {
        Self::to(&vec![0.0; dynamics.nu()])
    }

    /// To one input after the other; stages beyond their end take the last.
    ///
    /// # Panics
    /// If there is none.
    pub fn along(inputs: &[impl AsRef<[f64]>]) -> Self {
        Self {
            reference: Reference::trajectory(inputs),
        }
    }
}

impl<D: Dynamics> Residual<D> for InputError {
    fn dim(&self, dynamics: &D) -> usize {
        dynamics.nu()
    }

    fn depends_on(&self) -> Dependence {
        Dependence::Input
    }

    fn eval<T: Scalar>(&self, node: &Node<'_, D>, _: &[T], u: &[T], r: &mut [T]) {
        away_from(self.reference.at(node.stage), u, r);
    }

    fn linearize(&self, node: &Node<'_, D>, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        let first = out.ndx();
        let mut values = std::mem::take(&mut out.values);
        self.value(node, x, u, &mut values);
        out.values = values;
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
