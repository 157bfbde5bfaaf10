//! A real-time simulation in the browser: watch, pause, drag bodies, move joints.
//!
//! | file | content |
//! |---|---|
//! | `world` | the simulation: time, commands, targets, recording |
//! | `drag` | the spring between a body and the mouse |
//! | `server` | connections and access control |
//! | `request` | requests of a browser |
//! | `session` | one browser page: frames to it, commands from it |
//!
//! The simulation runs only while a page is open: the thread of a connection advances it to the present before each frame.

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

/// A running simulation, shown in browsers of this machine.
///
/// In the browser the user can pause, step, slow down and reset it, move joints by sliders (through servos), pull a body with the mouse (by a
/// spring), see contact forces, and save the motion as an HTML viewer or a table. It runs while a page is open, and ends when this value is dropped.
///
/// # Access control
/// The server listens on the loopback address only, so other machines cannot reach it. Its URL contains 128 random bits, and
/// requests without them are refused: other users of the machine do not know them. Requests to another host name, or from pages of another origin,
/// are refused.
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

/// Shared data of all connections.
#[derive(Debug)]
struct Shared {
    world: Mutex<World>,
    page: String,
    port: u16,
    secret: String,
    ends: AtomicBool,
}

impl Shared {
    /// The simulation; it continues after a thread that panicked within a step.
    fn world(&self) -> MutexGuard<'_, World> {
        self.world.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn ends(&self) -> bool {
        self.ends.load(Ordering::Relaxed)
    }
}

impl Live {
    /// Starts a server on a free port. Joints get servos that hold their initial position, with the effort limits of the simulator; joints with a servo keep it.
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

    /// [`start`](Self::start) with a controller instead of servos and sliders: `control(time, state, u)` sets the input of each step.
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

    /// URL of the page, including its secret.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// The recording since the start or the last reset, with at most 60 times per second.
    pub fn recording(&self) -> Recording {
        self.shared.world().recording()
    }

    /// The current state.
    pub fn state(&self) -> State {
        self.shared.world().state().clone()
    }

    /// Blocks until the program ends: for programs that do nothing else.
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
