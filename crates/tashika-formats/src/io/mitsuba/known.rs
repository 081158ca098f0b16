//! Parameters of Mitsuba's plugins, in snake case.
//!
//! Parameters that no reader used are looked up in this table. A name that is not a parameter of
//! the plugin is noted, and refused if it is a slip of one that is. The table has parameters and
//! nested objects, of Mitsuba 0.6 and of Mitsuba 3.
//!
//! Sources: the documentation of Mitsuba 0.6 and 3, and the names that plugins of Mitsuba 3.9.1
//! look up. Held to this by `suite::unknown_names::mitsuba_*`.

use super::object::Class;

/// Class, plugins and names of parameters. An empty list of plugins stands for all plugins of the
/// class.
type Row = (Class, &'static [&'static str], &'static [&'static str]);

use Class::{Bsdf, Emitter, Film, Filter, Integrator, Medium, Sampler, Sensor, Shape, Texture};

const ROUGH: &[&str] = &["distribution", "alpha", "alpha_u", "alpha_v", "sample_visible"];
const REGISTRY: &[&str] = &["sigma_t", "albedo", "sigma_a", "sigma_s", "scale", "material", "g", "density"];
const DAY: &[&str] =
    &["latitude", "longitude", "timezone", "year", "month", "day", "hour", "minute", "second"];

