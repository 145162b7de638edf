//! Time of orders of beads, of their nearest-neighbour order, and of the bound.

use beadwork_base::Control;
use beadwork_search::travel::{Item, Order, Settings, nearest_neighbour, solve};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Short beads in a square with about one of them on each 4 mm², in groups of about 25.
fn beads(count: usize) -> Vec<Item<'static>> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(count as u64);
    let mut unit = || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let side = 2.0 * (count as f64).sqrt();
    let bead = |_| {
        let [x, y] = [side * unit(), side * unit()];
        let group = (x / 10.0) as u32 * 1000 + (y / 10.0) as u32;
        Item::bead([x, y], [x + 5.0 * unit(), y + 5.0 * unit()]).within(group, 0)
    };
    (0..count).map(bead).collect()
}

fn order(criterion: &mut Criterion) {
    for (name, order) in [("free", Order::Free), ("groups", Order::Groups)] {
        let mut group = criterion.benchmark_group(name);
        group.sample_size(10);
        for count in [100, 1000, 20_000] {
            let items = beads(count);
            group.throughput(Throughput::Elements(count as u64));
            group.bench_function(BenchmarkId::new("nearest", count), |bencher| {
                bencher.iter(|| nearest_neighbour(&items, order, None));
            });
            for kicks_per_item in [0, 10] {
                let settings = Settings { order, kicks_per_item, ..Settings::default() };
                let id = BenchmarkId::new(format!("{kicks_per_item} kicks"), count);
                group.bench_function(id, |bencher| {
                    bencher.iter(|| solve(&items, &settings, &Control::default()));
                });
            }
        }
    }
}

fn bound(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("bound");
    group.sample_size(10);
    for count in [100, 1000] {
        let items = beads(count);
        let settings = Settings { kicks_per_item: 0, bound_iterations: 10, ..Settings::default() };
        group.bench_function(BenchmarkId::from_parameter(count), |bencher| {
            bencher.iter(|| solve(&items, &settings, &Control::default()));
        });
    }
}

criterion_group!(benches, order, bound);
criterion_main!(benches);
