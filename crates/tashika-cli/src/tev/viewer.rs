//! Connection to a viewer. Finished tiles are queued, and a separate thread sends them.
//!
//! The render never waits for the viewer, however slow it is. Each pixel is queued once, so the
//! queue is never larger than the film. The socket does not block, which distinguishes a stalled
//! viewer from a closed connection. During the render, the viewer may stall for any time. At the
//! end, the program waits as long as the viewer keeps reading.
//!
//! # Held to this by
//! The tests below; those of the program in `tests/tev.rs`.

use std::io::{self, ErrorKind, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use tashika::render::Finished;

use super::packet;
use crate::exit::Failure;

/// Address at which tev listens by default.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:14158";
/// Longest wait for the connection.
const CONNECT_PATIENCE: Duration = Duration::from_secs(5);
/// Longest time that a viewer may stall once the render is done.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time between attempts to send to a viewer that has no room for more.
const PAUSE: Duration = Duration::from_millis(10);

/// Connection to a viewer that shows the tiles of one image.
pub struct Viewer {
    address: String,
    image: String,
    channels: OnceLock<Vec<String>>,
    queue: Sender<Vec<u8>>,
    shared: Arc<Shared>,
    thread: JoinHandle<()>,
}

/// State that the sending thread shares with the render.
#[derive(Default)]
struct Shared {
    /// True once nothing more will be queued.
    ending: AtomicBool,
    /// Error that ended the sending, until it is reported.
    trouble: Mutex<Option<io::Error>>,
}

impl Shared {
    fn trouble(&self) -> std::sync::MutexGuard<'_, Option<io::Error>> {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Viewer {
    /// Connects to the viewer. The viewer shows the image under the name of the file to be written.
    pub fn connect(address: &str, file: &Path) -> Result<Self, Failure> {
        let stream = call(address).map_err(|e| {
            Failure::file(format!(
                "cannot reach tev at {address}: {e}; start tev first (it listens at {DEFAULT_ADDRESS} unless its --host says \
                 otherwise), or leave --tev out"
            ))
        })?;
        Ok(Self::over(stream, address, file, PATIENCE))
    }

    /// Makes the connection to a viewer at the other end of `stream`.
    fn over(mut stream: impl Write + Send + 'static, address: &str, file: &Path, patience: Duration) -> Self {
        let (queue, packets) = channel();
        let shared = Arc::new(Shared::default());
        let seen = Arc::clone(&shared);
        let thread = thread::spawn(move || {
            if let Err(e) = send(&mut stream, &packets, &seen.ending, patience) {
                *seen.trouble() = Some(e);
            }
        });
        let name = file.file_name().unwrap_or(file.as_os_str());
        Self {
            address: address.to_owned(),
            image: name.to_string_lossy().into_owned(),
            channels: OnceLock::new(),
            queue,
            shared,
            thread,
        }
    }

    /// Queues a finished tile. If the connection has failed, returns the error, but only once.
    pub fn show(&self, finished: &Finished<'_>) -> Option<String> {
        let Finished { film, tile, .. } = *finished;
        if !self.thread.is_finished() {
            let channels = self.channels.get_or_init(|| {
                let channels = packet::channel_names(film);
                self.queue(packet::create_image(&self.image, film.size(), &channels));
                channels
            });
            self.queue(packet::update_image(&self.image, channels, tile, &packet::samples(film, tile)));
        }
        self.trouble()
    }

    /// Waits until everything is sent or the viewer has stalled too long. If the connection has
    /// failed, returns the error, unless `show` has returned it already.
    pub fn finish(self) -> Option<String> {
        let Self { address, queue, shared, thread, .. } = self;
        shared.ending.store(true, Ordering::Relaxed);
        drop(queue);
        // A panic of the thread has been printed already, and must not lose a finished image.
        let _ = thread.join();
        let trouble = shared.trouble().take();
        trouble.map(|e| told(&address, &e))
    }

    fn queue(&self, packet: Vec<u8>) {
        // Sending fails if the connection broke just now, which is reported elsewhere.
        let _ = self.queue.send(packet);
    }

    fn trouble(&self) -> Option<String> {
        self.shared.trouble().take().map(|e| told(&self.address, &e))
    }
}

fn told(address: &str, error: &io::Error) -> String {
    format!("tev at {address} shows no more of the image ({error}); the files are not affected")
}

/// Opens a connection that does not block.
fn call(address: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(ErrorKind::NotFound, "the name has no address");
    for place in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&place, CONNECT_PATIENCE) {
            Ok(stream) => {
                stream.set_nonblocking(true)?;
                return Ok(stream);
            }
            Err(e) => last = e,
        }
    }
    Err(last)
}

