//! What the network is given: images, batches, records.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

mod common;

use beadwork_base::Control;
use beadwork_dataset::{Config, Factory, Trajectory};
use beadwork_grid::{Links, Region, Start, Symmetry, VariantKind, Zones};
use beadwork_learn::Device;
use beadwork_learn::fusion::CHANNELS;
use beadwork_learn::fusion::episode::Episode;
use beadwork_learn::fusion::layer::{Canvas, Inputs, Made, State};
use beadwork_learn::fusion::odds::Odds;
use beadwork_learn::fusion::samples::{Batch, Batches, Rivals, SampleSettings, Split};
use tch::Tensor;

use self::common::{CHAINS, NEVER, dataset, layer, small};

/// The image once more, cell by cell from the definitions, by way of a path that was itself mapped.
fn image_by_definition(
    region: &Region,
    zones: &Zones,
    order: &[u32],
    initial: u32,
    canvas: Canvas,
) -> Vec<f32> {
    let (width, height) = (region.width(), region.height());
    let most_zone = zones.ids().iter().copied().max().unwrap().max(1);
    let linked = |a: u32, b: u32| order.windows(2).any(|step| step == [a, b] || step == [b, a]);
    let crossings_at = |cell: u32| {
        region
            .neighbours(cell)
            .filter(|&other| linked(cell, other) && zones.id(cell) != zones.id(other))
            .count()
    };
    let most = region.cells().map(crossings_at).max().unwrap().max(1);
    let now: usize = region.cells().map(crossings_at).sum::<usize>() / 2;
    let mut image = vec![0.0; canvas.cells() * CHANNELS as usize];
    for cell in region.cells() {
        let (x, y) = region.xy(cell);
        let pixel =
            &mut image[((y * canvas.width + x) * CHANNELS as u32) as usize..][..CHANNELS as usize];
        pixel[0] = f32::from(zones.id(cell)) / f32::from(most_zone);
        pixel[1] = f32::from(u8::from(x + 1 < width && linked(cell, cell + 1)));
        pixel[2] = f32::from(u8::from(y + 1 < height && linked(cell, cell + width)));
        pixel[3] = 1.0;
        let beside = region.neighbours(cell).any(|other| zones.id(other) != zones.id(cell));
        pixel[4] = f32::from(u8::from(beside));
        pixel[5] = crossings_at(cell) as f32 / most as f32;
        pixel[6] = now as f32 / initial.max(1) as f32;
        pixel[7] = y as f32 / (height - 1).max(1) as f32;
        pixel[8] = x as f32 / (width - 1).max(1) as f32;
    }
    image
}

#[test]
fn images_are_those_of_the_mapped_layer() {
    for seed in 0..40 {
        let (region, zones, layer) = layer(7 + seed as u32 % 5, 9, seed);
        let size = layer.size();
        let mut path = Start::RowZigzag.path(&region, &Control::default()).unwrap();
        let initial = layer.crossings().count(&path);
        let mut made = Vec::new();
        for turn in 0..seed {
            let mut all = Vec::new();
            path.for_each_variant(&[VariantKind::Transpose, VariantKind::Flip], |placed| {
                all.push(placed)
            });
            let placed = all[(turn * 7919) as usize % all.len()];
            let before = layer.crossings().count(&path);
            assert!(path.apply_variant(placed));
            made.push(Made { placed, before, after: layer.crossings().count(&path) });
        }
        let links = Links::new(&path);
        let crossings = layer.crossings().count(&path);
        let state = State { layer: &layer, links: &links, crossings, initial, made: &made };
        for symmetry in Symmetry::ALL {
            let (width, height) = symmetry.map_size(size);
            let canvas = Canvas::holding((width, height));
            let mut inputs = Inputs::new(canvas, 3);
            inputs.push(&state, symmetry);
            let (image, history) = inputs.tensors(Device::Cpu);
            assert_eq!(
                image.size(),
                [1, CHANNELS, i64::from(canvas.height), i64::from(canvas.width)]
            );
            let image =
                Vec::<f32>::try_from(image.permute([0, 2, 3, 1]).contiguous().view([-1])).unwrap();
            let mapped = |cell: u32| {
                let (x, y) = symmetry.map_cell(region.xy(cell), size);
                y * width + x
            };
            let mapped_region = Region::rectangle(width, height).unwrap();
            let mut ids = vec![0; region.grid_len()];
            region.cells().for_each(|cell| ids[mapped(cell) as usize] = zones.id(cell));
            let mapped_zones = Zones::new(&mapped_region, ids).unwrap();
            let order: Vec<u32> = path.order().iter().map(|&cell| mapped(cell)).collect();
            let expected =
                image_by_definition(&mapped_region, &mapped_zones, &order, initial, canvas);
            let apart = image.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart < 1e-6, "seed {seed}, {symmetry:?}: {apart}");
            let mask = Vec::<f32>::try_from(history.mask.view([-1])).unwrap();
            assert_eq!(mask.iter().sum::<f32>() as usize, made.len().min(3));
            let last = made.len().saturating_sub(3);
            for (at, made) in made[last..].iter().enumerate() {
                let placed = symmetry.map_variant(made.placed, size);
                let told = |tensor: &Tensor| tensor.int64_value(&[0, at as i64]);
                assert_eq!(told(&history.action), i64::from(placed.variant.class()));
                assert_eq!(
                    (told(&history.x), told(&history.y)),
                    (placed.x.into(), placed.y.into())
                );
            }
        }
    }
}

