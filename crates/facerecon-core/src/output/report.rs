//! The report of a run: one HTML file that needs no network, with pictures, plots and the numbers
//! in words. The page's template is `templates/report.html`.

pub mod marks;
mod numbers;
mod overview;
mod page;
mod pictures;
pub mod plots;
mod stages;
mod summary;

use crate::data::Capture;
use crate::output::Record;
use crate::pipeline::{Error, Reconstruction};

pub(super) use page::render as render_page;
pub use summary::summary;

/// The report of a run as an HTML text that needs no other file.
///
/// # Errors
/// [`Error::Input`] where the page cannot be written, which a valid template excludes.
pub fn html(capture: &Capture, result: &Reconstruction, record: &Record) -> Result<String, Error> {
    let shaded = pictures::shaded(&result.mesh);
    let verdict = &result.verdict;
    let mut sections = overview::sections(capture, result, record, verdict, shaded.as_ref());
    sections.extend(stages::sections(capture, result, record, shaded.as_ref()));
    page::render(&overview::page(capture, result, verdict.clone(), sections), "report.html")
}
