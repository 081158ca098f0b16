//! # tashika-viewer: films in a browser
//!
//! A web server for this machine alone, behind `tashika view` and `tashika render --serve`. Its
//! images implement [`Shown`]: a film that is being rendered ([`LiveFilm`]) or a film in a file
//! ([`StoredFilm`]), which is never loaded whole. The caller makes the page itself.
//!
//! | module | contents |
//! |---|---|
//! | `shown` | interface between a server and an image, and tiles of an image |
//! | `overview` | a film reduced to its least certain pixels, small enough to be held |
//! | `live`, `stored` | the two kinds of images |
//! | `rows`, `strips` | rows of a file with those of its reference, and a cache of them |
//! | `server` | the thread, its connections, and detection of open pages |
//! | `routes` | from a request to a response |
//!
//! The server is separate from the library, which opens no sockets and reads no clock. It is also
//! separate from the program, so that it can be tested alone.
//!
//! # Guarantee
//! The server is reachable from this machine only, and answers nothing without the unguessable
//! token in its address. Any request takes memory and time in proportion to one tile at most.
#![forbid(unsafe_code)]

mod live;
mod overview;
mod routes;
mod rows;
mod server;
mod shown;
mod stored;
mod strips;

pub use live::LiveFilm;
pub use server::{Options, PageContext, Server};
pub use shown::{
    Description, Headline, PlaneDescription, Refusal, Shown, Status, TILE, Tile, TileAddress, Values,
};
pub use stored::StoredFilm;
