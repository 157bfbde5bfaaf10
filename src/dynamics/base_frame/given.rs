//! The base velocity in a chosen representation: conversions, and the equation of motion there.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, DVector};

use super::{
    acceleration_from_representation, acceleration_to_representation,
    coriolis_matrix_to_representation, deviation_from_representation, deviation_to_representation,
    force_from_representation, force_to_representation, gradient_from_representation,
    gradient_to_representation, jacobian_derivative_to_representation, jacobian_to_representation,
    mass_matrix_inverse_to_representation, mass_matrix_to_representation,
    velocity_from_representation, velocity_to_representation,
};
use crate::dynamics as own;
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::Representation;

/// Quantities whose base part depends on the representation.
///
/// * `v` – velocity, length `nv`, in the representation of this crate
#[derive(Clone, Copy, Debug)]
pub enum BaseQuantity<'a, T: Scalar> {
    /// Velocity, length `nv`, or a small motion of the configuration.
    Velocity,
    /// Acceleration, length `nv`: the rate of the coordinates of the velocity.
    Acceleration {
        /// The velocity there.
        v: &'a [T],
    },
    /// Joint forces, length `nv`: force and moment on the base, dual to its velocity in power.
    Force,
    /// A tangent δx = (δq, δv, δm) of a state, length 2 `nv` or more:  δx' = S(x) δx.
    ///
    /// δq' is the small motion T(q) δq: in the mixed representation its base part is the change of the base's position in the
    /// world, then a rotation vector in axes of the world. δv' is the change of the velocity T(q) v, which also depends on q:
    /// the base part of δv' = T (δv + Ω(δq) × v), where Ω(δq) is δq without its linear part (*mixed*), δq (*inertial*), or zero
    /// (*body*). Entries after these, such as a contact state δm, stay unchanged. A deviation of finite size is converted by the same linear map.
    Deviation {
        /// The velocity of the state.
        v: &'a [T],
    },
    /// A gradient in the tangent of a state, for example a row of a controller gain: g' = S⁻ᵀ g, so g' · δx' = g · δx.
    Gradient {
        /// The velocity of the state.
        v: &'a [T],
    },
}

/// The base velocity of a robot in a chosen representation: conversions from and to the representation of this crate, and the equation of motion in it.
///
/// For all other functions of [`dynamics`](crate::dynamics), convert arguments and results. For example, with a velocity v' the momentum is
/// `momentum(model, q, v)` of v = [`from_representation`](Self::from_representation)(q, [`Velocity`](BaseQuantity::Velocity), v'), and the Jacobian
/// of a frame is the [`jacobian`](Self::jacobian) of its J. For a robot with a fixed base nothing changes. All functions allocate.
///
/// * `q` – configuration, length `nq`, in the format of this crate
///
/// All functions panic if a slice or matrix has the wrong size.
///
/// # Examples
/// ```
/// use dualbody::dynamics::{BaseFrame, BaseQuantity};
/// use dualbody::{model::{LinkSpec, ModelBuilder}, spatial::Representation};
///
/// let mut builder = ModelBuilder::new("ball");
/// builder.add_link(LinkSpec::new("ball").with_mass(1.0, [0.0; 3], [0.1; 3]));
/// let ball = builder.build()?;
/// // It flies along x. Turned by 1 mrad about z, the same velocity in its own axes points 1 mrad aside in the world.
/// let (q, v) = ([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// let mut dx = [0.0; 12];
/// dx[5] = 1e-3;
/// let base = BaseFrame::new(&ball, Representation::Mixed);
/// let mixed = base.to_representation(&q, BaseQuantity::Deviation { v: &v }, &dx);
/// assert_eq!((mixed[5], mixed[7]), (1e-3, 2e-3));
/// // However it turns, in axes of the world no force but its weight acts on it.
/// let h = base.bias_forces(&q, &[3.0, 0.0, -1.0, 0.2, 0.5, 0.1]);
/// assert!((h[2] - 9.81).abs() < 1e-12 && h[0].abs() < 1e-12 && h[1].abs() < 1e-12);
/// # Ok::<(), dualbody::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct BaseFrame<'m, P: Scalar = f64> {
    model: &'m Model<P>,
    representation: Representation,
}

impl<'m, P: Scalar> BaseFrame<'m, P> {
    /// Chooses the representation of the base velocity of a robot.
    pub fn new(model: &'m Model<P>, representation: Representation) -> Self {
        Self {
            model,
            representation,
        }
    }

    /// Converts a vector from the representation of this crate to this one.
    pub fn to_representation<T: Over<P>>(
        &self,
        q: &[T],
        quantity: BaseQuantity<'_, T>,
        x: &[T],
    ) -> DVector<T> {
        let (model, to) = (self.model, self.representation);
        match quantity {
            BaseQuantity::Velocity => velocity_to_representation(model, q, x, to),
            BaseQuantity::Acceleration { v } => acceleration_to_representation(model, q, v, x, to),
            BaseQuantity::Force => force_to_representation(model, q, x, to),
            BaseQuantity::Deviation { v } => deviation_to_representation(model, q, v, x, to),
            BaseQuantity::Gradient { v } => gradient_to_representation(model, q, v, x, to),
        }
    }

