//! pbrt-v3 and pbrt-v4 scene descriptions.
//!
//! Input: a text of directives, files that it includes, and PLY meshes and images beside it.
//! Output: a [`Scene`] in the file's world coordinates, taken as metres.
//!
//! | module | content |
//! |---|---|
//! | [`lexer`], [`place`] | tokens and their places |
//! | [`parameters`], [`known`] | parameter lists, and the parameters that exist |
//! | [`names`] | names that a scene defines, before or after their use |
//! | [`text`], [`version`] | included files; the format of a scene |
//! | [`interpreter`], [`state`], [`transform`] | directives in order, saved states, matrices |
//! | [`camera`] | camera and film |
//! | [`lights`], [`image_lights`] | lights and environments; lights with an image |
//! | [`spectra`], [`roughness`] | colours and roughness |
//! | [`textures`], [`materials`], [`shapes`] | surfaces |
//! | [`features`] | support of each feature |
//! | [`loading`] | state that all of them share |
//!
//! Objects are kept as instances: a shape between `ObjectBegin` and `ObjectEnd` is one mesh, which
//! each `ObjectInstance` places. The transform of the placement is that of the instance times the
//! one that was current at the shape.
//!
//! # Guarantee
//! Any bytes give a scene or an error with file, line and column. Memory and time are bounded by
//! the sizes of the files and the limits named in the modules; nothing recurses deeper than
//! [`text::MAX_DEPTH`] files. The same files give the same scene.
//!
//! # Limits
//! Lights do not move: each stays where it is at the requested time, or at the first time. Emissive
//! media, curves and measured materials are not supported. Each of these is noted where it occurs
//! in the file.
//!
//! Sources: Pharr et al. 2023; the format descriptions of pbrt-v3 and pbrt-v4 at pbrt.org. Held to
//! this by `suite::pbrt`, `suite::pbrt_appearance`, `suite::damaged_pbrt`.

mod camera;
mod features;
mod image_lights;
mod interpreter;
mod known;
mod lexer;
mod lights;
mod loading;
mod materials;
mod media;
mod names;
mod parameters;
mod place;
mod roughness;
mod shapes;
mod spectra;
mod state;
mod text;
mod textures;
mod transform;
mod version;

pub(super) use self::features::FEATURES;

use self::interpreter::Interpreter;
use self::text::Texts;
use super::SceneFiles;
use crate::error::Result;
use crate::scene::Scene;

/// Reads a pbrt scene.
///
/// # Errors
/// [`Error::Io`](crate::error::Error::Io) if the file or an included file cannot be read; otherwise
/// errors of the text, with their line.
pub(super) fn load(files: &SceneFiles) -> Result<Scene> {
    let mut texts = Texts::new(files);
    let main = texts.main()?;
    let version = text::version(files, &main);
    let mut interpreter = Interpreter::new(files, texts, version);
    interpreter.run(&main, 1)?;
    let ahead = interpreter.needed_ahead();
    if !ahead.is_empty() {
        let mut texts = Texts::new(files);
        let main = texts.main()?;
        interpreter = Interpreter::new(files, texts, version);
        interpreter.begin_with(&ahead)?;
        interpreter.run(&main, 1)?;
    }
    interpreter.finish()
}
