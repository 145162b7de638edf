//! A planned layer, and its runs: the sections of its path that are printed with one tool.

use beadwork_grid::{Cell, Path, Region, Zones};

/// A layer with its path.
///
/// The layers of a print are numbered from the bed up without a gap, because each one rests on the
/// one below.
#[derive(Clone, Copy, Debug)]
pub struct Layer<'a> {
    /// Number of the layer, from 0 at the bed.
    pub number: usize,
    /// The cells.
    pub region: &'a Region,
    /// The zone of each cell, which is the number of the tool that prints it.
    pub zones: &'a Zones,
    /// The order in which the cells are printed; each piece of the path is one bead.
    pub path: &'a Path,
}

/// A maximal sequence of consecutive cells of a piece that have the same zone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run<'a> {
    pub(super) zone: u8,
    pub(super) cells: &'a [Cell],
    /// The cell of the piece before the run; `None` at the start of the piece.
    pub(super) before: Option<Cell>,
    /// The cell of the piece after the run; `None` at the end of the piece.
    pub(super) after: Option<Cell>,
}

impl<'a> Layer<'a> {
    /// The runs in printing order.
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
    pub(super) fn column_and_row(self, cell: Cell) -> [i32; 2] {
        let (x, y) = self.region.xy(cell);
        [x as i32, y as i32]
    }
}

impl Run<'_> {
    /// The corners of the run's toolpath; see [`toolpath`].
    pub(super) fn toolpath(&self, column_and_row: impl Fn(Cell) -> [i32; 2]) -> Vec<[i32; 2]> {
        toolpath(
            self.before.map(&column_and_row),
            self.cells.iter().map(|&cell| column_and_row(cell)),
            self.after.map(&column_and_row),
        )
    }
}

/// The corners of the polyline that the nozzle follows through adjacent cells.
///
/// The unit is half a cell: cell (0, 0) extends from 0 to 2 in x and y and has its centre at (1,
/// 1), so centres and edges of cells have integer coordinates.
///
/// The line enters the first cell at the middle of an edge, passes through the centres of all
/// cells, and leaves the last cell at the middle of an edge.
/// So each cell contributes half a cell before its centre and half a cell after it, and the line is
/// as many cells long as there are cells: constant flow deposits one cell's volume in each of them.
///
/// The cells `before` and `after` decide where the line begins and ends: if the tool changes
/// between two cells of a piece, both toolpaths meet at the edge between them.
/// Without such a neighbour the line continues straight to the opposite edge, and a single cell is
/// printed along x.
pub(super) fn toolpath(
    before: Option<[i32; 2]>,
    cells: impl Iterator<Item = [i32; 2]>,
    after: Option<[i32; 2]>,
) -> Vec<[i32; 2]> {
    let mut cells = cells.peekable();
    let mut corners = Vec::new();
    let mut last = before;
    // The direction of the step into the current cell, from the second cell on.
    let mut heading = None;
    while let Some(cell) = cells.next() {
        let next = cells.peek().copied().or(after);
        let step = |from: [i32; 2], to: [i32; 2]| [to[0] - from[0], to[1] - from[1]];
        let out = next.map(|next| step(cell, next));
        let enter = heading.or(last.map(|last| step(last, cell))).or(out).unwrap_or([1, 0]);
        let leave = out.unwrap_or(enter);
        let centre = [2 * cell[0] + 1, 2 * cell[1] + 1];
        if corners.is_empty() {
            corners.push([centre[0] - enter[0], centre[1] - enter[1]]);
        }
        // Straight stretches need no corner.
        if enter != leave {
            corners.push(centre);
        }
        if cells.peek().is_none() {
            corners.push([centre[0] + leave[0], centre[1] + leave[1]]);
        }
        last = Some(cell);
        heading = Some(leave);
    }
    corners
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
    fn toolpaths_reach_from_edge_to_edge() {
        let run = |before, cells: &[[i32; 2]], after| {
            let corners = toolpath(before, cells.iter().copied(), after);
            assert_eq!(length(&corners), 2 * cells.len() as u32);
            corners
        };
        assert_eq!(run(None, &[[0, 0]], None), [[0, 1], [2, 1]], "along x");
        assert_eq!(
            run(None, &[[3, 0], [2, 0], [1, 0]], None),
            [[8, 1], [2, 1]],
            "one straight line"
        );
        assert_eq!(run(None, &[[0, 0], [0, 1], [1, 1]], None), [[1, 0], [1, 3], [4, 3]]);
        assert_eq!(run(None, &[[0, 0]], Some([0, 1])), [[1, 0], [1, 2]], "towards the cell after");
        assert_eq!(run(Some([0, 0]), &[[0, 1]], None), [[1, 2], [1, 4]], "on from the cell before");
        assert_eq!(run(Some([0, 0]), &[[0, 1]], Some([1, 1])), [[1, 2], [1, 3], [2, 3]]);
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
