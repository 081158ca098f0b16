//! Execution of directives in the order of the text.
//!
//! Directives before `WorldBegin` describe the camera and the film, those after it the scene. Known
//! directives without a meaning here are skipped. A word that is not a directive is an error, so
//! that arbitrary text is not mistaken for an empty scene.
//!
//! Tested by `suite::pbrt`, `suite::damaged_pbrt`.

mod objects;

use std::collections::BTreeMap;

use glam::{DAffine3, DMat4, DVec3};

use self::objects::Instance;
use super::camera::{self, Film, Stand};
use super::known;
use super::lexer::{Lexer, Token, unescape, wide_number};
use super::lights;
use super::loading::Loading;
use super::materials::Materials;
use super::media::{self, Media};
use super::names::{Definition, Named};
use super::parameters::{Parameter, Parameters};
use super::place::Place;
use super::shapes::{Part, Request, Shapes};
use super::spectra;
use super::state::{MAX_DEFAULTS, MAX_SAVED, SavedBy, States};
use super::text::{Text, Texts};
use super::textures::Textures;
use super::transform;
use super::version::Version;
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::SceneFiles;
use crate::io::lights::Surroundings;
use crate::io::notes::excerpt;
use crate::math::motion::Track;
use crate::scene::{NoteKind, Scene};

/// All directives, for the detection of slips.
const DIRECTIVES: [&str; 44] = [
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordinateSystem",
    "CoordSysTransform",
    "Film",
    "Filter",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "Renderer",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "SurfaceIntegrator",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "WorldBegin",
    "WorldEnd",
];

/// The scene as far as it is read.
pub(super) struct Interpreter<'f> {
    loading: Loading<'f>,
    texts: Texts<'f>,
    states: States,
    textures: Textures,
    materials: Materials,
    media: Media,
    shapes: Shapes,
    sky: Surroundings,
    objects: BTreeMap<String, Vec<Part>>,
    /// Instances whose object is not defined yet.
    waiting: Vec<Instance>,
    /// Name and parts of the object between `ObjectBegin` and `ObjectEnd`.
    object: Option<(String, Vec<Part>)>,
    instances: usize,
    camera: Option<(String, Parameters, Stand)>,
    /// Type of the integrator, if the file names one.
    integrator: Option<String>,
    film: Film,
    in_world: bool,
    ended: bool,
}

impl<'f> Interpreter<'f> {
    /// Interpreter before the first directive.
    pub(super) fn new(files: &'f SceneFiles, texts: Texts<'f>, version: Version) -> Self {
        let materials = Materials::new();
        Self {
            loading: Loading::new(files, version),
            texts,
            states: States::new(materials.default_id(), files.options().time()),
            textures: Textures::default(),
            materials,
            integrator: None,
            media: Media::default(),
            shapes: Shapes::default(),
            sky: Surroundings::default(),
            objects: BTreeMap::new(),
            waiting: Vec::new(),
            object: None,
            instances: 0,
            camera: None,
            film: Film::new(version),
            in_world: false,
            ended: false,
        }
    }

    /// Executes a text and the files that it includes; `depth` texts are open.
    pub(super) fn run(&mut self, text: &Text, depth: usize) -> Result<()> {
        let mut lexer = Lexer::new(&text.bytes, text.source.clone());
        while !self.ended {
            let Some(token) = lexer.next()? else { break };
            let place = lexer.place();
            let Token::Word(word) = token else {
                return Err(Error::invalid(place.location(), token.shown(), "a directive"));
            };
            match word {
                b"Include" | b"Import" => {
                    let name = string(&mut lexer, "the name of a file")?;
                    let included = self.texts.include(&name, &text.folder, depth, &place.location())?;
                    if word == b"Include" {
                        self.run(&included, depth + 1)?;
                    } else {
                        self.import(&included, depth + 1, &place)?;
                    }
                }
                _ => self.directive(word, &mut lexer, place)?,
            }
        }
        if self.ended && lexer.next()?.is_some() {
            let at = lexer.place().location();
            self.note(NoteKind::Ignored, "what follows WorldEnd: left out", at);
        }
        Ok(())
    }

