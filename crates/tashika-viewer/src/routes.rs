//! From a request to a response: access checks, routes, and the headers of every answer.
//!
//! All routes are below `/TOKEN/`; the rest does not exist. The host of a request must be this
//! machine by name or number. So a page of another site learns nothing, even if the name of that
//! site was made to resolve to this machine.
//!
//! | request | answer |
//! |---|---|
//! | `GET ` | the page |
//! | `GET state` | JSON: version, progress, descriptions of the images |
//! | `GET tile?image=0&level=0&x=0&y=0&plane=&plane=half_width` | [`Tile::bytes`](crate::Tile) |
//! | `GET pixel?image=0&x=10&y=20` | JSON: the values of all planes |
//! | `POST bye` | nothing; the page is being closed |
//!
//! # Guarantee
//! Answers never repeat text from the request. Bodies of requests are not read. Pages may run and
//! load only their own contents.
//!
//! # Held to this by
//! The tests in `tests/server.rs`, and those below.

use std::sync::Arc;

use bytes::Bytes;
use http_body_util::Full;
use hyper::header::{self, HeaderName, HeaderValue};
use hyper::{Method, Request, Response, StatusCode};
use serde::{Serialize, Serializer};
use tashika::film::Samples;

use crate::server::{PageContext, Shared};
use crate::shown::{Description, Headline, Refusal, Shown, TileAddress, Values};

/// An answer without the common headers.
struct Answer {
    status: StatusCode,
    kind: &'static str,
    body: Bytes,
    /// Additional header.
    extra: Option<(HeaderName, HeaderValue)>,
}

/// Largest number of planes of one request for a tile.
const MOST_PLANES: usize = 16;
const TEXT: &str = "text/plain; charset=utf-8";
const JSON: &str = "application/json";

impl Answer {
    fn new(kind: &'static str, body: impl Into<Bytes>) -> Self {
        Self { status: StatusCode::OK, kind, body: body.into(), extra: None }
    }

    fn empty(status: StatusCode) -> Self {
        Self { status, ..Self::new(TEXT, Bytes::new()) }
    }

    fn text(status: StatusCode, text: String) -> Self {
        Self { status, ..Self::new(TEXT, text) }
    }

    fn json(value: &impl Serialize) -> Self {
        serde_json::to_vec(value)
            .map_or_else(|_| Self::empty(StatusCode::INTERNAL_SERVER_ERROR), |body| Self::new(JSON, body))
    }
}

impl From<Refusal> for Answer {
    fn from(refusal: Refusal) -> Self {
        let status = match refusal {
            Refusal::NotYet | Refusal::Outside(_) | Refusal::NoPlane => StatusCode::NOT_FOUND,
            Refusal::Unreadable(_) => StatusCode::INTERNAL_SERVER_ERROR,
        };
        Self::text(status, refusal.to_string())
    }
}

/// Answers a request; the flag is true if the request has the token.
pub(crate) async fn answer<B>(shared: &Arc<Shared>, request: &Request<B>) -> (Response<Full<Bytes>>, bool) {
    let Ok(nonce) = random_hex() else {
        let mut response = Response::new(Full::default());
        *response.status_mut() = StatusCode::INTERNAL_SERVER_ERROR;
        return (response, false);
    };
    let rest = is_for_us(request, shared.port).then(|| below_token(request.uri().path(), &shared.token));
    let (answer, is_known) = match rest {
        None => (Answer::empty(StatusCode::FORBIDDEN), false),
        Some(None) => (Answer::empty(StatusCode::NOT_FOUND), false),
        Some(Some(route)) => (known(shared, request, route, &nonce).await, true),
    };
    (with_headers(answer, &nonce), is_known)
}

/// Returns 128 random bits as hexadecimal digits.
pub(crate) fn random_hex() -> Result<String, getrandom::Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)?;
    Ok(format!("{:032x}", u128::from_be_bytes(bytes)))
}

/// Returns true if the request has a single `Host` header, and this is `127.0.0.1` or `localhost`
/// with the server's port.
fn is_for_us<B>(request: &Request<B>, port: u16) -> bool {
    let mut hosts = request.headers().get_all(header::HOST).iter();
    let host = hosts.next().and_then(|host| host.to_str().ok()).unwrap_or_default();
    hosts.next().is_none() && (host == format!("127.0.0.1:{port}") || host == format!("localhost:{port}"))
}

