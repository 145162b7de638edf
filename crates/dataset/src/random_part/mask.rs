//! The filled cells of a layer, and the operations of image processing on them.

/// The filled cells of a layer, row by row.
/// Cells outside the grid are empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mask {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) cells: Vec<bool>,
}

/// A rectangle of cells, which may reach beyond the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rectangle {
    /// Column and row of the corner with the lowest numbers.
    pub(super) corner: [i64; 2],
    /// Width and height.
    pub(super) size: [i64; 2],
}

/// A set of offsets around a cell: for each row from the top, half the width of the row.
/// The row of half width h holds the offsets -h to h.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Kernel {
    half_widths: Vec<i64>,
}

/// Label of empty cells in [`Mask::components`].
const UNLABELLED: u32 = u32::MAX;

impl Mask {
    pub(super) fn empty(width: u32, height: u32) -> Self {
        let (width, height) = (width as usize, height as usize);
        Self { width, height, cells: vec![false; width * height] }
    }

    pub(super) fn is_empty(&self) -> bool {
        !self.cells.contains(&true)
    }

    /// Fills or empties the cells of a rectangle that lie on the grid.
    pub(super) fn set(&mut self, rectangle: Rectangle, filled: bool) {
        let clamp = |axis: usize, len: usize| {
            let low = rectangle.corner[axis].clamp(0, len as i64);
            let high = (rectangle.corner[axis] + rectangle.size[axis]).clamp(low, len as i64);
            low as usize..high as usize
        };
        let columns = clamp(0, self.width);
        for y in clamp(1, self.height) {
            self.cells[y * self.width..][columns.clone()].fill(filled);
        }
    }

    /// The neighbours of a cell that lie on the grid.
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> {
        let (width, len) = (self.width, self.cells.len());
        let x = cell % width;
        [
            (x > 0).then(|| cell - 1),
            (x + 1 < width).then(|| cell + 1),
            cell.checked_sub(width),
            (cell + width < len).then_some(cell + width),
        ]
        .into_iter()
        .flatten()
    }

    /// The empty cells beside filled ones, in ascending order.
    pub(super) fn beside(&self) -> Vec<usize> {
        let filled_beside = |cell: &usize| self.neighbours(*cell).any(|other| self.cells[other]);
        (0..self.cells.len()).filter(|&cell| !self.cells[cell]).filter(filled_beside).collect()
    }

    /// The empty cells that are connected to the space around the grid.
    pub(super) fn outside(&self) -> Self {
        let (width, height) = (self.width, self.height);
        let mut outside = Self { cells: vec![false; width * height], ..*self };
        let on_border = |cell: usize| {
            let (x, y) = (cell % width, cell / width);
            x == 0 || y == 0 || x + 1 == width || y + 1 == height
        };
        let mut open: Vec<_> =
            (0..width * height).filter(|&cell| on_border(cell) && !self.cells[cell]).collect();
        open.iter().for_each(|&cell| outside.cells[cell] = true);
        while let Some(cell) = open.pop() {
            for other in self.neighbours(cell) {
                if !self.cells[other] && !outside.cells[other] {
                    outside.cells[other] = true;
                    open.push(other);
                }
            }
        }
        outside
    }

    /// The filled cells beside the outside, in ascending order.
    pub(super) fn contour(&self) -> Vec<usize> {
        let outside = self.outside();
        let on_contour = |&cell: &usize| {
            let neighbours = self.neighbours(cell);
            let mut count = 0;
            let beside = neighbours.inspect(|_| count += 1).any(|other| outside.cells[other]);
            beside || count < 4
        };
        (0..self.cells.len()).filter(|&cell| self.cells[cell]).filter(on_contour).collect()
    }

    /// True if some empty cells are enclosed by filled ones.
    pub(super) fn has_hole(&self) -> bool {
        let outside = self.outside();
        self.cells.iter().zip(&outside.cells).any(|(&filled, &outside)| !filled && !outside)
    }

    /// Label of each cell's component, [`UNLABELLED`] for empty cells, and the cells per component.
    /// Components are numbered in the order of their lowest cells.
    fn components(&self) -> (Vec<u32>, Vec<usize>) {
        let mut labels = vec![UNLABELLED; self.cells.len()];
        let mut sizes = Vec::new();
        let mut open = Vec::new();
        for first in 0..self.cells.len() {
            if !self.cells[first] || labels[first] != UNLABELLED {
                continue;
            }
            let label = sizes.len() as u32;
            let mut size = 0;
            labels[first] = label;
            open.push(first);
            while let Some(cell) = open.pop() {
                size += 1;
                for other in self.neighbours(cell) {
                    if self.cells[other] && labels[other] == UNLABELLED {
                        labels[other] = label;
                        open.push(other);
                    }
                }
            }
            sizes.push(size);
        }
        (labels, sizes)
    }

