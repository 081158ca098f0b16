//! The server from a client's side: its answers, and its resistance to hostile or broken clients.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpStream};
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value as Json;
use tashika::film::{Film, PlaneSpec, SampleKind, Window};
use tashika_viewer::{Headline, LiveFilm, Options, Server, Shown};

const SPECS: &[PlaneSpec] = &[
    PlaneSpec { name: "", channels: &["R", "G", "B"], unit: "W", kind: SampleKind::F32, doc: "Radiance." },
    PlaneSpec { name: "half_width", channels: &["Y"], unit: "W", kind: SampleKind::F32, doc: "" },
    PlaneSpec { name: "cost é", channels: &["rays"], unit: "1", kind: SampleKind::U32, doc: "" },
];
const WINDOW: Window = Window { x: 3, y: 1, width: 300, height: 200 };

fn film() -> Film {
    let mut film = Film::new([400, 300], WINDOW, SPECS).unwrap();
    for (i, (x, y)) in WINDOW.pixels().enumerate() {
        film.plane_mut("").unwrap().set_f32(x, y, &[x as f32 / 3.0, f32::INFINITY, -0.0]);
        film.plane_mut("half_width").unwrap().set_f32(x, y, &[i as f32]);
        film.plane_mut("cost é").unwrap().set_u32(x, y, &[u32::MAX - i as u32]);
    }
    film.metadata_mut().set("scene", "<script>alert(1)</script>");
    film
}

/// A server of one finished image and of one image without a film.
fn serve() -> (Server, Arc<LiveFilm>) {
    let (first, second) = (Arc::new(LiveFilm::new()), Arc::new(LiveFilm::new()));
    first.finish(film());
    let images: Vec<(String, Arc<dyn Shown>)> =
        vec![("first".to_owned(), first), ("second".to_owned(), second.clone())];
    let page =
        |context: &tashika_viewer::PageContext| format!("<!doctype html><script nonce={}>", context.nonce);
    (Server::start(images, Box::new(page), &Options::default()).unwrap(), second)
}

/// An answer by status, headers and body.
struct Answer {
    status: u16,
    headers: Vec<(String, String)>,
    body: Vec<u8>,
}

impl Answer {
    fn header(&self, name: &str) -> &str {
        self.headers.iter().find(|(n, _)| n == name).map_or("", |(_, value)| value)
    }

    fn text(&self) -> &str {
        std::str::from_utf8(&self.body).unwrap()
    }

    fn json(&self) -> Json {
        assert_eq!((self.status, self.header("content-type")), (200, "application/json"));
        serde_json::from_slice(&self.body).unwrap()
    }
}

fn port(server: &Server) -> u16 {
    server.address().split([':', '/']).nth(4).unwrap().parse().unwrap()
}

/// Path of the page, without the last slash.
fn home(server: &Server) -> String {
    format!("/{}", server.address().split('/').nth(3).unwrap())
}

fn connect(server: &Server) -> TcpStream {
    let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port(server))).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    stream
}

/// Sends bytes and reads until the server closes the connection. If `is_all`, the connection is
/// closed for sending after the bytes.
fn exchange(server: &Server, bytes: &[u8], is_all: bool) -> Vec<u8> {
    let mut stream = connect(server);
    // A server that refuses a long request may close before all of it was sent.
    let _ = stream.write_all(bytes);
    if is_all {
        let _ = stream.shutdown(Shutdown::Write);
    }
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    answer
}

fn parsed(answer: &[u8]) -> Answer {
    let end = answer.windows(4).position(|w| w == b"\r\n\r\n").expect("an answer with headers");
    let head = std::str::from_utf8(&answer[..end]).unwrap();
    let (first, rest) = head.split_once("\r\n").unwrap_or((head, ""));
    let status = first.split(' ').nth(1).unwrap().parse().unwrap();
    let header = |line: &str| line.split_once(": ").map(|(n, v)| (n.to_owned(), v.to_owned()));
    Answer { status, headers: rest.lines().filter_map(header).collect(), body: answer[end + 4..].to_vec() }
}

fn request(server: &Server, method: &str, path: &str) -> Answer {
    request_for(server, method, path, &format!("127.0.0.1:{}", port(server)))
}

