//! The server's thread, its connections, and detection of open pages.
//!
//! One thread answers; two others read files and cut tiles. Connections are few: at more than
//! [`MOST_CONNECTIONS`], or when the system has no resources for more, the connection that has been
//! idle longest is closed, starting with those that never sent the token. So clients that open
//! connections and send nothing do not disturb others.
//!
//! # Guarantee
//! Only this machine can connect. A connection is closed if its request does not arrive within
//! [`HEADER_TIME`]. The head of a request has at most [`MOST_HEAD_BYTES`].
//!
//! # Held to this by
//! The tests in `tests/server.rs`, and those below.

use std::convert::Infallible;
use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;
use tokio::sync::{Semaphore, oneshot};
use tokio::task::AbortHandle;

use crate::routes::{answer, random_hex};
use crate::shown::{Refusal, Shown};

/// Largest number of connections at once.
const MOST_CONNECTIONS: usize = 256;
/// Time within which a request must arrive, from when the connection can accept one.
const HEADER_TIME: Duration = Duration::from_secs(10);
/// Largest size of a request's first line and headers (bytes).
const MOST_HEAD_BYTES: usize = 16 << 10;
/// Largest number of headers of a request.
const MOST_HEADERS: usize = 64;
/// Number of threads that read files and make tiles.
const WORKERS: usize = 2;
/// Time after a poll during which a page counts as open: browsers let pages in the background poll
/// once a minute.
const POLL_TIME: Duration = Duration::from_secs(70);
/// Time after a goodbye within which the page may return: reloading a page sends a goodbye, too.
const GOODBYE_TIME: Duration = Duration::from_secs(3);

/// Settings of a server.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Port of the server. Default: 0, any that is free.
    pub port: u16,
}

/// Values that a page needs from the server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PageContext {
    /// Attribute `nonce` of the page's `script` and `style` elements, new for each request.
    /// Browsers ignore elements without it.
    pub nonce: String,
}

/// Function that makes the page.
pub(crate) type Page = Box<dyn Fn(&PageContext) -> String + Send + Sync>;

/// A running server; dropping the value stops it.
pub struct Server {
    shared: Arc<Shared>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// State that all connections share.
pub(crate) struct Shared {
    pub(crate) port: u16,
    pub(crate) token: String,
    pub(crate) images: Vec<(String, Arc<dyn Shown>)>,
    pub(crate) page: Page,
    pub(crate) watch: Watch,
    workers: Arc<Semaphore>,
    connections: Mutex<Vec<Connection>>,
    /// Counter of events on connections, which orders them by idle time.
    clock: AtomicU64,
}

/// State of a connection, by which others choose the one to close.
struct Connection {
    activity: Arc<Activity>,
    abort: AbortHandle,
}

#[derive(Default)]
struct Activity {
    /// True while a request is being answered.
    busy: AtomicBool,
    /// True if a request has sent the token.
    known: AtomicBool,
    /// Count at the last answer, or at the start of the connection.
    last: AtomicU64,
}

impl Server {
    /// Starts a server for images, each with a label, and for a page that shows them.
    ///
    /// # Errors
    /// If the port is taken, or the system provides no thread or no random numbers.
    pub fn start(
        images: Vec<(String, Arc<dyn Shown>)>,
        page: Box<dyn Fn(&PageContext) -> String + Send + Sync>,
        options: &Options,
    ) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, options.port))?;
        listener.set_nonblocking(true)?;
        let shared = Arc::new(Shared {
            port: listener.local_addr()?.port(),
            token: random_hex().map_err(|e| io::Error::other(e.to_string()))?,
            images,
            page,
            watch: Watch::default(),
            workers: Arc::new(Semaphore::new(WORKERS)),
            connections: Mutex::default(),
            clock: AtomicU64::new(0),
        });
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(WORKERS)
            .build()?;
        let (stop, stopped) = oneshot::channel();
        let serving = shared.clone();
        let serve = move || {
            runtime.block_on(async {
                let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
                tokio::spawn(accept(serving, listener));
                // A sent value and a dropped sender both mean to stop.
                let _ = stopped.await;
            });
            // A tile in the making must not delay the end of the server.
            runtime.shutdown_background();
        };
        let thread = thread::Builder::new().name("server".to_owned()).spawn(serve)?;
        Ok(Self { shared, stop: Some(stop), thread: Some(thread) })
    }

    /// Address of the page. On this machine anyone who knows the address can see the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.shared.port, self.shared.token)
    }

    /// Returns true if a page is open: it polled the state in the last 70 s. After its goodbye a
    /// page counts as open for 3 s more, since it may only be reloading.
    pub fn is_watched(&self) -> bool {
        self.shared.watch.is_watched(Instant::now())
    }

    /// Stops the server.
    pub fn stop(self) {}
}

