//! Who is served, and what is refused.

use std::io::Write;
use std::net::TcpStream;
use std::time::Duration;

use serde_json::{Value, json};

use crate::served::{Served, read, scene};

#[test]
fn nobody_is_served_who_does_not_show_the_token_or_comes_from_elsewhere() {
    let served = Served::new("");
    let (port, token) = (served.port, &served.token);
    let page = served.get("");
    assert!(page.code == 200 && page.body.starts_with(b"<!doctype html>"));
    for rule in
        ["content-security-policy: default-src 'none'", "referrer-policy: no-referrer", "cache-control: no-store"]
    {
        assert!(page.head.contains(rule), "{}", page.head);
    }
    assert!(token.len() == 32 && token.chars().all(|c| c.is_ascii_hexdigit()));
    let other = Served::new("");
    assert_ne!(other.token, *token);
    let ask =
        |method: &str, path: &str, headers: &str| served.raw(&format!("{method} {path} HTTP/1.1\r\n{headers}\r\n\r\n"));
    let host = format!("Host: 127.0.0.1:{port}");
    let home = format!("/{token}/");
    assert_eq!(ask("GET", &home, &format!("Host: localhost:{port}")).code, 200);
    for path in ["/", "/start", "//", &format!("/{}/", other.token), &home[..home.len() - 2], &format!("{home}../")] {
        assert!([403, 404].contains(&ask("GET", path, &host).code), "{path}");
    }
    assert!(ask("GET", "/", &host).refused(403).contains("the token is wrong"));
    for wrong in
        ["Host: example.org", "Host: 127.0.0.1", &format!("Host: evil.example:{port}"), &format!("Host: [::1]:{port}")]
    {
        ask("GET", &home, wrong).refused(421);
    }
    for origin in ["http://example.org", "null", "http://127.0.0.1:1", &format!("https://127.0.0.1:{port}")] {
        ask("GET", &home, &format!("{host}\r\nOrigin: {origin}")).refused(403);
        ask("POST", &format!("{home}tile"), &format!("{host}\r\nContent-Length: 2\r\nOrigin: {origin}\r\n\r\n{{}}"))
            .refused(403);
    }
    ask("GET", &home, &format!("{host}\r\nSec-Fetch-Site: cross-site")).refused(403);
    assert_eq!(ask("GET", &home, &format!("{host}\r\nOrigin: http://127.0.0.1:{port}")).code, 200);
    for method in ["PUT", "DELETE", "OPTIONS", "TRACE", "PATCH"] {
        ask(method, &home, &host).refused(405);
    }
    // Who is refused so leaves the place to others: the connection ends, and what else was asked on it is not looked at.
    for wrong in [host.clone(), "Host: example.org".to_owned()] {
        let mut stream = served.connect();
        let request = format!("GET / HTTP/1.1\r\n{wrong}\r\n\r\n");
        stream.write_all(request.repeat(2).as_bytes()).unwrap();
        let answer = read(&mut stream).unwrap();
        assert!([403, 421].contains(&answer.code) && answer.head.contains("connection: close"), "{answer:?}");
        assert!(read(&mut stream).is_none());
    }
    // Elsewhere on this machine nothing listens.
    if let Some(address) = own_address() {
        assert!(TcpStream::connect_timeout(&(address, port).into(), Duration::from_secs(5)).is_err(), "{address}");
    }
    served.is_alive();
}

/// An address of this machine that is not that of itself alone, if it has one.
fn own_address() -> Option<std::net::IpAddr> {
    let socket = std::net::UdpSocket::bind("0.0.0.0:0").ok()?;
    // Nothing is sent: this only asks which way it would go.
    socket.connect("192.0.2.1:9").ok()?;
    socket.local_addr().ok().map(|address| address.ip()).filter(|address| !address.is_loopback())
}

