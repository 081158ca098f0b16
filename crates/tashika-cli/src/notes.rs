//! Notes on a scene, for scripts.

use serde::Serialize;
use tashika::scene::{Note, NoteKind, Scene};

/// A difference between the rendered scene and its file.
#[derive(Debug, Serialize)]
pub struct NoteReport {
    /// Effect on the scene, such as `approximated`.
    pub kind: NoteKind,
    /// Description of the difference.
    pub message: String,
    /// Place in the file where the difference occurred first.
    pub first: String,
    /// Number of occurrences.
    pub count: u64,
}

/// Notes on a scene, in the scene's order.
pub fn notes(scene: &Scene) -> Vec<NoteReport> {
    let told = |Note { kind, message, first, count }: Note| NoteReport {
        kind,
        message,
        first: first.to_string(),
        count,
    };
    scene.notes().iter().map(told).collect()
}
