//! Intel's Open Image Denoise (OIDN) 2, loaded at run time, as a
//! [smoother](tashika_film::reconstruction::Smoother) that replaces the built-in reconstruction.
//!
//! The library is not needed to build. PyPI's package `pyoidn` carries it for Linux and Windows;
//! distributions call it `libOpenImageDenoise.so.2`. Declarations follow the documentation of its C
//! interface (OIDN 2, `oidn.h`; Apache-2.0).
//!
//! # Guarantee
//! None: only an audit can make a claim about a picture. The bits depend on the library, on the
//! device and on the number of threads.
//!
//! # Held to this by
//! The test below, if `TASHIKA_OIDN` names a library; `test_denoiser.py` of the Python package.

mod library;

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use library::{Device, Images};
use tashika_film::color::Rgb;
use tashika_film::error::{Error, Result};
use tashika_film::film::{Film, PlaneSpec, planes};
use tashika_film::reconstruction::Smoother;

/// File name of an installed library, by operating system.
pub const SYSTEM: &str = if cfg!(target_os = "macos") {
    "libOpenImageDenoise.2.dylib"
} else if cfg!(windows) {
    "OpenImageDenoise.dll"
} else {
    "libOpenImageDenoise.so.2"
};

/// Environment variable with the path of the library.
const VARIABLE: &str = "TASHIKA_OIDN";

/// Mean luminance of the pictures that the network receives: it expects exposed pictures.
const MIDDLE_GRAY: f32 = 0.18;

/// The library with a device, ready to denoise pictures.
pub struct Oidn {
    device: Device,
}

impl fmt::Debug for Oidn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name())
    }
}

impl Oidn {
    /// Name of our own reconstruction, in [`by_name`](Self::by_name).
    pub const OWN: &str = "own";
    /// Name of the library where it is found, else of our reconstruction.
    pub const AUTO: &str = "auto";

    /// Loads the library from a file, or by a [name](SYSTEM) that the system resolves, and makes a
    /// device on the processor with `threads` threads; 0 stands for all that there are.
    ///
    /// # Errors
    /// If the library is missing, or is not OIDN 2; the message has installation instructions.
    pub fn load(library: &Path, threads: usize) -> Result<Self> {
        let failed = |why: String| {
            let expected = "Open Image Denoise 2, as `pip install pyoidn` has it in pyoidn/oidn/lib, or a \
                            distribution's package";
            Error::option("denoiser", format!("{} ({why})", library.display()), expected)
        };
        // SAFETY: the user guarantees that the named file is this library.
        let device = unsafe { Device::load(library, threads) }.map_err(failed)?;
        Ok(Self { device })
    }

    /// Returns the denoiser that a user selects by `name`. `own`: `None`, the built-in
    /// reconstruction. `oidn`: the library that the environment variable `TASHIKA_OIDN` names, else
    /// `found`, else [the system's](SYSTEM). `auto`: as `oidn`, but `None` if neither `found` nor
    /// the system has one that loads. Any other name: the library in that file.
    ///
    /// # Errors
    /// As [`Oidn::load`].
    pub fn by_name(
        name: &Path,
        found: impl FnOnce() -> Option<PathBuf>,
        threads: usize,
    ) -> Result<Option<Arc<dyn Smoother>>> {
        let library = match name.to_str() {
            Some(Self::OWN) => return Ok(None),
            Some(Self::AUTO) if std::env::var_os(VARIABLE).is_none() => {
                let libraries = found().into_iter().chain([SYSTEM.into()]);
                let loaded = libraries.filter_map(|library| Self::load(&library, threads).ok()).next();
                return Ok(loaded.map(|oidn| Arc::new(oidn) as _));
            }
            Some("oidn" | Self::AUTO) => {
                let named = std::env::var_os(VARIABLE).map(PathBuf::from);
                named.or_else(found).unwrap_or_else(|| SYSTEM.into())
            }
            _ => name.to_owned(),
        };
        Ok(Some(Arc::new(Self::load(&library, threads)?)))
    }
}

impl Smoother for Oidn {
    fn name(&self) -> String {
        let [major, minor, patch] = self.device.version();
        format!("oidn {major}.{minor}.{patch}")
    }