/// Returns the rest of a path after `/TOKEN/`. The time does not depend on the place where a wrong
/// token differs.
fn below_token<'a>(path: &'a str, token: &str) -> Option<&'a str> {
    let (found, rest) = path.strip_prefix('/')?.split_once('/')?;
    let differences = found.bytes().zip(token.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
    (found.len() == token.len() && std::hint::black_box(differences) == 0).then_some(rest)
}

/// Answers a request that has the token.
async fn known<B>(shared: &Arc<Shared>, request: &Request<B>, route: &str, nonce: &str) -> Answer {
    let method = match route {
        "" | "state" | "tile" | "pixel" => Method::GET,
        "bye" => Method::POST,
        _ => return Answer::empty(StatusCode::NOT_FOUND),
    };
    if request.method() != method {
        let allowed = HeaderValue::from_static(if method == Method::GET { "GET" } else { "POST" });
        let extra = Some((header::ALLOW, allowed));
        return Answer { extra, ..Answer::empty(StatusCode::METHOD_NOT_ALLOWED) };
    }
    let query = Query(request.uri().query().unwrap_or_default());
    let answered = match route {
        "" => {
            let page = (shared.page)(&PageContext { nonce: nonce.to_owned() });
            Ok(Answer::new("text/html; charset=utf-8", page))
        }
        "state" => {
            shared.watch.polled();
            Ok(state(&shared.images))
        }
        "tile" => tile(shared, query).await,
        "pixel" => pixel(shared, query).await,
        _ => {
            shared.watch.said_goodbye();
            Ok(Answer::empty(StatusCode::NO_CONTENT))
        }
    };
    answered.unwrap_or_else(|wrong| Answer::text(StatusCode::BAD_REQUEST, wrong))
}

fn with_headers(answer: Answer, nonce: &str) -> Response<Full<Bytes>> {
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data: blob:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    let mut response = Response::new(Full::new(answer.body));
    *response.status_mut() = answer.status;
    let headers = response.headers_mut();
    let policy = HeaderValue::try_from(policy).expect("letters, digits and signs");
    headers.insert(header::CONTENT_SECURITY_POLICY, policy);
    let fixed = [
        (header::CONTENT_TYPE, answer.kind),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.extend(answer.extra);
    response
}

/// Answer to `state`.
#[derive(Serialize)]
struct State {
    version: u64,
    live: bool,
    finished: bool,
    ready: f32,
    headline: Option<Headline>,
    failure: Option<String>,
    images: Vec<Option<Labelled>>,
}

/// Description of an image, with its label.
#[derive(Serialize)]
struct Labelled {
    label: String,
    #[serde(flatten)]
    description: Description,
}

fn state(images: &[(String, Arc<dyn Shown>)]) -> Answer {
    // The version is read first: later changes make it grow, and are requested again.
    let version = images.iter().map(|(_, image)| image.version()).sum();
    let all: Vec<_> = images.iter().map(|(_, image)| image.status()).collect();
    let labelled = images.iter().map(|(label, image)| {
        image.description().map(|description| Labelled { label: label.clone(), description })
    });
    Answer::json(&State {
        version,
        live: all.iter().any(|s| s.live),
        finished: all.iter().all(|s| s.finished),
        ready: all.iter().map(|s| s.ready).fold(1.0, f32::min),
        headline: all.iter().find_map(|s| s.headline.clone()),
        failure: all.iter().find_map(|s| s.failure.clone()),
        images: labelled.collect(),
    })
}

async fn tile(shared: &Arc<Shared>, query: Query<'_>) -> Result<Answer, String> {
    let image = query.image(shared)?;
    let at = TileAddress { level: query.number("level")?, x: query.number("x")?, y: query.number("y")? };
    let planes = query.texts("plane")?;
    if planes.len() > MOST_PLANES {
        return Err(format!("there is plane more than {MOST_PLANES} times"));
    }
    let tile =
        shared.work(move || image.tile(at, &planes.iter().map(String::as_str).collect::<Vec<_>>())).await;
    Ok(tile.map_or_else(Answer::from, |tile| {
        let extra = Some((HeaderName::from_static("x-tashika-version"), HeaderValue::from(tile.version)));
        Answer { extra, ..Answer::new("application/octet-stream", tile.bytes) }
    }))
}

async fn pixel(shared: &Arc<Shared>, query: Query<'_>) -> Result<Answer, String> {
    let image = query.image(shared)?;
    let (x, y) = (query.number("x")?, query.number("y")?);
    let values = shared.work(move || image.pixel(x, y)).await;
    Ok(values.map_or_else(Answer::from, |values| Answer::json(&Pixel { planes: Planes(values) })))
}

/// Answer to `pixel`.
#[derive(Serialize)]
struct Pixel {
    planes: Planes,
}

/// A map from names of planes to lists of values.
struct Planes(Vec<Values>);

impl Serialize for Planes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|plane| (&plane.plane, List(&plane.values))))
    }
}

