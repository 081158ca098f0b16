//! Parameters of pbrt-v3 and pbrt-v4, by the kind and type of their owner.
//!
//! A parameter that a reader looks up counts as used. The others are looked up in this table. A
//! name that is not a parameter of its owner is noted, and refused if it is a slip of one that is.
//! The table has the names of both formats, and a few of pbrt-v2.
//!
//! Sources: the format descriptions of pbrt-v3 and pbrt-v4 at pbrt.org, and the parameters that
//! their sources look up. Held to this by `suite::unknown_names::pbrt_*`.

/// Kind, types and names of parameters. An empty list of types stands for all types of the kind.
type Row = (&'static str, &'static [&'static str], &'static [&'static str]);

/// Parameters of both formats, by kind and type.
const ROWS: &[Row] = &[
    ("camera", &[], &["shutteropen", "shutterclose", "screenwindow", "frameaspectratio", "hither", "yon"]),
    ("camera", &["perspective"], &["fov", "halffov", "lensradius", "focaldistance"]),
    ("camera", &["orthographic"], &["lensradius", "focaldistance"]),
    ("camera", &["environment", "spherical"], &["mapping", "fov", "halffov", "lensradius", "focaldistance"]),
    ("camera", &["realistic"], &["lensfile", "aperturediameter", "focusdistance", "simpleweighting"]),
    ("camera", &["realistic"], &["aperture", "scale", "filmdistance", "filmdiag", "specfile"]),
    ("film", &[], &["xresolution", "yresolution", "cropwindow", "pixelbounds", "filename", "diagonal"]),
    ("film", &[], &["savefp16", "sensor", "iso", "exposuretime", "whitebalance", "imagingratio", "scale"]),
    ("film", &[], &["maxsampleluminance", "maxcomponentvalue", "display", "writefrequency"]),
    ("film", &["gbuffer"], &["coordinatesystem"]),
    ("film", &["spectral"], &["lambdamin", "lambdamax", "nbuckets", "buckets"]),
    ("shape", &[], &["alpha", "shadowalpha"]),
    ("shape", &["sphere", "cylinder", "paraboloid"], &["radius", "zmin", "zmax", "phimax"]),
    ("shape", &["disk"], &["height", "radius", "innerradius", "phimax"]),
    ("shape", &["cone"], &["height", "radius", "phimax"]),
    ("shape", &["hyperboloid"], &["p1", "p2", "phimax"]),
    (
        "shape",
        &["trianglemesh", "bilinearmesh"],
        &["indices", "P", "N", "S", "uv", "st", "UV", "faceIndices"],
    ),
    ("shape", &["trianglemesh"], &["discarddegenerateUVs"]),
    ("shape", &["bilinearmesh"], &["emissionfilename"]),
    ("shape", &["plymesh"], &["filename", "displacement", "displacement.edgelength", "edgelength"]),
    ("shape", &["loopsubdiv"], &["levels", "nlevels", "indices", "P", "scheme"]),
    ("shape", &["heightfield"], &["nu", "nv", "Pz", "z"]),
    ("shape", &["curve"], &["P", "N", "degree", "basis", "type", "width", "width0", "width1", "splitdepth"]),
    ("shape", &["nurbs"], &["nu", "nv", "uorder", "vorder", "uknots", "vknots", "u0", "v0", "u1", "v1"]),
    ("shape", &["nurbs"], &["P", "Pw"]),
    ("light", &[], &["scale", "power", "illuminance", "nsamples", "samples"]),
    ("light", &["point"], &["I", "from"]),
    ("light", &["spot"], &["I", "from", "to", "coneangle", "conedeltaangle"]),
    ("light", &["distant"], &["L", "from", "to"]),
    ("light", &["infinite"], &["L", "mapname", "filename", "portal"]),
    ("light", &["goniometric"], &["I", "mapname", "filename"]),
    ("light", &["projection"], &["I", "mapname", "filename", "fov"]),
    ("area light", &["diffuse"], &["L", "twosided", "filename", "scale", "power", "nsamples", "samples"]),
    ("material", &[], &["type", "displacement", "normalmap", "bumpmap", "remaproughness"]),
    ("material", &["matte"], &["Kd", "sigma"]),
    ("material", &["plastic"], &["Kd", "Ks", "roughness", "uroughness", "vroughness"]),
    ("material", &["metal"], &["eta", "k", "roughness", "uroughness", "vroughness"]),
    ("material", &["mirror"], &["Kr"]),
    ("material", &["glass"], &["Kr", "Kt", "eta", "index", "roughness", "uroughness", "vroughness"]),
    ("material", &["uber"], &["Kd", "Ks", "Kr", "Kt", "eta", "index", "opacity"]),
    ("material", &["uber"], &["roughness", "uroughness", "vroughness"]),
    ("material", &["substrate"], &["Kd", "Ks", "roughness", "uroughness", "vroughness"]),
    ("material", &["translucent"], &["Kd", "Ks", "reflect", "transmit"]),
    ("material", &["translucent"], &["roughness", "uroughness", "vroughness"]),
    ("material", &["disney"], &["color", "anisotropic", "clearcoat", "clearcoatgloss", "eta", "metallic"]),
    ("material", &["disney"], &["roughness", "scatterdistance", "sheen", "sheentint", "speculartint"]),
    ("material", &["disney"], &["spectrans", "thin", "difftrans", "flatness"]),
    ("material", &["hair"], &["color", "reflectance", "sigma_a", "eumelanin", "pheomelanin"]),
    ("material", &["hair"], &["eta", "beta_m", "beta_n", "alpha"]),
    ("material", &["subsurface", "kdsubsurface"], &["name", "coefficients", "sigma_a", "sigma_s", "mfp"]),
    ("material", &["subsurface", "kdsubsurface"], &["reflectance", "Kd", "Kr", "Kt", "g", "eta", "scale"]),
    ("material", &["subsurface", "kdsubsurface"], &["roughness", "uroughness", "vroughness"]),
    ("material", &["fourier"], &["bsdffile"]),
    ("material", &["measured"], &["filename"]),
    ("material", &["mix"], &["amount", "namedmaterial1", "namedmaterial2", "materials"]),
    ("material", &["diffuse"], &["reflectance", "sigma"]),
    ("material", &["coateddiffuse"], &["reflectance", "roughness", "uroughness", "vroughness", "eta"]),
    (
        "material",
        &["coateddiffuse", "coatedconductor"],
        &["thickness", "g", "albedo", "maxdepth", "nsamples"],
    ),
    ("material", &["coatedconductor"], &["interface.roughness", "interface.uroughness", "interface.eta"]),
    ("material", &["coatedconductor"], &["interface.vroughness", "interface.thickness", "reflectance"]),
    ("material", &["coatedconductor"], &["conductor.roughness", "conductor.uroughness", "conductor.eta"]),
    ("material", &["coatedconductor"], &["conductor.vroughness", "conductor.k"]),
    ("material", &["conductor"], &["eta", "k", "reflectance", "roughness", "uroughness", "vroughness"]),
    ("material", &["dielectric"], &["eta", "roughness", "uroughness", "vroughness"]),
    ("material", &["thindielectric"], &["eta"]),
    ("material", &["diffusetransmission"], &["reflectance", "transmittance", "scale"]),
    ("texture", &[], &["mapping", "uscale", "vscale", "udelta", "vdelta", "v1", "v2"]),
    ("texture", &["constant"], &["value"]),
    ("texture", &["imagemap"], &["filename", "wrap", "filter", "maxanisotropy", "trilinear", "scale"]),
    ("texture", &["imagemap"], &["invert", "encoding", "gamma"]),
    ("texture", &["scale"], &["tex1", "tex2", "tex", "scale"]),
    ("texture", &["mix", "directionmix"], &["tex1", "tex2", "amount", "dir"]),
    ("texture", &["checkerboard"], &["tex1", "tex2", "dimension", "aamode"]),
    ("texture", &["bilerp"], &["v00", "v01", "v10", "v11"]),
    ("texture", &["dots"], &["inside", "outside"]),
    ("texture", &["fbm", "wrinkled", "windy"], &["octaves", "roughness"]),
    ("texture", &["marble"], &["octaves", "roughness", "scale", "variation"]),
    ("texture", &["ptex"], &["filename", "encoding", "scale", "gamma"]),
    ("medium", &[], &["type", "preset", "sigma_a", "sigma_s", "scale", "g", "Le", "Lescale"]),
    ("medium", &["heterogeneous", "uniformgrid", "rgbgrid", "cloud"], &["p0", "p1"]),
    ("medium", &["heterogeneous", "uniformgrid", "rgbgrid"], &["nx", "ny", "nz", "density", "temperature"]),
    ("medium", &["uniformgrid", "nanovdb"], &["temperaturescale", "temperatureoffset", "temperaturecutoff"]),
    ("medium", &["nanovdb"], &["filename", "LeScale"]),
    ("medium", &["cloud"], &["density", "wispiness", "frequency"]),
    ("sampler", &[], &["pixelsamples", "samples", "seed", "randomization", "randomize", "jitter"]),
    ("sampler", &[], &["xsamples", "ysamples", "dimensions", "chunksize", "minsamples", "maxsamples"]),
    ("filter", &[], &["xradius", "yradius", "xwidth", "ywidth", "sigma", "alpha", "B", "C", "tau"]),
    ("accelerator", &[], &["splitmethod", "maxnodeprims", "intersectcost", "traversalcost", "emptybonus"]),
    ("accelerator", &[], &["maxprims", "maxdepth", "refineimmediately"]),
    ("integrator", &[], &["maxdepth", "mindepth", "rrthreshold", "lightsamplestrategy", "lightsampler"]),
    ("integrator", &[], &["regularize", "pixelbounds", "samplelights", "samplebsdf", "cossample"]),
    ("integrator", &[], &["maxdistance", "nsamples", "strategy", "visualizestrategies", "visualizeweights"]),
    ("integrator", &[], &["bootstrapsamples", "chains", "mutationsperpixel", "largestepprobability"]),
    ("integrator", &[], &["sigma", "photonsperiteration", "numiterations", "iterations", "radius"]),
    ("integrator", &[], &["seed", "imagewritefrequency", "filename", "imagefilename", "skipbad", "function"]),
    ("option", &[], &["disablepixeljitter", "disabletexturefiltering", "disablewavelengthjitter"]),
    ("option", &[], &["displacementedgescale", "msereferenceimage", "msereferenceout", "rendercoordsys"]),
    (
        "option",
        &[],
        &["seed", "forcediffuse", "pixelstats", "wavefront", "pixelmaterial", "recordpixelstats"],
    ),
];

/// Returns the parameters of a kind and type.
pub(super) fn names(kind: &str, class: &str) -> impl Iterator<Item = &'static str> {
    let of_this = move |row: &&Row| row.0 == kind && (row.1.is_empty() || row.1.contains(&class));
    ROWS.iter().filter(of_this).flat_map(|row| row.2.iter().copied())
}

/// Returns the parameters of all types of a kind.
pub(super) fn names_of_kind(kind: &str) -> impl Iterator<Item = &'static str> {
    ROWS.iter().filter(move |row| row.0 == kind).flat_map(|row| row.2.iter().copied())
}

/// Returns true if the name is a parameter of any kind.
pub(super) fn is_name(name: &str) -> bool {
    ROWS.iter().any(|row| row.2.contains(&name))
}
