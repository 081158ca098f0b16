//! Mitsuba's volumes, in a scene whose smoke they are.
#![no_main]

const SCENE: &[u8] = br#"<scene version="3.0.0"><integrator type="volpath"/><emitter type="constant"/>
<shape type="cube"><bsdf type="null"/><medium type="heterogeneous" name="interior">
<volume type="gridvolume" name="sigma_t"><string name="filename" value="a.vol"/></volume>
<volume type="gridvolume" name="albedo"><string name="filename" value="a.vol"/><boolean name="use_grid_bbox" value="true"/></volume>
</medium></shape></scene>"#;

libfuzzer_sys::fuzz_target!(|data: &[u8]| tashika_fuzz::load(&[("scene.xml", SCENE), ("a.vol", data)]));
