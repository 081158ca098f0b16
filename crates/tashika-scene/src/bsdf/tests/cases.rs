//! The list of BSDFs under test.

use std::mem::discriminant;

use super::super::{
    AshikhminShirley, Bsdf, Clearcoat, CoatModel, Coated, Conductor, ConductorFresnel, FacetModel, Glass,
    Lambert, Layered, MAX_ALPHA, MAX_GTR1_ALPHA, MIN_ALPHA, MIN_SHEEN_ROUGHNESS, MetallicRoughness,
    Microfacets, Mirror, Phong, Plastic, Principled, Sheen, ThinGlass, TintedFresnel,
};
use crate::color::Rgb;
use crate::math::elementary::powf;
use crate::rng::Stream;

/// A BSDF with the name that failures report.
pub struct Case {
    pub name: String,
    pub bsdf: Bsdf,
}

/// Number of random BSDFs in the list.
const RANDOM: u64 = 12;

const ORANGE: Rgb = Rgb::new(0.8, 0.5, 0.2);
const BLUE: Rgb = Rgb::new(0.1, 0.2, 0.7);

/// Lists the corners of every variant, then the random sweep.
pub fn all() -> Vec<Case> {
    let mut bsdfs: Vec<(String, Bsdf)> = Vec::new();
    let mut add = |name: String, bsdf: Bsdf| bsdfs.push((name, bsdf));
    for reflectance in [ORANGE, Rgb::WHITE, Rgb::gray(1e-3)] {
        add(format!("Lambert {reflectance:?}"), lambert(reflectance));
    }
    for exponent in [0.0, 1.0, 20.0, 1e3, 1e6] {
        add(format!("Phong n = {exponent}"), phong(BLUE, Rgb::gray(0.3), exponent));
        add(format!("Phong white lobe, n = {exponent}"), phong(Rgb::BLACK, Rgb::WHITE, exponent));
    }
    add("Phong diffuse only".into(), phong(ORANGE, Rgb::BLACK, 50.0));
    let alphas = [MIN_ALPHA, 0.05, 0.4, 1.0];
    let even = FacetModel::ALL.iter().flat_map(|&model| alphas.map(|alpha| Microfacets::even(alpha, model)));
    for facets in even {
        let white = ConductorFresnel::Schlick { f0: Rgb::WHITE };
        add(format!("Conductor white, {facets:?}"), conductor(white, facets));
        add(format!("Conductor gold, {facets:?}"), conductor(gold(), facets));
        add(format!("Plastic, {facets:?}"), plastic(ORANGE, Rgb::gray(0.2), 1.5, facets));
        add(format!("Coated, {facets:?}"), coated(ORANGE, Rgb::WHITE, 1.5, facets));
        add(format!("MetallicRoughness, {facets:?}"), metallic_roughness(ORANGE, Rgb::gray(0.04), facets));
        add(
            format!("Principled, {facets:?}"),
            principled(ORANGE, Rgb::BLACK, 0.5, (0.0, Rgb::BLACK, 1.5), facets),
        );
    }
    for facets in brushed() {
        let white = ConductorFresnel::Schlick { f0: Rgb::WHITE };
        add(format!("Conductor white, {facets:?}"), conductor(white, facets));
        add(format!("MetallicRoughness, {facets:?}"), metallic_roughness(ORANGE, Rgb::gray(0.3), facets));
    }
    let dark = ConductorFresnel::Schlick { f0: Rgb::BLACK };
    add("Conductor black but for grazing light".into(), conductor(dark, 0.2));
    for (alpha, f0) in [(0.05, BLUE), (0.4, Rgb::gray(0.04))] {
        add(format!("Conductor of a pane, {alpha}"), conductor(ConductorFresnel::Passed { f0 }, alpha));
    }
    for ior in [1.0001, 5.0] {
        add(format!("Coated white, ior = {ior}"), coated(Rgb::WHITE, Rgb::WHITE, ior, 0.2));
        add(format!("Coated black, ior = {ior}"), coated(Rgb::BLACK, Rgb::WHITE, ior, 0.2));
    }
    add("Coated without reflection".into(), coated(ORANGE, Rgb::BLACK, 1.5, 0.2));
    let half_metal = MetallicRoughness {
        diffuse: ORANGE * 0.4,
        f0: Rgb::gray(0.04).lerp(ORANGE, 0.6),
        dielectric_f0: Rgb::gray(0.04),
        facets: Microfacets::ggx(0.3),
    };
    add("MetallicRoughness, metallic = 0.6".into(), Bsdf::MetallicRoughness(half_metal));
    add("MetallicRoughness metal".into(), metallic_roughness(Rgb::BLACK, ORANGE, 0.3));
    add("MetallicRoughness white".into(), metallic_roughness(Rgb::WHITE, Rgb::gray(0.04), 0.1));
    for alpha in [[MIN_ALPHA; 2], [0.03; 2], [0.4; 2], [1.0; 2], [0.5, 0.1], [0.2, 1.0]] {
        for f0 in [Rgb::BLACK, BLUE, Rgb::WHITE] {
            let facets = Microfacets { alpha, model: FacetModel::Ggx };
            add(format!("AshikhminShirley, {f0:?}, {alpha:?}"), ashikhmin_shirley(ORANGE, f0, facets));
        }
    }
    add("MetallicRoughness, f0 = 0".into(), metallic_roughness(BLUE, Rgb::BLACK, 0.7));
    let tinted = (0.6, BLUE, 1.2);
    add("Principled smooth".into(), principled(Rgb::WHITE, BLUE * 0.3, 0.0, tinted, 0.1));
    add("Principled rough".into(), principled(ORANGE, Rgb::BLACK, 1.0, tinted, 0.5));
    add("Principled cloth".into(), principled(ORANGE, Rgb::WHITE, 1.0, (0.0, BLUE, 1.0001), 1.0));
    for (roughness, flatness) in [(0.0, 1.0), (0.5, 0.4), (1.0, 1.0)] {
        let name = format!("Principled, roughness {roughness}, flatness {flatness}");
        let of = principled(Rgb::WHITE, Rgb::BLACK, roughness, (0.0, Rgb::BLACK, 1.0001), 0.3);
        add(name, flat(of, flatness));
    }
    add("Principled sheen alone".into(), principled(Rgb::BLACK, BLUE, 1.0, (1.0, Rgb::BLACK, 1.5), 1.0));
    let white = principled(Rgb::WHITE, Rgb::BLACK, 1.0, tinted, 0.3);
    for model in CoatModel::ALL {
        for alpha in [MIN_ALPHA, 0.03, 0.1] {
            let of = |base: Bsdf, amount| clearcoat(base, amount, alpha, model);
            add(format!("Clearcoat of black, {model:?}, {alpha}"), of(lambert(Rgb::BLACK), 1.0));
            add(format!("Clearcoat of white, {model:?}, {alpha}"), of(lambert(Rgb::WHITE), 1.0));
            let metal = metallic_roughness(BLUE, Rgb::gray(0.3), 0.2);
            add(format!("Clearcoat of metal, {model:?}, {alpha}"), of(metal, 0.7));
            add(format!("Clearcoat of principled, {model:?}, {alpha}"), of(white, 0.5));
        }
    }
    add("Clearcoat of nothing".into(), clearcoat(white, 0.0, 0.05, CoatModel::Layer));
    add("Clearcoat, wide".into(), clearcoat(lambert(ORANGE), 1.0, 0.8, CoatModel::Layer));
    for roughness in [MIN_SHEEN_ROUGHNESS, 0.4, 1.0] {
        add(format!("Sheen alone, {roughness}"), sheen(lambert(Rgb::BLACK), Rgb::WHITE, roughness));
        add(format!("Sheen on white, {roughness}"), sheen(lambert(Rgb::WHITE), BLUE, roughness));
        let cloth = sheen(metallic_roughness(ORANGE, Rgb::gray(0.04), 0.5), BLUE, roughness);
        add(format!("Sheen on plastic, {roughness}"), cloth);
        add(format!("Sheen under a coat, {roughness}"), clearcoat(cloth, 0.7, 0.1, CoatModel::Layer));
    }
    add("Mirror".into(), Bsdf::Mirror(Mirror { reflectance: ORANGE }));
    add("Plastic black, ior = 5".into(), plastic(Rgb::BLACK, Rgb::WHITE, 5.0, 0.2));
    add("Plastic without lobe".into(), plastic(ORANGE, Rgb::BLACK, 1.5, 0.2));
    add("ThinGlass".into(), thin_glass(1.5, Rgb::WHITE, ORANGE));
    add("Glass".into(), glass(1.5, Rgb::WHITE, ORANGE));
    add("Glass, ior = 1.0001".into(), glass(1.0001, Rgb::WHITE, Rgb::WHITE));
    let mut stream = super::stream(0);
    for index in 0..RANDOM {
        add(format!("random {index}"), random(&mut stream));
    }
    bsdfs.into_iter().map(|(name, bsdf)| Case { name, bsdf }).collect()
}

