//! Threads of batches: a pool that is made again in a process that was forked, where the threads of its parent are missing.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;
use std::{io, thread};

use dualbody::StopSignal;
use pyo3::prelude::*;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::{guarded, invalid, value_error};
use crate::kinds::whole;

/// Number of threads that was asked for; zero for one each core, or what `RAYON_NUM_THREADS` says.
static WANTED: AtomicUsize = AtomicUsize::new(0);
static POOL: Mutex<Option<Pool>> = Mutex::new(None);

/// Bytes of the stack of a thread: those of a program's first thread, as steps of batches need more than the 2 MiB of others where they are compiled without
/// optimisation. They are addresses; memory is what is used of them.
const STACK: usize = 8 << 20;

/// Most threads that may be asked for: each takes memory and time.
const MOST: usize = 1024;

#[derive(Clone)]
struct Pool {
    process: u32,
    wanted: usize,
    pool: Arc<ThreadPool>,
}

/// Sets the number of threads of batches, 0 for one for each core.
#[pyfunction]
pub(crate) fn set_threads(threads: &Bound<'_, PyAny>) -> PyResult<()> {
    match whole("threads", threads)? {
        given if given > MOST => Err(invalid!("threads is {given}, expected at most {MOST}")),
        given => {
            WANTED.store(given, Ordering::Relaxed);
            Ok(())
        }
    }
}

/// Returns the number of threads of batches.
#[pyfunction]
pub(crate) fn threads() -> PyResult<usize> {
    Ok(pool()?.current_num_threads())
}

/// The pool of this process.
pub(crate) fn pool() -> PyResult<Arc<ThreadPool>> {
    let (process, wanted) = (std::process::id(), WANTED.load(Ordering::Relaxed));
    let mut known = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = &*known
        && (known.process, known.wanted) == (process, wanted)
    {
        return Ok(known.pool.clone());
    }
    let pool = ThreadPoolBuilder::new().num_threads(wanted);
    let pool = pool.stack_size(STACK).build();
    let pool = Arc::new(pool.map_err(value_error)?);
    let new = Pool {
        process,
        wanted,
        pool: pool.clone(),
    };
    // A pool of another process has no threads here that could end.
    if let Some(old) = known.replace(new)
        && old.process != process
    {
        std::mem::forget(old);
    }
    Ok(pool)
}

/// Runs work on a pool. Only what hands it over is generic: jobs and latches, which are most of the code, are compiled once.
pub(crate) fn install<R: Send>(pool: &ThreadPool, work: impl FnOnce() -> R + Send) -> R {
    fn any(pool: &ThreadPool, work: &mut (dyn FnMut() + Send)) {
        pool.install(work);
    }
    let (mut work, mut out) = (Some(work), None);
    any(pool, &mut || out = work.take().map(|work| work()));
    out.expect("the pool has done the work")
}

/// Runs work on the pool, without the interpreter lock.
pub(crate) fn on_pool<R: Send>(py: Python<'_>, work: impl FnOnce() -> R + Send) -> PyResult<R> {
    let pool = pool()?;
    py.detach(|| guarded(|| install(&pool, work)))
}

/// Fewer items than this stay on the thread that asks for them.
pub(crate) const FEW: usize = 4;

/// Computes something for every item, on the pool if there are many; the interpreter lock is not needed.
pub(crate) fn each<R: Send>(
    count: usize,
    one: impl Fn(usize) -> R + Send + Sync,
) -> PyResult<Vec<R>> {
    if count < FEW {
        return guarded(|| (0..count).map(one).collect());
    }
    let pool = pool()?;
    guarded(|| install(&pool, || (0..count).into_par_iter().map(one).collect()))
}

/// Runs short work on this thread and, of loops of the library, on others of the pool, without the interpreter lock.
pub(crate) fn beside_pool<R: Send>(py: Python<'_>, work: impl FnOnce() -> R + Send) -> PyResult<R> {
    let pool = pool()?;
    py.detach(|| guarded(|| dualbody::beside_pool(&pool, work)))
}

/// [`on_pool_watched`] without progress: solvers, which Ctrl-C ends.
pub(crate) fn on_pool_stopped<R: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    on_pool_watched(py, None, |_| work())
}

/// How often work that takes long is looked after: for Ctrl-C and for its progress.
const LOOK: Duration = Duration::from_millis(50);

/// Flags shared by long work and the thread that waits for it.
#[derive(Default)]
pub(crate) struct Watch {
    stop: StopSignal,
    done: AtomicUsize,
    /// Whether progress is shown. Otherwise threads do not count, since counting makes them wait for each other.
    counts: bool,
}

impl Watch {
    /// Counts a step, or ends the work if it is to stop: it unwinds to where panics are caught.
    pub(crate) fn step(&self) {
        if self.counts {
            self.done.fetch_add(1, Ordering::Relaxed);
        }
        if self.stop.is_set() {
            resume_unwind(Box::new("stopped"));
        }
    }
}

/// [`on_pool`] that Ctrl-C ends: signals are looked at while the work goes on, and so is `progress(done)`, if it is given.
pub(crate) fn on_pool_watched<R: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> R + Send,
) -> PyResult<R> {
    let pool = pool()?;
    watched(py, progress, move |watch| {
        install(&pool, || watch.stop.watch(|| work(watch)))
    })
}

/// Runs work that waits for other programs, such as compilers, which Ctrl-C ends: a thread of the pool would do nothing else meanwhile.
pub(crate) fn stopped<R: Send>(py: Python<'_>, work: impl FnOnce() -> R + Send) -> PyResult<R> {
    watched(py, None, |watch| watch.stop.watch(work))
}

/// Runs work on a thread of its own, without the interpreter lock, and looks at signals and after its progress until it ends.
fn watched<R: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> R + Send,
) -> PyResult<R> {
    let watch = Watch {
        counts: progress.is_some(),
        ..Watch::default()
    };
    let progress = progress.map(|progress| progress.clone().unbind());
    let look = || {
        Python::attach(|py| {
            py.check_signals()?;
            let done = watch.done.load(Ordering::Relaxed);
            progress
                .as_ref()
                .map_or(Ok(()), |f| f.call1(py, (done,)).map(|_| ()))
        })
    };
    let ended = py.detach(|| {
        thread::scope(|scope| {
            let (sender, receiver) = mpsc::channel();
            let watch = &watch;
            let serve = move || {
                let out = guarded(|| work(watch));
                let _ = sender.send(());
                out
            };
            let worker = thread::Builder::new().stack_size(STACK);
            let worker = worker.spawn_scoped(scope, serve)?;
            let mut looked = Ok(());
            while let Err(mpsc::RecvTimeoutError::Timeout) = receiver.recv_timeout(LOOK) {
                if looked.is_ok() {
                    looked = look();
                    if looked.is_err() {
                        watch.stop.stop();
                    }
                }
            }
            Ok::<_, io::Error>((worker.join(), looked))
        })
    });
    let (out, looked) = ended.map_err(value_error)?;
    looked?;
    let out = out.map_err(|_| value_error("the work on its thread ended early"))?;
    look()?;
    out
}
