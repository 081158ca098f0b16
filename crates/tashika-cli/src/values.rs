//! Parsers of option values from the command line; each error names the accepted values.

use std::time::Duration;

use tashika::color::Controlled;
use tashika::error::Error;
use tashika::experiment::Grouping;
use tashika::film::Window;
use tashika::gather::Filter;
use tashika::integrator::{SumMethod, Truth};
use tashika::io::Exposure;
use tashika::request::{ProjectionName, Quality};
use tashika::sensors::{Photometry, SensorGridRequest};
use tashika::vpl::Clamp;

/// Parses a whole number: `10000`, `55_000`, `10k`, `1.5M`.
pub fn count(typed: &str) -> Result<u64, String> {
    let wrong = || "expected a whole number, such as 55000, 55_000 or 55k".to_owned();
    let (digits, unit) = match typed.char_indices().last() {
        Some((at, 'k' | 'K')) => (&typed[..at], 1e3),
        Some((at, 'M')) => (&typed[..at], 1e6),
        _ => (typed, 1.0),
    };
    let digits = digits.replace('_', "");
    if !digits.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(wrong());
    }
    let number = digits.parse::<f64>().map_err(|_| wrong())? * unit;
    // Below 2⁵³ every whole number is exactly representable as an `f64`.
    let exact = number.fract() == 0.0 && number < (1_u64 << 53) as f64;
    if exact { Ok(number as u64) } else { Err(wrong()) }
}

/// Parses a share, as a percentage or a fraction: `2%`, `0.02`.
pub fn percentage(typed: &str) -> Result<f64, String> {
    let wrong = || "expected a percentage or a share, such as 2% or 0.02".to_owned();
    let (number, unit) = match typed.strip_suffix('%') {
        Some(percent) => (percent.trim_end(), 100.0),
        None => (typed, 1.0),
    };
    let number: f64 = number.parse().map_err(|_| wrong())?;
    if number.is_finite() { Ok(number / unit) } else { Err(wrong()) }
}

/// Parses a grid of sensors.
pub fn sensor_grid(typed: &str) -> Result<SensorGridRequest, String> {
    typed.parse().map_err(expected)
}

/// Parses the name of a conversion to illuminance.
pub fn photometry(typed: &str) -> Result<Photometry, String> {
    typed.parse().map_err(expected)
}

/// Scale of a picture in false colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseColor {
    /// Luminance at the end of the scale (cd·m⁻²), if given.
    pub end: Option<f64>,
}

/// Parses the scale of a picture of luminances: `cd/m2`, `cd/m2:5000`.
pub fn false_color(typed: &str) -> Result<FalseColor, String> {
    let wrong = || "expected cd/m2, or cd/m2:MAX with a luminance above 0".to_owned();
    match typed.strip_prefix("cd/m2").ok_or_else(wrong)? {
        "" => Ok(FalseColor { end: None }),
        rest => {
            let number = rest.strip_prefix(':').and_then(|number| number.parse::<f64>().ok());
            let end = number.filter(|end| *end > 0.0 && *end < 1e30).ok_or_else(wrong)?;
            Ok(FalseColor { end: Some(end) })
        }
    }
}

/// Accepted values of an option, without its name and value, which the message of the program
/// states already.
fn expected(error: Error) -> String {
    match error {
        Error::Option { expected, .. } => format!("expected {expected}"),
        error => error.to_string(),
    }
}

/// Parses the name of a quality preset.
pub fn quality(typed: &str) -> Result<Quality, String> {
    typed.parse().map_err(|_| format!("expected {}", Quality::ALL.map(Quality::name).join(", ")))
}

/// Parses the times at which a shutter opens and closes (s): `0,0.02`.
pub fn shutter(typed: &str) -> Result<[f64; 2], String> {
    let wrong = || "expected two times in seconds, the first not above the second, such as 0,0.02".to_owned();
    let (open, close) = typed.split_once(',').ok_or_else(wrong)?;
    let number = |typed: &str| typed.trim().parse::<f64>().map_err(|_| wrong());
    let shutter = [number(open)?, number(close)?];
    let valid = shutter.iter().all(|seconds| seconds.is_finite()) && shutter[0] <= shutter[1];
    if valid { Ok(shutter) } else { Err(wrong()) }
}

