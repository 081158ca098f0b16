//! Random scenes at the ends of the range of numbers: sizes of 10⁻²⁰ to 10¹⁸ m, radiance of 10⁻³⁸
//! to 10³⁸, and triangles without width. Materials, textures, media and cameras are at the limits
//! of accepted values.
//!
//! With every method, each pixel is finite, or has the stop `not finite` and claims nothing. If
//! light and squared lengths are within the range of single precision, all pixels are finite.
//!
//! The seeds of the scenes are fixed, and a message of failure has the number of its scene. Scenes
//! that the builder refuses are skipped. With `TASHIKA_SLOW_TESTS=1` more scenes are drawn.

use std::env;
use std::panic::{AssertUnwindSafe, catch_unwind};

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::bsdf::ConductorFresnel;
use tashika::color::Rgb;
use tashika::film::{Claim, Film, RenderFilm, Stop};
use tashika::math::Vec3;
use tashika::math::elementary::powf;
use tashika::request::{ClaimName, MethodName};
use tashika::rng::{Purpose, Stream};
use tashika::scene::{
    Alpha, AlphaMode, Camera, ColorInput, Emission, Emitter, Environment, Image, ImageTexture, Material,
    MeshData, Pixels, Projection, Scene, SceneBuilder, Surface, Texture,
};

use crate::cases::{builder, cuboid, parallelogram};
use crate::media::add;

const SIZE: [u32; 2] = [4, 3];

/// Range of lengths and radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Range {
    /// Products of drawn numbers are within the range of single precision.
    Within,
    /// Drawn numbers span the whole range of single precision.
    Beyond,
}

/// Generator of a random scene.
struct Draw {
    s: Stream,
    range: Range,
    /// Size of the scene (m).
    size: f32,
}

