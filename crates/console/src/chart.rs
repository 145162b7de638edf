//! Line charts and heat maps as SVG, several in one picture.

use std::collections::HashSet;

use anyhow::anyhow;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

// Distinguishable with any colour vision, after Okabe and Ito.

/// Blue of the palette.
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
/// Orange of the palette.
pub const ORANGE: RGBColor = RGBColor(213, 94, 0);
/// Green of the palette.
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
/// Purple of the palette.
pub const PURPLE: RGBColor = RGBColor(170, 80, 140);
/// Grey of the palette, for reference lines.
pub const GREY: RGBColor = RGBColor(120, 120, 120);

/// An axis of a chart.
#[derive(Clone, Copy)]
pub struct Axis<'a> {
    /// Label, with the unit.
    pub label: &'a str,
    /// Whether the scale is logarithmic; all values must then be positive.
    pub logarithmic: bool,
    /// Values that the axis must include in addition to those of the series.
    pub shown: &'a [f64],
}

/// A line of a chart.
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Colour of the line.
    pub colour: RGBColor,
    /// Style of the line.
    pub style: LineStyle,
    /// Points `(x, y)`, in the order they are connected.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    fn shape_style(&self) -> ShapeStyle {
        match self.style {
            LineStyle::Thin => self.colour.mix(0.6).stroke_width(1),
            LineStyle::Plain | LineStyle::Dotted => self.colour.stroke_width(2),
        }
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum LineStyle {
    /// A line of normal width.
    Plain,
    /// A thin, pale line, for secondary data.
    Thin,
    /// A line with a dot at each point.
    Dotted,
}

/// A line chart.
pub struct Chart<'a> {
    /// Title above the chart.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis<'a>,
    /// Vertical axis.
    pub y: Axis<'a>,
    /// The lines.
    pub series: Vec<Series>,
}

/// Draws charts row by row, each `width` x `height` pixels, with one legend below all of them.
///
/// Returns the text of the SVG.
pub fn charts(
    charts: &[Chart<'_>],
    columns: usize,
    (width, height): (u32, u32),
) -> anyhow::Result<String> {
    const LEGEND: u32 = 32;

    let columns = columns.min(charts.len()).max(1);
    let rows = charts.len().div_ceil(columns);
    let size = (width * columns as u32, height * rows as u32 + LEGEND);
    draw_svg(size, |area| {
        let (above, below) = area.split_vertically(height * rows as u32);
        for (chart, area) in charts.iter().zip(above.split_evenly((rows, columns))) {
            chart.draw(&area)?;
        }
        legend(&below, charts)
    })
}

impl Chart<'_> {
    fn draw(&self, area: &Area<'_>) -> anyhow::Result<()> {
        let values = |axis: Axis<'_>, value: fn(&(f64, f64)) -> f64| -> (f64, f64) {
            let points = self.series.iter().flat_map(|series| series.points.iter().map(value));
            let all = points.chain(axis.shown.iter().copied()).map(|value| axis.coordinate(value));
            let (low, high) =
                all.fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(at), high.max(at)));
            match (low < high, axis.logarithmic) {
                (true, true) => (low.floor(), high.ceil()),
                (true, false) => (low, high),
                // A single value, or none, spans no range.
                (false, _) if low.is_finite() && low < f64::MAX => (low - 0.5, low + 0.5),
                (false, _) => (0.0, 1.0),
            }
        };
        let ((left, right), (bottom, top)) =
            (values(self.x, |point| point.0), values(self.y, |point| point.1));
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 14).into_font().style(FontStyle::Bold))
            .margin(8)
            .margin_right(18)
            .x_label_area_size(38)
            .y_label_area_size(50)
            .build_cartesian_2d(left..right, bottom..top)
            .map_err(drawing_error)?;
        chart
            .configure_mesh()
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .x_labels(self.x.ticks(left, right))
            .y_labels(self.y.ticks(bottom, top))
            .x_label_formatter(&|at| self.x.tick_label(*at))
            .y_label_formatter(&|at| self.y.tick_label(*at))
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(222, 222, 232))
            .label_style(("sans-serif", 11))
            .axis_desc_style(("sans-serif", 12))
            .draw()
            .map_err(drawing_error)?;
        for series in &self.series {
            let points: Vec<(f64, f64)> = series
                .points
                .iter()
                .map(|&(x, y)| (self.x.coordinate(x), self.y.coordinate(y)))
                .collect();
            let dots = if series.style == LineStyle::Dotted { 3 } else { 0 };
            let line = LineSeries::new(points, series.shape_style()).point_size(dots);
            chart.draw_series(line).map_err(drawing_error)?;
        }
        Ok(())
    }
}

