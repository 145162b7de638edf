//! Temperatures of whole parts as arrays.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod common;

use beadwork_thermal::Simulation;
use beadwork_thermal::simulation::{Accuracy, FieldError, Method};
use common::{Print, Random, bits, field, pause, run};
use ndarray::Array3;

const METHODS: [Method; 4] = [
    Method::Naive,
    Method::Reference { steps: 1 },
    Method::Fast(Accuracy::Standard),
    Method::Fast(Accuracy::High),
];

/// A random print of which some events are done, and its other events.
fn half_printed(seed: u64, method: Method) -> (Simulation, Print, usize) {
    let mut random = Random::new(seed);
    let print = Print::random(&mut random, [40, 24, 5]);
    let done = random.between(1, print.events.len() - 1);
    let mut simulation = print.empty(method);
    run(&mut simulation, &print.events[..done]);
    (simulation, print, done)
}

#[test]
fn arrays_have_the_temperatures_of_single_voxels() {
    for seed in 0..20 {
        let (simulation, print, _) = half_printed(seed, Method::default());
        let celsius = simulation.temperatures_c();
        let (depth, frame) = (print.part.depth, print.part.frame);
        assert_eq!(celsius.dim(), (depth, frame.height as usize, frame.width as usize));
        for ((z, y, x), own) in celsius.indexed_iter() {
            let expected = simulation.temperature_c([x as u32, y as u32, z as u32]);
            assert_eq!(own.to_bits(), expected.unwrap_or(f64::NAN).to_bits());
        }
        for (z, expected) in celsius.outer_iter().enumerate() {
            let layer = simulation.layer_temperatures_c(z as u32);
            assert_eq!(layer.dim(), expected.dim());
            let pairs = layer.iter().zip(&expected);
            assert!(pairs.into_iter().all(|(a, b)| a.to_bits() == b.to_bits()));
        }
        let outside = simulation.layer_temperatures_c(depth as u32);
        assert_eq!(outside.dim(), (frame.height as usize, frame.width as usize));
        assert!(outside.iter().all(|celsius| celsius.is_nan()));
        assert!(print.empty(Method::default()).temperatures_c().iter().all(|c| c.is_nan()));
    }
}

#[test]
fn a_field_that_was_read_is_restored_to_the_bit() {
    for seed in 0..12 {
        for method in METHODS {
            let (mut one, print, done) = half_printed(seed, method);
            let mut other = one.clone();
            let read = one.temperatures_c();
            // Other temperatures in between must leave no trace.
            other.set_temperatures_c(read.mapv(|celsius| celsius + 3.5).view()).unwrap();
            assert_ne!(bits(&one), bits(&other));
            other.set_temperatures_c(read.view()).unwrap();
            assert_eq!(bits(&one), bits(&other));
            for simulation in [&mut one, &mut other] {
                run(simulation, &print.events[done..]);
                pause(simulation, 3.0);
            }
            assert_eq!(bits(&one), bits(&other), "print {seed}, {method:?}");
        }
    }
}

/// The simulation stores differences from the air temperature; very small ones are rounded when
/// they are converted to °C.
#[test]
fn temperatures_near_that_of_the_air_are_restored_nearly() {
    for seed in 0..8 {
        let (mut simulation, ..) = half_printed(seed, Method::Fast(Accuracy::High));
        pause(&mut simulation, 3000.0);
        let before = field(&simulation);
        simulation.set_temperatures_c(simulation.temperatures_c().view()).unwrap();
        for (a, b) in before.iter().zip(field(&simulation)) {
            assert!(a.is_nan() == b.is_nan() && (a.is_nan() || (a - b).abs() <= 1e-13), "{a} {b}");
        }
    }
}

#[test]
fn a_print_goes_on_from_a_field() {
    let (mut simulation, mut print, _) = half_printed(5, Method::default());
    print.process.plate_c = None;
    let mut events = print.events.iter().filter(|event| event.voxel.is_some());
    let first = [*events.next().unwrap(), *events.next().unwrap()];
    for method in METHODS {
        let mut cold = print.empty(method);
        run(&mut cold, &first);
        let ambient_c = print.process.ambient_c;
        cold.set_temperatures_c(Array3::from_elem(cold.temperatures_c().dim(), ambient_c).view())
            .unwrap();
        pause(&mut cold, 1.0);
        let all = cold.statistics().unwrap();
        assert!(all.count == 2 && (all.max_c - ambient_c).abs() < 1e-9, "{all:?}");
    }
    // A clone has its own temperatures.
    let before = bits(&simulation);
    let mut clone = simulation.clone();
    let warmer = simulation.temperatures_c() + 1.0;
    clone.set_temperatures_c(warmer.view()).unwrap();
    assert_eq!(bits(&simulation), before);
    assert!(
        (clone.statistics().unwrap().mean_c - simulation.statistics().unwrap().mean_c - 1.0).abs()
            < 1e-4
    );
    let order = [simulation.seconds(), clone.seconds()];
    assert_eq!(order[0].to_bits(), order[1].to_bits());
    pause(&mut simulation, 0.1);
}

#[test]
fn wrong_fields_are_refused() {
    let (mut simulation, print, _) = half_printed(7, Method::default());
    let before = bits(&simulation);
    let good = simulation.temperatures_c();
    let (depth, height, width) = good.dim();
    let transposed = good.clone().reversed_axes();
    let error = simulation.set_temperatures_c(transposed.view()).unwrap_err();
    let expected = [depth, height, width];
    assert_eq!(error, FieldError::Shape { found: [width, height, depth], expected });
    assert_eq!(
        error.to_string(),
        format!(
            "temperature field has shape [{width}, {height}, {depth}]: the part has [{depth}, \
             {height}, {width}] layers, rows and columns"
        )
    );

    let voxel @ [x, y, z] = print.events.iter().find_map(|event| event.voxel).unwrap();
    for wrong in [f64::NAN, f64::INFINITY, -300.0, 1000.1] {
        let mut field = good.clone();
        field[[z as usize, y as usize, x as usize]] = wrong;
        let error = simulation.set_temperatures_c(field.view()).unwrap_err();
        let message = format!(
            "voxel {voxel:?} has a temperature of {wrong} °C: it must be from -273.15 to 1000"
        );
        assert_eq!(error.to_string(), message);
    }
    assert_eq!(bits(&simulation), before);

    // Values where nothing is deposited do not matter.
    let filled = good.mapv(|celsius| if celsius.is_nan() { 1e9 } else { celsius });
    simulation.set_temperatures_c(filled.view()).unwrap();
    assert_eq!(bits(&simulation), before);
    // The memory layout of the array does not matter either.
    let transposed = good.reversed_axes().as_standard_layout().into_owned();
    simulation.set_temperatures_c(transposed.t()).unwrap();
    assert_eq!(bits(&simulation), before);
}
