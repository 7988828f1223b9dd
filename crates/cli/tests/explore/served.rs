//! The explorer at work, and who asks it.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use vibrochain_testkit::TestDir;

/// How long an answer may take on a machine that is busy with other tests.
pub(crate) const PATIENCE: Duration = Duration::from_secs(120);

/// Waits until something is so.
#[track_caller]
pub(crate) fn until(what: &str, is: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is() {
        assert!(begun.elapsed() < PATIENCE, "in vain waited for: {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The explorer at work.
pub(crate) struct Served {
    pub(crate) dir: TestDir,
    pub(crate) child: Child,
    pub(crate) port: u16,
    pub(crate) token: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// An answer of HTTP.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) code: u16,
    pub(crate) head: String,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    /// What is said to the page alone has no form of its own; what is in it of the program is held against what that prints.
    pub(crate) fn json(&self) -> Value {
        let text = std::str::from_utf8(&self.body).unwrap();
        text.parse().unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    /// The message of a refusal, which must have this code.
    #[track_caller]
    pub(crate) fn refused(&self, code: u16) -> String {
        assert_eq!(self.code, code, "{self:?}");
        self.json()["error"].as_str().unwrap().to_owned()
    }
}

/// Reads an answer; nothing if the other side has hung up.
pub(crate) fn read(stream: &mut TcpStream) -> Option<Answer> {
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
    pub(crate) fn new(line: &str) -> Self {
        let dir = TestDir::new();
        fs::create_dir(dir.path("tmp")).unwrap();
        Self::on(dir, line)
    }

    pub(crate) fn on(dir: TestDir, line: &str) -> Self {
        let command = dir.command(&format!("explore{line}"));
        let temporary = dir.path("tmp");
        Self::begun(dir, Self::start(command, &temporary))
    }

    /// Starts the program, with its files in a folder.
    pub(crate) fn start(mut command: Command, temporary: &Path) -> Child {
        command.env("TMPDIR", temporary).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap()
    }

    /// The program that was started, once it has printed its address.
    pub(crate) fn begun(dir: TestDir, mut child: Child) -> Self {
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let rest = address.trim().strip_prefix("http://127.0.0.1:").unwrap();
        let (port, token) = rest.split_once('/').unwrap();
        let (port, token) = (port.parse().unwrap(), token.trim_end_matches('/').to_owned());
        Self { dir, child, port, token }
    }

    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends bytes as they are.
    pub(crate) fn raw(&self, request: &str) -> Answer {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).unwrap();
        read(&mut stream).unwrap_or_else(|| panic!("no answer to {}", request.lines().next().unwrap()))
    }

    pub(crate) fn request(&self, method: &str, name: &str, headers: &str, body: &str) -> String {
        let (port, token, length) = (self.port, &self.token, body.len());
        format!(
            "{method} /{token}/{name} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{headers}Content-Length: {length}\r\n\r\n{body}"
        )
    }

    pub(crate) fn get(&self, name: &str) -> Answer {
        self.raw(&self.request("GET", name, "", ""))
    }

    pub(crate) fn post(&self, name: &str, body: &Value) -> Answer {
        self.raw(&self.request("POST", name, "", &body.to_string()))
    }

    /// Sends a question, and does not wait for its answer.
    pub(crate) fn ask(&self, name: &str, body: &Value) -> TcpStream {
        let mut stream = self.connect();
        stream.write_all(self.request("POST", name, "", &body.to_string()).as_bytes()).unwrap();
        stream
    }

    /// Whether anything that computes has files, besides the mark of the explorer.
    pub(crate) fn has_files(&self) -> bool {
        let own: Vec<_> = fs::read_dir(self.dir.path("tmp")).unwrap().map(|one| one.unwrap().path()).collect();
        assert_eq!(own.len(), 1, "{own:?}");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            assert_eq!(fs::metadata(&own[0]).unwrap().permissions().mode() & 0o7777, 0o700);
        }
        fs::read_dir(&own[0]).unwrap().count() > 1
    }

    /// Still there, and not only on the connection that has been ill-treated.
    #[track_caller]
    pub(crate) fn is_alive(&self) {
        assert_eq!(self.get("").code, 200);
    }
}

pub(crate) fn scene() -> Value {
    json!({
        "model": { "sites": 6, "gamma1": 0.2, "asymmetry": 0.4 },
        "sweep": {
            "x": { "parameter": "omega", "from": 0.4, "to": 3.0, "points": 8 },
            "y": { "parameter": "gamma2", "from": 0.0, "to": 0.3, "points": 8 },
        },
        "compute": { "families": ["double-sided", "single-sided"], "stability": true },
    })
}
