//! The process that runs cases: it reports each case that it starts, and its findings.

use std::any::Any;
use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;
use std::sync::Mutex;
use std::thread;

use crate::check::Checks;
use crate::input::Case;
use crate::memory;
use crate::options::Options;
use crate::seeds::Seeds;

/// Memory that a case may use: so many times its input, and so much in any case.
const MEMORY_PER_BYTE: usize = 100;
const MEMORY: usize = 64 << 20;

/// Stack of a case: the default of a thread.
const STACK: usize = 2 << 20;

/// Where the last panic was.
static PLACE: Mutex<String> = Mutex::new(String::new());

/// Runs all cases of a process and writes lines to its parent: `n <index> <kind>` before a case, `+` where it was accepted, `v
/// <reason>` where something does not hold.
pub(crate) fn run(options: Options) -> ExitCode {
    panic::set_hook(Box::new(|info| {
        let place = info
            .location()
            .map_or_else(String::new, ToString::to_string);
        *PLACE.lock().unwrap_or_else(|poison| poison.into_inner()) = place;
    }));
    let worker = thread::Builder::new()
        .stack_size(STACK)
        .spawn(move || serve(&options));
    let served = worker.map(thread::JoinHandle::join);
    ExitCode::from(u8::from(!matches!(served, Ok(Ok(())))))
}

fn serve(options: &Options) {
    let (seeds, checks) = (Seeds::new(), Checks::new());
    let mut out = std::io::stdout();
    let mut index = options.from;
    while index < options.executions {
        let case = Case::new(&seeds, &options.kinds, options.seed, index);
        let mut tell = |line: &str| {
            let told = out.write_all(line.as_bytes()).and_then(|()| out.flush());
            // Nobody listens any more.
            told.unwrap_or_else(|_| std::process::exit(1));
        };
        tell(&format!("n {index} {}\n", case.kind.name()));
        match judge(&checks, &case) {
            Ok(true) => tell("+\n"),
            Ok(false) => {}
            Err(reason) => tell(&format!("v {}\n", reason.escape_debug())),
        }
        index += options.step;
    }
}

/// Runs a case; a panic is something that does not hold.
fn judge(checks: &Checks, case: &Case) -> Result<bool, String> {
    let limit = MEMORY + MEMORY_PER_BYTE * case.bytes.len();
    let run = AssertUnwindSafe(|| checks.run(case));
    match memory::within(limit, || panic::catch_unwind(run)) {
        Ok(judged) => judged,
        Err(panic) => Err(format!("panic at {}: {}", place(), message(&*panic))),
    }
}

fn place() -> String {
    PLACE
        .lock()
        .unwrap_or_else(|poison| poison.into_inner())
        .clone()
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("no message")
}

/// Runs one case in sight, with its file printed.
pub(crate) fn replay(options: &Options) -> ExitCode {
    let (seeds, checks) = (Seeds::new(), Checks::new());
    let case = Case::new(&seeds, &options.kinds, options.seed, options.from);
    println!(
        "{}\n-- {} of {} bytes",
        case.text(),
        case.kind.name(),
        case.bytes.len()
    );
    let judged = judge(&checks, &case);
    println!("{judged:?}");
    ExitCode::from(u8::from(judged.is_err()))
}
