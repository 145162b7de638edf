//! The proxy against a slow form of its equations, and against the heat equation.

#![expect(clippy::needless_range_loop, reason = "indices of matrices and blocks")]

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use beadwork_part::{LineOrder, Order, Pattern, Sequence};
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::geometry::LevelBlocks;
use super::stepper::{State, Stepper};
use super::*;
use crate::testing::{part, unit};

/// A part of random columns, some of them hollow.
pub(super) fn random_part(rng: &mut Xoshiro256PlusPlus) -> Arc<Voxels> {
    let size = [3 + rng.next_u64() as u32 % 9, 3 + rng.next_u64() as u32 % 7, 6];
    let heights: Vec<u32> = (0..size[0] * size[1]).map(|_| rng.next_u64() as u32 % 7).collect();
    let hollow = rng.next_u64() as u32 % 6;
    part(size, |[x, y, z]| {
        let column = y * size[0] + x;
        z < heights[column as usize].max(u32::from(column == 0) * 6)
            && (z != hollow || column.is_multiple_of(3))
    })
}

/// One step by its definition: explicit sideways, then a dense system per column of blocks.
///
/// Levels without a mean in `level_k` keep their temperatures.
fn slow_step(
    blocks: &Blocks,
    coefficients: &Coefficients,
    level_k: &[f64],
    step_s: f64,
    state: &State,
) -> Vec<Vec<f64>> {
    let levels = level_k.len();
    let theta = |level: usize, block: usize| f64::from(state.theta[level][block]);
    let deposited = |level: usize, block: usize| {
        if level == 0 { f64::from(state.deposited[block]) } else { 1.0 }
    };
    let side = f64::from(blocks.side);
    let mut next = vec![vec![0.0; blocks.len()]; levels];
    for block in 0..blocks.len() {
        let used: Vec<usize> =
            (0..levels).filter(|&level| blocks.levels[level].voxels[block] > 0.0).collect();
        let count = used.len();
        let mut matrix = vec![vec![0.0; count + 1]; count];
        for (row, &number) in used.iter().enumerate() {
            let level = &blocks.levels[number];
            let voxels = f64::from(level.voxels[block]);
            let own = theta(number, block);
            let pairs = |level: &LevelBlocks, from: usize, to: usize, pairs: &[f32]| {
                let limit = 0.2 * level.voxels[from].min(level.voxels[to]);
                (f64::from(pairs[from]) * coefficients.lateral * step_s / side)
                    .min(f64::from(limit))
            };
            let mut flow = 0.0;
            let right = (block + 1 < blocks.len()).then(|| (block + 1, block, &level.right));
            let left = block.checked_sub(1).map(|left| (left, left, &level.right));
            let down = (block + blocks.width < blocks.len())
                .then(|| (block + blocks.width, block, &level.down));
            let up = block.checked_sub(blocks.width).map(|up| (up, up, &level.down));
            for (other, from, contacts) in [right, left, down, up].into_iter().flatten() {
                let to = from + (other.max(block) - from);
                flow += pairs(level, from, to, contacts)
                    * deposited(number, other)
                    * (theta(number, other) - own);
            }
            let vertical = |other: &LevelBlocks, contacts: f32| {
                2.0 * coefficients.vertical * step_s / (level.layers + other.layers) as f64
                    * f64::from(contacts)
            };
            let to_plate = coefficients.plate_k.map_or(0.0, |_| {
                2.0 * coefficients.vertical * step_s / level.layers as f64
                    * f64::from(level.plate[block])
            });
            // Of the printed layer, sides towards voxels that are not printed face the air, too.
            let sides = if number == 0 {
                voxels * f64::from(state.open_sides[block])
            } else {
                f64::from(level.sides[block])
            };
            let surface = (sides * coefficients.side_area
                + f64::from(level.faces[block]) * coefficients.top_area)
                * step_s;
            let loss_theta = if number == 0 { own } else { level_k[number] };
            let mut diagonal = voxels + to_plate + surface * coefficients.loss_at(loss_theta);
            let mut known = voxels * own + flow + to_plate * coefficients.plate_k.unwrap_or(0.0);
            if number + 1 < blocks.levels.len() {
                // The printed layer does not conduct downwards where it is not printed, but takes
                // the temperature below there.
                let below = vertical(&blocks.levels[number + 1], level.below[block]);
                diagonal += below;
                if number + 1 == levels {
                    known += below * theta(number + 1, block);
                } else if let Some(column) = used.iter().position(|&other| other == number + 1) {
                    matrix[row][column] -= below;
                }
            }
            if number > 0 {
                let upper = &blocks.levels[number - 1];
                let above = vertical(upper, upper.below[block]) * deposited(number - 1, block);
                diagonal += above;
                if number == 1 {
                    let bare = f64::from(upper.below[block]) * (1.0 - deposited(0, block));
                    diagonal += bare * coefficients.top_area * step_s * coefficients.loss_at(own);
                }
                if let Some(column) = used.iter().position(|&other| other == number - 1) {
                    matrix[row][column] -= above;
                }
            }
            matrix[row][row] += diagonal;
            matrix[row][count] = known;
        }
        for (row, solution) in solve(matrix).into_iter().enumerate() {
            next[used[row]][block] = solution;
        }
    }
    next
}

