//! The paths that a search starts from.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::{Cell, Path, Region, cover};

/// A way to visit a region, chosen without looking at its zones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Start {
    /// Rows from top to bottom, the first from left to right, then alternately.
    RowZigzag,
    /// Columns from left to right, the first from top to bottom, then alternately.
    ColumnZigzag,
    /// Round and round inwards, from the top-left cell to the right.
    Spiral,
    /// [`cover()`]: any region, in few pieces.
    Cover,
}

/// Why a [`Start`] does not exist on a region.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "this region has no {start} of one piece: it would jump from ({}, {}) to ({}, {})",
    from.0, from.1, to.0, to.1
)]
pub struct StartError {
    /// The asked start.
    pub start: Start,
    /// Column and row of the cell before the first jump.
    pub from: (u32, u32),
    /// Column and row of the cell after it.
    pub to: (u32, u32),
}

/// A name that is no [`Start`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("'{0}' is no start: choose row_zigzag, column_zigzag, spiral or cover")]
pub struct UnknownStart(pub String);

impl Start {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::RowZigzag, Self::ColumnZigzag, Self::Spiral, Self::Cover];

    /// The path itself: of one piece, except for [`Start::Cover`].
    /// Linear in the plane's cells, but for the cover.
    pub fn path(self, region: &Region) -> Result<Path, StartError> {
        let order = match self {
            Self::RowZigzag => row_zigzag(region),
            Self::ColumnZigzag => column_zigzag(region),
            Self::Spiral => spiral(region),
            Self::Cover => return Ok(cover(region)),
        };
        if let Some(jump) = order.windows(2).find(|step| !region.adjacent(step[0], step[1])) {
            return Err(StartError {
                start: self,
                from: region.xy(jump[0]),
                to: region.xy(jump[1]),
            });
        }
        Ok(Path::hamiltonian(region, order)
            .expect("all cells of the plane, clipped to the region, in unit steps"))
    }

    /// Its name in configurations and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::RowZigzag => "row_zigzag",
            Self::ColumnZigzag => "column_zigzag",
            Self::Spiral => "spiral",
            Self::Cover => "cover",
        }
    }
}

impl fmt::Display for Start {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Start {
    type Err = UnknownStart;

    fn from_str(name: &str) -> Result<Self, UnknownStart> {
        Self::ALL
            .into_iter()
            .find(|start| start.name() == name)
            .ok_or_else(|| UnknownStart(name.to_owned()))
    }
}

/// The cells of the region in row zigzag order, whether or not they form one path.
fn row_zigzag(region: &Region) -> Vec<Cell> {
    let width = region.width();
    let row = |y: u32| {
        (0..width)
            .map(move |x| if y.is_multiple_of(2) { x } else { width - 1 - x })
            .map(move |x| (x, y))
    };
    clip(region, (0..region.height()).flat_map(row))
}

fn column_zigzag(region: &Region) -> Vec<Cell> {
    let height = region.height();
    let column = |x: u32| {
        (0..height)
            .map(move |y| if x.is_multiple_of(2) { y } else { height - 1 - y })
            .map(move |y| (x, y))
    };
    clip(region, (0..region.width()).flat_map(column))
}

fn spiral(region: &Region) -> Vec<Cell> {
    let (width, height) = (region.width(), region.height());
    let rings = width.min(height).div_ceil(2);
    let ring = |r: u32| {
        let (right, bottom) = (width - 1 - r, height - 1 - r);
        let top = (r..=right).map(move |x| (x, r));
        let down = (r + 1..=bottom).map(move |y| (right, y));
        // A ring one cell high or wide has no way back.
        let back = (r..right).rev().filter(move |_| bottom > r).map(move |x| (x, bottom));
        let up = (r + 1..bottom).rev().filter(move |_| right > r).map(move |y| (r, y));
        top.chain(down).chain(back).chain(up)
    };
    clip(region, (0..rings).flat_map(ring))
}

fn clip(region: &Region, order: impl Iterator<Item = (u32, u32)>) -> Vec<Cell> {
    order.map(|(x, y)| region.cell(x, y)).filter(|&cell| region.contains(cell)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rectangle_has_every_start() {
        for width in 1..8 {
            for height in 1..8 {
                let region = Region::rectangle(width, height).unwrap();
                for start in Start::ALL {
                    let path = start.path(&region).unwrap();
                    assert_eq!(path.order()[0], 0, "{start} on {width} x {height}");
                    assert_eq!(path.pieces(), 1, "{start} on {width} x {height}");
                }
            }
        }
    }

    #[test]
    fn orders_of_a_small_rectangle() {
        let region = Region::rectangle(3, 3).unwrap();
        let order = |start: Start| start.path(&region).unwrap().order().to_vec();
        assert_eq!(order(Start::RowZigzag), [0, 1, 2, 5, 4, 3, 6, 7, 8]);
        assert_eq!(order(Start::ColumnZigzag), [0, 3, 6, 7, 4, 1, 2, 5, 8]);
        assert_eq!(order(Start::Spiral), [0, 1, 2, 5, 8, 7, 6, 3, 4]);
    }

    #[test]
    fn a_mask_without_the_start_says_where_it_breaks() {
        let ring = Region::from_mask(3, 3, (0..9).map(|cell| cell != 4).collect()).unwrap();
        let error = Start::RowZigzag.path(&ring).unwrap_err();
        assert_eq!(
            error.to_string(),
            "this region has no row_zigzag of one piece: it would jump from (2, 1) to (0, 1)"
        );
        assert_eq!(Start::Spiral.path(&ring).unwrap().pieces(), 1);
        assert_eq!(Start::Cover.path(&ring).unwrap().pieces(), 1);
    }

    #[test]
    fn names_round_trip() {
        for start in Start::ALL {
            assert_eq!(start.name().parse(), Ok(start));
        }
        assert_eq!("zigzag".parse::<Start>(), Err(UnknownStart("zigzag".to_owned())));
    }
}
