//! Coefficients of the steps of a [`Stepper`](super::stepper::Stepper).

use super::coefficients::Coefficients;
use super::geometry::{Blocks, LevelBlocks};
use super::plane::Plane;
use super::stepper::{FirstLevel, LevelStepper};

/// Maximum share of the difference to a neighbour that a block takes up in a step.
///
/// Full blocks stay below it; blocks with few voxels would be unstable.
const MAX_SHARE: f32 = 0.2;

/// Steps of one length on blocks of one size.
pub(super) struct Assembly<'a> {
    pub(super) blocks: &'a Blocks,
    pub(super) coefficients: &'a Coefficients,
    pub(super) step_s: f64,
}

/// What the elimination of a level leaves for the level above it.
pub(super) struct Eliminated {
    /// 1 / pivot of each block.
    inverse_pivot: Vec<f32>,
    /// Conductance to the level above, per voxel of the eliminated level.
    above: Vec<f32>,
}

impl Assembly<'_> {
    /// The printed layer.
    pub(super) fn first_level(&self) -> FirstLevel {
        let (first, second) = (&self.blocks.levels[0], self.blocks.levels.get(1));
        let to_plate = self.to_plate(first);
        let between = second.map_or(0.0, |second| self.between(first, second));
        let top_area = self.coefficients.top_area * self.step_s;
        FirstLevel {
            sides: self.sides(first, None),
            source: self.plane(per_voxel(&first.plate, to_plate * self.plate_k(), first), first),
            plate: self.plane(per_voxel(&first.plate, to_plate, first), first),
            faces: self.plane(per_voxel(&first.faces, top_area, first), first),
            side: (self.coefficients.side_area * self.step_s) as f32,
            below: self.plane(per_voxel(&first.below, between, first), first),
            covered: match second {
                Some(second) => self.plane(per_voxel(&first.below, top_area, second), second),
                None => self.plane(vec![0.0; self.blocks.len()], first),
            },
        }
    }

    /// A level below it, whose surfaces have the heat transfer coefficient `loss`.
    ///
    /// `lower` is the level below, unless there is none or it keeps its temperatures; planes that
    /// equal `sides` share its values.
    pub(super) fn level(
        &self,
        number: usize,
        loss: f32,
        lower: Option<Eliminated>,
        sides: &[Plane; 4],
    ) -> (LevelStepper, Eliminated) {
        let levels = &self.blocks.levels;
        let (level, upper) = (&levels[number], &levels[number - 1]);
        let above = per_voxel(&upper.below, self.between(upper, level), level);
        let plate = per_voxel(&level.plate, self.to_plate(level), level);
        let diagonal = |(surface, plate): (&f32, &f32)| 1.0 + surface * loss + plate;
        let mut pivot: Vec<f32> = self.surface(level).iter().zip(&plate).map(diagonal).collect();
        // What the second level exchanges with the first depends on what is printed.
        if number > 1 {
            pivot.iter_mut().zip(&above).for_each(|(pivot, above)| *pivot += above);
        }
        let passed_up = levels.get(number + 1).map(|next| {
            let below = per_voxel(&level.below, self.between(level, next), level);
            let Some(lower) = lower else {
                // It keeps its temperatures, and passes them up as they are.
                pivot.iter_mut().zip(&below).for_each(|(pivot, below)| *pivot += below);
                return self.plane(below, level);
            };
            let passed: Vec<f32> =
                below.iter().zip(&lower.inverse_pivot).map(|(below, p)| below * p).collect();
            for (block, pivot) in pivot.iter_mut().enumerate() {
                *pivot += below[block] - passed[block] * lower.above[block];
            }
            self.plane(passed, level)
        });
        if number > 1 {
            pivot.iter_mut().for_each(|pivot| *pivot = 1.0 / *pivot);
        }
        let plate_k = self.plate_k() as f32;
        let source = plate
            .iter()
            .any(|&plate| plate > 0.0)
            .then(|| self.plane(plate.iter().map(|plate| plate * plate_k).collect(), level));
        let stepper = LevelStepper {
            sides: self.sides(level, Some(sides)),
            source,
            above: self.plane(above.clone(), level),
            passed_up,
            pivot: self.plane(pivot.clone(), level),
        };
        (stepper, Eliminated { inverse_pivot: pivot, above })
    }

    /// Conductances to the four neighbours, per voxel.
    fn sides(&self, level: &LevelBlocks, other: Option<&[Plane; 4]>) -> [Plane; 4] {
        let factor = self.coefficients.lateral * self.step_s / f64::from(self.blocks.side);
        // Both sides of a border have the same limit, so that no heat is lost.
        let limited = |pairs: &[f32], shift: usize| -> Vec<f32> {
            let next = level.voxels[shift..].iter().chain(std::iter::repeat_n(&0.0, shift));
            let limit = level.voxels.iter().zip(next).map(|(&a, &b)| MAX_SHARE * a.min(b));
            pairs.iter().zip(limit).map(|(&n, limit)| (n * factor as f32).min(limit)).collect()
        };
        let shifted = |values: &[f32], shift: usize| -> Vec<f32> {
            let mut shifted = vec![0.0; values.len()];
            shifted[shift..].copy_from_slice(&values[..values.len() - shift]);
            shifted
        };
        let width = self.blocks.width;
        let (right, down) = (limited(&level.right, 1), limited(&level.down, width));
        let (left, up) = (shifted(&right, 1), shifted(&down, width));
        let everywhere = vec![1.0; self.blocks.len()];
        let conductances = [right, left, down, up];
        std::array::from_fn(|side| {
            let shares = per_voxel(&conductances[side], 1.0, level);
            let plane = Plane::new(shares, &everywhere, width);
            plane.shared_with(other.map(|other| &other[side]))
        })
    }

    /// Surface that faces the air, per voxel, times the step over the heat capacity.
    fn surface(&self, level: &LevelBlocks) -> Vec<f32> {
        let sides = per_voxel(&level.sides, self.coefficients.side_area * self.step_s, level);
        let faces = per_voxel(&level.faces, self.coefficients.top_area * self.step_s, level);
        sides.iter().zip(&faces).map(|(side, face)| side + face).collect()
    }

    /// Conductance of a voxel on the plate.
    fn to_plate(&self, level: &LevelBlocks) -> f64 {
        let Some(_) = self.coefficients.plate_k else { return 0.0 };
        2.0 * self.coefficients.vertical * self.step_s / level.layers as f64
    }

    /// Conductance of a pair of voxels between two levels.
    fn between(&self, upper: &LevelBlocks, lower: &LevelBlocks) -> f64 {
        let layers = (upper.layers + lower.layers) as f64;
        2.0 * self.coefficients.vertical * self.step_s / layers
    }

    fn plate_k(&self) -> f64 {
        self.coefficients.plate_k.unwrap_or(0.0)
    }

    fn plane(&self, values: Vec<f32>, level: &LevelBlocks) -> Plane {
        Plane::new(values, &level.voxels, self.blocks.width)
    }
}

/// Values times `factor`, divided by the voxels of their block; 0 without voxels.
fn per_voxel(values: &[f32], factor: f64, level: &LevelBlocks) -> Vec<f32> {
    let share = |(&value, &voxels): (&f32, &f32)| {
        if voxels > 0.0 { value * factor as f32 / voxels } else { 0.0 }
    };
    values.iter().zip(&level.voxels).map(share).collect()
}