    /// Executes a text as `Include` does, and restores the state afterwards.
    fn import(&mut self, text: &Text, depth: usize, place: &Place) -> Result<()> {
        self.save(SavedBy::Attribute, place)?;
        let depth_before = self.states.depth();
        self.run(text, depth)?;
        while self.states.depth() > depth_before {
            self.states.restore(SavedBy::Attribute);
        }
        // If the file has one end directive too many, that has already restored the saved state.
        if self.states.depth() == depth_before {
            self.states.restore(SavedBy::Attribute);
        }
        Ok(())
    }

    /// Builds the scene after the last directive.
    pub(super) fn finish(mut self) -> Result<Scene> {
        let at = Location::file(self.loading.files.path());
        if !self.in_world {
            self.note(NoteKind::Repaired, "no WorldBegin: the scene is empty", at.clone());
        } else if !self.ended && self.loading.version == Version::V3 {
            self.note(NoteKind::Repaired, "no WorldEnd: the scene ends with the file", at.clone());
        }
        if self.object.is_some() || self.states.depth() > 0 {
            self.note(NoteKind::Repaired, "attributes or objects without end: ended with the scene", at);
        }
        self.place_waiting()?;
        self.refuse_slips()?;
        if let Some((class, parameters, stand)) = self.camera.take() {
            camera::add(&mut self.loading, &class, &parameters, &stand, &self.film)?;
        }
        media::finish(&mut self.loading, self.integrator.as_deref());
        if self.sky.hides_constant() {
            let at = Location::file(self.loading.files.path());
            self.note(NoteKind::Ignored, "constant infinite lights beside a map: left out", at);
        }
        let mut builder = self.loading.builder;
        self.sky.finish(&mut builder)?;
        builder.build()
    }

    fn note(&mut self, kind: NoteKind, message: &str, at: Location) {
        self.loading.note(kind, message, at);
    }