fn request_for(server: &Server, method: &str, path: &str, host: &str) -> Answer {
    let text = format!("{method} {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n");
    parsed(&exchange(server, text.as_bytes(), false))
}

fn get(server: &Server, route: &str) -> Answer {
    request(server, "GET", &format!("{}/{route}", home(server)))
}

#[test]
fn the_address_is_unguessable_and_every_answer_has_the_headers() {
    let (server, _) = serve();
    let token = home(&server)[1..].to_owned();
    assert!(token.len() == 32 && token.bytes().all(|b| b.is_ascii_hexdigit()), "{token}");
    assert_ne!(token, home(&serve().0)[1..]);
    let mut nonces = Vec::new();
    for (method, route, status) in [
        ("GET", "", 200),
        ("GET", "", 200),
        ("GET", "state", 200),
        ("GET", "absent", 404),
        ("POST", "bye", 204),
    ] {
        let answer = request(&server, method, &format!("/{token}/{route}"));
        assert_eq!(answer.status, status, "{route}");
        let policy = answer.header("content-security-policy");
        let nonce = policy.split("'nonce-").nth(1).unwrap().split('\'').next().unwrap().to_owned();
        let expected = format!(
            "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data: blob:; connect-src 'self'; \
             base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        );
        assert_eq!(policy, expected);
        assert_eq!(answer.header("x-content-type-options"), "nosniff");
        assert_eq!(answer.header("referrer-policy"), "no-referrer");
        assert_eq!(answer.header("cache-control"), "no-store");
        assert_eq!(answer.header("cross-origin-resource-policy"), "same-origin");
        if route.is_empty() {
            assert_eq!(answer.text(), format!("<!doctype html><script nonce={nonce}>"));
            assert_eq!(answer.header("content-type"), "text/html; charset=utf-8");
        }
        nonces.push(nonce);
    }
    nonces.sort();
    nonces.dedup();
    assert_eq!(nonces.len(), 5, "another nonce each time");
}

#[test]
fn the_state_tells_what_there_is_and_grows_with_it() {
    let (server, second) = serve();
    let state = get(&server, "state").json();
    assert_eq!((&state["live"], &state["finished"]), (&Json::from(true), &Json::from(false)));
    assert_eq!(
        (&state["ready"], &state["headline"], &state["images"][1]),
        (&Json::from(0.0), &Json::Null, &Json::Null)
    );
    let first = &state["images"][0];
    assert_eq!(first["label"], "first");
    assert_eq!(first["size"], serde_json::json!([400, 300]));
    assert_eq!(first["window"], serde_json::json!([3, 1, 300, 200]));
    assert_eq!(
        (&first["levels"], &first["metadata"]["scene"]),
        (&Json::from(2), &Json::from("<script>alert(1)</script>"))
    );
    let radiance = serde_json::json!({"name": "", "channels": ["R", "G", "B"], "unit": "W", "doc": "Radiance.", "kind": "f32"});
    assert_eq!((&first["planes"][0], &first["planes"][2]["kind"]), (&radiance, &Json::from("u32")));

    second.update(&film(), Window { width: 16, height: 16, ..WINDOW });
    second.progress(Headline { text: "half".to_owned(), pixels: 2, of: 4, claiming: 1, promise_met: 1 });
    let later = get(&server, "state").json();
    assert_eq!(later["version"].as_u64().unwrap(), state["version"].as_u64().unwrap() + 2);
    assert_eq!(
        later["headline"],
        serde_json::json!({"text": "half", "pixels": 2, "of": 4, "claiming": 1, "promise_met": 1})
    );
    assert_eq!((&later["ready"], &later["images"][1]["label"]), (&Json::from(0.5), &Json::from("second")));
}

#[test]
fn tiles_and_pixels_are_those_of_the_film() {
    let (server, _) = serve();
    let film = film();
    let tile = get(&server, "tile?image=0&level=0&x=1&y=0&plane=cost%20%C3%A9");
    assert_eq!((tile.status, tile.header("content-type")), (200, "application/octet-stream"));
    assert_eq!(tile.header("x-tashika-version"), "1");
    let expected: Vec<u8> = (1..201)
        .flat_map(|y| (259..303).map(move |x| (x, y)))
        .flat_map(|(x, y)| film.plane("cost é").unwrap().u32_at(x, y)[0].to_le_bytes())
        .collect();
    assert!(tile.body == expected, "{} bytes", tile.body.len());
    let main = get(&server, "tile?plane=&image=0&level=1&x=0&y=0");
    assert_eq!(main.body.len(), 3 * 150 * 100 * 4);

    let pixel = get(&server, "pixel?image=0&x=4&y=2");
    assert_eq!(
        pixel.text(),
        r#"{"planes":{"":[1.3333334,"inf",-0.0],"half_width":[301.0],"cost é":[4294966994]}}"#
    );
    pixel.json();
}

#[test]
fn wrong_values_are_refused_in_words_that_do_not_repeat_them() {
    let (server, _) = serve();
    for (route, status) in [
        ("tile", 400),
        ("tile?image=0&level=0&x=0&y=0", 400),
        ("tile?image=0&level=0&x=0&y=0", 400),
        (&format!("tile?image=0&level=0&x=0&y=0{}", "&plane=".repeat(17)), 400),
        ("tile?image=2&level=0&x=0&y=0&plane=", 400),
        ("tile?image=4294967295&level=0&x=0&y=0&plane=", 400),
        ("tile?image=0&level=4294967295&x=0&y=0&plane=", 404),
        ("tile?image=0&level=2&x=0&y=0&plane=", 404),
        ("tile?image=0&level=0&x=4294967295&y=4294967295&plane=", 404),
        ("tile?image=0&level=99999999999999999999&x=0&y=0&plane=", 400),
        ("tile?image=0&level=-1&x=0&y=0&plane=", 400),
        ("tile?image=0&level=0&x=0&y=0&plane=%3Cscript%3E", 404),
        ("tile?image=0&level=0&x=0&y=0&plane=%FF", 400),
        ("tile?image=1&level=0&x=0&y=0&plane=", 404),
        ("pixel?image=0&x=2&y=1", 404),
        ("pixel?image=0&x=%3Cscript%3E&y=1", 400),
        ("pixel?image=0&x=4294967295&y=4294967295", 404),
    ] {
        let answer = get(&server, route);
        assert_eq!(answer.status, status, "{route}: {}", answer.text());
        assert_eq!(answer.header("content-type"), "text/plain; charset=utf-8");
        assert!(
            !answer.body.is_empty() && answer.body.len() < 200 && !answer.text().contains("script"),
            "{route}"
        );
    }
    let home = home(&server);
    for (method, route, allowed) in
        [("POST", "state", "GET"), ("HEAD", "", "GET"), ("PUT", "tile", "GET"), ("GET", "bye", "POST")]
    {
        let answer = request(&server, method, &format!("{home}/{route}"));
        assert_eq!((answer.status, answer.header("allow")), (405, allowed), "{method} {route}");
    }
}

#[test]
fn without_the_token_or_by_another_name_there_is_nothing() {
    let (server, _) = serve();
    let home = home(&server);
    let mut wrong = home.clone().into_bytes();
    // A changed digit of the token.
    wrong[20] = if wrong[20] == b'0' { b'1' } else { b'0' };
    let wrong = String::from_utf8(wrong).unwrap();
    for path in [
        "/",
        "//",
        "/state",
        "/favicon.ico",
        &home,
        &format!("{wrong}/"),
        &format!("{wrong}/state"),
        &format!("/{home}/"),
        &format!("{}/state", &home[..32]),
        &format!("{home}/../../etc/passwd"),
        &format!("{home}/%2e%2e/%2e%2e/etc/passwd"),
        &format!("{home}/..%2f..%2fetc/passwd"),
        &format!("/..{home}/state"),
        &format!("{home}/state/"),
        &format!("{home}//state"),
        "/../../etc/passwd",
        "*",
    ] {
        let answer = request(&server, "GET", path);
        assert!(answer.status == 404 && answer.body.is_empty(), "{path}: {}", answer.status);
    }
    let port = port(&server);
    assert_eq!(
        request_for(&server, "GET", &format!("{home}/state"), &format!("localhost:{port}")).status,
        200
    );
    for host in ["evil.example", &format!("evil.example:{port}"), "127.0.0.1", "127.0.0.1:1", "localhost", ""]
    {
        let answer = request_for(&server, "GET", &format!("{home}/state"), host);
        assert!(answer.status == 403 && answer.body.is_empty(), "{host}: {}", answer.status);
    }
    let twice = format!("127.0.0.1:{port}\r\nhost: evil.example");
    assert_eq!(request_for(&server, "GET", &format!("{home}/state"), &twice).status, 403);
}

#[test]
fn it_is_watched_from_the_first_poll_on_and_ends_when_dropped() {
    let (server, _) = serve();
    assert!(!server.is_watched());
    get(&server, "");
    assert!(!server.is_watched(), "the page itself has not asked yet");
    get(&server, "state");
    assert!(server.is_watched());
    let port = port(&server);
    let idle = connect(&server);
    server.stop();
    assert!(TcpStream::connect((Ipv4Addr::LOCALHOST, port)).is_err());
    drop(idle);
}

#[test]
fn whoever_says_nothing_or_nonsense_disturbs_nobody() {
    let (server, _) = serve();
    let home = home(&server);
    let host = format!("host: 127.0.0.1:{}\r\n", port(&server));
    // As many connections as the system allows this process. Both ends are in this process, and
    // each end takes a file descriptor.
    let mut idle = Vec::new();
    for _ in 0..1000 {
        let Ok(stream) = TcpStream::connect((Ipv4Addr::LOCALHOST, port(&server))) else { break };
        idle.push(stream);
    }
    let mut slow: Vec<TcpStream> = idle.split_off(idle.len() / 2);
    for stream in &mut slow {
        // Connections that were closed in favour of others reject the bytes.
        let _ = stream.write_all(b"GET / HTTP/1.1\r\nx: ");
    }
    for _ in 0..2 {
        assert_eq!(get(&server, "state").status, 200, "while all of them are open");
    }
    drop(idle.split_off(idle.len() / 2));
    assert_eq!(get(&server, "state").status, 200);

    let long = "a".repeat(1 << 20);
    let many = "x: y\r\n".repeat(1000);
    let nonsense: Vec<Vec<u8>> = vec![
        Vec::new(),
        b"\r\n\r\n\r\n".to_vec(),
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".to_vec(),
        (0..100_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect(),
        b"GET\r\n\r\n".to_vec(),
        b"GET / HTTP/9.9\r\n\r\n".to_vec(),
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_vec(),
        format!("GET {home}/state HTTP/1.1\r\n\r\n").into_bytes(),
        format!("GET {home}/{long} HTTP/1.1\r\n{host}\r\n").into_bytes(),
        format!("GET {home}/state HTTP/1.1\r\n{host}x: {long}\r\n\r\n").into_bytes(),
        format!("GET {home}/state HTTP/1.1\r\n{host}{many}\r\n").into_bytes(),
        format!("GET {home}/state HTTP/1.1\r\n{host}x\0y: z\r\n\r\n").into_bytes(),
        format!("POST {home}/state HTTP/1.1\r\n{host}content-length: 18446744073709551615\r\n\r\n{long}").into_bytes(),
        format!("POST {home}/state HTTP/1.1\r\n{host}content-length: 5\r\ntransfer-encoding: chunked\r\n\r\nfffffffff\r\n").into_bytes(),
        format!("GET {home}/state HTTP/1.1\r\n{host}content-length: -1\r\n\r\n").into_bytes(),
    ];
    for bytes in nonsense {
        let answer = exchange(&server, &bytes, true);
        let first = &bytes[..bytes.len().min(60)];
        if !answer.is_empty() {
            let status = parsed(&answer).status;
            assert!((400..500).contains(&status), "{:?}: {status}", String::from_utf8_lossy(first));
        }
        assert_eq!(get(&server, "state").status, 200, "after {:?}", String::from_utf8_lossy(first));
    }
    assert_eq!(get(&server, "tile?image=0&level=1&x=0&y=0&plane=half_width").status, 200);
}
