//! Requests of browsers, and the check that they come from this machine.

use std::io::{self, Read};

use super::Shared;

/// Longest head of a request, bytes, and most lines of it.
const HEAD: usize = 16 << 10;
const LINES: usize = 64;

/// A request that is let in.
#[derive(Debug, PartialEq)]
pub(super) enum Request {
    Page,
    Recording(Format),
    /// A socket, with the key of its handshake.
    Socket(String),
}

/// A file that a recording is saved as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    Html,
    Csv,
    Json,
}

/// A refused request, with its status.
#[derive(Debug, PartialEq)]
pub(super) struct Refusal(pub(super) &'static str);

/// Reads the head of a request, bounded; what follows it is not read.
pub(super) fn read_head(stream: &mut impl Read) -> io::Result<Vec<u8>> {
    let (mut head, mut part) = (Vec::new(), [0; 1024]);
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let n = stream.read(&mut part)?;
        if n == 0 || head.len() + n > HEAD {
            return Err(io::ErrorKind::InvalidData.into());
        }
        head.extend_from_slice(&part[..n]);
    }
    Ok(head)
}

/// Looks at a head: the method, the host, the origin, the secret, then what is requested.
pub(super) fn request(head: &[u8], shared: &Shared) -> Result<Request, Refusal> {
    let mut lines = [httparse::EMPTY_HEADER; LINES];
    let mut parsed = httparse::Request::new(&mut lines);
    match parsed.parse(head) {
        Ok(httparse::Status::Complete(_)) => {}
        _ => return Err(Refusal("400 Bad Request")),
    }
    let all = |name: &str| {
        let own = parsed
            .headers
            .iter()
            .filter(|line| line.name.eq_ignore_ascii_case(name));
        own.map(|line| String::from_utf8_lossy(line.value).trim().to_owned())
            .collect::<Vec<_>>()
    };
    if parsed.method != Some("GET") {
        return Err(Refusal("405 Method Not Allowed"));
    }
    let names = [
        format!("127.0.0.1:{}", shared.port),
        format!("localhost:{}", shared.port),
    ];
    // A foreign domain name that resolves to this address is not one of these.
    if !matches!(all("host").as_slice(), [host] if names.contains(host)) {
        return Err(Refusal("403 Forbidden"));
    }
    let is_own = |origin: &String| names.iter().any(|name| *origin == format!("http://{name}"));
    if !all("origin").iter().all(is_own) {
        return Err(Refusal("403 Forbidden"));
    }
    let unknown = Refusal("404 Not Found");
    let path = parsed.path.unwrap_or_default().split(['?', '#']).next();
    let path = path.and_then(|path| path.strip_prefix('/')?.strip_prefix(shared.secret.as_str()));
    match path {
        Some("/") => Ok(Request::Page),
        Some("/recording.html") => Ok(Request::Recording(Format::Html)),
        Some("/recording.csv") => Ok(Request::Recording(Format::Csv)),
        Some("/recording.json") => Ok(Request::Recording(Format::Json)),
        Some("/socket") => match (
            all("upgrade").as_slice(),
            all("sec-websocket-key").as_slice(),
        ) {
            ([kind], [key]) if kind.eq_ignore_ascii_case("websocket") => {
                Ok(Request::Socket(key.clone()))
            }
            _ => Err(Refusal("426 Upgrade Required")),
        },
        _ => Err(unknown),
    }
}
