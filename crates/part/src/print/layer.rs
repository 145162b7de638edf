//! A planned layer, and the runs of one tool that it is printed in.

use beadwork_grid::{Cell, Path, Region, Zones};

use super::{Settings, SettingsError};
use crate::Frame;

/// A layer with its path.
/// A print has them from the bed up, none left out: each rests on the one below.
#[derive(Clone, Copy, Debug)]
pub struct Layer<'a> {
    /// Its number from 0, counted from the bed; [`Motion::layer`](super::Motion::layer) is the same
    /// number in a program that was read.
    pub number: usize,
    /// Its cells.
    pub region: &'a Region,
    /// Their zones: the numbers of the tools that print them.
    pub zones: &'a Zones,
    /// The order in which they are printed.
    pub path: &'a Path,
}

/// Consecutive cells of a piece that have the same zone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run<'a> {
    pub(super) zone: u8,
    pub(super) cells: &'a [Cell],
    /// The cells of the piece before and after it.
    pub(super) before: Option<Cell>,
    pub(super) after: Option<Cell>,
}

impl<'a> Layer<'a> {
    /// The runs in their order.
    pub(super) fn runs(self) -> impl Iterator<Item = Run<'a>> {
        self.path.iter_pieces().flat_map(move |piece| {
            let mut begin = 0;
            piece.chunk_by(move |&a, &b| self.zones.id(a) == self.zones.id(b)).map(move |cells| {
                let end = begin + cells.len();
                let before = begin.checked_sub(1).map(|at| piece[at]);
                begin = end;
                Run { zone: self.zones.id(cells[0]), cells, before, after: piece.get(end).copied() }
            })
        })
    }

    /// Column and row of a cell.
    pub(super) fn place(self, cell: Cell) -> [i32; 2] {
        let (x, y) = self.region.xy(cell);
        [x as i32, y as i32]
    }
}

impl Run<'_> {
    /// The corners of the run's stroke in halves of a cell, where (1, 1) is the middle of cell (0,
    /// 0): from edge to edge, so that it is as long as it has cells.
    /// A bead of a single cell runs along x.
    pub(super) fn corners(&self, place: impl Fn(Cell) -> [i32; 2]) -> Vec<[i32; 2]> {
        corners(
            self.before.map(&place),
            self.cells.iter().map(|&cell| place(cell)),
            self.after.map(&place),
        )
    }
}

/// The corners of a stroke through cells, in halves of a cell; the cells before and after it tell
/// where it comes from and goes to.
pub(super) fn corners(
    before: Option<[i32; 2]>,
    cells: impl Iterator<Item = [i32; 2]>,
    after: Option<[i32; 2]>,
) -> Vec<[i32; 2]> {
    let mut cells = cells.peekable();
    let mut corners = Vec::new();
    let mut last = before;
    let mut heading = None;
    while let Some(cell) = cells.next() {
        let next = cells.peek().copied().or(after);
        let step = |from: [i32; 2], to: [i32; 2]| [to[0] - from[0], to[1] - from[1]];
        let out = next.map(|next| step(cell, next));
        let come = heading.or(last.map(|last| step(last, cell))).or(out).unwrap_or([1, 0]);
        let go = out.unwrap_or(come);
        let middle = [2 * cell[0] + 1, 2 * cell[1] + 1];
        if corners.is_empty() {
            corners.push([middle[0] - come[0], middle[1] - come[1]]);
        }
        if come != go {
            corners.push(middle);
        }
        if cells.peek().is_none() {
            corners.push([middle[0] + go[0], middle[1] + go[1]]);
        }
        last = Some(cell);
        heading = Some(go);
    }
    corners
}

