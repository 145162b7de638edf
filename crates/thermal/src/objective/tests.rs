//! Measures against slow twins: one event at a time, with statistics of all temperatures.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::{CancelToken, Control, Threads};
use beadwork_grid::Cell;
use beadwork_part::Pattern;
use beadwork_part::slice::Voxels;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::report::{LayerReport, reward};
use crate::simulation::{DepositError, Method};
use crate::testing::{stairs, unprinted};
use crate::{
    DepositionEvent, ProcessParameters, Simulation, TemperatureStatistics, ThermalMaterial,
};

type Random = Xoshiro256PlusPlus;

/// Stairs with a pattern for each layer, both drawn at random.
fn random_plan(random: &mut Random) -> (Arc<Voxels>, Vec<Vec<Cell>>) {
    let (width, height) = (random.random_range(1..24), random.random_range(1..14));
    let part = stairs(width, height, random.random_range(1..4));
    let orders = (0..part.depth).map(|layer| {
        let pattern = Pattern::ALL[random.random_range(0..Pattern::ALL.len())];
        part.region(layer).map_or_else(|_| Vec::new(), |region| pattern.order(&region))
    });
    (part.clone(), orders.collect())
}

/// Number of layers that have cells.
fn printed(orders: &[Vec<Cell>]) -> usize {
    orders.iter().filter(|order| !order.is_empty()).count()
}

/// Deviation of all temperatures, voxel by voxel.
fn slow_std_c(simulation: &Simulation) -> f64 {
    let layers = 0..simulation.part().depth as u32;
    let all: Vec<f64> = layers
        .flat_map(|layer| simulation.cell_temperatures_c(layer).map(|(_, celsius)| celsius))
        .collect();
    TemperatureStatistics::of(all).map_or(0.0, |all| all.std_c)
}

/// The measures of a layer with a sample after every event.
fn slow_layer(simulation: &mut Simulation, layer: u32, order: &[Cell], pause_s: f64) -> LayerHeat {
    let mut events = simulation.layer_events(layer, order);
    let pause_s = if order.is_empty() { 0.0 } else { pause_s };
    let travel = events.iter().filter(|event| event.voxel.is_none());
    let travel_seconds = travel.map(|event| event.seconds).sum::<f64>();
    events.push(DepositionEvent::pause(pause_s));
    // Temperatures change most at the start of a pause.
    let events = events.into_iter().flat_map(|event| {
        let parts = if event.voxel.is_none() { (event.seconds / 0.01).ceil() as usize } else { 1 };
        let seconds = event.seconds / parts.max(1) as f64;
        std::iter::repeat_n(DepositionEvent { seconds, ..event }, parts)
    });
    let start_s = simulation.seconds();
    let mut before = slow_std_c(simulation);
    let (mut sum, mut max) = (0.0, before);
    for event in events {
        simulation.run(&[event], &Control::default()).unwrap();
        let after = slow_std_c(simulation);
        sum += f64::midpoint(before, after) * event.seconds;
        max = f64::max(max, after);
        before = after;
    }
    let print_seconds = simulation.seconds() - start_s;
    LayerHeat {
        layer,
        print_seconds,
        travel_seconds,
        pause_seconds: pause_s,
        end_std_c: before,
        mean_std_c: if print_seconds > 0.0 { sum / print_seconds } else { 0.0 },
        max_std_c: max,
    }
}

#[test]
fn samples_at_every_event_are_those_of_the_twin() {
    let random = &mut Random::seed_from_u64(1);
    for _ in 0..60 {
        let (part, orders) = random_plan(random);
        let settings = Settings {
            // Shorter than any event that deposits.
            sample_s: Some(1.0 / 61.0),
            pause_s: 0.0,
            ..Settings::default()
        };
        // One step for each event, and no travel to be cut: the same steps in both.
        let process = ProcessParameters { travel_mm_s: None, ..ProcessParameters::default() };
        let abs = ThermalMaterial::abs();
        let mut fast = Simulation::new(part, &abs, &process, Method::Naive).unwrap();
        let mut slow = fast.clone();
        let mut meter = HeatMeter::new(&fast, &abs, settings);
        for (layer, order) in (0..).zip(&orders) {
            let slow_heat = slow_layer(&mut slow, layer, order, 0.0);
            let heat = meter.deposit(&mut fast, layer, order, &Control::default()).unwrap();
            assert_near(&heat, &slow_heat, 1e-6);
        }
    }
}

