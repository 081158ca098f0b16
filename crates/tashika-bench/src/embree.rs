//! Embree 4, loaded at run time, as another ray tracer for the segments of a render.
//!
//! Declarations follow the documentation of its C interface (Embree 4, `rtcore_*.h`; Apache-2.0).
//! Building this crate needs no part of Embree. PyPI's package `embreex` carries the library.
//!
//! A mesh with one instance is built in world space; other meshes are instanced. Materials that let
//! light pass are evaluated in an occlusion filter, as users of Embree do.

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::ptr::null_mut;
use std::sync::Arc;

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW, Symbol};
use tashika::math::Vec3;
use tashika::scene::{InstanceId, Scene};

/// Range of the ray parameter that is skipped at each end of a segment, so that surfaces do not
/// shadow themselves.
const MARGIN: f32 = 1e-4;

/// Number of segments in a packet of `rtcOccluded16`.
pub const PACKET: usize = 16;

type Handle = *mut c_void;
type Filter = unsafe extern "C" fn(*const FilterArguments);

const GEOMETRY_TRIANGLE: c_uint = 0;
const GEOMETRY_INSTANCE: c_uint = 121;
const BUFFER_INDEX: c_uint = 0;
const BUFFER_VERTEX: c_uint = 1;
const FORMAT_UINT3: c_uint = 0x5003;
const FORMAT_FLOAT3: c_uint = 0x9003;
const FORMAT_FLOAT3X4_COLUMN_MAJOR: c_uint = 0x9234;
const SCENE_ROBUST: c_uint = 1 << 2;
const QUALITY_MEDIUM: c_uint = 1;
const QUERY_COHERENT: c_uint = 1 << 16;
const ALL_FEATURES: c_uint = u32::MAX;
const INVALID: c_uint = u32::MAX;

macro_rules! functions {
    ($($name:ident: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions that are used.
        #[expect(non_snake_case, reason = "as the library names them")]
        struct Functions {
            $($name: Symbol<unsafe extern "C" fn($($argument),*) $(-> $result)?>,)*
        }

        impl Functions {
            /// # Safety
            /// `library` must be Embree 4.
            unsafe fn load(library: &Library) -> Result<Self, libloading::Error> {
                // SAFETY: the types are those of the documentation.
                unsafe { Ok(Self { $($name: library.get(concat!(stringify!($name), "\0").as_bytes())?,)* }) }
            }
        }
    };
}

functions! {
    rtcNewDevice: fn(*const c_char) -> Handle;
    rtcReleaseDevice: fn(Handle);
    rtcGetDeviceError: fn(Handle) -> c_uint;
    rtcNewScene: fn(Handle) -> Handle;
    rtcReleaseScene: fn(Handle);
    rtcSetSceneFlags: fn(Handle, c_uint);
    rtcSetSceneBuildQuality: fn(Handle, c_uint);
    rtcCommitScene: fn(Handle);
    rtcNewGeometry: fn(Handle, c_uint) -> Handle;
    rtcReleaseGeometry: fn(Handle);
    rtcSetNewGeometryBuffer: fn(Handle, c_uint, c_uint, c_uint, usize, usize) -> *mut c_void;
    rtcSetGeometryInstancedScene: fn(Handle, Handle);
    rtcSetGeometryTransform: fn(Handle, c_uint, c_uint, *const f32);
    rtcSetGeometryOccludedFilterFunction: fn(Handle, Filter);
    rtcCommitGeometry: fn(Handle);
    rtcAttachGeometryByID: fn(Handle, Handle, c_uint);
    rtcOccluded1: fn(Handle, *mut Ray1, *mut OccludedArguments);
    rtcOccluded16: fn(*const c_int, Handle, *mut Ray16, *mut OccludedArguments);
    rtcIntersect1: fn(Handle, *mut RayHit1, *mut c_void);
}

/// `RTCRay`.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct Ray1 {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: c_uint,
    id: c_uint,
    flags: c_uint,
}

/// `RTCRayHit`.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RayHit1 {
    ray: Ray1,
    normal: [f32; 3],
    uv: [f32; 2],
    primitive: c_uint,
    geometry: c_uint,
    instance: [c_uint; 2],
}

/// `RTCRay16`.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct Ray16 {
    origin: [[f32; PACKET]; 3],
    near: [f32; PACKET],
    direction: [[f32; PACKET]; 3],
    time: [f32; PACKET],
    far: [f32; PACKET],
    mask: [c_uint; PACKET],
    id: [c_uint; PACKET],
    flags: [c_uint; PACKET],
}