#[test]
fn every_file_of_the_page_is_there_and_loads_nothing_from_elsewhere() {
    let served = Served::new("");
    let (mut wanted, mut seen) = (vec![String::new()], Vec::new());
    while let Some(name) = wanted.pop() {
        let answer = served.get(&name);
        assert_eq!(answer.code, 200, "{name}");
        let text = String::from_utf8(answer.body).unwrap();
        // The name of the language that SVG is written in is asked of nobody.
        let plain = text.replace("http://www.w3.org/2000/svg", "");
        assert!(!plain.contains("http:") && !plain.contains("https:"), "{name}");
        for begin in [" from \"./", "src=\"", "rel=\"stylesheet\" href=\"", "rel=\"icon\" href=\""] {
            for piece in text.split(begin).skip(1) {
                let next = piece.split('"').next().unwrap().to_owned();
                if !seen.contains(&next) && !wanted.contains(&next) {
                    wanted.push(next);
                }
            }
        }
        seen.push(name);
    }
    assert!(seen.len() > 12, "{seen:?}");
    served.get("nothing.js").refused(404);
}

#[test]
fn what_is_no_question_is_refused_by_what_is_wrong_with_it() {
    let served = Served::new("");
    let tile = |z: Value, x: Value, y: Value| served.post("tile", &json!({ "scene": scene(), "z": z, "x": x, "y": y }));
    assert_eq!(tile(0.into(), 0.into(), 0.into()).code, 200);
    for (z, x, y, told) in [
        (json!(99), json!(0), json!(0), "z = 99 is out of range: give a whole number from 0 to "),
        (json!(4_294_967_295_u32), json!(0), json!(0), "z = 4294967295 is out of range"),
        (json!(0), json!(2), json!(0), "x = 2 is out of range: give a whole number from -1 to 1 with z = 0"),
        (json!(5), json!(0), json!(i64::MIN), "is out of range: give a whole number from -32 to 63 with z = 5"),
        (json!(-1), json!(0), json!(0), "invalid value"),
        (json!(1e30), json!(0), json!(0), "invalid type"),
        (json!("1"), json!(0), json!(0), "invalid type"),
        (json!(0), json!(0.5), json!(0), "invalid type"),
    ] {
        let message = tile(z, x, y).refused(400);
        assert!(message.contains(told), "{message}");
    }
    let with = |pointer: &str, new: Value| {
        let mut scene = scene();
        *scene.pointer_mut(pointer).unwrap() = new;
        served.post("view", &json!({ "scene": scene })).refused(400)
    };
    assert!(with("/model/asymmetry", json!(1.5)).starts_with("asymmetry = 1.5 is out of range"));
    assert!(with("/model/sites", json!(100_000_000)).contains("sites = 100000000 is out of range"));
    assert!(with("/model/sites", json!(5000)).contains("give at most 1001"));
    assert!(with("/compute/families", json!(["0+3+,0-x"])).contains("is not a family"));
    assert!(with("/compute/families", json!([])).contains("families is empty"));
    assert!(with("/sweep/x/to", json!(0.4)).contains("is not a range"));
    let mut line = scene();
    line["sweep"] = json!({ "x": scene()["sweep"]["x"] });
    line["model"]["gamma2"] = 0.1.into();
    assert!(served.post("view", &json!({ "scene": line })).refused(400).contains("has two axes"));
    let point = |which: &str, more: Value| {
        let mut asked = json!({ "model": { "sites": 6, "gamma1": 0.2, "gamma2": 0.1, "omega": 1.5, "asymmetry": 0.4 }, "which": which, "samples": 8 });
        asked.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        asked
    };
    assert_eq!(served.post("orbit", &point("double-sided", json!({}))).code, 200);
    for (asked, told) in [
        (point("many-sided", json!({})), "invalid value"),
        (point("--help", json!({})), "invalid value"),
        (point("0+9+,0-9-", json!({})), "--word"),
        (
            point("double-sided", json!({ "samples": 10_000_000 })),
            "samples = 10000000 is too many for a page: give at most 12500",
        ),
        (point("double-sided", json!({ "model": { "sites": 6 } })), "--gamma1"),
        (point("double-sided", json!({ "model": { "sites": 6, "scene": "/etc/passwd" } })), "model has no scene"),
        (point("double-sided", json!({ "model": { "sites": 100_000 } })), "give at most 1001"),
        // Neither a text nor a fraction passes by the limits of numbers.
        (point("double-sided", json!({ "model": { "sites": "100000" } })), "sites = \"100000\" is no whole number"),
        (point("double-sided", json!({ "model": { "sites": 100_000.0 } })), "sites = 100000.0 is no whole number"),
        (point("double-sided", json!({ "model": { "sites": 3, "layers": "9999" } })), "layers = \"9999\" is no whole"),
        (point("double-sided", json!({ "model": { "sites": 3, "layers": 999 } })), "give at most 1001"),
        (
            point("double-sided", json!({ "model": { "sites": 6, "omega": "1.5" } })),
            "omega = \"1.5\" is a text: give a number, without quotes",
        ),
        (point("double-sided", json!({ "model": { "sites": 6, "ends": 1 } })), "ends = 1 is no value of it"),
        (
            point("double-sided", json!({ "model": { "sites": 1000 }, "samples": 30_000 })),
            "samples = 30000 is too many for a page: give at most 75",
        ),
        (point("double-sided", json!({ "out": "elsewhere.csv" })), "unknown key"),
        // No word of a command line, which is made of these.
        (point("0+,0-\0", json!({})), "the character NUL"),
        (point("double\0-sided", json!({})), "the character NUL"),
        (point("double-sided", json!({ "model": { "sites": 6, "ends": "fr\0ee" } })), "the character NUL"),
    ] {
        let message = served.post("orbit", &asked).refused(400);
        assert!(message.contains(told), "{message}");
    }
    served.post("orbits", &json!({})).refused(404);
    // A resonance is no mistake of whoever asks.
    let resonance = json!({ "model": { "sites": 6, "gamma1": 2.25, "gamma2": 0.1, "omega": 1.5, "asymmetry": 0.4 } });
    assert!(served.post("orbit", &point("double-sided", resonance)).refused(422).contains("resonance"));
    for body in ["", "{", "[1,", "null", "\u{1}", "{\"scene\":{}}"] {
        served.raw(&served.request("POST", "tile", "", body)).refused(400);
    }
    served.is_alive();
}