impl Draw {
    fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.s.below(of.len() as u64) as usize]
    }

    fn chance(&mut self, of: u64) -> bool {
        self.s.below(of) == 0
    }

    /// Returns ten to the power of a uniform number between `from` and `to`.
    fn power(&mut self, from: f32, to: f32) -> f32 {
        powf(10.0, from + (to - from) * self.s.uniform())
    }

    /// Returns a share between 0 and 1, often close to an end.
    fn share(&mut self) -> f32 {
        let middle = self.s.uniform();
        let tiny = self.power(-30.0, -2.0);
        self.one_of(&[0.0, 1.0, middle, tiny, 1.0 - f32::EPSILON / 2.0, f32::MIN_POSITIVE])
    }

    fn ior(&mut self) -> f32 {
        let middle = 1.1 + self.s.uniform();
        self.one_of(&[1.0001, 1.33, 1.5, 5.0, middle])
    }

    fn color(&mut self) -> Rgb {
        Rgb::new(self.share(), self.share(), self.share())
    }

    fn brightness(&mut self) -> f32 {
        match self.range {
            Range::Within => self.power(-12.0, 12.0),
            Range::Beyond => self.power(-38.0, 38.0),
        }
    }

    fn radiance(&mut self) -> Rgb {
        let brightness = self.brightness();
        let color = self.color();
        if self.chance(3) { Rgb::gray(brightness) } else { color * brightness }
    }

    fn place(&mut self) -> Vec3 {
        let on_grid = Vec3::from([0; 3].map(|_| self.one_of(&[-1.0, -0.5, 0.0, 0.5, 1.0])));
        let anywhere = Vec3::from(self.s.uniform_3()) * 2.0 - 1.0;
        let far = if self.range == Range::Beyond && self.chance(8) { self.power(0.0, 6.0) } else { 1.0 };
        (if self.chance(2) { on_grid } else { anywhere }) * self.size * far
    }

    fn edge(&mut self) -> Vec3 {
        let direction = self.place() / self.size;
        let thin = self.power(-7.0, 0.0);
        direction * self.size * self.one_of(&[1.0, 1.0, 1.0, thin])
    }

    fn input(&mut self, b: &mut SceneBuilder) -> ColorInput {
        let color = self.color();
        if !self.chance(4) {
            return color.into();
        }
        let most = self.brightness();
        let texel = |draw: &mut Self| [0; 3].map(|_| draw.share() * if draw.chance(4) { most } else { 1.0 });
        let pixels = Pixels::Float((0..6).map(|_| texel(self)).collect());
        let image = b.add_image(Image { name: "extremes".into(), width: 3, height: 2, pixels }).unwrap();
        let texture = b.add_texture(Texture::Image(ImageTexture::new(image))).unwrap();
        ColorInput { texture: Some(texture), ..color.into() }
    }

    fn surface(&mut self, b: &mut SceneBuilder) -> Surface {
        let (one, other, alpha, ior) = (self.input(b), self.input(b), self.share(), self.ior());
        let fresnel = ConductorFresnel::Schlick { f0: self.color() };
        let exponent = self.one_of(&[0.0, 1.0, 1e3, 1e6]);
        let [metallic, roughness, anisotropy] = [0; 3].map(|_| self.share());
        let (reflectance, transmittance) = (self.color(), self.color());
        match self.s.below(11) {
            0 | 1 => Surface::Lambert { reflectance: one },
            2 => Surface::Phong { diffuse: one, specular: other, exponent },
            3 => Surface::Translucent { reflectance: one, transmittance: other },
            4 => Surface::Plastic { diffuse: one, specular: other, ior, facets: alpha.into() },
            5 => Surface::Conductor { fresnel, specular: one, facets: alpha.into() },
            6 => Surface::MetallicRoughness {
                base_color: one,
                metallic: metallic.into(),
                roughness: roughness.into(),
                specular_f0: other,
                anisotropy: anisotropy.into(),
                model: Default::default(),
            },
            7 => Surface::AshikhminShirley { diffuse: one, specular_f0: other, facets: alpha.into() },
            8 => Surface::Mirror { reflectance: one },
            9 => Surface::Glass { ior, reflectance, transmittance, facets: alpha.into() },
            _ => Surface::ThinGlass { ior, reflectance: one, transmittance: other, facets: alpha.into() },
        }
    }

    fn material(&mut self, b: &mut SceneBuilder) -> Material {
        let mut material = Material::new("extreme", self.surface(b));
        if self.chance(3) {
            let radiance = ColorInput { factor: self.radiance(), ..self.input(b) };
            material.emission = Some(Emission { radiance, two_sided: self.chance(2) });
        }
        if self.chance(6) {
            material.alpha = Some(Alpha { value: self.share().into(), mode: AlphaMode::Blend });
        }
        material
    }

    fn mesh(&mut self) -> MeshData {
        match self.s.below(5) {
            0 => {
                let (one, other) = (self.place(), self.place());
                cuboid(one.min(other), one.max(other), self.chance(2))
            }
            1 => {
                // Degenerate triangles: three corners on a line, or two at the same position. Their
                // neighbours are not degenerate.
                let (corner, edge, other) = (self.place(), self.edge(), self.edge());
                let nearly = self.power(-20.0, -3.0);
                let positions = vec![
                    corner,
                    corner + edge,
                    corner + edge * 2.0,
                    corner,
                    corner + edge * 0.5 + other * nearly,
                    corner + other,
                ];
                let triangles = vec![[0, 1, 2], [0, 3, 1], [0, 4, 1], [1, 4, 5], [0, 5, 4]];
                MeshData { positions, triangles, ..MeshData::default() }
            }
            _ => parallelogram(self.place(), self.edge(), self.edge()),
        }
    }

    fn emitter(&mut self) -> Emitter {
        // The position is often in a surface or at its edge.
        let position = self.place();
        // The intensity is proportional to the square of the scene's size.
        let intensity =
            self.radiance() * if self.range == Range::Within { self.size * self.size } else { 1.0 };
        if self.chance(3) {
            let direction = (self.place() + Vec3::NEG_Y * self.size * 0.1).normalize();
            Emitter::Directional { direction, irradiance: self.radiance() }
        } else {
            Emitter::Point { position, intensity }
        }
    }

    fn camera(&mut self) -> Camera {
        let eye = self.place();
        let target = self.place();
        let fov = self.one_of(&[1e-5, 0.1, 0.7, 2.0, 3.1]);
        let up = self.one_of(&[Vec3::X, Vec3::Y, Vec3::Z]);
        let target = if target == eye { eye + Vec3::NEG_Z * self.size } else { target };
        let camera = Camera::look_at("c", eye, target, up, fov);
        match self.s.below(6) {
            0 => Camera { projection: Projection::Orthographic { height: self.size }, ..camera },
            _ => camera,
        }
    }

    /// Returns a random scene; `None` if the builder refuses it.
    fn scene(&mut self, has_media: bool) -> Option<Scene> {
        let mut b = builder();
        for _ in 0..1 + self.s.below(5) {
            let material = self.material(&mut b);
            let material = b.add_material(material).ok()?;
            let mesh = self.mesh();
            let mesh = b.add_mesh(mesh, material).ok()?;
            b.add_instance(mesh, tashika::math::Affine3A::IDENTITY).ok()?;
        }
        for _ in 0..self.s.below(3) {
            let emitter = self.emitter();
            b.add_emitter(emitter).ok()?;
        }
        if self.chance(2) {
            b.set_environment(Environment::constant(self.radiance())).ok()?;
        }
        let mut camera = self.camera();
        if has_media {
            let [absorbs, scatters] = [0; 2].map(|_| (self.power(-6.0, 6.0) / self.size).min(1e8));
            let asymmetry = self.one_of(&[0.0, 0.999, -0.999, 0.5]);
            camera.medium = Some(add(&mut b, [absorbs; 3], [scatters, 0.0, scatters], asymmetry));
        }
        b.add_camera(camera).ok()?;
        b.build().ok()
    }
}

