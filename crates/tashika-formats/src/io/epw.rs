//! Weather files of EnergyPlus (`.epw`): the place, and one hour of irradiance.
//!
//! ```text
//! LOCATION,city,state,country,source,station,LATITUDE,LONGITUDE,ZONE,elevation
//! …
//! DATA PERIODS,periods,RECORDS AN HOUR,…
//! year,month,day,hour,minute,flags,dry bulb,DEW POINT,…,DIRECT NORMAL,DIFFUSE HORIZONTAL,…
//! ```
//!
//! Hour 1 is from 0:00 to 1:00 of the standard time of the place, without daylight saving, and hour
//! 24 ends at midnight. Irradiances (Wh·m⁻² in the hour, which are W·m⁻² on average) belong to the
//! middle of the hour (Crawley, Hand and Lawrie 1999). The year of a line is the one in which it
//! was measured; months of a typical year come from different years.
//!
//! # Limits
//! Files with several records an hour are refused.
//!
//! # Held to this by
//! The tests below.

use super::text::{decoded, utf8_or_latin1};
use crate::error::{Error, Location, Result};
use crate::scene::CalendarDate;

/// Columns of a record, from 0.
const DEW_POINT: usize = 7;
const DIRECT_NORMAL: usize = 14;
const DIFFUSE_HORIZONTAL: usize = 15;
/// Values at and above which a dew point or an irradiance is missing.
const NO_DEW_POINT: f64 = 99.0;
const NO_IRRADIANCE: f64 = 9999.0;

/// One hour at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WeatherHour {
    /// Degrees, positive to the north and to the east.
    pub latitude: f64,
    pub longitude: f64,
    /// Hours by which the clock is ahead of universal time.
    pub zone: f64,
    pub date: CalendarDate,
    /// Middle of the hour, in hours since the beginning of the day.
    pub middle: f64,
    /// Direct normal irradiance (W·m⁻²).
    pub direct_normal: f64,
    /// Diffuse horizontal irradiance (W·m⁻²).
    pub diffuse_horizontal: f64,
    /// Dew point (°C), if the file has it.
    pub dew_point: Option<f64>,
    /// Line of the record, from 1.
    pub line: u32,
}

/// Reads the hour that begins at `hour` (0 to 23) of a day.
///
/// # Errors
/// [`Error::Invalid`] with the line of a value that is not a number in its range, and if the file
/// has no such hour.
pub(super) fn hour(bytes: &[u8], month: u32, day: u32, hour: u32, at: &Location) -> Result<WeatherHour> {
    let bytes = decoded(bytes);
    let text = utf8_or_latin1(&bytes);
    let mut place = None;
    let wanted = [month, day, hour + 1].map(f64::from);
    for (line, content) in (1..).zip(text.lines()) {
        let record = Record { line, words: content.split(',').map(str::trim).collect(), at };
        match record.words[0].to_ascii_uppercase().as_str() {
            "LOCATION" => {
                place = Some([
                    record.number(6, "latitude", [-90.0, 90.0])?,
                    record.number(7, "longitude", [-180.0, 180.0])?,
                    record.number(8, "zone", [-14.0, 14.0])?,
                ]);
            }
            "DATA PERIODS" => {
                let count = record.number(2, "records an hour", [1.0, 60.0])?;
                if count != 1.0 {
                    let at = Location::line(at.file.clone(), line);
                    return Err(Error::unsupported(
                        at,
                        format!("{count} records an hour"),
                        "use hourly data",
                    ));
                }
            }
            first if first.starts_with(|c: char| c.is_ascii_digit()) => {
                let found = [
                    record.number(1, "month", [1.0, 12.0])?,
                    record.number(2, "day", [1.0, 31.0])?,
                    record.number(3, "hour", [1.0, 24.0])?,
                ];
                if found == wanted {
                    return record.hour(place, [month, day, hour]);
                }
            }
            _ => {}
        }
    }
    let found = format!("no record of {month:02}-{day:02}, hour {}", hour + 1);
    Err(Error::invalid(at.clone(), found, "an EPW file with a record of every hour of the year"))
}

/// Line of a file, split at commas.
struct Record<'t> {
    line: u32,
    words: Vec<&'t str>,
    at: &'t Location,
}

