//! `mapgen explore`: who may ask, and that what is answered is what the program prints.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};
use vibrochain_floquet::Mechanism;
use vibrochain_maps::cell::{Class, Status};
use vibrochain_testkit::{Cells, Desk, written};

/// How long an answer may take on a machine that is busy with other tests.
const PATIENCE: Duration = Duration::from_secs(120);

/// Waits until something is so.
#[track_caller]
fn until(what: &str, is: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is() {
        assert!(begun.elapsed() < PATIENCE, "in vain waited for: {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The explorer at work.
struct Served {
    desk: Desk,
    child: Child,
    port: u16,
    token: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// An answer of HTTP.
#[derive(Debug)]
struct Answer {
    code: u16,
    head: String,
    body: Vec<u8>,
}

impl Answer {
    /// What is said to the page alone has no form of its own; what is in it of the program is held against what that prints.
    fn json(&self) -> Value {
        let text = std::str::from_utf8(&self.body).unwrap();
        text.parse().unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    /// The message of a refusal, which must have this code.
    #[track_caller]
    fn refused(&self, code: u16) -> String {
        assert_eq!(self.code, code, "{self:?}");
        self.json()["error"].as_str().unwrap().to_owned()
    }
}

/// Reads an answer; nothing if the other side has hung up.
fn read(stream: &mut TcpStream) -> Option<Answer> {
    let mut bytes = Vec::new();
    let mut byte = [0];
    while !bytes.ends_with(b"\r\n\r\n") {
        if stream.read(&mut byte).ok()? == 0 {
            return None;
        }
        bytes.push(byte[0]);
    }
    let head = String::from_utf8(bytes).unwrap().to_ascii_lowercase();
    let code = head.split(' ').nth(1).unwrap().parse().unwrap();
    let length = head.lines().find_map(|line| line.strip_prefix("content-length: ")).map_or(0, |n| n.parse().unwrap());
    let mut body = vec![0; length];
    stream.read_exact(&mut body).ok()?;
    Some(Answer { code, head, body })
}

impl Served {
    fn new(line: &str) -> Self {
        let desk = Desk::new();
        fs::create_dir(desk.path("tmp")).unwrap();
        Self::on(desk, line)
    }

    fn on(desk: Desk, line: &str) -> Self {
        let mut command = desk.command(&format!("explore{line}"));
        let mut child =
            command.env("TMPDIR", desk.path("tmp")).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let rest = address.trim().strip_prefix("http://127.0.0.1:").unwrap();
        let (port, token) = rest.split_once('/').unwrap();
        let (port, token) = (port.parse().unwrap(), token.trim_end_matches('/').to_owned());
        Self { desk, child, port, token }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends bytes as they are.
    fn raw(&self, request: &str) -> Answer {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).unwrap();
        read(&mut stream).unwrap_or_else(|| panic!("no answer to {}", request.lines().next().unwrap()))
    }

    fn request(&self, method: &str, name: &str, headers: &str, body: &str) -> String {
        let (port, token, length) = (self.port, &self.token, body.len());
        format!(
            "{method} /{token}/{name} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{headers}Content-Length: {length}\r\n\r\n{body}"
        )
    }

    fn get(&self, name: &str) -> Answer {
        self.raw(&self.request("GET", name, "", ""))
    }

    fn post(&self, name: &str, body: &Value) -> Answer {
        self.raw(&self.request("POST", name, "", &body.to_string()))
    }

    /// Sends a question, and does not wait for its answer.
    fn ask(&self, name: &str, body: &Value) -> TcpStream {
        let mut stream = self.connect();
        stream.write_all(self.request("POST", name, "", &body.to_string()).as_bytes()).unwrap();
        stream
    }

    /// Whether anything that computes has files.
    fn has_files(&self) -> bool {
        let own: Vec<_> = fs::read_dir(self.desk.path("tmp")).unwrap().map(|one| one.unwrap().path()).collect();
        assert_eq!(own.len(), 1, "{own:?}");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            assert_eq!(fs::metadata(&own[0]).unwrap().permissions().mode() & 0o7777, 0o700);
        }
        fs::read_dir(&own[0]).unwrap().count() > 0
    }

    /// Still there, and not only on the connection that has been ill-treated.
    #[track_caller]
    fn is_alive(&self) {
        assert_eq!(self.get("").code, 200);
    }
}

fn scene() -> Value {
    json!({
        "model": { "sites": 6, "gamma1": 0.2, "asymmetry": 0.4 },
        "sweep": {
            "x": { "parameter": "omega", "from": 0.4, "to": 3.0, "points": 8 },
            "y": { "parameter": "gamma2", "from": 0.0, "to": 0.3, "points": 8 },
        },
        "compute": { "families": ["double-sided", "single-sided"], "stability": true },
    })
}

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

/// The cell number `i` of a tile, as its row in a table has it.
fn row(tile: &[u8], cells: usize, i: usize) -> [String; 6] {
    let number = |k: usize| {
        let value = f64::from_le_bytes(tile[8 * (k * cells + i)..][..8].try_into().unwrap());
        if value.is_nan() { String::new() } else { format!("{:016x}", value.to_bits()) }
    };
    let byte = |k: usize| usize::from(tile[(16 + k) * cells + i]);
    let name = |names: &[&'static str], k: usize| names.get(byte(k)).map_or(String::new(), ToString::to_string);
    let classes: Vec<&str> = Class::ALL.iter().map(|class| class.name()).collect();
    let mechanisms: Vec<&str> = Mechanism::ALL.iter().map(|mechanism| mechanism.name()).collect();
    let statuses: Vec<&str> = Status::ALL.iter().map(|status| status.name()).collect();
    [name(&classes, 0), name(&mechanisms, 1), number(0), number(1), byte(3).to_string(), name(&statuses, 2)]
}

/// Through two programs, of which only one knows tiles.
#[test]
fn a_tile_is_to_the_bit_what_a_sweep_of_its_range_computes() {
    let served = Served::new(" --threads 2");
    let mut cases = Vec::new();
    let compute = |families: Value| json!({ "families": families, "stability": true });
    let forced = json!({ "sites": 5, "gamma1": 0.2, "asymmetry": 0.4, "amplitude": 0.1, "restitution": 0.9 });
    cases.push((
        scene(),
        vec![(0, 0, 0), (3, 3, 2), (3, 7, 7), (10, 380, 301), (20, 400_001, 314_159), (30, 1 << 29, 123_456_789)],
    ));
    let mut other = scene();
    (other["model"], other["compute"]) = (forced.clone(), compute(json!(["single-sided", "double-sided"])));
    cases.push((other.clone(), vec![(0, 0, 0), (6, 27, 22), (20, 500_000, 300_000)]));
    other["compute"]["threshold"] = 0.01.into();
    cases.push((other, vec![(2, 1, 1)]));
    let mut words = scene();
    (words["model"]["sites"], words["compute"]) = (8.into(), compute(json!(["0+3+,0-3-", "0+3-,0-3+"])));
    cases.push((words, vec![(1, 0, 0), (15, 12_345, 4321)]));
    let mut symmetric = scene();
    (symmetric["model"]["asymmetry"], symmetric["compute"]) = (0.0.into(), compute(json!(["double-sided-symmetric"])));
    cases.push((symmetric, vec![(4, 5, 9)]));
    let mut existence = scene();
    existence["compute"] = json!({ "families": ["double-sided"] });
    cases.push((existence, vec![(20, 1_048_575, 0)]));
    let mut turned = scene();
    turned["model"] = json!({ "sites": 5, "gamma1": 0.2, "gamma2": 0.1, "omega": 1.07, "restitution": 0.25 });
    turned["sweep"] = json!({
        "x": { "parameter": "amplitude", "from": 0.1, "to": 0.3, "points": 2 },
        "y": { "parameter": "asymmetry", "from": 0.5, "to": 0.9, "points": 2 },
    });
    turned["compute"] = compute(json!(["single-sided"]));
    cases.push((turned, vec![(0, 0, 0), (20, 300_000, 700_000)]));

    let (mut tiles, mut classes, mut compared) = (0, std::collections::BTreeSet::new(), 0);
    for (scene, places) in cases {
        for (z, x, y) in places {
            let answer = served.post("tile", &json!({ "scene": scene, "z": z, "x": x, "y": y }));
            assert_eq!(answer.code, 200, "{answer:?}");
            const SIDE: usize = 64;
            assert_eq!(answer.body.len(), SIDE * SIDE * 20);
            // Where the tile is, worked out anew.
            let mut range = scene.clone();
            for (axis, number) in [("x", x), ("y", y)] {
                let end = |key: &str| scene["sweep"][axis][key].as_f64().unwrap();
                let step = (end("to") - end("from")) / (SIDE as f64 * 2f64.powi(z));
                let at = |cell: f64| end("from") + (f64::from(number) * SIDE as f64 + cell + 0.5) * step;
                let own = &mut range["sweep"][axis];
                (own["from"], own["to"], own["points"]) = (at(0.0).into(), at(63.0).into(), SIDE.into());
            }
            fs::write(served.desk.path("tile.json"), range.to_string()).unwrap();
            served.desk.run("sweep tile.json --out tile.csv --quiet").with(0, &[]);
            let text = String::from_utf8(served.desk.read("tile.csv")).unwrap();
            let mut lines = text.lines();
            let header: Vec<&str> = lines.next().unwrap().split(',').collect();
            let column = |name: &str| header.iter().position(|own| *own == name).unwrap();
            let columns = ["class", "mechanism", "spectral_radius", "margin", "solutions", "status"].map(column);
            let bits =
                |text: &str| text.parse::<f64>().map_or(String::new(), |value| format!("{:016x}", value.to_bits()));
            for (i, line) in lines.enumerate() {
                let fields: Vec<&str> = line.split(',').collect();
                let [class, mechanism, radius, margin, solutions, status] = columns.map(|column| fields[column]);
                let expected =
                    [class.into(), mechanism.into(), bits(radius), bits(margin), solutions.into(), status.into()];
                assert_eq!(row(&answer.body, SIDE * SIDE, i), expected, "{z}/{x}/{y}, cell {i}");
                classes.insert(class.to_owned());
                compared += 1;
            }
            tiles += 1;
        }
    }
    assert_eq!((tiles, compared), (16, 16 * 64 * 64));
    assert!(classes.len() >= 8, "{classes:?}");
}

/// The colours of numbers are those of `sweep --color`, for the cells of a tile: each by its own number, and the scale with its ticks.
#[test]
fn numbers_have_the_colours_of_a_sweep() {
    const SIDE: usize = 64;
    let served = Served::new("");
    let start = served.get("start").json();
    let rgb = |value: &Value| {
        let number = value.as_u64().unwrap();
        [number >> 16, number >> 8 & 255, number & 255].map(|part| part as u8)
    };
    let colours: Vec<[u8; 3]> = start["colours"]["scale"].as_array().unwrap().iter().map(rgb).collect();
    let below = rgb(&start["colours"]["below"]);
    let (mut numbers, mut none, mut lower) = (0, 0, 0);
    for (asymmetry, z) in [(0.4, 0), (0.1, 3)] {
        let mut scene = scene();
        scene["model"]["asymmetry"] = asymmetry.into();
        let tile = served.post("tile", &json!({ "scene": scene, "z": z, "x": (1 << z) / 2, "y": (1 << z) / 2 }));
        let mut own = scene.clone();
        for axis in ["x", "y"] {
            let [from, to] = ["from", "to"].map(|end| scene["sweep"][axis][end].as_f64().unwrap());
            let step = (to - from) / (SIDE as f64 * 2f64.powi(z));
            let first = f64::from((1 << z) / 2) * SIDE as f64;
            let at = |cell: f64| from + (first + cell + 0.5) * step;
            own["sweep"][axis]["from"] = at(0.0).into();
            own["sweep"][axis]["to"] = at(63.0).into();
            own["sweep"][axis]["points"] = SIDE.into();
        }
        fs::write(served.desk.path("own.json"), own.to_string()).unwrap();
        for color in ["spectral_radius", "margin", "solutions"] {
            let line = format!("sweep own.json --out own.csv --png own.png --svg own.svg --color {color} --quiet");
            served.desk.run(&line).with(0, &[]);
            let drawn = Cells::of(&served.desk.read("own.png"), SIDE as u32, SIDE as u32);
            let scale = served.post("scale", &json!({ "scene": own, "color": color })).json();
            let [from, to] = [0, 1].map(|i| scale["ends"][i].as_f64().unwrap());
            let svg = String::from_utf8(served.desk.read("own.svg")).unwrap();
            let words: Vec<String> = vibrochain_testkit::svg::texts(&svg).into_iter().map(|(_, text)| text).collect();
            let ticks = scale["ticks"].as_array().unwrap();
            let mut told: Vec<&str> = ticks.iter().map(|tick| tick[1].as_str().unwrap()).collect();
            told.extend([&scale["heading"], &scale["below"]].into_iter().filter_map(Value::as_str));
            assert!(
                told.len() > 1 && told.iter().all(|text| words.iter().any(|word| word == text)),
                "{told:?} {words:?}"
            );
            for i in 0..SIDE * SIDE {
                let number = |at: usize| f64::from_le_bytes(tile.body[at + 8 * i..at + 8 * i + 8].try_into().unwrap());
                let seen = drawn.of_cell(i, SIDE);
                let value = match color {
                    "spectral_radius" => f64::from((number(0) - 1.0) as f32),
                    "margin" => f64::from(number(8 * SIDE * SIDE) as f32),
                    _ => Some(tile.body[19 * SIDE * SIDE + i]).filter(|count| *count > 0).map_or(f64::NAN, f64::from),
                };
                if value.is_nan() {
                    assert_eq!(seen, [255; 3], "{color} {i}");
                    none += 1;
                    continue;
                }
                let place = if scale["logarithm"] == true { value.log10() } else { value };
                if scale["logarithm"] == true && (place.is_nan() || place < from) {
                    assert_eq!(seen, below, "{color} {i}");
                    lower += 1;
                    continue;
                }
                // Between two steps of the scale that is handed over.
                let step = ((place - from) / (to - from)).clamp(0.0, 1.0) * (colours.len() - 1) as f64;
                let near = colours[step.round() as usize];
                assert!(seen.iter().zip(near).all(|(a, b)| a.abs_diff(b) <= 1), "{color} {i} {seen:?} {near:?}");
                numbers += 1;
            }
        }
    }
    assert!(numbers > 8000 && none > 1000 && lower > 500, "{numbers} {none} {lower}");
    assert_eq!(numbers + none + lower, 2 * 3 * SIDE * SIDE);
    let mut bare = scene();
    bare["compute"]["stability"] = false.into();
    let refused =
        |scene: &Value, color: &str| served.post("scale", &json!({ "scene": scene, "color": color })).refused(400);
    assert!(refused(&bare, "spectral_radius").contains("add stability = true"));
    assert!(refused(&scene(), "impulse").contains("give spectral_radius, margin, solutions"));
    bare["sweep"]["x"]["points"] = 100_000.into();
    assert!(refused(&bare, "margin").contains("give at most 32768"));
}

/// What lies beyond the ends of a parameter's range is told apart, and costs no tile.
#[test]
fn a_tile_beyond_the_model_says_so() {
    let served = Served::new("");
    let answer = served.post("tile", &json!({ "scene": scene(), "z": 0, "x": 0, "y": -1 }));
    let status = &answer.body[18 * 4096..19 * 4096];
    assert!(answer.code == 200 && status.iter().all(|status| *status == 255));
}

const MODEL: &str = "--sites 6 --gamma1 0.2 --gamma2 0.15 --omega 1.6 --asymmetry 0.4";
const FORCED: &str =
    "--sites 5 --gamma1 0.2 --gamma2 0.1 --omega 1.5 --asymmetry 0.4 --amplitude 0.1 --restitution 0.9";
const HARMONICS: &str =
    "--sites 5 --gamma1 0.2 --gamma2 0.1 --omega 1.5 --asymmetry 0.4 --force 1:0.1:0,3:-0.033:0 --restitution 0.9";
const LAYERS: &str =
    "--sites 6 --ends free --layers 2 --gamma1 0.2 --gamma2 0.05 --gamma3 0.05 --omega 1.5 --asymmetry 0.2";

/// The model that flags give, as the page has it.
fn model(flags: &str) -> Map<String, Value> {
    let words: Vec<&str> = flags.split(' ').collect();
    let pair = |pair: &[&str]| {
        let value = match pair[0] {
            "--force" => {
                json!([{ "harmonic": 1, "amplitude": 0.1, "phase": 0.0 }, { "harmonic": 3, "amplitude": -0.033 }])
            }
            "--sites" | "--layers" => pair[1].parse::<u64>().unwrap().into(),
            _ => pair[1].parse::<f64>().map_or_else(|_| pair[1].into(), Value::from),
        };
        (pair[0][2..].to_owned(), value)
    };
    words.chunks(2).map(pair).collect()
}

#[test]
fn an_orbit_is_what_mapgen_orbit_prints() {
    let served = Served::new("");
    let mut solutions = 0;
    for (flags, which) in [
        (MODEL, "double-sided"),
        (MODEL, "single-sided"),
        (FORCED, "double-sided"),
        (HARMONICS, "double-sided"),
        (FORCED, "period-doubled"),
        (LAYERS, "0:0+0:1+,0:0-0:1-"),
        (MODEL, "0+3+,0-3-"),
    ] {
        let asked = json!({ "model": model(flags), "which": which, "samples": 16 });
        let answer = served.post("orbit", &asked);
        assert_eq!(answer.code, 200, "{answer:?}");
        let answer = answer.json();
        let flag = if which.contains('+') { "--word" } else { "--family" };
        let printed =
            served.desk.run(&format!("orbit {flag} {which} {flags} --json --trajectory own.csv --samples 16"));
        assert_eq!(answer["answer"], written(&printed.out), "{flags} {which}");
        assert_eq!(answer["files"]["orbit.csv"].as_str().unwrap().as_bytes(), served.desk.read("own.csv"));
        // And so does the line that it says.
        let line = answer["command"].as_str().unwrap();
        let again = served.desk.shell(line).with(0, &[]);
        assert_eq!(again.out, printed.out, "{line}");
        assert_eq!(answer["python"].as_array().unwrap().len(), answer["answer"]["solutions"].as_array().unwrap().len());
        solutions += answer["python"].as_array().unwrap().len();
    }
    assert!(solutions >= 8, "{solutions}");
}

#[test]
fn a_run_is_what_mapgen_simulate_prints() {
    let served = Served::new("");
    for (perturb, direction) in [(0.0, "random"), (1e-3, "random"), (1e-4, "unstable")] {
        let asked = json!({
            "model": model(FORCED), "which": "double-sided", "samples": 8, "solution": 1,
            "perturb": perturb, "direction": direction, "seed": 5, "periods": 12.5,
        });
        let answer = served.post("simulate", &asked);
        assert_eq!(answer.code, 200, "{answer:?}");
        let answer = answer.json();
        let pushed = if perturb == 0.0 {
            String::new()
        } else {
            format!("--perturb {perturb} --direction {direction} --seed 5 ")
        };
        let line = format!(
            "simulate --family double-sided {FORCED} --solution 1 {pushed}--periods 12.5 --samples 8 --json --trajectory a.csv --impacts b.csv"
        );
        let printed = served.desk.run(&line).with(0, &[]);
        assert_eq!(answer["answer"], written(&printed.out));
        for (own, name) in [("a.csv", "run.csv"), ("b.csv", "impacts.csv")] {
            assert_eq!(answer["files"][name].as_str().unwrap().as_bytes(), served.desk.read(own));
        }
        let again = served.desk.shell(answer["command"].as_str().unwrap()).with(0, &[]);
        assert_eq!(again.out, printed.out);
    }
    let endless = json!({
        "model": model(FORCED), "which": "double-sided", "samples": 64, "solution": 1,
        "perturb": 0.0, "direction": "random", "seed": 1, "periods": 1e9,
    });
    assert!(served.post("simulate", &endless).refused(400).contains("periods = 1000000000 is too many"));
    let stable = json!({
        "model": model("--sites 6 --gamma1 0.2 --gamma2 0.01 --omega 2.5 --asymmetry 0.4"), "which": "double-sided", "samples": 4,
        "solution": 1, "perturb": 1e-3, "direction": "unstable", "seed": 1, "periods": 3.0,
    });
    assert!(served.post("simulate", &stable).refused(400).contains("this breather is stable"));
}

#[test]
fn lines_pictures_and_tables_are_those_of_the_program() {
    let served = Served::new("");
    let mut scene = scene();
    for (axis, points) in [("x", 30), ("y", 20)] {
        scene["sweep"][axis]["points"] = points.into();
    }
    fs::write(served.desk.path("own.json"), scene.to_string()).unwrap();
    let sweep = served.post("sweep", &json!({ "scene": scene })).json();
    served.desk.run("sweep own.json --out own.csv --svg own.svg --quiet").with(0, &[]);
    assert_eq!(sweep["files"]["map.csv"].as_str().unwrap().as_bytes(), served.desk.read("own.csv"));
    assert_eq!(sweep["files"]["map.svg"].as_str().unwrap().as_bytes(), served.desk.read("own.svg"));

    let margin = served.post("sweep", &json!({ "scene": scene, "color": "margin" })).json();
    served.desk.run("sweep own.json --out own.csv --svg margin.svg --color margin --quiet").with(0, &[]);
    assert_eq!(margin["files"]["map.svg"].as_str().unwrap().as_bytes(), served.desk.read("margin.svg"));
    assert!(served.post("sweep", &json!({ "scene": scene, "color": "hue" })).refused(400).contains("hue"));

    let texts = served.post("texts", &json!({ "scene": scene })).json();
    fs::write(served.desk.path("view.toml"), texts["scene"].as_str().unwrap()).unwrap();
    served.desk.shell(texts["command"].as_str().unwrap()).with(0, &[]);
    assert_eq!(served.desk.read("map.csv"), served.desk.read("own.csv"));
    assert!(texts["python"].as_str().unwrap().contains("vc.sweep(\"view.toml\")"));

    let curves = served.post("curves", &json!({ "scene": scene, "tolerance": 1e-3, "places": 0 })).json();
    let printed = served.desk.run("curves own.json --json --tolerance 1e-3 --places 0");
    assert_eq!(curves["answer"], written(&printed.out));
    assert!(curves["answer"]["borders"].as_array().unwrap().len() > 3);

    let stripes = served.post("stripes", &json!({ "scene": scene })).json();
    served.desk.run("stripes own.json --csv stripes.csv --plot stripes.png").with(0, &[]);
    assert_eq!(stripes["files"]["stripes.csv"].as_str().unwrap().as_bytes(), served.desk.read("stripes.csv"));

    scene["sweep"]["x"]["points"] = 100_000.into();
    assert!(served.post("sweep", &json!({ "scene": scene })).refused(400).contains("points = 100000 is out of range"));
    scene["sweep"]["x"]["points"] = 30.into();
    scene["model"]["amplitude"] = 0.1.into();
    scene["model"]["restitution"] = 0.9.into();
    assert!(served.post("stripes", &json!({ "scene": scene })).refused(400).contains("without force"));
}

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
fn long_borders() -> Value {
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

/// What cannot remove its files any more has them removed: by what it has started, or by the next explorer.
#[cfg(unix)]
#[test]
fn an_explorer_that_is_killed_leaves_nothing_running_and_no_files_for_long() {
    let mut served = Served::new("");
    let asked = served.ask("curves", &long_borders());
    until("borders under way", || served.has_files());
    // Its folder is there before the program that fills it: a kill between the two leaves nobody to remove it but the next explorer.
    std::thread::sleep(std::time::Duration::from_millis(500));
    served.child.kill().unwrap();
    served.child.wait().unwrap();
    let left = |served: &Served| fs::read_dir(served.desk.path("tmp")).unwrap().count();
    // The program that computes them removes them when it ends.
    until("the end of what it has started", || left(&served) == 0);
    drop(asked);
    let mut served = Served::new("");
    served.is_alive();
    served.child.kill().unwrap();
    served.child.wait().unwrap();
    assert_eq!(left(&served), 1);
    let desk = std::mem::replace(&mut served.desk, Desk::new());
    let next = Served::on(desk, "");
    next.is_alive();
    assert_eq!(left(&next), 1);
    assert!(!next.has_files());
}

/// More connections than are served at a time, none of which asks, or none of which reads what it has asked for.
#[test]
fn the_owner_is_served_whoever_keeps_connections() {
    let served = Served::new("");
    let many = 400;
    let silent: Vec<TcpStream> = (0..many).map(|_| served.connect()).collect();
    served.is_alive();
    assert_eq!(silent.len(), many);
    drop(silent);
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

#[cfg(unix)]
#[test]
fn it_ends_well_by_ctrl_c_and_says_why_it_cannot_begin() {
    let desk = Desk::with_scene(
        "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\ngamma2 = 0.1\n[sweep]\n\
        x = { parameter = \"omega\", from = 0.6, to = 2.0, points = 30 }\n[compute]\nfamilies = [\"double-sided\"]\n",
    );
    desk.run("explore scene.toml").with(2, &["scene.toml: a map to fly over has two axes"]);
    desk.run("explore none.toml").with(2, &["none.toml"]);
    desk.run("explore --port 65536").with(2, &["--port", "too large"]);
    // An address that no browser opens as it is printed is not printed.
    desk.run("explore --port 80").with(2, &["--port 80 is that of HTTP itself", "give one from 1024"]);
    desk.run("explore --port 6000").with(2, &["--port 6000 is one that browsers refuse"]);
    let served = Served::new("");
    desk.run(&format!("explore --port {}", served.port)).with(1, &[&format!("cannot serve on port {}", served.port)]);
    if vibrochain_testkit::interrupts_are_ignored() {
        return;
    }
    // With work under way, and a connection that is kept open.
    fs::create_dir(desk.path("tmp")).unwrap();
    let mut command = desk.command("explore --port 0");
    let mut child =
        command.env("TMPDIR", desk.path("tmp")).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut address = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
    let rest = address.trim().strip_prefix("http://").unwrap();
    let (host, path) = rest.split_once('/').unwrap();
    let mut stream = TcpStream::connect(host).unwrap();
    let mut slow = scene();
    slow["model"]["sites"] = 1001.into();
    let tile = json!({ "scene": slow, "z": 6, "x": 30, "y": 10 });
    let mut second = TcpStream::connect(host).unwrap();
    for (stream, name, body) in [(&mut stream, "tile", tile), (&mut second, "curves", long_borders())] {
        let body = body.to_string();
        let head = format!("POST /{path}{name} HTTP/1.1\r\nHost: {host}\r\nContent-Length: {}", body.len());
        stream.write_all(format!("{head}\r\n\r\n{body}").as_bytes()).unwrap();
    }
    // One folder of all, in it that of the borders, in that their scene.
    let entries = |folder: &Path| -> Vec<_> { fs::read_dir(folder).unwrap().map(|one| one.unwrap().path()).collect() };
    until("borders under way", || {
        entries(&desk.path("tmp")).iter().any(|own| entries(own).iter().any(|one| one.join("view.toml").exists()))
    });
    vibrochain_testkit::signal(child, "INT").with(0, &["open this address in a browser"]);
    assert_eq!(entries(&desk.path("tmp")).len(), 0);
}

/// The map of a structure: a tile has the classes that a sweep of its cells' values writes, and a point the orbits that `orbit` prints.
#[test]
fn a_structure_is_flown_over_as_it_is_swept() {
    let desk = Desk::new();
    let scene = |limits: [[f64; 2]; 2], points: usize| {
        let axis = |name: &str, [from, to]: [f64; 2]| {
            format!("{{ parameter = \"{name}\", from = {from:?}, to = {to:?}, points = {points} }}")
        };
        format!(
            "title = \"oscillator\"\nomega = 2\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[0.1]]\n[[contact]]\nat = 0\n\
             upper = 0.1\nrestitution = 0.8\n[force]\nload = [1]\n[sweep]\nx = {}\ny = {}\n[compute]\nfamilies = [\"0+\", \"0+,0+/2\"]\n",
            axis("omega", limits[0]),
            axis("contact.0.upper", limits[1])
        )
    };
    fs::write(desk.path("map.toml"), scene([[0.5, 4.5], [0.05, 0.45]], 9)).unwrap();
    fs::create_dir(desk.path("tmp")).unwrap();
    let served = Served::on(desk, " map.toml");
    let page = served.get("");
    assert!(page.code == 200 && String::from_utf8(page.body).unwrap().contains("structure.js"));
    for file in ["structure.js", "ask.js", "dom.js", "plane.js", "style.css"] {
        assert_eq!(served.get(file).code, 200, "{file}");
    }
    let start = served.get("start").json();
    assert_eq!(start["words"], json!(["0+", "0+,0+/2"]));
    assert_eq!(start["axes"][1], json!({ "name": "contact.0.upper", "from": 0.05, "to": 0.45 }));
    let side = usize::try_from(start["side"].as_u64().unwrap()).unwrap();
    let tile = served.post("cells", &json!({ "z": 2, "x": 1, "y": 2 })).json();
    let step = [4.0 / (4.0 * side as f64), 0.4 / (4.0 * side as f64)];
    let first = [1.5 + 0.5 * step[0], 0.25 + 0.5 * step[1]];
    let last = [0, 1].map(|i| first[i] + (side - 1) as f64 * step[i]);
    fs::write(served.desk.path("tile.toml"), scene([[first[0], last[0]], [first[1], last[1]]], side)).unwrap();
    served.desk.run("sweep tile.toml --out tile.csv").with(0, &[]);
    let table = fs::read_to_string(served.desk.path("tile.csv")).unwrap();
    let mut lines = table.lines();
    assert!(lines.next().unwrap().starts_with("omega,contact.0.upper,class,word,"));
    let cells = tile["cells"].as_array().unwrap();
    let (mut count, mut seen) = (0, std::collections::BTreeSet::new());
    for (line, cell) in lines.zip(cells) {
        let class = tile["classes"][usize::try_from(cell.as_u64().unwrap()).unwrap()].as_str().unwrap();
        let (how, word) = class.split_once(' ').unwrap_or((class, ""));
        let word = if word.contains(',') { format!("\"{word}\"") } else { word.to_owned() };
        assert!(line.contains(&format!(",{how},{word},")), "{line} {class}");
        seen.insert(class.to_owned());
        count += 1;
    }
    assert!(count == side * side && cells.len() == count && seen.len() > 2, "{count} {seen:?}");
    let told = served.post("orbits", &json!({ "at": [2.325, 0.1] })).json();
    assert_eq!(told.as_array().unwrap().len(), 2);
    let own = written(
        &served
            .desk
            .run("orbit --scene map.toml --word 0+ --set omega=2.325 --set contact.0.upper=0.1 --json")
            .with(0, &[])
            .out,
    );
    assert_eq!(told[0]["answer"]["solutions"], own["solutions"]);
    assert!(told[0]["files"]["orbit.svg"].as_str().unwrap().contains("<svg"));
    for (question, asked) in [
        ("cells", json!({ "z": 41, "x": 0, "y": 0 })),
        ("cells", json!({ "z": 1, "x": 4, "y": 0 })),
        ("orbits", json!({ "at": [1] })),
    ] {
        assert_eq!(served.post(question, &asked).code, 400, "{question} {asked}");
    }
    served.post("tile", &json!({ "scene": {}, "z": 0, "x": 0, "y": 0 })).refused(400);
    // What cannot be flown over.
    let desk = Desk::new();
    fs::write(desk.path("line.toml"), scene([[0.5, 4.5], [0.05, 0.45]], 9).replace("\ny = ", "\n# y = ")).unwrap();
    desk.run("explore line.toml").with(2, &["two axes"]);
}
