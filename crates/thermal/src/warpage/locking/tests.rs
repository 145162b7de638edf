//! Locking against a slow twin that keeps no sums.

use std::collections::BTreeMap;

use beadwork_part::Frame;
use ndarray::Array3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;

type Field = BTreeMap<[u32; 3], f64>;

impl Temperatures for Field {
    fn layer(&self, z: usize) -> impl Iterator<Item = ([u32; 3], f64)> {
        self.iter().filter(move |(voxel, _)| voxel[2] as usize == z).map(|(&voxel, &c)| (voxel, c))
    }

    fn celsius(&self, voxel: [u32; 3]) -> Option<f64> {
        self.get(&voxel).copied()
    }
}

fn part(width: u32, height: u32, depth: usize) -> Voxels {
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height };
    Voxels::new(frame, Array3::zeros((depth, height as usize, width as usize)))
}

/// The stress-free strains minus αθ of the locked voxels.
struct Slow {
    membrane: Membrane,
    side: u32,
    columns: u32,
    locked: BTreeMap<[u32; 3], Strain>,
}

impl Slow {
    fn block(&self, [x, y, _]: [u32; 3]) -> usize {
        (y / self.side * self.columns + x / self.side) as usize
    }

    fn sample(&mut self, field: &Field, blocks: usize) {
        let ThermalMaterial { expansion_per_k: expansion, glass_transition_c: tg, .. } =
            ThermalMaterial::abs();
        self.locked.retain(|voxel, _| field[voxel] <= tg);
        let (mut count, mut free, mut heat) =
            (vec![0.0; blocks], vec![[0.0; 3]; blocks], vec![0.0; blocks]);
        for (voxel, c) in &self.locked {
            let block = self.block(*voxel);
            count[block] += 1.0;
            heat[block] += field[voxel];
            let thermal = expansion * field[voxel];
            let strain = [c[0] + thermal, c[1] + thermal, c[2]];
            (0..3).for_each(|i| free[block][i] += strain[i]);
        }
        for block in 0..blocks {
            (0..3).for_each(|i| free[block][i] /= f64::max(count[block], 1.0));
        }
        // Displacements are also the start of the next solution.
        if field.iter().any(|(voxel, &celsius)| celsius <= tg && !self.locked.contains_key(voxel)) {
            self.membrane.solve(&count, &free);
        }
        let mut new = Vec::new();
        for (&voxel @ [x, y, z], &celsius) in field {
            if celsius > tg || self.locked.contains_key(&voxel) {
                continue;
            }
            let block = self.block(voxel);
            let mut strain = self.membrane.strain(block);
            let at = |dx: i64, dy: i64, z: u32| -> Option<([u32; 3], f64)> {
                let side = [
                    u32::try_from(i64::from(x) + dx).ok()?,
                    u32::try_from(i64::from(y) + dy).ok()?,
                    z,
                ];
                Some((side, field.get(&side)?.min(tg)))
            };
            let gap = |dx, dy| match at(dx, dy, z) {
                Some((side, celsius)) if self.locked.contains_key(&side) => {
                    expansion * (tg - celsius) / 2.0
                }
                _ => 0.0,
            };
            strain[0] += gap(-1, 0) + gap(1, 0);
            strain[1] += gap(0, -1) + gap(0, 1);
            for (dx, dy) in [(-1, -1), (1, 1), (-1, 1), (1, -1)] {
                strain[2] += f64::min(gap(dx, 0), gap(0, dy)) * (dx * dy) as f64;
            }
            if let Some((below, own)) = z.checked_sub(1).and_then(|z| at(0, 0, z))
                && self.locked.contains_key(&below)
            {
                let near = |dx, dy| at(dx, dy, z - 1).map_or(own, |(_, celsius)| celsius);
                let xx = near(-1, 0) + near(1, 0) - 2.0 * own;
                let yy = near(0, -1) + near(0, 1) - 2.0 * own;
                let xy = (near(1, 1) + near(-1, -1) - near(1, -1) - near(-1, 1)) / 4.0;
                let limit = (xx * yy).abs().sqrt();
                let share = [xx.abs(), yy.abs(), xy.max(-limit).min(limit) * (xx + yy).signum()];
                let excess = own - heat[block] / count[block];
                for i in 0..3 {
                    if xx.abs() + yy.abs() > 0.0 {
                        strain[i] += 1.35 * expansion * excess * share[i] / (xx.abs() + yy.abs());
                    }
                }
            }
            new.push((voxel, [strain[0] - expansion * tg, strain[1] - expansion * tg, strain[2]]));
        }
        self.locked.extend(new);
    }
}