    /// Converts a vector from this representation to that of this crate.
    pub fn from_representation<T: Over<P>>(
        &self,
        q: &[T],
        quantity: BaseQuantity<'_, T>,
        x: &[T],
    ) -> DVector<T> {
        let (model, from) = (self.model, self.representation);
        match quantity {
            BaseQuantity::Velocity => velocity_from_representation(model, q, x, from),
            BaseQuantity::Acceleration { v } => {
                acceleration_from_representation(model, q, v, x, from)
            }
            BaseQuantity::Force => force_from_representation(model, q, x, from),
            BaseQuantity::Deviation { v } => deviation_from_representation(model, q, v, x, from),
            BaseQuantity::Gradient { v } => gradient_from_representation(model, q, v, x, from),
        }
    }

    /// Converts a Jacobian (any rows × `nv`) to velocities in this representation: J' = J T⁻¹. Also for a momentum matrix; applied twice to a mass
    /// matrix, (M T⁻¹)ᵀ T⁻¹.
    ///
    /// # Panics
    /// If it does not have `nv` columns.
    pub fn jacobian<T: Over<P>>(&self, q: &[T], jacobian: &DMatrix<T>) -> DMatrix<T> {
        jacobian_to_representation(self.model, q, jacobian, self.representation)
    }

    /// Converts the rate of a Jacobian to velocities in this representation: J̇' = (J̇ − J T⁻¹ Ṫ) T⁻¹. Also for the rate of a momentum matrix.
    ///
    /// * `v` – velocity, in the representation of this crate
    /// * `jacobian`, `derivative` – J and J̇, for velocities in the representation of this crate
    ///
    /// # Panics
    /// If the matrices do not have equal rows and `nv` columns.
    pub fn jacobian_derivative<T: Over<P>>(
        &self,
        q: &[T],
        v: &[T],
        jacobian: &DMatrix<T>,
        derivative: &DMatrix<T>,
    ) -> DMatrix<T> {
        let to = self.representation;
        jacobian_derivative_to_representation(self.model, q, v, jacobian, derivative, to)
    }

    /// Joint forces τ' that produce accelerations at a velocity v':  τ' = M' v̇' + h'.
    pub fn inverse_dynamics<T: Over<P>>(&self, q: &[T], v: &[T], a: &[T]) -> DVector<T> {
        let (v, a) = self.motion(q, v, a);
        let tau = own::inverse_dynamics(self.model, q, v.as_slice(), a.as_slice());
        self.force(q, &tau)
    }

    /// Accelerations v̇' that joint forces τ' produce.
    pub fn forward_dynamics<T: Over<P>>(&self, q: &[T], v: &[T], tau: &[T]) -> DVector<T> {
        let (v, tau) = (
            self.velocity(q, v),
            force_from_representation(self.model, q, tau, self.representation),
        );
        let a = own::forward_dynamics(self.model, q, v.as_slice(), tau.as_slice());
        acceleration_to_representation(
            self.model,
            q,
            v.as_slice(),
            a.as_slice(),
            self.representation,
        )
    }

    /// Bias forces h' = C' v' + g': the forces that keep v̇' zero.
    pub fn bias_forces<T: Over<P>>(&self, q: &[T], v: &[T]) -> DVector<T> {
        let (v, a) = self.still(q, v);
        let h = own::inverse_dynamics(self.model, q, v.as_slice(), a.as_slice());
        self.force(q, &h)
    }

    /// Joint forces g' that balance gravity.
    pub fn gravity_forces<T: Over<P>>(&self, q: &[T]) -> DVector<T> {
        self.force(q, &own::gravity_forces(self.model, q))
    }

    /// Mass matrix M' with the kinetic energy ½ v'ᵀ M' v'.
    pub fn mass_matrix<T: Over<P>>(&self, q: &[T]) -> DMatrix<T> {
        mass_matrix_to_representation(
            self.model,
            q,
            &own::mass_matrix(self.model, q),
            self.representation,
        )
    }

    /// Inverse M'⁻¹ of the mass matrix.
    ///
    /// # Panics
    /// If the mass matrix is singular: [`Model::check_mass_matrix`].
    pub fn mass_matrix_inverse<T: Over<P>>(&self, q: &[T]) -> DMatrix<T> {
        let inverse = own::mass_matrix_inverse(self.model, q);
        mass_matrix_inverse_to_representation(self.model, q, &inverse, self.representation)
    }

    /// Coriolis matrix C' with h' = C' v' + g' and Ṁ' − 2 C' skew-symmetric.
    pub fn coriolis_matrix<T: Over<P>>(&self, q: &[T], v: &[T]) -> DMatrix<T> {
        let v = self.velocity(q, v);
        let C = own::coriolis_matrix(self.model, q, v.as_slice());
        let M = own::mass_matrix(self.model, q);
        coriolis_matrix_to_representation(self.model, q, v.as_slice(), &C, &M, self.representation)
    }

    /// The velocity in the crate's own representation.
    fn velocity<T: Over<P>>(&self, q: &[T], v: &[T]) -> DVector<T> {
        velocity_from_representation(self.model, q, v, self.representation)
    }

    /// Velocity and acceleration in the crate's own representation.
    fn motion<T: Over<P>>(&self, q: &[T], v: &[T], a: &[T]) -> (DVector<T>, DVector<T>) {
        let v = self.velocity(q, v);
        let a =
            acceleration_from_representation(self.model, q, v.as_slice(), a, self.representation);
        (v, a)
    }

    /// Velocity in the crate's own representation, and the acceleration there where that in this one is zero.
    fn still<T: Over<P>>(&self, q: &[T], v: &[T]) -> (DVector<T>, DVector<T>) {
        self.motion(q, v, &vec![T::zero(); self.model.nv()])
    }

    fn force<T: Over<P>>(&self, q: &[T], tau: &DVector<T>) -> DVector<T> {
        force_to_representation(self.model, q, tau.as_slice(), self.representation)
    }
}
