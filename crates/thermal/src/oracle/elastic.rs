//! Three-dimensional thermoelasticity of a growing part, to test the warpage estimate against.
//!
//! One finite element with eight nodes per voxel, isotropic and linear elastic.
//! A voxel above the glass transition carries (nearly) no stress; when it cools below, it has no
//! stress at the strain that it has at that time.
//! Each sample is a solution for all displacements by conjugate gradients: some 10⁴ times as slow
//! as the estimate.

use beadwork_part::slice::Voxels;
use ndarray::Array3;

use crate::material::ThermalMaterial;
use crate::simulation::Simulation;

/// Strain: the normal components along x, y and z, then the angles yz, xz and xy.
type Strain = [f64; 6];

/// Poisson's ratio.
const POISSON: f64 = 0.35;
/// Stiffness of a voxel above the glass transition, relative to a solid one.
const SOFT: f64 = 1e-4;
/// Stiffness of a spring at each node that keeps a part in place that nothing holds.
const SPRING: f64 = 1e-8;

/// How the plate holds the part while it is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// The bottom stays flat, and slides.
    Sliding,
    /// The bottom does not move.
    Bonded,
    /// The part bends freely.
    None,
}

/// A part with the strains that are locked into it so far.
#[derive(Clone, Debug)]
pub struct ElasticPrint {
    support: Support,
    /// Voxels along x, y and z.
    size: [usize; 3],
    /// Sides of a voxel, m.
    sides_m: [f64; 3],
    expansion: f64,
    transition_c: f64,
    element: Element,
    /// Strain at which each voxel locked, and whether it is locked.
    locked: Vec<Option<Strain>>,
    /// Displacements of all nodes, m.
    displacement: Vec<[f64; 3]>,
}

/// The released and cooled part.
#[derive(Clone, Copy, Debug)]
pub struct ElasticShape {
    /// Curvatures of the paraboloid that fits the bottom best, along x and y, 1/m.
    pub curvatures_1_m: [f64; 2],
    /// Maximum height of the outline of the bottom above its lowest point, mm.
    pub lift_mm: f64,
}

#[derive(Clone, Debug)]
struct Element {
    stiffness: Vec<[f64; 24]>,
    /// Forces per stress-free strain.
    load: Vec<Strain>,
    /// Strain at the centre per displacement.
    centre: [[f64; 24]; 6],
}

impl Element {
    fn new(sides: [f64; 3]) -> Self {
        let lame = POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
        let shear = 0.5 / (1.0 + POISSON);
        let mut elasticity = [[0.0; 6]; 6];
        for i in 0..3 {
            (0..3).for_each(|j| elasticity[i][j] = lame);
            elasticity[i][i] += 2.0 * shear;
            elasticity[i + 3][i + 3] = shear;
        }
        let strains = |at: [f64; 3]| {
            let mut strains = [[0.0; 24]; 6];
            for node in 0..8 {
                let sign = [0, 1, 2].map(|axis| if node >> axis & 1 == 0 { -1.0 } else { 1.0 });
                let shape = [0, 1, 2].map(|axis| f64::midpoint(1.0, sign[axis] * at[axis]));
                let slope = [0, 1, 2].map(|axis| sign[axis] / sides[axis]);
                let [x, y, z] = [
                    slope[0] * shape[1] * shape[2],
                    shape[0] * slope[1] * shape[2],
                    shape[0] * shape[1] * slope[2],
                ];
                let at = 3 * node;
                (strains[0][at], strains[1][at + 1], strains[2][at + 2]) = (x, y, z);
                (strains[3][at + 1], strains[3][at + 2]) = (z, y);
                (strains[4][at], strains[4][at + 2]) = (z, x);
                (strains[5][at], strains[5][at + 1]) = (y, x);
            }
            strains
        };
        let (mut stiffness, mut load) = (vec![[0.0; 24]; 24], vec![[0.0; 6]; 24]);
        let weight = sides.iter().product::<f64>() / 8.0;
        let gauss = 1.0 / 3.0_f64.sqrt();
        for point in 0..8 {
            let at = [0, 1, 2].map(|axis| if point >> axis & 1 == 0 { -gauss } else { gauss });
            let strains = strains(at);
            for i in 0..24 {
                for k in 0..6 {
                    let stress: f64 = (0..6).map(|l| strains[l][i] * elasticity[l][k]).sum();
                    load[i][k] += weight * stress;
                    (0..24).for_each(|j| stiffness[i][j] += weight * stress * strains[k][j]);
                }
            }
        }
        Self { stiffness, load, centre: strains([0.0; 3]) }
    }
}

