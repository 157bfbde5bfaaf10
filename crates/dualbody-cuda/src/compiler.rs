//! NVRTC, and the folder in which compiled kernels are kept.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{fs, iter, thread};

use dualbody::StopSignal;
use dualbody::codegen::{CudaKernel, CudaSource};
use dualbody_cache::{Cache, FileError};
use sha2::{Digest, Sha256};

use crate::architecture::Architecture;
use crate::error::{CudaError, searched};
use crate::nvrtc::{self, Program};

/// NVRTC with its flags, and the folder of compiled kernels, by default `dualbody-cuda` in the user's cache folder.
///
/// It compiles to machine code of one architecture, which the driver loads without further compilation. It needs no GPU. Compiled code is identified by
/// the text, the version of NVRTC, the architecture and the flags. A damaged file is compiled again. No file is removed: delete the folder if it is too
/// large.
///
/// NVRTC runs in the process of the program and cannot be interrupted: a [watched](StopSignal::watch) [`StopSignal`] takes effect before the next
/// kernel, which for a humanoid may be minutes later. The end of the program ends NVRTC.
#[derive(Clone, Debug, Default)]
pub struct Compiler {
    flags: Vec<String>,
    cache: Option<Cache>,
    precompiled: Option<Cache>,
}

/// A kernel in machine code.
#[derive(Clone, Debug)]
pub struct Compiled {
    image: Vec<u8>,
    log: Option<String>,
}

impl Compiled {
    /// The machine code, an ELF file.
    pub fn image(&self) -> &[u8] {
        &self.image
    }

    /// Messages of the compiler, with registers and spilled bytes; `None` if the kernel was compiled before.
    pub fn log(&self) -> Option<&str> {
        self.log.as_deref()
    }
}

impl Compiler {
    /// The compiler without flags.
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces the flags, except that of the architecture. With `--use_fast_math` a number that is not finite may be missed.
    #[must_use]
    pub fn with_flags(mut self, flags: &[&str]) -> Self {
        self.flags = flags.iter().map(|&flag| flag.to_owned()).collect();
        self
    }

    /// Stores compiled kernels in this folder, which is created if necessary. Anyone with write access to it can change the code that runs on the GPU.
    #[must_use]
    pub fn with_cache(mut self, folder: impl Into<PathBuf>) -> Self {
        self.cache = Some(Cache::new(folder));
        self
    }

    /// Looks for kernels in this folder first, which [`precompile`](Self::precompile) has filled, for any version of NVRTC. If it contains all kernels,
    /// NVRTC is not needed. Anyone with write access to it can change the code that runs on the GPU.
    #[must_use]
    pub fn with_precompiled(mut self, folder: impl Into<PathBuf>) -> Self {
        self.precompiled = Some(Cache::new(folder));
        self
    }

    /// Compiles all kernels of a function, or finds them compiled, and stores them in a folder for programs on machines without NVRTC.
    ///
    /// Programs find them by [`with_precompiled`](Self::with_precompiled) if text and flags are the same. Machine code runs on GPUs of the same major
    /// architecture with the same or a later minor version: code of `sm_80` also runs on `sm_86`.
    ///
    /// # Errors
    /// As [`compile_all`](Self::compile_all).
    pub fn precompile(
        &self,
        source: &CudaSource,
        architecture: Architecture,
        folder: impl Into<PathBuf>,
    ) -> Result<Vec<Compiled>, CudaError> {
        let (all, folder) = (self.compile_all(source, architecture)?, Cache::new(folder));
        for (kernel, compiled) in source.kernels.iter().zip(&all) {
            let file = file(&folder, kernel, &self.all_flags(architecture), None);
            folder.keep(&file, |own| write(own, &compiled.image))?;
        }
        Ok(all)
    }

    /// Compiles a kernel, or finds it compiled.
    ///
    /// # Errors
    /// If NVRTC is missing or refuses the text or the flags, or if the file cannot be stored; if a [`StopSignal`] is already set and the kernel would
    /// have to be compiled.
    pub fn compile(
        &self,
        kernel: &CudaKernel,
        architecture: Architecture,
    ) -> Result<Compiled, CudaError> {
        self.compile_unless_stopped(kernel, architecture, &StopSignal::watched())
    }

