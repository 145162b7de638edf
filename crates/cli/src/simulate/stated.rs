//! Bead width and layer height of a program, from its comments or from what it extrudes.

use anyhow::bail;
use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_gcode::{Event, Feature, Filament, Program};
use beadwork_thermal::program::{bead_lengths, layer_heights};

/// Names of the bead width in comments, the more general ones first.
/// They are those of PrusaSlicer, Slic3r, Bambu Studio, Orca Slicer, `KISSlicer` and Simplify3D,
/// and of the table that PrusaSlicer writes into the header.
const WIDTHS: [&str; 8] = [
    "extrusion_width",
    "line_width",
    "extrusion_width_mm",
    "extruderwidth",
    "inner_wall_line_width",
    "perimeter_extrusion_width",
    "perimeters extrusion width",
    "outer_wall_line_width",
];

/// Names of the layer height in comments.
/// PrusaSlicer, Slic3r, Bambu Studio and Orca Slicer, Cura, `KISSlicer`, and Simplify3D.
const HEIGHTS: [&str; 4] = ["layer_height", "layer height", "layer_thickness_mm", "layerheight"];

/// Difference below which two layer heights are one, relative to them.
const SAME_HEIGHT: f64 = 0.05;

/// Share of the beads that must lie in layers of the stated height.
const STATED_SHARE: f64 = 0.1;

/// Maximum height of a bead in widths.
const ASPECT: f64 = 0.85;

/// Widths of beads that can be printed, in mm.
const PRINTABLE_MM: std::ops::RangeInclusive<f64> = 0.05..=5.0;

/// The number of millimetres that a comment states for a name: `name = 0.2`, `name: 0.2 mm` or
/// `name,0.2`.
/// `None` for other comments, and for per cent and 0, which mean that the slicer chooses.
fn number_of(comment: &str, name: &str) -> Option<f64> {
    let (key, value) = comment.split_once(['=', ':', ','])?;
    if !key.trim().eq_ignore_ascii_case(name) {
        return None;
    }
    // `LAYER_HEIGHT: 0.3` is that of a single layer (Bambu Studio).
    if name.contains('_') && !comment.contains('=') {
        return None;
    }
    // A list has one value per tool.
    let value = value.split([',', ';', '(']).next()?.trim();
    let number = value.strip_suffix("mm").unwrap_or(value).trim_end();
    number.parse().ok().filter(|&mm: &f64| mm > 0.0 && mm.is_finite())
}

/// The first number in the comments for one of these names.
fn stated(program: &Program, names: &[&str]) -> Option<f64> {
    let comments = || program.lines.iter().filter_map(|line| line.comment());
    names.iter().find_map(|name| comments().find_map(|comment| number_of(comment, name)))
}

/// Bead width and layer height that the comments of a program state, in mm.
pub(super) fn stated_mm(program: &Program) -> [Option<f64>; 2] {
    [stated(program, &WIDTHS), stated(program, &HEIGHTS)]
}

/// Bead width and layer height of the voxels for a program, in mm.
/// Reports on stderr what the comments do not state, or state wrongly.
pub(super) fn voxel_mm(program: &Program) -> anyhow::Result<[f64; 2]> {
    let [width, height] = stated_mm(program);
    let heights = control::quiet(Threads::One, |control| layer_heights(program, control))?;
    let heights = match heights {
        Ok(heights) => heights,
        Err(error) => bail!(error),
    };
    // A bead is not much higher than wide: a larger step in z has supports below it.
    let max_mm = ASPECT * width.unwrap_or(f64::INFINITY);
    let common = heights.iter().find(|(mm, _)| *mm <= max_mm);
    let height = match (height, common) {
        (Some(stated), Some(&(common, share))) => {
            let same = |&&(mm, _): &&(f64, f64)| (mm - stated).abs() <= SAME_HEIGHT * stated;
            let of_stated: f64 = heights.iter().filter(same).map(|(_, share)| share).sum();
            if of_stated < STATED_SHARE && share > 0.5 {
                eprintln!(
                    "beadwork: comments state layers of {stated} mm, most beads are printed in \
                     layers of {common} mm; simulated in voxels {common} mm high"
                );
                common
            } else {
                stated
            }
        }
        (Some(stated), None) => stated,
        (None, Some(&(common, _))) => {
            eprintln!(
                "beadwork: comments state no layer height; most beads are printed in layers of \
                 {common} mm"
            );
            common
        }
        (None, None) => bail!("no bead width and layer height in the comments: name the part, too"),
    };
    let width = if let Some(width) = width {
        width
    } else {
        let mean_mm: f64 = heights.iter().map(|(mm, share)| mm * share).sum();
        measured_width(program, mean_mm)?
    };
    Ok([width, height])
}

