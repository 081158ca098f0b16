//! `tashika experiment iwasaki2019`: whole images of all methods, and their errors.

use tashika::experiment::{Cell, Column, Pixels, Pool, Row};
use tashika::film::Film;
use tashika::integrator::Setting;
use tashika::io::{Exposure, ToneMap, write_exr, write_file, write_png};
use tashika::report::{error_image, percent_of_tolerance};
use tashika::tree::LightSet;

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{
    Bench, Findings, Subjects, about_intervals, prepare, quantities, scenery, subject, told,
};
use crate::plan::{Folder, Iwasaki2019Plan};
use crate::progress::Meter;
use crate::stage::timed;
use crate::summary::Seconds;
use crate::watcher::Watcher;

const COLUMNS: &[Column] = &[
    Column::Method,
    Column::Error,
    Column::Within,
    Column::Confidence,
    Column::Claims,
    Column::Median,
    Column::P95,
    Column::Worst,
    Column::Budget,
    Column::Rays,
    Column::Pairs,
    Column::Seconds,
];

/// Stem of the names of the reference's files.
const REFERENCE: &str = "reference";

/// Renders all methods, compares them with the reference, and writes all files.
pub fn work(plan: &Iwasaki2019Plan, meter: &Meter) -> Result<Outcome, Failure> {
    let measure = &plan.measure;
    let watcher = Watcher::new(meter, Seconds::default());
    let (stage, subjects) = prepare(measure, &plan.asked, plan.pixels, meter, &watcher)?;
    let Subjects { prepared, pixels, lights } = &subjects;
    let setting = prepared.setting();
    let error = percent_of_tolerance(measure.cells[0].tolerance);
    let mut findings = Findings {
        title: format!("{}: within {error} of the exact sum", stage.scene.name()),
        above: vec![scenery(&stage, pixels), quantities(lights.set().len() as u64, &setting.view.gather)],
        rows: Vec::new(),
        of: measure.cells.len(),
        columns: COLUMNS,
        below: about_intervals(),
        images: Vec::new(),
        reference: None,
    };
    let mut gallery = Gallery { folder: &plan.folder, exposure: Exposure::Auto };
    interrupt::with_flag(|cancel| -> Result<(), Failure> {
        let bench = Bench { meter, cancel };
        let run = Run { bench, setting, lights, pixels };
        let Some(reference) = run.bench.exact(&run.setting, lights, pixels)? else { return Ok(()) };
        write_exr(&plan.folder.file(&format!("{REFERENCE}.exr")), &reference)?;
        if let Pixels::All(_) = pixels {
            gallery.show(&reference, REFERENCE)?;
        }
        for cell in &measure.cells {
            let Some((row, film)) = run.method(cell, &reference, &mut gallery)? else { break };
            if let Pixels::All(_) = pixels {
                findings.images.push((row.method.to_owned(), film));
            }
            findings.rows.push(row);
        }
        findings.reference = Some(reference);
        Ok(())
    })?;
    findings.finish(&measure.common, Some(&plan.folder), meter)
}

/// Inputs that are the same for all methods.
struct Run<'a> {
    bench: Bench<'a>,
    setting: Setting<'a>,
    lights: &'a LightSet,
    pixels: &'a Pixels,
}

impl Run<'_> {
    /// Renders one method's image and compares it with the reference; `None` if interrupted.
    fn method(
        &self,
        cell: &Cell,
        reference: &Film,
        gallery: &mut Gallery<'_>,
    ) -> Result<Option<(Row, Film)>, Failure> {
        let meter = self.bench.meter;
        let all = Pixels::All(reference.window());
        meter.phase(&told(cell));
        let integrator = cell.method.integrator(self.lights, &cell.options)?;
        let mut seconds = 0.0;
        let rendered = timed(&mut seconds, || {
            all.render(&self.setting, integrator.as_ref(), &|p| meter.update(p), self.bench.cancel)
        })?;
        if !rendered.complete {
            return Ok(None);
        }
        let mut pool = Pool::new(cell.allowed());
        let comparison = pool.add(&rendered.film, reference)?;
        let row = Row::new(&subject(&self.setting, self.lights, self.pixels), cell.into(), &pool, seconds);
        let name = cell.method.name();
        write_exr(&gallery.folder.file(&format!("{name}.exr")), &rendered.film)?;
        gallery.show(&rendered.film, name)?;
        // An error image of a few pixels would show nothing.
        if let Pixels::All(_) = self.pixels {
            let file = format!("{name}-error.png");
            write_file(&gallery.folder.file(&file), &error_image(&comparison).png())?;
        }
        Ok(Some((row, rendered.film)))
    }
}

/// Writer of pictures that all have the same exposure.
struct Gallery<'a> {
    folder: &'a Folder,
    exposure: Exposure,
}

impl Gallery<'_> {
    /// Writes the picture of a film; the first one sets the exposure.
    fn show(&mut self, film: &Film, name: &str) -> Result<(), Failure> {
        let file = format!("{name}.png");
        let tone_map = ToneMap { exposure: self.exposure, ..ToneMap::default() };
        self.exposure = Exposure::Stops(write_png(&self.folder.file(&file), film, &tone_map)?);
        Ok(())
    }
}
