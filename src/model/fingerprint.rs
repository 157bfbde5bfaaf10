//! Fingerprint of a robot.

use super::Model;
use crate::scalar::Scalar;

/// Start and factor of the hash of Fowler, Noll and Vo, FNV-1a, for 64 bits.
pub(crate) const START: u64 = 0xcbf2_9ce4_8422_2325;
pub(crate) const FACTOR: u64 = 0x0100_0000_01b3;

impl<P: Scalar> Model<P> {
    /// Returns a hash of the robot: equal each time the robot is loaded, and with high probability different for another robot or after a change of a
    /// parameter, a name or the tree. Use it as a key for cached data of a robot.
    ///
    /// Values that are [not known yet](Scalar::has_value) are ignored.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::samples;
    ///
    /// let model = samples::cartpole();
    /// assert_eq!(model.fingerprint(), samples::cartpole().fingerprint());
    /// assert_ne!(model.fingerprint(), model.with_damping(1, 0.5).fingerprint());
    /// ```
    pub fn fingerprint(&self) -> u64 {
        let mut hash = Hash(START);
        hash.add(self.name().as_bytes());
        for joint in self.joints() {
            hash.add(joint.name.as_bytes());
        }
        for body in self.bodies() {
            let parent = body.parent.map_or(u64::MAX, |parent| parent.0 as u64);
            hash.add(&parent.to_le_bytes());
            let follows = body.coupling.is_some();
            hash.add(format!("{:?} {follows}", body.joint).as_bytes());
        }
        self.map(&mut |x| {
            for lane in (0..P::LANES).filter(|_| x.has_value()) {
                hash.add(&x.value(lane).to_le_bytes());
            }
            x
        });
        hash.0
    }
}

struct Hash(u64);

impl Hash {
    fn add(&mut self, bytes: &[u8]) {
        // Where one piece ends is part of it.
        for byte in bytes.iter().chain(&bytes.len().to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(FACTOR);
        }
    }
}
