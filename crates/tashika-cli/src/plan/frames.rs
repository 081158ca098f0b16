//! Frames of an animation that are rendered, and their times.

use crate::args::FramesArgs;
use crate::exit::Failure;

/// Default number of frames a second, that of films.
const FPS: f64 = 24.0;

/// Range of frames, including both ends.
#[derive(Clone, Copy, Debug)]
pub struct Frames {
    first: u32,
    last: u32,
    fps: f64,
}

impl Frames {
    /// Takes the arguments; `None` if they name no frames.
    pub fn new(args: &FramesArgs) -> Result<Option<Self>, Failure> {
        let fps = args.fps.unwrap_or(FPS);
        if !(fps > 0.0 && fps.is_finite()) {
            return Err(Failure::option("fps", fps, "frames a second, above 0"));
        }
        Ok(args.frames.map(|[first, last]| Self { first, last, fps }))
    }

    /// Returns the range as it is typed: `1..48`.
    pub fn typed(&self) -> String {
        format!("{}..{}", self.first, self.last)
    }

    /// Number of the first frame.
    pub fn first(&self) -> u32 {
        self.first
    }

    /// Numbers and times (s) of the frames, in order.
    pub fn all(&self) -> impl Iterator<Item = (u32, f64)> + use<> {
        let fps = self.fps;
        (self.first..=self.last).map(move |number| (number, f64::from(number) / fps))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbers_over_frames_a_second() {
        let frames = |fps| Frames::new(&FramesArgs { frames: Some([23, 25]), fps });
        let all: Vec<(u32, f64)> = frames(None).unwrap().unwrap().all().collect();
        assert_eq!(all, [(23, 23.0 / 24.0), (24, 1.0), (25, 25.0 / 24.0)]);
        assert_eq!(frames(Some(50.0)).unwrap().unwrap().all().last(), Some((25, 0.5)));
        assert!(Frames::new(&FramesArgs { frames: None, fps: None }).unwrap().is_none());
        for wrong in [0.0, -24.0, f64::NAN, f64::INFINITY] {
            assert!(frames(Some(wrong)).is_err(), "{wrong}");
        }
    }
}