impl ElasticPrint {
    /// A full cuboid of which nothing is printed yet.
    pub fn new(part: &Voxels, material: &ThermalMaterial, support: Support) -> Self {
        let size = [part.frame.width as usize, part.frame.height as usize, part.depth];
        let (cell_m, layer_m) = (part.frame.cell_mm / 1e3, part.frame.layer_mm / 1e3);
        let sides_m = [cell_m, cell_m, layer_m];
        Self {
            support,
            size,
            sides_m,
            expansion: material.expansion_per_k,
            transition_c: material.glass_transition_c,
            element: Element::new(sides_m),
            locked: vec![None; size.iter().product()],
            displacement: vec![[0.0; 3]; size.iter().map(|n| n + 1).product()],
        }
    }

    fn nodes(&self, voxel: usize) -> [usize; 8] {
        let [width, height, _] = self.size;
        let (x, y, z) = (voxel % width, voxel / width % height, voxel / width / height);
        std::array::from_fn(|node| {
            let (x, y, z) = (x + (node & 1), y + (node >> 1 & 1), z + (node >> 2));
            (z * (height + 1) + y) * (width + 1) + x
        })
    }

    /// Locks the voxels below the glass transition, and unlocks those above.
    pub fn sample(&mut self, simulation: &Simulation) {
        self.step(&simulation.temperatures_c(), self.transition_c);
    }

    fn step(&mut self, celsius: &Array3<f64>, max_c: f64) {
        let celsius = celsius.as_standard_layout();
        let celsius = celsius.as_slice().expect("a standard array is a slice");
        let (mut stiffness, mut free) = (vec![0.0; celsius.len()], vec![[0.0; 6]; celsius.len()]);
        for (voxel, &celsius) in celsius.iter().enumerate().filter(|(_, celsius)| !celsius.is_nan())
        {
            if celsius > max_c {
                self.locked[voxel] = None;
            }
            stiffness[voxel] = SOFT;
            if let Some(mut strain) = self.locked[voxel] {
                let thermal = self.expansion * (celsius.min(self.transition_c) - self.transition_c);
                strain[..3].iter_mut().for_each(|strain| *strain += thermal);
                (stiffness[voxel], free[voxel]) = (1.0, strain);
            }
        }
        self.solve(&stiffness, &free, self.support, 1e-4);
        for (voxel, &celsius) in celsius.iter().enumerate() {
            if celsius <= max_c && self.locked[voxel].is_none() {
                self.locked[voxel] = Some(self.strain(voxel));
            }
        }
    }

    /// Locks all voxels, takes the part off the plate and cools it to one temperature.
    pub fn finish(mut self, simulation: &Simulation) -> ElasticShape {
        self.sample(simulation);
        self.step(&simulation.temperatures_c(), f64::INFINITY);
        let free: Vec<Strain> =
            self.locked.iter().map(|strain| strain.expect("all voxels are locked")).collect();
        self.solve(&vec![1.0; free.len()], &free, Support::None, 1e-7);
        self.shape()
    }

    fn strain(&self, voxel: usize) -> Strain {
        let nodes = self.nodes(voxel);
        self.element.centre.map(|row| {
            let terms = (0..24).map(|i| row[i] * self.displacement[nodes[i / 3]][i % 3]);
            terms.sum()
        })
    }

