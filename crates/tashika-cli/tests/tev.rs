//! `render --tev`, tested with a server in place of the viewer. The server reads packets according
//! to tev's layout, which `src/tev/packet.rs` states. The image that they form must equal the image
//! in the file.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::thread::{self, JoinHandle};

use assert_cmd::Command;
use tashika::film::{Film, Samples, Window, channel_name};
use tashika::io::read_exr;

/// Starts a viewer that calls `act` with its first connection; returns its address.
fn server<T: Send + 'static>(act: fn(TcpStream) -> T) -> (String, JoinHandle<T>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    (address, thread::spawn(move || act(listener.accept().unwrap().0)))
}

/// Renders the small built-in scene in `folder`; returns exit code and standard error.
fn render(folder: &Path, more: &str) -> (Option<i32>, String) {
    let line = format!("render builtin:tiny --method path --paths 2 -o seen.exr {more}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    let output = command.current_dir(folder).args(line.split_whitespace()).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// Bytes that are read from the front.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> &'a [u8] {
        assert!(count <= self.0.len(), "{count} bytes are wanted, {} are left", self.0.len());
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    fn number<const N: usize, T>(&mut self, read: fn([u8; N]) -> T) -> T {
        read(self.take(N).try_into().unwrap())
    }

    fn flag(&mut self) -> bool {
        let byte = self.take(1)[0];
        assert!(byte <= 1, "a flag of {byte}");
        byte == 1
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).expect("a text ends with a zero");
        String::from_utf8(self.take(end + 1)[..end].to_vec()).unwrap()
    }

    fn size(&mut self) -> usize {
        usize::try_from(self.number(i32::from_le_bytes)).expect("no negative size")
    }

    /// Reads a count of channels and their names, which all differ.
    fn channels(&mut self) -> Vec<String> {
        let names: Vec<String> = (0..self.size()).map(|_| self.text()).collect();
        assert!(!names.is_empty() && names.iter().all(|name| !name.is_empty()));
        assert!(names.iter().enumerate().all(|(i, name)| !names[..i].contains(name)), "{names:?}");
        names
    }
}

/// The image that a viewer would show.
#[derive(Default)]
struct Shown {
    name: String,
    size: [usize; 2],
    /// Samples of the full image for each channel; `None` for samples that were not sent.
    channels: BTreeMap<String, Vec<Option<f32>>>,
    tiles: usize,
}

impl Shown {
    /// Reads an image from bytes, all of which must belong to packets.
    fn read(bytes: &[u8]) -> Self {
        let mut shown = Self::default();
        let mut bytes = Bytes(bytes);
        while !bytes.0.is_empty() {
            let length = u32::from_le_bytes(bytes.0[..4].try_into().unwrap()) as usize;
            let mut packet = Bytes(bytes.take(length));
            packet.take(4);
            match packet.take(1)[0] {
                4 => shown.create(&mut packet),
                6 => shown.update(&mut packet),
                other => panic!("operation {other}"),
            }
            assert!(packet.0.is_empty(), "{} bytes too many", packet.0.len());
        }
        shown
    }

    fn create(&mut self, packet: &mut Bytes<'_>) {
        assert!(self.channels.is_empty(), "the image is created once");
        assert!(packet.flag(), "it comes to front");
        self.name = packet.text();
        self.size = [packet.size(), packet.size()];
        let empty = vec![None; self.size[0] * self.size[1]];
        self.channels = packet.channels().into_iter().map(|name| (name, empty.clone())).collect();
    }

    fn update(&mut self, packet: &mut Bytes<'_>) {
        assert!(!packet.flag(), "who works elsewhere is not disturbed by each tile");
        assert_eq!(packet.text(), self.name);
        let channels = packet.channels();
        let [x, y, width, height] = [(); 4].map(|()| packet.size());
        assert!(width > 0 && x + width <= self.size[0] && height > 0 && y + height <= self.size[1]);
        let mut places =
            || channels.iter().map(|_| packet.number(i64::from_le_bytes) as usize).collect::<Vec<_>>();
        let (offsets, strides) = (places(), places());
        let last = |c: usize| offsets[c] + (width * height - 1) * strides[c];
        let count = (0..channels.len()).map(last).max().unwrap() + 1;
        let samples: Vec<f32> = (0..count).map(|_| packet.number(f32::from_le_bytes)).collect();
        for (c, name) in channels.iter().enumerate() {
            let channel = self.channels.get_mut(name).expect("a channel that was created");
            for pixel in 0..width * height {
                let place = (y + pixel / width) * self.size[0] + x + pixel % width;
                let before = channel[place].replace(samples[offsets[c] + pixel * strides[c]]);
                assert_eq!(before, None, "{name}: no pixel is sent twice");
            }
        }
        self.tiles += 1;
    }