    fn directive(&mut self, word: &[u8], lexer: &mut Lexer<'_>, place: Place) -> Result<()> {
        let at = || place.location();
        match word {
            b"Identity" => self.states.replace(DMat4::IDENTITY),
            b"Translate" => {
                let v = numbers::<3>(lexer)?;
                self.states.concatenate(DMat4::from_translation(v.into()));
            }
            b"Scale" => {
                let v = numbers::<3>(lexer)?;
                self.states.concatenate(DMat4::from_scale(v.into()));
            }
            b"Rotate" => {
                let [angle, x, y, z] = numbers(lexer)?;
                let m = transform::rotate(angle, DVec3::new(x, y, z));
                self.concatenate(m, "rotations without axis: left out", at());
            }
            b"LookAt" => {
                let v = numbers::<9>(lexer)?;
                let [eye, target, up] = [0, 3, 6].map(|i| DVec3::new(v[i], v[i + 1], v[i + 2]));
                self.concatenate(
                    transform::look_at(eye, target, up),
                    "LookAt without direction: left out",
                    at(),
                );
            }
            b"Transform" => {
                let m = transform::matrix(&numbers(lexer)?);
                self.states.replace(m);
            }
            b"ConcatTransform" => {
                let m = transform::matrix(&numbers(lexer)?);
                self.states.concatenate(m);
            }
            b"CoordinateSystem" => {
                let name = string(lexer, "the name of a coordinate system")?;
                self.states.name_system(&name);
            }
            b"CoordSysTransform" => {
                let name = string(lexer, "the name of a coordinate system")?;
                if !self.states.replace_by_system(&name) {
                    self.note(NoteKind::Repaired, "coordinate systems without name: left out", at());
                }
            }
            b"ActiveTransform" => {
                let token = lexer.next()?;
                if !matches!(token, Some(Token::Word(which)) if self.states.activate(which)) {
                    let found = shown(token);
                    return Err(Error::invalid(lexer.place().location(), found, "StartTime, EndTime or All"));
                }
            }
            b"TransformTimes" => {
                if !self.states.set_times(numbers(lexer)?) {
                    self.note(NoteKind::Repaired, "TransformTimes that do not rise: passed over", at());
                }
            }
            b"TransformBegin" => self.save(SavedBy::Transform, &place)?,
            b"TransformEnd" => self.restore(SavedBy::Transform, at()),
            b"AttributeBegin" => self.save(SavedBy::Attribute, &place)?,
            b"AttributeEnd" => self.restore(SavedBy::Attribute, at()),
            b"ReverseOrientation" => self.states.current.reverse ^= true,
            b"WorldBegin" => {
                if self.in_world {
                    self.note(NoteKind::Repaired, "WorldBegin in the world: passed over", at());
                } else {
                    self.in_world = true;
                    self.states.begin_world();
                }
            }
            b"WorldEnd" => self.ended = true,
            b"ObjectBegin" => self.begin_object(string(lexer, "the name of an object")?, &place)?,
            b"ObjectEnd" => self.end_object(at()),
            b"ObjectInstance" => {
                let name = string(lexer, "the name of an object")?;
                self.instance(&name, at())?;
            }
            b"NamedMaterial" => {
                let name = string(lexer, "the name of a material")?;
                self.name_material(&name, at());
            }
            b"MediumInterface" => {
                let inside = string(lexer, "the name of a medium")?;
                let outside = if lexer.peek() == Some(b'"') {
                    string(lexer, "the name of a medium")?
                } else {
                    inside.clone()
                };
                self.loading.met("directive", "MediumInterface", "left out", &at())?;
                self.states.current.media = self.media.sides(&mut self.loading, [&inside, &outside], &at());
            }
            b"ColorSpace" => {
                let name = string(lexer, "the name of a colour space")?;
                self.loading.met("color space", &name, "srgb", &at())?;
                self.states.current.primaries = spectra::primaries(&name);
            }
            b"Option" => {
                // `Option` has one parameter, which affects how pbrt runs and not the image.
                let parameters = self.own_parameters(lexer, place)?;
                parameters.accept_known();
                self.loading.note_unused("option", "", &parameters)?;
            }
            b"Texture" => {
                let name = string(lexer, "the name of a texture")?;
                let value_type = string(lexer, "the type of a texture's values")?;
                let class = string(lexer, "the type of a texture")?;
                let parameters = self.parameters(lexer, place, "texture")?;
                let of = match value_type.as_str() {
                    "float" => Named::Float,
                    "color" | "spectrum" => Named::Color,
                    _ => {
                        let types = [&*name, &*value_type, &*class];
                        return self.textures.define(&mut self.loading, types, &parameters);
                    }
                };
                self.meet(Definition { of, name, class, parameters: parameters.into(), to_world: None })?;
            }
            b"Attribute" => {
                let target = string(lexer, "shape, light, material, medium or texture")?;
                let at = place.location();
                let parameters = self.own_parameters(lexer, place)?;
                for parameter in parameters.unused().filter(|p| !known::is_name(&p.name)) {
                    let known = known::names_of_kind(&target).chain(known::names_of_kind("area light"));
                    self.loading.note_unknown(&format!("attribute {target:?}"), known, parameter)?;
                }
                let defaults = &mut self.states.current.defaults;
                defaults.entry(target).or_default().extend(parameters.into_list());
                let bytes: usize = defaults.values().flatten().map(Parameter::bytes).sum();
                if bytes > MAX_DEFAULTS {
                    let found = format!("{bytes} bytes of parameters by Attribute");
                    return Err(Error::invalid(at, found, format!("at most {MAX_DEFAULTS}")));
                }
            }
            _ => return self.directive_of_type(word, lexer, place),
        }
        Ok(())
    }

