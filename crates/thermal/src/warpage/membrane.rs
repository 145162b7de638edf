//! In-plane strains of a flat sheet whose blocks shrink by different amounts.
//!
//! The sheet is in plane stress, free at its outline, and slides on what keeps it flat.
//! Each block has a thickness and a stress-free strain; the sheet takes the displacements of
//! minimum elastic energy, computed with one bilinear finite element per block.
//!
//! Far from the outline, a sheet of even thickness whose isotropic stress-free strain varies along
//! one axis only follows it along that axis, (1 + ν) times, and takes its mean along the other one.
//! So a line of beads shrinks across its length almost on its own, but along its length only with
//! the rest of the part.

/// Strain in the plane: along x, along y, and the shear component of the tensor (half the change of
/// the angle).
pub(super) type Strain = [f64; 3];

/// Poisson's ratio; typical of glassy polymers.
pub(super) const POISSON: f64 = 0.35;

/// Thickness of a block that carries no stress, as a fraction of the mean thickness of the others.
///
/// It makes strains defined in these blocks, and is too small to matter in the others.
const SOFT: f64 = 1e-3;

/// Default of [`Membrane::tolerance`].
const TOLERANCE: f64 = 1e-4;

/// Maximum number of iterations of one solution.
const MAX_ITERATIONS: usize = 400;

/// A sheet of square blocks, and its displacements.
#[derive(Clone, Debug)]
pub(super) struct Membrane {
    columns: usize,
    /// Blocks of the part, by number: row times columns plus column.
    blocks: Vec<usize>,
    /// Displacements of the corners of blocks along x and y, in blocks: the start of the next
    /// iteration.
    displacement: Vec<[f64; 2]>,
    element: Element,
    /// Residual at which the iteration stops, as a fraction of the load.
    pub(super) tolerance: f64,
}

/// Matrices of a square element with side, thickness and Young's modulus 1.
#[derive(Clone, Debug)]
struct Element {
    stiffness: [[f64; 8]; 8],
    /// Forces per stress-free strain.
    load: [[f64; 3]; 8],
}

/// Signs of the four corners of an element along x and y.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];

/// Derivatives of the shape function of a corner along x and y, at a point of an element.
fn gradient(corner: usize, [x, y]: [f64; 2]) -> [f64; 2] {
    let [along_x, along_y] = CORNERS[corner];
    [along_x * (1.0 + along_y * y) / 2.0, along_y * (1.0 + along_x * x) / 2.0]
}

fn dot(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum()
}

/// Adds a multiple of one vector to another.
fn add(to: &mut [[f64; 2]], factor: f64, from: &[[f64; 2]]) {
    for (to, from) in to.iter_mut().zip(from) {
        to[0] += factor * from[0];
        to[1] += factor * from[1];
    }
}

impl Element {
    fn new() -> Self {
        let scale = 1.0 / (1.0 - POISSON * POISSON);
        // Stress of a strain; the shear strain is the tensor's, so its modulus is E / (1 + ν).
        let stress = |[x, y, shear]: Strain| {
            [scale * (x + POISSON * y), scale * (y + POISSON * x), shear / (1.0 + POISSON)]
        };
        // Strain of a unit displacement of degree of freedom `i`.
        let strain = |i: usize, at: [f64; 2]| {
            let [along_x, along_y] = gradient(i / 2, at);
            if i.is_multiple_of(2) {
                [along_x, 0.0, along_y / 2.0]
            } else {
                [0.0, along_y, along_x / 2.0]
            }
        };
        // The shear component occurs twice in the energy.
        let work = |a: Strain, b: Strain| a[0] * b[0] + a[1] * b[1] + 2.0 * a[2] * b[2];
        let (mut stiffness, mut load) = ([[0.0; 8]; 8], [[0.0; 3]; 8]);
        let gauss = 1.0 / 3.0_f64.sqrt();
        for corner in CORNERS {
            let at = corner.map(|sign| sign * gauss);
            for i in 0..8 {
                for (j, stiffness) in stiffness[i].iter_mut().enumerate() {
                    *stiffness += work(strain(i, at), stress(strain(j, at))) / 4.0;
                }
                for (j, load) in load[i].iter_mut().enumerate() {
                    let mut unit = [0.0; 3];
                    unit[j] = 1.0;
                    *load += work(strain(i, at), stress(unit)) / 4.0;
                }
            }
        }
        Self { stiffness, load }
    }
}

impl Membrane {
    /// A sheet of the given blocks of a grid of `columns` x `rows`, at rest.
    pub(super) fn new(columns: usize, rows: usize, inside: impl Fn(usize) -> bool) -> Self {
        let blocks = (0..columns * rows).filter(|&block| inside(block)).collect();
        let displacement = vec![[0.0; 2]; (columns + 1) * (rows + 1)];
        Self { columns, blocks, displacement, element: Element::new(), tolerance: TOLERANCE }
    }

