//! # tashika-viewer: films in a browser
//!
//! A web server for this machine alone, behind `tashika view` and `tashika render --serve`. What it
//! shows is [`Shown`]: a film that is being rendered ([`LiveFilm`]) or one in a file
//! ([`StoredFilm`]), which is never loaded whole. The page itself is the caller's.
//!
//! | module | what it is |
//! |---|---|
//! | `shown` | what a server asks of an image, and tiles of it |
//! | `overview` | a film made small enough to be held, of its least certain pixels |
//! | `live`, `stored` | the two kinds of images |
//! | `rows`, `strips` | rows of a file with those of its reference, the last used ones kept |
//! | `server` | the thread, its connections, and who watches |
//! | `routes` | from a request to a response |
//!
//! It is apart from the library, which opens no sockets and knows no clock, and from the program,
//! so that it can be tested without one.
//!
//! # Guarantee
//! The server is reachable from this machine only, answers nothing without the unguessable token in
//! its address, and whatever a request says, takes memory and time in proportion to one tile.
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
