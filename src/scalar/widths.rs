//! Vector widths and their reasons.

/// Number of states in a group of a batch: as many as fit into the widest vector registers of possible CPUs.
pub const BATCH_WIDTH: usize = if cfg!(target_arch = "x86_64") { 8 } else { 2 };

/// Number of directions of one evaluation on dual numbers: large enough to share the work on values, small enough to stay in registers.
pub const CHUNK: usize = 4;

/// Numbers that are worked on together: some vectors, without an end that is not full.
pub(crate) const GROUP: usize = 8;

/// Right-hand sides that are solved together: some vectors of the widest kind, because each step waits for the one before it.
pub(crate) const BLOCK: usize = 16;

/// Bodies in a level of a packed tree, one a lane: legs and arms come in twos and fours.
pub(crate) const LEVEL: usize = 4;

/// Columns of a symmetric product that are found together, so that each need not wait for the one before it.
pub(crate) const TILE: usize = 4;

/// Coordinates that a factor eliminates together, the largest first: an arm's are seven, a leg's six or three.
pub(crate) const ELIMINATED: [usize; 3] = [4, 2, 1];

/// Angles whose sines and cosines go through the vector units together.
pub(crate) const ANGLES: usize = 8;

/// Bytes of a cache line, of all CPUs of today or a multiple of theirs.
pub(crate) const CACHE_LINE: usize = 64;