#[test]
fn strains_are_those_of_the_slow_twin() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    for case in 0..40 {
        // Blocks of 1 x 1 or of 2 x 2 voxels.
        let [width, height] = if case % 4 == 0 { [26, 3] } else { [6, 5] };
        let part = part(width, height, 3);
        let mut locking = Locking::new(&part, &ThermalMaterial::abs());
        locking.membrane.tolerance = 1e-10;
        let mut slow = Slow {
            membrane: locking.membrane.clone(),
            side: locking.side as u32,
            columns: locking.columns as u32,
            locked: BTreeMap::new(),
        };
        let mut field = Field::new();
        for _ in 0..30 {
            // Deposits a few voxels and changes all temperatures; one in ten is above Tg.
            for _ in 0..width {
                let (x, y) = (random.random_range(0..width), random.random_range(0..height));
                if let Some(z) = (0..3).find(|&z| !field.contains_key(&[x, y, z])) {
                    field.insert([x, y, z], 230.0);
                }
            }
            for celsius in field.values_mut() {
                *celsius = if random.random_ratio(1, 10) {
                    140.0
                } else {
                    random.random_range(40.0..105.0)
                };
            }
            locking.sample(&field);
            slow.sample(&field, locking.blocks.len());
        }
        let mut count = 0;
        for voxel in field.keys() {
            let fast = locking.locked[locking.index(*voxel)];
            match slow.locked.get(voxel) {
                None => assert!(fast[0].is_nan()),
                Some(slow) => {
                    count += 1;
                    for (a, b) in fast.into_iter().zip(slow) {
                        assert!((f64::from(a) - b).abs() < 1e-6, "{voxel:?}: {fast:?} {slow:?}");
                    }
                }
            }
        }
        assert!(count > 50);
        assert_eq!(locking.blocks.iter().map(|block| block.count).sum::<usize>(), count);
    }
}

#[test]
fn a_voxel_that_is_heated_again_loses_its_strain() {
    let part = part(4, 4, 2);
    let mut locking = Locking::new(&part, &ThermalMaterial::abs());
    let layer = |z: u32, celsius: f64| (0..16).map(move |i| ([i % 4, i / 4, z], celsius));
    locking.sample(&layer(0, 105.0).collect::<Field>());
    locking.sample(&layer(0, 65.0).chain(layer(1, 105.0)).collect::<Field>());
    let difference = |locking: &Locking| {
        let column = locking.columns().next().unwrap();
        column[1][0] - column[0][0]
    };
    // The upper layer is shorter by α (Tg - 65 °C).
    assert!((difference(&locking) + 90e-6 * 40.0).abs() < 1e-6);
    // Both layers melt and lock together.
    locking.sample(&layer(0, 120.0).chain(layer(1, 120.0)).collect::<Field>());
    assert!(locking.columns().flatten().all(|strain| strain[0].is_nan()));
    assert!(locking.blocks.iter().all(|block| block.count == 0 && block.heat.abs() < 1e-9));
    locking.sample(&layer(0, 100.0).chain(layer(1, 100.0)).collect::<Field>());
    assert!(difference(&locking).abs() < 1e-6);
}

#[test]
fn deep_layers_are_read_from_time_to_time() {
    let part = part(3, 3, 40);
    let mut locking = Locking::new(&part, &ThermalMaterial::abs());
    let field = |celsius: f64| -> Field {
        let cells = (0..40).flat_map(|z| (0..9).map(move |i| [i % 3, i / 3, z]));
        cells.map(|voxel| (voxel, celsius)).collect()
    };
    locking.sample(&field(105.0));
    (0..8).for_each(|_| locking.sample(&field(65.0)));
    let heat: f64 = locking.blocks.iter().map(|block| block.heat).sum();
    assert!((heat - 65.0 * 360.0).abs() < 1e-6);
}
