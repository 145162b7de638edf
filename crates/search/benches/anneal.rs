//! Throughput of the annealers and of their moves, on small and large grids.

use std::hint::black_box;

use beadwork_base::Control;
use beadwork_grid::{Crossings, Layout, LayoutSpec, Links, Path, Region, Start, Switch};
use beadwork_search::Move;
use beadwork_search::anneal::{self, Free, Method, Outcome, Preset, Settings};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

fn instance(side: u32) -> (Path, Crossings) {
    let region = Region::rectangle(side, side).expect("the sides are in range");
    let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, 0).expect("three zones fit");
    let start =
        Start::RowZigzag.path(&region, &Control::default()).expect("a rectangle has a zigzag");
    (start, Crossings::new(&region, &zones))
}

fn run(start: &Path, crossings: &Crossings, settings: &Settings<'_>) -> Outcome {
    anneal::solve(start, crossings, settings, &Control::default())
}

fn paper(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("paper");
    for side in [30, 50, 100] {
        let (start, crossings) = instance(side);
        group.throughput(Throughput::Elements(5000));
        group.bench_function(BenchmarkId::from_parameter(side), |bencher| {
            let settings = Settings::preset(Preset::Paper, 0);
            bencher.iter_with_large_drop(|| run(&start, &crossings, &settings));
        });
    }
}

fn fast(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("fast");
    group.sample_size(10);
    for side in [30, 100, 300, 500] {
        let (start, crossings) = instance(side);
        let method = Method::Free(Free { proposals: 1_000_000, ..Free::default() });
        group.throughput(Throughput::Elements(1_000_000));
        group.bench_function(BenchmarkId::from_parameter(side), |bencher| {
            let settings = Settings { method, ..Settings::preset(Preset::Fast, 0) };
            bencher.iter_with_large_drop(|| run(&start, &crossings, &settings));
        });
    }
}

/// Checks of all pairs of switches that touch, on a path that annealing has rearranged.
fn validity(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("validity");
    for side in [30, 100, 500] {
        let (start, crossings) = instance(side);
        let path = run(&start, &crossings, &Settings::preset(Preset::Fast, 0)).path;
        let first = (0..side * (side - 1))
            .filter_map(|corner| Some(Switch::new(corner, path.sides(corner)?)));
        let pairs: Vec<[Switch; 2]> = first
            .flat_map(|first| {
                let others = [first.corner() + 1, first.corner() + side, first.corner() + side + 1];
                others.map(|corner| [first, Switch::new(corner, first.from().other())])
            })
            .collect();
        group.throughput(Throughput::Elements(pairs.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(side), |bencher| {
            bencher
                .iter(|| pairs.iter().filter(|[a, b]| black_box(path.allows_pair(*a, *b))).count());
        });
    }
}

/// Replays of the moves of an annealing run, on links only and on the path.
fn replay(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("replay");
    for side in [30, 60, 100] {
        let (start, crossings) = instance(side);
        let moves = run(&start, &crossings, &Settings::preset(Preset::ExtraLong, 0)).moves;
        let variants: Vec<_> = moves
            .iter()
            .filter_map(|step| if let Move::Variant(placed) = step { Some(*placed) } else { None })
            .collect();
        group.throughput(Throughput::Elements(variants.len() as u64));
        let first = Links::new(&start);
        let mut links = first.clone();
        group.bench_function(BenchmarkId::new("links", side), |bencher| {
            bencher.iter(|| {
                links.copy_from(&first);
                variants.iter().filter(|&&placed| links.apply_variant(placed)).count()
            });
        });
        let mut path = start.clone();
        group.bench_function(BenchmarkId::new("path", side), |bencher| {
            bencher.iter(|| {
                path.copy_from(&start);
                variants.iter().filter(|&&placed| path.apply_variant(placed)).count()
            });
        });
    }
}

criterion_group!(benches, paper, fast, validity, replay);
criterion_main!(benches);
