//! Materials: `UsdPreviewSurface`, and the choice between the surfaces of a material.
//!
//! A material may have two surfaces. The surface of MaterialX (`outputs:mtlx:surface`,
//! [`materialx`](super::materialx)) is the one that its author sees. The `UsdPreviewSurface` is for
//! programs without MaterialX, and often only a rough approximation. The surface of MaterialX is
//! used if all of its nodes are supported, or if there is no `UsdPreviewSurface`.
//!
//! ```text
//! metallic workflow    base diffuseColor, F₀ = ((n − 1)/(n + 1))² of what is no metal
//! specular workflow    base diffuseColor, no metal, F₀ = specularColor
//! α = roughness², of the coat clearcoatRoughness²
//! ```
//!
//! The surface has holes where the opacity is below `opacityThreshold`. Without a threshold, it is
//! a mix: its share `opacity` is the opaque surface, and the rest is a thin pane of the given index
//! of refraction, which transmits light without refraction. With the mode `presence`, the rest is
//! empty.
//!
//! Material prims with the same opinions are read once. If a material is missing or has no
//! supported surface, the `displayColor` of the drawn prim is used, or grey if it has none.
//!
//! Held to this by `usd_materials` of the suite.

use std::collections::BTreeMap;

use super::Stage;
use super::features::met;
use super::inputs::Reading;
use super::layers::LayerId;
use super::models::Model;
use super::network::Source;
use super::prim::Prim;
use super::primvars::Shown;
use super::sites::Node;
use super::value::Text;
use crate::bsdf::CoatModel;
use crate::color::Rgb;
use crate::error::Result;
use crate::io::dielectrics::{normal_reflectance, single_face};
use crate::io::mixes;
use crate::io::principled::metallic_roughness;
use crate::scene::{Alpha, AlphaMode, Emission, FloatInput, Material, MaterialId, NoteKind, Surface};

/// Properties of a mesh that its material depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshAppearance {
    pub is_double_sided: bool,
    /// Colour and opacity that are used if there is no material.
    pub shown: Shown,
}

/// A material in use.
#[derive(Clone, Debug)]
pub(super) struct UsedMaterial {
    pub id: MaterialId,
    /// Name of the texture coordinates that it uses.
    pub uv: Option<Text>,
}

/// Materials and surfaces that were looked up so far.
#[derive(Default)]
pub(super) struct Materials {
    /// By path of a material: its surface shader, and its identity; none if no surface is
    /// supported.
    by_path: BTreeMap<Text, Option<(Prim, Identity)>>,
    read: BTreeMap<(Identity, bool), UsedMaterial>,
    shown: BTreeMap<[u32; 4], UsedMaterial>,
    /// Paths that were looked up; true for materials.
    pub known: BTreeMap<Text, bool>,
}

/// Specs of a material and of all prims below it.
type Identity = Vec<(LayerId, u32)>;