/// Sends all queued packets until the queue is closed. Gives up if `ending` is set and the viewer
/// accepts nothing for `patience`.
fn send(
    stream: &mut impl Write,
    packets: &Receiver<Vec<u8>>,
    ending: &AtomicBool,
    patience: Duration,
) -> io::Result<()> {
    let mut still_since = None;
    for packet in packets {
        let mut rest = &packet[..];
        while !rest.is_empty() {
            match stream.write(rest) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(taken) => {
                    rest = &rest[taken..];
                    still_since = None;
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) if e.kind() == ErrorKind::WouldBlock => {
                    if ending.load(Ordering::Relaxed) {
                        let since = *still_since.get_or_insert_with(Instant::now);
                        if since.elapsed() >= patience {
                            let seconds = patience.as_secs_f64();
                            let message = format!("it has read nothing for {seconds} seconds");
                            return Err(io::Error::new(ErrorKind::TimedOut, message));
                        }
                    }
                    thread::sleep(PAUSE);
                }
                Err(e) => return Err(e),
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use tashika::film::{Film, PlaneSpec, SampleKind, Window};
    use tashika::render::Progress;

    const SPECS: &[PlaneSpec] =
        &[PlaneSpec { name: "", channels: &["R", "G", "B"], unit: "1", kind: SampleKind::F32, doc: "" }];

    /// Stand-in for a viewer. It accepts a few bytes at a time and `room` bytes in all; after that,
    /// every write fails with `then`.
    struct Peer {
        taken: Arc<Mutex<Vec<u8>>>,
        room: usize,
        then: ErrorKind,
    }

    impl Write for Peer {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let mut taken = self.taken.lock().unwrap();
            let count = bytes.len().min(7).min(self.room - taken.len());
            if count == 0 {
                return Err(self.then.into());
            }
            taken.extend(&bytes[..count]);
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// Shows two tiles to such a peer. Returns the bytes that the peer accepted, the errors of
    /// `show`, and the error of `finish`.
    fn shown(room: usize, then: ErrorKind) -> (Vec<u8>, Vec<String>, Option<String>) {
        let taken = Arc::new(Mutex::new(Vec::new()));
        let peer = Peer { taken: Arc::clone(&taken), room, then };
        let viewer = Viewer::over(peer, "nowhere:1", Path::new("some/a.exr"), Duration::from_millis(50));
        let film = Film::new([4, 4], Window::full([4, 4]), SPECS).unwrap();
        let mut told = Vec::new();
        for y in 0..2 {
            let tile = Window { x: 0, y, width: 4, height: 1 };
            told.extend(viewer.show(&Finished { progress: Progress::default(), film: &film, tile }));
        }
        if then == ErrorKind::WouldBlock {
            // The wait is longer than the patience at the end: during the render, no stall is too
            // long.
            thread::sleep(Duration::from_millis(100));
            told.extend(viewer.trouble());
        } else {
            // Time for the thread to fail, so that the next tile finds it failed.
            while !viewer.thread.is_finished() {
                thread::sleep(Duration::from_millis(1));
            }
            let tile = Window::full([4, 4]);
            for _ in 0..3 {
                told.extend(viewer.show(&Finished { progress: Progress::default(), film: &film, tile }));
            }
        }
        let last = viewer.finish();
        (Arc::try_unwrap(taken).unwrap().into_inner().unwrap(), told, last)
    }

    #[test]
    fn all_that_is_shown_is_sent_in_order() {
        let (taken, told, last) = shown(usize::MAX, ErrorKind::WouldBlock);
        assert_eq!((told, last), (vec![], None));
        let channels = ["R", "G", "B"].map(str::to_owned);
        let mut expected = packet::create_image("a.exr", [4, 4], &channels);
        for y in 0..2 {
            let tile = Window { x: 0, y, width: 4, height: 1 };
            expected.extend(packet::update_image("a.exr", &channels, tile, &[0.0; 12]));
        }
        assert_eq!(taken, expected);
    }

    #[test]
    fn a_viewer_that_stands_still_is_given_up_at_the_end_only() {
        let begun = Instant::now();
        let (taken, told, last) = shown(10, ErrorKind::WouldBlock);
        assert_eq!((taken.len(), told), (10, vec![]));
        let last = last.unwrap();
        assert!(last.contains("nowhere:1") && last.contains("nothing for 0.05 seconds"), "{last}");
        assert!(begun.elapsed() >= Duration::from_millis(50), "it was waited for");
    }

    #[test]
    fn a_broken_connection_is_told_once() {
        let (taken, told, last) = shown(10, ErrorKind::BrokenPipe);
        assert_eq!((taken.len(), last), (10, None));
        assert!(
            matches!(&told[..], [once] if once.contains("nowhere:1") && once.contains("not affected")),
            "{told:?}"
        );
    }
}
