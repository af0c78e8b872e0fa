//! The page's server: a thread of its own, connections that are limited in number, size and time.

use std::io;
use std::net::{IpAddr, SocketAddr, TcpListener};
use std::pin::pin;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use axum::Router;
use encoring_station::{Permission, ShownRing};
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpStream;
use tokio::sync::{Semaphore, watch};
use tokio::task::JoinSet;
use tokio::time::{Duration, sleep};

use crate::access::{Access, WebToken};
use crate::api::app;
use crate::frames::Frames;
use crate::shared::{Ends, Shared};

/// The longest head of a request.
const HEAD_BYTES_MAX: usize = 16 * 1024;

/// How long to wait after the system gave no connection, which it does while it is short of something.
const AFTER_ACCEPT_ERROR: Duration = Duration::from_millis(50);

/// Threads that wait for the ring on behalf of pages; more questions wait their turn.
const THREADS_FOR_PAGES: usize = 4;

/// What a server allows.
#[derive(Clone, Debug)]
pub struct WebOptions {
    /// Names under which the page is reached, beside those of this machine.
    pub hosts: Vec<String>,
    /// What a page may do.
    pub permission: Permission,
    /// What a page must name to be let in; `None`: nothing.
    pub token: Option<WebToken>,
    /// Connections at the same time; one more is closed at once. A page holds up to six.
    pub connections: usize,
    /// How long the head of a request may take, and its body.
    pub slow: Duration,
}

impl Default for WebOptions {
    fn default() -> Self {
        Self {
            hosts: Vec::new(),
            permission: Permission::Look,
            token: None,
            connections: 512,
            slow: Duration::from_secs(10),
        }
    }
}

/// A page that is served until this is dropped.
#[derive(Debug)]
pub struct ServedPage {
    stop: Option<watch::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for ServedPage {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A thread that has died serves no page any more either.
            let _ = thread.join();
        }
    }
}

/// Serves the page of a ring.
///
/// # Errors
/// If the system gives no thread or takes the listener back.
pub fn start(
    listener: TcpListener,
    ring: Arc<dyn ShownRing>,
    options: &WebOptions,
) -> io::Result<ServedPage> {
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;
    let (stop, stopped) = watch::channel(());
    let shared = Shared {
        frames: Arc::new(Frames::new(Arc::clone(&ring))),
        ring,
        permission: options.permission,
        access: Arc::new(Access::new(options.token.clone(), address.port())),
        hosts: hosts(address.ip().to_canonical(), &options.hosts).into(),
        diagnosing: Arc::new(Semaphore::new(1)),
        slow: options.slow,
        stopped,
    };
    let connections = options.connections;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .max_blocking_threads(THREADS_FOR_PAGES)
        .build()?;
    let thread = thread::Builder::new().name("page".to_owned()).spawn(move || {
        runtime.block_on(async {
            // It was a listener of this process a moment ago.
            let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
            serve(listener, shared, connections).await;
        });
    })?;
    Ok(ServedPage { stop: Some(stop), thread: Some(thread) })
}

/// The names under which the page may be asked for, in lower case, beside the address that a request came to.
fn hosts(address: IpAddr, named: &[String]) -> Vec<String> {
    let loopback = ["localhost", "127.0.0.1", "::1"].map(str::to_owned);
    let loopback = loopback.into_iter().filter(|_| address.is_loopback() || address.is_unspecified());
    loopback.chain(named.iter().map(|name| name.to_ascii_lowercase())).collect()
}

async fn serve(listener: tokio::net::TcpListener, shared: Shared, connections: usize) {
    let mut stopped = shared.stopped.clone();
    let mut stop = pin!(async move { while stopped.changed().await.is_ok() {} });
    let frames = Arc::clone(&shared.frames);
    let frames = tokio::spawn(async move { frames.run().await });
    let slow = shared.slow;
    let app = app(shared);
    let mut served = JoinSet::new();
    loop {
        let accepted = tokio::select! {
            biased;
            () = &mut stop => break,
            Some(_) = served.join_next() => continue,
            accepted = listener.accept() => accepted,
        };
        match accepted {
            Ok((stream, peer)) if served.len() < connections => {
                served.spawn(connection(stream, peer, app.clone(), slow));
            }
            Ok(_) => {}
            Err(_) => tokio::select! {
                () = &mut stop => break,
                () = sleep(AFTER_ACCEPT_ERROR) => {}
            },
        }
    }
    frames.abort();
    served.shutdown().await;
}

async fn connection(stream: TcpStream, peer: SocketAddr, app: Router, slow: Duration) {
    // Answers are short and waited for; without this they still arrive, later.
    let _ = stream.set_nodelay(true);
    let Ok(here) = stream.local_addr() else { return };
    let ends = Ends { peer: peer.ip().to_canonical(), here: here.ip().to_canonical() };
    let app = TowerToHyperService::new(app);
    let app = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(ends);
        app.call(request)
    });
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(slow)
        .max_buf_size(HEAD_BYTES_MAX)
        .serve_connection(TokioIo::new(stream), app);
    // An error of one connection ends that connection.
    let _ = served.await;
}
