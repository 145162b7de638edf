//! Layers of one height, of several, and programs without layers.

use proptest::prelude::*;

use super::*;

/// Beads of 10 mm at these heights.
fn program(heights_mm: &[f64]) -> Program {
    let bead = |z: &f64| format!("G1 X0 Y0 Z{z:.3} F6000\nG1 X10 E1\nG1 X0 E1\n");
    let text: String = heights_mm.iter().map(bead).collect::<Vec<_>>().concat();
    format!("M83\n{text}").parse().unwrap()
}

fn rows(heights_mm: &[f64], layer_mm: f64) -> Rows {
    Rows::of_program(&program(heights_mm), 0.5, layer_mm, &Control::default()).unwrap()
}

fn tops(thicknesses: &[f64]) -> Vec<f64> {
    let mut top = 0.0;
    let add = |&thickness: &f64| {
        top += thickness;
        top
    };
    thicknesses.iter().map(add).collect()
}

// PrusaSlicer, first_layer_height = 0.3
#[test]
fn a_first_layer_of_another_height() {
    for (first, shift, deviation) in
        [(0.3, 0, 0.1), (0.15, 0, 0.05), (0.35, 1, 0.05), (0.28, 0, 0.08)]
    {
        let heights = tops(&[first, 0.2, 0.2, 0.2, 0.2]);
        let rows = rows(&heights, 0.2);
        for (layer, &z) in heights.iter().enumerate() {
            let row = layer as i64 + shift;
            let expected = if layer == 0 { [0, 1 + shift] } else { [row, row + 1] };
            assert_eq!(rows.at(z), expected, "{first}");
        }
        let fit = rows.fit().unwrap();
        assert_eq!((fit.layers, fit.rows), (5, 5 + shift as usize));
        assert!((fit.max_deviation_mm - deviation).abs() < 1e-9, "{fit:?}");
        assert!((fit.height_mm - first - 0.8).abs() < 1e-9);
    }
    let thick = rows(&tops(&[0.3, 0.1, 0.1]), 0.1);
    assert_eq!([0.3, 0.4, 0.5].map(|z| thick.at(z)), [[0, 3], [3, 4], [4, 5]]);
    let fit = thick.fit().unwrap();
    assert!(fit.max_deviation_mm < 1e-9 && fit.volume_error.abs() < 1e-9, "{fit:?}");
}

#[test]
fn layers_of_one_height_are_rows() {
    let heights: Vec<f64> = (1..50).map(|layer| 0.2 * f64::from(layer)).collect();
    for offset in [0.0, 0.01, -0.015] {
        let shifted: Vec<f64> = heights.iter().map(|z| z + offset).collect();
        let rows = rows(&shifted, 0.2);
        assert_eq!(rows.fit(), None);
        for (row, &z) in (0..).zip(&shifted) {
            assert_eq!(rows.at(z), [row, row + 1]);
        }
    }
    // Above a support, layers are not thick.
    assert_eq!(rows(&[1.0, 1.2, 1.4], 0.2).at(1.2), [5, 6]);
    let program = "M83\nG1 Z0.2\nG1 X9 E1\nG1 X0 Z0.4 E1\nG1 X9 Z0.6 E1".parse().unwrap();
    let vase = Rows::of_program(&program, 0.5, 0.2, &Control::default()).unwrap();
    assert_eq!(vase.fit(), None, "a spiral has no layers");
    let text = "M83\nG1 Z0.3\nG1 X9 E1\nG1 X0 Z0.5 E1\nG1 X9 Z0.7 E1".parse().unwrap();
    let vase = Rows::of_program(&text, 0.5, 0.2, &Control::default()).unwrap();
    assert_eq!([0.3, 0.4, 0.5, 0.6].map(|z| vase.at(z)[0]), [0, 1, 1, 2]);
    assert!((vase.fit().unwrap().max_deviation_mm - 0.1).abs() < 1e-9);
}

