//! Connections: on this machine alone, so many at a time, none for ever.

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
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};
use vibrochain_lattice::Stop;

use crate::answers::Answers;
use crate::guard::Guard;
use crate::route::Desk;
use crate::token::Token;

/// Connections at a time; a browser opens six. So many more wait to be taken up, at no cost here; others are put off by the system.
const CONNECTIONS: usize = 256;
const WAITING: u32 = 1024;

/// How long a connection may be silent, or take for the head of a request.
const SILENCE: Duration = Duration::from_secs(10);

/// How long a connection is kept, and then how long what is under way may take: a client that reads no answers is left.
const LIFE: Duration = Duration::from_secs(900);

/// The most bytes of a request's head, and of what is read at once.
const BUFFER: usize = 16 << 10;

/// Threads that wait for computations: never more than are allowed at a time, which is at most a thread of the pool each.
const BLOCKING: usize = 2048;

/// How often the flag that ends it is looked at, and how long to wait where the system has no descriptors left.
const LOOK: Duration = Duration::from_millis(50);

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
        let desk = Arc::new(Desk::new(guard, answers, pool));
        runtime.block_on(async {
            let places = Arc::new(Semaphore::new(CONNECTIONS));
            while !stop.is_raised() {
                let Ok(Ok(place)) = timeout(LOOK, Arc::clone(&places).acquire_owned()).await else { continue };
                match timeout(LOOK, listener.accept()).await {
                    Ok(Ok((stream, _))) => {
                        let desk = Arc::clone(&desk);
                        tokio::spawn(async move {
                            connection(stream, &desk).await;
                            drop(place);
                        });
                    }
                    // No descriptors left, or a connection that has gone already.
                    Ok(Err(_)) => sleep(LOOK).await,
                    Err(_) => {}
                }
            }
        });
        // Connections are dropped, which stops what they wait for.
        runtime.shutdown_timeout(FAREWELL);
    }
}

async fn connection(stream: TcpStream, desk: &Desk) {
    // Answers are written whole: there is nothing to wait for.
    let _ = stream.set_nodelay(true);
    let service = service_fn(|request| async { Ok::<_, Infallible>(desk.respond(request).await) });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(SILENCE).max_buf_size(BUFFER);
    let mut connection = std::pin::pin!(http.serve_connection(TokioIo::new(stream), service));
    if timeout(LIFE, connection.as_mut()).await.is_err() {
        connection.as_mut().graceful_shutdown();
        let _ = timeout(LIFE, connection).await;
    }
}
