//! A document of MaterialX that a stage refers to.
#![no_main]

const STAGE: &[u8] = br#"#usda 1.0
def Mesh "Quad" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
    rel material:binding = </M>
}
def "M" ( references = @look.mtlx@</MaterialX/Materials/M> ) { }
"#;

libfuzzer_sys::fuzz_target!(|data: &[u8]| tashika_fuzz::load(&[("scene.usda", STAGE), ("look.mtlx", data)]));