#[test]
fn a_prime_line_is_no_layer() {
    let heights = tops(&[0.2; 300]);
    let mut with_line = vec![0.28];
    with_line.extend(&heights);
    assert_eq!(rows(&with_line, 0.2).fit(), None);
    let mut first_thicker = vec![0.4];
    first_thicker.extend(tops(&[0.3; 1].iter().chain(&[0.2; 299]).copied().collect::<Vec<_>>()));
    let thicker = rows(&first_thicker, 0.2);
    assert_eq!(thicker.fit().unwrap().layers, 300);
    assert_eq!(thicker.at(0.3), [0, 1]);
    assert!((thicker.left_out_mm() - 20.0).abs() < 1e-9);
    // An object in layers of another height, printed before the next one.
    let mut objects = tops(&[0.3; 3]);
    objects.extend(tops(&[0.2; 5]));
    assert!(rows(&objects, 0.2).left_out_mm().abs() < 1e-9);
}

#[test]
fn a_part_on_a_raft_begins_above_it() {
    let raft = ";TYPE:Support\nG1 Z0.3 F6000\nG1 X20 E2\n;TYPE:Perimeter\n";
    let part = program(&[0.95, 1.15, 1.35]).emit();
    let text = format!("M83\n{raft}{part}").parse().unwrap();
    let rows = Rows::of_program(&text, 0.5, 0.2, &Control::default()).unwrap();
    assert_eq!([0.95, 1.15, 1.35].map(|z| rows.at(z)), [[0, 1], [1, 2], [2, 3]]);
    assert_eq!(rows.fit(), None);
    let fit = program_fit(&text, 0.5, 0.2, &Control::default()).unwrap();
    assert!((fit.raft_mm - 0.75).abs() < 1e-9 && fit.left_out_mm == 0.0);
    let [(height, _)] = layer_heights(&text, &Control::default()).unwrap()[..] else { panic!() };
    assert!((height - 0.2).abs() < 1e-9);
}

#[test]
fn common_heights_of_layers() {
    let heights = |thicknesses: &[f64]| {
        layer_heights(&program(&tops(thicknesses)), &Control::default()).unwrap()
    };
    let [(most, share), (second, _)] = heights(&[0.3, 0.2, 0.2, 0.2])[..] else { panic!() };
    assert_eq!((most, second), (0.2, 0.3));
    assert!((share - 0.75).abs() < 1e-9);
    assert_eq!(layer_heights(&Program::default(), &Control::default()).unwrap(), []);
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_row_belongs_to_the_layer_around_its_centre(
        thicknesses in prop::collection::vec(6..40_u32, 1..30),
        layer in 8..40_u32,
    ) {
        let layer_mm = f64::from(layer) / 100.0;
        let heights = tops(&thicknesses.iter().map(|&h| f64::from(h) / 100.0).collect::<Vec<_>>());
        let rows = rows(&heights, layer_mm);
        let Some(fit) = rows.fit() else { return Ok(()) };
        prop_assert_eq!(fit.layers, thicknesses.len());
        // Rows follow each other without a gap.
        let mut end = 0;
        for &z in &heights {
            let [first, next] = rows.at(z);
            prop_assert_eq!(first, end);
            prop_assert!(next >= first);
            end = next;
        }
        prop_assert_eq!(fit.rows as i64, end);
        // The total height is off by no more than a row, and each top by one and a half.
        prop_assert!((fit.height_mm - fit.rows_mm).abs() <= layer_mm + 1e-6, "{:?}", fit);
        prop_assert!(fit.max_deviation_mm <= 1.5 * layer_mm + 1e-6, "{:?}", fit);
        // A slow twin: the row's centre, with the bottom row placed at every possible shift.
        let shifts = (0..200).map(|step| layer_mm * (f64::from(step) / 200.0 - 0.5));
        let fits = |shift: f64| {
            let mut below = 0.0;
            heights.iter().all(|&z| {
                let inside = |row: &i64| {
                    let centre = shift + layer_mm * (*row as f64 + 0.5);
                    centre > below - 2e-3 * layer_mm && centre <= z + 2e-3 * layer_mm
                };
                let [first, next] = rows.at(z);
                let all = (first..next).all(|row| inside(&row));
                below = z;
                all
            })
        };
        let found = shifts.clone().any(fits)
            || heights.iter().any(|z| {
                let part = (z / layer_mm).rem_euclid(1.0);
                fits(layer_mm * part) || fits(layer_mm * (part - 1.0))
            });
        prop_assert!(found);
    }
}
