//! Random states, within bounds for each part.

use nalgebra::DVector;
use rand::{Rng, RngExt};

use super::free_body::{BASE_POSE, write_pose, write_velocity};
use super::state::State;
use crate::model::Model;
use crate::model::manifold::{q_range, v_range};
use crate::scalar::from_each;
use crate::spatial::{Motion, Quaternion, Representation, SPATIAL, Transform};

/// Bounds of a random state: `[lower, upper]` of each coordinate, which is uniformly distributed between them. Equal bounds fix a coordinate.
///
/// The bounds of the base have no effect on a robot with a fixed base.
///
/// # Examples
/// ```
/// use dualbody::{State, model::samples, sim::StateBounds};
/// use rand::{SeedableRng, rngs::Xoshiro256PlusPlus};
///
/// let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
/// let bounds = StateBounds { joint_position: [-0.2, 0.2], joint_velocity: [0.0, 0.5], ..StateBounds::default() };
/// let state = State::random_within(&samples::cartpole(), &mut rng, &bounds);
/// assert!(state.q.amax() <= 0.2 && state.v.min() >= 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateBounds {
    /// Position of the base in the world, m; ±1 by default.
    pub base_position: [[f64; 2]; 3],
    /// Roll, pitch and yaw of the base, rad, see [`Quaternion::from_roll_pitch_yaw`]; `None`, the default, is every rotation with
    /// the same probability.
    pub base_roll_pitch_yaw: Option<[[f64; 2]; 3]>,
    /// Velocity of the origin of the base, in axes of the world, m/s; ±1 by default.
    pub base_linear_velocity: [[f64; 2]; 3],
    /// Angular velocity of the base, in axes of the world, rad/s; ±1 by default.
    pub base_angular_velocity: [[f64; 2]; 3],
    /// Position of each joint of one degree of freedom, rad or m, also within its joint limits; by default any position as in
    /// [`Model::random_configuration`].
    pub joint_position: [f64; 2],
    /// Velocity along each degree of freedom of a joint, rad/s or m/s, also within the speed limit of the joint; ±1 by default.
    pub joint_velocity: [f64; 2],
}

impl Default for StateBounds {
    fn default() -> Self {
        let all = [[-1.0, 1.0]; 3];
        Self {
            base_position: all,
            base_roll_pitch_yaw: None,
            base_linear_velocity: all,
            base_angular_velocity: all,
            joint_position: [f64::NEG_INFINITY, f64::INFINITY],
            joint_velocity: [-1.0, 1.0],
        }
    }
}

impl State<f64> {
    /// Draws a random state within bounds. Joints of several degrees of freedom get a random position; mimic joints have no coordinates.
    ///
    /// # Panics
    /// If a lower bound exceeds its upper one or is NaN, or if one of the base or of a velocity is not finite.
    pub fn random_within<R: Rng + ?Sized>(
        model: &Model,
        rng: &mut R,
        bounds: &StateBounds,
    ) -> Self {
        let q = random_configuration(model, rng, bounds.joint_position);
        let v = random_velocity(model, rng, bounds.joint_velocity);
        let mut state = Self {
            q,
            v,
            activation: DVector::zeros(0),
            contact: DVector::zeros(0),
            sleep: DVector::zeros(0),
        };
        if model.has_floating_base() {
            state.place_base(rng, bounds);
        }
        state
    }

    fn place_base<R: Rng + ?Sized>(&mut self, rng: &mut R, bounds: &StateBounds) {
        let mut three = |name: &str, bounds: &[[f64; 2]; 3]| -> [f64; 3] {
            from_each(|k| uniform(rng, name, bounds[k]))
        };
        let position = three("base_position", &bounds.base_position);
        let rotation = match &bounds.base_roll_pitch_yaw {
            Some(bounds) => Quaternion::from_roll_pitch_yaw(three("base_roll_pitch_yaw", bounds)),
            None => Quaternion::from_slice(&self.q.as_slice()[3..7]),
        };
        let linear = three("base_linear_velocity", &bounds.base_linear_velocity);
        let angular = three("base_angular_velocity", &bounds.base_angular_velocity);
        let pose = Transform::new(rotation.to_matrix(), position.into());
        let velocity = Motion::new(linear.into(), angular.into());
        write_pose(&mut self.q.as_mut_slice()[..BASE_POSE], &pose);
        let own = &mut self.v.as_mut_slice()[..SPATIAL];
        write_velocity(own, &pose, &velocity, Representation::Mixed);
    }
}

fn random_configuration<R: Rng + ?Sized>(
    model: &Model,
    rng: &mut R,
    bounds: [f64; 2],
) -> DVector<f64> {
    let mut q = model.random_configuration(rng);
    check("joint_position", bounds);
    if bounds == [f64::NEG_INFINITY, f64::INFINITY] {
        return q;
    }
    for joint in model.joint_parts() {
        let body = model.body(joint.body);
        if body.coupling.is_some() || q_range(body).len() != 1 {
            continue;
        }
        let limits = [joint.limits.lower, joint.limits.upper];
        q[body.q] = between(rng, q[body.q], narrowed(bounds, limits));
    }
    q
}

fn random_velocity<R: Rng + ?Sized>(model: &Model, rng: &mut R, bounds: [f64; 2]) -> DVector<f64> {
    assert!(
        bounds.iter().all(|x| x.is_finite()),
        "joint_velocity of a random state has the bounds {bounds:?}, expected finite ones"
    );
    check("joint_velocity", bounds);
    let mut own = vec![bounds; model.nv()];
    for joint in model.joint_parts() {
        let body = model.body(joint.body);
        let ratio = body.coupling.map_or(1.0, |coupling| coupling.ratio.abs());
        if let Some(limit) = joint.limits.velocity {
            let limit = limit / ratio;
            for bounds in &mut own[v_range(body)] {
                *bounds = narrowed(*bounds, [Some(-limit), Some(limit)]);
            }
        }
    }
    DVector::from_iterator(model.nv(), own.into_iter().map(|b| between(rng, b[0], b)))
}

/// Bounds within limits; those limits that are nearest where there is nothing between.
fn narrowed([lower, upper]: [f64; 2], limits: [Option<f64>; 2]) -> [f64; 2] {
    let [least, largest] = limits;
    let (least, largest) = (
        least.unwrap_or(f64::NEG_INFINITY),
        largest.unwrap_or(f64::INFINITY),
    );
    let within = |x: f64| x.max(least).min(largest);
    [within(lower), within(upper)]
}

/// A number between bounds; where one is infinite the given number, moved into the other.
fn between<R: Rng + ?Sized>(rng: &mut R, given: f64, [lower, upper]: [f64; 2]) -> f64 {
    if lower >= upper {
        return lower;
    }
    match lower.is_finite() && upper.is_finite() {
        true => rng.random_range(lower..upper),
        false => given.max(lower).min(upper),
    }
}

fn uniform<R: Rng + ?Sized>(rng: &mut R, name: &str, bounds: [f64; 2]) -> f64 {
    check(name, bounds);
    assert!(
        bounds.iter().all(|x| x.is_finite()),
        "{name} of a random state has the bounds {bounds:?}, expected finite ones"
    );
    between(rng, bounds[0], bounds)
}

fn check(name: &str, [lower, upper]: [f64; 2]) {
    assert!(
        lower <= upper,
        "{name} of a random state has the lower bound {lower} above the upper bound {upper}"
    );
}
