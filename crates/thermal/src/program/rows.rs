//! Which rows of voxels a bead fills, by its height.
//!
//! Voxels have one height, but programs print layers of several: a thicker first layer, or layers
//! that adapt to the slope of the surface.
//! If nearly all beads lie at multiples of the voxels' height, a bead fills the row below its
//! height.
//! Otherwise the grid is shifted so that its boundaries agree with those of as many layers as
//! possible, and a layer fills the rows whose centres lie within it: none, one or several.
//! Every row between the lowest and the highest layer belongs to one layer.

use beadwork_base::Control;
use beadwork_gcode::{Event, Motion, Program, TraceError};

use super::heights::{Height, Heights};

/// Deviation from a multiple of the voxels' height that still fits, in voxels.
const FITS: f64 = 0.1;

/// Share of beads that need not fit, such as a prime line.
const MISFITS: f64 = 0.01;

/// Share of sloped beads above which a program prints a spiral.
const SLOPED: f64 = 0.1;

/// Parts into which a layer is divided to find the shift of the grid.
const BINS: usize = 50;

/// Maximum height of a bead in widths.
const ASPECT: f64 = 0.85;

/// Tolerance for rounded coordinates, in voxels.
const ROUNDING: f64 = 1e-6;

/// How well the layers of a program fit rows of voxels of one height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerFit {
    /// Number of the program's layers.
    pub layers: usize,
    /// Number of rows of voxels.
    pub rows: usize,
    /// Height of the program's layers together, in mm.
    pub height_mm: f64,
    /// Height of the rows together, in mm.
    pub rows_mm: f64,
    /// Maximum distance between the top of a layer and that of its rows, in mm.
    pub max_deviation_mm: f64,
    /// Volume of the beads in the rows relative to their volume in the program, minus 1.
    pub volume_error: f64,
    /// Number of layers so thin that they fill no row.
    pub layers_without_row: usize,
}

/// The rows of voxels that beads fill.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    heights: Heights,
    layer_mm: f64,
    /// Height of the raft below the part, mm; 0 without one.
    raft_mm: f64,
    /// Height of the lower side of the first row, in mm: not 0 for a spiral on layers that do not
    /// lie at multiples of the voxels' height.
    bottom_mm: f64,
    /// The layers from the bed up; empty if rows follow from the height alone.
    layers: Vec<Layer>,
}

/// A layer that fills some rows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layer {
    /// Height of its top, mm.
    top_mm: f64,
    thickness_mm: f64,
    /// Length of its beads, mm.
    length_mm: f64,
    /// Its first row, and the row after its last.
    rows: [i64; 2],
}

impl Rows {
    /// Assigns rows of voxels of the given width and height to the heights of a program.
    pub(super) fn of_program(
        program: &Program,
        cell_mm: f64,
        layer_mm: f64,
        control: &Control<'_>,
    ) -> Result<Self, TraceError> {
        Ok(Self::new(Heights::of(program, control)?, cell_mm, layer_mm))
    }

    fn new(heights: Heights, cell_mm: f64, layer_mm: f64) -> Self {
        let mut heights = heights;
        let raft_mm = raft_mm(&heights, cell_mm, layer_mm);
        for height in &mut heights.level {
            height.z_mm -= raft_mm;
        }
        heights.top_mm -= raft_mm;
        let total: f64 = heights.level.iter().map(|height| height.length_mm).sum();
        let is_spiral = heights.sloped_mm > SLOPED * (total + heights.sloped_mm);
        let is_uniform = is_uniform(&heights.level, cell_mm, layer_mm);
        let bottom_mm =
            if is_spiral && !is_uniform { shift(&heights.level, layer_mm) } else { 0.0 };
        let layers = if is_spiral || is_uniform {
            Vec::new()
        } else {
            layers(&heights.level, cell_mm, layer_mm)
        };
        Self { heights, layer_mm, raft_mm, bottom_mm, layers }
    }

    /// Whether a motion is a bead of the part.
    pub(super) fn is_part(&self, motion: &Motion) -> bool {
        self.heights.is_part(motion)
    }

    /// The first row that a motion fills if it is a bead, and the row after the last.
    pub(super) fn of(&self, motion: &Motion) -> [i64; 2] {
        self.at(f64::midpoint(motion.from_mm[2], motion.to_mm[2]))
    }

    /// As [`Rows::of`], for a height above the bed.
    fn at(&self, z_mm: f64) -> [i64; 2] {
        self.above_raft(z_mm - self.raft_mm)
    }

