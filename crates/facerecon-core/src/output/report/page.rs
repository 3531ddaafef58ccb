//! What the page's template is filled with.

use askama::Template;
use rayon::prelude::*;

use super::pictures::data_url;
use crate::data::Rgb;
use crate::pipeline::Error;

/// The whole page.
#[derive(Template)]
#[template(path = "report.html")]
pub(super) struct Page {
    pub(super) subtitle: String,
    pub(super) verdict: VerdictBox,
    pub(super) facts: Vec<Fact>,
    pub(super) landmarks: Vec<LandmarkRow>,
    pub(super) distances: Vec<DistanceRow>,
    pub(super) summary: Vec<String>,
    pub(super) warnings: Vec<String>,
    pub(super) sections: Vec<Section>,
    pub(super) times: Vec<Time>,
    pub(super) total_ms: String,
    pub(super) params: String,
}

/// The verdict with its reasons.
pub(super) struct VerdictBox {
    pub(super) level: String,
    pub(super) reasons: Vec<String>,
}

/// A landmark: position in the model frame and standard deviation, mm when the result is metric.
pub(super) struct LandmarkRow {
    pub(super) name: &'static str,
    pub(super) term: &'static str,
    pub(super) side: &'static str,
    pub(super) status: String,
    pub(super) position: String,
    pub(super) sigma: String,
}

/// A measured distance and its standard deviation, mm.
pub(super) struct DistanceRow {
    pub(super) term: &'static str,
    pub(super) abbreviation: &'static str,
    pub(super) value: String,
    pub(super) sigma: String,
}

/// A number with its name.
pub(super) struct Fact {
    pub(super) value: String,
    pub(super) name: &'static str,
}

/// The time of a stage, and its share of the longest one's.
pub(super) struct Time {
    pub(super) stage: String,
    pub(super) ms: String,
    pub(super) percent: String,
}

/// A heading with rows of pictures and plots.
pub(super) struct Section {
    pub(super) title: &'static str,
    /// Whether the section shows one stage, and its heading is of the second level.
    pub(super) is_stage: bool,
    pub(super) text: &'static str,
    pub(super) rows: Vec<Row>,
}

impl Section {
    pub(super) fn new(title: &'static str, rows: Vec<RowBuilder>) -> Self {
        let rows = rows.into_iter().filter_map(RowBuilder::build).collect();
        Self { title, is_stage: false, text: "", rows }
    }

    pub(super) fn of_stage(title: &'static str, rows: Vec<RowBuilder>) -> Self {
        Self { is_stage: true, ..Self::new(title, rows) }
    }
}

/// Pictures and plots side by side.
pub(super) struct Row {
    pub(super) columns: usize,
    pub(super) cells: Vec<Cell>,
}

/// A picture as a data URL, or a plot as SVG.
pub(super) enum Cell {
    Picture { source: String, caption: String },
    Plot(String),
}

enum RawCell {
    Picture(Rgb, String),
    Plot(String),
}

/// Collects the pictures of a row, so that they are encoded in parallel.
pub(super) struct RowBuilder {
    columns: usize,
    cells: Vec<RawCell>,
}

impl RowBuilder {
    /// A row of 2 to 4 columns.
    pub(super) fn new(columns: usize) -> Self {
        Self { columns, cells: Vec::new() }
    }

    pub(super) fn picture(&mut self, image: Rgb, caption: impl Into<String>) {
        self.cells.push(RawCell::Picture(image, caption.into()));
    }

    /// Adds a plot; an empty one is left out.
    pub(super) fn plot(&mut self, svg: String) {
        if !svg.is_empty() {
            self.cells.push(RawCell::Plot(svg));
        }
    }

    /// The row with encoded pictures; `None` without cells.
    fn build(self) -> Option<Row> {
        let cells: Vec<Cell> = self.cells.into_par_iter().filter_map(RawCell::encoded).collect();
        (!cells.is_empty()).then_some(Row { columns: self.columns, cells })
    }
}

impl RawCell {
    fn encoded(self) -> Option<Cell> {
        match self {
            Self::Plot(svg) => Some(Cell::Plot(svg)),
            Self::Picture(image, caption) => {
                data_url(&image).map(|source| Cell::Picture { source, caption })
            }
        }
    }
}

/// Fills a page's template.
pub(in crate::output) fn render(page: &impl Template, name: &str) -> Result<String, Error> {
    page.render().map_err(|fault| Error::Input(format!("{name}: {fault}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page_with(text: &str) -> String {
        let page = Page {
            subtitle: text.to_owned(),
            verdict: VerdictBox { level: "good".into(), reasons: vec![text.to_owned()] },
            landmarks: Vec::new(),
            distances: Vec::new(),
            facts: Vec::new(),
            summary: Vec::new(),
            warnings: vec![text.to_owned()],
            sections: Vec::new(),
            times: Vec::new(),
            total_ms: "0".into(),
            params: text.to_owned(),
        };
        render(&page, "report.html").unwrap()
    }

    #[test]
    fn text_from_files_cannot_become_markup() {
        let html = page_with("<script>\"&\"");
        assert!(!html.contains("<script>"), "{html}");
        assert_eq!(html.matches("script&#62;&#34;&#38;&#34;").count(), 4, "{html}");
    }

    #[test]
    fn a_row_without_cells_is_left_out() {
        let mut empty = RowBuilder::new(2);
        empty.plot(String::new());
        assert!(Section::new("Empty", vec![empty]).rows.is_empty());
    }
}
