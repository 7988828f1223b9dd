//! Who may ask: the page that this process has served, and nobody else. Other pages of the same browser can send requests to this machine,
//! and a name of theirs may be made to lead here; neither knows the token, and both are known by what the browser says of them.

use hyper::Method;
use hyper::header::{HOST, HeaderMap, ORIGIN};

use crate::refusal::Refusal;
use crate::token::Token;

/// What the browser says of who has asked.
const SITE: &str = "sec-fetch-site";

/// Ports from 1024 that browsers never connect to, by the Fetch standard's list of blocked ports.
const BLOCKED: [u16; 19] =
    [1719, 1720, 1723, 2049, 3659, 4045, 4190, 5060, 5061, 6000, 6566, 6665, 6666, 6667, 6668, 6669, 6679, 6697, 10080];

/// Refuses a port whose address no browser would open as it is printed.
///
/// # Errors
/// [`Refusal`] with the reason, and what to give.
pub fn port_will_do(port: u16) -> Result<(), Refusal> {
    let reason = match port {
        0 => return Ok(()),
        80 => "is that of HTTP itself, which browsers leave out of the address",
        1..1024 => "is the system's, and browsers refuse many of these",
        port if BLOCKED.contains(&port) => "is one that browsers refuse",
        _ => return Ok(()),
    };
    Err(Refusal::wrong(format!("--port {port} {reason}: give one from 1024 that is free, as 8080, or 0 for any")))
}

/// Whom requests must be addressed to.
#[derive(Debug, Clone)]
pub(crate) struct Guard {
    hosts: [String; 2],
    origins: [String; 2],
    token: Token,
}

impl Guard {
    pub(crate) fn new(port: u16, token: Token) -> Self {
        let hosts = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{port}"));
        let origins = hosts.each_ref().map(|host| format!("http://{host}"));
        Self { hosts, origins, token }
    }

    /// Where the page is.
    pub(crate) fn address(&self) -> String {
        format!("{}/{}/", self.origins[0], self.token.text())
    }

    /// What is asked for, of a request that may ask.
    ///
    /// # Errors
    /// [`Refusal`]: 421 for another host, 403 for another origin or a wrong token, 405 for a method that nothing here has.
    pub(crate) fn admit<'a>(&self, method: &Method, path: &'a str, headers: &HeaderMap) -> Result<&'a str, Refusal> {
        let one = |name: &str| {
            let mut all = headers.get_all(name).iter();
            let first = all.next();
            // Two of a kind are one too many: which of them counts?
            (first.map(|value| value.to_str().unwrap_or_default()), all.next().is_some())
        };
        let known = |all: &[String], given: &str| all.iter().any(|own| own == given);
        match one(HOST.as_str()) {
            (Some(host), false) if known(&self.hosts, host) => {}
            _ => return Err(Refusal::new(421, "this is not the host that was asked for")),
        }
        match one(ORIGIN.as_str()) {
            (None, _) => {}
            (Some(origin), false) if known(&self.origins, origin) => {}
            _ => return Err(Refusal::new(403, "requests of other pages are refused")),
        }
        if !matches!(one(SITE), (None | Some("same-origin" | "none"), false)) {
            return Err(Refusal::new(403, "requests of other pages are refused"));
        }
        if !matches!(*method, Method::GET | Method::POST) {
            return Err(Refusal::new(405, format!("{method} is not understood: GET and POST are")));
        }
        let wrong = || Refusal::new(403, "the token is wrong: open the address that mapgen has printed, all of it");
        let (token, rest) = path.strip_prefix('/').and_then(|path| path.split_once('/')).ok_or_else(wrong)?;
        if self.token.is(token) { Ok(rest) } else { Err(wrong()) }
    }
}

#[cfg(test)]
mod tests {
    use hyper::header::{HeaderName, HeaderValue};

    use super::*;

    fn ask(guard: &Guard, method: Method, path: &str, given: &[(&str, &str)]) -> Result<String, u16> {
        let mut headers = HeaderMap::new();
        for (name, value) in given {
            let name: HeaderName = name.parse().unwrap();
            headers.append(name, HeaderValue::from_str(value).unwrap());
        }
        guard.admit(&method, path, &headers).map(str::to_owned).map_err(|refusal| refusal.code)
    }

    #[test]
    fn a_port_whose_address_would_not_open_is_refused() {
        for port in [0, 1024, 8080, 32768, u16::MAX] {
            assert_eq!(port_will_do(port), Ok(()), "{port}");
        }
        for (port, told) in [(80, "HTTP itself"), (1, "the system's"), (443, "the system's"), (6667, "browsers refuse")]
        {
            let message = port_will_do(port).unwrap_err().message;
            assert!(message.contains(told) && message.contains("from 1024"), "{message}");
        }
    }

    #[test]
    fn only_the_page_itself_is_admitted() {
        let guard = Guard::new(8080, Token::random().unwrap());
        let home = guard.address();
        let path = home.strip_prefix("http://127.0.0.1:8080").unwrap();
        let host = ("host", "127.0.0.1:8080");
        let get = |path: &str, headers: &[(&str, &str)]| ask(&guard, Method::GET, path, headers);
        assert_eq!(get(path, &[host]), Ok(String::new()));
        assert_eq!(get(&format!("{path}tile"), &[("host", "localhost:8080")]), Ok("tile".to_owned()));
        let own = [("origin", "http://127.0.0.1:8080"), ("sec-fetch-site", "same-origin")];
        assert!(get(path, &[host, own[0], own[1]]).is_ok());
        for wrong in ["/", "", "/x/", "tile", "//", "/00000000000000000000000000000000/"] {
            assert_eq!(get(wrong, &[host]), Err(403), "{wrong}");
        }
        assert_eq!(get(path.trim_end_matches('/'), &[host]), Err(403));
        for other in
            ["", "127.0.0.1", "127.0.0.1:8081", "example.org", "example.org:8080", "127.0.0.1:8080.example.org"]
        {
            assert_eq!(get(path, &[("host", other)]), Err(421), "{other}");
        }
        assert_eq!(get(path, &[]), Err(421));
        assert_eq!(get(path, &[host, ("host", "example.org")]), Err(421));
        for other in ["null", "http://example.org", "https://127.0.0.1:8080", "http://127.0.0.1:8080.example.org"] {
            assert_eq!(get(path, &[host, ("origin", other)]), Err(403), "{other}");
        }
        for site in ["cross-site", "same-site"] {
            assert_eq!(get(path, &[host, ("sec-fetch-site", site)]), Err(403), "{site}");
        }
        for method in [Method::PUT, Method::DELETE, Method::OPTIONS, Method::CONNECT] {
            assert_eq!(ask(&guard, method, path, &[host]), Err(405));
        }
    }
}
