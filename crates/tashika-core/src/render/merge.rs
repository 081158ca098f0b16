//! Merging of the parts of an image, rendered by several machines, into one film.
//!
//! A part is a film with some of the pixels of a window. Its plane `stop` is 0 at pixels that
//! belong to other parts. Its metadata `tiles` has the part's shares and the number of all shares;
//! `window` has the whole window.
//!
//! Parts of one render have the same planes, size and metadata, and only such parts are merged. The
//! metadata `tiles` and `complete` may differ, as may findings about a single film, such as those
//! of an audit. Such findings are preserved only if the first part is the whole. A pixel may be in
//! several parts, for example if a share was rendered again because its first worker seemed lost.
//! It must then be equal in all of them, bit by bit.
//!
//! # Guarantee
//! The film of all shares equals the film that one machine renders, metadata included.
//!
//! # Held to this by
//! The tests below; `shares_are_merged_to_the_same_bytes` and
//! `many_shares_are_small_films_that_merge_to_the_same_bytes` of the program.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::TileShare;
use crate::error::{Error, Location, Result};
use crate::film::{Film, Metadata, RenderFilm, SampleKind, Value, Window, keys, planes};

/// Film that was joined from parts, with the shares and pixels that are missing.
#[derive(Clone, Debug)]
pub struct Merged {
    /// Film of all parts; pixels that no part has are zero, also in the plane `stop`.
    pub film: Film,
    /// Numbers of the missing shares, counted from 1; empty if none is missing, or if parts do not
    /// state their shares.
    pub missing: Vec<u32>,
    /// Number of shares that the tiles are divided into.
    pub of: u32,
    /// Number of pixels that no part has.
    pub missing_pixels: u64,
    /// File of the first part, for messages.
    pub first: PathBuf,
}

/// Joins parts, one after the other. Only the joined film is held in memory, not the parts.
#[derive(Clone, Debug)]
pub struct Merger {
    /// Joined film, with the metadata of the first part except for values that may differ.
    film: Film,
    /// File of the first part, with which messages compare the others.
    first: PathBuf,
    shares: BTreeSet<u32>,
    of: u32,
}

impl Merger {
    /// Begins with a part; `name` is the name of its file.
    ///
    /// # Errors
    /// [`Error::Invalid`], naming the part, if it is not a part of a render.
    pub fn new(name: &Path, first: &Film) -> Result<Self> {
        let mut film = first.blank(first.size(), window_of(name, first)?)?;
        let mut metadata = Metadata::default();
        let share = share_of(name, first)?;
        let is_whole = share.is_whole() && rendered(name, first)?.into_iter().all(|is| is);
        for (name, value) in first.metadata().iter().filter(|(name, _)| is_whole || !may_differ(name)) {
            metadata.set(name, value.clone());
        }
        *film.metadata_mut() = metadata;
        let mut merger = Self { film, first: name.to_owned(), shares: BTreeSet::new(), of: share.of() };
        merger.add(name, first)?;
        Ok(merger)
    }

    /// Adds a part.
    ///
    /// # Errors
    /// [`Error::Invalid`], naming the part, if it is not of the same render as the first one, or if
    /// one of its pixels was added before with a different value. In both cases nothing of the part
    /// is added.
    pub fn add(&mut self, name: &Path, part: &Film) -> Result<()> {
        self.same_render(name, part)?;
        let share = share_of(name, part)?;
        if share.of() != self.of {
            return Err(self.refused(
                name,
                format!("a share of {}", share.of()),
                format!("a share of {}", self.of),
            ));
        }
        if !self.film.window().covers(&part.window()) {
            let inside = format!("pixels inside {}", self.film.window());
            return Err(self.refused(name, format!("the pixels {}", part.window()), inside));
        }
        let there = rendered(name, part)?;
        let rendered_there = || part.window().pixels().zip(&there).filter(|(_, is)| **is).map(|(at, _)| at);
        let here = rendered(name, &self.film)?;
        let has = |x, y| here[self.film.window().index(x, y)];
        if let Some((x, y)) =
            rendered_there().find(|(x, y)| has(*x, *y) && !same_pixel(&self.film, part, *x, *y))
        {
            let found = format!("another value for pixel {x},{y} than an earlier part");
            return Err(Error::invalid(Location::file(name), found, "parts that agree where they overlap"));
        }
        // Each row is divided into runs of pixels that were all rendered or all not rendered.
        let (left, width) = (part.window().x, part.window().width as usize);
        for (y, row) in (part.window().y..).zip(there.chunks_exact(width)) {
            let mut x = left;
            for run in row.chunk_by(|a, b| a == b) {
                let count = run.len() as u32;
                if run[0] {
                    self.film.copy_pixels([x, y], part, [x, y], count);
                }
                x += count;
            }
        }
        if !share.is_whole() {
            self.shares.extend(share.numbers());
        }
        Ok(())
    }