    /// Executes directives with a type or a name, and parameters.
    fn directive_of_type(&mut self, word: &[u8], lexer: &mut Lexer<'_>, place: Place) -> Result<()> {
        let target = match word {
            b"Shape" => "shape",
            b"Material" | b"MakeNamedMaterial" => "material",
            b"LightSource" | b"AreaLightSource" => "light",
            b"MakeNamedMedium" => "medium",
            b"Camera" | b"Film" | b"Sampler" | b"PixelFilter" | b"Filter" | b"Accelerator"
            | b"Integrator" | b"SurfaceIntegrator" | b"VolumeIntegrator" | b"Renderer" | b"Volume" => "",
            _ => {
                let name = String::from_utf8_lossy(word);
                return Err(match nearest_name(&name, DIRECTIVES) {
                    Some(near) => Error::misspelt(place.location(), "directive", &name, near),
                    None => {
                        Error::invalid(place.location(), Token::Word(word).shown(), "a directive of pbrt")
                    }
                });
            }
        };
        let class = string(lexer, "the name of a type")?;
        let parameters = self.parameters(lexer, place, target)?;
        let at = || parameters.at();
        match word {
            b"Shape" => self.shape(&class, &parameters)?,
            b"Material" => {
                let (textures, materials) = (&self.textures, &mut self.materials);
                self.states.current.material =
                    materials.define(&mut self.loading, textures, &class, &parameters)?;
            }
            b"MakeNamedMaterial" => {
                let (name, class) = (class, String::new());
                let parameters = parameters.into();
                self.meet(Definition { of: Named::Material, name, class, parameters, to_world: None })?;
            }
            b"LightSource" => {
                self.motion(true, &at());
                let to_world = self.place(&at())?;
                if let Some(to_world) = to_world {
                    lights::light(&mut self.loading, &class, &parameters, &to_world, &mut self.sky)?;
                }
            }
            b"AreaLightSource" => {
                self.states.current.area_light = lights::area_light(&mut self.loading, &class, &parameters)?;
            }
            b"Camera" => self.set_camera(class, parameters),
            b"Film" => self.film = Film::read(&mut self.loading, &class, &parameters)?,
            b"MakeNamedMedium" => {
                self.loading.met("directive", "MakeNamedMedium", "left out", &at())?;
                let (name, class, to_world) = (class, String::new(), self.states.affine());
                self.meet(Definition {
                    of: Named::Medium,
                    name,
                    class,
                    parameters: parameters.into(),
                    to_world,
                })?;
            }
            b"Volume" => self.loading.met("directive", "Volume", "left out", &at())?,
            b"Integrator" => {
                self.without_effect("integrator", &class, &parameters)?;
                self.integrator = Some(class);
            }
            // Sampling and filtering in pbrt are no part of the scene.
            b"Sampler" => self.without_effect("sampler", &class, &parameters)?,
            b"PixelFilter" | b"Filter" => self.without_effect("filter", &class, &parameters)?,
            b"Accelerator" => self.without_effect("accelerator", &class, &parameters)?,
            // Directives of version 2.
            _ => {}
        }
        Ok(())
    }

    /// Notes unknown parameters of a directive that has no effect on the picture.
    fn without_effect(&mut self, kind: &str, class: &str, parameters: &Parameters) -> Result<()> {
        parameters.accept_known();
        self.loading.note_unused(kind, class, parameters)
    }

    /// Executes a definition, unless it was already executed ahead of this reading.
    fn meet(&mut self, definition: Definition) -> Result<()> {
        if self.loading.names.was_ahead(&definition) {
            return Ok(());
        }
        self.define(&definition)?;
        if self.loading.version == Version::V4 {
            self.loading.names.keep(definition);
        }
        Ok(())
    }

    fn define(&mut self, definition: &Definition) -> Result<()> {
        let Definition { of, name, class, parameters, to_world } = definition;
        let (loading, textures) = (&mut self.loading, &mut self.textures);
        match of {
            Named::Float => textures.define(loading, [name, "float", class], parameters),
            Named::Color => textures.define(loading, [name, "spectrum", class], parameters),
            Named::Material => self.materials.define_named(loading, textures, name, parameters),
            Named::Medium => self.media.define(loading, name, parameters, *to_world),
            // Objects are not defined by a single directive.
            Named::Object => Ok(()),
        }
    }

    /// Returns the definitions that a second reading begins with; empty if no second reading is
    /// needed.
    pub(super) fn needed_ahead(&self) -> Vec<Definition> {
        self.loading.names.needed_ahead()
    }

