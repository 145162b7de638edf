//! Pictures of the temperatures on planes, as SVG and as PNG.

mod canvas;
mod scale;

use std::fmt::Write;

use beadwork_part::Frame;
use beadwork_thermal::section::{Plane, Section};
use png::{BitDepth, ColorType, Encoder};

use self::canvas::Canvas;
pub use self::scale::Scale;
use self::scale::{colour, ticks};

/// The temperatures of a plane of voxels, as seen from one side.
pub struct Map {
    title: String,
    /// Names of the axes to the right and upwards.
    axes: [&'static str; 2],
    /// Width and height of a voxel as seen, mm.
    voxel_mm: [f64; 2],
    size: [u32; 2],
    /// Temperatures in °C, row by row from the top; NaN where nothing is deposited.
    values: Vec<f32>,
}

impl Map {
    /// The map of a section of a part, as seen from the right, from the front, or from above.
    pub fn of(section: &Section, frame: &Frame, title: String) -> Self {
        let (axes, high_mm) = match section.plane {
            Plane::X(_) => (["y", "z"], frame.layer_mm),
            Plane::Y(_) => (["x", "z"], frame.layer_mm),
            Plane::Layer(_) => (["x", "y"], frame.cell_mm),
        };
        let (rows, columns) = section.temperatures_c.dim();
        let celsius =
            section.temperatures_c.iter().map(|&celsius| celsius as f32).collect::<Vec<f32>>();
        // Rows run from the back or from the bottom, columns from the left or from the back.
        let values = match section.plane {
            Plane::Layer(_) => celsius,
            Plane::X(_) => celsius.into_iter().rev().collect(),
            Plane::Y(_) => celsius.rchunks(columns.max(1)).flatten().copied().collect(),
        };
        let size = [columns as u32, rows as u32];
        Self { title, axes, voxel_mm: [frame.cell_mm, high_mm], size, values }
    }

    /// All temperatures of the map in °C, without NaN.
    pub fn celsius(&self) -> impl Iterator<Item = f32> {
        self.values.iter().copied().filter(|celsius| celsius.is_finite())
    }

    fn size_mm(&self) -> [f64; 2] {
        [0, 1].map(|axis| f64::from(self.size[axis]) * self.voxel_mm[axis])
    }

    /// One pixel per voxel; transparent where nothing is deposited.
    fn pixels(&self, scale: Scale) -> Vec<u8> {
        let pixel = |&celsius: &f32| {
            let [red, green, blue] =
                if celsius.is_finite() { scale.colour(celsius.into()) } else { [0; 3] };
            [red, green, blue, if celsius.is_finite() { u8::MAX } else { 0 }]
        };
        self.values.iter().flat_map(pixel).collect()
    }
}

/// Width of a drawing, in pixels.
pub const WIDTH: u32 = 1080;

/// Space for the colour scale beside the maps, in pixels.
const SCALE_WIDTH: f64 = 90.0;
const SCALE_HEIGHT: f64 = 170.0;

/// Space around a map for its title and axes, in pixels.
const LEFT: f64 = 46.0;
const TOP: f64 = 30.0;
const BELOW: f64 = 40.0;
const RIGHT: f64 = 14.0;

/// Height of a heading, in pixels.
const HEADING: f64 = 28.0;

/// Maximum height of a map, in pixels.
const MAX_HEIGHT: f64 = 640.0;

/// Maps side by side.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    /// Text above them.
    pub heading: Option<&'a str>,
    /// The maps, from left to right.
    pub maps: &'a [Map],
}

impl<'a> Row<'a> {
    /// Rows of up to `columns` maps, the first one below a heading.
    ///
    /// # Panics
    /// If `columns` is 0.
    pub fn under(
        heading: Option<&'a str>,
        maps: &'a [Map],
        columns: usize,
    ) -> impl Iterator<Item = Self> {
        let heading = move |number| heading.filter(|_| number == 0);
        maps.chunks(columns)
            .enumerate()
            .map(move |(number, maps)| Self { heading: heading(number), maps })
    }

    fn heading_height(&self) -> f64 {
        if self.heading.is_some() { HEADING } else { 0.0 }
    }
}

