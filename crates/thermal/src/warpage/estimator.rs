//! Shrinkage and curvature of columns of voxels during a print.

use beadwork_base::{Control, Interrupted};
use beadwork_part::slice::Voxels;
use ndarray::Array2;

use super::locking::Locking;
use super::plate::Plate;
use crate::material::ThermalMaterial;
use crate::simulation::Simulation;

/// Maximum number of blocks of columns along each side of the plate whose shape is computed.
const MAX_BLOCKS: usize = 96;

/// Follows a print, and estimates how much the part warps.
///
/// ```no_run
/// # use beadwork_base::Control;
/// # use beadwork_thermal::warpage::WarpageEstimator;
/// # use beadwork_thermal::{DepositionEvent, Simulation, ThermalMaterial};
/// # fn run(
/// #     print: &mut Simulation,
/// #     layers: &[Vec<DepositionEvent>],
/// # ) -> Result<(), Box<dyn std::error::Error>> {
/// let control = Control::default();
/// let mut warpage = WarpageEstimator::new(print.part(), &ThermalMaterial::abs());
/// for events in layers {
///     print.run_sampled(events, 0.5, |print| warpage.sample(print), &control)?;
/// }
/// let lift_mm = warpage.finish(print, &control)?.corner_lift_mm;
/// # Ok(())
/// # }
/// ```
///
/// # Model
/// The part is a stack of elastic layers with one modulus.
/// During the print, the plate keeps the part flat but does not keep it from shrinking.
/// A voxel carries no stress above the glass transition Tg.
/// When it cools below Tg, it **locks**: it has no stress at the in-plane strain that its
/// surroundings have at that time.
/// From then on it shrinks by α (Tg - T).
/// The material below has already shrunk in part, so it shrinks less from then on, and the upper
/// layers pull the edges up once the part is taken off the plate.
/// A voxel that is heated above Tg again loses its stress, and locks again when it cools.
///
/// With θ = min(T, Tg), and c the stress-free strain of a voxel minus αθ, a tensor in the plane:
///
/// - A voxel that locks gets c = ε - α Tg, where ε is the strain at its position.
/// - The strain of the part is that of a sheet in plane stress with free edges: at least one finite
///   element for each 1/16 of the longer side (a block), with the number of its locked voxels as
///   thickness, and their mean of c + αθ as stress-free strain.
///   A line shrinks along its length only together with the rest of the part, but across it almost
///   on its own: if αθ varies along one axis only, the sheet follows it (1 + ν) times along this
///   axis, and takes its mean along the other.
/// - What a block is too coarse for is added.
///   The voxel below may be hotter than the mean of its block; by the same rule, the difference
///   counts (1 + ν) times along the axis of the temperature's larger second difference (each axis
///   by its share).
///   A voxel next to a solid one of the same layer fills the gap that has opened since the
///   neighbour locked: half of α (Tg - T) of the neighbour is added to ε along the axis between
///   them.
/// - Released and cooled to a uniform temperature, a column of voxels alone takes the curvatures κ.
///   With h the height of a voxel, z the height of its centre and z̄ the mean of these heights:
///
///   ```text
///   κ = -Σ c (z - z̄) h / Σ ((z - z̄)² h + h³ / 12)
///   ```
///
///   For a full column of height H, the divisor is H³ / 12.
/// - All columns together take the shape that minimizes the bending energy of a plate with free
///   edges (Kirchhoff plate theory).
///
/// The temperature at which a part is taken off the plate does not matter: it is elastic, and what
/// counts is its shape when all of it has the same temperature.
///
/// For two layers of height h, of which the lower was at T everywhere when the upper locked, κ = 3
/// α (Tg - T) / (4 h), which is Timoshenko's bimetal (1925, *J. Opt. Soc. Am.* 11).
/// For a thin layer on a thick stack, it is Stoney's formula (1909, *Proc. R. Soc. A* 82).
/// The mismatch is that of Wang, Xi and Jin (2007, *Int. J. Adv. Manuf. Technol.* 33), who take one
/// T for the whole stack and let it bend after each layer instead of once at the end.
/// A rectangle with one κ lifts its corners by κ L² / 8 over its centre, with L the diagonal.
///
/// # What it depends on
/// Against three-dimensional elasticity with the same assumptions and the same samples
/// (`docs/results/warpage.md`), the curvature along lines is right within 8 % on a plate of 20 x 8
/// mm, and that across them, which is much smaller, within 1 / m for curvatures of 4 / m.
/// The direction of lines matters most: lifts of lines along the longer side of a plate are several
/// times those of lines along the shorter side.
/// The order of lines and how even temperatures are matter less: differences between orders of
/// lines of one direction are within the error of the estimate.
///
/// # Limits
/// Stress does not relax below Tg.
/// The plate holds the part flat until the end, but lets it slide: a part that is glued to the
/// plate and stays elastic would hardly warp, and one whose corners come off while it is thin warps
/// several times as much.
/// So lifts of different parts, and of high parts above all, are not comparable with measurements.
/// The model ignores gravity, stiffness that depends on the temperature or on the direction of
/// beads, shrinkage by the relaxation of stretched molecules along beads, and the variation of
/// in-plane strains over the height.
/// Its curvature falls with the height, but measured blocks of ABS warp most at medium heights
/// (Armillotta, Bellotti and Cavallaro 2018, *Robot. Comput.-Integr. Manuf.* 50).
/// Plate theory is for thin plates: for parts higher than a third of their length, at most the
/// order of the numbers is meaningful.
#[derive(Clone, Debug)]
pub struct WarpageEstimator {
    cell_m: f64,
    layer_m: f64,
    locking: Locking,
}

