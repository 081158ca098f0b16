//! Parts of an image, rendered by several machines, as one film.
//!
//! A part is a film of the whole window in which the plane `stop` is 0 where another part is to be looked at; its metadata `tiles` says
//! which shares of how many it is. Parts go together if they are of the same render: the same planes, window and metadata but for `tiles`,
//! `complete` and what an audit said. A pixel that several parts have (a share that was rendered twice, because the first worker was
//! thought lost) has to be the same in all of them, bit by bit.
//!
//! # Guarantee
//! The film of all shares equals the film that one machine renders, metadata included.
//!
//! # Held to this by
//! The tests below; `shares_are_merged_to_the_same_bytes` of the program.

use std::collections::BTreeSet;
use std::path::Path;

use super::TileShare;
use crate::error::{Error, Location, Result};
use crate::film::{Film, Metadata, Plane, Value};

/// What is known of a film that was joined from parts.
#[derive(Clone, Debug)]
pub struct Merged {
    /// The film; pixels that no part has are zero and say so in `stop`.
    pub film: Film,
    /// Shares that are missing, from 1; empty if none is, or if parts do not say which they are.
    pub missing: Vec<u32>,
    /// How many shares there are.
    pub of: u32,
    /// Pixels that no part has.
    pub missing_pixels: u64,
}

/// Joins parts; each comes with the name of its file.
///
/// # Errors
/// [`Error::Option`] if there is no part; [`Error::Invalid`], naming the part, if it is not of the same render as the first one or has another
/// value for a pixel that both have.
pub fn merge(parts: &[(&Path, &Film)]) -> Result<Merged> {
    let Some(((first_name, first), others)) = parts.split_first() else {
        return Err(Error::option("parts", 0, "at least one film"));
    };
    for (name, film) in others {
        same_render((name, film), (first_name, first))?;
    }
    let mut film = first.blank(first.size(), first.window())?;
    let (mut numbers, mut of) = (BTreeSet::new(), 1);
    for (name, part) in parts {
        let share = share_of(name, part)?;
        // Of the same number, as the first part: it was checked.
        of = of.max(share.of());
        numbers.extend(share.numbers().iter().filter(|_| !share.is_whole()).copied());
        add(&mut film, name, part)?;
    }
    let missing_pixels = stops(first_name, &film)?.iter().filter(|stop| **stop == 0).count() as u64;
    let missing: Vec<u32> = (1..=of).filter(|n| of > 1 && !numbers.contains(n)).collect();
    let share = if missing_pixels == 0 || of == 1 {
        TileShare::default()
    } else {
        TileShare::of_numbers(numbers, of)?
    };
    // An audit was of a part.
    let mut metadata = Metadata::default();
    for (name, value) in first.metadata().iter().filter(|(name, _)| !name.starts_with("audit.")) {
        metadata.set(name, value.clone());
    }
    metadata.set("tiles", share.to_string());
    metadata.set("complete", missing_pixels == 0);
    *film.metadata_mut() = metadata;
    Ok(Merged { missing: if missing_pixels == 0 { Vec::new() } else { missing }, film, of, missing_pixels })
}

/// Copies the pixels of a part that were rendered.
fn add(film: &mut Film, name: &Path, part: &Film) -> Result<()> {
    let window = part.window();
    let (there, here) = (stops(name, part)?, stops(name, film)?.to_vec());
    for (i, (x, y)) in window.pixels().enumerate().filter(|(i, _)| there[*i] != 0) {
        if here[i] != 0 && !same_pixel(film, part, i) {
            let found = format!("another value for pixel {x},{y} than an earlier part");
            return Err(Error::invalid(Location::file(name), found, "parts that agree where they overlap"));
        }
        film.copy_pixels([x, y], part, [x, y], 1);
    }
    Ok(())
}

fn same_pixel(a: &Film, b: &Film, i: usize) -> bool {
    a.planes().iter().zip(b.planes()).all(|(a, b)| {
        let n = a.channels().len();
        let range = i * n..(i + 1) * n;
        let bits = |p: &Plane| -> Vec<u32> {
            let floats = p.f32_samples().map(|s| s[range.clone()].iter().map(|v| v.to_bits()).collect());
            floats.or_else(|| p.u32_samples().map(|s| s[range.clone()].to_vec())).unwrap_or_default()
        };
        bits(a) == bits(b)
    })
}

