//! Remarks on rotations that a step does not resolve.
//!
//! Coriolis and centrifugal forces turn the motion of what spins. In a body without forces ω̇ = −I⁻¹ (ω × I ω), whose slope in ω has eigenvalues λ of the size
//! of the nutation rate. So the measure is not the speed of a joint, which a symmetric wheel may have as high as it likes, but the largest |λ| of all that
//! speed adds to the Jacobian of the rate.
//!
//! Largest change of energy in a turn at |λ| Δt = x, as a part of the kinetic energy, over ten turns: a body with inertias 1, 2, 3 that turns about its middle
//! axis and about (1, 1, 1), a slim one (0.1, 1, 1) about (1, 1, 0), a heavy top, and a double pendulum.
//!
//! TABLE
//!
//! The limits are where 1 % is passed by the worst of them.

use nalgebra::DMatrix;

use super::frozen::{Frozen, shape};
use crate::joint::Joint;
use crate::linalg::eigenvalues;
use crate::model::Model;
use crate::sim::{Integrator, Simulator, SimulatorRemark};

/// |λ| Δt up to which energy changes by about 1 % in a turn, see above.
fn largest_angle(integrator: Integrator) -> f64 {
    match integrator {
        Integrator::SemiImplicitEuler => 0.01,
        Integrator::ImplicitVelocity | Integrator::RungeKutta4 => 1.0,
        Integrator::ImplicitMidpoint => 2.0,
    }
}

impl Simulator<f64> {
    /// The remark on the fastest change that Coriolis and centrifugal forces make at a velocity.
    pub(super) fn remark_on_rotation(&self, q: &[f64], v: &[f64]) -> Option<SimulatorRemark> {
        let bare = self.with_inertia_only();
        let moving = Frozen::new(bare.clone(), q, v);
        let still = Frozen::new(bare, q, &vec![0.0; v.len()]);
        let mut by_speed = moving.rate() - still.rate();
        let nv = v.len();
        by_speed.view_mut((0, nv), (nv, nv)).fill_with_identity();
        leave_out_translation(self.model(), &mut by_speed);
        let found = eigenvalues(by_speed.clone()).into_iter();
        let fastest = found.max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()))?;
        let time_step = self.time_step();
        let (angle, largest) = (fastest.norm(), largest_angle(self.effective_integrator(v)));
        if angle <= largest {
            return None;
        }
        let implicit = Integrator::ImplicitVelocity;
        Some(SimulatorRemark::UnresolvedRotation {
            joint: moving.name(&shape(&by_speed, fastest)?),
            rate: angle / time_step,
            longest: time_step * largest / angle,
            time_step,
            better: (angle <= largest_angle(implicit)).then_some(implicit),
        })
    }

    /// The integrator by whose rule these forces are taken.
    fn effective_integrator(&self, v: &[f64]) -> Integrator {
        match self.takes_middle_at(v) {
            true => Integrator::ImplicitVelocity,
            false => self.integrator(),
        }
    }
}

/// Takes out the linear velocity of bodies whose joint moves in axes of the body: it turns in these axes, which is exact in a step and changes nothing else.
fn leave_out_translation(model: &Model, a: &mut DMatrix<f64>) {
    let nv = model.nv();
    let bodies = model.independent();
    let turning = bodies.filter(|body| body.joint.turns_with_body());
    let axes = turning.flat_map(|body| body.axes());
    for (k, _) in axes.filter(|(_, axis)| !axis.is_angular()) {
        for k in [k, nv + k] {
            a.row_mut(k).fill(0.0);
            a.column_mut(k).fill(0.0);
        }
    }
}
