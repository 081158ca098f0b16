//! Geometry that does not depend on scenes: boxes, frames, rays, and the error of floating-point
//! sums.

mod aabb;
mod cone;
pub mod elementary;
mod frame;
mod instants;
mod local;
pub mod motion;
mod ray;
mod rounding;
pub mod simd;

pub use aabb::Aabb;
pub use cone::Cone;
pub use frame::Frame;
pub use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat2, Mat3, Quat, Vec2, Vec3};
pub use instants::Instants;
pub use local::{LocalPlaces, local_origin, origin_near, spacing_at};
pub use ray::Ray;
pub use rounding::{GAMMA_4, GAMMA_7, UNIT_ROUNDOFF, gamma, offset_from_surface};
pub use simd::Real;

#[cfg(test)]
mod tests {
    use super::Quat;

    /// `glam` must not use its vector code, which would not give the same bits on all machines. Its
    /// types would then be aligned to 16 bytes instead of 4.
    #[test]
    fn vectors_and_matrices_are_computed_number_by_number() {
        assert_eq!([align_of::<Quat>(), align_of::<glam::Vec4>()], [4; 2]);
    }
}