fn assert_near(fast: &LayerHeat, slow: &LayerHeat, max_k: f64) {
    let times = |heat: &LayerHeat| [heat.print_seconds, heat.travel_seconds, heat.pause_seconds];
    for (fast, slow) in times(fast).into_iter().zip(times(slow)) {
        assert!((fast - slow).abs() < 1e-9, "{fast} {slow}");
    }
    let stds = |heat: &LayerHeat| [heat.end_std_c, heat.mean_std_c, heat.max_std_c];
    for (one, other) in stds(fast).into_iter().zip(stds(slow)) {
        assert!((one - other).abs() < max_k, "{fast:?} {slow:?}");
    }
}

#[test]
fn short_samples_converge_to_the_twin() {
    let random = &mut Random::seed_from_u64(2);
    for _ in 0..40 {
        let (part, orders) = random_plan(random);
        let pause_s = if random.random() { random.random_range(0.0..2.0) } else { 0.0 };
        let settings = Settings { sample_s: Some(0.02), pause_s, ..Settings::default() };
        let (mut fast, mut slow) = (unprinted(part.clone()), unprinted(part));
        let mut meter = HeatMeter::new(&fast, &ThermalMaterial::abs(), settings);
        for (layer, order) in (0..).zip(&orders) {
            let slow_heat = slow_layer(&mut slow, layer, order, pause_s);
            let heat = meter.deposit(&mut fast, layer, order, &Control::default()).unwrap();
            assert_near(&heat, &slow_heat, 1.5);
        }
        assert_eq!(meter.layers().len(), printed(&orders));
    }
}

#[test]
fn measuring_changes_no_bit_of_a_layer() {
    let random = &mut Random::seed_from_u64(3);
    let abs = ThermalMaterial::abs();
    // The last part has more events in a layer than the fast method runs at once.
    let mut plans: Vec<_> = (0..40).map(|_| random_plan(random)).collect();
    let part = stairs(90, 60, 2);
    let orders = [Pattern::CONVENTIONAL, Pattern::ALL[20]].into_iter().enumerate();
    let orders = orders.map(|(layer, pattern)| pattern.order(&part.region(layer).unwrap()));
    plans.push((part.clone(), orders.collect()));
    for (part, orders) in plans {
        let (mut measured, mut plain) = (unprinted(part.clone()), unprinted(part));
        let mut meter = HeatMeter::new(&measured, &abs, Settings::default());
        let mut reports = Vec::new();
        for (layer, order) in (0..).zip(&orders) {
            meter.deposit(&mut measured, layer, order, &Control::default()).unwrap();
            let seconds = plain.deposit(layer, order, &Control::default()).unwrap();
            reports.extend(LayerReport::of(&plain, layer, seconds, &abs));
            for z in 0..=layer {
                assert!(measured.cell_temperatures_c(z).eq(plain.cell_temperatures_c(z)));
            }
        }
        let measures = meter.finish(&measured, &Control::default()).unwrap();
        assert_eq!(measures.reward().to_bits(), reward(&reports).to_bits());
        let seconds: f64 = reports.iter().map(|report| report.print_seconds).sum();
        assert!((measures.print_seconds() - seconds).abs() < 1e-6);
    }
}

