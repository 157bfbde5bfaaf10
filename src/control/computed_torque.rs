//! Computed torque: the model cancels the dynamics of the robot, and a linear error equation remains.

use nalgebra::DVector;

use crate::dynamics::inverse_dynamics;
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::sim::State;

/// The controller  `τ = M(q) (−k_p (q − q_des) − k_d (v − v_des)) + h(q, v)`.
///
/// On a fully actuated robot with an exact model, the error satisfies
/// `ë + k_d ė + k_p e = 0`.
///
/// # Examples
/// ```
/// use dualbody::{State, control::ComputedTorque, model::samples};
///
/// let model = samples::pendulum();
/// let controller = ComputedTorque::new(&model, 10.0, 6.0);
/// let target = State::new(&[0.0], &[0.0]);
/// let tau = controller.torque(&model, &State::new(&[0.3], &[0.0]), &target);
/// // M (−k_p q) + ½ g sin q
/// assert!((tau[0] - (-10.0 * 0.3 / 3.0 + 0.5 * 9.81 * 0.3_f64.sin())).abs() < 1e-14);
/// ```
///
/// # References
/// [Murray, Li, Sastry 1994, section 4.5.2].
#[derive(Clone, Debug, PartialEq)]
pub struct ComputedTorque {
    /// Position gain of each degree of freedom, 1/s².
    pub position_gain: DVector<f64>,
    /// Velocity gain of each degree of freedom, 1/s.
    pub velocity_gain: DVector<f64>,
}

impl ComputedTorque {
    /// Makes a controller with equal gains for all degrees of freedom of a model.
    pub fn new<P: Scalar>(model: &Model<P>, position_gain: f64, velocity_gain: f64) -> Self {
        let all = |gain| DVector::from_element(model.nv(), gain);
        Self {
            position_gain: all(position_gain),
            velocity_gain: all(velocity_gain),
        }
    }

    /// Computes the joint forces τ (length `nv`) that drive `state` to `target`. Allocates.
    ///
    /// # Panics
    /// If a state or the gains have the wrong length.
    pub fn torque<P: Scalar, T: Over<P>>(
        &self,
        model: &Model<P>,
        state: &State<T>,
        target: &State<T>,
    ) -> DVector<T> {
        model.check_v(self.position_gain.as_slice());
        model.check_v(self.velocity_gain.as_slice());
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        // a = k_p (q_des ⊖ q) + k_d (v_des − v), the error seen from where the robot is
        let mut a = model.difference(q, target.q.as_slice());
        for (k, a) in a.iter_mut().enumerate() {
            *a = *a * self.position_gain[k] + (target.v[k] - v[k]) * self.velocity_gain[k];
        }
        // τ = M a + h
        inverse_dynamics(model, q, v, a.as_slice())
    }
}