    /// As [`Rows::at`], for a height above the raft.
    fn above_raft(&self, z_mm: f64) -> [i64; 2] {
        if self.layers.is_empty() {
            let row = ((z_mm - self.bottom_mm) / self.layer_mm - 1.0).round() as i64;
            return [row, row.saturating_add(1)];
        }
        let above = self.layers.partition_point(|layer| layer.top_mm < z_mm);
        let near = [above.saturating_sub(1), above.min(self.layers.len() - 1)];
        let distance = |index: usize| (self.layers[index].top_mm - z_mm).abs();
        let nearest = if distance(near[0]) < distance(near[1]) { near[0] } else { near[1] };
        self.layers[nearest].rows
    }

    /// How the layers fit; `None` if all lie at multiples of the voxels' height.
    pub(super) fn fit(&self) -> Option<LayerFit> {
        let rows_mm = |rows: i64| rows as f64 * self.layer_mm;
        let Some(last) = self.layers.last() else { return self.spiral_fit() };
        let deviation = |layer: &Layer| (layer.top_mm - rows_mm(layer.rows[1])).abs();
        let of_all = |measure: &dyn Fn(&Layer) -> f64| self.layers.iter().map(measure).sum::<f64>();
        let printed = of_all(&|layer| layer.length_mm * layer.thickness_mm);
        let filled = of_all(&|layer| layer.length_mm * rows_mm(layer.rows[1] - layer.rows[0]));
        Some(LayerFit {
            layers: self.layers.len(),
            rows: last.rows[1].max(0) as usize,
            height_mm: last.top_mm,
            rows_mm: rows_mm(last.rows[1]),
            max_deviation_mm: self.layers.iter().map(deviation).fold(0.0, f64::max),
            volume_error: if printed > 0.0 { filled / printed - 1.0 } else { 0.0 },
            layers_without_row: self.layers.iter().filter(|at| at.rows[0] >= at.rows[1]).count(),
        })
    }

    /// How a spiral fits if the first row does not begin at the bed.
    fn spiral_fit(&self) -> Option<LayerFit> {
        let height_mm = self.heights.top_mm;
        let [_, rows] = self.above_raft(height_mm);
        let rows_mm = rows as f64 * self.layer_mm;
        (self.bottom_mm != 0.0 && rows > 0).then_some(LayerFit {
            layers: rows as usize,
            rows: rows as usize,
            height_mm,
            rows_mm,
            max_deviation_mm: self.bottom_mm.abs(),
            volume_error: rows_mm / height_mm - 1.0,
            layers_without_row: 0,
        })
    }

    /// Length of the beads before or below the first layer, in mm, which are left out.
    pub(super) fn left_out_mm(&self) -> f64 {
        let below = |height: &&Height| self.above_raft(height.z_mm)[1] < 1;
        let low_mm: f64 =
            self.heights.level.iter().filter(below).map(|height| height.length_mm).sum();
        self.heights.prime_mm + self.heights.below_bed_mm + low_mm
    }
}

/// Height of the raft, or of the supports, on which the whole part stands, in mm; 0 without one.
fn raft_mm(heights: &Heights, cell_mm: f64, layer_mm: f64) -> f64 {
    let lowest_mm = heights.level.first().map_or(0.0, |height| height.z_mm);
    let has_gap = lowest_mm > (ASPECT * cell_mm).max(1.5 * layer_mm);
    let has_support = heights.support_mm < lowest_mm - layer_mm / 2.0;
    if has_gap && has_support { lowest_mm - layer_mm } else { 0.0 }
}

/// Whether nearly all beads lie at multiples of the voxels' height, with no thick layer among them.
fn is_uniform(heights: &[Height], cell_mm: f64, layer_mm: f64) -> bool {
    let total: f64 = heights.iter().map(|height| height.length_mm).sum();
    let misfit = |height: &&Height| {
        let rows = height.z_mm / layer_mm;
        (rows - rows.round()).abs() > FITS || rows < 0.5
    };
    let misfits: f64 = heights.iter().filter(misfit).map(|height| height.length_mm).sum();
    if misfits > MISFITS * total {
        return false;
    }
    let mut below = 0.0;
    let tops = heights.iter().filter(|height| !misfit(height)).map(|height| height.z_mm);
    !tops.into_iter().any(|top_mm| {
        let thickness = top_mm - std::mem::replace(&mut below, top_mm);
        thickness > 1.5 * layer_mm && thickness <= ASPECT * cell_mm
    })
}