/// The bead width of a program whose comments do not state one: that of most beads according to
/// `;WIDTH:` comments, or the mean by the extruded volume.
/// `height_mm` is the mean height of the beads.
fn measured_width(program: &Program, height_mm: f64) -> anyhow::Result<f64> {
    let mut widths: Vec<(f64, f64)> = Vec::new();
    let mut marks = (1..).zip(&program.lines).filter_map(|(number, line)| {
        let comment = line.comment()?.trim_start();
        let width = number_of(comment.strip_prefix("LINE_").unwrap_or(comment), "WIDTH")?;
        // Slicers write widths such as 0.449999.
        Some((number, (width * 1e3).round() / 1e3))
    });
    let mut next = marks.next();
    let mut width = None;
    for event in program.trace() {
        let Event::Motion(motion) = event? else { continue };
        while let Some((_, mm)) = next.filter(|&(line, _)| line <= motion.line) {
            width = Some(mm);
            next = marks.next();
        }
        let not_part = [Feature::PrimeTower, Feature::Skirt, Feature::Support, Feature::Custom];
        if !motion.is_extrusion() || not_part.contains(&motion.feature) {
            continue;
        }
        if let Some(width) = width {
            let known = widths.iter().position(|(other, _)| (other - width).abs() < 1e-6);
            match known {
                Some(at) => widths[at].1 += motion.length_mm(),
                None if widths.len() < MAX_WIDTHS => widths.push((width, motion.length_mm())),
                None => {}
            }
        }
    }
    if let Some(&(width, _)) = widths.iter().max_by(|a, b| a.1.total_cmp(&b.1)) {
        eprintln!("beadwork: comments state no common bead width; most beads are {width} mm wide");
        return Ok(width);
    }
    let diameter = stated(program, &["filament_diameter", "filamentdiameters"]);
    let filament = Filament { diameter_mm: diameter.unwrap_or(1.75), density_g_cm3: 1.0 };
    let [extruded_mm, length_mm] =
        control::quiet(Threads::One, |control| bead_lengths(program, control))??;
    let width = extruded_mm * filament.area_mm2() / (length_mm * height_mm);
    // To hundredths of a millimetre.
    let width = (width * 100.0).round() / 100.0;
    if !PRINTABLE_MM.contains(&width) {
        bail!("no bead width and layer height in the comments: name the part, too");
    }
    eprintln!(
        "beadwork: comments state no bead width; {width} mm follows from the extruded volume of \
         {} mm filament",
        filament.diameter_mm
    );
    Ok(width)
}

/// Maximum number of widths that are kept apart; variable-width walls have thousands.
const MAX_WIDTHS: usize = 1 << 10;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_and_heights_of_many_slicers() {
        for (comments, width, height) in [
            ("; extrusion_width = 0.45\n; layer_height = 0.2", Some(0.45), Some(0.2)),
            (
                "; extrusion_width = 0\n; layer_height = 0.2\n; line_width = 0.42",
                Some(0.42),
                Some(0.2),
            ),
            ("; extrusion_width = 105%\n; layer_height = 0.15", None, Some(0.15)),
            (";Layer height: 0.16\n", None, Some(0.16)),
            (";   extruderWidth,0.48\n;   layerHeight,0.2\n", Some(0.48), Some(0.2)),
            ("; extrusion_width_mm = 0.4\n; layer_thickness_mm = 0.1", Some(0.4), Some(0.1)),
            ("; perimeters extrusion width = 0.45mm (2.7mm^3/s)", Some(0.45), None),
            ("; line_width = 0.42,0.42", Some(0.42), None),
            ("; LAYER_HEIGHT: 0.3\n; layer_height = 0.2", None, Some(0.2)),
            ("; initial_layer_height = 0.3\n; first_layer_height = 0.3", None, None),
            ("; extrusion_width = nan\n; layer_height = -1", None, None),
        ] {
            assert_eq!(stated_mm(&comments.parse().unwrap()), [width, height], "{comments}");
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "sizes are rounded decimals")]
    fn missing_sizes_are_measured() {
        let beads = "M83\nG1 Z0.3 F6000\nG1 X50 E3\nG1 Z0.5\nG1 X0 E2\nG1 Z0.7\nG1 X50 E2\n";
        let program = |text: &str| text.parse::<Program>().unwrap();
        // 2 mm of filament are 4.81 mm³; the first layer is thicker.
        assert_eq!(voxel_mm(&program(beads)).unwrap(), [0.48, 0.2]);
        let marked = format!(";WIDTH:0.4\n{beads};WIDTH:0.5\n");
        assert_eq!(voxel_mm(&program(&marked)).unwrap(), [0.4, 0.2]);
        let wrong = format!("; layer_height = 0.1\n; extrusion_width = 0.5\n{beads}");
        assert_eq!(voxel_mm(&program(&wrong)).unwrap(), [0.5, 0.2]);
        assert!(voxel_mm(&program("G1 X1 F600\n")).is_err());
    }
}
