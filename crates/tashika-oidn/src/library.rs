//! The C interface of OIDN: a device on the processor, and a filter for each picture.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::null_mut;

use libloading::Library;

type Handle = *mut c_void;

const DEVICE_TYPE_CPU: c_int = 1;
const FORMAT_FLOAT3: c_int = 3;
const ERROR_NONE: c_int = 0;

macro_rules! functions {
    ($($name:ident: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Functions of the library that are called.
        #[expect(non_snake_case, reason = "as the library names them")]
        struct Functions {
            $($name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// # Safety
            /// `library` must be OIDN 2, and outlive the functions.
            unsafe fn load(library: &Library) -> Result<Self, libloading::Error> {
                // SAFETY: the types are those of the documentation.
                unsafe { Ok(Self { $($name: *library.get(concat!(stringify!($name), "\0").as_bytes())?,)* }) }
            }
        }
    };
}

functions! {
    oidnNewDevice: fn(c_int) -> Handle;
    oidnSetDeviceInt: fn(Handle, *const c_char, c_int);
    oidnSetDeviceBool: fn(Handle, *const c_char, bool);
    oidnGetDeviceInt: fn(Handle, *const c_char) -> c_int;
    oidnGetDeviceError: fn(Handle, *mut *const c_char) -> c_int;
    oidnCommitDevice: fn(Handle);
    oidnReleaseDevice: fn(Handle);
    oidnNewFilter: fn(Handle, *const c_char) -> Handle;
    oidnSetSharedFilterImage: fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
    oidnSetFilterBool: fn(Handle, *const c_char, bool);
    oidnSetFilterFloat: fn(Handle, *const c_char, f32);
    oidnCommitFilter: fn(Handle);
    oidnExecuteFilter: fn(Handle);
    oidnReleaseFilter: fn(Handle);
}

/// A noisy picture and its features, row by row, three numbers a pixel.
pub struct Images {
    /// Width and height (pixels).
    pub size: [usize; 2],
    pub color: Vec<f32>,
    pub albedo: Vec<f32>,
    pub normal: Vec<f32>,
    /// Factor that colours are multiplied by for the network.
    pub scale: f32,
}

/// A device of the library, on the processor.
pub struct Device {
    handle: Handle,
    functions: Functions,
    /// Last field, so that the library is unloaded after everything that needs it.
    _library: Library,
}

// SAFETY: "all API calls are thread-safe" with one exception that does not occur here, objects that
// are released while they are in use (OIDN 2, documentation, "Open Image Denoise API").
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Device {
    /// Loads the library from a file, or by a name that the system resolves, and makes a device on
    /// the processor.
    ///
    /// # Safety
    /// The file must be OIDN 2.
    pub unsafe fn load(path: &Path, threads: usize) -> Result<Self, String> {
        // SAFETY: by the contract of this function; the functions live no longer than the library
        // beside them.
        let (library, functions) = unsafe {
            let library = Library::new(path).map_err(|error| error.to_string())?;
            let functions = Functions::load(&library).map_err(|error| error.to_string())?;
            (library, functions)
        };
        // SAFETY: the call is as documented.
        let handle = unsafe { (functions.oidnNewDevice)(DEVICE_TYPE_CPU) };
        if handle.is_null() {
            return Err("it has no device on the processor".to_owned());
        }
        let device = Self { handle, functions, _library: library };
        let Functions { oidnSetDeviceInt, oidnSetDeviceBool, oidnCommitDevice, .. } = &device.functions;
        // SAFETY: the device is alive, and names end with a zero.
        unsafe {
            oidnSetDeviceInt(handle, c"numThreads".as_ptr(), threads.min(c_int::MAX as usize) as c_int);
            oidnSetDeviceBool(handle, c"setAffinity".as_ptr(), false);
            oidnCommitDevice(handle);
        }
        device.check()?;
        match device.version() {
            [2, ..] => Ok(device),
            [major, minor, _] => Err(format!("it is version {major}.{minor}")),
        }
    }

    /// Major, minor and patch version of the library.
    pub fn version(&self) -> [i32; 3] {
        [c"versionMajor", c"versionMinor", c"versionPatch"].map(|name| {
            // SAFETY: the device is alive, and the name ends with a zero.
            unsafe { (self.functions.oidnGetDeviceInt)(self.handle, name.as_ptr()) }
        })
    }

    /// Returns the picture without its noise.
    pub fn denoise(&self, mut images: Images) -> Result<Vec<f32>, String> {
        let [width, height] = images.size;
        let samples = 3 * width * height;
        let planes = [&images.color, &images.albedo, &images.normal];
        assert!(planes.iter().all(|plane| plane.len() == samples), "planes have the size of the picture");
        let mut output = vec![0.0f32; samples];
        let f = &self.functions;
        // SAFETY: the device is alive; each image has three floats for each of width × height
        // pixels, and outlives the filter; names end with a zero.
        unsafe {
            let filter = (f.oidnNewFilter)(self.handle, c"RT".as_ptr());
            if filter.is_null() {
                self.check()?;
                return Err("there is no filter RT".to_owned());
            }
            let image = |name: &CStr, data: &mut [f32]| {
                let data = data.as_mut_ptr().cast();
                (f.oidnSetSharedFilterImage)(
                    filter,
                    name.as_ptr(),
                    data,
                    FORMAT_FLOAT3,
                    width,
                    height,
                    0,
                    0,
                    0,
                );
            };
            image(c"color", &mut images.color);
            image(c"albedo", &mut images.albedo);
            image(c"normal", &mut images.normal);
            image(c"output", &mut output);
            (f.oidnSetFilterBool)(filter, c"hdr".as_ptr(), true);
            (f.oidnSetFilterFloat)(filter, c"inputScale".as_ptr(), images.scale);
            (f.oidnCommitFilter)(filter);
            (f.oidnExecuteFilter)(filter);
            (f.oidnReleaseFilter)(filter);
        }
        self.check().map(|()| output)
    }

    /// Returns the error since the last check, if there was one.
    fn check(&self) -> Result<(), String> {
        let mut message: *const c_char = null_mut();
        // SAFETY: the device is alive; the message lives until the next error, and is copied.
        unsafe {
            if (self.functions.oidnGetDeviceError)(self.handle, &raw mut message) == ERROR_NONE {
                return Ok(());
            }
            if message.is_null() {
                return Err("an error without a message".to_owned());
            }
            Err(CStr::from_ptr(message).to_string_lossy().into_owned())
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the device is alive and not in use.
        unsafe { (self.functions.oidnReleaseDevice)(self.handle) }
    }
}
