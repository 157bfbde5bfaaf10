//! Rules of all episodes.

/// Time at which a new episode starts after the end of one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AutoReset {
    /// In the step after the end, whose action has no effect and whose reward is zero.
    #[default]
    NextStep,
    /// In the step of the end; the last observation is in [`Transitions::final_observations`](super::Transitions::final_observations).
    SameStep,
    /// Only by [`Environments::reset_where`](super::Environments::reset_where).
    Never,
}

/// Rules of a step, the same for all groups.
pub(super) struct Rules<'a, E> {
    pub(super) environment: &'a E,
    /// Index of the first time step.
    pub(super) step: usize,
    pub(super) decimation: usize,
    pub(super) max_length: usize,
    pub(super) auto_reset: AutoReset,
}
