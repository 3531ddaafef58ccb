//! Plots as SVG (the thesis used JFreeChart, section 6.1).

use plotters::prelude::*;

const SIZE: (u32, u32) = (640, 320);
const LINE: RGBColor = RGBColor(33, 102, 172);

type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// The error after each step of an iterative stage, as an SVG picture; empty without steps.
pub fn convergence(title: &str, y_label: &str, history: &[f64]) -> String {
    let finite: Vec<(f64, f64)> = history
        .iter()
        .enumerate()
        .filter(|(_, e)| e.is_finite())
        .map(|(i, e)| ((i + 1) as f64, *e))
        .collect();
    if finite.is_empty() {
        return String::new();
    }
    let top = finite.iter().fold(0.0f64, |m, p| m.max(p.1)) * 1.05 + 1e-12;
    let last = finite.iter().fold(1.0f64, |m, p| m.max(p.0));
    svg(|area| {
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(60)
            .build_cartesian_2d(1.0..last.max(2.0), 0.0..top)?;
        chart.configure_mesh().x_desc("step").y_desc(y_label).light_line_style(WHITE).draw()?;
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
    if finite.is_empty() || bins == 0 {
        return String::new();
    }
    let width = ((high - low) / bins as f64).max(1e-9);
    let mut counts = vec![0u32; bins];
    for v in &finite {
        counts[(((v - low) / width) as usize).min(bins - 1)] += 1;
    }
    let top = counts.iter().copied().max().unwrap_or(1).max(1);
    svg(|area| {
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(60)
            .build_cartesian_2d(low..low + width * bins as f64, 0u32..top + top / 20 + 1)?;
        chart
            .configure_mesh()
            .x_desc(x_label)
            .y_desc("count")
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

fn svg(draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, plotters::coord::Shift>) -> Drawn) -> String {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        // Drawing into a string cannot fail but for a chart without room, which has no picture.
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
        let plot = convergence("ICP", "error, mm", &[3.0, 2.0, f64::NAN, 1.5]);
        assert!(plot.starts_with("<svg") && plot.matches("<circle").count() == 3, "{plot}");
        assert!(convergence("ICP", "mm", &[]).is_empty());
        let bars = histogram("Disparity", "px", &[1.0, 2.0, 2.1, 9.0, f64::INFINITY], 8);
        assert!(bars.matches("<rect").count() >= 8);
        assert!(histogram("One", "px", &[4.0], 8).starts_with("<svg"));
    }
}
