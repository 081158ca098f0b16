//! Sensors: irradiance and illuminance at given places, each with an interval.
//!
//! A [`SensorSet`] is rendered as an image whose pixels are sensors
//! ([`Sensor`](crate::scene::Sensor)). The methods, claims, tiles and checkpoints of images are
//! therefore those of sensors, too. [`SensorSet::readings`] converts the film to irradiance and
//! illuminance ([`Photometry`]), and [`GridSummary`] summarises a set, such as the points of a
//! work plane.
//!
//! ```
//! use glam::DVec3;
//! use tashika::scene::{SensorPoint, builtin};
//! use tashika::sensors::{Photometry, SensorSet};
//! use tashika::{Renderer, Scene};
//!
//! let scene = std::sync::Arc::new(builtin::tiny());
//! let points = vec![SensorPoint::plane(DVec3::new(0.0, 0.1, 0.0), DVec3::Y)];
//! let sensors = SensorSet::new(&scene, points)?;
//! let film = Renderer::new(scene).sensors(&sensors).error(0.1).render()?.film;
//! let reading = &sensors.readings(&film, Photometry::Scene)[0];
//! println!("{} ± {:?} lx", reading.illuminance, reading.half_width);
//! # assert!(reading.half_width.unwrap() <= 0.1 * reading.illuminance);
//! # Ok::<(), tashika::Error>(())
//! ```

mod daylight;
mod grid;
mod photometry;
mod readings;
mod request;
mod set;
mod summary;

pub use daylight::horizontal_irradiance;
pub use grid::{GridOver, SensorGridRequest};
pub use photometry::Photometry;
pub use readings::Reading;
pub use request::SensorRequest;
pub use set::SensorSet;
pub use summary::{Bounds, GridSummary};