/// Parses the first and the last number of a range of frames: `1..48`.
pub fn frames(typed: &str) -> Result<[u32; 2], String> {
    let wrong = || "expected two numbers of frames, the first not above the second, such as 1..48".to_owned();
    let (first, last) = typed.split_once("..").ok_or_else(wrong)?;
    let number = |typed: &str| typed.trim().parse::<u32>().map_err(|_| wrong());
    let frames = [number(first)?, number(last)?];
    if frames[0] <= frames[1] { Ok(frames) } else { Err(wrong()) }
}

/// Parses a time: `60s`, `5m`, `1.5h`.
pub fn duration(typed: &str) -> Result<Duration, String> {
    const MOST: f64 = 365.0 * 86_400.0;
    let wrong = || "expected a time above zero, such as 60s, 5m or 1h".to_owned();
    let (number, unit) = match typed.char_indices().last() {
        Some((at, 's')) => (&typed[..at], 1.0),
        Some((at, 'm')) => (&typed[..at], 60.0),
        Some((at, 'h')) => (&typed[..at], 3600.0),
        _ => return Err(wrong()),
    };
    let seconds = number.parse::<f64>().map_err(|_| wrong())? * unit;
    if seconds > 0.0 && seconds <= MOST { Ok(Duration::from_secs_f64(seconds)) } else { Err(wrong()) }
}

/// Parses width and height (pixels): `640x480`.
pub fn size(typed: &str) -> Result<[u32; 2], String> {
    let sides = typed.split_once(['x', 'X', '×']);
    sides
        .and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]))
        .ok_or_else(|| "expected WIDTHxHEIGHT in pixels, such as 640x480".to_owned())
}

/// Parses a part of the image (pixels): `X,Y,W,H`.
pub fn crop(typed: &str) -> Result<Window, String> {
    let wrong = || "expected X,Y,W,H in pixels from the top left, such as 0,0,320,240".to_owned();
    typed.parse().map_err(|_| wrong())
}

/// Parses the address at which a program listens: `127.0.0.1:14158`, `render-node:14158`,
/// `[::1]:14158`.
pub fn address(typed: &str) -> Result<String, String> {
    let port = typed.rsplit_once(':').filter(|(host, _)| !host.is_empty()).map(|(_, port)| port.parse());
    match port {
        Some(Ok(1..=u16::MAX)) => Ok(typed.to_owned()),
        _ => Err("expected HOST:PORT, such as 127.0.0.1:14158; a scene goes before this option".to_owned()),
    }
}

/// Parses the distance of a clamp: `auto`, `off` or metres.
pub fn clamp(typed: &str) -> Result<Clamp, String> {
    match typed {
        "auto" => Ok(Clamp::Auto),
        "off" => Ok(Clamp::Off),
        metres => metres
            .parse()
            .map(Clamp::Distance)
            .map_err(|_| "expected auto, off, or a distance in metres, such as 0.1".to_owned()),
    }
}

/// Parses the exposure of a picture: `auto` or a number of stops.
pub fn exposure(typed: &str) -> Result<Exposure, String> {
    match typed {
        "auto" => Ok(Exposure::Auto),
        stops => stops
            .parse()
            .map(Exposure::Stops)
            .map_err(|_| "expected auto, or a number of stops, such as -1.5".to_owned()),
    }
}

/// Parses an error metric by its name.
pub fn controlled(typed: &str) -> Result<Controlled, String> {
    named(&Controlled::ALL, typed)
}

/// Parses the name of a truth, the quantity from which errors are measured.
pub fn truth(typed: &str) -> Result<Truth, String> {
    named(&Truth::ALL, typed)
}

/// Parses a pixel filter by its name.
pub fn filter(typed: &str) -> Result<Filter, String> {
    named(&Filter::ALL, typed)
}

/// Parses a projection by its name.
pub fn projection(typed: &str) -> Result<ProjectionName, String> {
    named(&ProjectionName::ALL, typed)
}

/// Parses a grouping of pixels by its name.
pub fn grouping(typed: &str) -> Result<Grouping, String> {
    named(&Grouping::ALL, typed)
}

fn named<T: Copy + ToString>(all: &[T], typed: &str) -> Result<T, String> {
    all.iter().copied().find(|one| one.to_string() == typed.trim()).ok_or_else(|| {
        let names: Vec<String> = all.iter().map(T::to_string).collect();
        format!("expected {}", names.join(" or "))
    })
}

