//! Upper bounds of the contribution of clusters of lights to clusters of gather points.

mod analytic;
mod angle;
mod constant;
mod cube_map;
mod geometry;
mod light;
mod lobes;
mod material;
mod reflector;
mod scattering;
mod spans;

#[cfg(test)]
pub(crate) mod tests;

pub use analytic::UpperAnalytic;
pub use constant::UpperConstant;
pub use cube_map::UpperCubeMap;
pub use geometry::{Towards, upper_geometric, upper_transmittance};
pub use light::{LightBounds, LightShape};
pub use material::UpperMaterial;
pub use reflector::Reflector;
pub use scattering::UpperScattering;
