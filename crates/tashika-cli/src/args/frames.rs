//! Frames of an animation.

use clap::Args as ClapArgs;

use crate::values;

/// Options that choose frames.
#[derive(Debug, ClapArgs)]
pub struct FramesArgs {
    /// Render the frames A to B, including both, each at the time of its number divided by --fps,
    /// and write an image of each, whose file name ends in the frame's number
    #[arg(long, value_name = "A..B", value_parser = values::frames, conflicts_with = "at", help_heading = "Scene")]
    pub frames: Option<[u32; 2]>,

    /// Number of frames a second, above 0 [default: 24]
    #[arg(
        long,
        value_name = "N",
        requires = "frames",
        allow_negative_numbers = true,
        help_heading = "Scene"
    )]
    pub fps: Option<f64>,
}
