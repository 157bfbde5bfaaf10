//! The dynamics and the step on numbers that record what is computed.
//!
//! A crate of its own, since recording takes much code and no fast one: it is compiled with few optimisations, beside the extension module, see
//! the profiles in the manifest of that.

use dualbody::scalar::traced::Graph;
use dualbody::{Model, Simulator, codegen};
use dualbody_native::{Compiler, NativeError, NativeSimulator};

/// Traces [`codegen::inverse_dynamics`].
#[inline(never)]
pub fn inverse_dynamics(model: &Model) -> Graph {
    codegen::inverse_dynamics(model)
}

/// Traces [`codegen::forward_dynamics`].
#[inline(never)]
pub fn forward_dynamics(model: &Model) -> Graph {
    codegen::forward_dynamics(model)
}

/// Traces [`codegen::mass_matrix`].
#[inline(never)]
pub fn mass_matrix(model: &Model) -> Graph {
    codegen::mass_matrix(model)
}

/// Traces [`codegen::inverse_dynamics_derivatives`].
#[inline(never)]
pub fn inverse_dynamics_derivatives(model: &Model) -> Graph {
    codegen::inverse_dynamics_derivatives(model)
}

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
