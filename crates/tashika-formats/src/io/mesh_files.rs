//! Files of one mesh, as scenes of several formats name them.

pub(super) use super::obj::read_mesh as read_obj;
pub(super) use super::ply::read as read_ply;
