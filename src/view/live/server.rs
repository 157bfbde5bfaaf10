//! Connections of browsers.

use std::io::{self, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use super::Shared;
use super::request::{Format, Refusal, Request, read_head, request};
use super::session;

/// Most connections at a time: a page has two.
const MOST: usize = 16;

/// Longest time that a browser is waited for.
const PATIENCE: Duration = Duration::from_secs(5);

/// Answers connections, each in its own thread, until the end.
pub(super) fn run(listener: &TcpListener, shared: &Arc<Shared>) {
    let open = Arc::new(AtomicUsize::new(0));
    let mut threads = Vec::new();
    for stream in listener.incoming() {
        if shared.ends() {
            break;
        }
        let Ok(stream) = stream else { continue };
        threads.retain(|thread: &thread::JoinHandle<()>| !thread.is_finished());
        if open.fetch_add(1, Ordering::Relaxed) >= MOST {
            open.fetch_sub(1, Ordering::Relaxed);
            continue;
        }
        let (shared, open) = (Arc::clone(shared), Arc::clone(&open));
        threads.push(thread::spawn(move || {
            // A closed connection is not an error.
            let _ = answer(stream, &shared);
            open.fetch_sub(1, Ordering::Relaxed);
        }));
    }
    for thread in threads {
        let _ = thread.join();
    }
}

/// Lets [`run`] see that the end has come.
pub(super) fn wake(port: u16) {
    let _ = TcpStream::connect(("127.0.0.1", port));
}

fn answer(mut stream: TcpStream, shared: &Shared) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.set_nodelay(true)?;
    let head = read_head(&mut stream)?;
    match request(&head, shared) {
        Ok(Request::Page) => send(
            &mut stream,
            "200 OK",
            "text/html; charset=utf-8",
            &shared.page,
        ),
        Ok(Request::Recording(format)) => {
            let recording = shared.world().recording();
            let (kind, text) = match format {
                Format::Html => ("text/html; charset=utf-8", recording.to_html()),
                Format::Csv => ("text/csv; charset=utf-8", recording.to_csv()),
                Format::Json => ("application/json", recording.to_json()),
            };
            send(&mut stream, "200 OK", kind, &text)
        }
        Ok(Request::Socket(key)) => session::run(stream, &key, shared),
        Err(Refusal(status)) => send(&mut stream, status, "text/plain", status),
    }
}

/// Sends a whole answer, with headers against caching, embedding and referrers.
fn send(stream: &mut TcpStream, status: &str, kind: &str, text: &str) -> io::Result<()> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\nCache-Control: no-store\r\n\
         Referrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\n\r\n",
        text.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(text.as_bytes())?;
    stream.flush()
}
