//! The C compiler of generated code.

use std::path::PathBuf;

use dualbody_native::Compiler;

use crate::prelude::*;

/// A compiler from its description in Python; the default one if there is none.
pub(crate) fn compiler_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<Compiler> {
    let Some(given) = given else {
        return Ok(Compiler::default());
    };
    let command: Option<String> = attribute(given, "command")?;
    let flags: Option<Vec<String>> = attribute(given, "flags")?;
    let cache: Option<PathBuf> = attribute(given, "cache")?;
    let mut compiler = match command {
        Some(command) => guarded(|| Compiler::new(&command))?,
        None => Compiler::default(),
    };
    if let Some(flags) = flags {
        let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
        compiler = compiler.with_flags(&flags);
    }
    Ok(match cache {
        Some(cache) => compiler.with_cache(cache),
        None => compiler,
    })
}