impl Axis<'_> {
    /// Position of a value in the linear coordinates of the chart.
    fn coordinate(self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    fn ticks(self, low: f64, high: f64) -> usize {
        if self.logarithmic { (high - low) as usize + 1 } else { 6 }
    }

    fn tick_label(self, at: f64) -> String {
        if !self.logarithmic {
            // Ticks are sums of steps: rounding removes their accumulated error.
            return format!("{}", (at * 1e6).round() / 1e6);
        }
        if (at - at.round()).abs() > 1e-6 {
            return String::new();
        }
        match at.round() as i32 {
            power @ -2..=4 => format!("{}", 10_f64.powi(power)),
            5 => "100,000".to_owned(),
            6 => "1,000,000".to_owned(),
            power => format!("1e{power}"),
        }
    }
}

/// Draws the names of all lines in one row; a name that several charts share appears once.
fn legend(area: &Area<'_>, charts: &[Chart<'_>]) -> anyhow::Result<()> {
    let mut left = 50;
    let mut seen = HashSet::new();
    let series = charts.iter().flat_map(|chart| &chart.series);
    for series in series.filter(|series| seen.insert(&series.name)) {
        let line = vec![(left, 12), (left + 26, 12)];
        area.draw(&PathElement::new(line, series.shape_style())).map_err(drawing_error)?;
        let style =
            ("sans-serif", 12).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(series.name.clone(), (left + 32, 12), style))
            .map_err(drawing_error)?;
        left += 60 + 7 * series.name.chars().count() as i32;
    }
    Ok(())
}

/// A heat map: a matrix of numbers shown as colours.
pub struct HeatMap {
    /// Title above the map.
    pub title: String,
    /// Names of the rows, from the top.
    pub rows: Vec<String>,
    /// Names of the columns, from the left.
    pub columns: Vec<String>,
    /// Values row by row; a cell that is not finite stays empty.
    pub values: Vec<f64>,
}

