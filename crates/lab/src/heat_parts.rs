//! The parts on which the thermal solver is measured, by formula.

use std::sync::Arc;

use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Pattern};
use clap::ValueEnum;
use ndarray::Array3;

/// A part of the thermal figures: voxels of 0.5 x 0.5 x 0.25 mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum HeatPart {
    /// 120 x 40 x 12, full: 57,600 voxels.
    Rectangular,
    /// 90 x 50 x 12 without y >= 20 and 25 <= x < 65: 39,600 voxels.
    U,
    /// 77 layers, layer z a centred square of side round(60 - 56 z / 76): 99,536 voxels.
    Pyramid,
    /// 64 x 64 x 40, full: 163,840 voxels.
    Block,
}

impl HeatPart {
    /// The paper's three.
    pub(crate) const PAPER: [Self; 3] = [Self::Rectangular, Self::U, Self::Pyramid];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Rectangular => "rectangular",
            Self::U => "U",
            Self::Pyramid => "pyramid",
            Self::Block => "block",
        }
    }

    pub(crate) fn voxels(self) -> Voxels {
        match self {
            Self::Rectangular => voxels([120, 40, 12], |_| true),
            Self::U => voxels([90, 50, 12], |[x, y, _]| !(y >= 20 && (25..65).contains(&x))),
            Self::Pyramid => voxels([60, 60, 77], |[x, y, z]| {
                let side = (60.0 - 56.0 * f64::from(z) / 76.0).round() as u32;
                let inside = |i: u32| ((60 - side) / 2..(60 - side) / 2 + side).contains(&i);
                inside(x) && inside(y)
            }),
            Self::Block => cuboid([64, 64, 40]),
        }
    }
}

/// A full cuboid of so many voxels along x, y and z.
pub(crate) fn cuboid(size: [u32; 3]) -> Voxels {
    voxels(size, |_| true)
}

fn voxels([width, height, depth]: [u32; 3], inside: impl Fn([u32; 3]) -> bool) -> Voxels {
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height };
    let material = |(z, y, x): (usize, usize, usize)| {
        if inside([x as u32, y as u32, z as u32]) { 0 } else { Voxels::EMPTY }
    };
    let shape = (depth as usize, height as usize, width as usize);
    Voxels::new(frame, Array3::from_shape_fn(shape, material))
}

/// The orders of each layer by all 38 patterns, in the order of their numbers.
pub(crate) fn all_orders(part: &Voxels) -> anyhow::Result<Vec<Vec<Vec<Cell>>>> {
    let layer = |layer| {
        let region = part.region(layer)?;
        Ok(Pattern::ALL.iter().map(|pattern| pattern.order(&region)).collect())
    };
    (0..part.depth).map(layer).collect()
}

/// The order of each layer by one pattern.
pub(crate) fn orders(part: &Arc<Voxels>, pattern: Pattern) -> anyhow::Result<Vec<Vec<Cell>>> {
    (0..part.depth).map(|layer| Ok(pattern.order(&part.region(layer)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_the_voxels_that_their_figures_are_told_for() {
        let counts = HeatPart::value_variants().iter().map(|part| part.voxels().count());
        assert_eq!(counts.collect::<Vec<_>>(), [57_600, 39_600, 99_536, 163_840]);
    }
}
