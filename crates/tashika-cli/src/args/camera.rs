//! Who looks: which cameras of the scene, and what of them is another than the scene says.

use clap::Args as ClapArgs;
use tashika::request::ProjectionName;

use crate::values;

/// Which cameras, and what of them is another than the scene says.
#[derive(Debug, ClapArgs)]
pub struct CameraArgs {
    /// Camera, by name; `render` takes several, with commas between or said again, or all of them
    /// (all), and makes an image of each, whose name ends in the camera's
    /// [default: the scene's first]
    #[arg(long = "camera", value_name = "NAME", help_heading = "Scene")]
    pub cameras: Vec<String>,

    /// Another projection than the camera's: perspective; fisheye, the equidistant circle that
    /// touches the longer sides of the image; spherical, all directions by latitude and longitude;
    /// equal-area, all directions in a square whose pixels see the same solid angle
    /// [default: the camera's]
    #[arg(long, value_name = "perspective|fisheye|spherical|equal-area", value_parser = values::projection,
        help_heading = "Camera")]
    pub projection: Option<ProjectionName>,

    /// Field of view in degrees: vertical, of a perspective, below 180; across the circle, of a
    /// fisheye, at most 360 [default: the camera's; of another projection than its own 40, or 180]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, help_heading = "Camera")]
    pub fov: Option<f32>,

    /// Radius of the lens in metres, of a perspective: what is out of focus blurs; 0 is a pinhole
    /// [default: the camera's]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true, help_heading = "Camera")]
    pub lens_radius: Option<f32>,

    /// Distance along the axis in metres at which the image is sharp
    /// [default: the camera's, if it has a lens]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true, help_heading = "Camera")]
    pub focus_distance: Option<f32>,

    /// Blades of the lens, 3 to 100: its opening is a polygon with corners on the circle of the
    /// radius
    /// [default: the camera's; a round opening]
    #[arg(long, value_name = "N", help_heading = "Camera")]
    pub blades: Option<u32>,

    /// Turn of the blades in degrees, counter-clockwise as the camera sees it; at 0 a corner is up
    /// [default: the camera's, or 0]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, help_heading = "Camera")]
    pub blade_rotation: Option<f32>,
}