    /// Executes the definitions that a second reading begins with.
    pub(super) fn begin_with(&mut self, ahead: &[Definition]) -> Result<()> {
        self.loading.names.begin_with(ahead);
        ahead.iter().try_for_each(|definition| self.define(definition))
    }

    /// Refuses undefined names that are slips of defined ones.
    fn refuse_slips(&self) -> Result<()> {
        self.loading.names.refuse_slips(|of| match of {
            Named::Float => self.textures.names(true),
            Named::Color => self.textures.names(false),
            Named::Material => self.materials.names(),
            Named::Medium => self.media.names(),
            Named::Object => self.objects.keys().cloned().collect(),
        })
    }

    /// Reads parameters, without the defaults of `Attribute`.
    fn own_parameters(&self, lexer: &mut Lexer<'_>, place: Place) -> Result<Parameters> {
        Parameters::read(lexer, self.states.current.primaries, place)
    }

    /// Reads parameters, with the defaults of `Attribute` for that target.
    fn parameters(&self, lexer: &mut Lexer<'_>, place: Place, target: &str) -> Result<Parameters> {
        let mut parameters = self.own_parameters(lexer, place)?;
        if let Some(defaults) = self.states.current.defaults.get(target) {
            parameters.extend_defaults(defaults);
        }
        Ok(parameters)
    }

    fn concatenate(&mut self, m: Option<DMat4>, otherwise: &str, at: Location) {
        match m {
            Some(m) => self.states.concatenate(m),
            None => self.note(NoteKind::Repaired, otherwise, at),
        }
    }

    fn save(&mut self, by: SavedBy, place: &Place) -> Result<()> {
        if self.states.save(by) {
            return Ok(());
        }
        let found = format!("{} attributes that are not ended", self.states.depth());
        Err(Error::invalid(place.location(), found, format!("at most {MAX_SAVED}")))
    }

    fn restore(&mut self, by: SavedBy, at: Location) {
        match self.states.restore(by) {
            None => self.note(NoteKind::Repaired, "ends of attributes without beginning: passed over", at),
            Some(saved_by) if saved_by != by => {
                let message = "ends that do not match their beginning: what was saved last is taken back";
                self.note(NoteKind::Repaired, message, at);
            }
            Some(_) => {}
        }
    }

    fn name_material(&mut self, name: &str, at: Location) {
        self.states.current.material = self.materials.named(name).unwrap_or_else(|| {
            self.loading.names.miss(Named::Material, name, &at);
            let message = format!("material {:?} is not defined: grey", excerpt(name, 60));
            self.loading.note_named(NoteKind::Repaired, message, "materials are not defined", at);
            self.materials.default_id()
        });
    }

    fn set_camera(&mut self, class: String, parameters: Parameters) {
        let at = parameters.at();
        if self.camera.is_some() {
            self.note(NoteKind::Ignored, "further cameras: the last one is used", at.clone());
        }
        if let Some(times) = self.states.moves() {
            self.loading.builder.add_animated_seconds(times);
        }
        match self.states.inverse().as_ref().and_then(camera::to_world) {
            Some(pose) => {
                let medium = self.states.current.media.outside;
                let stand = Stand { pose, track: self.states.inverses(), medium };
                self.camera = Some((class, parameters, stand));
            }
            None => self.note(
                NoteKind::Repaired,
                "cameras with a transform that cannot be inverted: left out",
                at,
            ),
        }
        self.states.name_inverse("camera");
    }

    /// Times at which the shutter opens and closes (s), as requested or given by the camera; none
    /// if the scene is loaded at a single time.
    fn shutter(&self) -> Option<[f64; 2]> {
        let own =
            self.camera.as_ref().map_or(camera::SHUTTER, |(_, parameters, _)| camera::shutter(parameters));
        self.loading.files.options().exposure(Some(own))
    }

