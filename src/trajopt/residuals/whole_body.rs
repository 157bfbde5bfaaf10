//! Centre of mass and momentum.

use nalgebra::Vector3;

use super::away_from;
use crate::dynamics::{center_of_mass, centroidal_momentum};
use crate::scalar::Scalar;
use crate::spatial::SPATIAL;
use crate::trajopt::residual::Dependence;
use crate::trajopt::residual::built_in::{BuiltIn, Site, built_in_residual};
use crate::trajopt::system::{On, Sizes};

/// c − target, m: the centre of mass in the world, 3 entries. Allocates when it is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct CenterOfMass {
    /// Target of the centre of mass in the world, m.
    pub target: Vector3<f64>,
}

impl BuiltIn for CenterOfMass {
    fn dim(&self, _: &dyn Sizes) -> usize {
        3
    }

    fn depends_on(&self) -> Dependence {
        Dependence::Configuration
    }

    fn eval<T: Scalar>(&self, site: &Site<'_, dyn On<T> + '_>, x: &[T], _: &[T], r: &mut [T]) {
        let model = site.model();
        let c = center_of_mass(model, &x[..model.nq()]);
        away_from(self.target.as_slice(), c.as_slice(), r);
    }
}

/// h − target: the momentum about the centre of mass, `[linear; angular]` in the axes of the world, kg·m/s and kg·m²/s,
/// 6 entries. Allocates when it is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct CentroidalMomentum {
    /// The momentum as it should be.
    pub target: [f64; SPATIAL],
}

impl BuiltIn for CentroidalMomentum {
    fn dim(&self, _: &dyn Sizes) -> usize {
        SPATIAL
    }

    fn depends_on(&self) -> Dependence {
        Dependence::State
    }

    fn eval<T: Scalar>(&self, site: &Site<'_, dyn On<T> + '_>, x: &[T], _: &[T], r: &mut [T]) {
        let model = site.model();
        let (q, v) = (&x[..model.nq()], &x[model.nq()..][..model.nv()]);
        let h = centroidal_momentum(model, q, v);
        away_from(&self.target, &h.to_array(), r);
    }
}

built_in_residual!(CenterOfMass, of a robot);
built_in_residual!(CentroidalMomentum, of a robot);
