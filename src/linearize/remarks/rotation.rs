//! Remarks on rotations that a step does not resolve.
//!
//! Coriolis and centrifugal forces rotate the motion of spinning bodies. For a free body ω̇ = −I⁻¹ (ω × I ω); its derivative in ω has eigenvalues λ
//! of the size of the nutation rate. So the criterion is not the speed of a joint, which may be arbitrarily high for a symmetric wheel, but the
//! largest |λ| of the velocity-dependent part of the Jacobian of the rate.
//!
//! |λ| Δt in rad above which energy changes by more than 1 % per revolution, relative to the kinetic energy at the start, averaged over ten revolutions:
//!
//! | | semi-implicit Euler | implicit velocity | Runge–Kutta | implicit midpoint |
//! |---|---|---|---|---|
//! | free body, inertias 1, 2, 3, about its middle axis | 0.023 | 0.6 | 1.5 | more than 1.4 |
//! | the same, about (1, 1, 1) | 0.006 | 1.3 | 0.93 | more than 1.6 |
//! | free body, inertias 0.1, 1, 1, about (1, 1, 0) | 0.003 | more than 1.5 | 0.75 | more than 1.5 |
//! | wheel, inertias 1, 1, 1.9, wobbling by a tenth | 0.05 | more than 2.2 | more than 2.2 | more than 2.2 |
//! | heavy top, 60 rad/s | 0.011 | more than 2 | 0.95 | more than 2 |
//! | double pendulum, 20 rad/s | 0.03 | 1.3 | 2.1 | more than 2 |
//!
//! | UR5, each joint at 7 to 10 rad/s | 0.004 | more than 0.08 | more than 0.08 | |
//! | humanoid rotating at 10 rad/s with unactuated limbs | 0.004 | 0.015; 8 % at 0.1, diverges at 0.36 | 0.35 | |
//!
//! A single pendulum at 20 rad/s has λ = 0 and stays below 1 % up to 1.8 rad per step with all integrators. The limit of semi-implicit Euler is in
//! the middle of its column, where the worst case changes by 4 % per revolution: ordinary motion would exceed a lower limit. With implicit velocity
//! the energy of linkages oscillates, and its limit is safe for the humanoid. That of the Runge–Kutta method is the minimum of its column.

use nalgebra::DMatrix;

use super::frozen::{Frozen, shape};
use crate::joint::Joint;
use crate::linalg::eigenvalues;
use crate::model::Model;
use crate::nested::IntoNested;
use crate::sim::{Integrator, Simulator, SimulatorRemark};

/// |λ| Δt up to which energy changes by about 1 % per revolution, rad: see above.
fn largest_angle(integrator: Integrator) -> f64 {
    match integrator {
        Integrator::SemiImplicitEuler => 0.01,
        Integrator::ImplicitVelocity => 0.2,
        Integrator::RungeKutta4 => 0.35,
        Integrator::ImplicitMidpoint => 1.0,
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
    let axes = turning.nested(|body| body.axes());
    for (k, _) in axes.filter(|(_, axis)| !axis.is_angular()) {
        for k in [k, nv + k] {
            a.row_mut(k).fill(0.0);
            a.column_mut(k).fill(0.0);
        }
    }
}
