//! Linking of infill lines: the rule and the methods, by the number of lines.

#[path = "../tests/infill/mod.rs"]
mod infill;

use std::f64::consts::FRAC_PI_4;

use beadwork_base::Control;
use beadwork_search::link::{Method, Rule, Settings, solve};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use infill::{gear_like, lines};

/// Numbers of lines, roughly.
const COUNTS: [usize; 4] = [100, 500, 2000, 20_000];

fn rule(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("link rule");
    group.sample_size(10);
    for count in COUNTS {
        let (rings, spacing) = gear_like(count);
        let lines = lines(&rings, spacing, FRAC_PI_4);
        group.throughput(Throughput::Elements(lines.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(lines.len()), |bencher| {
            bencher.iter_with_large_drop(|| Rule::default().links(&lines, &rings, spacing));
        });
    }
}

fn methods(criterion: &mut Criterion) {
    for method in [Method::Nearest, Method::BreakPoints, Method::Cover] {
        let mut group = criterion.benchmark_group(format!("link {method}"));
        group.sample_size(10);
        for count in COUNTS {
            // Break points take minutes for 20,000 lines.
            if method == Method::BreakPoints && count > 2000 {
                continue;
            }
            let (rings, spacing) = gear_like(count);
            let lines = lines(&rings, spacing, FRAC_PI_4);
            let links = Rule::default().links(&lines, &rings, spacing).expect("lines are valid");
            let settings = Settings { method, ..Settings::default() };
            group.throughput(Throughput::Elements(lines.len() as u64));
            group.bench_function(BenchmarkId::from_parameter(lines.len()), |bencher| {
                bencher.iter_with_large_drop(|| solve(&links, &settings, &Control::default()));
            });
        }
    }
}

criterion_group!(benches, rule, methods);
criterion_main!(benches);
