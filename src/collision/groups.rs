//! Groups of shapes that may touch.

/// Collision groups of a shape, and the groups that it may touch, as bit masks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Groups {
    /// Groups that the shape is in.
    pub own: u32,
    /// Groups whose shapes it may touch.
    pub mask: u32,
}

impl Default for Groups {
    /// In the first group, may touch all.
    fn default() -> Self {
        Self {
            own: 1,
            mask: u32::MAX,
        }
    }
}

impl Groups {
    /// Whether shapes of these groups touch: each is in a group that the other may touch.
    pub fn may_touch(&self, other: &Self) -> bool {
        self.own & other.mask != 0 && other.own & self.mask != 0
    }
}