#[test]
fn what_is_too_large_is_refused_before_it_is_read() {
    let served = Served::new("");
    let (port, token) = (served.port, &served.token);
    let head = format!("POST /{token}/tile HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n");
    // Told beforehand: refused without a byte of it.
    assert!(
        served
            .raw(&format!("{head}Content-Length: 1000000000000\r\n\r\n"))
            .refused(413)
            .contains("at most 65536 bytes")
    );
    // Not told.
    let mut chunked = format!("{head}Transfer-Encoding: chunked\r\n\r\n");
    (0..9).for_each(|_| chunked += &format!("2000\r\n{}\r\n", "x".repeat(0x2000)));
    served.raw(&chunked).refused(413);
    // Heads: of one line, and of many.
    assert!([414, 431].contains(&served.raw(&format!("GET /{} HTTP/1.1\r\n\r\n", "x".repeat(100_000))).code));
    let many: String = (0..200).map(|i| format!("X-{i}: {}\r\n", "y".repeat(1000))).collect();
    assert_eq!(served.raw(&format!("GET /{token}/ HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{many}\r\n")).code, 431);
    for nonsense in ["\0\0\0\0\r\n\r\n", "GET\r\n\r\n", "GET / HTTP/9.9\r\n\r\n"] {
        assert_eq!(served.raw(nonsense).code, 400, "{nonsense:?}");
    }
    served.is_alive();
}