/// Draws rows of maps, with one colour scale beside them; returns the text of an SVG.
///
/// All maps are drawn to the same scale; a row is as high as its highest map.
pub fn svg(rows: &[Row<'_>], scale: Scale) -> String {
    let mut text = String::new();
    write(&mut text, rows, scale).expect("writing to a string succeeds");
    text
}

fn write(text: &mut String, rows: &[Row<'_>], scale: Scale) -> std::fmt::Result {
    let columns = rows.iter().map(|row| row.maps.len()).max().unwrap_or(0).max(1);
    let panel = (f64::from(WIDTH) - SCALE_WIDTH) / columns as f64;
    let sizes_mm = || rows.iter().flat_map(|row| row.maps).map(Map::size_mm);
    let max_mm = |axis: usize| sizes_mm().map(|size_mm| size_mm[axis]).fold(1e-9, f64::max);
    let per_mm = ((panel - LEFT - RIGHT) / max_mm(0)).min(MAX_HEIGHT / max_mm(1));
    let height = |row: &Row<'_>| {
        let max_mm = row.maps.iter().map(|map| map.size_mm()[1]).fold(0.0, f64::max);
        row.heading_height() + TOP + max_mm * per_mm + BELOW
    };
    let total = rows.iter().map(height).sum::<f64>().max(SCALE_HEIGHT + 70.0);
    writeln!(
        text,
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{total:.0}"
viewBox="0 0 {WIDTH} {total:.0}" font-family="sans-serif" font-size="12" fill="black">"#
    )?;
    writeln!(text, r#"<rect width="{WIDTH}" height="{total:.0}" fill="white"/>"#)?;
    let mut above = 0.0;
    for row in rows {
        if let Some(heading) = row.heading {
            writeln!(
                text,
                r#"<text x="14" y="{:.1}" font-size="16">{}</text>"#,
                above + 22.0,
                escaped(heading)
            )?;
        }
        for (column, map) in row.maps.iter().enumerate() {
            let corner = [column as f64 * panel + LEFT, above + row.heading_height() + TOP];
            panel_of(text, map, scale, corner, per_mm)?;
        }
        above += height(row);
    }
    let corner = [f64::from(WIDTH) - SCALE_WIDTH + 8.0, TOP + 14.0];
    scale_of(text, scale, corner)?;
    writeln!(text, "</svg>")
}

fn panel_of(
    text: &mut String,
    map: &Map,
    scale: Scale,
    [x, y]: [f64; 2],
    per_mm: f64,
) -> std::fmt::Result {
    let [wide, high] = map.size_mm().map(|mm| mm * per_mm);
    let title = escaped(&map.title);
    writeln!(
        text,
        r#"<text x="{x:.1}" y="{:.1}" font-size="13" font-weight="bold">{title}</text>"#,
        y - 10.0
    )?;
    let picture = base64(&encode(map.size, &map.pixels(scale)));
    writeln!(
        text,
        r#"<image x="{x:.1}" y="{y:.1}" width="{wide:.1}" height="{high:.1}"
preserveAspectRatio="none" image-rendering="optimizeSpeed" style="image-rendering:pixelated"
href="data:image/png;base64,{picture}"/>"#
    )?;
    writeln!(
        text,
        r##"<rect x="{x:.1}" y="{y:.1}" width="{wide:.1}" height="{high:.1}"
fill="none" stroke="#888"/>"##
    )?;
    let [wide_mm, high_mm] = map.size_mm();
    let [across, up] = map.axes;
    let (marks, decimals) = ticks(0.0, wide_mm, (wide / 60.0).clamp(1.0, 6.0));
    for mm in marks {
        let at = x + mm * per_mm;
        writeln!(
            text,
            r#"<text x="{at:.1}" y="{:.1}" font-size="11"
text-anchor="middle">{mm:.decimals$}</text>"#,
            y + high + 14.0
        )?;
    }
    let (marks, decimals) = ticks(0.0, high_mm, (high / 40.0).clamp(1.0, 6.0));
    for mm in marks {
        let at = y + high - mm * per_mm + 4.0;
        writeln!(
            text,
            r#"<text x="{:.1}" y="{at:.1}" font-size="11"
text-anchor="end">{mm:.decimals$}</text>"#,
            x - 5.0
        )?;
    }
    writeln!(
        text,
        r#"<text x="{:.1}" y="{:.1}" font-size="11" text-anchor="middle">{across}, mm</text>"#,
        x + wide / 2.0,
        y + high + 28.0
    )?;
    let (at_x, at_y) = (x - 32.0, y + high / 2.0);
    writeln!(
        text,
        r#"<text transform="translate({at_x:.1},{at_y:.1}) rotate(-90)" font-size="11"
text-anchor="middle">{up}, mm</text>"#
    )
}

fn scale_of(text: &mut String, scale: Scale, [x, y]: [f64; 2]) -> std::fmt::Result {
    const PARTS: u32 = 16;

    writeln!(text, r#"<defs><linearGradient id="heat" x1="0" y1="1" x2="0" y2="0">"#)?;
    for part in 0..=PARTS {
        let share = f64::from(part) / f64::from(PARTS);
        let [red, green, blue] = colour(share);
        writeln!(text, r#"<stop offset="{share}" stop-color="rgb({red},{green},{blue})"/>"#)?;
    }
    writeln!(text, "</linearGradient></defs>")?;
    writeln!(text, r#"<text x="{x:.1}" y="{:.1}">°C</text>"#, y - 10.0)?;
    writeln!(
        text,
        r##"<rect x="{x:.1}" y="{y:.1}" width="18" height="{SCALE_HEIGHT}"
fill="url(#heat)" stroke="#888"/>"##
    )?;
    for (label, share) in labels(scale) {
        let at = y + SCALE_HEIGHT * (1.0 - share);
        writeln!(
            text,
            r##"<path d="M{:.1} {at:.1}h5" stroke="#444"/><text x="{:.1}" y="{:.1}">{}</text>"##,
            x + 18.0,
            x + 27.0,
            at + 4.0,
            escaped(&label)
        )?;
    }
    Ok(())
}

/// Labels of the colour scale, and their positions on it, from 0 to 1.
fn labels(scale: Scale) -> Vec<(String, f64)> {
    let (marks, decimals) = scale.ticks();
    let share = |celsius: f64| (celsius - scale.low_c) / (scale.high_c - scale.low_c);
    let mut labels: Vec<_> = marks
        .into_iter()
        .map(|celsius| (format!("{celsius:.decimals$}"), share(celsius)))
        .collect();
    if scale.is_exceeded {
        labels.retain(|(_, share)| *share < 0.93);
        labels.push((format!("> {:.decimals$}", scale.high_c), 1.0));
    }
    labels
}

/// Approximate length of the longer side of a map in pixels.
const PIXELS: f64 = 900.0;

/// Minimum length of the colour scale in pixels.
const MIN_SCALE: usize = 150;

/// A map with its colour scale as a PNG picture, several pixels per voxel.
pub fn png(map: &Map, scale: Scale) -> Vec<u8> {
    const MARGIN: usize = 14;
    const GAP: usize = 18;
    const BAR: usize = 20;
    const LABEL: usize = 84;
    const HEADER: usize = 24;

    let [columns, rows] = map.size.map(|count| count as usize);
    let [wide_mm, high_mm] = map.size_mm();
    let per_mm = PIXELS / wide_mm.max(high_mm);
    // The shorter side of a voxel is rounded first: rounding both sides separately would distort
    // the part.
    let min_mm = map.voxel_mm[0].min(map.voxel_mm[1]);
    let min_pixels = (min_mm * per_mm).floor().max(1.0);
    let [zoom_x, zoom_y] = map.voxel_mm.map(|mm| (mm / min_mm * min_pixels).round() as usize);
    let (wide, high) = (columns * zoom_x, rows * zoom_y);
    let bar = high.clamp(MIN_SCALE, 2 * MIN_SCALE);
    let size = [MARGIN + wide + GAP + BAR + LABEL, 2 * MARGIN + high.max(HEADER + bar)];
    let mut canvas = Canvas::white(size);
    for (row, values) in map.values.chunks(columns.max(1)).enumerate() {
        for (column, &celsius) in
            values.iter().enumerate().filter(|(_, celsius)| celsius.is_finite())
        {
            let corner = [MARGIN + column * zoom_x, MARGIN + row * zoom_y];
            canvas.fill(corner, [zoom_x, zoom_y], scale.colour(celsius.into()));
        }
    }
    let left = MARGIN + wide + GAP;
    let top = MARGIN + HEADER;
    canvas.write([left, MARGIN], "°C");
    for line in 0..bar {
        let share = 1.0 - (line as f64 + 0.5) / bar as f64;
        canvas.fill([left, top + line], [BAR, 1], colour(share));
    }
    for (label, share) in labels(scale) {
        let at = top + ((1.0 - share) * (bar - 1) as f64) as usize;
        canvas.fill([left + BAR, at], [5, 1], [0; 3]);
        canvas.write([left + BAR + 9, at.saturating_sub(canvas::HEIGHT / 2)], &label);
    }
    encode(size.map(|side| side as u32), canvas.pixels())
}

fn encode([width, height]: [u32; 2], pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header().expect("writing to memory succeeds");
    writer.write_image_data(pixels).expect("the size is that of the pixels");
    writer.finish().expect("writing to memory succeeds");
    bytes
}

/// Text with the characters escaped that have a meaning in XML elements.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Base64 encoding (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let letter = char::from(LETTERS[(bits >> (18 - 6 * i) & 63) as usize]);
            text.push(if i <= chunk.len() { letter } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, array};

    use super::*;

    const FRAME: Frame =
        Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 30, height: 12 };

    fn map() -> Map {
        // Seen from the front, row 11 is the topmost.
        let celsius =
            |x: usize, y: usize| if x == y { f64::NAN } else { 80.0 + (x + 3 * y) as f64 };
        let temperatures_c = Array2::from_shape_fn((12, 30), |(row, x)| celsius(x, 11 - row));
        let section = Section { plane: Plane::Y(0), temperatures_c };
        Map::of(&section, &FRAME, "a < b".to_owned())
    }

    #[test]
    fn maps_are_seen_from_the_right_the_front_or_above() {
        let seen = |plane| {
            let section = Section { plane, temperatures_c: array![[1.0, 2.0], [3.0, 4.0]] };
            Map::of(&section, &FRAME, String::new()).values
        };
        assert_eq!(seen(Plane::X(0)), [4.0, 3.0, 2.0, 1.0]);
        assert_eq!(seen(Plane::Y(0)), [3.0, 4.0, 1.0, 2.0]);
        assert_eq!(seen(Plane::Layer(0)), [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn base64_as_in_its_definition() {
        for (bytes, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn voxels_become_blocks_of_pixels_and_the_rest_stays_white() {
        let map = map();
        let bytes = png(&map, Scale::of(map.celsius()));
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!(info.width, 14 + 30 * 30 + 18 + 20 + 84);
        let at = |x: usize, y: usize| &pixels[4 * (y * info.width as usize + x)..][..4];
        assert_eq!(at(14, 14), [255; 4], "nothing is deposited there");
        assert_eq!(at(14 + 30, 14), at(14 + 59, 14 + 14));
        assert_ne!(at(14 + 30, 14), at(14 + 60, 14));
    }

    #[test]
    fn drawings_are_whole() {
        let maps = [map(), map(), map()];
        let rows: Vec<Row<'_>> = Row::under(Some("a & b"), &maps, 2).collect();
        assert_eq!(rows.iter().map(|row| row.maps.len()).collect::<Vec<_>>(), [2, 1]);
        let text = svg(&rows, Scale::of(maps.iter().flat_map(Map::celsius)));
        assert!(text.starts_with("<svg") && text.ends_with("</svg>\n"));
        assert_eq!(text.matches("a &amp; b").count(), 1);
        assert!(text.contains("a &lt; b") && text.matches("<image").count() == 3);
        assert!(svg(&[], Scale::of([].into_iter())).ends_with("</svg>\n"));
    }

    #[test]
    fn rows_are_as_high_as_their_highest_map() {
        let flat = || Map { size: [30, 6], values: vec![80.0; 180], ..map() };
        let height = |maps: &[Map]| {
            let rows: Vec<Row<'_>> = Row::under(None, maps, 1).collect();
            let text = svg(&rows, Scale::of(maps.iter().flat_map(Map::celsius)));
            let (_, rest) = text.split_once(" height=\"").unwrap();
            rest.split_once('"').unwrap().0.parse::<f64>().unwrap()
        };
        let (high, low) = (height(&[map(), map()]), height(&[map(), flat()]));
        let per_mm = (f64::from(WIDTH) - SCALE_WIDTH - LEFT - RIGHT) / 15.0;
        assert!((high - low - 1.5 * per_mm).abs() < 1.0, "{high} {low}");
    }
}