/// How much a part is likely to warp.
#[derive(Clone, Debug)]
pub struct WarpageEstimate {
    /// Mean of the curvatures along both axes that the columns would take alone, weighted by their
    /// stiffness, 1/m; positive if edges go up.
    pub curvature_1_m: f64,
    /// The means of the curvatures along x and along y, weighted in the same way, 1/m.
    pub axis_curvatures_1_m: [f64; 2],
    /// Maximum height of the outline above the lowest point of the part, mm, at least 0.
    pub corner_lift_mm: f64,
    /// Height difference between the highest and the lowest point, mm: more than the lift if the
    /// centre rises.
    pub flatness_mm: f64,
    /// Width and height of a block of columns, in voxels: 1 for parts of up to 96 x 96 voxels.
    pub block: usize,
    /// The shape, one number per block, with the axes `[y, x]`: height above the best-fitting
    /// plane, mm; NaN outside the part.
    pub heights_mm: Array2<f64>,
}

impl WarpageEstimator {
    /// An estimator for a part of which nothing is printed yet.
    /// The memory is 12 bytes per voxel of its bounding box.
    pub fn new(part: &Voxels, material: &ThermalMaterial) -> Self {
        Self {
            cell_m: part.frame.cell_mm / 1e3,
            layer_m: part.frame.layer_mm / 1e3,
            locking: Locking::new(part, material),
        }
    }

    /// Locks all deposited voxels that are at or below the glass transition and not locked yet, and
    /// unlocks those that are above it again.
    ///
    /// Call it at regular times ([`Simulation::run_sampled`]): the temperatures at the sample are
    /// used as those at the moment of locking.
    /// On the same plate, the curvature along lines changed by at most 7 % between intervals of
    /// 0.02 and 2 s, but that across lines by up to 2.5 / m, and with it the lifts of lines along
    /// the shorter side by a factor of up to 3; they were lower than those of lines along the
    /// longer side with every interval.
    /// Compare plans with the same sampling interval only.
    ///
    /// A sample reads the temperatures of the layers that have voxels to be locked, of the eight
    /// highest ones, and every few samples those of deeper ones; and it computes the strains of at
    /// most 16 x 16 blocks.
    ///
    /// # Panics
    /// If the simulation is of another part.
    pub fn sample(&mut self, simulation: &Simulation) {
        self.locking.sample(simulation);
    }

