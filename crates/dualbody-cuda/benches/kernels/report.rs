//! Remarks of the compiler on a kernel, and contents of its machine code.

use std::error::Error;
use std::fmt;
use std::fs;
use std::time::Instant;

use dualbody::codegen::CudaSource;
use dualbody_cuda::{Architecture, Compiled, Compiler};
use object::{Object, ObjectSection};

/// Bytes of an instruction, since the architecture `sm_70`.
const INSTRUCTION: u64 = 16;
/// Ticks of a second in which Linux counts the time of processes.
const TICKS: f64 = 100.0;

/// Sizes of the kernels of a function, together except for the registers.
pub(crate) struct Report {
    /// The most of one.
    registers: usize,
    /// Stored and loaded, of all functions of the kernel.
    spilled: usize,
    instructions: u64,
    /// Processor time of compiling, where the system reports it; otherwise time on the clock.
    seconds: f64,
}

impl Report {
    /// Compiles the kernels of a function, none of which may be kept already.
    pub(crate) fn of(
        source: &CudaSource,
        compiler: &Compiler,
        architecture: Architecture,
    ) -> Result<Self, Box<dyn Error>> {
        let (start, used) = (Instant::now(), processor_time());
        let all = compiler.compile_all(source, architecture)?;
        let elapsed = start.elapsed().as_secs_f64();
        let seconds = used
            .zip(processor_time())
            .map_or(elapsed, |(from, to)| to - from);
        let logs: Option<Vec<&str>> = all.iter().map(Compiled::log).collect();
        let logs = logs.ok_or("a kernel was compiled before")?;
        let numbers = |word: &'static str| {
            let lines = logs.iter().flat_map(|log| log.lines());
            lines.filter_map(move |line| number_before(line, word))
        };
        let instructions = all.iter().map(instructions);
        Ok(Self {
            registers: numbers(" registers")
                .max()
                .ok_or("the compiler does not say how many registers there are")?,
            spilled: numbers(" bytes spill stores")
                .chain(numbers(" bytes spill loads"))
                .sum(),
            instructions: instructions.sum::<Result<u64, _>>()?,
            seconds,
        })
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            registers,
            spilled,
            instructions,
            seconds,
        } = self;
        write!(f, "{registers} {spilled} {instructions} {seconds:.1}")
    }
}

/// Number of the instructions of a kernel.
fn instructions(compiled: &Compiled) -> Result<u64, object::Error> {
    let code = object::File::parse(compiled.image())?;
    let sections = code
        .sections()
        .filter(|section| section.name().is_ok_and(|name| name.starts_with(".text")));
    Ok(sections.map(|section| section.size()).sum::<u64>() / INSTRUCTION)
}

/// The number that stands before a word in a line.
fn number_before(line: &str, word: &str) -> Option<usize> {
    let (before, _) = line.split_once(word)?;
    before
        .rsplit(|c: char| !c.is_ascii_digit())
        .next()?
        .parse()
        .ok()
}

/// Processor time of this program so far, s; `None` where Linux does not report it.
fn processor_time() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // After the name in brackets: utime and stime are the 12th and 13th.
    let (_, rest) = stat.rsplit_once(')')?;
    let ticks: Vec<f64> = rest
        .split_whitespace()
        .skip(11)
        .take(2)
        .filter_map(|x| x.parse().ok())
        .collect();
    Some(ticks.iter().sum::<f64>() / TICKS)
}
