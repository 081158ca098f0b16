//! `tashika view`.

use std::sync::Arc;
use std::thread;

use serde::Serialize;
use tashika::report::{Page, Provenance};
use tashika_viewer::{Shown, StoredFilm};

use crate::exit::{Failure, Outcome};
use crate::plan::ViewPlan;
use crate::progress::{Meter, metered};
use crate::serve::Served;
use crate::summary::{print, typed_command, write_json};

/// Address of the page, for scripts.
#[derive(Debug, Serialize)]
struct Report {
    address: String,
}

/// Serves the page of a file until Ctrl-C.
pub fn run(plan: &ViewPlan) -> Result<Outcome, Failure> {
    metered(&plan.common, |meter| work(plan, meter))
}

fn work(plan: &ViewPlan, meter: &Meter) -> Result<Outcome, Failure> {
    meter.phase(&format!("opening {}", plan.image.display()));
    let film = StoredFilm::open(&plan.image, plan.reference.as_deref())?;
    let name = plan.image.display().to_string();
    let mut page = Page::new(&name, &name);
    if let Some(reference) = &plan.reference {
        page.lines = vec![format!("Errors are measured from {}.", reference.display())];
    }
    page.tone = plan.tone;
    page.command = Some(typed_command());
    page.provenance = vec![Provenance::of(&name, film.metadata())];
    let shown: Arc<dyn Shown> = Arc::new(film);
    let served = Served::start(vec![(name, shown)], page, &plan.serving)?;
    let address = served.address();
    meter.finish();
    if let Some(path) = &plan.common.json {
        write_json(path, &Report { address: address.clone() })?;
    }
    if plan.common.prints_rows() {
        print(&format!("{} is shown at {address} until Ctrl-C\n", plan.image.display()))?;
    }
    // The server has threads of its own; Ctrl-C ends the program.
    loop {
        thread::park();
    }
}