struct List<'a>(&'a Samples);

impl Serialize for List<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Samples::F32(values) => serializer.collect_seq(values.iter().map(|&v| Number(v))),
            Samples::U32(values) => serializer.collect_seq(values),
        }
    }
}

/// A number as the shortest digits that give its bits back; a word if JSON has no such number.
struct Number(f32);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            value if value.is_nan() => serializer.serialize_str("nan"),
            f32::INFINITY => serializer.serialize_str("inf"),
            f32::NEG_INFINITY => serializer.serialize_str("-inf"),
            value => serializer.serialize_f32(value),
        }
    }
}

/// Query of a request, after the question mark.
#[derive(Clone, Copy)]
struct Query<'a>(&'a str);

impl Query<'_> {
    /// The first value of that name, decoded.
    fn text(self, name: &str) -> Result<String, String> {
        self.texts(name).map(|mut all| all.swap_remove(0))
    }

    /// All values of that name, decoded; at least one.
    fn texts(self, name: &str) -> Result<Vec<String>, String> {
        let pairs = self.0.split('&').map(|pair| pair.split_once('=').unwrap_or((pair, "")));
        let values = pairs.filter(|(key, _)| *key == name).map(|(_, value)| decoded(value));
        let found: Option<Vec<String>> = values.collect();
        let found = found.ok_or_else(|| format!("{name} is not percent-encoded UTF-8"))?;
        if found.is_empty() { Err(format!("{name} is missing")) } else { Ok(found) }
    }

    fn number(self, name: &str) -> Result<u32, String> {
        let text = self.text(name)?;
        let digits = Some(text.as_str()).filter(|t| t.bytes().all(|b| b.is_ascii_digit()));
        digits
            .and_then(|t| t.parse().ok())
            .ok_or_else(|| format!("{name} is not a whole number from 0 to {}", u32::MAX))
    }

    fn image(self, shared: &Shared) -> Result<Arc<dyn Shown>, String> {
        let image = shared.images.get(self.number("image")? as usize);
        let last = shared.images.len().saturating_sub(1);
        image.map(|(_, shown)| shown.clone()).ok_or_else(|| format!("image is not from 0 to {last}"))
    }
}

/// Decodes percent-encoded text, with `+` for a space.
fn decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'%' => {
                let mut digit = || char::from(rest.next()?).to_digit(16);
                (16 * digit()? + digit()?) as u8
            }
            b'+' => b' ',
            byte => byte,
        });
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_decoded_or_refused() {
        let query = Query("plane=half%5Fwidth+%C3%A9&x=12&y=-1&z=4294967296&w=%zz&v=%C3&u=%2&t=+1&x=13&s");
        assert_eq!(query.text("plane").unwrap(), "half_width é");
        assert_eq!(query.number("x"), Ok(12), "the first of that name");
        assert_eq!(query.text("s").unwrap(), "");
        for name in ["y", "z", "w", "v", "u", "t", "s", "r"] {
            let said = query.number(name).unwrap_err();
            assert!(said.starts_with(name), "{said}");
        }
    }

    #[test]
    fn only_the_very_token_opens() {
        assert_eq!(below_token("/abc/state", "abc"), Some("state"));
        assert_eq!(below_token("/abc/", "abc"), Some(""));
        for path in
            ["/abd/state", "/ab/state", "/abcd/state", "/abc", "/", "", "abc/state", "//abc/state", "/%61bc/"]
        {
            assert_eq!(below_token(path, "abc"), None, "{path}");
        }
    }

    #[test]
    fn numbers_lead_back_to_the_same_bits() {
        let values = [0.1, -0.0, f32::MIN_POSITIVE / 4.0, f32::MAX, 16_777_216.0, 1.0 / 3.0];
        let text = serde_json::to_string(&List(&Samples::F32(values.to_vec()))).unwrap();
        let back: Vec<f64> = serde_json::from_str(&text).unwrap();
        assert!(back.iter().zip(values).all(|(b, v)| (*b as f32).to_bits() == v.to_bits()), "{text}");
        let odd = Samples::F32(vec![f32::INFINITY, f32::NEG_INFINITY, f32::NAN]);
        assert_eq!(serde_json::to_string(&List(&odd)).unwrap(), r#"["inf","-inf","nan"]"#);
    }
}
