//! Centre of mass and momentum.

use nalgebra::Vector3;

use super::away_from;
use crate::dynamics::{center_of_mass, centroidal_momentum};
use crate::scalar::Scalar;
use crate::spatial::SPATIAL;
use crate::trajopt::residual::{Node, Residual, fixed_size};

/// c − target, m: the centre of mass in the world, 3 entries. Allocates when it is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct CenterOfMass {
    /// Target of the centre of mass in the world, m.
    pub target: Vector3<f64>,
}

impl Residual for CenterOfMass {
    fixed_size!(3, Configuration);

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        let model = node.model();
        let c = center_of_mass(model, &x[..model.nq()]);
        away_from(self.target.as_slice(), c.as_slice(), r);
    }
}

/// h − target: the momentum about the centre of mass, `[linear; angular]` in the axes of the world, kg·m/s and kg·m²/s,
/// 6 entries. Allocates when it is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct CentroidalMomentum {
    /// Target momentum.
    pub target: [f64; SPATIAL],
}

impl Residual for CentroidalMomentum {
    fixed_size!(SPATIAL, State);

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        let model = node.model();
        let (q, v) = (&x[..model.nq()], &x[model.nq()..][..model.nv()]);
        let h = centroidal_momentum(model, q, v);
        away_from(&self.target, &h.to_array(), r);
    }
}
