//! Inputs of the network: images, histories, batches.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

mod common;

use beadwork_base::Control;
use beadwork_dataset::{Config, Factory, Trajectory};
use beadwork_grid::{Links, Region, Start, Symmetry, VariantKind, Zones};
use beadwork_learn::Device;
use beadwork_learn::fusion::CHANNELS;
use beadwork_learn::fusion::baseline::Baseline;
use beadwork_learn::fusion::episode::Episode;
use beadwork_learn::fusion::inputs::{Canvas, Inputs};
use beadwork_learn::fusion::layer::{AppliedMove, State};
use beadwork_learn::fusion::samples::{Batch, Batches, Negatives, Settings, Split};
use tch::Tensor;

use self::common::{CHAINS, dataset, layer, small};

/// The image of a path, computed cell by cell from the definitions of the channels.
fn image_by_definition(
    region: &Region,
    zones: &Zones,
    order: &[u32],
    initial: u32,
    canvas: Canvas,
) -> Vec<f32> {
    let (width, height) = (region.width(), region.height());
    let max_zone = zones.ids().iter().copied().max().unwrap().max(1);
    let linked = |a: u32, b: u32| order.windows(2).any(|step| step == [a, b] || step == [b, a]);
    let crossings_at = |cell: u32| {
        region
            .neighbours(cell)
            .filter(|&other| linked(cell, other) && zones.id(cell) != zones.id(other))
            .count()
    };
    let max_crossings = region.cells().map(crossings_at).max().unwrap().max(1);
    let now: usize = region.cells().map(crossings_at).sum::<usize>() / 2;
    let mut image = vec![0.0; canvas.cells() * CHANNELS as usize];
    for cell in region.cells() {
        let (x, y) = region.xy(cell);
        let pixel =
            &mut image[((y * canvas.width + x) * CHANNELS as u32) as usize..][..CHANNELS as usize];
        pixel[0] = f32::from(zones.id(cell)) / f32::from(max_zone);
        pixel[1] = f32::from(u8::from(x + 1 < width && linked(cell, cell + 1)));
        pixel[2] = f32::from(u8::from(y + 1 < height && linked(cell, cell + width)));
        pixel[3] = 1.0;
        let is_boundary = region.neighbours(cell).any(|other| zones.id(other) != zones.id(cell));
        pixel[4] = f32::from(u8::from(is_boundary));
        pixel[5] = crossings_at(cell) as f32 / max_crossings as f32;
        pixel[6] = now as f32 / initial.max(1) as f32;
        pixel[7] = y as f32 / (height - 1).max(1) as f32;
        pixel[8] = x as f32 / (width - 1).max(1) as f32;
    }
    image
}

