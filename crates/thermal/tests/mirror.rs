//! Symmetry: a mirrored, transposed or shifted print has the mirrored, transposed or shifted field.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod common;

use std::sync::Arc;

use beadwork_part::slice::Voxels;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{DepositionEvent, Simulation};
use common::{Difference, Print, Random, difference, part_of, random_part, voxels};

/// A map of voxels.
#[derive(Clone, Copy, Debug)]
enum View {
    MirroredX,
    MirroredY,
    Transposed,
    /// Along x, so that columns lie in other cache lines.
    Shifted(u32),
}

impl View {
    fn size(self, part: &Voxels) -> [u32; 2] {
        let (width, height) = (part.frame.width, part.frame.height);
        match self {
            Self::MirroredX | Self::MirroredY => [width, height],
            Self::Transposed => [height, width],
            Self::Shifted(by) => [width + by, height],
        }
    }

    fn position(self, [x, y, z]: [u32; 3], part: &Voxels) -> [u32; 3] {
        match self {
            Self::MirroredX => [part.frame.width - 1 - x, y, z],
            Self::MirroredY => [x, part.frame.height - 1 - y, z],
            Self::Transposed => [y, x, z],
            Self::Shifted(by) => [x + by, y, z],
        }
    }

    fn print(self, print: &Print) -> Print {
        let part = &print.part;
        let [width, height] = self.size(part);
        let frame = beadwork_part::Frame { width, height, ..part.frame };
        let filled: std::collections::HashSet<[u32; 3]> =
            voxels(part).map(|voxel| self.position(voxel, part)).collect();
        let other =
            part_of(frame, part.depth, |position| filled.contains(&position.map(|i| i as u32)));
        let moved = |event: &DepositionEvent| DepositionEvent {
            voxel: event.voxel.map(|voxel| self.position(voxel, part)),
            ..*event
        };
        let events = print.events.iter().map(moved).collect();
        Print {
            part: other,
            events,
            material: print.material.clone(),
            process: print.process.clone(),
        }
    }
}

const VIEWS: [View; 6] = [
    View::MirroredX,
    View::MirroredY,
    View::Transposed,
    View::Shifted(1),
    View::Shifted(7),
    View::Shifted(21),
];

fn compare(part: &Arc<Voxels>, view: View, one: &Simulation, other: &Simulation) -> Difference {
    let celsius = |simulation: &Simulation, voxel| simulation.temperature_c(voxel).unwrap();
    let ones: Vec<f64> = voxels(part).map(|voxel| celsius(one, voxel)).collect();
    let others: Vec<f64> =
        voxels(part).map(|voxel| celsius(other, view.position(voxel, part))).collect();
    difference(&ones, &others)
}

#[test]
fn explicit_methods_give_the_same_bits() {
    for seed in 0..12 {
        let mut random = Random::new(seed);
        let print = Print::random(&mut random, [40, 12, 4]);
        for method in [Method::Naive, Method::Reference { steps: 1 }] {
            let one = print.run(method);
            for view in VIEWS {
                let other = view.print(&print).run(method);
                let apart = compare(&print.part, view, &one, &other);
                assert_eq!(apart, Difference::default(), "print {seed}, {method:?}, {view:?}");
            }
        }
    }
}

/// Windows begin and end with cache lines, so the fast method is not quite symmetric in x.
#[test]
fn the_fast_method_gives_nearly_the_same() {
    for seed in 0..12 {
        let mut random = Random::new(100 + seed);
        let part = random_part(&mut random, [50, 30, 4]);
        let print = Print::paper(&mut random, part);
        // Measured: 0.75 and 0.056 K, 0.31 and 0.031 K.
        let standard = (Accuracy::Standard, Difference { rms: 0.08, max: 1.0 });
        let high = (Accuracy::High, Difference { rms: 0.05, max: 0.5 });
        for (accuracy, limit) in [standard, high] {
            let one = print.run(Method::Fast(accuracy));
            for view in VIEWS {
                let other = view.print(&print).run(Method::Fast(accuracy));
                let apart = compare(&print.part, view, &one, &other);
                let case = format!("print {seed}, {accuracy:?}, {view:?}");
                assert!(apart.max < limit.max && apart.rms < limit.rms, "{case}: {apart:?}");
            }
        }
    }
}