/// Mask of the lanes that hold a ray, aligned as packets have to be.
#[repr(C, align(64))]
struct Valid([c_int; PACKET]);

/// `RTCRayQueryContext`, followed by the state of the filter.
#[repr(C)]
struct Context<'a> {
    instance: [c_uint; 2],
    model: *const Model<'a>,
    visible: [f32; PACKET],
}

/// `RTCOccludedArguments`.
#[repr(C)]
struct OccludedArguments {
    flags: c_uint,
    features: c_uint,
    context: *mut c_void,
    filter: *mut c_void,
    occluded: *mut c_void,
    /// Space for additional fields in other builds of the library.
    reserve: [u64; 4],
}

/// `RTCFilterFunctionNArguments`.
#[repr(C)]
struct FilterArguments {
    valid: *mut c_int,
    user: *mut c_void,
    context: *mut c_void,
    ray: *const f32,
    hit: *const f32,
    count: c_uint,
}

/// Scene data that the filter reads.
struct Model<'a> {
    scene: &'a Scene,
    /// Instance of each geometry of the top scene.
    ids: &'a [InstanceId],
}

// The library's headers give these sizes.
const _: () = assert!(size_of::<Ray1>() == 48 && size_of::<RayHit1>() == 96 && size_of::<Ray16>() == 768);

/// Function of Embree that traces segments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// `rtcOccluded1`, one segment after the other.
    Single,
    /// `rtcOccluded16`.
    Packet,
    /// `rtcOccluded16` with the flag for coherent rays.
    CoherentPacket,
}

/// Options for building a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Build {
    /// Sets `RTC_SCENE_FLAG_ROBUST`.
    pub robust: bool,
    /// Number of threads that build the scene.
    pub threads: u32,
}

/// Loaded library of Embree 4.
pub struct Library4 {
    functions: Functions,
    /// Keeps the functions valid. Never unloaded, as its threads may outlive every handle.
    _library: std::mem::ManuallyDrop<Library>,
}

/// Scene in the form of Embree, with its device.
pub struct Traced<'a> {
    library: &'a Library4,
    scene: Arc<Scene>,
    device: Handle,
    top: Handle,
    /// Instance of each geometry of the top scene.
    ids: Vec<InstanceId>,
}

// SAFETY: a committed scene may be queried from any thread. Until they are dropped, the handles are
// used for queries only.
unsafe impl Sync for Traced<'_> {}

impl Library4 {
    /// Loads the library at `path`.
    ///
    /// # Errors
    /// If there is no library at `path`, or it lacks a function of Embree 4.
    pub fn load(path: &Path) -> Result<Self, libloading::Error> {
        // SAFETY: the caller guarantees that `path` is Embree 4.
        unsafe {
            let library = Library::open(Some(path), RTLD_NOW | RTLD_LOCAL)?;
            Ok(Self { functions: Functions::load(&library)?, _library: std::mem::ManuallyDrop::new(library) })
        }
    }