    /// Conjugate gradients with the diagonal as preconditioner.
    fn solve(&mut self, stiffness: &[f64], free: &[Strain], support: Support, tolerance: f64) {
        let size = 3 * self.displacement.len();
        let bottom = (self.size[0] + 1) * (self.size[1] + 1);
        let is_fixed = |i: usize| match support {
            Support::Sliding => i / 3 < bottom && i % 3 == 2,
            Support::Bonded => i / 3 < bottom,
            Support::None => false,
        };
        let spring = SPRING * self.sides_m[0];
        let solid: Vec<usize> = (0..stiffness.len()).filter(|&i| stiffness[i] > 0.0).collect();
        let multiply = |u: &[f64]| {
            let mut forces: Vec<f64> = u.iter().map(|u| spring * u).collect();
            for &voxel in &solid {
                let nodes = self.nodes(voxel);
                let local: [f64; 24] =
                    std::array::from_fn(|i| stiffness[voxel] * u[3 * nodes[i / 3] + i % 3]);
                for (i, row) in self.element.stiffness.iter().enumerate() {
                    forces[3 * nodes[i / 3] + i % 3] +=
                        row.iter().zip(&local).map(|(a, b)| a * b).sum::<f64>();
                }
            }
            (0..size).filter(|&i| is_fixed(i)).for_each(|i| forces[i] = 0.0);
            forces
        };
        let (mut diagonal, mut load) = (vec![spring; size], vec![0.0; size]);
        for &voxel in &solid {
            let nodes = self.nodes(voxel);
            for i in 0..24 {
                let at = 3 * nodes[i / 3] + i % 3;
                diagonal[at] += stiffness[voxel] * self.element.stiffness[i][i];
                let force: f64 =
                    self.element.load[i].iter().zip(&free[voxel]).map(|(a, b)| a * b).sum();
                load[at] += stiffness[voxel] * force;
            }
        }
        (0..size).filter(|&i| is_fixed(i)).for_each(|i| load[i] = 0.0);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scaled =
            |a: &[f64]| -> Vec<f64> { a.iter().zip(&diagonal).map(|(a, d)| a / d).collect() };
        let mut u: Vec<f64> = self.displacement.as_flattened().to_vec();
        (0..size).filter(|&i| is_fixed(i)).for_each(|i| u[i] = 0.0);
        let product = multiply(&u);
        let mut residual: Vec<f64> = load.iter().zip(&product).map(|(a, b)| a - b).collect();
        let mut direction = scaled(&residual);
        let mut error = dot(&residual, &direction);
        let target = tolerance * tolerance * dot(&load, &scaled(&load));
        while error > target {
            let product = multiply(&direction);
            let step = error / dot(&direction, &product);
            u.iter_mut().zip(&direction).for_each(|(u, d)| *u += step * d);
            residual.iter_mut().zip(&product).for_each(|(r, p)| *r -= step * p);
            let next = scaled(&residual);
            let turn = dot(&residual, &next) / error;
            error *= turn;
            direction.iter_mut().zip(&next).for_each(|(d, n)| *d = n + turn * *d);
        }
        for (i, u) in u.into_iter().enumerate() {
            self.displacement[i / 3][i % 3] = u;
        }
    }

    fn shape(&self) -> ElasticShape {
        let [columns, rows] = [self.size[0] + 1, self.size[1] + 1];
        let bottom: Vec<[f64; 3]> = (0..columns * rows)
            .map(|node| {
                let centred = |i: usize, n: usize, side| (i as f64 - (n - 1) as f64 / 2.0) * side;
                let x = centred(node % columns, columns, self.sides_m[0]);
                [x, centred(node / columns, rows, self.sides_m[1]), self.displacement[node][2]]
            })
            .collect();
        let plane = fit(&bottom, |x, y| [1.0, x, y]);
        let paraboloid = fit(&bottom, |x, y| [1.0, x, y, x * x / 2.0, y * y / 2.0, x * y]);
        let height = |&[x, y, w]: &[f64; 3]| w - plane[0] - plane[1] * x - plane[2] * y;
        let lowest = bottom.iter().map(height).fold(f64::INFINITY, f64::min);
        let is_edge = |node: usize| {
            let (x, y) = (node % columns, node / columns);
            x == 0 || y == 0 || x + 1 == columns || y + 1 == rows
        };
        let edge = bottom.iter().enumerate().filter(|&(node, _)| is_edge(node));
        let highest = edge.map(|(_, node)| height(node)).fold(f64::NEG_INFINITY, f64::max);
        ElasticShape {
            curvatures_1_m: [paraboloid[3], paraboloid[4]],
            lift_mm: (highest - lowest) * 1e3,
        }
    }
}

/// Coefficients of the functions of x and y that fit points `[x, y, value]` best.
fn fit<const N: usize>(points: &[[f64; 3]], functions: impl Fn(f64, f64) -> [f64; N]) -> [f64; N] {
    let (mut matrix, mut right) = ([[0.0; N]; N], [0.0; N]);
    for &[x, y, value] in points {
        let functions = functions(x, y);
        for i in 0..N {
            right[i] += functions[i] * value;
            (0..N).for_each(|j| matrix[i][j] += functions[i] * functions[j]);
        }
    }
    for i in 0..N {
        let (pivot, row, of_row) = (matrix[i][i], matrix[i], right[i]);
        for j in (0..N).filter(|&j| j != i) {
            let factor = matrix[j][i] / pivot;
            (0..N).for_each(|k| matrix[j][k] -= factor * row[k]);
            right[j] -= factor * of_row;
        }
    }
    std::array::from_fn(|i| right[i] / matrix[i][i])
}
