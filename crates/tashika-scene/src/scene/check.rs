//! Validation of the parts of a scene. Later code relies on it.
//!
//! An error names the field, the value found and the values allowed. Checked by the tests of
//! [`SceneBuilder`](super::SceneBuilder) and by the suites of damaged files.

use glam::Vec2;

use super::part::SurfaceView;
use super::{
    AlphaMode, ColorInput, FacetInput, FloatInput, Image, Material, MaterialId, NormalInput, Pixels, Scene,
    Surface, Texture,
};
use crate::bsdf::ConductorFresnel;
use crate::color::Rgb;
use crate::error::{Error, Location};

/// Field and value that were found, and the values that are expected.
pub(super) struct Wrong {
    found: String,
    expected: String,
}

type Checked = Result<(), Wrong>;

impl Wrong {
    fn new(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { found: found.into(), expected: expected.into() }
    }

    /// Returns the error at a location.
    pub fn error(self, at: Location) -> Error {
        Error::invalid(at, self.found, self.expected)
    }
}

/// Checks the number of texels, and that floating-point texels are finite.
pub(super) fn image(image: &Image) -> Checked {
    let texels = image.pixels.len();
    if texels == 0 || texels as u64 != u64::from(image.width) * u64::from(image.height) {
        return Err(Wrong::new(
            format!("{texels} texels for {}×{}", image.width, image.height),
            "width × height texels, more than none",
        ));
    }
    if let Pixels::Float(p) = &image.pixels
        && let Some(v) = p.iter().flatten().find(|v| !v.is_finite())
    {
        return Err(Wrong::new(format!("a texel of {v}"), "finite numbers"));
    }
    Ok(())
}

/// Checks the parameters of a texture, except its operands, which the builder checks.
pub(super) fn texture(texture: &Texture, scene: &Scene) -> Checked {
    match texture {
        Texture::Constant(c) if !c.is_finite() => {
            Err(Wrong::new(format!("constant = {:?}", c.to_array()), "finite numbers"))
        }
        Texture::Constant(_) => Ok(()),
        Texture::Image(t) if t.image.index() >= scene.images.len() => {
            Err(Wrong::new(format!("image {}", t.image.index()), "an image of this scene"))
        }
        Texture::Image(t) => finite_transform(t.transform.0.is_finite()),
        Texture::Tiles(t) if t.set.index() >= scene.tile_sets.len() => {
            Err(Wrong::new(format!("tiles {}", t.set.index()), "tiles of this scene"))
        }
        Texture::Tiles(t) => finite_transform(t.transform.0.is_finite()),
        Texture::Checkerboard { transform, .. } => finite_transform(transform.0.is_finite()),
        Texture::Power { exponent, .. } => number("exponent", *exponent),
        Texture::Product(..) | Texture::Mix { .. } => Ok(()),
    }
}

fn finite_transform(finite: bool) -> Checked {
    if finite { Ok(()) } else { Err(Wrong::new("a texture transform that is not finite", "finite numbers")) }
}

