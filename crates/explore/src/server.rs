//! Connections: on this machine alone, so many at a time, none that is silent for ever.

use std::convert::Infallible;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use rayon::ThreadPool;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::task::{AbortHandle, yield_now};
use tokio::time::{sleep, timeout};
use vibrochain_lattice::Stop;

use crate::answers::Answers;
use crate::connection::Connection;
use crate::guard::Guard;
use crate::route::Service;
use crate::token::Token;

/// Connections at a time; a browser opens six. With all that one may send before it is refused they take 100 MB.
const CONNECTIONS: usize = 1024;

/// So many more wait to be taken up, at no cost here. What comes beyond these the system drops, and whoever has asked tries again only
/// after a second.
const WAITING: u32 = 4096;

/// How long a connection may take for the head of a request.
const HEAD: Duration = Duration::from_secs(10);

/// How long a connection may be silent, whatever it waits for: that it asks, or that it reads its answer. Longer than a head or a body may
/// take, which are refused with a word.
const SILENCE: Duration = Duration::from_secs(15);

/// The most bytes of a request's head, and of what is read at once.
const BUFFER: usize = 16 << 10;

/// Threads that wait for computations: never more than are allowed at a time, which is at most a thread of the pool each.
const BLOCKING: usize = 2048;

/// How often the flag that ends it is looked at, and how long to wait where no place is free.
const LOOK: Duration = Duration::from_millis(50);
const PAUSE: Duration = Duration::from_millis(5);

/// How long computations may take to end with the server.
const FAREWELL: Duration = Duration::from_secs(5);

/// The explorer, at its address.
#[derive(Debug)]
pub struct Explorer {
    runtime: Runtime,
    listener: TcpListener,
    guard: Guard,
}

impl Explorer {
    /// Takes `port` of 127.0.0.1, or a free one for 0.
    ///
    /// # Errors
    /// Those of the system: a port that is taken, no randomness.
    pub fn open(port: u16) -> io::Result<Self> {
        let runtime = Builder::new_current_thread().enable_io().enable_time().max_blocking_threads(BLOCKING).build()?;
        let listener = {
            let _inside = runtime.enter();
            let socket = TcpSocket::new_v4()?;
            // The port of an explorer that has just ended may be taken again at once. (On Windows this would take it from one at work.)
            #[cfg(unix)]
            socket.set_reuseaddr(true)?;
            socket.bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))?;
            socket.listen(WAITING)?
        };
        let guard = Guard::new(listener.local_addr()?.port(), Token::random()?);
        Ok(Self { runtime, listener, guard })
    }

    /// Where the page is, with the token: `http://127.0.0.1:PORT/TOKEN/`.
    #[must_use]
    pub fn address(&self) -> String {
        self.guard.address()
    }

    /// Serves until `stop` is raised. Tiles are computed on `pool`.
    pub fn serve(self, answers: Arc<dyn Answers>, pool: ThreadPool, stop: &Stop) {
        let Self { runtime, listener, guard } = self;
        let service = Arc::new(Service::new(guard, answers, pool));
        runtime.block_on(async {
            let mut places = Places { all: Vec::new(), most: CONNECTIONS.min(descriptors(2 * CONNECTIONS) / 2) };
            while !stop.is_raised() {
                if !places.have_room() {
                    // What has arrived meanwhile is looked at first.
                    sleep(PAUSE).await;
                    if !places.have_room() {
                        places.give_way();
                        continue;
                    }
                }
                match timeout(LOOK, listener.accept()).await {
                    Ok(Ok((stream, _))) => {
                        let (service, one) = (Arc::clone(&service), Arc::new(Connection::new()));
                        let own = Arc::clone(&one);
                        let task = tokio::spawn(async move { serve(stream, &service, &own).await });
                        places.all.push((task.abort_handle(), one));
                        // What it asks is looked at before the next one is taken up, which may want its place.
                        yield_now().await;
                    }
                    // No descriptors left, or a connection that has gone already.
                    Ok(Err(_)) => {
                        places.give_way();
                        sleep(PAUSE).await;
                    }
                    Err(_) => {}
                }
            }
            // Connections are dropped, which stops what they wait for. Those that are told so go when they are looked at next.
            for (task, _) in &places.all {
                task.abort();
            }
            while places.all.iter().any(|(task, _)| !task.is_finished()) {
                yield_now().await;
            }
        });
        runtime.shutdown_timeout(FAREWELL);
    }
}

/// The connections there are.
struct Places {
    all: Vec<(AbortHandle, Arc<Connection>)>,
    /// How many there may be.
    most: usize,
}

impl Places {
    /// Whether there is room for one more. Who has been silent for too long is left.
    fn have_room(&mut self) -> bool {
        self.all.retain(|(task, one)| {
            if one.silent() > Some(SILENCE) {
                task.abort();
            }
            !task.is_finished()
        });
        self.all.len() < self.most
    }

    /// Leaves all connections that are idle, so that others can have their places. One at a time, those who wait behind a thousand silent
    /// ones would wait for seconds; a browser opens a connection anew without a word.
    fn give_way(&mut self) {
        self.all.retain(|(task, one)| {
            let idle = one.is_idle();
            if idle {
                task.abort();
            }
            !idle
        });
    }
}

/// How many files and connections this process may have open: `wanted` of them, where the system lets it.
#[cfg(unix)]
fn descriptors(wanted: usize) -> usize {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let all = |limit: Option<u64>| limit.and_then(|limit| usize::try_from(limit).ok()).unwrap_or(usize::MAX);
    let more = wanted.min(all(maximum));
    if all(current) >= more || setrlimit(Resource::Nofile, Rlimit { current: Some(more as u64), maximum }).is_err() {
        return all(current);
    }
    more
}

#[cfg(not(unix))]
fn descriptors(wanted: usize) -> usize {
    wanted
}

async fn serve(stream: TcpStream, service: &Service, connection: &Connection) {
    // Answers are written whole: there is nothing to wait for.
    let _ = stream.set_nodelay(true);
    let service = service_fn(|request| async {
        connection.heard();
        let response = service.respond(request, connection).await;
        connection.heard();
        Ok::<_, Infallible>(response)
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD).max_buf_size(BUFFER);
    // A connection that ends badly has been left by the other side.
    let _ = http.serve_connection(TokioIo::new(stream), service).await;
}
