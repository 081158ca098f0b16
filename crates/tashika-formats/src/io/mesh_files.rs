//! Readers of mesh files that scenes of several formats name.

pub(super) use super::obj::read_mesh as read_obj;
pub(super) use super::ply::read as read_ply;
