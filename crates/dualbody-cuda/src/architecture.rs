//! Architectures of machine code.

use std::fmt;

/// An architecture of GPUs, by its compute capability.
///
/// # Examples
/// ```
/// use dualbody_cuda::Architecture;
///
/// assert_eq!(Architecture::new(9, 0).to_string(), "sm_90");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Architecture {
    major: u32,
    minor: u32,
}

impl Architecture {
    /// The architecture of a compute capability.
    pub fn new(major: u32, minor: u32) -> Self {
        Self { major, minor }
    }

    /// This architecture and the earlier ones whose machine code it runs, the latest first.
    pub(crate) fn and_earlier(self) -> impl Iterator<Item = Self> {
        let major = self.major;
        (0..=self.minor)
            .rev()
            .map(move |minor| Self { major, minor })
    }
}

impl fmt::Display for Architecture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sm_{}{}", self.major, self.minor)
    }
}