#[test]
fn images_equal_those_of_the_mapped_path() {
    for seed in 0..40 {
        let (region, zones, layer) = layer(7 + seed as u32 % 5, 9, seed);
        let size = layer.size();
        let mut path = Start::RowZigzag.path(&region, &Control::default()).unwrap();
        let initial = layer.crossings().count(&path);
        let mut moves = Vec::new();
        for turn in 0..seed {
            let mut all = Vec::new();
            path.for_each_variant(&[VariantKind::Transpose, VariantKind::Flip], |placed| {
                all.push(placed);
            });
            let placed = all[(turn * 7919) as usize % all.len()];
            let before = layer.crossings().count(&path);
            assert!(path.apply_variant(placed));
            moves.push(AppliedMove { placed, before, after: layer.crossings().count(&path) });
        }
        let links = Links::new(&path);
        let crossings = layer.crossings().count(&path);
        let state = State { layer: &layer, links: &links, crossings, initial, moves: &moves };
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
            assert_eq!(inputs.image().as_slice().unwrap(), image);
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
            assert_eq!(mask.iter().sum::<f32>() as usize, moves.len().min(3));
            let arrays = inputs.history();
            let first = moves.len().saturating_sub(3);
            for (index, applied) in moves[first..].iter().enumerate() {
                let placed = symmetry.map_variant(applied.placed, size);
                let expected: [i64; 3] =
                    [placed.variant.class().into(), placed.x.into(), placed.y.into()];
                let value = |tensor: &Tensor| tensor.int64_value(&[0, index as i64]);
                assert_eq!([&history.action, &history.x, &history.y].map(value), expected);
                assert_eq!([arrays.action, arrays.x, arrays.y].map(|it| it[[0, index]]), expected);
                assert_eq!(arrays.mask[[0, index]].to_bits(), 1.0_f32.to_bits());
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
        State { layer: &layer, links: &Links::new(&path), crossings: 1, initial: 1, moves: &[] };
    Inputs::new(Canvas { height: 16, width: 16 }, 3).push(&state, Symmetry::ALL[0]);
}

#[test]
fn batches_depend_on_the_split_and_the_epoch() {
    let (_folder, dataset) = dataset(CHAINS);
    let strata = dataset.manifest().strata.len() as u64;
    let mut splits = [0; 3];
    for trajectory in dataset.records::<Trajectory>() {
        splits[Split::of(&trajectory.unwrap(), strata) as usize] += 1;
    }
    assert_eq!(splits, [64, 8, 8]);
    let settings = small().samples();
    let all = |split, epoch| -> Vec<Batch> {
        Batches::new(&dataset, split, &settings, epoch).collect::<Result<_, _>>().unwrap()
    };
    let (first, again, other) = (all(Split::Train, 0), all(Split::Train, 0), all(Split::Train, 1));
    let key = |batches: &[Batch]| {
        batches.iter().flat_map(|batch| batch.position.to_vec()).collect::<Vec<_>>()
    };
    assert_eq!(key(&first), key(&again));
    assert_ne!(key(&first), key(&other));
    for batch in &first {
        let Canvas { height, width } = batch.inputs.canvas();
        let (height, width) = (height as usize, width as usize);
        assert!(batch.len() <= 8 && batch.len() == batch.inputs.len());
        assert_eq!(batch.negatives.dim(), (batch.len(), height, width));
        for (example, &position) in batch.position.iter().enumerate() {
            let (y, x) = (position as usize / width, position as usize % width);
            assert!(!batch.negatives[[example, y, x]], "the target is not a negative");
        }
    }
    let mut skipped = Batches::new(&dataset, Split::Train, &settings, 0);
    assert_eq!(skipped.skip_batches(5).unwrap(), 5);
    let rest: Vec<Batch> = skipped.collect::<Result<_, _>>().unwrap();
    assert_eq!(key(&rest), key(&first[5..]));
    let boundary = Settings { negatives: Negatives::Boundary, ..settings.clone() };
    assert!(
        Batches::new(&dataset, Split::Valid, &boundary, 0).all(|batch| batch
            .unwrap()
            .negatives
            .iter()
            .any(|&negative| negative))
    );
}

#[test]
fn arrays_convert_to_the_tensors_of_training() {
    let (_folder, dataset) = dataset(CHAINS);
    let settings = small().samples();
    let batch = Batches::new(&dataset, Split::Train, &settings, 0).next().unwrap().unwrap();
    let (image, _) = batch.inputs.tensors(Device::Cpu);
    let from_array = Tensor::try_from(&batch.inputs.image()).unwrap();
    assert_eq!(from_array.permute([0, 3, 1, 2]), image);
    let targets = batch.targets(Device::Cpu);
    let negatives = Tensor::try_from(&batch.negatives).unwrap();
    assert_eq!(negatives.flatten(1, -1), targets.negatives);
    assert_eq!(Tensor::try_from(&batch.position).unwrap(), targets.position);
    assert_eq!(Tensor::try_from(&batch.action).unwrap(), targets.action);
}

#[test]
fn held_out_examples_are_balanced_over_sizes() {
    let config = CHAINS.replace("['14x11', '10x20']", "['9x8', '40x30']");
    let (_folder, dataset) = dataset(&config);
    for split in [Split::Valid, Split::Test] {
        let settings = small().held_out(3);
        let mut by_canvas = std::collections::BTreeMap::new();
        for batch in Batches::new(&dataset, split, &settings, 0) {
            let batch = batch.unwrap();
            *by_canvas.entry(batch.inputs.canvas().cells()).or_insert(0) += batch.inputs.len();
            assert!(batch.baselines.iter().all(|&baseline| baseline != Baseline::default()));
        }
        // Two layouts, two presets, one trajectory for each of them and each size.
        assert_eq!(Vec::from_iter(by_canvas), [(16 * 16, 12), (32 * 48, 12)], "{split:?}");
    }
}

#[test]
fn layers_larger_than_the_network_allows_are_refused() {
    let config = CHAINS.replace("['14x11', '10x20']", "['6x130']").replace("side = 3", "side = 2");
    let (_folder, dataset) = dataset(&config);
    let error =
        Batches::new(&dataset, Split::Train, &small().samples(), 0).next().unwrap().unwrap_err();
    assert!(
        error.to_string().contains("6 x 130 cells, the network takes at most 128 x 128"),
        "{error}"
    );
}

#[test]
fn records_of_other_moves_are_skipped() {
    let config = Config::from_toml(
        "count = 2
sizes = ['12x9']
presets = ['fast']
starts = ['row_zigzag']
layouts = [{ name = 'voronoi' }]",
    );
    let factory = Factory::new(config.unwrap(), Vec::new(), &Control::default()).unwrap();
    let trajectory = factory.trajectory(0, &Control::default()).unwrap();
    assert!(!trajectory.moves.is_empty() && Episode::new(&trajectory).unwrap().is_none());
}