/// The layers between the heights, and the rows whose centres they contain.
fn layers(heights: &[Height], cell_mm: f64, layer_mm: f64) -> Vec<Layer> {
    let shift = shift(heights, layer_mm);
    // The first row whose centre lies above a height.
    let row_above =
        |z_mm: f64| (((z_mm - shift) / layer_mm - 0.5 + ROUNDING).floor() as i64 + 1).max(0);
    let mut below = 0.0;
    let layer = |&Height { z_mm, length_mm, .. }: &Height| {
        let gap = z_mm - std::mem::replace(&mut below, z_mm);
        // No bead is higher than wide: in a larger gap there are supports.
        let thickness_mm =
            if gap > (ASPECT * cell_mm).max(1.5 * layer_mm) { layer_mm } else { gap };
        let rows = [row_above(z_mm - thickness_mm), row_above(z_mm)];
        Layer { top_mm: z_mm, thickness_mm, length_mm, rows }
    };
    heights.iter().map(layer).collect()
}

/// Height of a boundary between rows, from more than -layer/2 to layer/2: the one with which most
/// tops of layers agree.
fn shift(heights: &[Height], layer_mm: f64) -> f64 {
    let remainder = |height: &Height| (height.z_mm / layer_mm + ROUNDING).rem_euclid(1.0);
    let bin = |height: &Height| ((remainder(height) * BINS as f64) as usize).min(BINS - 1);
    let mut counts = [0_usize; BINS];
    for height in heights {
        counts[bin(height)] += 1;
    }
    let votes = |at: usize| counts[(at + BINS - 1) % BINS] + counts[at] + counts[(at + 1) % BINS];
    // The lowest of several.
    let chosen = heights.iter().rev().max_by_key(|height| votes(bin(height)));
    let part = chosen.map_or(0.0, |height| (height.z_mm / layer_mm).rem_euclid(1.0));
    // In the middle, the grid begins above the bed: a row less rather than more.
    layer_mm * if part > 0.5 + ROUNDING { part - 1.0 } else { part }
}

/// How a program fits voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramFit {
    /// How its layers fit; `None` if all lie at multiples of the voxels' height.
    pub layers: Option<LayerFit>,
    /// Length of the beads before or below the first layer, such as a prime line, which are left
    /// out, in mm.
    pub left_out_mm: f64,
    /// Height of the raft or of the supports on which the whole part stands, in mm; 0 without one.
    /// The voxels begin above it.
    pub raft_mm: f64,
}

/// Finds out how a program fits voxels of a width and a height, both in mm.
///
/// Linear in the program's length; reports no progress.
pub fn program_fit(
    program: &Program,
    cell_mm: f64,
    layer_mm: f64,
    control: &Control<'_>,
) -> Result<ProgramFit, TraceError> {
    let rows = Rows::of_program(program, cell_mm, layer_mm, control)?;
    Ok(ProgramFit { layers: rows.fit(), left_out_mm: rows.left_out_mm(), raft_mm: rows.raft_mm })
}

/// Heights of the layers of a program in mm, each with its share of the length of all beads, the
/// most common one first.
///
/// Empty if no bead is level.
/// Linear in the program's length; reports no progress.
pub fn layer_heights(
    program: &Program,
    control: &Control<'_>,
) -> Result<Vec<(f64, f64)>, TraceError> {
    /// Coordinates are rounded to micrometres, so their differences are two micrometres off.
    const SAME_UM: i64 = 2;
    let Heights { level: heights, support_mm, .. } = Heights::of(program, control)?;
    let total: f64 = heights.iter().map(|height| height.length_mm).sum();
    // The lowest layer may lie on a raft; then it is taken to be as high as the second one.
    let mut below = match heights[..] {
        [first, second, ..] if support_mm < first.z_mm => (2.0 * first.z_mm - second.z_mm).max(0.0),
        _ => 0.0,
    };
    let mut found: Vec<(i64, f64)> = Vec::new();
    for height in &heights {
        let thickness = height.z_mm - std::mem::replace(&mut below, height.z_mm);
        found.push(((thickness * 1e3).round() as i64, height.length_mm / total));
    }
    // Heaviest first, so that each takes in its neighbours.
    found.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut merged: Vec<(i64, f64)> = Vec::new();
    for (height, share) in found {
        match merged.iter_mut().find(|(other, _)| (other - height).abs() <= SAME_UM) {
            Some((_, sum)) => *sum += share,
            None => merged.push((height, share)),
        }
    }
    merged.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(merged.into_iter().map(|(height, share)| (height as f64 / 1e3, share)).collect())
}

/// Length of the filament that the beads of the part take, and length of these beads, both in mm.
///
/// Linear in the program's length; reports no progress.
pub fn bead_lengths(program: &Program, control: &Control<'_>) -> Result<[f64; 2], TraceError> {
    let heights = Heights::of(program, control)?;
    let mut sums = [0.0; 2];
    for event in program.trace() {
        if let Event::Motion(motion) = event?
            && heights.is_part(&motion)
        {
            sums[0] += motion.extruded_mm;
            sums[1] += motion.length_mm();
        }
    }
    Ok(sums)
}

#[cfg(test)]
mod tests;
