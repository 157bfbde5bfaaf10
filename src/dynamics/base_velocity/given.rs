//! Dynamics with the base velocity in one representation throughout.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, DVector, Vector3};

use super::{
    acceleration_from_representation, acceleration_to_representation,
    coriolis_matrix_to_representation, force_from_representation, force_to_representation,
    jacobian_derivative_to_representation, jacobian_to_representation,
    mass_matrix_inverse_to_representation, mass_matrix_to_representation,
    velocity_from_representation,
};
use crate::dynamics::{
    self as own, MomentumFrame, centroidal_momentum_matrix, frame_jacobian, mass_matrix,
};
use crate::model::{FrameId, Model};
use crate::scalar::{Differentiable, Over, Scalar};
use crate::spatial::{Force, Motion, Representation};

/// The dynamics of a robot with its base velocity in a chosen representation: it takes and gives every velocity,
/// acceleration, force and matrix in that representation. The configuration is the crate's own.
///
/// Each function is the one of its name in [`dynamics`](crate::dynamics), converted as the functions
/// `…_to_representation` do it. For a robot with a fixed base they are the same. All allocate.
///
/// * `q` – configuration, length `nq`
/// * `v`, `a`, `tau` – length `nv`; the first six of a floating base are its velocity in the representation, the rate of
///   these numbers, and the force and moment that have their power with it
///
/// All functions panic if a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::dynamics::BaseVelocity;
/// use dualbody::{model::{LinkSpec, ModelBuilder}, spatial::Representation};
///
/// let mut builder = ModelBuilder::new("stone");
/// builder.add_link(LinkSpec::new("stone").with_mass(2.0, [0.0; 3], [0.1; 3]));
/// let stone = builder.build()?;
/// // It falls and turns: in axes of the world no force but its weight acts on it.
/// let (q, v) = ([0.0, 0.0, 1.0, 0.8, 0.0, 0.6, 0.0], [3.0, 0.0, -1.0, 0.2, 0.5, 0.1]);
/// let h = BaseVelocity::new(&stone, Representation::Mixed).bias_forces(&q, &v);
/// assert!((h[2] - 2.0 * 9.81).abs() < 1e-12 && h[0].abs() < 1e-12 && h[1].abs() < 1e-12);
/// # Ok::<(), dualbody::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct BaseVelocity<'m, P: Scalar = f64> {
    model: &'m Model<P>,
    representation: Representation,
}

impl<'m, P: Scalar> BaseVelocity<'m, P> {
    /// Chooses the representation of the base velocity of a robot.
    pub fn new(model: &'m Model<P>, representation: Representation) -> Self {
        Self {
            model,
            representation,
        }
    }

    /// Returns the representation.
    pub fn representation(&self) -> Representation {
        self.representation
    }

    /// Joint forces that produce accelerations:  τ' = M' v̇' + h'.
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

    /// Forces g' that hold the robot against gravity.
    pub fn gravity_forces<T: Over<P>>(&self, q: &[T]) -> DVector<T> {
        self.force(q, &own::gravity_forces(self.model, q))
    }