/// Facets of two different roughnesses.
pub fn brushed() -> Vec<Microfacets> {
    let of = |alpha: [[f32; 2]; 2]| {
        FacetModel::ALL.iter().flat_map(move |&model| alpha.map(|alpha| Microfacets { alpha, model }))
    };
    let wide = Microfacets { alpha: [MAX_ALPHA, 0.3], model: FacetModel::GgxIndependent };
    of([[0.5, 0.1], [0.2, 1.0]]).chain([wide]).collect()
}

/// Cases that are not specular and therefore have a density.
pub fn smooth() -> Vec<Case> {
    all().into_iter().filter(|case| !case.bsdf.is_specular()).collect()
}

/// Returns a BSDF of a random kind; roughnesses and exponents are uniform in the logarithm.
pub fn random(stream: &mut Stream) -> Bsdf {
    let mut colour = || Rgb::from(stream.uniform_3());
    let (a, b) = (colour(), colour());
    let alpha = powf(MIN_ALPHA, stream.uniform()).max(MIN_ALPHA);
    let model = FacetModel::ALL[stream.below(3) as usize];
    // Every second one is isotropic. The two roughnesses differ by at most a factor of five, so
    // that no lobe is too thin for the quadrature.
    let across = alpha * (0.2 + 0.8 * stream.uniform());
    let across = if stream.below(2) == 0 { alpha } else { across.clamp(MIN_ALPHA, alpha) };
    let facets = Microfacets { alpha: [alpha, across], model };
    let ior = 1.0001 + 3.9 * stream.uniform() * stream.uniform();
    match stream.below(13) {
        0 => lambert(a),
        1 => phong(a * (Rgb::WHITE - b), b, powf(1e6, stream.uniform())),
        2 => conductor(ConductorFresnel::Schlick { f0: a }, facets),
        3 => conductor(ConductorFresnel::Exact { eta: a * 3.0 + Rgb::gray(0.05), k: b * 8.0 }, facets),
        4 => coated(a, b, ior, facets),
        5 => metallic_roughness(a, b, facets),
        6 => Bsdf::Mirror(Mirror { reflectance: a }),
        7 => plastic(a * (Rgb::WHITE - b), b, ior, facets),
        8 => thin_glass(ior, a, b),
        11 => ashikhmin_shirley(a, b, facets),
        9 => {
            let of = principled(a, b, stream.uniform(), (stream.uniform(), b, ior), facets);
            flat(of, [0.0, 1.0, stream.uniform()][stream.below(3) as usize])
        }
        10 => {
            let base = match stream.below(3) {
                0 => lambert(a),
                1 => metallic_roughness(a, b, facets),
                _ => principled(a, Rgb::BLACK, stream.uniform(), (stream.uniform(), b, ior), facets),
            };
            let coat = powf(MIN_ALPHA / MAX_GTR1_ALPHA, stream.uniform()) * MAX_GTR1_ALPHA;
            let model = CoatModel::ALL[stream.below(3) as usize];
            let coated = clearcoat(base, stream.uniform(), coat.max(MIN_ALPHA), model);
            let roughness = MIN_SHEEN_ROUGHNESS + (1.0 - MIN_SHEEN_ROUGHNESS) * stream.uniform();
            if stream.below(2) == 0 { coated } else { sheen(coated, b, roughness) }
        }
        _ => glass(ior, a, b),
    }
}

