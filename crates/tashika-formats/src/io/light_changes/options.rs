//! Options `name=value` in the text of a light.

use super::{Cie, Sun, Turned};
use crate::scene::sky::{MAX_TURBIDITY, MIN_TURBIDITY};
use crate::scene::{CalendarDate, CieSky};

/// Largest factor on a light.
const MAX_SCALE: f32 = 1e30;

/// Parses a finite number in single precision.
pub(super) fn number(text: &str) -> Result<f32, String> {
    let number = text.trim().parse::<f32>().ok().filter(|v| v.is_finite());
    number.ok_or_else(|| format!("{text:?} is no number"))
}

/// Parses a finite number in double precision.
pub(super) fn wide_number(text: &str) -> Result<f64, String> {
    number(text)?;
    text.trim().parse().map_err(|_| format!("{text:?} is no number"))
}

/// Options of a light, in the form `name=value`.
pub(super) struct Options<'t>(Vec<(&'t str, &'t str)>);

impl<'t> Options<'t> {
    /// Every option that may follow a file or a place.
    const NAMES: [&'static str; 6] = ["elevation", "azimuth", "turbidity", "scale", "rotate", "up"];

    /// Splits a text into the part before its options and the options, of which the last comes
    /// first. Options are split off from the end, because file names may contain commas.
    pub(super) fn behind(text: &'t str) -> (&'t str, Vec<&'t str>) {
        Self::behind_file(text, &Self::NAMES)
    }

    /// As [`Self::behind`], for options of the given names.
    pub(super) fn behind_file(text: &'t str, names: &[&str]) -> (&'t str, Vec<&'t str>) {
        let (mut before, mut options) = (text, Vec::new());
        while let Some((rest, last)) = before.rsplit_once(',') {
            if !last.split_once('=').is_some_and(|(name, _)| names.contains(&name)) {
                break;
            }
            options.push(last);
            before = rest;
        }
        (before, options)
    }

    /// Splits options into names and values; each name may occur once.
    pub(super) fn of(words: impl IntoIterator<Item = &'t str>) -> Result<Self, String> {
        let mut options: Vec<(&str, &str)> = Vec::new();
        for word in words {
            let option = word.split_once('=').ok_or_else(|| format!("{word:?} is no NAME=VALUE"))?;
            if options.iter().any(|(name, _)| *name == option.0) {
                return Err(format!("{} twice", option.0));
            }
            options.push(option);
        }
        Ok(Self(options))
    }

    /// Returns true if an option is given and was not taken yet.
    pub(super) fn has(&self, name: &str) -> bool {
        self.0.iter().any(|(known, _)| *known == name)
    }

    fn take(&mut self, name: &str) -> Option<&'t str> {
        let at = self.0.iter().position(|(n, _)| *n == name)?;
        Some(self.0.swap_remove(at).1)
    }

    /// Takes a number in a range; a missing one is `missing`, or an error.
    pub(super) fn number(
        &mut self,
        name: &str,
        range: [f32; 2],
        missing: Option<f32>,
    ) -> Result<f32, String> {
        let Some(text) = self.take(name) else { return missing.ok_or_else(|| format!("no {name}")) };
        let value = number(text)?;
        let [lo, hi] = range;
        if (lo..=hi).contains(&value) { Ok(value) } else { Err(format!("{name} from {lo} to {hi}")) }
    }

    /// Takes a number in a range, in double precision.
    pub(super) fn wide(&mut self, name: &str, range: [f64; 2]) -> Result<f64, String> {
        let value = wide_number(self.take(name).ok_or_else(|| format!("no {name}"))?)?;
        let [lo, hi] = range;
        if (lo..=hi).contains(&value) { Ok(value) } else { Err(format!("{name} from {lo} to {hi}")) }
    }