    /// Mass matrix M' with the kinetic energy ½ v'ᵀ M' v'.
    pub fn mass_matrix<T: Over<P>>(&self, q: &[T]) -> DMatrix<T> {
        mass_matrix_to_representation(
            self.model,
            q,
            &mass_matrix(self.model, q),
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
        let M = mass_matrix(self.model, q);
        coriolis_matrix_to_representation(self.model, q, v.as_slice(), &C, &M, self.representation)
    }

    /// Velocity of a frame, in a representation of its own.
    pub fn frame_velocity<T: Over<P>>(
        &self,
        q: &[T],
        v: &[T],
        frame: FrameId,
        representation: Representation,
    ) -> Motion<T> {
        let v = self.velocity(q, v);
        own::frame_velocity(self.model, q, v.as_slice(), frame, representation)
    }

    /// Acceleration J' v̇' + J̇' v' of a frame, in a representation of its own.
    pub fn frame_acceleration<T: Over<P>>(
        &self,
        q: &[T],
        v: &[T],
        a: &[T],
        frame: FrameId,
        representation: Representation,
    ) -> Motion<T> {
        let (v, a) = self.motion(q, v, a);
        own::frame_acceleration(
            self.model,
            q,
            v.as_slice(),
            a.as_slice(),
            frame,
            representation,
        )
    }

    /// Bias acceleration J̇' v' of a frame: its acceleration where v̇' is zero.
    pub fn frame_bias_acceleration<T: Over<P>>(
        &self,
        q: &[T],
        v: &[T],
        frame: FrameId,
        representation: Representation,
    ) -> Motion<T> {
        let (v, a) = self.still(q, v);
        own::frame_acceleration(
            self.model,
            q,
            v.as_slice(),
            a.as_slice(),
            frame,
            representation,
        )
    }

    /// Jacobian J' of a frame, 6 × `nv`.
    pub fn frame_jacobian<T: Over<P>>(
        &self,
        q: &[T],
        frame: FrameId,
        representation: Representation,
    ) -> DMatrix<T> {
        let J = frame_jacobian(self.model, q, frame, representation);
        jacobian_to_representation(self.model, q, &J, self.representation)
    }

    /// Rate J̇' of the Jacobian of a frame, 6 × `nv`.
    pub fn frame_jacobian_derivative<T: Over<P>>(
        &self,
        q: &[T],
        v: &[T],
        frame: FrameId,
        representation: Representation,
    ) -> DMatrix<T> {
        let v = self.velocity(q, v);
        let J = frame_jacobian(self.model, q, frame, representation);
        let rate =
            own::frame_jacobian_derivative(self.model, q, v.as_slice(), frame, representation);
        jacobian_derivative_to_representation(
            self.model,
            q,
            v.as_slice(),
            &J,
            &rate,
            self.representation,
        )
    }

    /// Momentum of all bodies.
    pub fn momentum<T: Over<P>>(&self, q: &[T], v: &[T], frame: MomentumFrame) -> Force<T> {
        let v = self.velocity(q, v);
        own::momentum(self.model, q, v.as_slice(), frame)
    }

    /// Momentum matrix A' with h = A' v', 6 × `nv`.
    pub fn momentum_matrix<T: Over<P>>(&self, q: &[T], frame: MomentumFrame) -> DMatrix<T> {
        let A = own::momentum_matrix(self.model, q, frame);
        jacobian_to_representation(self.model, q, &A, self.representation)
    }

    /// Rate A' v̇' + Ȧ' v' of the centroidal momentum.
    pub fn centroidal_momentum_rate<T: Over<P>>(&self, q: &[T], v: &[T], a: &[T]) -> Force<T> {
        let (v, a) = self.motion(q, v, a);
        own::centroidal_momentum_rate(self.model, q, v.as_slice(), a.as_slice())
    }

    /// Jacobian of the average velocity, 6 × `nv`.
    pub fn average_velocity_jacobian<T: Over<P>>(
        &self,
        q: &[T],
        frame: MomentumFrame,
    ) -> DMatrix<T> {
        let J = own::average_velocity_jacobian(self.model, q, frame);
        jacobian_to_representation(self.model, q, &J, self.representation)
    }

    /// Velocity ċ of the centre of mass in the world.
    pub fn center_of_mass_velocity<T: Over<P>>(&self, q: &[T], v: &[T]) -> Vector3<T> {
        own::center_of_mass_velocity(self.model, q, self.velocity(q, v).as_slice())
    }

    /// Jacobian of the centre of mass, 3 × `nv`.
    pub fn center_of_mass_jacobian<T: Over<P>>(&self, q: &[T]) -> DMatrix<T> {
        let J = own::center_of_mass_jacobian(self.model, q);
        jacobian_to_representation(self.model, q, &J, self.representation)
    }

    /// Acceleration c̈ of the centre of mass in the world; with `a` of zeros it is the bias.
    pub fn center_of_mass_acceleration<T: Over<P>>(&self, q: &[T], v: &[T], a: &[T]) -> Vector3<T> {
        let (v, a) = self.motion(q, v, a);
        own::center_of_mass_acceleration(self.model, q, v.as_slice(), a.as_slice())
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

impl<T: Differentiable> BaseVelocity<'_, T> {
    /// Rate Ȧ' of the centroidal momentum matrix, 6 × `nv`.
    pub fn centroidal_momentum_matrix_derivative(&self, q: &[T], v: &[T]) -> DMatrix<T> {
        let v = self.velocity(q, v);
        let A = centroidal_momentum_matrix(self.model, q);
        let rate = own::centroidal_momentum_matrix_derivative(self.model, q, v.as_slice());
        jacobian_derivative_to_representation(
            self.model,
            q,
            v.as_slice(),
            &A,
            &rate,
            self.representation,
        )
    }
}
