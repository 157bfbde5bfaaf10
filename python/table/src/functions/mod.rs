//! The table: a macro for each area, which hands its entries to another macro, which makes something of them.

mod base;
mod dynamics;
mod frames;
mod momenta;
mod simulation;

use crate::prelude::*;
use crate::{Dual, Function};

/// Functions of a model or of a simulator on duals.
macro_rules! on_duals {
    ($of:ident: $Of:ident; $($(#[$doc:meta])* $name:ident $([$mark:ident])? ($($arguments:tt)*) -> $tail:expr, $one:expr;)*) => {
        &[$(crate::function!($of: $Of, Dual; $name ($($arguments)*) -> $tail, $one)),*]
    };
}

/// All functions of the table on duals.
pub(crate) static ON_DUALS: &[&[Function<Dual>]] = &[
    crate::dynamics_functions!(on_duals),
    crate::frame_functions!(on_duals),
    crate::momentum_functions!(on_duals),
    crate::base_functions!(on_duals),
    crate::simulator_functions!(on_duals),
];
