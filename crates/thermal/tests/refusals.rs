//! Invalid input: which error it gives, and that it changes nothing.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod common;

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_part::Frame;
use beadwork_part::slice::Voxels;
use beadwork_thermal::simulation::{Accuracy, DepositError, Method, SetupError};
use beadwork_thermal::{
    DepositionEvent, ProcessParameters, PropertyError, Simulation, ThermalMaterial,
};
use common::{bits, block, frame, part_of, run};
use ndarray::Array3;

const METHODS: [Method; 3] =
    [Method::Naive, Method::Reference { steps: 1 }, Method::Fast(Accuracy::Standard)];

/// 4 x 3 x 2 voxels without one inside the lower layer and one in a corner of the upper layer.
fn part() -> Arc<Voxels> {
    part_of(frame(4, 3), 2, |position| position != [1, 1, 0] && position != [3, 2, 1])
}

fn unprinted(method: Method) -> Simulation {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    Simulation::new(part(), &material, &process, method).unwrap()
}

fn setup(
    material: &ThermalMaterial,
    process: &ProcessParameters,
    method: Method,
) -> Result<Simulation, SetupError> {
    Simulation::new(block(3, 3, 1), material, process, method)
}

/// With some of layer 0 printed, the call must fail in the same way for all methods, and change
/// nothing.
#[track_caller]
fn refused(call: impl Fn(&mut Simulation) -> DepositError, expected: &DepositError) {
    for method in METHODS {
        let mut simulation = unprinted(method);
        let events = [born([0, 0, 0]), DepositionEvent::pause(0.1), born([1, 0, 0])];
        run(&mut simulation, &events);
        let mut untouched = simulation.clone();
        let error = call(&mut simulation);
        // NaN is not equal to itself.
        assert_eq!(format!("{error:?}"), format!("{expected:?}"), "{method:?}");
        assert_eq!(bits(&simulation), bits(&untouched), "{method:?}");
        assert_eq!(simulation.seconds().to_bits(), untouched.seconds().to_bits());
        // Later events give the same bits, too: no hidden state has changed.
        for simulation in [&mut simulation, &mut untouched] {
            run(simulation, &[born([2, 0, 0]), DepositionEvent::pause(1.0), born([2, 0, 1])]);
        }
        assert_eq!(bits(&simulation), bits(&untouched), "{method:?}, later");
    }
}

#[track_caller]
fn refused_events(events: &[DepositionEvent], expected: &DepositError) {
    let control = Control::default();
    refused(|simulation| simulation.run(events, &control).unwrap_err(), expected);
}

fn born(voxel: [u32; 3]) -> DepositionEvent {
    DepositionEvent { voxel: Some(voxel), seconds: 0.01 }
}

#[test]
fn voxels_that_are_not_part_of_the_print() {
    for voxel in [[1, 1, 0], [4, 0, 0], [0, 3, 0], [0, 0, 2], [u32::MAX; 3]] {
        refused_events(&[born([2, 0, 0]), born(voxel)], &DepositError::Outside { voxel });
    }
}

#[test]
fn voxels_twice() {
    refused_events(&[born([1, 0, 0])], &DepositError::Repeated { voxel: [1, 0, 0] });
    refused_events(
        &[born([3, 0, 0]), born([3, 0, 0])],
        &DepositError::Repeated { voxel: [3, 0, 0] },
    );
}

#[test]
fn voxels_above_nothing() {
    refused_events(
        &[born([3, 0, 1]), born([3, 0, 0])],
        &DepositError::Unsupported { voxel: [3, 0, 1] },
    );
    // Above a voxel of the same call, or above a hole in the part, is allowed.
    let mut simulation = unprinted(Method::default());
    run(&mut simulation, &[born([3, 0, 0]), born([3, 0, 1]), born([1, 1, 1])]);
}

#[test]
fn events_of_impossible_durations() {
    for seconds in [-1.0, f64::NAN, f64::INFINITY, -f64::MIN_POSITIVE] {
        let events = [born([2, 0, 0]), DepositionEvent::pause(seconds)];
        refused_events(&events, &DepositError::Duration { event: 1, seconds });
        let events = [
            born([2, 0, 0]),
            DepositionEvent::pause(0.0),
            DepositionEvent { seconds, ..born([3, 0, 0]) },
        ];
        refused_events(&events, &DepositError::Duration { event: 2, seconds });
    }
    refused_events(
        &[DepositionEvent { seconds: 0.0, ..born([2, 0, 0]) }],
        &DepositError::Duration { event: 0, seconds: 0.0 },
    );
}

#[test]
fn events_too_long_for_the_naive_method() {
    let mut simulation = unprinted(Method::Naive);
    let limit = simulation.max_stable_step_s();
    run(&mut simulation, &[born([0, 0, 0]), DepositionEvent::pause(10.0)]);
    let before = bits(&simulation);
    let seconds = limit * 1.001;
    let events = [born([1, 0, 0]), DepositionEvent { seconds, ..born([2, 0, 0]) }];
    let error = simulation.run(&events, &Control::default()).unwrap_err();
    assert_eq!(error, DepositError::Unstable { voxel: [2, 0, 0], seconds, limit });
    assert_eq!(bits(&simulation), before);
    run(&mut simulation, &[DepositionEvent { seconds: limit, ..born([2, 0, 0]) }]);
}

