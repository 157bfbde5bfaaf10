//! Working memory on one scalar.

use dualbody::dynamics::{
    AbaScratch, CoriolisScratch, CrbaScratch, ForwardDynamicsDerivatives,
    ForwardDynamicsDerivativesScratch, InverseDynamicsDerivatives,
    InverseDynamicsDerivativesScratch, MassMatrixInverseScratch, RneaScratch,
};
use dualbody::scalar::Differentiable;
use dualbody::spatial::Force;
use dualbody::{Model, Scalar};
use nalgebra::DMatrix;

/// Working memory for a model. Its parts are made at once or at the first call that needs them.
pub struct Memory<T: Differentiable> {
    pub rnea: RneaScratch<T>,
    pub crba: Option<CrbaScratch<T>>,
    pub aba: Option<AbaScratch<T>>,
    pub inverse: Option<MassMatrixInverseScratch<T>>,
    pub coriolis: Option<CoriolisScratch<T>>,
    pub inverse_derivatives: Option<(
        InverseDynamicsDerivativesScratch<T>,
        InverseDynamicsDerivatives<T>,
    )>,
    pub forward_derivatives: Option<(
        ForwardDynamicsDerivativesScratch<T>,
        ForwardDynamicsDerivatives<T>,
    )>,
    pub square: DMatrix<T>,
    pub frame: DMatrix<T>,
    pub external: Vec<Force<T>>,
}

impl<T: Differentiable> Memory<T> {
    /// Memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let nv = model.nv();
        Self {
            rnea: RneaScratch::new(model),
            crba: None,
            aba: None,
            inverse: None,
            coriolis: None,
            inverse_derivatives: None,
            forward_derivatives: None,
            square: DMatrix::zeros(nv, nv),
            frame: DMatrix::zeros(6, nv),
            external: Vec::new(),
        }
    }

    /// The external forces on the bodies from their numbers, body by body; none if there are no numbers.
    pub fn read_external(&mut self, numbers: Option<&&[T]>) {
        self.external.clear();
        let forces = numbers.map_or(&[][..], |all| all).chunks_exact(6);
        self.external
            .extend(forces.map(|x| Force::from_array(std::array::from_fn(|k| x[k]))));
    }
}