/// Parses the name of a method that experiments measure: any except `exact`, their reference.
pub fn method(typed: &str) -> Result<SumMethod, String> {
    let method = measured().find(|method| method.name() == typed.trim());
    method.ok_or_else(|| format!("expected {}, or several of them with commas between", method_names()))
}

/// Names of the [`measured`] methods, with commas between.
pub fn method_names() -> String {
    measured().map(SumMethod::name).collect::<Vec<_>>().join(", ")
}

/// Methods that experiments measure: all except the reference, [`SumMethod::Exact`].
pub fn measured() -> impl Iterator<Item = SumMethod> {
    SumMethod::ALL.into_iter().filter(|method| *method != SumMethod::Exact)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_read_as_people_write_them() {
        let good = [
            ("0", 0),
            ("55_000", 55_000),
            ("10k", 10_000),
            ("1.5M", 1_500_000),
            ("2K", 2_000),
            ("1e5", 100_000),
        ];
        for (typed, number) in good {
            assert_eq!(count(typed), Ok(number), "{typed}");
        }
        for typed in ["", "k", "-3", "1.5", "1.2345k", "ten", "1kk", "inf", "nan", "9007199254740993", "_"] {
            assert!(count(typed).is_err(), "{typed}");
        }
    }

    #[test]
    fn percentages_and_shares_are_the_same_number() {
        for (typed, share) in [("2%", 0.02), ("0.02", 0.02), ("2 %", 0.02), ("0.5%", 0.005), ("100%", 1.0)] {
            assert_eq!(percentage(typed), Ok(share), "{typed}");
        }
        for typed in ["", "%", "two", "2%%", "inf", "nan%", "2 percent"] {
            assert!(percentage(typed).is_err(), "{typed}");
        }
    }

    #[test]
    fn pairs_and_quadruples_are_whole() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        assert_eq!(crop("1, 2,30,40"), Ok(Window { x: 1, y: 2, width: 30, height: 40 }));
        for typed in ["640", "640x", "x480", "640x480x3", "-1x5", "64.0x48"] {
            assert!(size(typed).is_err(), "{typed}");
        }
        assert!(crop("1,2,3").is_err() && crop("1,2,3,4,5").is_err());
    }

    #[test]
    fn shutters_open_before_they_close() {
        assert_eq!(shutter("-0.01, 1e-2"), Ok([-0.01, 0.01]));
        assert_eq!(shutter("2,2"), Ok([2.0, 2.0]));
        for typed in ["", "1", "1,", "2,1", "0,inf", "nan,1", "0,1,2"] {
            assert!(shutter(typed).is_err(), "{typed}");
        }
    }

    #[test]
    fn frames_go_from_one_to_another() {
        assert_eq!(frames("1..48"), Ok([1, 48]));
        assert_eq!(frames("7 .. 7"), Ok([7, 7]));
        for typed in ["", "5", "..", "5..", "5..4", "-1..4", "1...4", "1..=4", "1.5..4"] {
            assert!(frames(typed).is_err(), "{typed}");
        }
    }

    #[test]
    fn addresses_have_a_host_and_a_port() {
        for typed in ["127.0.0.1:14158", "localhost:1", "[::1]:65535"] {
            assert_eq!(address(typed), Ok(typed.to_owned()));
        }
        for typed in ["", "localhost", ":14158", "localhost:0", "localhost:65536", "builtin:tiny", "a:-1"] {
            assert!(address(typed).unwrap_err().contains("127.0.0.1:14158"), "{typed}");
        }
    }

    #[test]
    fn words_and_numbers_share_an_option() {
        assert_eq!((clamp("auto"), clamp("off")), (Ok(Clamp::Auto), Ok(Clamp::Off)));
        assert_eq!(clamp("0.25"), Ok(Clamp::Distance(0.25)));
        assert_eq!((exposure("auto"), exposure("-1.5")), (Ok(Exposure::Auto), Ok(Exposure::Stops(-1.5))));
        assert!(clamp("far").is_err() && exposure("bright").is_err());
    }

    #[test]
    fn methods_are_those_that_can_be_wrong() {
        assert_eq!(method("mdlc"), Ok(SumMethod::Mdlc));
        for typed in ["exact", "path", "", "MDLC"] {
            let said = method(typed).unwrap_err();
            assert!(said.contains("lightcuts, mdlc,") && !said.contains("exact"), "{typed}: {said}");
        }
    }
}
