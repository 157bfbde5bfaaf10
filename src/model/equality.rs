//! Equality of robots.

use super::Model;

/// Two robots are equal if all their parts and parameters are equal: names, joints, bodies, frames, links with their shapes, gravity. Source file and
/// edit history are ignored.
impl PartialEq for Model {
    fn eq(&self, other: &Self) -> bool {
        (&self.name, self.gravity, &self.bodies, &self.frames)
            == (&other.name, other.gravity, &other.bodies, &other.frames)
            && (&self.damping, &self.armature, &self.springs)
                == (&other.damping, &other.armature, &other.springs)
            && (&self.joints, &self.links) == (&other.joints, &other.links)
    }
}

#[cfg(test)]
mod tests {
    use crate::model::samples;

    #[test]
    fn robots_are_equal_by_content() {
        let (one, other) = (samples::arm(), samples::arm());
        assert_eq!(one, other);
        assert_eq!(one, one.with_parameters(one.parameters().as_slice()));
        assert_eq!(one.clone().with_damping(2, 0.5), other.with_damping(2, 0.5));
    }

    #[test]
    fn one_number_or_name_makes_another_robot() {
        let one = samples::cartpole();
        assert_ne!(one, one.clone().with_damping(0, 0.25));
        assert_ne!(one, one.clone().with_gravity([0.0, 0.0, -1.62].into()));
        assert_ne!(one, one.with_link_mass("pole", 0.125).unwrap());
        assert_ne!(one, samples::pendulum());
    }
}
