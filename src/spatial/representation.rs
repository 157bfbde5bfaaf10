//! In which frame a spatial velocity, force or Jacobian is expressed.

/// The three usual representations of the velocity of a frame F in the world W.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Representation {
    /// Origin of F, axes of F (left-trivialised, Pinocchio's `LOCAL`).
    Body,
    /// Origin of F, axes of W (Pinocchio's `LOCAL_WORLD_ALIGNED`): the linear part is ṗ, the velocity of F's origin.
    Mixed,
    /// Origin of W, axes of W (right-trivialised, Pinocchio's `WORLD`).
    Inertial,
}