    /// Builds `scene` on a device of its own.
    pub fn build(&self, scene: &Arc<Scene>, build: Build) -> Traced<'_> {
        let f = &self.functions;
        let config = CString::new(format!("threads={}", build.threads)).expect("no zero inside");
        // SAFETY: a configuration that ends with a zero.
        let device = unsafe { (f.rtcNewDevice)(config.as_ptr()) };
        assert!(!device.is_null(), "Embree makes no device");
        let new_scene = || {
            // SAFETY: the device lives.
            unsafe {
                let new = (f.rtcNewScene)(device);
                (f.rtcSetSceneFlags)(new, if build.robust { SCENE_ROBUST } else { 0 });
                (f.rtcSetSceneBuildQuality)(new, QUALITY_MEDIUM);
                new
            }
        };
        let top = new_scene();
        let mut shared: Vec<Handle> = vec![null_mut(); scene.meshes().len()];
        let ids: Vec<InstanceId> = scene.instance_ids().collect();
        for ((number, instance), &id) in (0u32..).zip(scene.instances()).zip(&ids) {
            let mesh = &scene.meshes()[instance.mesh.index()];
            let transparent = scene.may_be_transparent(id);
            if instance.is_baked() {
                let corners = |k| scene.world_corners(id, k);
                self.attach_triangles(device, top, number, mesh.triangles().len(), corners, transparent);
                continue;
            }
            let below = &mut shared[instance.mesh.index()];
            if below.is_null() {
                *below = new_scene();
                let corners = |k| mesh.corners(k);
                self.attach_triangles(device, *below, 0, mesh.triangles().len(), corners, transparent);
                // SAFETY: a scene that was just made.
                unsafe { (f.rtcCommitScene)(*below) };
            }
            let columns = instance.to_world.to_cols_array();
            // SAFETY: handles that live, a matrix of twelve numbers in columns.
            unsafe {
                let geometry = (f.rtcNewGeometry)(device, GEOMETRY_INSTANCE);
                (f.rtcSetGeometryInstancedScene)(geometry, *below);
                (f.rtcSetGeometryTransform)(geometry, 0, FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.as_ptr());
                (f.rtcCommitGeometry)(geometry);
                (f.rtcAttachGeometryByID)(top, geometry, number);
                (f.rtcReleaseGeometry)(geometry);
            }
        }
        // SAFETY: the handles are valid. An instance holds a reference to its scene, so the scenes
        // can be released.
        unsafe {
            (f.rtcCommitScene)(top);
            for below in shared.into_iter().filter(|below| !below.is_null()) {
                (f.rtcReleaseScene)(below);
            }
            assert_eq!((f.rtcGetDeviceError)(device), 0, "Embree refuses the scene");
        }
        Traced { library: self, scene: Arc::clone(scene), device, top, ids }
    }

    fn attach_triangles(
        &self,
        device: Handle,
        scene: Handle,
        number: u32,
        count: usize,
        corners: impl Fn(u32) -> [Vec3; 3],
        transparent: bool,
    ) {
        let f = &self.functions;
        // SAFETY: the handles are valid, and each buffer is filled with exactly the number of items
        // that it was allocated for.
        unsafe {
            let geometry = (f.rtcNewGeometry)(device, GEOMETRY_TRIANGLE);
            let vertices =
                (f.rtcSetNewGeometryBuffer)(geometry, BUFFER_VERTEX, 0, FORMAT_FLOAT3, 12, 3 * count);
            let indices = (f.rtcSetNewGeometryBuffer)(geometry, BUFFER_INDEX, 0, FORMAT_UINT3, 12, count);
            let (vertices, indices) = (vertices.cast::<[[f32; 3]; 3]>(), indices.cast::<[u32; 3]>());
            for k in 0..count {
                vertices.add(k).write_unaligned(corners(k as u32).map(|v| v.to_array()));
                indices.add(k).write_unaligned([0, 1, 2].map(|corner| 3 * k as u32 + corner));
            }
            if transparent {
                (f.rtcSetGeometryOccludedFilterFunction)(geometry, let_pass);
            }
            (f.rtcCommitGeometry)(geometry);
            (f.rtcAttachGeometryByID)(scene, geometry, number);
            (f.rtcReleaseGeometry)(geometry);
        }
    }
}

/// Multiplies the visibility of each segment by the transmittance of the transparent surface that
/// it hits. Rejects the hit if the product is not zero, so that the segment continues.
///
/// # Safety
/// To be called by Embree, with a [`Context`].
unsafe extern "C" fn let_pass(arguments: *const FilterArguments) {
    // SAFETY: Embree passes pointers and layouts as documented: each field is an array of `count`
    // numbers, and the arrays are contiguous.
    unsafe {
        let arguments = &*arguments;
        let n = arguments.count as usize;
        let context = &mut *arguments.context.cast::<Context<'_>>();
        let model = &*context.model;
        let ray = |field: usize, i: usize| *arguments.ray.add(field * n + i);
        let hit = |field: usize, i: usize| *arguments.hit.add(field * n + i);
        for i in 0..n {
            if *arguments.valid.add(i) == 0 {
                continue;
            }
            let [primitive, geometry, instance] = [5, 6, 7].map(|field| hit(field, i).to_bits());
            let id = model.ids[if instance == INVALID { geometry } else { instance } as usize];
            let direction = if instance == INVALID {
                Vec3::new(ray(4, i), ray(5, i), ray(6, i))
            } else {
                let placed = &model.scene.instances()[id.index()];
                placed.to_world.transform_vector3(Vec3::new(ray(4, i), ray(5, i), ray(6, i)))
            };
            let (u, v) = (hit(3, i), hit(4, i));
            let stopped = model.scene.stopped(id, primitive, [1.0 - u - v, u, v], direction, true);
            let lane = ray(10, i).to_bits() as usize;
            context.visible[lane] *= 1.0 - stopped;
            if context.visible[lane] > 0.0 {
                *arguments.valid.add(i) = 0;
            }
        }
    }
}

