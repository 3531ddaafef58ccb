//! Plots as SVG (the thesis draws them with JFreeChart, section 6.1).

use plotters::prelude::*;

/// Width and height of a plot that takes half the page, and of a square one that takes a third, px.
const WIDE: (u32, u32) = (560, 300);
const SQUARE: (u32, u32) = (400, 400);
const LINE: RGBColor = RGBColor(33, 102, 172);

type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// The error after each step of an iterative stage, as an SVG picture; empty without steps. `first`
/// is the number of the first entry: 0 where it is the error before any step.
pub fn convergence(title: &str, y_label: &str, history: &[f64], first: usize) -> String {
    let finite: Vec<(f64, f64)> = history
        .iter()
        .enumerate()
        .filter(|(_, e)| e.is_finite())
        .map(|(i, e)| ((i + first) as f64, *e))
        .collect();
    if finite.is_empty() {
        return String::new();
    }
    // on an axis from zero, a decrease of a few per cent would look like a flat line
    let (low, high) = finite.iter().fold((f64::MAX, f64::MIN), |m, p| (m.0.min(p.1), m.1.max(p.1)));
    let bottom = if low > 0.5 * high { low - 0.25 * (high - low) } else { 0.0f64.min(low) };
    let top = high + 0.06 * (high - bottom) + 1e-9 * high.abs() + 1e-12;
    let (start, last) = (first as f64, finite.last().map_or(1.0, |p| p.0));
    svg(SQUARE, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 17))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(64)
            .build_cartesian_2d(start..last.max(start + 1.0), bottom..top)?;
        chart
            .configure_mesh()
            .x_desc("step")
            .y_desc(y_label)
            .label_style(("sans-serif", 13))
            .x_labels((last as usize + 1 - first).clamp(2, 12))
            .x_label_formatter(&|v| format!("{v:.0}"))
            .light_line_style(WHITE)
            .draw()?;
        chart.draw_series(LineSeries::new(finite.iter().copied(), LINE.stroke_width(2)))?;
        chart.draw_series(finite.iter().map(|p| Circle::new(*p, 2, LINE.filled())))?;
        Ok(())
    })
}

/// How often values occur, in `bins` equal bins, as an SVG picture; empty without values.
pub fn histogram(title: &str, x_label: &str, values: &[f64], bins: usize) -> String {
    let finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let low = finite.iter().copied().fold(f64::INFINITY, f64::min);
    let high = finite.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // bins of whole numbers have a whole width: otherwise every few bins one would be empty
    let whole = finite.iter().all(|v| v.fract() == 0.0 && v.abs() < 1e9);
    let step = ((high - low + 1.0) / bins as f64).ceil();
    let (low, bins) =
        if whole { (low - 0.5, ((high - low + 1.0) / step).ceil() as usize) } else { (low, bins) };
    if finite.is_empty() || bins == 0 {
        return String::new();
    }
    let width = if whole { step } else { ((high - low) / bins as f64).max(1e-9) };
    let mut counts = vec![0u32; bins];
    for v in &finite {
        counts[(((v - low) / width) as usize).min(bins - 1)] += 1;
    }
    let top = counts.iter().copied().max().unwrap_or(1).max(1);
    svg(WIDE, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 17))
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(60)
            .build_cartesian_2d(low..low + width * bins as f64, 0u32..top + top / 20 + 1)?;
        chart
            .configure_mesh()
            .x_desc(x_label)
            .y_desc("count")
            .label_style(("sans-serif", 13))
            .disable_x_mesh()
            .light_line_style(WHITE)
            .draw()?;
        chart.draw_series(counts.iter().enumerate().map(|(i, &count)| {
            let left = low + width * i as f64;
            let mut bar =
                Rectangle::new([(left, 0), (left + width, count)], LINE.mix(0.75).filled());
            bar.set_margin(0, 0, 1, 1);
            bar
        }))?;
        Ok(())
    })
}

fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, plotters::coord::Shift>) -> Drawn,
) -> String {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        // Drawing into a string cannot fail except for a chart without space; then there is no plot.
        if area.fill(&WHITE).is_err() || draw(&area).is_err() || area.present().is_err() {
            return String::new();
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plots_are_svg_and_survive_odd_numbers() {
        let plot = convergence("ICP", "error, mm", &[3.0, 2.0, f64::NAN, 1.5], 0);
        assert!(plot.starts_with("<svg") && plot.matches("<circle").count() == 3, "{plot}");
        assert!(convergence("ICP", "mm", &[], 1).is_empty());
        let bars = histogram("Disparity", "px", &[1.0, 2.0, 2.1, 9.0, f64::INFINITY], 8);
        assert!(bars.matches("<rect").count() >= 8);
        assert!(histogram("One", "px", &[4.0], 8).starts_with("<svg"));
    }
}