    /// Returns the film of all parts, with the shares and pixels that are missing.
    ///
    /// # Errors
    /// None for a film that was made by this program.
    pub fn finish(self) -> Result<Merged> {
        let Self { mut film, first, shares, of } = self;
        let missing_pixels = rendered(&first, &film)?.iter().filter(|is| !**is).count() as u64;
        let all = || (1..=of).filter(|_| of > 1 && missing_pixels > 0);
        let missing = all().filter(|n| !shares.contains(n)).collect();
        let share =
            if all().next().is_none() { TileShare::default() } else { TileShare::of_numbers(shares, of)? };
        film.metadata_mut().set(keys::TILES, share.to_string());
        film.metadata_mut().set(keys::COMPLETE, missing_pixels == 0);
        Ok(Merged { film, missing, of, missing_pixels, first })
    }

    fn refused(&self, name: &Path, found: String, expected: String) -> Error {
        Error::invalid(Location::file(name), found, format!("as in {}: {expected}", self.first.display()))
    }

    fn same_render(&self, name: &Path, film: &Film) -> Result<()> {
        let first = &self.film;
        let shows = |f: &Film| format!("an image of {}x{} pixels", f.size()[0], f.size()[1]);
        if shows(film) != shows(first) {
            return Err(self.refused(name, shows(film), shows(first)));
        }
        let planes = |f: &Film| -> Vec<String> {
            f.planes()
                .iter()
                .map(|p| format!("{}[{}] {:?}", p.name(), p.channels().join(","), p.kind()))
                .collect()
        };
        if planes(film) != planes(first) {
            return Err(self.refused(
                name,
                format!("the planes {}", planes(film).join(" ")),
                planes(first).join(" "),
            ));
        }
        let values = |m: &Metadata| -> Vec<(String, Value)> {
            m.iter().filter(|(n, _)| !may_differ(n)).map(|(n, v)| (n.to_owned(), v.clone())).collect()
        };
        let (theirs, ours) = (values(film.metadata()), values(first.metadata()));
        let told = |values: &[(String, Value)], wanted: &str| {
            let found = values.iter().find(|(name, _)| name == wanted);
            found.map_or_else(|| format!("no {wanted}"), |(name, value)| format!("{name} = {value}"))
        };
        let of_theirs = theirs.iter().filter(|v| !ours.contains(v));
        let differ: Vec<_> = of_theirs.chain(ours.iter().filter(|v| !theirs.contains(v))).collect();
        // A different scene or seed also changes values about the making of the film. These are not
        // the cause, and are reported only if nothing else differs.
        let is_cause = |name: &str| keys::about(name) != keys::About::Making;
        match differ.iter().find(|(name, _)| is_cause(name)).or(differ.first()) {
            Some((key, _)) => Err(self.refused(name, told(&theirs, key), told(&ours, key))),
            None => Ok(()),
        }
    }
}

fn same_pixel(a: &Film, b: &Film, x: u32, y: u32) -> bool {
    a.planes().iter().zip(b.planes()).all(|(a, b)| match (a.kind(), b.kind()) {
        (SampleKind::F32, SampleKind::F32) => {
            let bits = |v: &f32| v.to_bits();
            a.f32_at(x, y).iter().map(bits).eq(b.f32_at(x, y).iter().map(bits))
        }
        (SampleKind::U32, SampleKind::U32) => a.u32_at(x, y) == b.u32_at(x, y),
        _ => false,
    })
}

/// Returns the window of the whole render. The image size that a part states is trusted, as
/// `--size` is, even if the part itself is small.
fn window_of(name: &Path, part: &Film) -> Result<Window> {
    let Some(text) = part.metadata().text(keys::WINDOW) else { return Ok(part.window()) };
    let window: Option<Window> = text.parse().ok();
    window.filter(|window| Film::check(part.size(), *window).is_ok()).ok_or_else(|| {
        let found = format!("a film whose window is {text:?}");
        Error::invalid(Location::file(name), found, "a film that was rendered")
    })
}

