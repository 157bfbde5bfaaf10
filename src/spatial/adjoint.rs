//! The maps of motions and forces between frames as 6 × 6 matrices, rows and columns `[linear; angular]`.
//!
//! Products are cheaper with [`Transform::motion`] and [`Transform::force`].

use nalgebra::{Matrix6, Vector3};

use super::{Force, Motion, SPATIAL, Transform};
use crate::scalar::{Scalar, from_each};

impl<T: Scalar> Transform<T> {
    /// Adjoint matrix (R, \[p\] R; 0, R): it maps motions from B to A, as [`motion`](Self::motion) does.
    ///
    /// # Examples
    /// ```
    /// use dualbody::spatial::{Motion, Transform};
    /// use nalgebra::{Vector3, Vector6};
    ///
    /// let pose = Transform::from_translation(Vector3::new(2.0, 0.0, 0.0));
    /// let turning = [0.0, 0.0, 0.0, 0.0, 0.0, 3.0];
    /// let by_matrix = pose.adjoint() * Vector6::from(turning);
    /// assert_eq!(by_matrix[1], -6.0); // the point of the body at A's origin
    /// assert_eq!(pose.motion(&Motion::from_array(turning)).to_array(), by_matrix.as_slice());
    /// ```
    ///
    /// # References
    /// [Murray, Li, Sastry 1994, section 2.4].
    pub fn adjoint(&self) -> Matrix6<T> {
        matrix(|k| self.motion(&Motion::basis(k)).to_array())
    }

    /// Matrix (R, 0; \[p\] R, R) that maps forces from B to A, as [`force`](Self::force) does: the inverse transpose of
    /// the [adjoint](Self::adjoint).
    pub fn force_adjoint(&self) -> Matrix6<T> {
        matrix(|k| self.force(&basis_force(k)).to_array())
    }
}

fn basis_force<T: Scalar>(k: usize) -> Force<T> {
    let unit: Motion<T> = Motion::basis(k);
    let (linear, angular): (Vector3<T>, Vector3<T>) = (unit.linear, unit.angular);
    Force::new(linear, angular)
}

/// The matrix of these columns.
fn matrix<T: Scalar>(column: impl Fn(usize) -> [T; SPATIAL]) -> Matrix6<T> {
    let columns: [[T; SPATIAL]; SPATIAL] = from_each(column);
    Matrix6::from_fn(|row, k| columns[k][row])
}

#[cfg(test)]
impl<T: Scalar> Motion<T> {
    /// Matrix V × of the [cross product](Self::cross) with a motion: (\[ω\], \[v\]; 0, \[ω\]). That of the [cross product](Self::cross_force)
    /// with a force is −(V ×)ᵀ.
    pub(crate) fn cross_matrix(&self) -> Matrix6<T> {
        matrix(|k| self.cross(&Self::basis(k)).to_array())
    }
}

#[cfg(test)]
#[expect(non_snake_case, reason = "monogram notation, see the conventions")]
mod tests {
    use super::*;
    use crate::spatial::Quaternion;

    fn pose() -> Transform<f64> {
        Transform::new(
            Quaternion::exp(&Vector3::new(0.4, -1.0, 0.6)).to_matrix(),
            Vector3::new(1.0, -2.0, 0.5),
        )
    }

    #[test]
    fn adjoint_of_the_inverse_is_the_inverse_and_that_of_forces_the_inverse_transpose() {
        let X = pose();
        let off = |a: Matrix6<f64>, b: Matrix6<f64>| (a - b).amax();
        let one = Matrix6::identity();
        assert!(off(X.adjoint() * X.inverse().adjoint(), one) < 1e-14);
        assert!(off(X.force_adjoint(), X.inverse().adjoint().transpose()) < 1e-14);
        assert!(off(X.inverse().force_adjoint(), X.adjoint().transpose()) < 1e-14);
    }

    #[test]
    fn adjoint_of_a_product_is_the_product_of_adjoints() {
        let X = pose();
        let off = (X * X).adjoint() - X.adjoint() * X.adjoint();
        assert!(off.amax() < 1e-13);
    }

    // d/dt Ad(exp(V t)) = V × at t = 0, by central differences.
    #[test]
    fn cross_matrix_is_the_rate_of_the_adjoint() {
        let V = Motion::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4]);
        let at = |t: f64| Transform::exp(&(V * t)).adjoint();
        let rate = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!((rate - V.cross_matrix()).amax() < 1e-9);
        let of_force = matrix(|k| V.cross_force(&basis_force(k)).to_array());
        assert_eq!((of_force + V.cross_matrix().transpose()).amax(), 0.0);
    }
}