impl Record<'_> {
    fn wrong(&self, found: String, expected: String) -> Error {
        Error::invalid(Location::line(self.at.file.clone(), self.line), found, expected)
    }

    /// Number in a column, counted from 0.
    fn number(&self, column: usize, name: &str, range: [f64; 2]) -> Result<f64> {
        let [least, most] = range;
        let text = self.words.get(column).copied().unwrap_or_default();
        let number = text.parse::<f64>().ok().filter(|value| (least..=most).contains(value));
        number.ok_or_else(|| {
            let shown: String = text.chars().take(20).collect();
            let expected = format!("a number from {least} to {most} in column {}", column + 1);
            self.wrong(format!("{name} = {shown:?}"), expected)
        })
    }

    /// Irradiance in a column (W·m⁻²).
    fn irradiance(&self, column: usize, name: &str) -> Result<f64> {
        let value = self.number(column, name, [0.0, 1e6])?;
        if value < NO_IRRADIANCE {
            return Ok(value);
        }
        Err(self
            .wrong(format!("{name} = {value}, which means missing"), "an hour with this value".to_owned()))
    }

    fn hour(&self, place: Option<[f64; 3]>, [month, day, hour]: [u32; 3]) -> Result<WeatherHour> {
        let Some([latitude, longitude, zone]) = place else {
            return Err(
                self.wrong("no line LOCATION before".to_owned(), "the header of an EPW file".to_owned())
            );
        };
        let year = self.number(0, "year", [1900.0, 2100.0])?;
        let Some(date) = CalendarDate::new(year as i32, month, day) else {
            return Err(self.wrong(format!("{year}-{month:02}-{day:02}"), "a day of the calendar".to_owned()));
        };
        Ok(WeatherHour {
            latitude,
            longitude,
            zone,
            date,
            middle: f64::from(hour) + 0.5,
            direct_normal: self.irradiance(DIRECT_NORMAL, "direct normal irradiance")?,
            diffuse_horizontal: self.irradiance(DIFFUSE_HORIZONTAL, "diffuse horizontal irradiance")?,
            dew_point: self
                .number(DEW_POINT, "dew point", [-100.0, 1000.0])
                .ok()
                .filter(|t| *t < NO_DEW_POINT),
            line: self.line,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "LOCATION,Berlin,-,DEU,IWEC Data,103840,52.47,13.40,1.0,49.0\r\n\
        DESIGN CONDITIONS,0\r\nDATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31\r\n";

    fn record(year: &str, hour: u32, dew_point: &str, direct: &str, diffuse: &str) -> String {
        format!(
            "{year},6,21,{hour},60,?9?9,20.0,{dew_point},50,101325,0,1300,330,500,{direct},{diffuse},0,0\r\n"
        )
    }

    fn read(text: &str, at_hour: u32) -> Result<WeatherHour> {
        hour(text.as_bytes(), 6, 21, at_hour, &Location::file("b.epw"))
    }

    /// Hour 15 of the file is from 14:00 to 15:00; its middle is 14:30.
    #[test]
    fn the_hour_of_a_time_is_the_one_around_it() {
        let text = format!(
            "{HEADER}{}{}",
            record("1991", 14, "9", "1", "2"),
            record("1991", 15, "12.5", "640", "180")
        );
        let found = read(&text, 14).unwrap();
        let date = CalendarDate::new(1991, 6, 21).unwrap();
        let expected = WeatherHour {
            latitude: 52.47,
            longitude: 13.4,
            zone: 1.0,
            date,
            middle: 14.5,
            direct_normal: 640.0,
            diffuse_horizontal: 180.0,
            dew_point: Some(12.5),
            line: 5,
        };
        assert_eq!(found, expected);
        let missing = format!("{HEADER}{}", record("1991", 15, "99.9", "640", "180"));
        assert_eq!(read(&missing, 14).unwrap().dew_point, None);
    }

    #[test]
    fn errors_name_the_line_and_the_accepted_values() {
        let with = |line: &str| read(&format!("{HEADER}{line}"), 14).unwrap_err().to_string();
        for (line, why) in [
            (
                record("1991", 15, "9", "-1", "2"),
                "b.epw:4: direct normal irradiance = \"-1\"; expected a number from 0",
            ),
            (record("1991", 15, "9", "1", "x"), "b.epw:4: diffuse horizontal irradiance = \"x\""),
            (record("1991", 15, "9", "9999", "2"), "means missing"),
            (record("91", 15, "9", "1", "2"), "b.epw:4: year = \"91\"; expected a number from 1900 to 2100"),
            (record("1991", 15, "9", "1", "2").replace(",15,", ",25,"), "b.epw:4: hour = \"25\""),
            (record("1991", 14, "9", "1", "2"), "no record of 06-21, hour 15"),
            ("1991,6,21,15\n".to_owned(), "b.epw:4: direct normal irradiance = \"\""),
        ] {
            assert!(with(&line).contains(why), "{}", with(&line));
        }
        let line = record("1991", 15, "9", "1", "2");
        let headless = read(&line, 14).unwrap_err().to_string();
        assert!(headless.contains("b.epw:1: no line LOCATION"), "{headless}");
        let north = read(&format!("{}{line}", HEADER.replace("52.47", "95")), 14).unwrap_err().to_string();
        assert!(north.contains("b.epw:1: latitude"), "{north}");
        let often = read(&format!("{}{line}", HEADER.replace("PERIODS,1,1", "PERIODS,1,4")), 14).unwrap_err();
        assert!(often.to_string().contains("4 records an hour"), "{often}");
        assert!(read("", 14).is_err() && read("\u{0}\u{ff},,,,", 14).is_err());
    }
}