    /// Locks all deposited voxels that are not locked yet, and computes how the part bends.
    ///
    /// Costs the part's voxels, and its columns times the square of its shorter side; parts with
    /// more than 96 columns along a side are first coarsened to at most that.
    /// Progress counts the blocks of columns.
    ///
    /// # Panics
    /// As [`WarpageEstimator::sample`].
    pub fn finish(
        mut self,
        simulation: &Simulation,
        control: &Control<'_>,
    ) -> Result<WarpageEstimate, Interrupted> {
        control.check()?;
        self.locking.finish(simulation);
        estimate(&self.locking, self.cell_m, self.layer_m, control)
    }
}

/// The bending stiffness of a column divided by modulus and width, m³, and its bending moments
/// divided by the same, m².
fn bending(column: &[[f32; 3]], layer_m: f64) -> (f64, [f64; 3]) {
    let h = layer_m;
    let voxels =
        || (0u32..).zip(column).filter(|(_, c)| !c[0].is_nan()).map(|(z, c)| (f64::from(z) * h, c));
    let count = voxels().count() as f64;
    let centre = voxels().map(|(z, _)| z).sum::<f64>() / count.max(1.0);
    let (mut stiffness, mut moments) = (0.0, [0.0; 3]);
    for (z, c) in voxels() {
        let arm = z - centre;
        stiffness += arm * arm * h + h * h * h / 12.0;
        moments.iter_mut().zip(c).for_each(|(sum, &c)| *sum -= f64::from(c) * arm * h);
    }
    (stiffness, moments)
}

/// Bends a part with the locked strains.
fn estimate(
    locking: &Locking,
    cell_m: f64,
    layer_m: f64,
    control: &Control<'_>,
) -> Result<WarpageEstimate, Interrupted> {
    let block = locking.width().max(locking.height()).div_ceil(MAX_BLOCKS).max(1);
    let (columns, rows) = (locking.width().div_ceil(block), locking.height().div_ceil(block));
    let mut stiffness = vec![0.0; columns * rows];
    let mut moments = vec![[0.0; 3]; columns * rows];
    let (mut total, mut total_moments) = (0.0, [0.0; 3]);
    for (number, column) in locking.columns().enumerate() {
        let (x, y) = (number % locking.width() / block, number / locking.width() / block);
        let (of_column, moments_of_column) = bending(column, layer_m);
        stiffness[y * columns + x] += of_column;
        total += of_column;
        for (i, moment) in moments_of_column.into_iter().enumerate() {
            moments[y * columns + x][i] += moment;
            total_moments[i] += moment;
        }
    }
    let curvatures = |moments: [f64; 3], stiffness: f64| {
        moments.map(|moment| if stiffness > 0.0 { moment / stiffness } else { 0.0 })
    };
    let [along_x, along_y, _] = curvatures(total_moments, total);
    let curvature = moments.iter().zip(&stiffness).map(|(&m, &s)| curvatures(m, s)).collect();
    let spacing = cell_m * block as f64;
    let plate = Plate { width: columns, height: rows, spacing, stiffness, curvature };
    let heights = plate.deflection(control)?;
    let inside =
        |x: usize, y: usize| x < columns && y < rows && plate.stiffness[y * columns + x] > 0.0;
    let is_outline = |&[x, y]: &[usize; 2]| {
        let around = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        !around.into_iter().all(|(x, y)| inside(x, y))
    };
    let height_m = |[x, y]: [usize; 2]| heights[y * columns + x];
    let lowest = plate.cells().map(height_m).fold(f64::INFINITY, f64::min);
    // 0 if nothing is deposited, where these are infinite.
    let rise_mm = |highest: f64| (highest - lowest).max(0.0) * 1e3;
    let heights_mm = Array2::from_shape_fn((rows, columns), |(y, x)| {
        if inside(x, y) { height_m([x, y]) * 1e3 } else { f64::NAN }
    });
    Ok(WarpageEstimate {
        curvature_1_m: f64::midpoint(along_x, along_y),
        axis_curvatures_1_m: [along_x, along_y],
        corner_lift_mm: rise_mm(
            plate.cells().filter(is_outline).map(height_m).fold(f64::NEG_INFINITY, f64::max),
        ),
        flatness_mm: rise_mm(plate.cells().map(height_m).fold(f64::NEG_INFINITY, f64::max)),
        block,
        heights_mm,
    })
}

#[cfg(test)]
mod tests;
