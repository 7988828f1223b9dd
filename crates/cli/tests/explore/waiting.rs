//! Many who ask, who leave, and who are slow: nobody keeps the others waiting.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use vibrochain_testkit::TestDir;

use crate::points::{HARMONICS, MODEL, model};
use crate::served::{PATIENCE, Served, read, scene, until};

/// A slow orbit that nobody waits for any more gives its worker back: there are two, and both are asked for it, again and again.
#[test]
fn an_orbit_that_nobody_waits_for_frees_its_worker() {
    let served = Served::new("");
    let mut model_of_it = model(HARMONICS);
    model_of_it.insert("sites".to_owned(), 1001.into());
    model_of_it.insert("omega".to_owned(), 0.07.into());
    let slow = json!({ "model": model_of_it, "which": "double-sided", "samples": 2 });
    let quick = json!({ "model": model(MODEL), "which": "double-sided", "samples": 8 });
    for _ in 0..4 {
        let mut left: Vec<TcpStream> = (0..2).map(|_| served.connect()).collect();
        for stream in &mut left {
            stream.write_all(served.request("POST", "orbit", "", &slow.to_string()).as_bytes()).unwrap();
        }
        // Both are under way: the next question waits in vain as long as they are.
        let mut third = served.connect();
        third.write_all(served.request("POST", "orbit", "", &quick.to_string()).as_bytes()).unwrap();
        third.set_read_timeout(Some(Duration::from_millis(1500))).unwrap();
        let waited = third.read(&mut [0]);
        assert!(waited.is_err(), "{waited:?}: the slow orbits are not slow");
        drop(left);
        third.set_read_timeout(Some(PATIENCE)).unwrap();
        assert_eq!(read(&mut third).unwrap().code, 200);
    }
    served.is_alive();
}

#[test]
fn thousands_of_requests_at_once_are_answered_or_refused() {
    let served = Served::new(" --threads 2");
    let body = json!({ "scene": scene(), "z": 2, "x": 1, "y": 1 }).to_string();
    let requests = [
        served.request("POST", "tile", "", &body),
        served.request("GET", "style.css", "", ""),
        served.request("POST", "view", "", &json!({ "scene": scene() }).to_string()),
        served.request("GET", "", "Origin: http://example.org\r\n", ""),
    ];
    let mut counts = std::collections::BTreeMap::new();
    for _ in 0..5 {
        let mut streams: Vec<TcpStream> = (0..500).map(|_| served.connect()).collect();
        for (stream, request) in streams.iter_mut().zip(requests.iter().cycle()) {
            stream.write_all(request.as_bytes()).unwrap();
        }
        for stream in &mut streams {
            // Answered one after the other: those that are served leave their places to those that wait.
            let answer = read(stream).unwrap();
            let _ = stream.shutdown(std::net::Shutdown::Both);
            let later = ["retry-after: 1", "connection: close"].map(|line| answer.head.contains(line));
            assert_eq!(later, [answer.code == 503, [403, 503].contains(&answer.code)], "{answer:?}");
            *counts.entry(answer.code).or_insert(0) += 1;
        }
    }
    assert_eq!(counts.values().sum::<i32>(), 2500);
    assert!(counts.keys().all(|code| [200, 403, 503].contains(code)), "{counts:?}");
    assert!(counts[&403] == 625 && counts[&200] > 1250, "{counts:?}");
    served.is_alive();
    assert_eq!(served.post("tile", &json!({ "scene": scene(), "z": 2, "x": 1, "y": 1 })).code, 200);
}

/// Each of these tiles takes minutes: an answer comes only if they are given up.
#[test]
fn what_nobody_waits_for_any_more_is_not_computed() {
    let served = Served::new(" --threads 1");
    let mut slow = scene();
    slow["model"]["sites"] = 1001.into();
    for round in 0..3 {
        let asked: Vec<TcpStream> = (0..20)
            .map(|i| {
                let mut stream = served.connect();
                let body = json!({ "scene": slow, "z": 6, "x": 30 + round, "y": 10 + i }).to_string();
                stream.write_all(served.request("POST", "tile", "", &body).as_bytes()).unwrap();
                stream
            })
            .collect();
        drop(asked);
    }
    assert_eq!(served.post("tile", &json!({ "scene": scene(), "z": 0, "x": 0, "y": 0 })).code, 200);
    served.is_alive();
}

