//! The system's C compiler, and the folder in which compiled code is kept.

use std::env::consts::DLL_SUFFIX;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::{env, fs};

use dualbody::codegen::Source;
use dualbody_cache::{Cache, FileError};

use crate::error::NativeError;
use crate::process;

/// A C compiler with its flags, and the folder for compiled files.
///
/// The default is the compiler in the variable `CC`, or `cc`, with optimisation for this machine (`-O2 -march=native`), and the folder
/// `dualbody-native` in the user's cache folder. The compiler must accept the flags of GCC and Clang.
///
/// Compiled code is identified by the text, the compiler, its flags and the target machine (all predefined macros), so no function is compiled twice and
/// no file is used on another machine. No file is removed: delete the folder if it is too large.
///
/// A [`StopSignal`](dualbody::StopSignal) ends a compiler that was started within its [`watch`](dualbody::StopSignal::watch), with all its processes,
/// within a tenth of a second. The end of the program, for example by Ctrl-C, ends them as well (on Unix).
#[derive(Clone, Debug)]
pub struct Compiler {
    command: Vec<String>,
    flags: Vec<String>,
    cache: Option<Cache>,
}

impl Default for Compiler {
    fn default() -> Self {
        let command = env::var("CC").ok().filter(|cc| !cc.trim().is_empty());
        Self::new(command.as_deref().unwrap_or("cc"))
    }
}

impl Compiler {
    /// Sets the command of the compiler, which may have several words ("ccache gcc").
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

    /// Replaces the flags for optimisation. Flags of the language and of shared libraries are always added.
    #[must_use]
    pub fn with_flags(mut self, flags: &[&str]) -> Self {
        self.flags = flags.iter().map(|&flag| flag.to_owned()).collect();
        self
    }

    /// Stores compiled code in this folder, which is created if necessary. Anyone with write access to it can change the behaviour of the program.
    #[must_use]
    pub fn with_cache(mut self, folder: impl Into<PathBuf>) -> Self {
        self.cache = Some(Cache::new(folder));
        self
    }

    /// The file of a compiled source; compiles it unless it is there.
    pub(crate) fn compile(&self, source: &Source) -> Result<PathBuf, NativeError> {
        let machine = self.machine()?;
        let parts = [source.header.as_str(), &source.source, &machine];
        let words = self.command.iter().chain(&self.flags).map(String::as_str);
        let cache = Cache::or_of_user(self.cache.as_ref(), "dualbody-native");
        let (cache, name) = (cache.ok_or(NativeError::NoCache)?, &source.name);
        let folder = cache.path(name, parts.into_iter().chain(words));
        let file = folder.join(format!("{name}{DLL_SUFFIX}"));
        if !file.is_file() {
            cache.keep(&folder, |own| {
                fs::create_dir_all(own).map_err(FileError::at(own))?;
                self.build(source, own)
            })?;
        }
        Ok(file)
    }

    /// Removes a compiled file that cannot be loaded.
    pub(crate) fn forget(file: &Path) {
        if let Some(folder) = file.parent() {
            let _ = fs::remove_dir_all(folder);
        }
    }

    /// All that the compiler predefines with these flags: its version, and the features of the machine.
    fn machine(&self) -> Result<String, NativeError> {
        let mut command = self.command(&["-dM", "-E", "-x", "c", "-"], Path::new("."));
        let output = self.run(&mut command)?;
        self.check("its flags", &output)?;
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    fn build(&self, source: &Source, folder: &Path) -> Result<(), NativeError> {
        source.save(folder).map_err(FileError::at(folder))?;
        let (text, file) = (
            format!("{}.c", &source.name),
            format!("{}{DLL_SUFFIX}", &source.name),
        );
        let flags = ["-std=c99", "-fPIC", "-shared", "-o", &file, &text, "-lm"];
        let mut command = self.command(&flags, folder);
        // Temporary files go with the folder where the compiler is killed.
        let output = self.run(command.env("TMPDIR", "."))?;
        self.check(&text, &output)
    }

    fn command(&self, flags: &[&str], folder: &Path) -> Command {
        let mut command = Command::new(&self.command[0]);
        command.args(&self.command[1..]).args(&self.flags);
        command.args(flags).current_dir(folder);
        command
    }

    fn run(&self, command: &mut Command) -> Result<Output, NativeError> {
        let name = || self.command.join(" ");
        match process::output(command) {
            Ok(Some(output)) => Ok(output),
            Ok(None) => Err(NativeError::Stopped { command: name() }),
            Err(reason) => Err(NativeError::NoCompiler {
                command: name(),
                reason,
            }),
        }
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
}