#[test]
fn orders_of_a_layer() {
    let order = |order: &'static [u32], layer| {
        move |s: &mut Simulation| s.deposit(layer, order, &Control::default()).unwrap_err()
    };
    // Layer 0 of this part has cells 0 to 11 without 5; 0 and 1 are printed.
    refused(order(&[2, 3, 1], 0), &DepositError::Repeated { voxel: [1, 0, 0] });
    refused(order(&[2, 3, 5], 0), &DepositError::Outside { voxel: [1, 1, 0] });
    refused(order(&[2, 3, 12], 0), &DepositError::Outside { voxel: [0, 3, 0] });
    refused(order(&[0, 1, 4], 1), &DepositError::Unsupported { voxel: [0, 1, 1] });
    refused(order(&[2], 9), &DepositError::Outside { voxel: [2, 0, 9] });
    for method in METHODS {
        let (mut simulation, control) = (unprinted(method), Control::default());
        let empty = bits(&simulation);
        let mut deposit = |layer, order: &[u32]| simulation.deposit(layer, order, &control);
        let error = deposit(0, &[0, 1, 2, 3, 4, 6, 7, 8, 9, 11]).unwrap_err();
        assert_eq!(error, DepositError::Missing { voxel: [2, 2, 0] });
        let error = deposit(0, &[0, 1, 2, 3, 4, 6, 7, 8, 9, 11, 9]).unwrap_err();
        assert_eq!(error, DepositError::Repeated { voxel: [1, 2, 0] });
        // A layer that the part does not have has no cells to print.
        assert_eq!(deposit(2, &[]), Ok(0.0));
        assert_eq!(bits(&simulation), empty);
        simulation.deposit(0, &[0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11], &control).unwrap();
    }
}

#[test]
fn properties_of_materials() {
    type Set = fn(&mut ThermalMaterial, f64);
    let positive: [(&str, Set); 3] = [
        ("conductivity_w_mk", |material, value| material.conductivity_w_mk = value),
        ("specific_heat_j_kgk", |material, value| material.specific_heat_j_kgk = value),
        ("density_kg_m3", |material, value| material.density_kg_m3 = value),
    ];
    for (name, set) in positive {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut material = ThermalMaterial::abs();
            set(&mut material, value);
            let error =
                setup(&material, &ProcessParameters::default(), Method::default()).unwrap_err();
            assert!(
                matches!(
                    error,
                    SetupError::Property(PropertyError::NotPositive { property, .. })
                        if property == name
                ),
                "{error:?}"
            );
        }
    }
    let ranges: [(&str, Set); 3] = [
        ("emissivity", |material, value| material.emissivity = value),
        ("glass_transition_c", |material, value| material.glass_transition_c = value),
        ("expansion_per_k", |material, value| material.expansion_per_k = value),
    ];
    for (name, set) in ranges {
        for value in [-300.0, 2000.0, f64::NAN, f64::INFINITY] {
            let mut material = ThermalMaterial::abs();
            set(&mut material, value);
            let error =
                setup(&material, &ProcessParameters::default(), Method::default()).unwrap_err();
            assert!(
                matches!(
                    error,
                    SetupError::Property(PropertyError::OutOfRange { property, .. })
                        if property == name
                ),
                "{error:?}"
            );
        }
    }
}

#[test]
fn settings_of_processes() {
    type Set = fn(&mut ProcessParameters, f64);
    let ranges: [(&str, Set); 4] = [
        ("extrusion_c", |process, value| process.extrusion_c = value),
        ("plate_c", |process, value| process.plate_c = Some(value)),
        ("ambient_c", |process, value| process.ambient_c = value),
        ("convection_w_m2k", |process, value| process.convection_w_m2k = value),
    ];
    let positive: [(&str, Set); 2] = [
        ("print_mm_s", |process, value| process.print_mm_s = value),
        ("travel_mm_s", |process, value| process.travel_mm_s = Some(value)),
    ];
    for (name, set) in ranges.into_iter().chain(positive) {
        for value in [-300.0, f64::NAN, f64::INFINITY] {
            let mut process = ProcessParameters::default();
            set(&mut process, value);
            let error = setup(&ThermalMaterial::abs(), &process, Method::default()).unwrap_err();
            let SetupError::Property(
                PropertyError::NotPositive { property, .. }
                | PropertyError::OutOfRange { property, .. },
            ) = error
            else {
                panic!("{name} {value}: {error:?}");
            };
            assert_eq!(property, name);
        }
    }
    for (_, set) in positive {
        let mut process = ProcessParameters::default();
        set(&mut process, 0.0);
        assert!(setup(&ThermalMaterial::abs(), &process, Method::default()).is_err());
    }
}

#[test]
fn methods_and_sizes() {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    assert_eq!(
        setup(&material, &process, Method::Reference { steps: 0 }).unwrap_err(),
        SetupError::NoSteps
    );
    let slow = ProcessParameters { print_mm_s: 5.0, ..process.clone() };
    let error = setup(&material, &slow, Method::Naive).unwrap_err();
    let SetupError::Unstable { seconds, limit } = error else { panic!("{error:?}") };
    assert!((seconds - 0.1).abs() < 1e-12 && (limit - 0.0877).abs() < 1e-4);
    for (cell_mm, layer_mm) in [(0.0, 0.25), (0.5, -0.25), (f64::NAN, 0.25), (0.5, f64::INFINITY)] {
        let frame = Frame { cell_mm, layer_mm, ..frame(2, 2) };
        let part = Arc::new(Voxels::new(frame, Array3::zeros((1, 2, 2))));
        for method in METHODS {
            let error = Simulation::new(part.clone(), &material, &process, method).unwrap_err();
            assert!(matches!(error, SetupError::Size { .. }), "{error:?}");
        }
    }
}

#[test]
#[should_panic(expected = "a pause is not possible: deposition event 0 lasts -1 s")]
fn negative_pauses() {
    _ = unprinted(Method::default()).pause(-1.0, &Control::default());
}
