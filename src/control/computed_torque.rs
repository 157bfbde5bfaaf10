//! Computed torque: the model cancels the dynamics of the robot, and a linear error equation remains.

use nalgebra::DVector;

use crate::dynamics::{RneaScratch, inverse_dynamics_into};
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

/// Working memory of [`ComputedTorque::torque_into`].
#[derive(Clone, Debug)]
pub struct ComputedTorqueScratch<T> {
    rnea: RneaScratch<T>,
    a: Vec<T>,
}

impl<T: Scalar> ComputedTorqueScratch<T> {
    /// Makes memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        Self {
            rnea: RneaScratch::new(model),
            a: vec![T::zero(); model.nv()],
        }
    }
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
        let mut scratch = ComputedTorqueScratch::new(model);
        let mut tau = DVector::zeros(model.nv());
        self.torque_into(model, state, target, &mut scratch, tau.as_mut_slice());
        tau
    }

    /// [`torque`](Self::torque) without allocation.
    ///
    /// # Panics
    /// If a state, the gains or the output have the wrong length.
    pub fn torque_into<P: Scalar, T: Over<P>>(
        &self,
        model: &Model<P>,
        state: &State<T>,
        target: &State<T>,
        scratch: &mut ComputedTorqueScratch<T>,
        tau: &mut [T],
    ) {
        model.check_v(self.position_gain.as_slice());
        model.check_v(self.velocity_gain.as_slice());
        // a = k_p (q_des ⊖ q) + k_d (v_des − v), the error seen from where the robot is
        model.difference_into(state.q.as_slice(), target.q.as_slice(), &mut scratch.a);
        for (k, a) in scratch.a.iter_mut().enumerate() {
            *a = *a * self.position_gain[k] + (target.v[k] - state.v[k]) * self.velocity_gain[k];
        }
        // τ = M a + h
        inverse_dynamics_into(
            model,
            state.q.as_slice(),
            state.v.as_slice(),
            &scratch.a,
            &[],
            &mut scratch.rnea,
            tau,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{bias_forces, forward_dynamics, mass_matrix};
    use crate::model::samples;
    use crate::sim::{Integrator, Simulator};
    use crate::tests::{OTHER_ALGORITHM, SAME_ALGEBRA};

    #[test]
    fn torque_equals_its_formula() {
        let model = samples::arm();
        let state = State::new(
            &[0.1, -0.4, 0.3, 0.8, -0.2, 0.5, 0.0],
            &[0.3, 0.1, -0.2, 0.5, 0.4, -0.6, 0.2],
        );
        let target = State::new(&[0.0; 7], &[0.1; 7]);
        let controller = ComputedTorque::new(&model, 10.0, 6.0);
        let a = (&target.q - &state.q) * 10.0 + (&target.v - &state.v) * 6.0;
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        let expected = mass_matrix(&model, q) * &a + bias_forces(&model, q, v);
        let tau = controller.torque(&model, &state, &target);
        assert!((&tau - expected).norm() < SAME_ALGEBRA);
        assert!((forward_dynamics(&model, q, v, tau.as_slice()) - a).norm() < OTHER_ALGORITHM);
    }

    // ë + 5 ė + 6 e = 0 from e₀ at rest: e(t) = e₀ (3 e⁻²ᵗ − 2 e⁻³ᵗ). The torque is held over each millisecond, so to
    // first order.
    #[test]
    fn closed_loop_equals_the_linear_error_equation() {
        let simulator = Simulator::new(samples::double_pendulum())
            .with_time_step(1e-3)
            .with_integrator(Integrator::RungeKutta4);
        let controller = ComputedTorque::new(simulator.model(), 6.0, 5.0);
        let (start, target) = (
            State::new(&[0.5, -0.3], &[0.0; 2]),
            State::new(&[0.1, 0.2], &[0.0; 2]),
        );
        let end = simulator
            .rollout(&start, 1000, |_, state, u| {
                u.copy_from_slice(
                    controller
                        .torque(simulator.model(), state, &target)
                        .as_slice(),
                );
            })
            .last()
            .clone();
        let factor = 3.0 * (-2.0_f64).exp() - 2.0 * (-3.0_f64).exp();
        let expected = &target.q + (&start.q - &target.q) * factor;
        assert!(
            (&end.q - &expected).norm() < 2e-3,
            "{} against {expected}",
            end.q
        );
    }
}