#[test]
fn plans_are_measured_the_same_on_any_number_of_threads() {
    let random = &mut Random::seed_from_u64(4);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let (abs, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let still = ProcessParameters { travel_mm_s: None, ..process.clone() };
    for _ in 0..20 {
        let (part, orders) = random_plan(random);
        let settings = Settings { warpage: true, pause_s: 0.5, ..Settings::default() };
        let measure = |process: &ProcessParameters, settings: &Settings, threads| {
            let control = Control::on(threads);
            measure_plan(&part, &abs, process, Method::default(), &orders, settings, &control)
                .unwrap()
        };
        let one = measure(&process, &settings, Threads::One);
        let mut from = None;
        let mut events = |(layer, order): (u32, &Vec<u32>)| {
            let events = crate::event::layer_events(order, layer, from, &part.frame, &process);
            from = order.last().copied().or(from);
            events
        };
        let layers: Vec<Vec<DepositionEvent>> = (0..).zip(&orders).map(&mut events).collect();
        let control = Control::default();
        let of_events =
            measure_events(&part, &abs, &process, Method::default(), &layers, &settings, &control);
        assert_eq!(of_events.unwrap(), one);
        assert_eq!(one, measure(&process, &settings, Threads::Pool(&pool)));
        assert!((one.pause_seconds() - 0.5 * printed(&orders) as f64).abs() < 1e-9);
        assert!(one.warpage_mm.unwrap() >= 0.0);
        let free = measure(&still, &Settings::default(), Threads::One);
        assert_eq!(free.no_travel_reward, Some(free.reward()));
        let ratio = one.no_travel_reward.unwrap() - free.reward();
        assert!(ratio.abs() < 1e-9, "{ratio}");
        let maxima: f64 = one.layers.iter().map(|layer| layer.max_std_c).sum();
        assert!((maxima - one.layers[0].max_std_c - one.peak_std_sum_c()).abs() < 1e-9);
        for objective in Objective::ALL {
            assert!(objective.cost(&one).unwrap() >= 0.0);
            let gain = objective.gain_percent(&one, &one);
            assert!(gain.is_none_or(|gain| gain == 0.0));
        }
    }
}

#[test]
fn warpage_is_that_of_its_estimator() {
    let part = stairs(20, 12, 3);
    let abs = ThermalMaterial::abs();
    let orders: Vec<_> =
        (0..3).map(|z| Pattern::CONVENTIONAL.order(&part.region(z).unwrap())).collect();
    let settings = Settings { warpage: true, sample_s: Some(0.1), ..Settings::default() };
    let control = Control::default();
    let process = ProcessParameters::default();
    let measures =
        measure_plan(&part, &abs, &process, Method::default(), &orders, &settings, &control)
            .unwrap();
    let mut simulation = unprinted(part);
    let mut warpage = crate::warpage::WarpageEstimator::new(simulation.part(), &abs);
    for (layer, order) in (0..).zip(&orders) {
        let events = simulation.layer_events(layer, order);
        simulation.run_sampled(&events, 0.1, |now| warpage.sample(now), &control).unwrap();
    }
    let expected = warpage.finish(&simulation, &control).unwrap().corner_lift_mm;
    let lift = measures.warpage_mm.unwrap();
    assert!((lift / expected - 1.0).abs() < 0.05, "{lift} {expected}");
}

#[test]
fn invalid_plans_and_interruptions_are_errors() {
    let part = stairs(13, 7, 2);
    let abs = ThermalMaterial::abs();
    let control = Control::default();
    let order = Pattern::CONVENTIONAL.order(&part.region(0).unwrap());
    let mut simulation = unprinted(part.clone());
    let before = simulation.clone();
    for pause_s in [-1.0, f64::NAN, f64::INFINITY] {
        let settings = Settings { pause_s, ..Settings::default() };
        let mut meter = HeatMeter::new(&simulation, &abs, settings);
        let refused = meter.deposit(&mut simulation, 0, &order, &control);
        assert!(matches!(refused, Err(DepositError::Duration { .. })), "{refused:?}");
        assert!(meter.layers().is_empty());
    }
    let mut meter = HeatMeter::new(&simulation, &abs, Settings::default());
    let refused = meter.deposit(&mut simulation, 0, &order[1..], &control);
    assert!(matches!(refused, Err(DepositError::Missing { .. })));
    let cancel = CancelToken::new();
    cancel.cancel();
    let cancelled = Control { cancel: Some(&cancel), ..control };
    let refused = meter.deposit(&mut simulation, 0, &order, &cancelled);
    assert!(matches!(refused, Err(DepositError::Interrupted(_))));
    assert_eq!(simulation.statistics(), before.statistics());
    let (process, settings) = (ProcessParameters::default(), Settings::default());
    let one = std::slice::from_ref(&order);
    let refused = measure_plan(&part, &abs, &process, Method::default(), one, &settings, &control);
    assert_eq!(refused, Err(MeasureError::Layers { orders: 1, layers: 2 }));
    // Time is up after some polls: an error, whenever it happens.
    let orders: Vec<_> =
        (0..2).map(|z| Pattern::CONVENTIONAL.order(&part.region(z).unwrap())).collect();
    for polls in 0..4 {
        let polled = AtomicUsize::new(0);
        let time_is_up = || polled.fetch_add(1, Ordering::Relaxed) >= polls;
        let control = Control { time_is_up: Some(&time_is_up), ..Control::default() };
        let result =
            measure_plan(&part, &abs, &process, Method::default(), &orders, &settings, &control);
        assert!(matches!(result, Err(MeasureError::Deposit(DepositError::Interrupted(_)))));
    }
}

#[test]
fn pauses_are_part_of_the_print() {
    let part = stairs(20, 12, 2);
    let orders: Vec<_> =
        (0..2).map(|z| Pattern::CONVENTIONAL.order(&part.region(z).unwrap())).collect();
    let measure = |pause_s: f64| {
        let (abs, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        let settings = Settings { pause_s, ..Settings::default() };
        let control = Control::default();
        measure_plan(&part, &abs, &process, Method::default(), &orders, &settings, &control)
            .unwrap()
    };
    let (without, with) = (measure(0.0), measure(1.0));
    let seconds = with.print_seconds() - without.print_seconds();
    assert!((seconds - 2.0).abs() < 1e-9 && (with.pause_seconds() - 2.0).abs() < 1e-9);
    // The pause lowers the deviation at the layers' ends, and changes nothing without time.
    assert!(Objective::Reward.gain_percent(&with, &without).unwrap() > 10.0);
    let change = with.no_travel_reward.unwrap() - without.no_travel_reward.unwrap();
    assert!(change.abs() < 1e-12);
}

#[test]
fn weighted_sums_are_relative_to_a_baseline() {
    let measures = |end_std_c: f64, warpage_mm: Option<f64>| HeatMeasures {
        layers: vec![LayerHeat {
            layer: 0,
            print_seconds: 2.0,
            travel_seconds: 0.5,
            pause_seconds: 0.0,
            end_std_c,
            mean_std_c: 3.0,
            max_std_c: 9.0,
        }],
        no_travel_reward: None,
        warpage_mm,
    };
    let (base, plan) = (measures(4.0, Some(0.5)), measures(2.0, Some(1.0)));
    let weighted: Weighted = "reward=0.5, warpage=0.25".parse().unwrap();
    assert_eq!(weighted.cost(&plan, &base), Some(0.75));
    assert_eq!(weighted.cost(&plan, &measures(4.0, None)), None);
    assert!(weighted.needs_warpage() && !weighted.needs_no_travel());
    assert_eq!(weighted.to_string().parse(), Ok(weighted));
    assert_eq!(Objective::Reward.gain_percent(&plan, &base), Some(50.0));
    assert_eq!(Objective::NoTravel.gain_percent(&plan, &base), None);
    assert_eq!(Objective::Reward.gain_percent(&plan, &measures(0.0, None)), None);
    for text in ["", "cold", "reward=", "reward=-1", "reward=nan", "peak=inf", "peak=0"] {
        assert!(text.parse::<Weighted>().is_err(), "{text}");
    }
    let repeated = "peak,reward,peak".parse::<Weighted>();
    assert_eq!(repeated, Err(WeightedError::Repeated { objective: Objective::Peak }));
}