    /// Takes one of several words, the first if the option is missing.
    pub(super) fn choice<const N: usize>(
        &mut self,
        name: &str,
        words: [&'static str; N],
    ) -> Result<&'static str, String> {
        let Some(text) = self.take(name) else { return Ok(words[0]) };
        let known = words.into_iter().find(|word| *word == text);
        known.ok_or_else(|| format!("{name} is {}", words.join(" or ")))
    }

    /// Takes the day of a `date=YYYY-MM-DD`.
    pub(super) fn date(&mut self) -> Result<Option<CalendarDate>, String> {
        let Some(text) = self.take("date") else { return Ok(None) };
        let parts: Vec<Option<u32>> = text.split('-').map(|part| part.parse().ok()).collect();
        let date = match parts[..] {
            [Some(year), Some(month), Some(day)] => {
                i32::try_from(year).ok().and_then(|year| CalendarDate::new(year, month, day))
            }
            _ => None,
        };
        date.map(Some).ok_or_else(|| format!("{text:?} is no day YYYY-MM-DD from 1900 to 2100"))
    }

    /// Takes the month and day of a `date=MM-DD`.
    pub(super) fn month_and_day(&mut self) -> Result<(u32, u32), String> {
        let text = self.take("date").ok_or("no date")?;
        let parts: Vec<Option<u32>> = text.split('-').map(|part| part.parse().ok()).collect();
        match parts[..] {
            // A year of 366 days has every day of a weather file.
            [Some(month), Some(day)] if CalendarDate::new(2000, month, day).is_some() => Ok((month, day)),
            _ => Err(format!("{text:?} is no day MM-DD")),
        }
    }

    /// Takes a `time=HH:MM`, in minutes since the beginning of the day.
    pub(super) fn minutes(&mut self) -> Result<u32, String> {
        let text = self.take("time").ok_or("no time")?;
        let parts: Vec<Option<u32>> = text.split(':').map(|part| part.parse().ok()).collect();
        match parts[..] {
            [Some(hours @ 0..=23), Some(minutes @ 0..=59)] => Ok(60 * hours + minutes),
            _ => Err(format!("{text:?} is no time HH:MM from 00:00 to 23:59")),
        }
    }

    /// Takes the position of the sun and the turbidity of the air.
    pub(super) fn sun(&mut self) -> Result<Sun, String> {
        Ok(Sun {
            elevation: self.number("elevation", [0.0, 90.0], None)?,
            azimuth: self.number("azimuth", [-360.0, 360.0], None)?,
            turbidity: self.number("turbidity", [MIN_TURBIDITY, MAX_TURBIDITY], Some(3.0))?,
        })
    }

    /// Takes the options of a sky of ISO 15469. Types with a sun need its position, others have
    /// none.
    pub(super) fn cie(&mut self, kind: u32) -> Result<Cie, String> {
        let sun = if CieSky::has_sun(kind) {
            let elevation = self.number("elevation", [0.0, 90.0], None)?;
            Some([elevation, self.number("azimuth", [-360.0, 360.0], None)?])
        } else {
            None
        };
        Ok(Cie {
            kind,
            sun,
            illuminance: self.number("illuminance", [0.0, MAX_SCALE], Some(10_000.0))?,
            ground: self.number("ground", [0.0, 1.0], Some(0.0))?,
        })
    }

    /// Takes the options of [`Turned`], with `rotate` only if `rotates` is true. Any option that is
    /// left is an error.
    pub(super) fn turned(&mut self, rotates: bool) -> Result<Turned, String> {
        let turned = Turned {
            scale: self.number("scale", [0.0, MAX_SCALE], Some(1.0))?,
            rotate: if rotates { self.number("rotate", [-360.0, 360.0], Some(0.0))? } else { 0.0 },
            z_is_up: match self.take("up") {
                None | Some("y") => false,
                Some("z") => true,
                Some(_) => return Err("up is y or z".to_owned()),
            },
        };
        match self.0.first() {
            Some((name, _)) => Err(format!("{name} is no option here")),
            None => Ok(turned),
        }
    }
}
