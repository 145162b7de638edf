//! How much a part is likely to warp: a number to rank plans by, no prediction.

mod plate;

use beadwork_part::slice::Voxels;

use self::plate::Plate;
use crate::material::Material;
use crate::simulation::Simulation;

/// Blocks of columns along the longer side, at most: what the plate's shape is found on.
const BLOCKS: usize = 96;

/// Follows a print, and tells how much the part is likely to warp.
///
/// ```no_run
/// # use beadwork_thermal::{Material, Simulation, Slot, Warpage};
/// # fn warp(simulation: &mut Simulation, layers: &[Vec<Slot>]) -> Result<(), beadwork_thermal::DepositError> {
/// let mut warpage = Warpage::new(simulation.part(), &Material::abs());
/// for slots in layers {
///     simulation.run_watched(slots, 0.5, |simulation| warpage.look(simulation))?;
/// }
/// let lift_mm = warpage.finish(simulation).corner_lift_mm;
/// # Ok(())
/// # }
/// ```
///
/// # Model
/// The part is a stack of elastic layers of one modulus.
/// While it is printed, the plate keeps it flat, but not from shrinking.
/// A voxel carries no stress above the glass transition Tg.
/// When it cools below, it **locks**: it is as long as the column below it is at that moment,
/// without stress.
/// From then on it shrinks by α (Tg - T).
/// The column below, of which some has cooled before, has less left to shrink, so that the upper
/// layers pull the edges up once the plate lets go.
/// Each column of voxels is taken alone.
/// With θ = min(T, Tg), and c the strain of a voxel, free of stress, less αθ:
///
/// - the length of a column at time t is what balances its forces: e(t) = mean of c + α θ(t) over
///   its locked voxels,
/// - a voxel that locks at time t gets c = e(t) - α Tg (the lowest of a column: c = -α Tg),
/// - let go and cooled to one temperature, the column alone would take the curvature κ = -Σ c (z -
///   z̄) h / I, with I = Σ ((z - z̄)² h + h³ / 12); for a full column of height H, that is -12 / H³
///   Σ c (z - z̄) h,
/// - all columns together take the shape of least bending energy of a plate free at its edges
///   (Kirchhoff's theory).
///
/// For two layers of height h, of which the lower was at T when the upper locked, κ = 3 α (Tg - T)
/// / (4 h): Timoshenko's bimetal (1925, *J. Opt. Soc. Am.* 11).
/// For a thin layer on a thick stack, it is Stoney's formula (1909, *Proc. R. Soc. A* 82).
/// The mismatch is that of Wang, Xi and Jin (2007, *Int. J. Adv. Manuf. Technol.* 33), who take one
/// T for the whole stack and let it bend after each layer, not once at the end.
/// A rectangle of one κ lifts its corners by κ L² / 8 over its middle, with L the diagonal.
///
/// # Limits
/// No stress relaxes below Tg; voxels that are heated above it again keep their lock.
/// Nothing is said of the plate's adhesion, of gravity, of stiffness in its dependence on
/// temperature and on the direction of beads, or of columns that hold each other in the plane.
/// Curvature falls with height here; measured blocks of ABS warp most at middling heights
/// (Armillotta, Bellotti and Cavallaro 2018, *Robot. Comput.-Integr. Manuf.* 50).
/// Plates are thin: of parts higher than a third of their length, only the order of numbers means
/// something, if at all.
/// The number is not the paper's reward in other words: even temperatures and warm ground at each
/// lock are two things, and patterns can be good at one of them.
#[derive(Clone, Debug)]
pub struct Warpage {
    width: usize,
    depth: usize,
    cell_m: f64,
    layer_m: f64,
    /// Thermal expansion, 1/K.
    expansion: f64,
    transition_c: f64,
    /// c of each voxel, `[y, x, z]`: columns lie in one piece.
    /// NaN where none is locked.
    locked: Vec<f64>,
    /// Voxels of each layer that are not locked.
    open: Vec<usize>,
}

/// How much a part is likely to warp.
#[derive(Clone, Debug, PartialEq)]
pub struct WarpageEstimate {
    /// Mean of the curvatures that the columns would take alone, weighted by their stiffness, 1/m;
    /// more than 0 if edges go up.
    pub curvature_1_m: f64,
    /// How far the outline rises above the lowest place of the part, at most, mm.
    /// At least 0.
    pub corner_lift_mm: f64,
    /// How far the highest place lies above the lowest, mm: more than the lift if the middle rises.
    pub flatness_mm: f64,
    /// Columns in each direction that one number of the map stands for: 1 up to 96 columns.
    pub block: usize,
    /// Numbers in a row of the map.
    pub width: usize,
    /// The shape, `[y, x]`: height above the best-fitting plane, mm; `None` outside the part.
    pub heights_mm: Vec<Option<f64>>,
}

impl Warpage {
    /// Before anything of a part is printed.
    /// Memory is 8 bytes for each voxel of the box around it.
    pub fn new(part: &Voxels, material: &Material) -> Self {
        Self {
            width: part.frame.width as usize,
            depth: part.depth,
            cell_m: part.frame.cell_mm / 1e3,
            layer_m: part.frame.layer_mm / 1e3,
            expansion: material.expansion_per_k,
            transition_c: material.glass_transition_c,
            locked: vec![f64::NAN; part.materials().len()],
            open: (0..part.depth).map(|layer| part.cells(layer).count()).collect(),
        }
    }

