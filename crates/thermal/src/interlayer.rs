//! How warm the ground is on which beads land.

use beadwork_part::slice::Voxels;

use crate::simulation::Simulation;
use crate::spread::Spread;

/// How warm the voxels below a layer were when it was laid on them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond {
    /// The upper layer.
    pub layer: u32,
    /// Temperatures of the voxels below, just before.
    pub landing: Spread,
    /// Share of them that were below the glass transition, 0 to 1.
    pub cold_share: f64,
}

impl Simulation {
    /// The bonds of all layers that lie on others, from the bottom up; linear in the part.
    ///
    /// Two beads weld by chains that diffuse through their interface while it is above the glass
    /// transition (Sun, Rizvi, Bellehumeur and Gu 2008, *Rapid Prototyping Journal* 14; Seppala and
    /// Migler 2016, *Additive Manufacturing* 12).
    /// A warm layer below keeps the interface there for longer.
    /// The interface itself starts about half-way between the bead and the ground, so ground below
    /// the glass transition is common and no defect by itself: these numbers rank plans.
    pub fn bonds(&self, glass_transition_c: f64) -> Vec<Bond> {
        bonds(self.part(), glass_transition_c, |voxel| self.landing_c(voxel))
    }
}

/// `landing_c` tells for x, y and z of a voxel of the part how warm the voxel below it was when it
/// was laid down, in °C, or `None` if there was none or it isn't laid down.
/// Layers without any such voxel are left out.
fn bonds(
    part: &Voxels,
    glass_transition_c: f64,
    landing_c: impl Fn([u32; 3]) -> Option<f64>,
) -> Vec<Bond> {
    let width = part.frame.width;
    let of_layer = |layer: u32| {
        let cells = part.cells(layer as usize);
        let landings: Vec<f64> =
            cells.filter_map(|cell| landing_c([cell % width, cell / width, layer])).collect();
        let landing = Spread::of(landings.iter().copied())?;
        let cold = landings.iter().filter(|&&celsius| celsius < glass_transition_c).count();
        Some(Bond { layer, landing, cold_share: cold as f64 / landings.len() as f64 })
    };
    (0..part.depth as u32).filter_map(of_layer).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::stairs;

    #[test]
    fn layers_are_told_apart() {
        let part = stairs(8, 4, 4);
        let bonds = bonds(&part, 105.0, |[x, _, z]| {
            (z == 1 || z == 2).then_some(if x < 6 { 90.0 } else { 130.0 })
        });
        assert_eq!(bonds.iter().map(|bond| bond.layer).collect::<Vec<_>>(), [1, 2]);
        // Layer 1 begins at x = 1, layer 2 at x = 2.
        assert_eq!((bonds[0].landing.count, bonds[1].landing.count), (28, 24));
        assert_eq!((bonds[0].cold_share, bonds[1].cold_share), (5.0 / 7.0, 4.0 / 6.0));
        assert_eq!((bonds[0].landing.min_c, bonds[0].landing.max_c), (90.0, 130.0));
    }

    #[test]
    fn nothing_laid_on_anything_has_no_bonds() {
        assert_eq!(bonds(&stairs(8, 4, 4), 105.0, |_| None), []);
    }
}
