//! Readers of mesh files that scene files of several formats can reference.

pub(super) use super::obj::read_mesh as read_obj;
pub(super) use super::ply::read as read_ply;
