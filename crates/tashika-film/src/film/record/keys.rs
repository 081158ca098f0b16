//! Table of the names of metadata values and of their meanings.

use std::fmt;

/// Subject of a metadata value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The truth that the film estimates, of any kind.
    Truth,
    /// The truth that the film estimates, if that truth is a sum over VPLs and gather points.
    Sum,
    /// The way in which the film was made.
    Making,
    /// The part of the image that the film covers, or a finding about it. Parts of one image may
    /// differ in such values.
    Part,
}

/// A row of [`KEYS`]: the name of a value in the metadata of films.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Name in the metadata; the OpenEXR attribute is this name with the prefix `tashika:`.
    pub name: &'static str,
    /// Subject of the value.
    pub about: About,
    /// Meaning of the value.
    pub doc: &'static str,
}

impl AsRef<str> for Key {
    fn as_ref(&self) -> &str {
        self.name
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// Returns the subject of the value of that name; [`About::Making`] for a name that is in no row.
pub fn about(name: &str) -> About {
    KEYS.iter().find(|key| key.name == name).map_or(About::Making, |key| key.about)
}

macro_rules! keys {
    ($($key:ident $name:literal $about:ident, $doc:literal;)+) => {
        $(
            #[doc = $doc]
            pub const $key: Key = Key { name: $name, about: About::$about, doc: $doc };
        )+

        /// All names that this program gives to values of the metadata.
        pub const KEYS: &[Key] = &[$($key),+];
    };
}

keys! {
    VERSION "version" Making, "version of the program";
    SCENE "scene" Truth, "name of the scene";
    SCENE_DIGEST "scene.digest" Truth, "digest of the scene's content, 16 hexadecimal digits";
    SCENE_CHANGES "scene.changes" Making, "what was changed of the scene's lights";
    SCENE_TIME "scene.time" Truth, "when the scene is as it is (s), if a time was asked for and anything in it moves";
    SCENE_LIGHT "scene.light" Making, "`default` if the scene had no light and was given some";
    CAMERA "camera" Truth, "name of the camera";
    CAMERA_SHUTTER "camera.shutter" Truth, "from when to when the shutter is open, if the camera or anything else moves meanwhile: open,close (s)";
    CAMERA_PROJECTION "camera.projection" Making, "projection that was asked for";
    CAMERA_FOV "camera.fov" Making, "field of view that was asked for (degrees)";
    CAMERA_LENS_RADIUS "camera.lens_radius" Making, "radius of the lens that was asked for (m)";
    CAMERA_FOCUS_DISTANCE "camera.focus_distance" Making, "distance of focus that was asked for (m)";
    CAMERA_BLADES "camera.blades" Making, "blades of the lens that were asked for";
    CAMERA_BLADE_ROTATION "camera.blade_rotation" Making, "their rotation that was asked for (degrees)";
    METHOD "method" Making, "name of the method";
    SEED "seed" Sum, "seed of the gather points, or of the paths";
    GATHER_POINTS "gather.points" Sum, "gather points a pixel";
    GATHER_FILTER "gather.filter" Truth, "pixel filter";
    TRUTH "truth" Truth, "what is estimated: `vpl`, `clamped` or `transport`";
    VPLS "vpls" Sum, "VPLs";
    VPLS_REQUESTED "vpls.requested" Sum, "VPLs that were asked for";
    VPLS_DIRECT "vpls.direct" Sum, "VPLs of direct light";
    VPLS_INDIRECT "vpls.indirect" Sum, "VPLs of indirect light";
    VPLS_PATHS "vpls.paths" Sum, "light paths that they come from";
    VPLS_SEED "vpls.seed" Sum, "seed of the light paths";
    VPLS_MAX_DEPTH "vpls.max_depth" Sum, "longest light path (segments)";
    VPLS_SCENE "vpls.scene" Sum, "name of the scene in which they were traced";
    VPLS_CLAMP_DISTANCE "vpls.clamp_distance_m" Sum, "distance below which the geometric term is clamped (m)";
    VPLS_INSTANTS "vpls.instants" Sum, "times at which lights and pixels look at what moves";
    VPLS_GLOSSY_SHARE "vpls.glossy_share" Sum, "share of the glossy reflection that VPLs carry";
    LIGHT_STRAIGHT "light.straight" Making, "of the light that surfaces in view send to the camera, by light paths alone: share that came straight from emitters, 0 to 1";
    LIGHT_SPECULAR "light.specular" Making, "share that came over mirrors or through glass only, 0 to 1";
    LIGHT_SCATTERED "light.scattered" Making, "share that surfaces or media scattered before, 0 to 1";
    LIGHT_OF_SURFACES "light.of_surfaces" Making, "share that surfaces emitted, 0 to 1";
    LIGHT_OF_POINTS "light.of_points" Making, "share that points emitted, 0 to 1";
    LIGHT_OF_INFINITY "light.of_infinity" Making, "share that environments and directional lights emitted, 0 to 1";
    ERROR "error" Making, "relative error that is allowed, 0 to 1";
    ERROR_ABSOLUTE "error_absolute" Making, "error that is enough where it is dark (W·m⁻²·sr⁻¹)";
    CONFIDENCE "confidence" Making, "confidence of the intervals, 0 to 1";
    CONTROL "control" Making, "what the error is the error of: `luminance` or `channels`";
    CLAIM "claim" Making, "kind of the intervals: `calibrated`, `certified` or `audited`";
    MAX_PAIRS "max_pairs" Making, "most pairs a pixel";
    MIN_PAIRS "min_pairs" Making, "fewest pairs a pixel";
    PAIRS_ARE "pairs.are" Making, "what the plane `pairs` counts";
    CUT_SEED "cut.seed" Making, "seed of the samples of cuts";
    PATHS "paths" Making, "paths a pixel";
    PATHS_FIRST "paths.first" Making, "paths a pixel before its first look at the error";
    PATHS_MOST "paths.most" Making, "most paths a pixel";
    LIGHT_GROUPS "light.groups" Making, "groups of lights that were asked for";
    LIGHT_GROUPS_PATHS "light.groups.paths" Making, "paths a pixel that tell what they give, where pixels are not by paths";
    MAX_DEPTH "max_depth" Making, "longest path (segments)";
    WINDOW "window" Making, "the part of the image that was asked for: x,y,width,height (pixels)";
    PIXELS "pixels" Making, "pixels, if they were named one by one";
    TILES "tiles" Part, "shares of the tiles: numbers/all";
    COMPLETE "complete" Part, "whether every pixel that was asked for was rendered";
    AUDIT_OF "audit.of" Part, "pixels that an audit looked at";
    AUDIT_WITHIN "audit.within" Part, "of these, pixels within the allowed error";
    AUDIT_SHARE "audit.share" Making, "share of the pixels that is to be within the error, 0 to 1";
    AUDIT_ASSURANCE "audit.assurance" Making, "how sure that is to be, 0 to 1";
    AUDIT_UPPER_OUTSIDE "audit.upper_outside" Part, "share of the pixels that is outside of the error at most, that sure";
    AUDIT_REACHED "audit.reached" Part, "whether the audit found that enough pixels are within the error";
    AUDIT_LOOKS "audit.looks" Part, "how often pictures in work were held against the audited pixels";
    AUDIT_MOST_LOOKS "audit.looks.most" Making, "looks that the risk is shared by";
    AUDIT_DRAWN "audit.drawn" Making, "of a picture in parts: pixels that were drawn for the audit, of which those are audited that show more than a constant background";
    AUDIT_POPULATION "audit.population" Part, "pixels that the audited ones were drawn from";
    AUDIT_RAYS "audit.rays" Part, "rays and segments traced for the audit";
    AUDIT_FACTOR "audit.factor" Part, "by how much the audit scaled the map of half-widths";
    FORESEEN "foreseen" Part, "median of the relative errors that the reconstruction foresees, of which nothing is claimed";
    ERROR_BEFORE "error.before" Part, "root mean square of the relative errors of the picture before the last pass, by the samples of that pass; no claim";
    DENOISER "denoiser" Making, "what smoothed the picture, where it is not our own reconstruction";
    PASSES "passes" Part, "passes that the picture was made in";
    AUDIT_KEPT "audit.kept" Part, "the same as `audit.within`, for readers of earlier versions";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_there_once_and_can_name_a_value() {
        let mut metadata = crate::film::Metadata::default();
        for (i, key) in KEYS.iter().enumerate() {
            assert!(KEYS[..i].iter().all(|other| other.name != key.name), "{key} twice");
            metadata.set(key, true);
        }
        assert_eq!(metadata.iter().count(), KEYS.len());
    }

    #[test]
    fn values_say_what_they_are_about() {
        assert_eq!(
            ["seed", "scene", "tiles", "unheard"].map(about),
            [About::Sum, About::Truth, About::Part, About::Making]
        );
    }
}