/// Returns, for each pixel of a film with the plane `stop`, whether it was rendered.
fn rendered(name: &Path, film: &Film) -> Result<Vec<bool>> {
    let read = RenderFilm::of(film);
    if !read.has_stops() {
        let found = format!("a film without the plane `{}`", planes::STOP.name);
        return Err(Error::invalid(Location::file(name), found, "a film that was rendered"));
    }
    Ok((0..film.window().area() as usize).map(|pixel| read.is_rendered(pixel)).collect())
}

fn share_of(name: &Path, film: &Film) -> Result<TileShare> {
    let text = film.metadata().text(keys::TILES).unwrap_or_default();
    text.parse().map_err(|_| {
        let found = format!("a film whose shares of the tiles are {text:?}");
        Error::invalid(Location::file(name), found, "a film of a share of its tiles")
    })
}

/// Returns true if a value of the metadata may differ between parts of one render.
fn may_differ(name: &str) -> bool {
    keys::about(name) == keys::About::Part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PlaneSpec;

    const fn spec(name: &'static str, channels: &'static [&'static str], kind: SampleKind) -> PlaneSpec {
        PlaneSpec { name, channels, unit: "1", kind, doc: "" }
    }
    const SPECS: &[PlaneSpec] =
        &[spec("", &["R", "G", "B"], SampleKind::F32), spec("stop", &["id"], SampleKind::U32)];
    const WINDOW: Window = Window { x: 2, y: 3, width: 5, height: 4 };

    /// Returns a film with the pixels for which `mine` is true. Their values are their positions
    /// and `−0`, whose bits differ from those of `0`.
    fn part(share: &str, mine: impl Fn(u32, u32) -> bool) -> Film {
        let mut film = Film::new([10, 10], WINDOW, SPECS).unwrap();
        for (x, y) in WINDOW.pixels().filter(|(x, y)| mine(*x, *y)) {
            film.plane_mut(planes::RADIANCE).unwrap().set_f32(x, y, &[x as f32, y as f32, -0.0]);
            film.plane_mut(planes::STOP).unwrap().set_u32(x, y, &[3]);
        }
        film.metadata_mut().set(keys::SEED, 7_u32);
        film.metadata_mut().set(keys::TILES, share);
        film.metadata_mut().set(keys::COMPLETE, true);
        film
    }

    fn merged(parts: &[&Film]) -> Result<Merged> {
        let names = ["a.exr", "b.exr", "c.exr"].map(Path::new);
        let mut merger = Merger::new(names[0], parts[0])?;
        names.iter().zip(parts).skip(1).try_for_each(|(name, part)| merger.add(name, part))?;
        merger.finish()
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
    fn parts_may_be_films_of_some_of_the_window() {
        let whole = part("1/1", |_, _| true);
        let said = |mut film: Film| {
            film.metadata_mut().set(keys::WINDOW, WINDOW.to_string());
            film
        };
        let cut = |share: &str, window: Window| {
            let mut film = whole.cropped(window).unwrap();
            film.metadata_mut().set(keys::TILES, share);
            said(film)
        };
        let [left, right] = [("1/2", WINDOW.x, 3), ("2/2", WINDOW.x + 3, 2)]
            .map(|(k, x, width)| cut(k, Window { x, width, ..WINDOW }));
        for parts in [[&left, &right], [&right, &left]] {
            assert_eq!(merged(&parts).unwrap().film, said(whole.clone()));
        }
        assert_eq!(merged(&[&left]).unwrap().missing_pixels, 8);
        let beyond = cut("2/2", Window { x: WINDOW.x, y: WINDOW.y, width: 1, height: 1 });
        let mut outside = beyond.blank([10, 10], Window { x: 0, ..WINDOW }).unwrap();
        *outside.metadata_mut() = beyond.metadata().clone();
        let found = merged(&[&left, &outside]).unwrap_err().to_string();
        assert!(
            found.contains("b.exr: the pixels 0,3,5,4; expected as in a.exr: pixels inside 2,3,5,4"),
            "{found}"
        );
        for said in ["all", "0,0,11,10", "3,3,0,2"] {
            let mut odd = left.clone();
            odd.metadata_mut().set(keys::WINDOW, said);
            let found = merged(&[&odd]).unwrap_err().to_string();
            assert!(found.contains(&format!("a.exr: a film whose window is {said:?}")), "{found}");
        }
    }

    #[test]
    fn what_is_missing_is_told_and_stays_not_rendered() {
        let [a, c] = [0, 2].map(|k| part(&format!("{}/3", k + 1), move |x, y| (x + y) % 3 == k));
        let found = merged(&[&a, &c]).unwrap();
        let of_second = WINDOW.pixels().filter(|(x, y)| (x + y) % 3 == 1).count() as u64;
        assert_eq!((found.missing, found.missing_pixels), (vec![2], of_second));
        assert_eq!(found.film.metadata().text(keys::TILES), Some("1,3/3"));
        assert_eq!(found.film.metadata().bool(keys::COMPLETE), Some(false));
        assert_eq!(found.film.plane(planes::STOP).unwrap().u32_at(2, 5), [0]);
        // Parts can be merged again.
        let b = part("2/3", |x, y| (x + y) % 3 == 1);
        assert_eq!(merged(&[&found.film, &b]).unwrap().film, part("1/1", |_, _| true));
        // A part that was interrupted lacks pixels, but no share is missing.
        let mut broken = part("2/3", |x, y| (x + y) % 3 == 1 && y < 5);
        broken.metadata_mut().set(keys::COMPLETE, false);
        let found = merged(&[&a, &broken, &c]).unwrap();
        assert!(found.missing.is_empty() && found.missing_pixels > 0);
    }

    #[test]
    fn parts_of_another_render_are_refused_with_what_differs() {
        let a = part("1/2", |x, _| x % 2 == 0);
        let said = |b: &Film| merged(&[&a, b]).unwrap_err().to_string();
        let mut b = part("2/2", |x, _| x % 2 == 1);
        b.metadata_mut().set(keys::SEED, 8_u32);
        b.metadata_mut().set(keys::AUDIT_DRAWN, 8_u32);
        assert!(said(&b).contains("b.exr: seed = 8; expected as in a.exr: seed = 7"), "{}", said(&b));
        let mut b = part("2/2", |x, _| x % 2 == 1);
        b.metadata_mut().set(keys::ERROR, 0.02);
        assert!(said(&b).contains("error = 0.02; expected as in a.exr: no error"), "{}", said(&b));
        assert!(
            said(&part("2/3", |_, _| false)).contains("a share of 3; expected as in a.exr: a share of 2")
        );
        assert!(said(&part("2", |_, _| false)).contains("shares of the tiles are \"2\""));
        let mut b = part("1/2", |x, _| x % 2 == 0);
        b.plane_mut(planes::RADIANCE).unwrap().set_f32(4, 4, &[4.0, 4.0, 0.0]);
        assert!(said(&b).contains("b.exr: another value for pixel 4,4"), "{}", said(&b));
        let mut merger = Merger::new(Path::new("a.exr"), &a).unwrap();
        assert!(merger.add(Path::new("b.exr"), &b).is_err());
        merger.add(Path::new("c.exr"), &part("2/2", |x, _| x % 2 == 1)).unwrap();
        assert_eq!(
            merger.finish().unwrap().film,
            part("1/1", |_, _| true),
            "nothing of a refused part is added"
        );
        let other = |size, window| {
            let mut film = Film::new(size, window, SPECS).unwrap();
            film.metadata_mut().set(keys::TILES, "2/2");
            film
        };
        assert!(
            said(&other([11, 10], WINDOW))
                .contains("an image of 11x10 pixels; expected as in a.exr: an image of 10x10")
        );
        let few = Film::new([10, 10], WINDOW, &SPECS[1..]).unwrap();
        assert!(
            said(&few).contains("the planes stop[id] U32; expected as in a.exr: [R,G,B] F32"),
            "{}",
            said(&few)
        );
        let mut audited = part("2/2", |x, _| x % 2 == 1);
        audited.metadata_mut().set(keys::AUDIT_OF, 3_u32);
        assert_eq!(
            merged(&[&audited, &a]).unwrap().film,
            part("1/1", |_, _| true),
            "an audit of a part is not one of the whole"
        );
        let mut whole = part("1/1", |_, _| true);
        whole.metadata_mut().set(keys::AUDIT_OF, 3_u32);
        assert_eq!(merged(&[&whole]).unwrap().film, whole, "that of the whole is");
        let mut broken = part("1/1", |x, _| x > 3);
        broken.metadata_mut().set(keys::AUDIT_OF, 3_u32);
        assert!(merged(&[&broken]).unwrap().film.metadata().get(keys::AUDIT_OF).is_none());
    }
}