/// Draws heat maps, `columns` in a row, with one colour scale from 0 (light) to `max` (dark).
///
/// Returns the text of the SVG.
pub fn heat_maps(maps: &[HeatMap], columns: usize, max: f64) -> anyhow::Result<String> {
    const CELL: (i32, i32) = (62, 34);
    const LEFT: i32 = 84;
    const TOP: i32 = 54;
    const GAP: i32 = 20;

    let columns = columns.min(maps.len()).max(1);
    let rows = maps.len().div_ceil(columns);
    let largest = |count: fn(&HeatMap) -> usize| maps.iter().map(count).max().unwrap_or(0) as i32;
    let width = LEFT + CELL.0 * largest(|map| map.columns.len()) + GAP;
    let height = TOP + CELL.1 * largest(|map| map.rows.len()) + GAP;
    draw_svg((width as u32 * columns as u32, height as u32 * rows as u32), |area| {
        for (map, area) in maps.iter().zip(area.split_evenly((rows, columns))) {
            let text = |size: i32, across: HPos| {
                ("sans-serif", size).into_text_style(&area).pos(Pos::new(across, VPos::Center))
            };
            let title =
                ("sans-serif", 14).into_font().style(FontStyle::Bold).into_text_style(&area);
            area.draw(&Text::new(map.title.clone(), (LEFT, 6), title)).map_err(drawing_error)?;
            let offsets = |count: usize, from: i32, step: i32| {
                (0..count as i32).map(move |i| from + i * step)
            };
            for (name, x) in map.columns.iter().zip(offsets(map.columns.len(), LEFT, CELL.0)) {
                let at = (x + CELL.0 / 2, TOP - 14);
                area.draw(&Text::new(name.clone(), at, text(12, HPos::Center)))
                    .map_err(drawing_error)?;
            }
            for (row, (name, y)) in
                map.rows.iter().zip(offsets(map.rows.len(), TOP, CELL.1)).enumerate()
            {
                let at = (LEFT - 8, y + CELL.1 / 2);
                area.draw(&Text::new(name.clone(), at, text(12, HPos::Right)))
                    .map_err(drawing_error)?;
                let values = &map.values[row * map.columns.len()..][..map.columns.len()];
                let values = values.iter().zip(offsets(map.columns.len(), LEFT, CELL.0));
                for (&value, x) in values.filter(|(value, _)| value.is_finite()) {
                    let share = (value / max).clamp(0.0, 1.0);
                    let corners = [(x, y), (x + CELL.0 - 1, y + CELL.1 - 1)];
                    area.draw(&Rectangle::new(corners, shade(share).filled()))
                        .map_err(drawing_error)?;
                    let ink = if share > 0.55 { WHITE } else { BLACK };
                    let style = text(12, HPos::Center).color(&ink);
                    let at = (x + CELL.0 / 2, y + CELL.1 / 2);
                    area.draw(&Text::new(format!("{value:.1}"), at, style))
                        .map_err(drawing_error)?;
                }
            }
        }
        Ok(())
    })
}

/// Colour of a share from 0 to 1: from nearly white over green to dark blue, darker with every
/// step.
fn shade(share: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 4] =
        [[247.0, 252.0, 240.0], [168.0, 221.0, 181.0], [43.0, 140.0, 190.0], [8.0, 48.0, 107.0]];

    let at = share * (STOPS.len() - 1) as f64;
    let stop = (at as usize).min(STOPS.len() - 2);
    let between =
        |i: usize| STOPS[stop][i] + (STOPS[stop + 1][i] - STOPS[stop][i]) * (at - stop as f64);
    let [r, g, b] = [0, 1, 2].map(|i| between(i) as u8);
    RGBColor(r, g, b)
}

fn draw_svg(
    size: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> anyhow::Result<()>,
) -> anyhow::Result<String> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        area.fill(&WHITE).map_err(drawing_error)?;
        draw(&area)?;
        area.present().map_err(drawing_error)?;
    }
    Ok(svg)
}

/// Converts an error of plotters, which borrows the drawing area, to one that owns its text.
fn drawing_error(error: impl std::fmt::Display) -> anyhow::Error {
    anyhow!("cannot draw: {error}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shades_grow_darker() {
        let light = |share: f64| {
            let RGBColor(r, g, b) = shade(share);
            2 * u32::from(r) + 5 * u32::from(g) + u32::from(b)
        };
        assert!((0..100).all(|i| light(f64::from(i) / 100.0) >= light(f64::from(i + 1) / 100.0)));
    }

    #[test]
    fn nothing_to_draw_is_an_empty_picture() {
        let axis = Axis { label: "x", logarithmic: false, shown: &[] };
        let chart = Chart { title: "none".to_owned(), x: axis, y: axis, series: Vec::new() };
        assert!(charts(&[], 3, (300, 200)).unwrap().starts_with("<svg"));
        assert!(charts(&[chart], 3, (300, 200)).unwrap().contains("none"));
        assert!(heat_maps(&[], 2, 100.0).unwrap().starts_with("<svg"));
    }
}
