//! Strains of sheets against closed forms and a dense solver.

use proptest::prelude::*;

use super::*;

/// The displacements by Gaussian elimination; a weak spring at each corner keeps the sheet in
/// place.
fn dense(membrane: &Membrane, thickness: &[f64], free: &[Strain]) -> Vec<[f64; 2]> {
    let size = 2 * membrane.displacement.len();
    let solid = membrane.blocks.iter().map(|&block| thickness[block]).filter(|&t| t > 0.0);
    let soft = SOFT * solid.clone().sum::<f64>() / solid.count().max(1) as f64;
    let mut rows = vec![vec![0.0; size + 1]; size];
    for (i, row) in rows.iter_mut().enumerate() {
        row[i] = 1e-9;
    }
    for &block in &membrane.blocks {
        let corners = membrane.corners(block);
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            rows[2 * corners[i / 2] + i % 2][2 * corners[j / 2] + j % 2] +=
                thickness[block].max(soft) * membrane.element.stiffness[i][j];
        }
        for (i, load) in membrane.element.load.iter().enumerate() {
            let force: f64 = (0..3).map(|j| load[j] * free[block][j]).sum();
            rows[2 * corners[i / 2] + i % 2][size] += thickness[block] * force;
        }
    }
    for i in 0..size {
        let pivot = rows[i].clone();
        for (j, row) in rows.iter_mut().enumerate() {
            let factor = row[i] / pivot[i];
            if j != i && factor != 0.0 {
                row.iter_mut().zip(&pivot).for_each(|(a, b)| *a -= factor * b);
            }
        }
    }
    (0..size / 2)
        .map(|i| [0, 1].map(|axis| rows[2 * i + axis][size] / rows[2 * i + axis][2 * i + axis]))
        .collect()
}

fn assert_near(a: Strain, b: Strain, tolerance: f64) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance), "{a:?} is not {b:?}");
}

#[test]
fn a_uniform_strain_is_not_resisted() {
    let uniform = [-0.002, 0.001, 0.0005];
    let thickness: Vec<f64> = (0..70).map(|block| f64::from(block % 5 + 1)).collect();
    let mut membrane = Membrane::new(10, 7, |block| block % 10 < 4 || block / 10 > 3);
    membrane.solve(&thickness, &[uniform; 70]);
    for &block in &membrane.blocks {
        assert_near(membrane.strain(block), uniform, 1e-6);
    }
}

#[test]
fn a_strip_follows_strains_across_it_and_averages_those_along_it() {
    // Isotropic thermal strains of a long strip that vary across it only, symmetrically, so that it
    // does not bend in its plane.
    let (length, width) = (80, 7);
    let thermal = |block: usize| f64::from([0, 5, 2, 9, 2, 5, 0][block / length]) * 1e-4;
    let free: Vec<Strain> =
        (0..length * width).map(|block| [thermal(block), thermal(block), 0.0]).collect();
    let mut membrane = Membrane::new(length, width, |_| true);
    membrane.solve(&vec![3.0; length * width], &free);
    let mean = 23.0 / 7.0 * 1e-4;
    for row in 0..width {
        let block = row * length + length / 2;
        let across = thermal(block) + POISSON * (thermal(block) - mean);
        assert_near(membrane.strain(block), [mean, across, 0.0], 3e-6);
    }
}

#[test]
fn sheets_without_solid_blocks_are_at_rest() {
    let mut membrane = Membrane::new(3, 2, |_| true);
    membrane.solve(&[0.0; 6], &[[1.0; 3]; 6]);
    assert_near(membrane.strain(4), [0.0; 3], 0.0);
    let mut none = Membrane::new(3, 2, |_| false);
    none.solve(&[1.0; 6], &[[1.0; 3]; 6]);
    Membrane::new(0, 0, |_| true).solve(&[], &[]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn strains_are_those_of_a_dense_solver(
        columns in 1..6_usize,
        rows in 1..5_usize,
        blocks in prop::collection::vec((0..4_u8, -9..9_i8, -9..9_i8, -9..9_i8), 30),
    ) {
        // A comb, which is connected.
        let inside = |block: usize| block / columns == 0 || (block % columns).is_multiple_of(2);
        let mut membrane = Membrane::new(columns, rows, inside);
        membrane.tolerance = 1e-9;
        let thickness: Vec<f64> =
            blocks[..columns * rows].iter().map(|block| f64::from(block.0)).collect();
        let free: Vec<Strain> = blocks[..columns * rows]
            .iter()
            .map(|block| [block.1, block.2, block.3].map(|i| f64::from(i) * 1e-3))
            .collect();
        membrane.solve(&thickness, &free);
        let mut slow = membrane.clone();
        slow.displacement = dense(&membrane, &thickness, &free);
        for &block in membrane.blocks.iter().filter(|&&block| thickness[block] > 0.0) {
            let (fast, slow) = (membrane.strain(block), slow.strain(block));
            for (a, b) in fast.into_iter().zip(slow) {
                prop_assert!((a - b).abs() < 1e-6, "{a} {b}");
            }
        }
    }
}
