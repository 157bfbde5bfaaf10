//! Rules of all episodes.

/// When an episode begins after the end of another one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AutoReset {
    /// In the step after the end, whose action has no effect and whose reward is zero.
    #[default]
    NextStep,
    /// In the step of the end: its last observation is in [`Transitions::final_observations`](super::Transitions::final_observations).
    SameStep,
    /// By [`Environments::reset_where`](super::Environments::reset_where) only.
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
