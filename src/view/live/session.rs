//! One browser page: sixty frames per second to it, commands from it.

use std::io::{self, ErrorKind, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use super::Shared;

/// Time from one frame to the next.
const FRAME: Duration = Duration::from_micros(16_667);

/// Largest order, bytes.
const ORDER: usize = 4096;

/// Most orders between two frames.
const ORDERS: usize = 100;

/// Serves a page until it goes away.
pub(super) fn run(mut stream: TcpStream, key: &str, shared: &Shared) -> io::Result<()> {
    let accept = derive_accept_key(key.as_bytes());
    write!(
        stream,
        "HTTP/1.1 101 Switching Protocols\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Accept: {accept}\r\n\r\n"
    )?;
    let config = WebSocketConfig::default()
        .max_message_size(Some(ORDER))
        .max_frame_size(Some(ORDER));
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, Some(config));
    shared.world().wake();
    let mut next = Instant::now();
    while !shared.ends() {
        if !listen(&mut socket, next, shared)? {
            return Ok(());
        }
        // Late frames are skipped.
        next = (next + FRAME).max(Instant::now());
        let frame = {
            let mut world = shared.world();
            world.advance();
            world.frame()
        };
        match socket.send(Message::text(frame)) {
            Ok(()) => {}
            Err(Error::Io(error)) => return Err(error),
            Err(_) => return Ok(()),
        }
    }
    let _ = socket.close(None);
    let _ = socket.flush();
    Ok(())
}

/// Executes commands until a time; `false` if the page is closed. Pending commands are executed even if no time is left.
fn listen(socket: &mut WebSocket<TcpStream>, until: Instant, shared: &Shared) -> io::Result<bool> {
    for _ in 0..ORDERS {
        let left = until.saturating_duration_since(Instant::now());
        let timeout = left.max(Duration::from_millis(1));
        socket.get_ref().set_read_timeout(Some(timeout))?;
        match socket.read() {
            Ok(Message::Text(order)) => shared.world().obey(&order),
            Ok(Message::Close(_)) => return Ok(false),
            Ok(_) => {}
            Err(Error::Io(error))
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
            {
                return Ok(true);
            }
            Err(Error::Io(error)) => return Err(error),
            Err(_) => return Ok(false),
        }
    }
    Ok(true)
}