impl Stage<'_> {
    /// Material at a path. Without a path, or without a supported surface, a material of the
    /// display colour.
    pub fn material(&mut self, path: Option<&Text>, look: MeshAppearance) -> Result<UsedMaterial> {
        let Some(path) = path else { return self.colored(look) };
        let found = match self.materials.by_path.get(path) {
            Some(known) => known.clone(),
            None => {
                let found = self.surface_of(path)?;
                self.materials.by_path.insert(path.clone(), found.clone());
                found
            }
        };
        let Some((shader, identity)) = found else { return self.colored(look) };
        let key = (identity, look.is_double_sided);
        if let Some(known) = self.materials.read.get(&key) {
            return Ok(known.clone());
        }
        let id = self.shader(&shader)?;
        let mut reading = Reading::new(shader, path.to_string());
        let material = match Model::of(&id) {
            Some(model) => self.read_model(&mut reading, model, look)?,
            None => self.read_preview(&mut reading, look)?,
        };
        let used = UsedMaterial { id: self.builder.add_material(material)?, uv: reading.uv };
        self.materials.read.insert(key, used.clone());
        Ok(used)
    }

    fn colored(&mut self, look: MeshAppearance) -> Result<UsedMaterial> {
        let color = look.shown.color.unwrap_or(Rgb::gray(mixes::GREY));
        let opacity = look.shown.opacity.unwrap_or(1.0);
        let [r, g, b] = color.to_array();
        let key = [r, g, b, opacity].map(f32::to_bits);
        if let Some(known) = self.materials.shown.get(&key) {
            return Ok(known.clone());
        }
        let material = Material::new("displayColor", Surface::Lambert { reflectance: color.into() });
        let alpha = (opacity < 1.0).then(|| Alpha { value: opacity.into(), mode: AlphaMode::Blend });
        let material = Material { alpha, ..material };
        let used = UsedMaterial { id: self.builder.add_material(material)?, uv: None };
        self.materials.shown.insert(key, used.clone());
        Ok(used)
    }

    /// Surface shader of a material; none, with a note, if no surface is supported.
    fn surface_of(&mut self, path: &Text) -> Result<Option<(Prim, Identity)>> {
        let Some((node, prim)) = self.composer.node(path, &mut self.builder)? else {
            let at = self.origin.clone().item(&**path);
            self.builder.note(
                NoteKind::Repaired,
                "materials that are not there: the display colour is used",
                at,
            );
            return Ok(None);
        };
        let at = self.at(&prim);
        let [materialx, preview] =
            ["outputs:mtlx:surface", "outputs:surface"].map(|name| self.surface(&prim, name));
        let (materialx, preview) = (materialx?, preview?);
        if !self.connections(&prim, "outputs:volume").is_empty() {
            met("material", "outputs:volume", at.clone(), &mut self.builder)?;
        }
        let is_understood = match &materialx {
            Some(shader) => self.is_understood(shader)?,
            None => false,
        };
        let (first, second) = if is_understood { (materialx, preview) } else { (preview, materialx) };
        let Some(shader) = first.or(second) else {
            let is_materialx = self.properties(&prim).iter().any(|name| name.starts_with("outputs:mtlx"));
            let row = if is_materialx { "another surface of MaterialX" } else { "another surface" };
            met("material", row, at, &mut self.builder)?;
            return Ok(None);
        };
        if !self.connections(&prim, "outputs:displacement").is_empty() {
            met("UsdPreviewSurface", "displacement", at, &mut self.builder)?;
        }
        let mut identity = prim.identity();
        self.identify(&node, &prim, &mut identity)?;
        Ok(Some((shader, identity)))
    }

    /// Shader that is connected to an output of a material, if it is supported.
    fn surface(&mut self, material: &Prim, output: &str) -> Result<Option<Prim>> {
        let Some(Source::Output(shader, _)) = self.source(material, output)? else { return Ok(None) };
        let id = self.shader(&shader)?;
        Ok((is_preview(&id) || Model::of(&id).is_some()).then_some(shader))
    }

    fn identify(&mut self, node: &Node, prim: &Prim, identity: &mut Identity) -> Result<()> {
        for name in self.composer.children(prim) {
            if let Some(child) = self.composer.child(node, &name, &mut self.builder)? {
                let below = self.composer.flat(&child);
                identity.extend(below.identity());
                self.identify(&child, &below, identity)?;
            }
        }
        Ok(())
    }

    fn read_preview(&mut self, r: &mut Reading, look: MeshAppearance) -> Result<Material> {
        let base_color = self.color(r, "diffuseColor", Rgb::gray(0.18), 1.0)?;
        let roughness = self.float(r, "roughness", 0.5, 1.0)?;
        let is_specular = self.input_number(&r.shader, "inputs:useSpecularWorkflow", 0.0)? != 0.0;
        let ior = self.input_number(&r.shader, "inputs:ior", 1.5)?.clamp(0.0, 1e3) as f32;
        let (metallic, f0) = if is_specular {
            (0.0.into(), self.color(r, "specularColor", Rgb::BLACK, 1.0)?)
        } else {
            (self.float(r, "metallic", 0.0, 1.0)?, Rgb::gray(normal_reflectance(ior)).into())
        };
        let mut surface = metallic_roughness(base_color, metallic, roughness, f0);
        let coat = self.float(r, "clearcoat", 0.0, 1.0)?;
        if coat.factor > 0.0 {
            let coat_roughness = self.float(r, "clearcoatRoughness", 0.01, 1.0)?;
            let alpha = self.builder.power(coat_roughness, 2.0)?;
            let base = Material::new(format!("{} below its coat", r.name), surface);
            let base = self.builder.add_material(base)?;
            surface = Surface::Clearcoat { base, amount: coat, alpha, model: CoatModel::Layer };
        }
        let opacity = self.float(r, "opacity", 1.0, 1.0)?;
        let threshold = self.input_number(&r.shader, "inputs:opacityThreshold", 0.0)? as f32;
        let mut alpha = None;
        if opacity.texture.is_some() || opacity.factor < 1.0 {
            let mode = self.input_word(&r.shader, "inputs:opacityMode")?;
            if threshold > 0.0 {
                alpha = Some(Alpha { value: opacity, mode: AlphaMode::Mask { cutoff: threshold } });
            } else if mode.as_deref() == Some("presence") {
                alpha = Some(Alpha { value: opacity, mode: AlphaMode::Blend });
            } else {
                surface = self.partly_clear(r, surface, opacity, (ior, roughness))?;
            }
        }
        let emission = self.color(r, "emissiveColor", Rgb::BLACK, f32::MAX)?;
        let emission = (!emission.factor.is_black())
            .then_some(Emission { radiance: emission, two_sided: look.is_double_sided });
        let normal = self.normal(r, "normal")?;
        let displacement = self.source(&r.shader, "inputs:displacement")?;
        if !matches!(&displacement, None | Some(Source::Value(_)))
            || matches!(&displacement, Some(Source::Value(value)) if value.number().is_some_and(|n| n != 0.0))
        {
            let at = self.at(&r.shader);
            met("UsdPreviewSurface", "displacement", at, &mut self.builder)?;
        }
        Ok(Material { emission, alpha, normal, ..Material::new(r.name.clone(), surface) })
    }

    /// Mix of a surface, with the share `opacity`, and a pane for the rest.
    fn partly_clear(
        &mut self,
        r: &Reading,
        surface: Surface,
        opacity: FloatInput,
        (ior, roughness): (f32, FloatInput),
    ) -> Result<Surface> {
        let at = self.at_property(&r.shader, "inputs:opacity");
        met("UsdPreviewSurface", "opacity", at, &mut self.builder)?;
        // The two faces of the pane together reflect as much as the opaque surface, which has one
        // face.
        let alpha = self.builder.power(roughness, 2.0)?;
        let pane = Surface::ThinGlass {
            ior: single_face(ior.max(1.0)),
            reflectance: Rgb::WHITE.into(),
            transmittance: Rgb::WHITE.into(),
            facets: alpha.into(),
        };
        if opacity.factor <= 0.0 {
            return Ok(pane);
        }
        let parts = [(format!("{}, clear", r.name), pane), (format!("{}, opaque", r.name), surface)];
        mixes::mix(&mut self.builder, parts, opacity)
    }
}

/// Returns true if a shader is a `UsdPreviewSurface`, by its own name or by that of MaterialX.
fn is_preview(id: &str) -> bool {
    id == "UsdPreviewSurface" || id.starts_with("ND_UsdPreviewSurface_surfaceshader")
}