impl Drop for Server {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // The thread returns nothing, and has already reported a panic of its own.
            let _ = thread.join();
        }
    }
}

/// Accepts connections forever.
async fn accept(shared: Arc<Shared>, listener: tokio::net::TcpListener) {
    loop {
        match listener.accept().await {
            Ok((stream, _)) => shared.clone().begin(stream),
            // Usually the system has no more file descriptors.
            Err(_) => {
                if !shared.close_idlest() {
                    tokio::time::sleep(Duration::from_millis(20)).await;
                }
                tokio::task::yield_now().await;
            }
        }
    }
}

impl Shared {
    fn connections(&self) -> MutexGuard<'_, Vec<Connection>> {
        self.connections.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> u64 {
        self.clock.fetch_add(1, Ordering::Relaxed)
    }

    /// Closes the connection that has been idle longest; returns false if all are busy.
    fn close_idlest(&self) -> bool {
        let mut connections = self.connections();
        let idle = connections.iter().enumerate().filter(|(_, c)| !c.activity.busy.load(Ordering::Relaxed));
        let rank = |c: &Connection| {
            (c.activity.known.load(Ordering::Relaxed), c.activity.last.load(Ordering::Relaxed))
        };
        let Some((idlest, _)) = idle.min_by_key(|(_, c)| rank(c)) else { return false };
        connections.swap_remove(idlest).abort.abort();
        true
    }

    /// Serves a connection, or closes it if too many others are busy.
    fn begin(self: Arc<Self>, stream: TcpStream) {
        self.connections().retain(|c| !c.abort.is_finished());
        if self.connections().len() >= MOST_CONNECTIONS && !self.close_idlest() {
            return;
        }
        let activity = Arc::new(Activity::default());
        activity.last.store(self.now(), Ordering::Relaxed);
        let abort = tokio::spawn(serve(self.clone(), stream, activity.clone())).abort_handle();
        self.connections().push(Connection { activity, abort });
    }

    /// Runs blocking work on a worker thread. Work that has not begun is cancelled when its future
    /// is dropped.
    pub(crate) async fn work<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> Result<T, Refusal> + Send + 'static,
    ) -> Result<T, Refusal> {
        let broken = || Refusal::Unreadable("the tile could not be made".to_owned());
        let turn = self.workers.clone().acquire_owned().await.map_err(|_| broken())?;
        let work = move || {
            let _turn = turn;
            work()
        };
        tokio::task::spawn_blocking(work).await.unwrap_or_else(|_| Err(broken()))
    }
}

/// Serves one connection until it ends.
async fn serve(shared: Arc<Shared>, stream: TcpStream, activity: Arc<Activity>) {
    let service = service_fn(|request| {
        let (shared, activity) = (shared.clone(), activity.clone());
        async move {
            activity.busy.store(true, Ordering::Relaxed);
            let (response, is_known) = answer(&shared, &request).await;
            activity.last.store(shared.now(), Ordering::Relaxed);
            activity.known.fetch_or(is_known, Ordering::Relaxed);
            activity.busy.store(false, Ordering::Relaxed);
            Ok::<_, Infallible>(response)
        }
    });
    let serving = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIME)
        .max_buf_size(MOST_HEAD_BYTES)
        .max_headers(MOST_HEADERS)
        .serve_connection(TokioIo::new(stream), service);
    // Errors on a connection are the client's, and end the connection.
    let _ = serving.await;
}

/// Times of the last poll and of the last goodbye of a page.
#[derive(Default)]
pub(crate) struct Watch(Mutex<Heard>);

#[derive(Clone, Copy, Default)]
struct Heard {
    poll: Option<Instant>,
    goodbye: Option<Instant>,
}

impl Watch {
    fn heard(&self) -> MutexGuard<'_, Heard> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn polled(&self) {
        *self.heard() = Heard { poll: Some(Instant::now()), goodbye: None };
    }

    pub(crate) fn said_goodbye(&self) {
        self.heard().goodbye = Some(Instant::now());
    }

    fn is_watched(&self, now: Instant) -> bool {
        let heard = *self.heard();
        let within = |when: Option<Instant>, time| when.is_some_and(|when| now.duration_since(when) <= time);
        within(heard.poll, POLL_TIME) && heard.goodbye.is_none_or(|_| within(heard.goodbye, GOODBYE_TIME))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_watched_until_it_falls_silent_or_has_said_goodbye() {
        let watch = Watch::default();
        let seconds = |n| Instant::now() + Duration::from_secs(n);
        assert!(!watch.is_watched(seconds(0)));
        watch.polled();
        assert!(watch.is_watched(seconds(69)) && !watch.is_watched(seconds(71)));
        watch.said_goodbye();
        assert!(watch.is_watched(seconds(2)) && !watch.is_watched(seconds(4)));
        watch.polled();
        assert!(watch.is_watched(seconds(69)), "it was only loaded again");
    }
}
