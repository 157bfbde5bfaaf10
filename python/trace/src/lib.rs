//! The dynamics and the step on numbers that record what is computed.
//!
//! A crate of its own, since recording takes much code and no fast one: it is compiled with few optimisations, beside the extension module, see
//! the profiles in the manifest of that.

use dualbody::scalar::traced::Graph;
use dualbody::{Model, Simulator, codegen};
use dualbody_native::{Compiler, NativeError, NativeSimulator};

macro_rules! of_models {
    ($($name:ident),*) => {
        /// Functions of a model by name: each traces that of its name of [`codegen`].
        pub static OF_MODELS: &[(&str, fn(&Model) -> Graph)] = &[$((stringify!($name), |model| codegen::$name(model))),*];
    };
}
of_models!(
    inverse_dynamics,
    forward_dynamics,
    mass_matrix,
    inverse_dynamics_derivatives
);

/// Traces [`codegen::step`].
#[inline(never)]
pub fn step(simulator: &Simulator) -> Graph {
    codegen::step(simulator)
}

/// Traces and compiles a step: [`NativeSimulator::new`].
///
/// # Errors
/// As there.
#[inline(never)]
pub fn native(simulator: Simulator, compiler: &Compiler) -> Result<NativeSimulator, NativeError> {
    NativeSimulator::new(simulator, compiler)
}

/// [`native`], or the library's own code: [`NativeSimulator::or_own`].
#[inline(never)]
pub fn native_or_own(simulator: Simulator, compiler: &Compiler) -> NativeSimulator {
    NativeSimulator::or_own(simulator, compiler)
}