/// Parameters of Mitsuba 0.6 and 3, by class and plugin.
const ROWS: &[Row] = &[
    (Integrator, &[], &["max_depth", "min_depth", "rr_depth", "strict_normals", "hide_emitters", "timeout"]),
    (Integrator, &[], &["emitter_samples", "bsdf_samples", "shading_samples", "samples_per_pass", "aovs"]),
    (Integrator, &[], &["block_size", "render_block_size", "sub_integrator", "img", "use_mis", "monochrome"]),
    (
        Integrator,
        &[],
        &["light_image", "sample_direct", "luminance_samples", "separate_direct", "direct_samples"],
    ),
    (Integrator, &[], &["p_large", "two_stage", "bidirectional_mutation", "lens_perturbation", "lambda"]),
    (Integrator, &[], &["multi_chain_perturbation", "caustic_perturbation", "manifold_perturbation"]),
    (Integrator, &[], &["num_chains", "max_chains", "chain_length", "global_photons", "caustic_photons"]),
    (Integrator, &[], &["volume_photons", "global_lookup_radius", "caustic_lookup_radius", "lookup_size"]),
    (Integrator, &[], &["granularity", "photon_count", "initial_radius", "alpha", "max_passes", "clamping"]),
    (Integrator, &[], &["shadow_map_resolution", "ray_length", "field", "undefined", "max_error", "p_value"]),
    (Integrator, &[], &["max_sample_factor", "resolution", "quality", "gradients", "clamp_neighbor"]),
    (Integrator, &[], &["clamp_screen", "overture", "quality_adjustment", "indirect_only", "debug"]),
    (
        Integrator,
        &[],
        &["use_spectral_mis", "sppc", "sppp", "sppi", "antithetic_sampling", "single_bounce", "max_bounces"],
    ),
    (Sampler, &[], &["sample_count", "seed", "jitter", "dimension", "dimensions", "scramble", "strength"]),
    (Filter, &[], &["radius", "stddev", "b", "c", "lobes"]),
    (Film, &[], &["width", "height", "size", "crop_offset_x", "crop_offset_y", "crop_width", "crop_height"]),
    (Film, &[], &["sample_border", "high_quality_edges", "file_format", "pixel_format", "component_format"]),
    (Film, &[], &["banner", "attach_log", "compensate", "gamma", "exposure", "key", "burn", "srf"]),
    (Film, &[], &["tonemap_method", "variable", "digits", "filename", "warn_invalid", "rfilter", "label"]),
    (Sensor, &[], &["to_world", "near_clip", "far_clip", "shutter_open", "shutter_close", "srf", "film"]),
    (Sensor, &[], &["sampler", "medium", "principal_point_offset_x", "principal_point_offset_y"]),
    (Sensor, &[], &["fov", "fov_axis", "focal_length", "focus_distance", "aperture_radius"]),
    (Sensor, &[], &["kc", "radial_distortion", "x", "y", "aperture"]),
    (
        Sensor,
        &["distant"],
        &["direction", "target", "ray_target", "ray_origin", "flip_directions", "orientation"],
    ),
    (Sensor, &["radiancemeter"], &["origin", "direction"]),
    (Emitter, &[], &["sampling_weight", "to_world", "shadow_rays", "medium"]),
    (Emitter, &["area"], &["radiance", "intensity"]),
    (Emitter, &["directionalarea", "constant"], &["radiance"]),
    (Emitter, &["point"], &["position", "intensity"]),
    (Emitter, &["spot"], &["intensity", "cutoff_angle", "beam_width", "texture"]),
    (Emitter, &["directional"], &["direction", "irradiance"]),
    (Emitter, &["collimated"], &["power", "irradiance"]),
    (
        Emitter,
        &["projector"],
        &["irradiance", "scale", "fov", "fov_axis", "focal_length", "near_clip", "far_clip"],
    ),
    (Emitter, &["projector"], &["principal_point_offset_x", "principal_point_offset_y"]),
    (Emitter, &["envmap"], &["filename", "bitmap", "scale", "intensity_scale", "cache", "mis_compensation"]),
    (Emitter, &["envmap"], &["gamma", "data", "raw"]),
    (Emitter, &["sky", "sun", "sunsky"], &["turbidity", "albedo", "sun_direction", "resolution", "stretch"]),
    (Emitter, &["sky", "sun", "sunsky"], &["scale", "sky_scale", "sun_scale", "sun_radius_scale", "extend"]),
    (
        Emitter,
        &["sky", "sun", "sunsky"],
        &["sun_aperture", "complex_sun", "end_year", "end_month", "end_day"],
    ),
    (Emitter, &["sky", "sun", "sunsky"], DAY),
    (Bsdf, &[], &["specular_sampling_weight", "sampling_weight"]),
    (Bsdf, &["diffuse", "roughdiffuse"], &["reflectance", "diffuse_reflectance", "alpha", "use_fast_approx"]),
    (Bsdf, &["dielectric", "thindielectric", "roughdielectric"], &["int_ior", "ext_ior", "eta"]),
    (Bsdf, &["dielectric", "thindielectric", "roughdielectric"], &["specular_reflectance"]),
    (Bsdf, &["dielectric", "thindielectric", "roughdielectric"], &["specular_transmittance"]),
    (Bsdf, &["roughdielectric", "roughconductor", "roughplastic", "pplastic", "roughcoating"], ROUGH),
    (Bsdf, &["conductor", "roughconductor"], &["material", "eta", "k", "ext_eta", "specular_reflectance"]),
    (Bsdf, &["plastic", "roughplastic", "pplastic"], &["int_ior", "ext_ior", "specular_reflectance"]),
    (Bsdf, &["plastic", "roughplastic", "pplastic"], &["diffuse_reflectance", "nonlinear"]),
    (Bsdf, &["principled", "principledthin"], &["base_color", "roughness", "anisotropic", "metallic", "eta"]),
    (
        Bsdf,
        &["principled", "principledthin"],
        &["spec_trans", "diff_trans", "specular", "spec_tint", "sheen"],
    ),
    (Bsdf, &["principled", "principledthin"], &["sheen_tint", "flatness", "clearcoat", "clearcoat_gloss"]),
    (
        Bsdf,
        &["principled", "principledthin"],
        &["diffuse_reflectance_sampling_rate", "clearcoat_sampling_rate"],
    ),
    (Bsdf, &["principled", "principledthin"], &["main_specular_sampling_rate", "diff_trans_sampling_rate"]),
    (Bsdf, &["principled", "principledthin"], &["specular_reflectance_sampling_rate"]),
    (Bsdf, &["principled", "principledthin"], &["specular_transmittance_sampling_rate"]),
    (Bsdf, &["phong", "ward"], &["specular_reflectance", "diffuse_reflectance"]),
    (Bsdf, &["phong"], &["exponent"]),
    (Bsdf, &["ward"], &["variant", "alpha", "alpha_u", "alpha_v"]),
    (Bsdf, &["hair"], &["eumelanin", "pheomelanin", "sigma_a", "int_ior", "ext_ior", "scale_tilt"]),
    (Bsdf, &["hair"], &["longitudinal_roughness", "azimuthal_roughness"]),
    (Bsdf, &["measured", "measured_polarized"], &["filename", "alpha_sample", "wavelength"]),
    (Bsdf, &["irawan"], &["filename", "repeat_u", "repeat_v", "kd", "ks"]),
    (Bsdf, &["hk"], REGISTRY),
    (Bsdf, &["hk"], &["thickness"]),
    (
        Bsdf,
        &["coating", "roughcoating"],
        &["int_ior", "ext_ior", "thickness", "sigma_a", "specular_reflectance"],
    ),
    (Bsdf, &["bumpmap"], &["scale", "texture", "bumpmap"]),
    (Bsdf, &["normalmap"], &["normalmap", "flip_invalid_normals", "use_shadowing_function", "scale"]),
    (Bsdf, &["mask"], &["opacity"]),
    (Bsdf, &["twosided"], &["allow_transmission"]),
    (Bsdf, &["blendbsdf"], &["weight"]),
    (Bsdf, &["mixturebsdf"], &["weights"]),
    (Bsdf, &["difftrans"], &["transmittance"]),
    (Bsdf, &["polarizer", "circular"], &["theta", "transmittance", "polarizing", "left_handed"]),
    (Bsdf, &["retarder"], &["theta", "delta", "transmittance"]),
    (Texture, &[], &["to_uv", "uscale", "vscale", "uoffset", "voffset", "uvscale"]),
    (Texture, &["bitmap"], &["filename", "filter_type", "wrap_mode", "wrap_mode_u", "wrap_mode_v", "raw"]),
    (Texture, &["bitmap"], &["gamma", "channel", "cache", "max_anisotropy", "accel", "format", "filter"]),
    (Texture, &["bitmap"], &["data", "bitmap"]),
    (Texture, &["checkerboard", "gridtexture"], &["color0", "color1", "line_width", "background"]),
    (Texture, &["scale"], &["scale", "value", "texture", "color"]),
    (Texture, &["mesh_attribute"], &["name", "scale"]),
    (Texture, &["wireframe"], &["interior_color", "edge_color", "line_width", "step_width", "color1"]),
    (Texture, &["curvature"], &["curvature", "scale"]),
    (Texture, &["volume"], &["volume"]),
    (Texture, &["uniform", "srgb"], &["value", "color", "wavelength_min", "wavelength_max", "unbounded"]),
    (Texture, &["d65", "blackbody"], &["scale", "color", "temperature", "wavelength_min", "wavelength_max"]),
    (Texture, &["regular", "irregular"], &["values", "wavelengths", "wavelength_min", "wavelength_max"]),
    (Texture, &["regular", "irregular"], &["lambda_min", "lambda_max", "range"]),
    (Shape, &[], &["to_world", "flip_normals", "interior", "exterior", "silhouette_sampling_weight"]),
    (Shape, &["obj", "ply", "serialized", "deformable"], &["filename", "face_normals", "flip_tex_coords"]),
    (Shape, &["obj", "ply", "serialized"], &["max_smooth_angle", "collapse", "shape_index", "shape_name"]),
    (Shape, &["obj", "ply", "serialized"], &["max_error", "srgb", "vertex_count", "recenter"]),
    (Shape, &["sphere", "disk"], &["center", "radius"]),
    (Shape, &["cylinder"], &["p0", "p1", "radius"]),
    (Shape, &["hair"], &["filename", "radius", "angle_threshold", "reduction"]),
    (Shape, &["heightfield"], &["filename", "scale", "shadowing", "width", "height"]),
    (Shape, &["sdfgrid"], &["filename", "grid", "normals", "interpolation", "watertight"]),
    (Shape, &["bsplinecurve", "linearcurve"], &["filename", "control_points", "control_point_count"]),
    (Shape, &["ellipsoids", "ellipsoidsmesh"], &["filename", "data", "centers", "scales", "quaternions"]),
    (
        Shape,
        &["ellipsoids", "ellipsoidsmesh"],
        &["opacities", "scale_factor", "extent", "extent_adaptive_clamping", "shell"],
    ),
    (Medium, &["homogeneous", "heterogeneous"], REGISTRY),
    (Medium, &["homogeneous", "heterogeneous"], &["sample_emitters", "has_spectral_extinction", "strategy"]),
    (Medium, &["homogeneous", "heterogeneous"], &["sampling_density", "method", "step_size", "orientation"]),
    (Medium, &["homogeneous", "heterogeneous"], &["phase", "emission", "majorant_resolution_factor"]),
    (Medium, &["constvolume"], &["value", "to_world"]),
    (Medium, &["gridvolume"], &["filename", "filter_type", "wrap_mode", "raw", "accel", "use_grid_bbox"]),
    (Medium, &["gridvolume"], &["data", "grid", "to_world", "min", "max", "send_data"]),
    (Medium, &["hg"], &["g"]),
    (Medium, &["tabphase"], &["values"]),
    (Medium, &["blendphase", "mixturephase"], &["weight", "weights", "phase_0", "phase_1"]),
    (Medium, &["sggx"], &["s"]),
    (Medium, &["microflake"], &["stddev"]),
    (Medium, &["dipole", "singlescatter"], REGISTRY),
    (Medium, &["dipole", "singlescatter"], &["int_ior", "ext_ior", "irr_samples", "irr_indirect", "quality"]),
    (Medium, &["singlescatter"], &["fast_single_scatter", "fss_samples", "single_scatter_shadow_rays"]),
];

/// Returns true if the name is a parameter of the plugin.
pub(super) fn has(class: Class, plugin: &str, name: &str) -> bool {
    // Films may have any number of captions and header entries. A spectral film has one spectrum
    // for each channel, with any name.
    let is_free = class == Film
        && (name.starts_with("label[") || name.starts_with("metadata[") || plugin == "specfilm");
    is_free || names(class, plugin).any(|known| known == name)
}

/// Returns the parameters of a plugin.
pub(super) fn names(class: Class, plugin: &str) -> impl Iterator<Item = &'static str> {
    let of_this = move |row: &&Row| row.0 == class && (row.1.is_empty() || row.1.contains(&plugin));
    ROWS.iter().filter(of_this).flat_map(|row| row.2.iter().copied())
}

/// Returns true if the name is a parameter of any plugin.
pub(super) fn is_name(name: &str) -> bool {
    ROWS.iter().any(|row| row.2.contains(&name))
}
