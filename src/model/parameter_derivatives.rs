//! Derivatives of all parameters of a robot over dual numbers.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, Vector3};

use super::{Model, ParameterGroup};
use crate::scalar::Dual;
use crate::spatial::{SPATIAL, Transform};

impl<const N: usize> Model<Dual<f64, N>> {
    /// Computes the derivatives of all [parameters](Self::parameters) (rows) in the directions of the dual numbers (columns), for a robot whose
    /// parameters are functions of variables. The transpose converts a gradient in the parameters to one in the variables.
    ///
    /// Placements are increments, as there: their rows are translation and rotation along the axes of the joint or frame.
    pub(crate) fn parameter_derivatives(&self) -> DMatrix<f64> {
        let parameters = self.parameters();
        let mut out = DMatrix::from_fn(parameters.len(), N, |i, k| parameters[i].eps[k]);
        for (group, range) in self.parameter_layout().groups() {
            let pose = match group {
                ParameterGroup::Placement(joint) => {
                    &self.bodies()[self.joints()[joint.0].bodies().start].placement
                }
                ParameterGroup::Frame(frame) => &self.frames()[frame.0].placement,
                _ => continue,
            };
            for k in 0..N {
                let increment = increment(pose, k);
                out.view_mut((range.start, k), (SPATIAL, 1))
                    .copy_from_slice(&increment);
            }
        }
        out
    }
}

/// Derivative of the increment of a pose: Rᵀ δp, and the axial vector of Rᵀ δR.
fn increment<const N: usize>(X: &Transform<Dual<f64, N>>, direction: usize) -> [f64; SPATIAL] {
    let R = X.rotation.map(|x| x.re).transpose();
    let turn = R * X.rotation.map(|x| x.eps[direction]);
    let shift: Vector3<f64> = R * X.translation.map(|x| x.eps[direction]);
    [shift.x, shift.y, shift.z, turn.m32, turn.m13, turn.m21]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;
    use crate::tests::SAME_ALGEBRA;

    // Increments of joints and frames, which are not differences of what the model holds.
    #[test]
    fn derivatives_of_parameters_in_themselves_equal_the_identity() {
        let model = samples::arm();
        let parameters = model.parameters();
        for index in 0..parameters.len() {
            let x = Dual::<f64, 1>::variable(parameters[index], 0);
            let seeded: Model<Dual<f64, 1>> = model.with_some_parameters(&[index], &[x]);
            let found = seeded.parameter_derivatives();
            for (k, slope) in found.iter().enumerate() {
                let expected = f64::from(u8::from(k == index));
                assert!((slope - expected).abs() < SAME_ALGEBRA, "{k} in {index}");
            }
        }
    }
}
