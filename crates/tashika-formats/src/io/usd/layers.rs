//! Files of a scene: layers, each read once, with their sublayers.
//!
//! A file that another file names is looked up beside that file, or in the same archive. A missing
//! file is noted; a damaged one is an error.
//!
//! # Guarantee
//! Layers that contain themselves are refused, and no more than [`MAX_LAYERS`] are read.
//!
//! Held to this by `usd` and `damaged_usd` of the suite.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::binary::{self, Bytes};
use super::features::met;
use super::layer::{Layer, PrimSpec};
use super::package::{self, Package};
use super::text;
use super::value::Text;
use super::xml;
use crate::error::{Error, Location, Result};
use crate::io::SceneFiles;
use crate::io::assets::{kind, reason};
use crate::io::files::{folder_of, is_absolute};
use crate::io::notes::quoted;
use crate::scene::{NoteKind, SceneBuilder};

/// Largest number of layers of a scene.
const MAX_LAYERS: usize = 10_000;

/// Largest number of sublayers of a file, including sublayers of sublayers.
const MAX_SUBLAYERS: usize = 1000;

/// Index of a layer of the scene.
pub(super) type LayerId = usize;

/// Index of a stack, which is a layer with all its sublayers.
pub(super) type StackId = usize;

/// Place of a file: beside the scene, or in an archive.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    /// Index of the archive, if the file is in one.
    package: Option<usize>,
    /// File name, relative to the scene's folder or to the archive.
    pub name: String,
}

/// Layers and archives that were opened so far.
pub(super) struct Layers<'f> {
    pub files: &'f SceneFiles,
    layers: Vec<(Layer, Place)>,
    bytes: u64,
    packages: Vec<Package>,
    /// Opened files, by canonical path, or by name in an archive.
    opened: BTreeMap<(Option<usize>, PathBuf), Opened>,
    /// Layers of each stack, from the strongest to the weakest.
    stacks: Vec<Vec<LayerId>>,
    by_root: BTreeMap<LayerId, StackId>,
}

#[derive(Clone, Copy)]
enum Opened {
    Layer(LayerId),
    Package(usize),
}

impl<'f> Layers<'f> {
    /// Opens the scene's own file, which becomes the first stack.
    pub fn open(files: &'f SceneFiles, builder: &mut SceneBuilder) -> Result<Self> {
        let mut layers = Self {
            files,
            layers: Vec::new(),
            bytes: 0,
            packages: Vec::new(),
            opened: BTreeMap::new(),
            stacks: Vec::new(),
            by_root: BTreeMap::new(),
        };
        let bytes = files.read_scene()?;
        let path = files.path().to_owned();
        let own = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let place = Place { package: None, name: own };
        let key = layers.key(&place, &Location::file(&path)).ok();
        let root = layers.add(bytes, &path, place, key)?;
        layers.stack_of(root, builder)?;
        Ok(layers)
    }

    pub fn layer(&self, id: LayerId) -> &Layer {
        &self.layers[id].0
    }

    pub fn stack(&self, id: StackId) -> &[LayerId] {
        &self.stacks[id]
    }

    pub fn spec(&self, (layer, prim): (LayerId, u32)) -> &PrimSpec {
        &self.layers[layer].0.prims[prim as usize]
    }

    /// Returns the length of all files that were read as layers (bytes).
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Returns the path of a prim in its layer.
    pub fn path(&self, (layer, prim): (LayerId, u32)) -> String {
        self.layers[layer].0.path(prim)
    }

    /// Location of a prim.
    pub fn at(&self, (layer, prim): (LayerId, u32), path: &str) -> Location {
        let layer = self.layer(layer);
        layer.at(layer.prims[prim as usize].line, path)
    }

    /// Place of the file that a layer calls `asset`.
    pub fn place(&self, asset: &str, layer: LayerId) -> Place {
        let Place { package, name } = &self.layers[layer].1;
        let name = if is_absolute(asset) { asset.to_owned() } else { format!("{}{asset}", folder_of(name)) };
        Place { package: *package, name }
    }

    /// Bytes of a file that is named at `at`.
    pub fn read(&self, place: &Place, at: &Location) -> Result<Bytes> {
        match place.package {
            None => {
                let bytes = self.files.read(&place.name, at)?;
                let to = bytes.len();
                Ok(Bytes { all: Rc::new(bytes), from: 0, to })
            }
            Some(package) => {
                let package = &self.packages[package];
                package.file(&place.name).ok_or_else(|| {
                    let path = package.name.join(&place.name);
                    Error::io(path, std::io::ErrorKind::NotFound.into())
                })
            }
        }
    }

    /// Returns true if a file is in an archive.
    pub fn is_packed(place: &Place) -> bool {
        place.package.is_some()
    }