/// Checks that the layers fit each other, the frame and the tools.
pub(super) fn check(
    layers: &[Layer<'_>],
    frame: &Frame,
    settings: &Settings,
) -> Result<(), SettingsError> {
    if layers.is_empty() {
        return Err(SettingsError::NoLayers);
    }
    if let Some(pair) = layers.windows(2).find(|pair| pair[0].number >= pair[1].number) {
        return Err(SettingsError::LayerOrder { layer: pair[1].number, before: pair[0].number });
    }
    if let Some((layer, _)) =
        layers.iter().enumerate().find(|&(number, layer)| layer.number != number)
    {
        return Err(SettingsError::Gap { layer: layers[layer].number });
    }
    for layer in layers {
        let Layer { number, region, zones, path } = *layer;
        let odd = |what| Err(SettingsError::Layer { layer: number, what });
        if (region.width(), region.height()) != (frame.width, frame.height) {
            return odd("the plane of its region");
        }
        if zones.ids().len() != region.grid_len()
            || region.cells().any(|cell| zones.id(cell) == Zones::OUTSIDE)
        {
            return odd("the plane of its zones");
        }
        // A path visits no cell twice, so that these two say that it visits the region's.
        let visits = path.order().len() == region.cell_count() as usize
            && path.order().iter().all(|&cell| region.contains(cell));
        if !visits || path.width() != region.width() {
            return odd("the plane of its path");
        }
        let tools = settings.tools.len();
        let greatest = region.cells().map(|cell| zones.id(cell)).max();
        if let Some(zone) = greatest.filter(|&zone| usize::from(zone) >= tools) {
            return Err(SettingsError::TooFewTools { layer: number, zone, tools });
        }
    }
    check_place(layers[layers.len() - 1].number, frame, settings)
}

/// Rounding of places to the decimals of a file, in mm.
const ROUNDING_MM: f64 = 1e-6;

fn check_place(last: usize, frame: &Frame, settings: &Settings) -> Result<(), SettingsError> {
    let [bed_x, bed_y, bed_z] = settings.printer.bed_mm;
    let [left_mm, front_mm, right_mm, back_mm] = frame.sides_mm();
    if front_mm < -ROUNDING_MM || right_mm > bed_x + ROUNDING_MM || back_mm > bed_y + ROUNDING_MM {
        return Err(SettingsError::PartOutside { left_mm, front_mm, right_mm, back_mm });
    }
    let top_mm = frame.top_mm(last) + settings.process.z_hop_mm;
    if top_mm > bed_z + ROUNDING_MM {
        return Err(SettingsError::TooHigh { top_mm, limit_mm: bed_z });
    }
    let Some(tower) = settings.purge.as_ref().and_then(|purge| purge.tower) else { return Ok(()) };
    let (right, back) = (tower.left_mm + tower.width_mm, tower.front_mm + tower.depth_mm);
    if right > bed_x + ROUNDING_MM || back > bed_y + ROUNDING_MM {
        return Err(SettingsError::PrimeTowerOutside);
    }
    let apart = right <= left_mm + ROUNDING_MM
        || tower.left_mm >= right_mm - ROUNDING_MM
        || back <= front_mm + ROUNDING_MM
        || tower.front_mm >= back_mm - ROUNDING_MM;
    if apart { Ok(()) } else { Err(SettingsError::PrimeTowerOverlaps) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(corners: &[[i32; 2]]) -> u32 {
        corners
            .windows(2)
            .map(|pair| pair[0][0].abs_diff(pair[1][0]) + pair[0][1].abs_diff(pair[1][1]))
            .sum()
    }

    #[test]
    fn strokes_reach_from_edge_to_edge() {
        let stroke = |before, cells: &[[i32; 2]], after| {
            let corners = corners(before, cells.iter().copied(), after);
            assert_eq!(length(&corners), 2 * cells.len() as u32);
            corners
        };
        assert_eq!(stroke(None, &[[0, 0]], None), [[0, 1], [2, 1]], "along x");
        assert_eq!(
            stroke(None, &[[3, 0], [2, 0], [1, 0]], None),
            [[8, 1], [2, 1]],
            "one straight line"
        );
        assert_eq!(stroke(None, &[[0, 0], [0, 1], [1, 1]], None), [[1, 0], [1, 3], [4, 3]]);
        assert_eq!(stroke(None, &[[0, 0]], Some([0, 1])), [[1, 0], [1, 2]], "towards what follows");
        assert_eq!(
            stroke(Some([0, 0]), &[[0, 1]], None),
            [[1, 2], [1, 4]],
            "on from what was before"
        );
        assert_eq!(stroke(Some([0, 0]), &[[0, 1]], Some([1, 1])), [[1, 2], [1, 3], [2, 3]]);
    }

    #[test]
    fn runs_know_their_neighbours() {
        let region = Region::rectangle(3, 2).unwrap();
        let zones = Zones::new(&region, vec![0, 0, 1, 1, 1, 1]).unwrap();
        let path = Path::in_pieces(&region, vec![0, 1, 2, 5, 3, 4]).unwrap();
        let layer = Layer { number: 0, region: &region, zones: &zones, path: &path };
        let runs: Vec<_> =
            layer.runs().map(|run| (run.zone, run.cells.to_vec(), run.before, run.after)).collect();
        let expected = [
            (0, vec![0, 1], None, Some(2)),
            (1, vec![2, 5], Some(1), None),
            (1, vec![3, 4], None, None),
        ];
        assert_eq!(runs, expected);
    }
}