    fn smooth(&self, radiance: &[Rgb], film: &Film) -> Result<Vec<Rgb>> {
        let window = film.window();
        let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
        let plane = |spec: PlaneSpec| -> Result<Vec<f32>> {
            let samples = film.plane(spec).and_then(|plane| plane.f32_samples());
            let samples =
                samples.ok_or_else(|| Error::option("denoiser", spec.name, "a film with that plane"))?;
            Ok(samples.iter().copied().map(finite).collect())
        };
        let mean =
            radiance.iter().map(|color| finite(color.luminance())).sum::<f32>() / window.area().max(1) as f32;
        let images = Images {
            size: [window.width as usize, window.height as usize],
            color: radiance.iter().flat_map(|color| color.to_array()).map(finite).collect(),
            albedo: plane(planes::ALBEDO)?.into_iter().map(|value| value.clamp(0.0, 1.0)).collect(),
            normal: plane(planes::NORMAL)?,
            scale: if mean > 0.0 { MIDDLE_GRAY / mean } else { 1.0 },
        };
        let smooth = self.device.denoise(images).map_err(|why| {
            Error::option("denoiser", self.name(), format!("a library that can smooth this picture: {why}"))
        })?;
        Ok(smooth.chunks_exact(3).map(|c| Rgb::new(c[0], c[1], c[2])).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tashika_film::film::{PixelRecord, Window};

    #[test]
    fn what_is_not_there_is_said_with_how_to_get_it() {
        let refused = Oidn::load(Path::new("/nowhere/libOpenImageDenoise.so.2"), 1).unwrap_err().to_string();
        assert!(refused.contains("/nowhere/") && refused.contains("pip install pyoidn"), "{refused}");
        // A different library.
        let other = Oidn::load(Path::new("libm.so.6"), 1).unwrap_err().to_string();
        assert!(other.contains("pyoidn"), "{other}");
    }

    #[test]
    fn names_are_those_of_users() {
        assert!(Oidn::by_name(Path::new("own"), || panic!("nothing is looked for"), 1).unwrap().is_none());
        if std::env::var_os(VARIABLE).is_none() {
            let found = || Some("/nowhere/found.so".into());
            assert!(Oidn::by_name(Path::new("auto"), found, 1).unwrap().is_none());
        }
        let file = Path::new("/nowhere/it.so");
        let refused = Oidn::by_name(file, || panic!("a file is named"), 1).unwrap_err().to_string();
        assert!(refused.contains("/nowhere/it.so"), "{refused}");
        if std::env::var_os(VARIABLE).is_none() {
            let found = || Some("/nowhere/found.so".into());
            let refused = Oidn::by_name(Path::new("oidn"), found, 1).unwrap_err().to_string();
            assert!(refused.contains("/nowhere/found.so"), "{refused}");
        }
    }

    /// Noise is mostly removed, an edge stays, and the brightness does not change.
    #[test]
    fn noise_is_smoothed() {
        let Some(library) = std::env::var_os(VARIABLE) else { return };
        let oidn = Oidn::load(Path::new(&library), 2).unwrap();
        let size = [64, 48];
        let truth = |x: u32| if x < 32 { 100.0 } else { 300.0 };
        let half = |seed: u32| {
            let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
            let mut state = seed;
            for (x, y) in Window::full(size).pixels() {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let noise = 1.0 + 0.5 * ((state >> 8) as f32 / (1 << 24) as f32 - 0.5);
                let radiance = Rgb::gray(truth(x) * noise);
                PixelRecord { radiance, albedo: Rgb::gray(0.5), ..PixelRecord::default() }
                    .store(&mut film, x, y);
            }
            film
        };
        for film in [half(1), half(2)] {
            let noisy: Vec<Rgb> = film.colors().unwrap().collect();
            let smooth = oidn.smooth(&noisy, &film).unwrap();
            let off = |colors: &[Rgb]| {
                let off = |((x, _), c): ((u32, u32), &Rgb)| (c.luminance() / truth(x) - 1.0).abs();
                Window::full(size).pixels().zip(colors).map(off).sum::<f32>() / colors.len() as f32
            };
            assert!(off(&smooth) < 0.3 * off(&noisy), "{} of {}", off(&smooth), off(&noisy));
            assert!(smooth == oidn.smooth(&noisy, &film).unwrap(), "the same twice");
        }
    }
}
