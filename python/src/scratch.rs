//! Working memory of the hot functions for one model, kept by each thread.

use dualbody::dynamics::{
    AbaScratch, CoriolisScratch, CrbaScratch, ForwardDynamicsDerivatives,
    ForwardDynamicsDerivativesScratch, InverseDynamicsDerivatives,
    InverseDynamicsDerivativesScratch, MassMatrixInverseScratch, RneaScratch,
};
use dualbody::sim::BatchScalar;
use dualbody::spatial::Force;
use dualbody::{Model, Scalar};
use nalgebra::DMatrix;

/// Working memory that a thread keeps, for as many models or simulators.
const KEPT: usize = 8;

/// Finds the memory that is meant among what a thread keeps; it is made at the first call, and the oldest goes if there are too many.
pub(crate) fn find_or_make<M, E>(
    all: &mut Vec<M>,
    is_meant: impl Fn(&M) -> bool,
    make: impl FnOnce() -> Result<M, E>,
) -> Result<&mut M, E> {
    let at = match all.iter().position(is_meant) {
        Some(at) => at,
        None => {
            let new = make()?;
            if all.len() == KEPT {
                all.remove(0);
            }
            all.push(new);
            all.len() - 1
        }
    };
    Ok(&mut all[at])
}

/// Working memory for a model.
pub(crate) struct Memory {
    id: u64,
    pub(crate) one: Of<f64>,
    pub(crate) wide: Of<BatchScalar>,
    pub(crate) inverse_derivatives: Option<(
        InverseDynamicsDerivativesScratch,
        InverseDynamicsDerivatives,
    )>,
    pub(crate) forward_derivatives: Option<(
        ForwardDynamicsDerivativesScratch,
        ForwardDynamicsDerivatives,
    )>,
}

/// Working memory on one scalar. What is not made at once is made at the first call that needs it.
pub(crate) struct Of<T: Scalar> {
    pub(crate) rnea: RneaScratch<T>,
    pub(crate) crba: Option<CrbaScratch<T>>,
    pub(crate) aba: Option<AbaScratch<T>>,
    pub(crate) inverse: Option<MassMatrixInverseScratch<T>>,
    pub(crate) coriolis: Option<CoriolisScratch<T>>,
    pub(crate) square: DMatrix<T>,
    pub(crate) frame: DMatrix<T>,
    pub(crate) external: Vec<Force<T>>,
}

impl Memory {
    pub(crate) fn new(model: &Model, id: u64) -> Self {
        Self {
            id,
            one: Of::new(model),
            wide: Of::new(model),
            inverse_derivatives: None,
            forward_derivatives: None,
        }
    }

    pub(crate) fn id(&self) -> u64 {
        self.id
    }
}

impl<T: Scalar> Of<T> {
    fn new(model: &Model) -> Self {
        let nv = model.nv();
        Self {
            rnea: RneaScratch::new(model),
            crba: None,
            aba: None,
            inverse: None,
            coriolis: None,
            square: DMatrix::zeros(nv, nv),
            frame: DMatrix::zeros(6, nv),
            external: Vec::new(),
        }
    }

    /// The external forces on the bodies from their numbers, body by body; none if there are no numbers.
    pub(crate) fn read_external(&mut self, numbers: &[T]) {
        self.external.clear();
        let forces = numbers.chunks_exact(6);
        self.external
            .extend(forces.map(|x| Force::from_array(std::array::from_fn(|k| x[k]))));
    }
}
