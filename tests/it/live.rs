//! The server of a running simulation: accepted requests, and its answers.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use dualbody::view::Live;
use dualbody::{Simulator, model::samples};

fn live() -> Live {
    let simulator = Simulator::new(samples::cartpole());
    let start = simulator.neutral_state();
    Live::start(simulator, &start).expect("a free port")
}

/// Host and path of an address.
fn parts(live: &Live) -> (String, String) {
    let rest = live.url().strip_prefix("http://").expect("an address");
    let (host, path) = rest.split_once('/').expect("a path");
    (host.into(), format!("/{path}"))
}

/// The whole answer to some lines.
fn answer(host: &str, lines: &[String]) -> String {
    let mut stream = TcpStream::connect(host).expect("a connection");
    stream
        .set_read_timeout(Some(Duration::from_secs(20)))
        .expect("a timeout");
    stream
        .write_all((lines.join("\r\n") + "\r\n\r\n").as_bytes())
        .expect("a request");
    let mut out = Vec::new();
    let _ = stream.read_to_end(&mut out);
    String::from_utf8_lossy(&out).into_owned()
}

fn get(host: &str, path: &str, more: &[&str]) -> String {
    let mut lines = vec![format!("GET {path} HTTP/1.1")];
    lines.extend(more.iter().map(|line| (*line).to_owned()));
    answer(host, &lines)
}

#[test]
fn the_page_is_for_who_knows_the_secret_and_names_this_machine() {
    let live = live();
    let (host, path) = parts(&live);
    let port = host.rsplit(':').next().expect("a port");
    let own = format!("Host: {host}");
    assert_eq!(path.len(), 34);
    let page = get(&host, &path, &[&own]);
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("pivot"));
    assert!(get(&host, &path, &[&format!("Host: localhost:{port}")]).starts_with("HTTP/1.1 200"));
    for (path, lines, status) in [
        // Another secret, none, a part of it, more than it.
        (
            "/00000000000000000000000000000000/",
            vec![own.as_str()],
            "404",
        ),
        ("/", vec![&own], "404"),
        (&path[..20], vec![&own], "404"),
        (&format!("{path}../x"), vec![&own], "404"),
        // Another name of this machine, as by a domain name system that lies; none; two.
        (&path, vec!["Host: evil.example"], "403"),
        (&path, vec!["Host: 127.0.0.1:1"], "403"),
        (&path, vec![], "403"),
        (&path, vec![&own, "Host: evil.example"], "403"),
        // Another origin, to read or to give orders.
        (&path, vec![&own, "Origin: http://evil.example"], "403"),
        (&path, vec![&own, "Origin: null"], "403"),
        (
            &format!("{path}socket"),
            vec![
                &own,
                "Origin: https://evil.example",
                "Upgrade: websocket",
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
            ],
            "403",
        ),
        (&format!("{path}socket"), vec![&own], "426"),
    ] {
        let found = get(&host, path, &lines);
        assert!(
            found.starts_with(&format!("HTTP/1.1 {status}")),
            "{path} {lines:?}: {found}"
        );
        assert!(!found.contains("pivot"));
    }
}

#[test]
fn broken_requests_are_refused_and_the_server_goes_on() {
    let live = live();
    let (host, path) = parts(&live);
    let own = format!("Host: {host}");
    assert!(
        answer(&host, &[format!("POST {path} HTTP/1.1"), own.clone()]).starts_with("HTTP/1.1 405")
    );
    assert!(answer(&host, &["nonsense".into()]).starts_with("HTTP/1.1 400"));
    let long = format!("X: {}", "x".repeat(100_000));
    assert!(!answer(&host, &[format!("GET {path} HTTP/1.1"), own.clone(), long]).contains("pivot"));
    let many = (0..1000).map(|k| format!("X-{k}: 1"));
    let lines: Vec<String> = [format!("GET {path} HTTP/1.1"), own.clone()]
        .into_iter()
        .chain(many)
        .collect();
    assert!(!answer(&host, &lines).contains("pivot"));
    assert!(get(&host, &path, &[&own]).starts_with("HTTP/1.1 200"));
}

#[test]
fn the_handshake_of_the_socket_equals_that_of_the_standard() {
    let live = live();
    let (host, path) = parts(&live);
    let mut stream = TcpStream::connect(&host).expect("a connection");
    stream
        .set_read_timeout(Some(Duration::from_secs(20)))
        .expect("a timeout");
    // Key and answer of RFC 6455, section 1.3.
    let head = format!(
        "GET {path}socket HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    );
    stream.write_all(head.as_bytes()).expect("a request");
    let mut out = String::new();
    let mut part = [0; 4096];
    while !out.contains("\"time\"") {
        let n = stream.read(&mut part).expect("an answer");
        out += &String::from_utf8_lossy(&part[..n]);
    }
    assert!(out.starts_with("HTTP/1.1 101") && out.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="));
}

#[test]
fn recordings_are_served_and_the_port_is_free_when_it_ends() {
    let live = live();
    let (host, path) = parts(&live);
    let own = format!("Host: {host}");
    assert!(get(&host, &format!("{path}recording.csv"), &[&own]).contains("q.pivot"));
    assert!(get(&host, &format!("{path}recording.json"), &[&own]).contains("\"times\""));
    assert!(get(&host, &format!("{path}recording.html"), &[&own]).contains("<!doctype html>"));
    assert_eq!((live.recording().len(), live.state().q.len()), (1, 2));
    drop(live);
    assert!(TcpStream::connect(&host).is_err());
}

#[test]
fn a_controller_sets_the_inputs_in_place_of_sliders() {
    let simulator = Simulator::new(samples::cartpole());
    let start = simulator.neutral_state();
    let live =
        Live::start_with_control(simulator, &start, |_, _, u| u[0] = 1.0).expect("a free port");
    let (host, path) = parts(&live);
    assert!(get(&host, &path, &[&format!("Host: {host}")]).contains("\"targets\":[]"));
}