impl Traced<'_> {
    fn context(&self, model: &Model<'_>) -> (Context<'static>, OccludedArguments) {
        let context = Context {
            instance: [INVALID; 2],
            model: std::ptr::from_ref(model).cast(),
            visible: [1.0; PACKET],
        };
        let arguments = OccludedArguments {
            flags: 0,
            features: ALL_FEATURES,
            context: null_mut(),
            filter: null_mut(),
            occluded: null_mut(),
            reserve: [0; 4],
        };
        (context, arguments)
    }

    /// Fills `visibility` with the visibility of each segment, in order: 0 if blocked.
    pub fn visibility(&self, segments: &[Segment], call: Call, visibility: &mut Vec<f32>) {
        let model = Model { scene: &self.scene, ids: &self.ids };
        let (mut context, mut arguments) = self.context(&model);
        arguments.context = std::ptr::from_mut(&mut context).cast();
        visibility.clear();
        match call {
            Call::Single => {
                for s in segments {
                    context.visible[0] = 1.0;
                    let mut ray = s.ray();
                    // SAFETY: a committed scene, a ray and arguments of the documented layout.
                    unsafe {
                        (self.library.functions.rtcOccluded1)(self.top, &raw mut ray, &raw mut arguments)
                    };
                    visibility.push(if ray.far < 0.0 { 0.0 } else { context.visible[0] });
                }
            }
            Call::Packet | Call::CoherentPacket => {
                arguments.flags = if call == Call::Packet { 0 } else { QUERY_COHERENT };
                for group in segments.chunks(PACKET) {
                    context.visible = [1.0; PACKET];
                    let mut rays = Ray16::of(group);
                    let valid = Valid(std::array::from_fn(|i| if i < group.len() { -1 } else { 0 }));
                    // SAFETY: as above.
                    unsafe {
                        (self.library.functions.rtcOccluded16)(
                            valid.0.as_ptr(),
                            self.top,
                            &raw mut rays,
                            &raw mut arguments,
                        );
                    }
                    let passed = |i: usize| if rays.far[i] < 0.0 { 0.0 } else { context.visible[i] };
                    visibility.extend((0..group.len()).map(passed));
                }
            }
        }
    }

    /// Fills `parameters` with the ray parameter of each closest hit, infinite if there is none.
    /// Holes are ignored.
    pub fn closest_hits(&self, rays: &[Segment], parameters: &mut Vec<f32>) {
        parameters.clear();
        for s in rays {
            let mut hit = RayHit1 {
                ray: s.ray(),
                normal: [0.0; 3],
                uv: [0.0; 2],
                primitive: INVALID,
                geometry: INVALID,
                instance: [INVALID; 2],
            };
            // SAFETY: a committed scene and a ray of the documented layout. A null pointer means
            // default arguments.
            unsafe { (self.library.functions.rtcIntersect1)(self.top, &raw mut hit, null_mut()) };
            parameters.push(if hit.geometry == INVALID { f32::INFINITY } else { hit.ray.far });
        }
    }
}

impl Drop for Traced<'_> {
    fn drop(&mut self) {
        // SAFETY: the handles are valid, and are not used after this.
        unsafe {
            (self.library.functions.rtcReleaseScene)(self.top);
            (self.library.functions.rtcReleaseDevice)(self.device);
        }
    }
}

/// Segment, or ray to infinity, in the form that ray tracers take.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Start of the segment or ray (m).
    pub origin: Vec3,
    /// Vector to the end of a segment, or the direction of a ray.
    pub direction: Vec3,
    /// Largest ray parameter, 1 at the end of a segment.
    pub t_max: f32,
}

impl Segment {
    fn ray(&self) -> Ray1 {
        Ray1 {
            origin: self.origin.to_array(),
            near: MARGIN,
            direction: self.direction.to_array(),
            time: 0.0,
            far: self.t_max * (1.0 - MARGIN),
            mask: u32::MAX,
            id: 0,
            flags: 0,
        }
    }
}

impl Ray16 {
    fn of(group: &[Segment]) -> Self {
        let mut rays = Self {
            origin: [[0.0; PACKET]; 3],
            near: [MARGIN; PACKET],
            direction: [[1.0; PACKET]; 3],
            time: [0.0; PACKET],
            far: [-1.0; PACKET],
            mask: [u32::MAX; PACKET],
            id: std::array::from_fn(|i| i as u32),
            flags: [0; PACKET],
        };
        for (i, s) in group.iter().enumerate() {
            for axis in 0..3 {
                rays.origin[axis][i] = s.origin[axis];
                rays.direction[axis][i] = s.direction[axis];
            }
            rays.far[i] = s.t_max * (1.0 - MARGIN);
        }
        rays
    }
}