/// Borders of so many masses take minutes.
pub(crate) fn long_borders() -> Value {
    let mut slow = scene();
    slow["model"]["sites"] = 1001.into();
    json!({ "scene": slow, "tolerance": 1e-9, "places": 0 })
}

#[test]
fn borders_keep_no_point_waiting_and_end_when_nobody_waits_for_them() {
    let served = Served::new("");
    let point = json!({ "model": model(MODEL), "which": "double-sided", "samples": 4 });
    let mut under_way: Vec<TcpStream> = (0..2).map(|_| served.ask("curves", &long_borders())).collect();
    until("borders under way", || served.has_files());
    assert_eq!(served.post("orbit", &point).code, 200);
    // A newer one takes the place of the oldest, which is told so.
    under_way.push(served.ask("curves", &long_borders()));
    let told = read(&mut under_way[0]).unwrap().refused(409);
    assert!(told.starts_with("a newer request has taken its place"), "{told}");
    // Left by all who have asked, they end, and leave no file.
    drop(under_way);
    until("the end of all borders", || !served.has_files());
    let quick = json!({ "scene": scene(), "tolerance": 1e-3, "places": 0 });
    assert_eq!(served.post("curves", &quick).code, 200);
    assert!(!served.has_files());
}

/// More connections than are served at a time, none of which asks, or none of which reads what it has asked for.
#[test]
fn the_owner_is_served_whoever_keeps_connections() {
    let served = Served::new("");
    let many = 400;
    let pages = served.request("GET", "map.js", "", "").repeat(200);
    let unread: Vec<TcpStream> = (0..many)
        .map(|_| {
            let mut stream = served.connect();
            // As much as fits; the other side stops to read where its answers are not read.
            stream.set_nonblocking(true).unwrap();
            let _ = stream.write(pages.as_bytes());
            stream
        })
        .collect();
    served.is_alive();
    assert_eq!(unread.len(), many);
    assert_eq!(served.post("tile", &json!({ "scene": scene(), "z": 0, "x": 0, "y": 0 })).code, 200);
}

/// How long the owner may wait behind any number of connections that ask nothing. Where files are few, seven rows of them lose their places
/// in turn, after a quarter of a second each, on a machine that is busy with other tests; one that is not left while it is silent
/// keeps its place for 10 s.
#[cfg(unix)]
const SOON: Duration = Duration::from_secs(5);

/// Two thirds of them wait to be taken up; where files are few, nearly all.
#[cfg(unix)]
#[test]
fn the_owner_is_served_at_once_however_many_are_silent() {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let many = 1500;
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    if current.is_some_and(|current| current < 3 * many) {
        setrlimit(Resource::Nofile, Rlimit { current: Some(3 * many), maximum }).unwrap();
    }
    let few = || {
        let dir = TestDir::new();
        let mut command = Command::new("sh");
        command.args(["-c", "ulimit -n 300; exec \"$0\" explore"]).arg(assert_cmd::cargo::cargo_bin("mapgen"));
        let child = Served::start(command, &dir.path("."));
        Served::begun(dir, child)
    };
    for served in [Served::new(""), few()] {
        // They are there again as soon as they are left.
        let mut silent: Vec<TcpStream> = (0..many).map(|_| served.connect()).collect();
        for _ in 0..3 {
            let asked = Instant::now();
            served.is_alive();
            assert!(asked.elapsed() < SOON, "{:?}", asked.elapsed());
            silent.extend((0..100).map(|_| served.connect()));
        }
        assert_eq!(silent.len() as u64, many + 300);
    }
}

#[test]
fn clients_that_are_slow_keep_nobody_waiting_and_are_left() {
    let served = Served::new("");
    // Half a head; a head, and half a body; nothing at all.
    let half = format!("GET /{}/ HT", served.token);
    let (port, token) = (served.port, &served.token);
    let body = format!("POST /{token}/tile HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Length: 1000\r\n\r\n{{");
    let mut slow = Vec::new();
    for text in [half.as_str(), &body, ""] {
        for _ in 0..50 {
            let mut stream = served.connect();
            stream.write_all(text.as_bytes()).unwrap();
            slow.push(stream);
        }
    }
    served.is_alive();
    // A byte now and then is no reason to wait longer.
    for (i, stream) in slow.iter_mut().enumerate() {
        match read(stream) {
            Some(answer) => assert!(answer.code == 408 && (50..100).contains(&i), "{i}: {answer:?}"),
            None => assert!(!(50..100).contains(&i), "{i}"),
        }
    }
    served.is_alive();
}