    /// Stack of the file that a layer calls `asset`; none, with a note, if the file is missing.
    pub fn stack_at(
        &mut self,
        asset: &str,
        layer: LayerId,
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<Option<StackId>> {
        match self.layer_at(asset, layer, at, builder)? {
            Some(layer) => self.stack_of(layer, builder).map(Some),
            None => Ok(None),
        }
    }

    fn layer_at(
        &mut self,
        asset: &str,
        layer: LayerId,
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<Option<LayerId>> {
        // `a.usdz[b.usd]` is a file in an archive.
        let (asset, inner) = match asset.strip_suffix(']').and_then(|a| a.split_once('[')) {
            Some((archive, inner)) => (archive, Some(inner)),
            None => (asset, None),
        };
        let place = self.place(asset, layer);
        match self.opened_at(place, inner, at) {
            Ok(id) => Ok(Some(id)),
            Err(error) if kind(&error) == NoteKind::Missing => {
                let message =
                    format!("layer {} could not be read ({}): left out", quoted(asset), reason(&error));
                builder.note(NoteKind::Missing, message, at.clone());
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    /// Layer of the file at `place`. If the file is an archive, the layer is its file `inner`, or
    /// else its first file.
    fn opened_at(&mut self, place: Place, inner: Option<&str>, at: &Location) -> Result<LayerId> {
        let key = self.key(&place, at)?;
        let opened = match self.opened.get(&key) {
            Some(opened) => *opened,
            None => {
                let bytes = self.read(&place, at)?;
                self.open_file(bytes, place, key)?
            }
        };
        match opened {
            Opened::Layer(id) => Ok(id),
            Opened::Package(package) => {
                let name = inner.map_or_else(|| self.packages[package].first.clone(), str::to_owned);
                self.packed(Place { package: Some(package), name }, at)
            }
        }
    }

    /// Opens a layer in an archive.
    fn packed(&mut self, place: Place, at: &Location) -> Result<LayerId> {
        let key = (place.package, PathBuf::from(&place.name));
        if let Some(Opened::Layer(id)) = self.opened.get(&key) {
            return Ok(*id);
        }
        let bytes = self.read(&place, at)?;
        match self.open_file(bytes, place, key)? {
            Opened::Layer(id) => Ok(id),
            Opened::Package(_) => Err(Error::unsupported(
                at.clone(),
                "an archive in an archive",
                "put its files beside each other",
            )),
        }
    }

    fn key(&self, place: &Place, at: &Location) -> Result<(Option<usize>, PathBuf)> {
        Ok(match place.package {
            None => (None, self.files.resolve(&place.name, at)?),
            Some(_) => (place.package, package::plain(&place.name).unwrap_or_default().into()),
        })
    }

    fn open_file(&mut self, bytes: Bytes, place: Place, key: (Option<usize>, PathBuf)) -> Result<Opened> {
        let name = match place.package {
            None => self.files.beside(&place.name),
            Some(package) => self.packages[package].name.join(&place.name),
        };
        if bytes.get().starts_with(package::MAGIC) {
            self.packages.push(Package::new(bytes.get().to_vec(), &name)?);
            let opened = Opened::Package(self.packages.len() - 1);
            self.opened.insert(key, opened);
            return Ok(opened);
        }
        self.parse(bytes, &name, place, Some(key)).map(Opened::Layer)
    }

    /// Opens the scene's file, which may be an archive.
    fn add(
        &mut self,
        bytes: Vec<u8>,
        name: &Path,
        place: Place,
        key: Option<(Option<usize>, PathBuf)>,
    ) -> Result<LayerId> {
        if bytes.starts_with(package::MAGIC) {
            let package = Package::new(bytes, name)?;
            let inner = Place { package: Some(0), name: package.first.clone() };
            self.packages.push(package);
            self.opened.extend(key.map(|key| (key, Opened::Package(0))));
            return self.packed(inner, &Location::file(name));
        }
        let to = bytes.len();
        self.parse(Bytes { all: Rc::new(bytes), from: 0, to }, name, place, key)
    }

    fn parse(
        &mut self,
        bytes: Bytes,
        name: &Path,
        place: Place,
        key: Option<(Option<usize>, PathBuf)>,
    ) -> Result<LayerId> {
        if self.layers.len() >= MAX_LAYERS {
            let found = format!("more than {MAX_LAYERS} layers");
            return Err(Error::invalid(Location::file(name), found, "fewer"));
        }
        self.bytes += bytes.get().len() as u64;
        let layer = if bytes.get().starts_with(binary::MAGIC) {
            binary::parse(bytes, name, self.files.options().max_file_bytes)?
        } else if xml::is_document(bytes.get()) {
            xml::parse(bytes.get(), name)?
        } else {
            text::parse(bytes.get(), name)?
        };
        self.layers.push((layer, place));
        let id = self.layers.len() - 1;
        self.opened.extend(key.map(|key| (key, Opened::Layer(id))));
        Ok(id)
    }

    /// Stack of a layer with all its sublayers.
    fn stack_of(&mut self, root: LayerId, builder: &mut SceneBuilder) -> Result<StackId> {
        if let Some(&stack) = self.by_root.get(&root) {
            return Ok(stack);
        }
        let mut all = Vec::new();
        self.collect(root, &mut Vec::new(), &mut all, builder)?;
        self.stacks.push(all);
        self.by_root.insert(root, self.stacks.len() - 1);
        Ok(self.stacks.len() - 1)
    }

    fn collect(
        &mut self,
        id: LayerId,
        open: &mut Vec<LayerId>,
        all: &mut Vec<LayerId>,
        builder: &mut SceneBuilder,
    ) -> Result<()> {
        let at = Location::file(&self.layer(id).name);
        if open.contains(&id) || all.len() >= MAX_SUBLAYERS {
            let expected = format!("at most {MAX_SUBLAYERS} sublayers, none in itself");
            return Err(Error::invalid(at, "a layer that contains itself, or too many", expected));
        }
        all.push(id);
        open.push(id);
        let metadata = &self.layer(id).metadata;
        let sublayers: Vec<Text> = metadata.sublayers.clone();
        if metadata.has_offsets {
            met("composition", "layer offset", at.clone(), builder)?;
        }
        if metadata.has_relocates {
            met("composition", "relocates", at.clone(), builder)?;
        }
        for sublayer in sublayers {
            if let Some(below) = self.layer_at(&sublayer, id, &at, builder)? {
                self.collect(below, open, all, builder)?;
            }
        }
        open.pop();
        Ok(())
    }
}