    /// Locks the voxels that are below the glass transition now and were not at the last look.
    ///
    /// To be called every so often ([`Simulation::run_watched`]), as columns are taken to be as
    /// warm at the lock as they are at the look.
    /// On a block of ABS of 30 x 20 mm, lifts with looks every 0.5 s were 10 to 15 % above those
    /// with looks every 0.02 s, and with 0.1 s 2 to 4 %; seven patterns ranked the same with all of
    /// them.
    /// Looks at layers' ends alone make lifts half as high again, and another rank.
    /// Compare plans with the same looks only.
    ///
    /// All locks of a layer together cost the part's voxels up to it; each look costs the layers
    /// with voxels that aren't locked.
    ///
    /// # Panics
    /// If the simulation is of another part, or lacks voxels that an earlier look has seen.
    pub fn look(&mut self, simulation: &Simulation) {
        self.lock(simulation, self.transition_c);
    }

    /// Locks what is deposited and left, as after a last look, and tells how the part bends.
    /// Panics like [`Warpage::look`].
    ///
    /// Costs the part's voxels, and its columns times the square of its shorter side; parts wider
    /// than 96 columns are first coarsened to that.
    pub fn finish(mut self, simulation: &Simulation) -> WarpageEstimate {
        self.lock(simulation, f64::INFINITY);
        self.estimate()
    }

    fn lock(&mut self, simulation: &Simulation, up_to_c: f64) {
        let first = self.open.iter().position(|&count| count > 0).unwrap_or(self.depth);
        // From the bottom up in each column: what lies below has locked before.
        for (voxel, celsius) in simulation.deposited(first..self.depth) {
            if celsius <= up_to_c {
                self.lock_voxel(voxel, |below| {
                    simulation.temperature_c(below).expect("locked voxels are there")
                });
            }
        }
    }

    /// Locks a voxel now, unless it is locked; `celsius` tells the temperatures of those below.
    fn lock_voxel(&mut self, voxel: [u32; 3], celsius: impl Fn([u32; 3]) -> f64) {
        let [x, y, z] = voxel;
        let start = (y as usize * self.width + x as usize) * self.depth;
        let column = &mut self.locked[start..=start + z as usize];
        if !column[z as usize].is_nan() {
            return;
        }
        let (mut sum, mut count) = (0.0, 0.0);
        for (below, c) in (0..z).zip(&*column).filter(|(_, c)| !c.is_nan()) {
            sum += c + self.expansion * celsius([x, y, below]).min(self.transition_c);
            count += 1.0;
        }
        let length = if count > 0.0 { sum / count } else { 0.0 };
        column[z as usize] = length - self.expansion * self.transition_c;
        self.open[z as usize] -= 1;
    }

    /// The bending stiffness of a column by modulus and width, m³, and the moment that bends it,
    /// m².
    fn bending(&self, column: &[f64]) -> [f64; 2] {
        let h = self.layer_m;
        let voxels = || {
            (0u32..).zip(column).filter(|(_, c)| !c.is_nan()).map(|(z, &c)| (f64::from(z) * h, c))
        };
        let count = voxels().count() as f64;
        let centre = voxels().map(|(z, _)| z).sum::<f64>() / count.max(1.0);
        voxels().fold([0.0; 2], |[stiffness, moment], (z, c)| {
            let arm = z - centre;
            [stiffness + arm * arm * h + h * h * h / 12.0, moment - c * arm * h]
        })
    }

    fn estimate(&self) -> WarpageEstimate {
        let height = self.locked.len() / (self.width * self.depth).max(1);
        let block = self.width.max(height).div_ceil(BLOCKS).max(1);
        let (columns, rows) = (self.width.div_ceil(block), height.div_ceil(block));
        let mut stiffness = vec![0.0; columns * rows];
        let mut moments = stiffness.clone();
        for (number, column) in self.locked.chunks_exact(self.depth.max(1)).enumerate() {
            let (x, y) = (number % self.width / block, number / self.width / block);
            let [of_column, moment] = self.bending(column);
            stiffness[y * columns + x] += of_column;
            moments[y * columns + x] += moment;
        }
        let (all, moment): (f64, f64) = (stiffness.iter().sum(), moments.iter().sum());
        let ratio =
            |moment: f64, stiffness: f64| if stiffness > 0.0 { moment / stiffness } else { 0.0 };
        let curvature = moments.iter().zip(&stiffness).map(|(&m, &s)| ratio(m, s)).collect();
        let spacing = self.cell_m * block as f64;
        let plate = Plate { width: columns, height: rows, spacing, stiffness, curvature };
        let heights = plate.deflection();
        let inside =
            |x: usize, y: usize| x < columns && y < rows && plate.stiffness[y * columns + x] > 0.0;
        let is_outline = |&[x, y]: &[usize; 2]| {
            let around = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
            !around.into_iter().all(|(x, y)| inside(x, y))
        };
        let height_m = |[x, y]: [usize; 2]| heights[y * columns + x];
        let lowest = plate.cells().map(height_m).fold(f64::INFINITY, f64::min);
        // 0 for a part of which nothing is deposited, where these are infinite.
        let rise_mm = |highest: f64| (highest - lowest).max(0.0) * 1e3;
        let heights_mm = (0..columns * rows)
            .map(|i| inside(i % columns, i / columns).then(|| heights[i] * 1e3))
            .collect();
        WarpageEstimate {
            curvature_1_m: ratio(moment, all),
            corner_lift_mm: rise_mm(
                plate.cells().filter(is_outline).map(height_m).fold(f64::NEG_INFINITY, f64::max),
            ),
            flatness_mm: rise_mm(plate.cells().map(height_m).fold(f64::NEG_INFINITY, f64::max)),
            block,
            width: columns,
            heights_mm,
        }
    }
}

#[cfg(test)]
mod tests;
