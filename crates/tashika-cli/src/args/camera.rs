//! Options for cameras: which of the scene's are rendered, and which of their properties are
//! replaced.

use clap::Args as ClapArgs;
use tashika::request::ProjectionName;

use crate::values;

/// Options that choose cameras and replace their properties.
#[derive(Debug, ClapArgs)]
pub struct CameraArgs {
    /// Camera by name; `render` takes several, separated by commas or in repeated options, or all
    /// of them (all), and writes an image of each, whose file name ends in the camera's name
    /// [default: the scene's first]
    #[arg(long = "camera", value_name = "NAME", help_heading = "Scene")]
    pub cameras: Vec<String>,

    /// Projection in place of the camera's: perspective; fisheye, the equidistant circle that
    /// touches the longer sides of the image; spherical, all directions by latitude and longitude;
    /// equal-area, all directions in a square whose pixels see the same solid angle
    /// [default: the camera's]
    #[arg(long, value_name = "perspective|fisheye|spherical|equal-area", value_parser = values::projection,
        help_heading = "Camera")]
    pub projection: Option<ProjectionName>,

    /// Field of view in degrees: of a perspective, the vertical angle, below 180; of a fisheye, the
    /// angle across the circle, at most 360
    /// [default: the camera's; 40, or 180 for a fisheye, if --projection is not the camera's]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, help_heading = "Camera")]
    pub fov: Option<f32>,

    /// Radius of the lens of a perspective, in metres: objects out of focus are blurred; 0 is a
    /// pinhole
    /// [default: the camera's]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true, help_heading = "Camera")]
    pub lens_radius: Option<f32>,

    /// Distance along the axis, in metres, at which the image is sharp
    /// [default: the camera's, if it has a lens]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true, help_heading = "Camera")]
    pub focus_distance: Option<f32>,

    /// Number of blades of the lens, 3 to 100: its opening becomes a polygon, whose corners are on
    /// the circle of the lens radius
    /// [default: the camera's; without blades the opening is round]
    #[arg(long, value_name = "N", help_heading = "Camera")]
    pub blades: Option<u32>,

    /// Rotation of the blades in degrees, counter-clockwise as the camera sees it; at 0 a corner is
    /// up
    /// [default: the camera's, or 0]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, help_heading = "Camera")]
    pub blade_rotation: Option<f32>,
}
