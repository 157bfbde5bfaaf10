//! Random states within bounds, and joint forces by name.

use dualbody::dynamics::{NamedForces, joint_forces};
use dualbody::sim::StateBounds;
use rand::SeedableRng;

use crate::prelude::*;

type Three = [[f64; 2]; 3];

functions! {
    /// A random (q, v) within bounds: position, roll-pitch-yaw, linear and angular velocity of the base, position and velocity of joints.
    fn _random_state(
        py: Python, model: &Bound<'py, PyModel>, seed: u64, bounds: (Three, Option<Three>, Three, Three, [f64; 2], [f64; 2])
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let bounds = StateBounds {
            base_position: bounds.0,
            base_roll_pitch_yaw: bounds.1,
            base_linear_velocity: bounds.2,
            base_angular_velocity: bounds.3,
            joint_position: bounds.4,
            joint_velocity: bounds.5,
        };
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let state = guarded(|| State::random_within(&model.get().model, &mut rng, &bounds))?;
        let array = |x: &DVector<f64>| vector(py, x.as_slice());
        Ok((array(&state.q), array(&state.v)))
    }

    /// Joint forces tau of unit forces along the degrees of freedom of a joint, a row for each, (dof, nv).
    fn _unit_joint_forces(py: Python, model: &Bound<'py, PyModel>, joint: &str) -> PyResult<Array<'py>> {
        let m = &*model.get().model;
        let count = m.joint_v(m.find_joint(joint).or_raise()?).len();
        let mut out = DMatrix::zeros(count, m.nv());
        for k in 0..count {
            let mut unit = vec![0.0; count];
            unit[k] = 1.0;
            let mut forces = NamedForces::default();
            forces.set_joint_forces(m, &[(joint, &unit)]).or_raise()?;
            out.row_mut(k).copy_from(&joint_forces(m, &forces).transpose());
        }
        Ok(matrix(py, &out))
    }
}