/// Checks all factors and references, and the parameters of the BSDFs that the material has.
pub(super) fn material<'a>(material: &'a Material, scene: &'a Scene) -> Checked {
    surface(&material.surface)?;
    if let Some(e) = &material.emission {
        color("emission", e.radiance.factor)?;
    }
    if let Some(a) = &material.alpha {
        number("alpha", a.value.factor)?;
        if let AlphaMode::Mask { cutoff } = a.mode
            && cutoff.is_nan()
        {
            return Err(Wrong::new("alpha cutoff = NaN", "a number"));
        }
    }
    match &material.normal {
        Some(NormalInput::Map { scale, .. }) if !scale.is_finite() => {
            return Err(Wrong::new(format!("normal scale = {scale}"), "a finite number"));
        }
        Some(NormalInput::Bump { height }) if !height.factor.is_finite() => {
            return Err(Wrong::new(format!("bump height = {}", height.factor), "a finite number"));
        }
        _ => {}
    }
    if let Some(tangent) = &material.tangent
        && !tangent.rotation.is_finite()
    {
        let found = format!("rotation of the tangent = {}", tangent.rotation);
        return Err(Wrong::new(found, "a finite number"));
    }
    if let Some(t) = material.textures().find(|t| t.index() >= scene.textures.len()) {
        return Err(Wrong::new(format!("texture {}", t.index()), "a texture of this scene"));
    }
    if let Some(m) = material.others().find(|m| m.index() >= scene.materials.len()) {
        return Err(Wrong::new(format!("material {}", m.index()), "a material added before"));
    }
    let layer = &material.surface;
    if let Surface::Sheen { base, .. } | Surface::Clearcoat { base, .. } = layer
        && let Some(other) = without_layer(*base, layer, scene)
    {
        let expected = "a base that is Lambertian, metallic-roughness, principled or a mix of these";
        return Err(Wrong::new(format!("a {} over {other}", layer.kind()), expected));
    }
    let look =
        SurfaceView { materials: &scene.materials, textures: scene.textures(), uv: Vec2::ZERO, cos: 1.0 };
    if matches!(material.surface, Surface::Boundary) {
        // A boundary's BSDF has a refractive index of 1, which is not allowed for other surfaces.
        return Ok(());
    }
    // A material has at most two parts, which the two ends of the range of `u` select.
    for u in [0.0, 1.0f32.next_down()] {
        look.part(material, u).bsdf.validate().map_err(|message| {
            let (found, expected) = message.split_once("; expected ").unwrap_or((&message, "another value"));
            Wrong::new(found, expected)
        })?;
    }
    Ok(())
}

/// Returns the kind of a surface in `base` that cannot lie under this layer, if there is any.
fn without_layer(base: MaterialId, layer: &Surface, scene: &Scene) -> Option<&'static str> {
    match &scene.materials[base.index()].surface {
        // A coat may lie over sheen.
        Surface::Sheen { .. } if matches!(layer, Surface::Clearcoat { .. }) => None,
        Surface::Lambert { .. } | Surface::MetallicRoughness { .. } | Surface::Principled { .. } => None,
        Surface::Mix { first, second, .. } => {
            without_layer(*first, layer, scene).or_else(|| without_layer(*second, layer, scene))
        }
        other => Some(other.kind()),
    }
}

fn color(name: &str, c: Rgb) -> Checked {
    if c.is_valid() {
        Ok(())
    } else {
        Err(Wrong::new(format!("{name} = {:?}", c.to_array()), "finite numbers of at least 0"))
    }
}

fn number(name: &str, v: f32) -> Checked {
    if v.is_finite() && v >= 0.0 {
        Ok(())
    } else {
        Err(Wrong::new(format!("{name} = {v}"), "a finite number of at least 0"))
    }
}