/// Gaussian elimination; the last column is the right side.
fn solve(mut matrix: Vec<Vec<f64>>) -> Vec<f64> {
    let count = matrix.len();
    for pivot in 0..count {
        for row in 0..count {
            if row == pivot {
                continue;
            }
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            for column in pivot..=count {
                matrix[row][column] -= factor * matrix[pivot][column];
            }
        }
    }
    (0..count).map(|row| matrix[row][count] / matrix[row][row]).collect()
}

#[test]
fn steps_solve_their_equations() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut steps = 0;
    while steps < 2000 {
        let part = random_part(&mut rng);
        let layer = rng.next_u64() as usize % 6;
        if part.cells(layer).next().is_none() {
            continue;
        }
        steps += 1;
        let extent = Extent::new(&part, layer, &[1, 1, 2, 4]);
        let process = ProcessParameters {
            plate_c: (!rng.next_u64().is_multiple_of(4)).then_some(80.0),
            ..ProcessParameters::default()
        };
        let coefficients = Coefficients::new(&part.frame, &ThermalMaterial::abs(), &process);
        let side = 1 << (rng.next_u64() % 3);
        let blocks = Blocks::new(&part, &extent, side);
        let coarse = Blocks::new(&part, &extent, 2 * side);
        assert_eq!(blocks.coarser(&extent).levels, coarse.levels);
        let step_s = (0.2 + unit(&mut rng)) * 0.16 * f64::from(side * side);
        let levels = extent.levels.len();
        let moving = levels.min(2 + rng.next_u64() as usize % 3);
        let level_k: Vec<f64> = (0..moving).map(|_| 40.0 + 60.0 * unit(&mut rng)).collect();
        let stepper = Stepper::new(&blocks, &coefficients, &level_k, step_s);
        let mut random = |level: &LevelBlocks, scale: f64| -> Vec<f32> {
            let value = |&voxels: &f32| {
                if voxels > 0.0 { (scale * unit(&mut rng)) as f32 } else { 0.0 }
            };
            level.voxels.iter().map(value).collect()
        };
        let theta = blocks.levels.iter().map(|level| random(level, 200.0)).collect();
        let deposited = random(&blocks.levels[0], 1.0);
        let open_sides = random(&blocks.levels[0], 4.0);
        let mut state = State { theta, deposited, open_sides };
        let slow = slow_step(&blocks, &coefficients, &level_k, step_s, &state);
        let mut next = state.theta.clone();
        stepper.step(&mut state, &mut next, &mut Vec::new());
        for (level, (theta, slow)) in blocks.levels.iter().zip(state.theta.iter().zip(&slow)) {
            for (block, (theta, slow)) in theta.iter().zip(slow).enumerate() {
                if level.voxels[block] > 0.0 {
                    assert!((f64::from(*theta) - slow).abs() < 2e-3, "{theta} {slow}");
                }
            }
        }
    }
}

fn abs(part: &Arc<Voxels>) -> Simulation {
    let process = ProcessParameters::default();
    Simulation::new(part.clone(), &ThermalMaterial::abs(), &process, Method::default()).unwrap()
}

