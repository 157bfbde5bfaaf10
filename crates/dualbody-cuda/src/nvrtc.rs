//! Calls of NVRTC, which Rust cannot check.

#![expect(
    unsafe_code,
    reason = "foreign functions can be called in no other way"
)]

use std::ffi::{CStr, CString, c_char};

use cudarc::nvrtc::{result, sys};

/// Whether there is an NVRTC.
pub(crate) fn has_nvrtc() -> bool {
    // SAFETY: loads a library of the system by its name, whose start code is NVRTC's own.
    unsafe { sys::is_culib_present() }
}

/// Version of NVRTC, which must be there.
pub(crate) fn nvrtc_version() -> Result<String, String> {
    let (mut major, mut minor) = (0, 0);
    // SAFETY: writes to two numbers, which live.
    let result = unsafe { sys::nvrtcVersion(&raw mut major, &raw mut minor) };
    checked(result)?;
    Ok(format!("{major}.{minor}"))
}

/// A text in NVRTC.
pub(crate) struct Program(sys::nvrtcProgram);

impl Program {
    /// Passes a text to NVRTC, which must be there.
    pub(crate) fn new(text: &str) -> Result<Self, String> {
        let text = CString::new(text).map_err(|_| "a zero in the text".to_owned())?;
        let program = result::create_program(&text, None);
        Ok(Self(program.map_err(|error| error.to_string())?))
    }

    /// Compiles it, for the architecture in the flags.
    pub(crate) fn compile(&self, flags: &[String]) -> Result<(), String> {
        // SAFETY: the program is one that NVRTC has made, and lives until it is dropped.
        let compiled = unsafe { result::compile_program(self.0, flags) };
        compiled.map_err(|error| error.to_string())
    }

    /// Messages of the compiler.
    pub(crate) fn log(&self) -> String {
        // SAFETY: as in `compile`.
        let log = unsafe { result::get_program_log(self.0) }.unwrap_or_default();
        let bytes: Vec<u8> = log.into_iter().map(|c| c.cast_unsigned()).collect();
        let text = CStr::from_bytes_until_nul(&bytes).unwrap_or_default();
        text.to_string_lossy().trim().to_owned()
    }

    /// The machine code.
    pub(crate) fn image(&self) -> Result<Vec<u8>, String> {
        let mut size = 0;
        // SAFETY: as in `compile`; writes to a number, which lives.
        checked(unsafe { sys::nvrtcGetCUBINSize(self.0, &raw mut size) })?;
        let mut image = vec![0_u8; size];
        // SAFETY: as in `compile`; writes as many bytes as it has just returned, and there are as many.
        checked(unsafe { sys::nvrtcGetCUBIN(self.0, image.as_mut_ptr().cast::<c_char>()) })?;
        Ok(image)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // SAFETY: the program is one that NVRTC has made, and is not used any more. There is nothing to do if that fails.
        let _ = unsafe { result::destroy_program(self.0) };
    }
}

fn checked(result: sys::nvrtcResult) -> Result<(), String> {
    result.result().map_err(|error| error.to_string())
}