pub fn ashikhmin_shirley(diffuse: Rgb, f0: Rgb, facets: Microfacets) -> Bsdf {
    let facets = Microfacets { model: FacetModel::Ggx, ..facets };
    Bsdf::AshikhminShirley(AshikhminShirley { diffuse, f0, facets })
}

pub fn lambert(reflectance: Rgb) -> Bsdf {
    Bsdf::Lambert(Lambert { reflectance })
}

pub fn phong(diffuse: Rgb, specular: Rgb, exponent: f32) -> Bsdf {
    Bsdf::Phong(Phong { diffuse, specular, exponent })
}

pub fn conductor(fresnel: ConductorFresnel, facets: impl Into<Microfacets>) -> Bsdf {
    Bsdf::Conductor(Conductor { fresnel, specular: Rgb::WHITE, facets: facets.into() })
}

pub fn plastic(diffuse: Rgb, specular: Rgb, ior: f32, facets: impl Into<Microfacets>) -> Bsdf {
    Bsdf::Plastic(Plastic { diffuse, specular, ior, facets: facets.into() })
}

pub fn thin_glass(ior: f32, reflectance: Rgb, transmittance: Rgb) -> Bsdf {
    Bsdf::ThinGlass(ThinGlass { ior, reflectance, transmittance })
}

