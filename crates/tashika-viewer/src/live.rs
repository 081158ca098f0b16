//! A film that is being rendered, shown tile by tile.
//!
//! # Guarantee
//! [`LiveFilm::update`] takes time in proportion to the tile. It waits at most for tiles that are
//! being copied out, and never for a browser. Each shown pixel is a pixel of a film that was
//! passed, never a mixture.
//!
//! # Held to this by
//! The tests of `stored`, which compare both kinds of images with the film.

use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use tashika::film::{Film, Window};

use crate::overview::{Overview, factor};
use crate::shown::{
    Collected, Description, Headline, Refusal, Shown, Status, Tile, TileAddress, Values, values,
};

/// A film that grows while it is shown.
#[derive(Default)]
pub struct LiveFilm {
    state: RwLock<State>,
}

#[derive(Default)]
struct State {
    version: u64,
    image: Option<Image>,
    headline: Option<Headline>,
    finished: bool,
}

/// State from the first film on.
struct Image {
    description: Description,
    film: Film,
    /// Reduced film, if the film is too large to be shown as a whole.
    overview: Option<Overview>,
}

impl Image {
    fn new(film: Film) -> Self {
        let window = film.window();
        let overview = (factor(window) > 1).then(|| Overview::new(&film, window));
        Self { description: Description::of(&film, window), film, overview }
    }

    fn renew(&mut self, part: Window) {
        if let Some(overview) = &mut self.overview {
            overview.renew(&self.film, part);
        }
    }
}

impl LiveFilm {
    /// An image without a film.
    pub fn new() -> Self {
        Self::default()
    }

    fn read(&self) -> RwLockReadGuard<'_, State> {
        self.state.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, State> {
        self.state.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// Copies `tile` from a film and shows it. The first call determines size, planes and metadata,
    /// and all calls must agree with it.
    ///
    /// # Panics
    /// If the tile is not inside the film's window, or the film does not agree with that of the
    /// first call.
    pub fn update(&self, film: &Film, tile: Window) {
        let mut state = self.write();
        let image = state.image.get_or_insert_with(|| {
            Image::new(film.blank(film.size(), film.window()).expect("a size that a film has"))
        });
        for y in tile.y..tile.y + tile.height {
            image.film.copy_pixels([tile.x, y], film, [tile.x, y], tile.width);
        }
        image.renew(tile);
        state.version += 1;
    }

    /// Sets the headline and the progress of the render.
    pub fn progress(&self, headline: Headline) {
        let mut state = self.write();
        state.headline = Some(headline);
        state.version += 1;
    }

    /// Replaces the image by a film that will not change.
    pub fn finish(&self, film: Film) {
        let mut image = Image::new(film);
        image.renew(image.film.window());
        let mut state = self.write();
        state.image = Some(image);
        state.finished = true;
        state.version += 1;
    }
}

impl Shown for LiveFilm {
    fn description(&self) -> Option<Description> {
        self.read().image.as_ref().map(|image| image.description.clone())
    }

    fn version(&self) -> u64 {
        self.read().version
    }

    fn status(&self) -> Status {
        let state = self.read();
        let share = state.headline.as_ref().map_or(0.0, |h| h.pixels as f32 / h.of.max(1) as f32);
        let ready = if state.finished { 1.0 } else { share.min(1.0) };
        Status {
            live: true,
            finished: state.finished,
            ready,
            headline: state.headline.clone(),
            failure: None,
        }
    }

    fn tile(&self, at: TileAddress, planes: &[&str]) -> Result<Tile, Refusal> {
        let state = self.read();
        let image = state.image.as_ref().ok_or(Refusal::NotYet)?;
        let (part, planes) = (image.description.part(at)?, image.description.places(planes)?);
        let step = 1 << at.level;
        if let Some(overview) = image.overview.as_ref().filter(|overview| overview.factor() <= step) {
            return Ok(overview.tile(state.version, &planes, part, step));
        }
        let mut bytes = Collected::new(&planes);
        bytes.add(&image.film, part, step);
        Ok(Tile { version: state.version, bytes: bytes.into_bytes() })
    }

    fn pixel(&self, x: u32, y: u32) -> Result<Vec<Values>, Refusal> {
        let state = self.read();
        let image = state.image.as_ref().ok_or(Refusal::NotYet)?;
        image.description.check_pixel(x, y)?;
        Ok(values(&image.film, x, y))
    }
}
