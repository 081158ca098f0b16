//! Page that is served to browsers on this machine. It shows a file or a render in progress.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use tashika::film::Film;
use tashika::render::Finished;
use tashika::report::{Images, Page};
use tashika_viewer::{Headline, LiveFilm, Options, Server, Shown};

use crate::exit::Failure;
use crate::interrupt;
use crate::plan::{RenderPlan, Serving};
use crate::progress::Meter;
use crate::summary::typed_command;

/// Time between checks for viewers of the page.
const PAUSE: Duration = Duration::from_millis(100);
/// Longest wait until a started browser shows the page.
const START: Duration = Duration::from_secs(10);

/// A page that is being served.
pub struct Served {
    server: Server,
    /// True if a browser was started.
    opened: bool,
}

impl Served {
    /// Serves images on a page, and opens a browser if `serving.browser` is true.
    pub fn start(
        images: Vec<(String, Arc<dyn Shown>)>,
        page: Page<'static>,
        serving: &Serving,
    ) -> Result<Self, Failure> {
        let html = move |context: &tashika_viewer::PageContext| {
            Page { images: Images::Served { nonce: context.nonce.clone() }, ..page.clone() }.html()
        };
        let options = Options { port: serving.port };
        let server = Server::start(images, Box::new(html), &options)
            .map_err(|e| Failure::file(format!("cannot serve a page on port {}: {e}", serving.port)))?;
        // If no browser can be started, the user has the printed address.
        let opened = serving.browser && open::that_detached(server.address()).is_ok();
        Ok(Self { server, opened })
    }

    /// Address at which the page is served.
    pub fn address(&self) -> String {
        self.server.address()
    }
}

/// Page of a render that can be watched.
pub struct LivePage {
    film: Arc<LiveFilm>,
    served: Served,
}

impl LivePage {
    /// Serves the page of a render that has not begun, and reports its address.
    pub fn open(plan: &RenderPlan, serving: &Serving, meter: &Meter) -> Result<Self, Failure> {
        let film = Arc::new(LiveFilm::new());
        let name = plan.outputs.exr.display().to_string();
        let mut page = Page::new(&name, format!("{name}: {}", plan.stage.scene.label()));
        page.lines = vec!["Closing this page does not stop the render.".to_owned()];
        page.tone = plan.tone_map.tone;
        page.command = Some(typed_command());
        let shown: Arc<dyn Shown> = film.clone();
        let served = Served::start(vec![(name, shown)], page, serving)?;
        meter.note(&format!("the render can be watched at {}", served.address()));
        Ok(Self { film, served })
    }

    /// Shows a tile, and the progress of the render in words.
    pub fn show(&self, done: &Finished<'_>, text: String) {
        self.film.update(done.film, done.tile);
        let progress = &done.progress;
        let (pixels, claiming) = (progress.tally.rendered(), progress.tally.claiming());
        self.film.progress(Headline { text, pixels, of: progress.of, claiming, promise_met: claiming });
    }

    /// Shows the film as it was written, until no browser watches the page or until Ctrl-C.
    pub fn end(self, film: Film, meter: &Meter) {
        self.film.finish(film);
        let begun = Instant::now();
        let starting = || self.served.opened && begun.elapsed() < START;
        interrupt::with_flag(|cancel| {
            let waits = || !cancel.load(std::sync::atomic::Ordering::SeqCst);
            if self.served.server.is_watched() && waits() {
                meter.note("everything is written; the program ends when the page is closed, or with Ctrl-C");
            }
            while waits() && (self.served.server.is_watched() || starting()) {
                thread::sleep(PAUSE);
            }
        });
    }
}
