//! Compilers as processes that a [`StopSignal`] ends, and the end of this program too.
//!
//! The command `cc` starts other programs: the compiler proper, the assembler, the linker. These go on when `cc` is killed, and GCC does not end them when
//! it is asked to terminate. So all of them are one group of processes, which is killed as a whole.
//!
//! A terminal's Ctrl-C does not reach this group, and the program that Ctrl-C ends cannot kill it any more. So a shell in a third group reads from a pipe
//! of the program. It kills the group unless it reads that the compiler is done: when the program reports it, and when the program ends in any way,
//! which closes the pipe.

use std::io;
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use dualbody::StopSignal;

/// How often signals are looked at.
const LOOK: Duration = Duration::from_millis(10);
/// How long killed processes are waited for, so that they write no more files. One that left its group may go on for ever.
const END: Duration = Duration::from_millis(100);

/// Runs a command, without input, until its end. Returns its output, or `None` if a signal that this thread watches was set before.
pub(crate) fn output(command: &mut Command) -> io::Result<Option<Output>> {
    let signals = StopSignal::watched();
    let is_stopped = || signals.iter().any(StopSignal::is_set);
    if is_stopped() {
        return Ok(None);
    }
    let (group, child) = Group::start(command)?;
    let (sender, receiver) = mpsc::channel();
    // Nothing waits for this message where killed processes do not end. Without a thread the group is dropped, which ends it.
    thread::Builder::new().spawn(move || sender.send(child.wait_with_output()))?;
    loop {
        match receiver.recv_timeout(LOOK) {
            Ok(output) => {
                group.release();
                return output.map(Some);
            }
            Err(RecvTimeoutError::Timeout) if is_stopped() => {
                group.kill();
                let _ = receiver.recv_timeout(END);
                return Ok(None);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(io::ErrorKind::BrokenPipe.into()),
        }
    }
}

/// A process with all that it starts. On Unix it ends when this is dropped without a word.
struct Group {
    /// The shell that stands by.
    #[cfg(unix)]
    shell: Child,
    #[cfg(not(unix))]
    process: u32,
}

#[cfg(unix)]
impl Group {
    /// Kills the group `$1` unless it reads that this is done.
    const STAND_BY: &str = r#"read -r word; [ "$word" = done ] || kill -s KILL -- "-$1""#;

    fn start(command: &mut Command) -> io::Result<(Self, Child)> {
        use std::os::unix::process::CommandExt;
        let piped = (Stdio::piped(), Stdio::piped());
        command.process_group(0).stdin(Stdio::null());
        let mut child = command.stdout(piped.0).stderr(piped.1).spawn()?;
        let mut shell = Command::new("sh");
        shell.args(["-c", Self::STAND_BY, "sh", &child.id().to_string()]);
        shell.process_group(0).stdin(Stdio::piped());
        let shell = shell.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        match shell {
            Ok(shell) => Ok((Self { shell }, child)),
            Err(error) => {
                let _ = child.kill();
                let _ = child.wait();
                Err(error)
            }
        }
    }

    fn release(self) {
        self.say("done\n");
    }

    fn kill(self) {
        self.say("stop\n");
    }

    /// Tells the shell, and waits until it has finished. A copy of the pipe in a process that was forked does not keep it from that.
    fn say(mut self, word: &str) {
        if let Some(mut pipe) = self.shell.stdin.take() {
            let _ = io::Write::write_all(&mut pipe, word.as_bytes());
        }
        let _ = self.shell.wait();
    }
}

#[cfg(not(unix))]
impl Group {
    fn start(command: &mut Command) -> io::Result<(Self, Child)> {
        command.stdin(Stdio::null());
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = child.spawn()?;
        let process = child.id();
        Ok((Self { process }, child))
    }

    fn release(self) {}

    /// Kills the process and those that it has started, by the tool of Windows.
    fn kill(self) {
        let process = self.process.to_string();
        let mut tool = Command::new("taskkill");
        let _ = tool.args(["/T", "/F", "/PID", &process]).output();
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(script: &str) -> io::Result<Option<Output>> {
        output(Command::new("sh").args(["-c", script]))
    }

    #[test]
    fn all_that_a_process_writes_is_read_with_how_it_ends() {
        let script = "head -c 300000 /dev/zero; head -c 200000 /dev/zero >&2; exit 3";
        let found = shell(script).expect("a shell").expect("nobody stops it");
        assert_eq!((found.stdout.len(), found.stderr.len()), (300_000, 200_000));
        assert_eq!(found.status.code(), Some(3));
        let none = output(&mut Command::new("no-such-compiler"));
        assert_eq!(none.unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn what_has_left_the_group_of_its_process_is_not_waited_for() {
        let (signal, begin) = (StopSignal::new(), std::time::Instant::now());
        let stop = signal.clone();
        let stopping = thread::spawn(move || {
            thread::sleep(Duration::from_millis(100));
            stop.stop();
        });
        // Job control gives the second process a group of its own, and it holds the output open.
        let found = signal.watch(|| shell("set -m; sleep 8 & wait"));
        stopping.join().expect("no panic");
        assert!(found.expect("a shell").is_none());
        assert!(begin.elapsed() < Duration::from_secs(4));
    }
}