    /// Number of components.
    pub(super) fn component_count(&self) -> usize {
        self.components().1.len()
    }

    /// Empties all components but those that overlap `below`, and of these all but the largest (the
    /// first of equals) if `only_largest`.
    pub(super) fn keep_supported(&mut self, below: &Self, only_largest: bool) {
        let (labels, sizes) = self.components();
        let mut kept = vec![false; sizes.len()];
        for (&label, &supported) in labels.iter().zip(&below.cells) {
            if supported && label != UNLABELLED {
                kept[label as usize] = true;
            }
        }
        if only_largest {
            let supported = (0..sizes.len()).filter(|&label| kept[label]);
            let largest = supported.min_by_key(|&label| std::cmp::Reverse(sizes[label]));
            kept = (0..sizes.len()).map(|label| Some(label) == largest).collect();
        }
        for (cell, label) in self.cells.iter_mut().zip(labels) {
            *cell = label != UNLABELLED && kept[label as usize];
        }
    }

    /// The union of all translates of the kernel that lie in the filled cells.
    /// Costs time proportional to the number of cells and the number of rows of the kernel.
    pub(super) fn opened(&self, kernel: &Kernel) -> Self {
        kernel.dilated(&kernel.eroded(self))
    }
}

impl Kernel {
    /// A square with sides of `2 * radius + 1` cells.
    pub(super) fn square(radius: u32) -> Self {
        Self { half_widths: vec![i64::from(radius); 2 * radius as usize + 1] }
    }

    /// An ellipse with axes of `2 * radius + 1` cells.
    /// Half the width of the row at offset y is sqrt(radius² - y²), rounded to the nearest.
    pub(super) fn ellipse(radius: u32) -> Self {
        let radius = i64::from(radius);
        let half_width = |y: i64| {
            let square = radius * radius - y * y;
            // The largest h with h - 1/2 <= sqrt(square).
            (0..=radius).rev().find(|&h| (2 * h - 1).max(0).pow(2) <= 4 * square).unwrap_or(0)
        };
        Self { half_widths: (-radius..=radius).map(half_width).collect() }
    }

    fn radius(&self) -> i64 {
        self.half_widths.len() as i64 / 2
    }

    /// The cells around which the kernel lies in the filled cells.
    fn eroded(&self, mask: &Mask) -> Mask {
        self.around_each(mask, |filled, span| filled == span)
    }

    /// The cells around which the kernel touches a filled cell.
    /// Kernels are point symmetric, so this is the union of the kernel around all filled cells.
    fn dilated(&self, mask: &Mask) -> Mask {
        self.around_each(mask, |filled, _| filled > 0)
    }

    /// The cells for which `holds` is true of two numbers: the filled cells under the kernel around
    /// the cell, and the cells of the kernel.
    fn around_each(&self, mask: &Mask, holds: impl Fn(i64, i64) -> bool) -> Mask {
        let (width, height) = (mask.width as i64, mask.height as i64);
        // Number of filled cells to the left of each cell's left side, one more than there are
        // columns for each row.
        let stride = mask.width + 1;
        let mut before = vec![0_i64; stride * mask.height];
        for (sums, row) in before.chunks_exact_mut(stride).zip(mask.cells.chunks_exact(mask.width))
        {
            for (x, &filled) in row.iter().enumerate() {
                sums[x + 1] = sums[x] + i64::from(filled);
            }
        }
        let radius = self.radius();
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let cells = cells.map(|(x, y)| {
            let (mut filled, mut span) = (0, 0);
            for (dy, &half) in (-radius..).zip(&self.half_widths) {
                span += 2 * half + 1;
                if (0..height).contains(&(y + dy)) {
                    let sums = &before[(y + dy) as usize * stride..];
                    let low = (x - half).max(0) as usize;
                    let high = (x + half + 1).min(width) as usize;
                    filled += sums[high] - sums[low];
                }
            }
            holds(filled, span)
        });
        Mask { cells: cells.collect(), ..*mask }
    }
}