pub fn coated(reflectance: Rgb, specular: Rgb, ior: f32, facets: impl Into<Microfacets>) -> Bsdf {
    Bsdf::Coated(Coated { reflectance, specular, ior, facets: facets.into() })
}

pub fn metallic_roughness(diffuse: Rgb, f0: Rgb, facets: impl Into<Microfacets>) -> Bsdf {
    Bsdf::MetallicRoughness(MetallicRoughness { diffuse, f0, dielectric_f0: f0, facets: facets.into() })
}

pub fn principled(
    diffuse: Rgb,
    sheen: Rgb,
    roughness: f32,
    (schlick, f0, ior): (f32, Rgb, f32),
    facets: impl Into<Microfacets>,
) -> Bsdf {
    let fresnel = TintedFresnel { schlick, f0, ior };
    let (flatness, facets) = (0.0, facets.into());
    Bsdf::Principled(Principled { diffuse, roughness, flatness, sheen, fresnel, facets })
}

/// Returns a principled surface with this flatness.
pub fn flat(mut bsdf: Bsdf, flatness: f32) -> Bsdf {
    if let Bsdf::Principled(b) = &mut bsdf {
        b.flatness = flatness;
    }
    bsdf
}

pub fn clearcoat(base: Bsdf, amount: f32, alpha: f32, model: CoatModel) -> Bsdf {
    let layered = Layered::over(&base).expect("a surface that can have a coat");
    Bsdf::Layered(Layered { coat: Clearcoat { amount, alpha, model }, ..layered })
}

pub fn sheen(base: Bsdf, color: Rgb, roughness: f32) -> Bsdf {
    let layered = Layered::over(&base).expect("a surface that can have sheen");
    Bsdf::Layered(Layered { sheen: Sheen { color, roughness }, ..layered })
}

pub fn glass(ior: f32, reflectance: Rgb, transmittance: Rgb) -> Bsdf {
    Bsdf::Glass(Glass { ior, reflectance, transmittance, facets: None })
}

/// Gold near 630, 530 and 460 nm (Johnson and Christy 1972, rounded).
fn gold() -> ConductorFresnel {
    ConductorFresnel::Exact { eta: Rgb::new(0.18, 0.5, 1.4), k: Rgb::new(3.1, 2.2, 1.9) }
}

#[test]
fn the_list_has_every_variant_and_only_valid_parameters() {
    let list = all();
    for case in &list {
        assert_eq!(case.bsdf.validate(), Ok(()), "{}", case.name);
    }
    let mut kinds: Vec<_> = Vec::new();
    for case in &list {
        if !kinds.contains(&discriminant(&case.bsdf)) {
            kinds.push(discriminant(&case.bsdf));
        }
    }
    assert_eq!(kinds.len(), 12, "a variant of `Bsdf` has no case, or this count is old");
}