    /// Numbers of the corners of a block.
    fn corners(&self, block: usize) -> [usize; 4] {
        let first = block / self.columns * (self.columns + 1) + block % self.columns;
        [first, first + 1, first + self.columns + 1, first + self.columns + 2]
    }

    /// Computes the displacements, given thickness and stress-free strain of each block; a block
    /// without thickness carries no stress.
    ///
    /// Conjugate gradients with the diagonal as preconditioner, from the previous displacements.
    /// Each iteration costs the number of blocks.
    pub(super) fn solve(&mut self, thickness: &[f64], free: &[Strain]) {
        let solid = self.blocks.iter().map(|&block| thickness[block]).filter(|&t| t > 0.0);
        let (sum, count) = solid.fold((0.0, 0.0), |(sum, count), t| (sum + t, count + 1.0));
        if count == 0.0 {
            self.displacement.fill([0.0; 2]);
            return;
        }
        let soft = SOFT * sum / count;
        let size = self.displacement.len();
        let (mut load, mut diagonal) = (vec![[0.0; 2]; size], vec![[0.0; 2]; size]);
        for &block in &self.blocks {
            for (i, corner) in self.corners(block).into_iter().enumerate() {
                for axis in 0..2 {
                    let row = 2 * i + axis;
                    let stiffness = self.element.stiffness[row][row];
                    diagonal[corner][axis] += thickness[block].max(soft) * stiffness;
                    let force: f64 =
                        self.element.load[row].iter().zip(&free[block]).map(|(a, b)| a * b).sum();
                    load[corner][axis] += thickness[block] * force;
                }
            }
        }
        let precondition = |residual: &[[f64; 2]], out: &mut [[f64; 2]]| {
            let divide = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
            for ((out, r), d) in out.iter_mut().zip(residual).zip(&diagonal) {
                *out = [divide(r[0], d[0]), divide(r[1], d[1])];
            }
        };
        let mut scaled = vec![[0.0; 2]; size];
        precondition(&load, &mut scaled);
        let target = self.tolerance * self.tolerance * dot(&load, &scaled);
        let mut product = vec![[0.0; 2]; size];
        self.multiply(thickness, soft, &self.displacement, &mut product);
        let mut residual = load;
        add(&mut residual, -1.0, &product);
        precondition(&residual, &mut scaled);
        let mut direction = scaled.clone();
        let mut error = dot(&residual, &scaled);
        for _ in 0..MAX_ITERATIONS {
            // Also stops without load.
            if error <= target {
                break;
            }
            self.multiply(thickness, soft, &direction, &mut product);
            let step = error / dot(&direction, &product);
            add(&mut self.displacement, step, &direction);
            add(&mut residual, -step, &product);
            precondition(&residual, &mut scaled);
            let before = std::mem::replace(&mut error, dot(&residual, &scaled));
            for (direction, scaled) in direction.iter_mut().zip(&scaled) {
                let turn = error / before;
                *direction = [scaled[0] + turn * direction[0], scaled[1] + turn * direction[1]];
            }
        }
    }

    /// Forces at all corners that displacements cause.
    fn multiply(&self, thickness: &[f64], soft: f64, u: &[[f64; 2]], forces: &mut [[f64; 2]]) {
        forces.fill([0.0; 2]);
        for &block in &self.blocks {
            let corners = self.corners(block);
            let thickness = thickness[block].max(soft);
            let mut local = [0.0; 8];
            for (i, corner) in corners.into_iter().enumerate() {
                [local[2 * i], local[2 * i + 1]] = u[corner].map(|u| thickness * u);
            }
            for (i, corner) in corners.into_iter().enumerate() {
                for (axis, force) in forces[corner].iter_mut().enumerate() {
                    let row = &self.element.stiffness[2 * i + axis];
                    *force += row.iter().zip(&local).map(|(a, b)| a * b).sum::<f64>();
                }
            }
        }
    }

    /// Strain at the centre of a block of the part.
    pub(super) fn strain(&self, block: usize) -> Strain {
        let mut strain = [0.0; 3];
        for (i, corner) in self.corners(block).into_iter().enumerate() {
            let ([along_x, along_y], [u, v]) = (gradient(i, [0.0; 2]), self.displacement[corner]);
            strain[0] += along_x * u;
            strain[1] += along_y * v;
            strain[2] += f64::midpoint(along_y * u, along_x * v);
        }
        strain
    }
}

#[cfg(test)]
mod tests;
