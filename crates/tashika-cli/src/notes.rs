//! Notes on a scene, for scripts.

use serde::Serialize;
use tashika::scene::{Note, NoteKind, Scene};

/// A note: how the scene that is rendered departs from what its file says.
#[derive(Debug, Serialize)]
pub struct NoteReport {
    /// What was done.
    pub kind: NoteKind,
    /// In words.
    pub message: String,
    /// Where it was met first.
    pub first: String,
    /// How often.
    pub count: u64,
}

/// The notes on a scene, in their order.
pub fn notes(scene: &Scene) -> Vec<NoteReport> {
    let told = |Note { kind, message, first, count }: Note| NoteReport {
        kind,
        message,
        first: first.to_string(),
        count,
    };
    scene.notes().iter().map(told).collect()
}