    /// Asserts that every sample of the file was shown, and nothing else.
    fn is(&self, film: &Film) {
        assert_eq!(self.size, film.size().map(|side| side as usize));
        let mut count = 0;
        for plane in film.planes() {
            for (c, channel) in plane.channels().iter().enumerate() {
                let name = channel_name(plane.name(), channel);
                let shown = &self.channels[&name];
                for (x, y) in Window::full(film.size()).pixels() {
                    let expected = film.window().contains(x, y).then(|| match plane.samples() {
                        Samples::F32(_) => plane.f32_at(x, y)[c].to_bits(),
                        Samples::U32(_) => (plane.u32_at(x, y)[c] as f32).to_bits(),
                    });
                    let seen = shown[y as usize * self.size[0] + x as usize].map(f32::to_bits);
                    assert_eq!(seen, expected, "{name} at {x},{y}");
                }
                count += 1;
            }
        }
        assert_eq!(self.channels.len(), count);
    }
}

#[test]
fn the_viewer_is_shown_what_is_written() {
    for crop in ["", "--crop 13,7,40,25"] {
        let folder = tempfile::tempdir().unwrap();
        let (address, seen) = server(|mut stream| {
            let mut bytes = Vec::new();
            stream.read_to_end(&mut bytes).unwrap();
            bytes
        });
        let (code, said) = render(folder.path(), &format!("--size 64x48 {crop} --tev {address}"));
        assert_eq!(code, Some(0), "{said}");
        assert!(!said.contains("tev"), "nothing to say about it: {said}");
        let shown = Shown::read(&seen.join().unwrap());
        assert_eq!(shown.name, "seen.exr");
        assert!(shown.tiles > 1, "tile by tile");
        for name in ["R", "half_width.Y", "claim.id", "normal.X"] {
            assert!(shown.channels.contains_key(name), "{name}");
        }
        shown.is(&read_exr(&folder.path().join("seen.exr")).unwrap());
    }
}

#[test]
fn a_viewer_that_goes_or_sleeps_disturbs_nothing() {
    let alone = tempfile::tempdir().unwrap();
    assert_eq!(render(alone.path(), "--size 200x150").0, Some(0));
    let expected = fs::read(alone.path().join("seen.exr")).unwrap();
    let check = |address: &str| {
        let folder = tempfile::tempdir().unwrap();
        let (code, said) = render(folder.path(), &format!("--size 200x150 --tev {address}"));
        assert_eq!(code, Some(0), "{said}");
        assert!(fs::read(folder.path().join("seen.exr")).unwrap() == expected, "the same file");
        said
    };
    let (address, gone) = server(drop);
    let said = check(&address);
    gone.join().unwrap();
    assert_eq!(said.matches(&format!("note: tev at {address} shows no more")).count(), 1, "{said}");
    // A viewer that keeps the connection open but never reads.
    let (address, asleep) = server(|stream| stream);
    check(&address);
    drop(asleep.join().unwrap());
}

#[test]
fn an_absent_viewer_is_told_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    // The listener is closed at once, so that nobody listens at this address.
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let (code, said) = render(folder.path(), &format!("--tev {address}"));
    assert_eq!(code, Some(3), "{said}");
    assert!(said.starts_with(&format!("error: cannot reach tev at {address}")), "{said}");
    assert!(said.contains("start tev first") && !said.contains("reading"), "{said}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing was written");
    let (code, said) = render(folder.path(), "--tev kitchen.glb");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("HOST:PORT") && said.contains("a scene goes before"), "{said}");
}