/// Rank of each number.
fn ranks(numbers: &[f64]) -> Vec<f64> {
    let below = |a: f64| numbers.iter().filter(|&&b| b < a).count() as f64;
    let above = |a: f64| numbers.iter().filter(|&&b| b > a).count() as f64;
    // Equal numbers share the mean of their ranks.
    numbers.iter().map(|&a| 0.5 * (below(a) - above(a) + numbers.len() as f64 - 1.0)).collect()
}

fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (ranks(a), ranks(b));
    let mean = (a.len() as f64 - 1.0) / 2.0;
    let product = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
}

/// Estimates of the orders of a layer, and their deviations by the heat equation.
fn estimates(part: &Arc<Voxels>, layer: u32) -> [Vec<f64>; 2] {
    let mut simulation = abs(part);
    let control = Control::default();
    for below in 0..layer {
        let order = Order::CONVENTIONAL.order(&part.region(below as usize).unwrap());
        simulation.deposit(below, &order, &control).unwrap();
    }
    let region = part.region(layer as usize).unwrap();
    let lines = ["scattered-5", "interleaved-4", "golden"]
        .map(|name| name.parse::<Sequence>().unwrap())
        .into_iter()
        .flat_map(LineOrder::all_of)
        .map(Order::from);
    let orders: Vec<Vec<Cell>> = Pattern::ALL
        .map(Order::from)
        .into_iter()
        .chain(lines)
        .map(|order| order.order(&region))
        .collect();
    let proxy = LayerProxy::new(&simulation, layer, &ThermalMaterial::abs());
    let estimate = |order: &Vec<Cell>| proxy.end_std_c(&simulation.layer_events(layer, order));
    let solve = |order: &Vec<Cell>| {
        let mut fork = simulation.clone();
        fork.deposit(layer, order, &control).unwrap();
        fork.statistics().unwrap().std_c
    };
    [orders.iter().map(estimate).collect(), orders.iter().map(solve).collect()]
}

#[test]
fn orders_are_ranked_as_by_the_heat_equation() {
    let l = part([40, 30, 6], |[x, y, _]| x < 15 || y < 12);
    // Most of its deviation is between layers.
    let pyramid = part([30, 30, 25], |[x, y, z]| {
        let inside = |i: u32| (z / 2..30 - z / 2).contains(&i);
        inside(x) && inside(y)
    });
    for (part, layer, minimum) in [(&l, 5, 0.99), (&pyramid, 12, 0.97), (&pyramid, 20, 0.93)] {
        let [estimated, solved] = estimates(part, layer);
        let correlation = rank_correlation(&estimated, &solved);
        assert!(correlation > minimum, "{layer}: {correlation}");
        for (estimated, solved) in estimated.iter().zip(&solved) {
            assert!((estimated / solved - 1.0).abs() < 0.3, "{estimated} {solved}");
        }
    }
}

#[test]
fn mirrored_orders_cost_the_same() {
    let square = part([12, 12, 3], |_| true);
    let proxy = LayerProxy::new(&abs(&square), 0, &ThermalMaterial::abs());
    let simulation = abs(&square);
    let region = square.region(0).unwrap();
    let of = |name: &str| {
        let order: Order = name.parse().unwrap();
        proxy.end_std_c(&simulation.layer_events(0, &order.order(&region)))
    };
    let first = of("lines-x-scattered-3-0");
    for other in ["lines-x-scattered-3-3", "lines-y-scattered-3-0", "lines-y-scattered-3-2"] {
        assert!((of(other) / first - 1.0).abs() < 1e-4, "{other}");
    }
}

#[test]
fn parts_of_any_shape_have_an_estimate() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    for _ in 0..300 {
        let part = random_part(&mut rng);
        let mut simulation = abs(&part);
        for layer in 0..6_u32 {
            if part.cells(layer as usize).next().is_none() {
                continue;
            }
            let order = Order::CONVENTIONAL.order(&part.region(layer as usize).unwrap());
            let proxy = LayerProxy::new(&simulation, layer, &ThermalMaterial::abs());
            let estimate = proxy.end_std_c(&simulation.layer_events(layer, &order));
            assert!(estimate.is_finite() && (0.0..200.0).contains(&estimate), "{estimate}");
            simulation.deposit(layer, &order, &Control::default()).unwrap();
        }
    }
}