fn stops<'f>(name: &Path, film: &'f Film) -> Result<&'f [u32]> {
    let plane = film.plane("stop").filter(|p| p.channels().len() == 1).and_then(Plane::u32_samples);
    plane.ok_or_else(|| {
        Error::invalid(
            Location::file(name),
            "a film without the plane `stop`",
            "a part that `tashika render` wrote",
        )
    })
}

fn share_of(name: &Path, film: &Film) -> Result<TileShare> {
    let text = film.metadata().text("tiles").unwrap_or_default();
    text.parse().map_err(|_| {
        let found = format!("a film whose shares of the tiles are {text:?}");
        Error::invalid(Location::file(name), found, "a part that `tashika render --tiles K/N` wrote")
    })
}

/// What may differ between parts of one render.
fn may_differ(name: &str) -> bool {
    name == "tiles" || name == "complete" || name.starts_with("audit.")
}

fn same_render((name, film): (&Path, &Film), (first_name, first): (&Path, &Film)) -> Result<()> {
    let refuse = |found: String, expected: String| {
        Err(Error::invalid(
            Location::file(name),
            found,
            format!("as in {}: {expected}", first_name.display()),
        ))
    };
    let shows = |f: &Film| {
        let ([width, height], w) = (f.size(), f.window());
        format!("the part {},{},{},{} of {width}x{height} pixels", w.x, w.y, w.width, w.height)
    };
    if shows(film) != shows(first) {
        return refuse(shows(film), shows(first));
    }
    let planes = |f: &Film| -> Vec<String> {
        f.planes()
            .iter()
            .map(|p| format!("{}[{}] {:?}", p.name(), p.channels().join(","), p.kind()))
            .collect()
    };
    if planes(film) != planes(first) {
        return refuse(format!("the planes {}", planes(film).join(" ")), planes(first).join(" "));
    }
    let of = |name, f| share_of(name, f).map(|share| share.of());
    let (theirs, ours) = (of(name, film)?, of(first_name, first)?);
    if theirs != ours {
        return refuse(format!("a share of {theirs}"), format!("a share of {ours}"));
    }
    let values = |m: &Metadata| -> Vec<(String, Value)> {
        m.iter().filter(|(n, _)| !may_differ(n)).map(|(n, v)| (n.to_owned(), v.clone())).collect()
    };
    let (theirs, ours) = (values(film.metadata()), values(first.metadata()));
    let told = |values: &[(String, Value)], wanted: &str| {
        let found = values.iter().find(|(name, _)| name == wanted);
        found.map_or_else(|| format!("no {wanted}"), |(name, value)| format!("{name} = {value}"))
    };
    let differs =
        theirs.iter().find(|v| !ours.contains(v)).or_else(|| ours.iter().find(|v| !theirs.contains(v)));
    match differs {
        Some((key, _)) => refuse(told(&theirs, key), told(&ours, key)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PlaneSpec, SampleKind, Window};

    const fn spec(name: &'static str, channels: &'static [&'static str], kind: SampleKind) -> PlaneSpec {
        PlaneSpec { name, channels, unit: "1", kind, doc: "" }
    }
    const WINDOW: Window = Window { x: 2, y: 3, width: 5, height: 4 };

    /// The pixels of which `mine` says so, of a film whose values are their place and bits that are not those of a number's value.
    fn part(share: &str, mine: impl Fn(u32, u32) -> bool) -> Film {
        let specs = [spec("", &["R", "G", "B"], SampleKind::F32), spec("stop", &["id"], SampleKind::U32)];
        let mut film = Film::new([10, 10], WINDOW, &specs).unwrap();
        for (x, y) in WINDOW.pixels().filter(|(x, y)| mine(*x, *y)) {
            film.plane_mut("").unwrap().set_f32(x, y, &[x as f32, y as f32, -0.0]);
            film.plane_mut("stop").unwrap().set_u32(x, y, &[3]);
        }
        film.metadata_mut().set("seed", 7_u32);
        film.metadata_mut().set("tiles", share);
        film.metadata_mut().set("complete", true);
        film
    }

    fn merged(parts: &[&Film]) -> Result<Merged> {
        let names = ["a.exr", "b.exr", "c.exr"].map(Path::new);
        merge(&names.into_iter().zip(parts.iter().copied()).collect::<Vec<_>>())
    }

    #[test]
    fn all_parts_are_the_whole_film_in_any_order_and_twice_too() {
        let [a, b, c] = [0, 1, 2].map(|k| part(&format!("{}/3", k + 1), move |x, y| (x + y) % 3 == k));
        let whole = part("1/1", |_, _| true);
        for parts in [[&a, &b, &c], [&c, &a, &b]] {
            let found = merged(&parts).unwrap();
            assert_eq!(found.film, whole);
            assert!(found.missing.is_empty() && found.missing_pixels == 0 && found.of == 3);
        }
        let both = part("1,2/3", |x, y| (x + y) % 3 != 2);
        assert_eq!(merged(&[&both, &b, &c]).unwrap().film, whole);
        assert_eq!(merged(&[&whole, &whole]).unwrap().film, whole);
    }

    #[test]
    fn what_is_missing_is_told_and_stays_not_rendered() {
        let [a, c] = [0, 2].map(|k| part(&format!("{}/3", k + 1), move |x, y| (x + y) % 3 == k));
        let found = merged(&[&a, &c]).unwrap();
        let of_second = WINDOW.pixels().filter(|(x, y)| (x + y) % 3 == 1).count() as u64;
        assert_eq!((found.missing, found.missing_pixels), (vec![2], of_second));
        assert_eq!(found.film.metadata().text("tiles"), Some("1,3/3"));
        assert_eq!(found.film.metadata().bool("complete"), Some(false));
        assert_eq!(found.film.plane("stop").unwrap().u32_at(2, 5), [0]);
        // Parts can be merged again.
        let b = part("2/3", |x, y| (x + y) % 3 == 1);
        assert_eq!(merged(&[&found.film, &b]).unwrap().film, part("1/1", |_, _| true));
        // A part that was interrupted leaves pixels out, but no share.
        let mut broken = part("2/3", |x, y| (x + y) % 3 == 1 && y < 5);
        broken.metadata_mut().set("complete", false);
        let found = merged(&[&a, &broken, &c]).unwrap();
        assert!(found.missing.is_empty() && found.missing_pixels > 0);
    }

    #[test]
    fn parts_of_another_render_are_refused_with_what_differs() {
        let a = part("1/2", |x, _| x % 2 == 0);
        let said = |b: &Film| merged(&[&a, b]).unwrap_err().to_string();
        let mut b = part("2/2", |x, _| x % 2 == 1);
        b.metadata_mut().set("seed", 8_u32);
        assert!(said(&b).contains("b.exr: seed = 8; expected as in a.exr: seed = 7"), "{}", said(&b));
        let mut b = part("2/2", |x, _| x % 2 == 1);
        b.metadata_mut().set("error", 0.02);
        assert!(said(&b).contains("error = 0.02; expected as in a.exr: no error"), "{}", said(&b));
        assert!(
            said(&part("2/3", |_, _| false)).contains("a share of 3; expected as in a.exr: a share of 2")
        );
        assert!(said(&part("2", |_, _| false)).contains("shares of the tiles are \"2\""));
        let mut b = part("1/2", |x, _| x % 2 == 0);
        b.plane_mut("").unwrap().set_f32(4, 4, &[4.0, 4.0, 0.0]);
        assert!(said(&b).contains("b.exr: another value for pixel 4,4"), "{}", said(&b));
        let small =
            Film::new([10, 10], Window { width: 4, ..WINDOW }, &[spec("stop", &["id"], SampleKind::U32)])
                .unwrap();
        assert!(
            said(&small).contains("the part 2,3,4,4 of 10x10 pixels; expected as in a.exr: the part 2,3,5,4")
        );
        let mut audited = part("2/2", |x, _| x % 2 == 1);
        audited.metadata_mut().set("audit.of", 3_u32);
        assert_eq!(
            merged(&[&audited, &a]).unwrap().film,
            part("1/1", |_, _| true),
            "an audit of a part is not one of the whole"
        );
        assert!(merge(&[]).is_err());
    }
}
