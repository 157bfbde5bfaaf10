//! Errors that need no GPU.

use std::fs;
use std::path::PathBuf;

use dualbody::StopSignal;
use dualbody::codegen::{CudaKernel, Precision};
use dualbody::model::samples;
use dualbody_cuda::{Architecture, Compiler, CudaError, Device, graphs};

/// A folder of one test, which goes with it.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new(test: &str) -> Self {
        let name = format!("dualbody-cuda-{}-{test}", std::process::id());
        let path = std::env::temp_dir().join(name);
        let _ = fs::remove_dir_all(&path);
        Self(path)
    }

    pub(crate) fn compiler(&self) -> Compiler {
        Compiler::new().with_cache(&self.0)
    }

    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let all = fs::read_dir(&self.0).expect("the folder");
        all.map(|entry| entry.expect("an entry").path()).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub(crate) fn source() -> CudaKernel {
    let graph = graphs::inverse_dynamics(&samples::pendulum());
    let source = graph
        .to_cuda("pendulum", Precision::Double, &[])
        .expect("a name");
    source.kernels[0].clone()
}

pub(crate) const HOPPER: (u32, u32) = (9, 0);

/// NVRTC; prints a line if it is missing.
pub(crate) fn has_nvrtc(folder: &Folder) -> bool {
    match folder
        .compiler()
        .compile(&source(), Architecture::new(HOPPER.0, HOPPER.1))
    {
        Err(CudaError::NoNvrtc { .. }) => {
            eprintln!("not tested: there is no NVRTC (crates/dualbody-cuda/nvrtc.sh installs it)");
            false
        }
        found => {
            found.expect("a kernel that NVRTC takes");
            true
        }
    }
}

#[test]
fn without_a_driver_the_error_says_what_was_looked_for() {
    match Device::new(0) {
        Err(CudaError::NoDriver { searched }) => {
            assert!(
                searched.iter().any(|name| name.contains("cuda")),
                "{searched:?}"
            );
            let text = CudaError::NoDriver { searched }.to_string();
            assert!(
                text.contains("no CUDA driver") && text.contains("libcuda.so"),
                "{text}"
            );
        }
        Err(error) => eprintln!("there is a driver, and no device: {error}"),
        Ok(device) => eprintln!("there is a device: {device:?}"),
    }
}

#[test]
fn without_nvrtc_the_error_says_what_was_looked_for() {
    let folder = Folder::new("none");
    match folder
        .compiler()
        .compile(&source(), Architecture::new(HOPPER.0, HOPPER.1))
    {
        Err(error @ CudaError::NoNvrtc { .. }) => {
            let text = error.to_string();
            assert!(
                text.contains("libnvrtc") && text.contains("nvidia-cuda-nvrtc-cu12"),
                "{text}"
            );
        }
        found => assert!(!found.expect("a kernel").image().is_empty()),
    }
}

#[test]
fn kernels_are_kept_and_found_again() {
    let folder = Folder::new("cache");
    if !has_nvrtc(&folder) {
        return;
    }
    let hopper = Architecture::new(HOPPER.0, HOPPER.1);
    assert_eq!(folder.files().len(), 1);
    let again = folder
        .compiler()
        .compile(&source(), hopper)
        .expect("a kernel");
    assert_eq!((again.log(), folder.files().len()), (None, 1));
    folder
        .compiler()
        .compile(&source(), Architecture::new(8, 0))
        .expect("a kernel");
    assert_eq!(folder.files().len(), 2);
    let flags = folder.compiler().with_flags(&["--fmad=false"]);
    assert!(
        flags
            .compile(&source(), hopper)
            .expect("a kernel")
            .log()
            .is_some()
    );
    assert_eq!(folder.files().len(), 3);
    // A file that was damaged is compiled once more.
    for file in folder.files() {
        let mut bytes = fs::read(&file).expect("a file");
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        fs::write(&file, bytes).expect("a file");
    }
    let mended = folder
        .compiler()
        .compile(&source(), hopper)
        .expect("a kernel");
    assert!(mended.log().is_some() && mended.image() == again.image());
}

#[test]
fn precompiled_kernels_are_found_whatever_compiled_them() {
    let (folder, carried) = (Folder::new("own"), Folder::new("carried"));
    if !has_nvrtc(&folder) {
        return;
    }
    let graph = graphs::inverse_dynamics(&samples::pendulum());
    let source = graph.to_cuda("pendulum", Precision::Double, &[]);
    let source = source.expect("a name");
    let ampere = Architecture::new(8, 0);
    let made = folder
        .compiler()
        .precompile(&source, ampere, &carried.0)
        .expect("a kernel");
    assert_eq!(carried.files().len(), source.kernels.len());
    // A cache that cannot be written: only carried kernels are found.
    let none = carried.files()[0].join("none");
    let there = Compiler::new()
        .with_cache(none)
        .with_precompiled(&carried.0);
    let kernel = &source.kernels[0];
    for minor in [0, 6, 9] {
        let found = there.compile(kernel, Architecture::new(8, minor));
        let found = found.expect("a kernel of an earlier architecture");
        assert_eq!((found.log(), found.image()), (None, made[0].image()));
    }
    for other in [Architecture::new(9, 0), Architecture::new(7, 5)] {
        there.compile(kernel, other).expect_err("not found");
    }
    let flags = there.with_flags(&["--fmad=false"]);
    flags.compile(kernel, ampere).expect_err("other flags");
}

#[test]
fn what_nvrtc_refuses_comes_back_with_its_log() {
    let folder = Folder::new("refused");
    if !has_nvrtc(&folder) {
        return;
    }
    let refused = |compiler: Compiler, architecture| {
        compiler
            .compile(&source(), architecture)
            .expect_err("an error")
            .to_string()
    };
    let hopper = Architecture::new(HOPPER.0, HOPPER.1);
    let text = refused(
        folder.compiler().with_flags(&["-Dunsigned=nothing"]),
        hopper,
    );
    assert!(
        text.contains("pendulum_batch")
            && text.contains("-Dunsigned=nothing")
            && text.contains("undefined"),
        "{text}"
    );
    let text = refused(folder.compiler().with_flags(&["--no-such-flag"]), hopper);
    assert!(text.contains("no-such-flag"), "{text}");
    let text = refused(folder.compiler(), Architecture::new(1, 0));
    assert!(text.contains("sm_10"), "{text}");
    fs::write(folder.0.join("file"), "").expect("a file");
    let text = refused(Compiler::new().with_cache(folder.0.join("file")), hopper);
    assert!(text.contains("file"), "{text}");
}

#[test]
fn a_signal_ends_before_the_next_kernel_that_is_not_compiled() {
    let folder = Folder::new("stopped");
    if !has_nvrtc(&folder) {
        return;
    }
    let (signal, architecture) = (StopSignal::new(), Architecture::new(HOPPER.0, HOPPER.1));
    let graph = graphs::inverse_dynamics(&samples::cartpole());
    let source = graph.to_cuda("cartpole", Precision::Double, &[]);
    let source = source.expect("a name");
    signal.stop();
    let all = signal.watch(|| folder.compiler().compile_all(&source, architecture));
    let error = all.expect_err("an error");
    assert!(matches!(error, CudaError::Stopped { .. }), "{error}");
    // A kernel that was compiled before is found.
    let found = signal.watch(|| folder.compiler().compile(&self::source(), architecture));
    assert!(found.expect("a kernel").log().is_none());
}