    /// Motion of the current transform while the shutter is open, if it moves. A note is added if
    /// something moves but is placed at one time: the first, or the middle of the time that the
    /// shutter is open.
    fn motion(&mut self, is_light: bool, at: &Location) -> Option<Track> {
        let times = self.states.moves()?;
        self.loading.builder.add_animated_seconds(times);
        let (what, track) = match self.states.track().filter(Track::can_place) {
            _ if is_light => ("lights that move", None),
            Some(track) => ("things that move", Some(track)),
            None => ("things that turn into their mirror image, or flat", None),
        };
        let options = self.loading.files.options();
        let when = match self.shutter() {
            Some(shutter) if track.as_ref().is_some_and(|track| track.moves_between(shutter)) => {
                return track;
            }
            Some([open, close]) if options.shutter.is_some() => {
                if !(close > times[0] && open < times[1] && open < close) {
                    return None;
                }
                "in the middle of the time that the shutter is open"
            }
            // Before its motion begins and after it ends, a shape stays at the nearer end.
            Some(_) if track.is_some() => return track,
            _ if options.at.is_none() => "first",
            _ => return None,
        };
        self.note(NoteKind::Approximated, &format!("{what}: where they are {when}"), at.clone());
        None
    }

    /// Current transform; none, with a note, if it cannot place anything.
    fn place(&mut self, at: &Location) -> Result<Option<DAffine3>> {
        let placed = self.states.affine().filter(|t| transform::placeable(t).is_some());
        if placed.is_none() {
            let message = "shapes and lights with a transform that cannot be inverted: left out";
            self.note(NoteKind::Repaired, message, at.clone());
        }
        Ok(placed)
    }

    fn shape(&mut self, class: &str, parameters: &Parameters) -> Result<()> {
        if !self.in_world {
            self.note(NoteKind::Repaired, "shapes before WorldBegin: taken into the scene", parameters.at());
        }
        let track = self.motion(false, &parameters.at());
        let Some(to_world) = self.place(&parameters.at())? else { return Ok(()) };
        let in_object = self.object.is_some();
        let state = &self.states.current;
        let request = Request { class, parameters, state, in_object, to_world: &to_world };
        let made = self.shapes.make(&mut self.loading, &self.textures, &mut self.materials, &request)?;
        let Some(mesh) = made else { return Ok(()) };
        let part = Part { mesh, to_object: to_world, track };
        match &mut self.object {
            Some((_, parts)) => parts.push(part),
            None => {
                let builder = &mut self.loading.builder;
                match parameters.string("filename").filter(|_| class == "plymesh") {
                    Some(file) => builder.begin_object(file),
                    None => builder.begin_unnamed_object(class),
                }
                self.add_instance(&part, &DAffine3::IDENTITY, None, &parameters.at())?;
            }
        }
        Ok(())
    }
}

/// Text of a token for errors.
fn shown(token: Option<Token<'_>>) -> String {
    token.map_or("the end of the file".to_owned(), |token| token.shown())
}

/// Reads the string that must come next.
fn string(lexer: &mut Lexer<'_>, expected: &str) -> Result<String> {
    match lexer.next()? {
        Some(Token::Quoted(bytes)) => Ok(unescape(bytes)),
        other => {
            let found = shown(other);
            Err(Error::invalid(lexer.place().location(), found, format!("{expected}, in quotation marks")))
        }
    }
}

/// Reads the numbers that must come next, in brackets or without.
fn numbers<const N: usize>(lexer: &mut Lexer<'_>) -> Result<[f64; N]> {
    let bracketed = lexer.peek() == Some(b'[');
    if bracketed {
        lexer.next()?;
    }
    let mut values = [0.0; N];
    for value in &mut values {
        let token = lexer.next()?;
        *value = match token {
            Some(Token::Word(word)) => wide_number(word),
            _ => None,
        }
        .ok_or_else(|| {
            let found = shown(token);
            Error::invalid(lexer.place().location(), found, format!("{N} finite numbers"))
        })?;
    }
    if bracketed {
        let token = lexer.next()?;
        if token != Some(Token::Close) {
            let found = shown(token);
            return Err(Error::invalid(lexer.place().location(), found, format!("\"]\" after {N} numbers")));
        }
    }
    Ok(values)
}