/// Checks the factors by which textures are multiplied.
fn surface(surface: &Surface) -> Checked {
    let color = |name, input: &ColorInput| color(name, input.factor);
    let number = |name, input: &FloatInput| number(name, input.factor);
    let roughness = |facets: &FacetInput| {
        number("alpha", &facets.alpha)?;
        facets.across.iter().try_for_each(|across| number("alpha across the tangent", across))
    };
    match surface {
        Surface::Lambert { reflectance } | Surface::Mirror { reflectance } => {
            color("reflectance", reflectance)
        }
        Surface::Translucent { reflectance, transmittance } => {
            color("reflectance", reflectance)?;
            color("transmittance", transmittance)
        }
        Surface::ThinGlass { reflectance, transmittance, facets, .. } => {
            color("reflectance", reflectance)?;
            color("transmittance", transmittance)?;
            roughness(facets)
        }
        Surface::Phong { diffuse, specular, .. } => {
            color("diffuse", diffuse)?;
            color("specular", specular)
        }
        Surface::Plastic { diffuse, specular, facets, .. } => {
            color("diffuse", diffuse)?;
            color("specular", specular)?;
            roughness(facets)
        }
        Surface::Conductor { fresnel, specular, facets } => {
            color("specular", specular)?;
            roughness(facets)?;
            match fresnel {
                ConductorFresnel::Schlick { f0 } | ConductorFresnel::Passed { f0 } => {
                    color("f0", &(*f0).into())
                }
                ConductorFresnel::Exact { eta, k } => {
                    color("eta", &(*eta).into())?;
                    color("k", &(*k).into())
                }
            }
        }
        Surface::Coated { reflectance, specular, facets, .. } => {
            color("reflectance", reflectance)?;
            color("specular", specular)?;
            roughness(facets)
        }
        Surface::MetallicRoughness { base_color, metallic, roughness, specular_f0, anisotropy, .. } => {
            number("anisotropy", anisotropy)?;
            color("base colour", base_color)?;
            number("metallic", metallic)?;
            number("roughness", roughness)?;
            color("specular f0", specular_f0)
        }
        Surface::AshikhminShirley { diffuse, specular_f0, facets } => {
            color("diffuse", diffuse)?;
            color("specular f0", specular_f0)?;
            roughness(facets)
        }
        Surface::Principled {
            base_color,
            metallic,
            roughness,
            specular_tint,
            sheen,
            sheen_tint,
            flatness,
            anisotropic,
            ior: _,
        } => {
            number("flatness", flatness)?;
            number("anisotropic", anisotropic)?;
            color("base colour", base_color)?;
            number("metallic", metallic)?;
            number("roughness", roughness)?;
            number("specular tint", specular_tint)?;
            number("sheen", sheen)?;
            number("sheen tint", sheen_tint)
        }
        Surface::Glass { reflectance, transmittance, facets, .. } => {
            roughness(facets)?;
            color("reflectance", &(*reflectance).into())?;
            color("transmittance", &(*transmittance).into())
        }
        Surface::Sheen { color: sheen, roughness, .. } => {
            color("colour of the sheen", sheen)?;
            number("roughness of the sheen", roughness)
        }
        Surface::Clearcoat { amount, alpha, .. } => {
            number("amount of the coat", amount)?;
            number("alpha of the coat", alpha)
        }
        Surface::Mix { amount, .. } => number("amount", amount),
        Surface::Boundary => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::CoatModel;
    use crate::scene::SceneBuilder;

    #[test]
    fn layers_lie_over_opaque_surfaces_that_can_have_one() {
        let mut b = SceneBuilder::new("coats", Location::default());
        let mut add = |surface| b.add_material(Material::new("m", surface));
        let gray = || ColorInput::from(Rgb::gray(0.5));
        let coat = |base, amount: f32| {
            let alpha = 0.1.into();
            Surface::Clearcoat { base, amount: amount.into(), alpha, model: CoatModel::Layer }
        };
        let lambert = add(Surface::Lambert { reflectance: gray() }).unwrap();
        let mirror = add(Surface::Mirror { reflectance: gray() }).unwrap();
        let mix = |second| Surface::Mix { first: lambert, second, amount: 0.5.into() };
        let [opaque, half] = [mix(lambert), mix(mirror)].map(|surface| add(surface).unwrap());
        let coated = add(coat(opaque, 1.0)).unwrap();
        let sheen =
            |base, roughness: f32| Surface::Sheen { base, color: gray(), roughness: roughness.into() };
        let cloth = add(sheen(opaque, 0.5)).unwrap();
        add(coat(cloth, 1.0)).unwrap();
        for (base, kind) in [(mirror, "mirror"), (half, "mirror"), (coated, "clear coat")] {
            let errors = [coat(base, 1.0), sheen(base, 0.5)].map(|layer| add(layer).unwrap_err().to_string());
            assert!(errors[0].contains(&format!("a clear coat over {kind}")), "{errors:?}");
            assert!(errors[1].contains(&format!("a sheen over {kind}")), "{errors:?}");
        }
        let error = add(sheen(cloth, 0.5)).unwrap_err().to_string();
        assert!(error.contains("a sheen over sheen"), "{error}");
        let error = add(sheen(lambert, -1.0)).unwrap_err().to_string();
        assert!(error.contains("roughness of the sheen = -1"), "{error}");
        let error = add(coat(lambert, f32::NAN)).unwrap_err().to_string();
        assert!(error.contains("amount of the coat = NaN"), "{error}");
    }
}
