//! Activation margin: the height above the ground up to which points take part in a step.

use super::point_state::PointState;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::dot;

/// Acceleration towards the ground that a point may gain within a step and still be noticed, m/s².
const LARGEST_APPROACH: f64 = 1e3;

/// Height above the ground up to which points take part in a step:  max(duration · (closing velocity + approach), reach). Derivatives are ignored.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ActivationMargin<D = f64> {
    /// Time in which a point may come down, s.
    pub(crate) duration: D,
    /// Velocity towards the ground that a point may gain until then, m/s.
    pub(crate) approach: D,
    /// Height up to which it takes part in any case, m.
    pub(crate) reach: f64,
}

impl<D: Scalar> ActivationMargin<D> {
    /// The surface itself: no height above the ground.
    pub(crate) fn surface() -> Self {
        Self {
            duration: D::zero(),
            approach: D::zero(),
            reach: 0.0,
        }
    }

    /// The way that points could come down within a step of `dt` (s), also under the forces of others.
    pub(crate) fn over_step(dt: D) -> Self {
        Self {
            duration: dt,
            approach: dt * LARGEST_APPROACH,
            reach: 0.0,
        }
    }

    /// Contribution of one shape to the height of a pair, by its maximum speed, m/s, on plain values: the sum of both is an upper bound of the height.
    pub(crate) fn half_height(&self, speed: D) -> f64 {
        let approach = 0.5 * self.approach.value(0);
        let way = (speed.value(0) + approach) * self.duration.value(0);
        way.max(0.5 * self.reach)
    }

    /// Distance of a point below the margin, m, in each lane and without derivatives; negative above it.
    pub(crate) fn distance_inside<T: Over<D>>(&self, point: &PointState<T>) -> T {
        let closing = (-dot(&point.normal, &point.velocity)).detached();
        let height = (closing.max(T::zero()) + self.approach.detached()) * self.duration.detached();
        point.depth.detached() + height.max(T::constant(self.reach))
    }

    /// Whether a point takes part in some lane; also true for a point whose position is not known yet.
    pub(crate) fn contains<T: Over<D>>(&self, point: &PointState<T>) -> bool {
        let inside = self.distance_inside(point);
        !inside.has_value() || (0..T::LANES).any(|lane| inside.value(lane) > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// A point at a height (m) over a plane that tilts by 30° about y, with a velocity along its normal (m/s) and 7 m/s across.
    fn point(height: f64, velocity: f64) -> PointState<f64> {
        let normal = Vector3::new(0.5, 0.0, 0.75_f64.sqrt());
        PointState {
            depth: -height,
            normal,
            velocity: normal * velocity + Vector3::y() * 7.0,
            ..PointState::zero()
        }
    }

    // 10 ms at 2 m/s are 20 mm, at 2 + 1 m/s they are 30 mm; what leaves counts as at rest.
    #[test]
    fn margin_is_the_way_that_a_point_may_come_down() {
        let margin = ActivationMargin {
            duration: 0.01,
            approach: 1.0,
            reach: 0.0,
        };
        for (height, velocity, inside) in [
            (0.025, -2.0, 0.005),
            (0.035, -2.0, -0.005),
            (0.005, 2.0, 0.005),
            (-0.004, 0.0, 0.014),
        ] {
            let point = point(height, velocity);
            let found = margin.distance_inside(&point);
            assert!(
                (found - inside).abs() < 1e-15,
                "{height} {velocity}: {found}"
            );
            assert_eq!(margin.contains(&point), inside > 0.0);
        }
    }

    #[test]
    fn margin_is_at_least_its_reach_and_by_default_the_surface() {
        let reach = ActivationMargin::<f64> {
            reach: 0.1,
            ..ActivationMargin::surface()
        };
        assert!((reach.distance_inside(&point(0.06, -50.0)) - 0.04).abs() < 1e-15);
        let none = ActivationMargin::<f64>::surface();
        assert_eq!(none.distance_inside(&point(0.0, -50.0)), 0.0);
        assert!(!none.contains(&point(0.0, -50.0)) && none.contains(&point(-1e-12, 50.0)));
    }

    // A point that takes part in one lane takes part.
    #[test]
    fn points_are_inside_lane_by_lane() {
        use crate::scalar::Lanes;
        let lanes = PointState {
            depth: Lanes([-0.01, 0.02]),
            ..PointState::<Lanes<2>>::zero()
        };
        let none = ActivationMargin::<f64>::surface();
        assert_eq!(none.distance_inside(&lanes).0, [-0.01, 0.02]);
        assert!(none.contains(&lanes));
    }
}
