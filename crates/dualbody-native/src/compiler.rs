//! The system's C compiler, and the folder in which compiled code is kept.

use std::env::consts::DLL_SUFFIX;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, fs, io, process};

use dualbody::codegen::Source;

use crate::error::NativeError;

/// A C compiler with its flags, and the folder for what it compiles.
///
/// The default is the one that the variable `CC` names, or `cc`, with optimisation for this very machine (`-O2 -march=native`), and the folder
/// `dualbody-native` among the user's caches. It takes flags as GCC and Clang do.
///
/// What was compiled is found again by the text, the compiler, its flags and the machine that it compiles for (all that it predefines), so that
/// nothing is compiled twice and no file serves another machine. Nothing is ever removed from the folder: delete it when it grows too large.
#[derive(Clone, Debug)]
pub struct Compiler {
    command: Vec<String>,
    flags: Vec<String>,
    cache: Option<PathBuf>,
}

impl Default for Compiler {
    fn default() -> Self {
        let command = env::var("CC").ok().filter(|cc| !cc.trim().is_empty());
        Self::new(command.as_deref().unwrap_or("cc"))
    }
}

impl Compiler {
    /// Names a compiler, with words that come before its flags if there are any ("ccache gcc").
    ///
    /// # Panics
    /// If the command is empty.
    pub fn new(command: &str) -> Self {
        let command: Vec<_> = command.split_whitespace().map(str::to_owned).collect();
        assert!(!command.is_empty(), "the command of a compiler is empty");
        let for_this_machine = match env::consts::ARCH {
            "x86_64" | "x86" => Some("-march=native"),
            "aarch64" => Some("-mcpu=native"),
            _ => None,
        };
        let flags = ["-O2"].into_iter().chain(for_this_machine);
        Self {
            command,
            flags: flags.map(str::to_owned).collect(),
            cache: None,
        }
    }

    /// Replaces the flags for optimisation; those of the language and of shared libraries come by themselves.
    #[must_use]
    pub fn with_flags(mut self, flags: &[&str]) -> Self {
        self.flags = flags.iter().map(|&flag| flag.to_owned()).collect();
        self
    }

    /// Keeps compiled code in this folder, which is made when it is needed. Whoever may write to it may change what the program does.
    #[must_use]
    pub fn with_cache(mut self, folder: impl Into<PathBuf>) -> Self {
        self.cache = Some(folder.into());
        self
    }

    /// The file of a compiled source; compiles it unless it is there.
    pub(crate) fn compile(&self, source: &Source) -> Result<PathBuf, NativeError> {
        let machine = self.machine()?;
        let parts = [source.header(), source.source(), &machine];
        let words = self.command.iter().chain(&self.flags).map(String::as_str);
        let key = fingerprint(parts.into_iter().chain(words));
        let (cache, name) = (self.cache()?, source.name());
        let folder = cache.join(format!("{name}-{key:032x}"));
        let file = folder.join(format!("{name}{DLL_SUFFIX}"));
        if file.is_file() {
            return Ok(file);
        }
        make_private(&cache).map_err(at(&cache))?;
        let own = unfinished(&folder);
        fs::create_dir_all(&own).map_err(at(&own))?;
        let moved = self
            .build(source, &own)
            .and_then(|()| finish(&own, &folder));
        if moved.is_err() {
            // What is left there is of no use to anybody.
            let _ = fs::remove_dir_all(&own);
        }
        moved.map(|()| file)
    }

    /// Removes what was compiled, and cannot be loaded.
    pub(crate) fn forget(file: &Path) {
        if let Some(folder) = file.parent() {
            let _ = fs::remove_dir_all(folder);
        }
    }

    /// All that the compiler predefines with these flags: its version, and what the machine can do.
    fn machine(&self) -> Result<String, NativeError> {
        let output = self.run(&["-dM", "-E", "-x", "c", "-"], Path::new("."))?;
        self.check("its flags", &output)?;
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    fn build(&self, source: &Source, folder: &Path) -> Result<(), NativeError> {
        source.save(folder).map_err(at(folder))?;
        let (text, file) = (
            format!("{}.c", source.name()),
            format!("{}{DLL_SUFFIX}", source.name()),
        );
        let flags = ["-std=c99", "-fPIC", "-shared", "-o", &file, &text, "-lm"];
        let output = self.run(&flags, folder)?;
        self.check(&text, &output)
    }

    fn run(&self, flags: &[&str], folder: &Path) -> Result<Output, NativeError> {
        let mut command = Command::new(&self.command[0]);
        command
            .args(&self.command[1..])
            .args(&self.flags)
            .args(flags);
        command.current_dir(folder).stdin(Stdio::null());
        command.output().map_err(|reason| NativeError::NoCompiler {
            command: self.command.join(" "),
            reason,
        })
    }

    fn check(&self, what: &str, output: &Output) -> Result<(), NativeError> {
        if output.status.success() {
            return Ok(());
        }
        Err(NativeError::Refused {
            command: [&self.command[..], &self.flags].concat().join(" "),
            what: what.to_owned(),
            log: String::from_utf8_lossy(&output.stderr).trim().to_owned(),
        })
    }

    fn cache(&self) -> Result<PathBuf, NativeError> {
        let set = |name: &str| {
            env::var_os(name)
                .filter(|path| !path.is_empty())
                .map(PathBuf::from)
        };
        let own = self.cache.clone();
        let of_user = || set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache")));
        own.or_else(|| Some(of_user()?.join("dualbody-native")))
            .ok_or(NativeError::NoCache)
    }
}

/// Adds the path to an error of the system.
fn at(path: &Path) -> impl FnOnce(io::Error) -> NativeError {
    let path = path.to_owned();
    |reason| NativeError::File { path, reason }
}

/// Makes a folder that only its owner may write to, if it is not there.
fn make_private(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

/// Folder beside the final one, of this call alone.
fn unfinished(folder: &Path) -> PathBuf {
    static CALLS: AtomicUsize = AtomicUsize::new(0);
    let call = CALLS.fetch_add(1, Ordering::Relaxed);
    folder.with_extension(format!("{}-{call}", process::id()))
}

/// Gives a folder its final name, unless another program was there first.
fn finish(own: &Path, folder: &Path) -> Result<(), NativeError> {
    match fs::rename(own, folder) {
        Err(_) if folder.is_dir() => fs::remove_dir_all(own).map_err(at(own)),
        renamed => renamed.map_err(at(folder)),
    }
}

/// The hash FNV-1a with 128 bits of texts, each with its length.
///
/// # References
/// G. Fowler, L. C. Noll, K.-P. Vo, D. Eastlake: The FNV Non-Cryptographic Hash Algorithm, RFC 9923, 2025.
fn fingerprint<'a>(texts: impl Iterator<Item = &'a str>) -> u128 {
    const BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    let mut hash = BASIS;
    for text in texts {
        let length = (text.len() as u64).to_le_bytes();
        for byte in length.iter().chain(text.as_bytes()) {
            hash = (hash ^ u128::from(*byte)).wrapping_mul(PRIME);
        }
    }
    hash
}