#[test]
#[should_panic(expected = "do not fit on")]
fn a_canvas_that_is_too_small_is_refused() {
    let (region, _, layer) = layer(20, 9, 0);
    let path = Start::RowZigzag.path(&region, &Control::default()).unwrap();
    let state =
        State { layer: &layer, links: &Links::new(&path), crossings: 1, initial: 1, made: &[] };
    Inputs::new(Canvas { height: 16, width: 16 }, 3).push(&state, Symmetry::ALL[0]);
}

#[test]
fn batches_hold_needed_moves_of_their_own_part() {
    let (_folder, dataset) = dataset(CHAINS);
    let strata = dataset.manifest().strata.len() as u64;
    let mut parts = [0; 3];
    for trajectory in dataset.records::<Trajectory>() {
        parts[Split::of(&trajectory.unwrap(), strata) as usize] += 1;
    }
    assert_eq!(parts, [64, 8, 8]);
    let settings = small().samples();
    let all = |split, epoch| -> Vec<Batch> {
        Batches::new(&dataset, split, &settings, epoch).collect::<Result<_, _>>().unwrap()
    };
    let (first, again, other) = (all(Split::Train, 0), all(Split::Train, 0), all(Split::Train, 1));
    let key = |batches: &[Batch]| {
        batches.iter().flat_map(|batch| batch.position.clone()).collect::<Vec<_>>()
    };
    assert_eq!(key(&first), key(&again));
    assert_ne!(key(&first), key(&other));
    for batch in &first {
        let cells = batch.inputs.canvas().cells();
        assert!(batch.inputs.len() <= 8 && batch.rivals.len() == cells * batch.inputs.len());
        for (at, &position) in batch.position.iter().enumerate() {
            assert!(
                !batch.rivals[at * cells + position as usize],
                "the truth is no rival of itself"
            );
        }
    }
    let mut skipped = Batches::new(&dataset, Split::Train, &settings, 0);
    assert_eq!(skipped.skip_batches(5).unwrap(), 5);
    let rest: Vec<Batch> = skipped.collect::<Result<_, _>>().unwrap();
    assert_eq!(key(&rest), key(&first[5..]));
    let boundary = SampleSettings { rivals: Rivals::Boundary, ..settings.clone() };
    assert!(
        Batches::new(&dataset, Split::Valid, &boundary, 0)
            .all(|batch| batch.unwrap().rivals.contains(&true))
    );
}

#[test]
fn what_is_held_out_is_of_all_sizes_alike() {
    let config = CHAINS.replace("['14x11', '10x20']", "['9x8', '40x30']");
    let (_folder, dataset) = dataset(&config);
    for split in [Split::Valid, Split::Test] {
        let settings = small().held_out(3);
        let mut of_canvas = std::collections::BTreeMap::new();
        for batch in Batches::new(&dataset, split, &settings, 0) {
            let batch = batch.unwrap();
            *of_canvas.entry(batch.inputs.canvas().cells()).or_insert(0) += batch.inputs.len();
            assert!(batch.odds.iter().all(|&odds| odds != Odds::default()));
        }
        // Two layouts, two presets, one trajectory of each and size.
        assert_eq!(Vec::from_iter(of_canvas), [(16 * 16, 12), (32 * 48, 12)], "{split:?}");
    }
}

#[test]
fn layers_with_more_places_than_the_network_knows_are_named() {
    let config = CHAINS.replace("['14x11', '10x20']", "['6x130']").replace("side = 3", "side = 2");
    let (_folder, dataset) = dataset(&config);
    let error =
        Batches::new(&dataset, Split::Train, &small().samples(), 0).next().unwrap().unwrap_err();
    assert!(
        error.to_string().contains("is of 6 x 130 cells: the network knows 128 places"),
        "{error}"
    );
}

#[test]
fn records_of_other_searches_are_passed_over() {
    let config = Config::from_toml(
        "count = 2\nsizes = ['12x9']\npresets = ['fast']\nstarts = ['row_zigzag']\nlayouts = [{ name = 'voronoi' }]",
    );
    let factory = Factory::new(config.unwrap(), Vec::new()).unwrap();
    let trajectory = factory.trajectory(0, &NEVER).unwrap().unwrap();
    assert!(!trajectory.moves.is_empty() && Episode::new(&trajectory).unwrap().is_none());
}