    fn compile_unless_stopped(
        &self,
        kernel: &CudaKernel,
        architecture: Architecture,
        signals: &[StopSignal],
    ) -> Result<Compiled, CudaError> {
        if let Some(image) = self.found(kernel, architecture) {
            return Ok(Compiled { image, log: None });
        }
        if !nvrtc::has_nvrtc() {
            return Err(CudaError::NoNvrtc {
                searched: searched(&["nvrtc"]),
            });
        }
        let flags = self.all_flags(architecture);
        let refused = |reason, log| CudaError::Refused {
            kernel: kernel.name().to_owned(),
            flags: flags.clone(),
            reason,
            log,
        };
        let version = nvrtc::nvrtc_version().map_err(|error| refused(error, String::new()))?;
        let cache = Cache::or_of_user(self.cache.as_ref(), "dualbody-cuda");
        let cache = cache.ok_or(CudaError::NoCache)?;
        let file = file(&cache, kernel, &flags, Some(&version));
        if let Some(image) = read(&file) {
            return Ok(Compiled { image, log: None });
        }
        if signals.iter().any(StopSignal::is_set) {
            return Err(CudaError::Stopped {
                kernel: kernel.name().to_owned(),
            });
        }
        let program = Program::new(kernel.text()).map_err(|error| refused(error, String::new()))?;
        let compiled = program.compile(&flags).and_then(|()| program.image());
        let image = compiled.map_err(|error| refused(error, program.log()))?;
        cache.keep(&file, |own| write(own, &image))?;
        Ok(Compiled {
            image,
            log: Some(program.log()),
        })
    }

    /// Compiles all kernels of a function, or finds them compiled, in parallel on all cores.
    ///
    /// # Errors
    /// As [`compile`](Self::compile), for the first kernel that fails.
    pub fn compile_all(
        &self,
        source: &CudaSource,
        architecture: Architecture,
    ) -> Result<Vec<Compiled>, CudaError> {
        let (kernels, next) = (&source.kernels, AtomicUsize::new(0));
        let signals = StopSignal::watched();
        // Each thread takes the next free kernel.
        let work = || {
            let taken = iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
            let taken = taken.map_while(|k| Some((k, kernels.get(k)?)));
            let compiled = taken.map(|(k, kernel)| {
                (
                    k,
                    self.compile_unless_stopped(kernel, architecture, &signals),
                )
            });
            compiled.collect::<Vec<_>>()
        };
        let cores = thread::available_parallelism().map_or(1, NonZero::get);
        let mut all = thread::scope(|scope| {
            let threads: Vec<_> = (1..cores.min(kernels.len()))
                .map(|_| scope.spawn(work))
                .collect();
            let own = work();
            let others = threads.into_iter().flat_map(joined);
            own.into_iter().chain(others).collect::<Vec<_>>()
        });
        all.sort_by_key(|(k, _)| *k);
        all.into_iter().map(|(_, compiled)| compiled).collect()
    }

    /// The machine code of a kernel that was compiled on another machine, for this architecture or an earlier one of the same kind.
    fn found(&self, kernel: &CudaKernel, architecture: Architecture) -> Option<Vec<u8>> {
        let folder = self.precompiled.as_ref()?;
        let mut all = architecture.and_earlier();
        all.find_map(|earlier| read(&file(folder, kernel, &self.all_flags(earlier), None)))
    }

    fn all_flags(&self, architecture: Architecture) -> Vec<String> {
        let own = [
            format!("--gpu-architecture={architecture}"),
            "--ptxas-options=-v".to_owned(),
        ];
        own.into_iter().chain(self.flags.iter().cloned()).collect()
    }
}

/// The result of a thread; a panic in it continues here.
fn joined<T>(thread: thread::ScopedJoinHandle<'_, T>) -> T {
    thread
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// The file of a kernel: its name, and a hash of its sources.
fn file(folder: &Cache, kernel: &CudaKernel, flags: &[String], version: Option<&str>) -> PathBuf {
    let texts = [Some(kernel.text()), version].into_iter().flatten();
    let texts = texts.chain(flags.iter().map(String::as_str));
    folder.path(kernel.name(), texts).with_extension("cubin")
}

/// The machine code in a file, which begins with its hash; `None` if it is not there, or damaged.
fn read(file: &Path) -> Option<Vec<u8>> {
    let bytes = fs::read(file).ok()?;
    let (hash, image) = bytes.split_at_checked(Sha256::output_size())?;
    (hash == Sha256::digest(image).as_slice()).then(|| image.to_vec())
}

/// Writes machine code behind its hash.
fn write(file: &Path, image: &[u8]) -> Result<(), FileError> {
    let content = [Sha256::digest(image).as_slice(), image].concat();
    fs::write(file, content).map_err(FileError::at(file))
}
