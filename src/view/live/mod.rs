//! A simulation in real time on a page: watched, paused, dragged, steered.
//!
//! | file | content |
//! |---|---|
//! | `world` | the simulation: time, orders, targets, recording |
//! | `drag` | the spring between a body and the mouse |
//! | `server` | connections, and who is let in |
//! | `request` | what a browser asks for |
//! | `session` | one page: frames to it, orders from it |
//!
//! The simulation goes on only while a page shows it: the thread of a connection moves it to the present before each frame.

mod drag;
mod request;
mod server;
mod session;
mod world;

use std::io;
use std::net::TcpListener;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use super::html::live_page;
use super::recording::Recording;
use crate::sim::{Simulator, State};
use world::World;

/// Bytes of the secret in the address.
const SECRET: usize = 16;

/// A simulation that a page shows while it runs, served to browsers of this machine.
///
/// On the page it is paused, stepped, slowed and reset; joints are moved by sliders, through servos; a body is pulled with the mouse, by a
/// spring; contact forces are drawn; what was seen is saved as a page or a table. It goes on while a page is open, and ends when this value is
/// dropped.
///
/// # Who is let in
/// The server listens on the loopback address only, so that other machines do not reach it. Its address holds 128 random bits, without which
/// everything is refused: other users of the machine do not know them. Requests that name another host, or come from pages of another origin, are
/// refused.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples, view::Live};
///
/// let simulator = Simulator::new(samples::cartpole());
/// let start = simulator.neutral_state();
/// let live = Live::start(simulator, &start)?;
/// assert!(live.url().starts_with("http://127.0.0.1:"));
/// // Opened in a browser, it runs there; this thread waits with `live.wait()`, or does something else.
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Live {
    url: String,
    shared: Arc<Shared>,
    server: Option<JoinHandle<()>>,
}

/// What all connections share.
#[derive(Debug)]
struct Shared {
    world: Mutex<World>,
    page: String,
    port: u16,
    secret: String,
    ends: AtomicBool,
}

impl Shared {
    /// The simulation; one that a thread left in the middle of a step goes on from there.
    fn world(&self) -> MutexGuard<'_, World> {
        self.world.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn ends(&self) -> bool {
        self.ends.load(Ordering::Relaxed)
    }
}

impl Live {
    /// Starts a server on a free port. Joints get servos that hold them as they start, with the effort limits of the simulator; those that have a
    /// servo keep it.
    ///
    /// # Errors
    /// If the system has no port or no random numbers.
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn start(simulator: Simulator, start: &State) -> io::Result<Self> {
        let simulator = simulator.with_holding_servos();
        let u = simulator.holding_targets(start);
        Self::serve(World::new(simulator, start, u, None))
    }

    /// [`start`](Self::start) with a controller in place of servos and sliders: `control(time, state, u)` sets the input of each step.
    ///
    /// # Errors
    /// If the system has no port or no random numbers.
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn start_with_control(
        simulator: Simulator,
        start: &State,
        control: impl FnMut(f64, &State, &mut [f64]) + Send + 'static,
    ) -> io::Result<Self> {
        let u = vec![0.0; simulator.nu()];
        Self::serve(World::new(simulator, start, u, Some(Box::new(control))))
    }

    fn serve(world: World) -> io::Result<Self> {
        let listener = TcpListener::bind(("127.0.0.1", 0))?;
        let (port, secret) = (listener.local_addr()?.port(), secret()?);
        let shared = Arc::new(Shared {
            page: live_page(&world.recording(), &world.controls(), port),
            world: Mutex::new(world),
            port,
            secret,
            ends: AtomicBool::new(false),
        });
        let own = Arc::clone(&shared);
        let server = thread::Builder::new()
            .name("dualbody live".into())
            .spawn(move || server::run(&listener, &own))?;
        Ok(Self {
            url: format!("http://127.0.0.1:{port}/{}/", shared.secret),
            shared,
            server: Some(server),
        })
    }

    /// Address of the page, with its secret.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// What was seen since the start or the last reset, at most 60 moments a second.
    pub fn recording(&self) -> Recording {
        self.shared.world().recording()
    }

    /// State of now.
    pub fn state(&self) -> State {
        self.shared.world().state().clone()
    }

    /// Waits until the program ends: for programs that do nothing else.
    pub fn wait(mut self) {
        if let Some(server) = self.server.take() {
            // A thread that panicked has ended.
            let _ = server.join();
        }
    }

    /// Ends the server.
    fn end(&mut self) {
        self.shared.ends.store(true, Ordering::Relaxed);
        server::wake(self.shared.port);
        if let Some(server) = self.server.take() {
            let _ = server.join();
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.end();
    }
}

/// Random bits as text.
fn secret() -> io::Result<String> {
    let mut bytes = [0; SECRET];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
