//! Reasons why code is not compiled or loaded.

use std::io;
use std::path::PathBuf;

use dualbody::codegen::CodeError;
use dualbody_cache::FileError;

/// Error of compilation or loading.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NativeError {
    /// The compiler does not run.
    #[error(
        "the C compiler \"{command}\" does not run ({reason}): name one in the variable CC, or by `Compiler::new`"
    )]
    NoCompiler {
        /// Its command.
        command: String,
        /// Reason of the system.
        reason: io::Error,
    },
    /// The compiler rejects its flags or the text.
    #[error("the C compiler \"{command}\" refuses {what}: {log}")]
    Refused {
        /// Its command with all flags.
        command: String,
        /// The code that it was compiling.
        what: String,
        /// Its messages.
        log: String,
    },
    /// A [`StopSignal`](dualbody::StopSignal) was set: the compiler was stopped, and its files were removed.
    #[error("the C compiler \"{command}\" was stopped")]
    Stopped {
        /// Its command.
        command: String,
    },
    /// The user has no cache folder for compiled code.
    #[error(
        "there is no folder to keep compiled code in, for neither XDG_CACHE_HOME nor HOME is set: choose one by `Compiler::with_cache`"
    )]
    NoCache,
    /// A file or folder cannot be written or read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A compiled file cannot be loaded.
    #[error("{path} cannot be loaded: {reason}", path = .path.display())]
    Load {
        /// The file.
        path: PathBuf,
        /// Reason of the system.
        reason: String,
    },
    /// The graph cannot be written as C.
    #[error(transparent)]
    Code(#[from] CodeError),
}