fn is_slow() -> bool {
    env::var("TASHIKA_SLOW_TESTS").is_ok_and(|value| value == "1")
}

fn draw(number: u64, range: Range) -> Draw {
    let mut s = Stream::new(number, Purpose::Test, range as u64);
    let exponent = match range {
        Range::Within => -6.0 + 12.0 * s.uniform(),
        Range::Beyond => -20.0 + 38.0 * s.uniform(),
    };
    Draw { s, range, size: powf(10.0, exponent) }
}

/// Renders three films: by path tracing, by one of all methods in turn, and with a claim.
fn films(tracer: &Tracer, number: u64) -> Vec<(String, Film)> {
    let plain = || Renderer::on(tracer).size(SIZE).vpls(100);
    let methods: Vec<MethodName> = MethodName::all().collect();
    let method = methods[number as usize % methods.len()];
    let of_sums = if method == MethodName::Path { plain().error(0.2) } else { plain() };
    let default = match number % 3 {
        0 => plain().error(0.3),
        1 => plain().method(MethodName::Path).error(0.3),
        _ => plain().error(0.3).claim(ClaimName::Audited),
    };
    [
        ("paths".to_owned(), plain().method(MethodName::Path).paths(16)),
        (method.name().to_owned(), of_sums.method(method).max_pairs(500)),
        ("with a claim".to_owned(), default.max_pairs(2000)),
    ]
    .into_iter()
    .filter_map(|(name, renderer)| Some((name, renderer.render().ok()?.film)))
    .collect()
}

/// Counts the pixels that are not finite, and asserts that each has the stop for that.
fn not_finite(film: &Film, at: &str) -> u64 {
    let (read, raw) = (RenderFilm::of(film), film.plane("").unwrap());
    for (x, y) in film.window().pixels() {
        let record = read.at(x, y);
        if raw.f32_at(x, y).iter().all(|value| value.is_finite()) {
            let numbers = [record.depth, record.coverage];
            assert!(numbers.iter().all(|value| !value.is_nan()), "{at}: {record:?}");
            let is_known = record.claim == Claim::None || record.half_width.is_finite();
            assert!(is_known && record.stop != Stop::NotFinite, "{at}: {record:?}");
        } else {
            assert_eq!((record.claim, record.stop), (Claim::None, Stop::NotFinite), "{at}");
            assert!(film.plane("half_width").unwrap().f32_at(x, y)[0].is_nan(), "{at}");
        }
    }
    read.tally().not_finite
}

/// Renders the scenes of a range. Returns their number and the messages of failures.
fn search(range: Range, count: u64) -> (u64, Vec<String>) {
    let (mut scenes, mut wrong) = (0, Vec::new());
    for number in 0..count {
        let mut draw = draw(number, range);
        let Some(scene) = draw.scene(number % 5 == 4) else { continue };
        scenes += 1;
        let found = catch_unwind(AssertUnwindSafe(|| {
            let tracer = Tracer::new(scene.into());
            films(&tracer, number)
                .iter()
                .map(|(method, film)| {
                    (method.clone(), not_finite(film, &format!("{range:?} {number}, {method}")))
                })
                .filter(|(_, pixels)| *pixels > 0)
                .collect::<Vec<_>>()
        }));
        match found {
            Err(_) => wrong.push(format!("{range:?} {number}: panic")),
            Ok(found) if range == Range::Within && !found.is_empty() => {
                wrong.push(format!("{range:?} {number}: {found:?}"));
            }
            Ok(_) => {}
        }
    }
    (scenes, wrong)
}

/// Asserts that scenes of a range have no wrong pixel.
fn assert_right(range: Range) {
    let count = if is_slow() { 4000 } else { 8 };
    let (scenes, wrong) = search(range, count);
    assert!(scenes > count / 2, "{scenes} scenes");
    assert!(wrong.is_empty(), "{} of {scenes} scenes:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn within_the_range_of_numbers_all_pixels_are_finite() {
    assert_right(Range::Within);
}

#[test]
fn beyond_the_range_of_numbers_pixels_say_what_they_are() {
    assert_right(Range::Beyond);
}
