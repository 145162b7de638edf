//! The solver against analytic solutions; `beadwork_thermal::oracle::analytic` has the table of
//! errors.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

use beadwork_thermal::oracle::analytic::Body;
use beadwork_thermal::simulation::{Accuracy, Method};

/// Maximum errors, from coarse to fine voxels.
fn errors(body: Body, method: Method, layers_mm: &[f64]) -> Vec<f64> {
    layers_mm.iter().map(|&layer_mm| body.deviation(layer_mm, method).unwrap().max).collect()
}

const REFERENCE: Method = Method::Reference { steps: 1 };

/// Each error is smaller than the one before by a factor from `min` to `max`.
fn assert_falls(errors: &[f64], min: f64, max: f64) {
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((min..=max).contains(&ratio), "{errors:?}");
    }
}

#[test]
fn a_slab_on_the_plate_follows_the_formula() {
    for method in [REFERENCE, Method::Naive] {
        let found = errors(Body::Slab, method, &[0.5, 0.25, 0.125, 0.0625]);
        assert_falls(&found, 3.5, 4.5);
        assert!(found[1] < 0.35 && found[3] < 0.03, "{found:?}");
    }
}

#[test]
fn a_deep_column_on_the_plate_follows_the_formula() {
    for method in [REFERENCE, Method::Naive] {
        let found = errors(Body::Deep, method, &[0.5, 0.25, 0.125, 0.0625]);
        assert_falls(&found, 3.5, 4.6);
        assert!(found[1] < 0.35 && found[3] < 0.03, "{found:?}");
    }
}

#[test]
fn a_cube_in_the_air_follows_the_formula() {
    let at = |surface_resistance| {
        errors(Body::Cube { surface_resistance }, REFERENCE, &[1.0, 0.5, 0.25])
    };
    let (centre, surface) = (at(false), at(true));
    // Taking the temperature at the centre for that of the surface is a first-order error.
    assert_falls(&centre, 1.8, 2.2);
    assert!(centre[2] < 1.8, "{centre:?}");
    assert_falls(&surface, 3.3, 5.5);
    assert!(surface[2] < 0.03, "{surface:?}");
}

#[test]
fn a_corner_in_the_air_follows_the_formula() {
    let at = |surface_resistance| {
        errors(Body::Corner { surface_resistance }, REFERENCE, &[1.0, 0.5, 0.25])
    };
    let (centre, surface) = (at(false), at(true));
    assert_falls(&centre, 1.4, 2.6);
    assert_falls(&surface, 2.3, 4.5);
    assert!(surface[2] < 0.2 && 3.0 * surface[2] < centre[2], "{surface:?} {centre:?}");
}

/// The fast method adds little to the error of the voxels.
#[test]
fn the_fast_method_follows_the_formulas() {
    for body in Body::ALL {
        for accuracy in [Accuracy::Standard, Accuracy::High] {
            let fast = body.deviation(0.25, Method::Fast(accuracy)).unwrap();
            let reference = body.deviation(0.25, REFERENCE).unwrap();
            assert!(fast.max < 1.1 * reference.max + 0.05, "{body:?}: {fast:?} {reference:?}");
        }
    }
}
