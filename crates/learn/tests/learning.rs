//! What the network is given, what it is trained for, training that goes on after a stop, and walks.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use beadwork_dataset::{Config, Dataset, Factory, GenerateSettings, Slice, Trajectory, generate};
use beadwork_grid::{Kind as MoveKind, Layout, LayoutSpec, Links, Region, Start, Symmetry, Zones, verify};
use beadwork_learn::Device;
use beadwork_learn::adamw::{AdamW, AdamWSettings};
use beadwork_learn::fusion::episode::Episode;
use beadwork_learn::fusion::layer::{Canvas, Inputs, Layer, Made, State};
use beadwork_learn::fusion::loss::{Hits, LossSettings, PositionLoss, loss};
use beadwork_learn::fusion::model::{Model, ModelError};
use beadwork_learn::fusion::propose::{AllMoves, Asked, Proposer};
use beadwork_learn::fusion::samples::{Batch, Batches, Rivals, Split, Targets};
use beadwork_learn::fusion::train::{End, Event, Run, TrainError, Training, last_checkpoint, train};
use beadwork_learn::fusion::walk::{Task, WalkSettings, walk};
use beadwork_learn::fusion::{CHANNELS, FusionNet, Proposals, VarStore};
use beadwork_search::Stop;
use tch::{Kind, Tensor};
use tempfile::{TempDir, tempdir};

static NEVER: AtomicBool = AtomicBool::new(false);

/// libtorch's generator of random numbers belongs to the whole process: whoever draws from it holds this, and has it alone.
static GENERATOR: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    // A test that failed while it had it leaves nothing behind: each seeds it anew.
    GENERATOR.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A dataset of chains on two small sizes.
fn dataset() -> (TempDir, Dataset) {
    let config = Config::from_toml(
        "count = 80\nper_shard = 16\nsource = 'chains'\nsizes = ['14x11', '10x20']\npresets = ['plain', 'noisy']\n\
         starts = ['row_zigzag']\nlayouts = [{ name = 'voronoi' }, { name = 'islands', side = 3 }]",
    );
    let factory = Factory::new(config.unwrap(), Vec::new()).unwrap();
    let folder = tempdir().unwrap();
    let settings = GenerateSettings { slice: Slice::WHOLE, threads: 2, cancel: &NEVER, observer: &|_| {} };
    generate(&factory, folder.path(), &settings).unwrap();
    let dataset = Dataset::open(folder.path()).unwrap();
    (folder, dataset)
}

/// A network and a training that take a second.
fn small() -> Training {
    Training {
        width: 4,
        hidden: 8,
        history: 4,
        steps: 12,
        batch: 8,
        per_trajectory: 64,
        pool: 2,
        warm_up: 3,
        evaluate_every: 5,
        valid_batches: 2,
        threads: 1,
        ..Training::default()
    }
}

fn layer(width: u32, height: u32, seed: u64) -> (Region, Zones, Layer) {
    let region = Region::rectangle(width, height).unwrap();
    let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
    let layer = Layer::new(&region, &zones);
    (region, zones, layer)
}

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
        let pixel = &mut image[((y * canvas.width + x) * CHANNELS as u32) as usize..][..CHANNELS as usize];
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
        let mut path = Start::RowZigzag.path(&region).unwrap();
        let initial = layer.crossings().count(&path);
        let mut made = Vec::new();
        for turn in 0..seed {
            let mut all = Vec::new();
            path.for_each_variant(&[MoveKind::Transpose, MoveKind::Flip], |placed| all.push(placed));
            let placed = all[(turn * 7919) as usize % all.len()];
            let before = layer.crossings().count(&path);
            assert!(path.apply_variant(placed));
            made.push(Made { placed, before, after: layer.crossings().count(&path) });
        }
        let links = Links::new(&path);
        let crossings = layer.crossings().count(&path);
        let state = State { layer: &layer, links: &links, crossings, initial, made: &made };
        for symmetry in Symmetry::ALL {
            let (width, height) = symmetry.size(size);
            let canvas = Canvas::holding((width, height));
            let mut inputs = Inputs::new(canvas, 3);
            inputs.push(&state, symmetry);
            let (image, history) = inputs.tensors(Device::Cpu);
            assert_eq!(image.size(), [1, CHANNELS, i64::from(canvas.height), i64::from(canvas.width)]);
            let image = Vec::<f32>::try_from(image.permute([0, 2, 3, 1]).contiguous().view([-1])).unwrap();
            let mapped = |cell: u32| {
                let (x, y) = symmetry.cell(region.xy(cell), size);
                y * width + x
            };
            let mapped_region = Region::rectangle(width, height).unwrap();
            let mut ids = vec![0; region.plane_len()];
            region.cells().for_each(|cell| ids[mapped(cell) as usize] = zones.id(cell));
            let mapped_zones = Zones::new(&mapped_region, ids).unwrap();
            let order: Vec<u32> = path.order().iter().map(|&cell| mapped(cell)).collect();
            let expected = image_by_definition(&mapped_region, &mapped_zones, &order, initial, canvas);
            let apart = image.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart < 1e-6, "seed {seed}, {symmetry:?}: {apart}");
            let mask = Vec::<f32>::try_from(history.mask.view([-1])).unwrap();
            assert_eq!(mask.iter().sum::<f32>() as usize, made.len().min(3));
            let last = made.len().saturating_sub(3);
            for (at, made) in made[last..].iter().enumerate() {
                let placed = symmetry.placed(made.placed, size);
                let told = |tensor: &Tensor| tensor.int64_value(&[0, at as i64]);
                assert_eq!(told(&history.action), i64::from(placed.variant.class()));
                assert_eq!((told(&history.x), told(&history.y)), (placed.x.into(), placed.y.into()));
            }
        }
    }
}

#[test]
#[should_panic(expected = "do not fit on")]
fn a_canvas_that_is_too_small_is_refused() {
    let (region, _, layer) = layer(20, 9, 0);
    let path = Start::RowZigzag.path(&region).unwrap();
    let state = State { layer: &layer, links: &Links::new(&path), crossings: 1, initial: 1, made: &[] };
    Inputs::new(Canvas { height: 16, width: 16 }, 3).push(&state, Symmetry::ALL[0]);
}

/// The loss as a loop over cells.
fn loss_by_definition(
    (scores, logits): (&[Vec<f64>], &[Vec<Vec<f64>>]),
    (positions, actions, rivals): (&[usize], &[usize], &[Vec<bool>]),
    width: usize,
    settings: &LossSettings,
) -> f64 {
    let log_softmax = |logits: &[f64], at: usize| {
        let most = logits.iter().copied().fold(f64::MIN, f64::max);
        logits[at] - most - logits.iter().map(|logit| (logit - most).exp()).sum::<f64>().ln()
    };
    let entropy = |logits: &[f64], truth: usize, smoothing: f64| {
        let all: f64 = (0..logits.len()).map(|at| -log_softmax(logits, at)).sum();
        (1.0 - smoothing) * -log_softmax(logits, truth) + smoothing * all / logits.len() as f64
    };
    let (mut ranking, mut ranked, mut classification) = (0.0, 0, 0.0);
    let (mut action, mut neighbours, mut neighbour_count) = (0.0, 0.0, 0);
    for (example, &truth) in positions.iter().enumerate() {
        let of_rivals = scores[example].iter().zip(&rivals[example]).filter(|(_, rival)| **rival);
        let mut others: Vec<f64> = of_rivals.map(|(&score, _)| score).collect();
        others.sort_by(|a, b| b.total_cmp(a));
        for other in others.iter().take(settings.hardest as usize) {
            ranking += (settings.margin - scores[example][truth] + other).max(0.0);
            ranked += 1;
        }
        others.insert(0, scores[example][truth]);
        classification -= log_softmax(&others, 0);
        let at = |cell: usize| -> Vec<f64> { logits[example].iter().map(|of| of[cell]).collect() };
        action += entropy(&at(truth), actions[example], settings.smoothing);
        let (x, y, height) = (truth % width, truth / width, scores[example].len() / width);
        let sides = [
            (x > 0).then(|| truth - 1),
            (x + 1 < width).then(|| truth + 1),
            (y > 0).then(|| truth - width),
            (y + 1 < height).then(|| truth + width),
        ];
        for cell in sides.into_iter().flatten() {
            neighbours += entropy(&at(cell), actions[example], settings.neighbour_smoothing);
            neighbour_count += 1;
        }
    }
    let count = positions.len() as f64;
    let position = match settings.position {
        PositionLoss::Ranking => ranking / f64::from(ranked.max(1)),
        PositionLoss::Classification => classification / count,
    };
    position + action / count + settings.neighbours * neighbours / f64::from(neighbour_count.max(1))
}

#[test]
fn the_loss_is_the_one_of_a_loop_over_cells() {
    let _alone = alone();
    tch::manual_seed(3);
    let (batch, height, width) = (4_usize, 5_usize, 6_usize);
    let cells = height * width;
    for round in 0..50 {
        let draw = |channels: i64| {
            Tensor::randn([batch as i64, channels, height as i64, width as i64], (Kind::Double, Device::Cpu))
        };
        let proposals =
            Proposals { position: draw(1).to_kind(Kind::Float), action: draw(12).to_kind(Kind::Float) };
        let scores: Vec<Vec<f64>> =
            Vec::try_from(proposals.position.view([batch as i64, -1]).to_kind(Kind::Double)).unwrap();
        let flat: Vec<f64> =
            Vec::try_from(proposals.action.contiguous().view([-1]).to_kind(Kind::Double)).unwrap();
        let logits: Vec<Vec<Vec<f64>>> =
            flat.chunks(12 * cells).map(|of| of.chunks(cells).map(<[f64]>::to_vec).collect()).collect();
        let positions: Vec<usize> = (0..batch).map(|at| (round * 7 + at * 11) % cells).collect();
        let actions: Vec<usize> = (0..batch).map(|at| (round + at * 5) % 12).collect();
        let rivals: Vec<Vec<bool>> = (0..batch)
            .map(|at| {
                (0..cells).map(|cell| cell != positions[at] && (cell * 31 + round * at) % 3 == 0).collect()
            })
            .collect();
        let whole =
            |numbers: &[usize]| Tensor::from_slice(&numbers.iter().map(|&n| n as i64).collect::<Vec<_>>());
        let targets = Targets {
            position: whole(&positions),
            action: whole(&actions),
            rivals: Tensor::from_slice(&rivals.concat()).view([batch as i64, -1]),
        };
        for position in [PositionLoss::Ranking, PositionLoss::Classification] {
            for hardest in [1, 3, 1000] {
                let settings = LossSettings { position, hardest, ..LossSettings::default() };
                let expected =
                    loss_by_definition((&scores, &logits), (&positions, &actions, &rivals), width, &settings);
                let got = loss(&proposals, &targets, &settings).double_value(&[]);
                assert!((got - expected).abs() < 1e-4, "{position:?}, {hardest}: {got} for {expected}");
            }
        }
        for (at, hits) in Hits::each(&proposals, &targets).into_iter().enumerate() {
            let above = (0..cells)
                .filter(|&cell| rivals[at][cell] && scores[at][cell] >= scores[at][positions[at]])
                .count();
            let likeliest = (0..12)
                .max_by(|&a, &b| logits[at][a][positions[at]].total_cmp(&logits[at][b][positions[at]]));
            let expected = [above < 1, above < 5, likeliest == Some(actions[at])].map(u64::from);
            assert_eq!([hits.top_1, hits.top_5, hits.action], expected);
        }
    }
}

#[test]
fn adamw_steps_as_its_equations_say() {
    let settings = AdamWSettings { weight_decay: 0.1, ..AdamWSettings::default() };
    let start = [0.5, -1.5, 2.0];
    let parameter = Tensor::from_slice(&start).set_requires_grad(true);
    let mut optimiser = AdamW::new(vec![parameter.shallow_clone()], settings);
    let (mut x, mut mean, mut square) = (start, [0.0; 3], [0.0; 3]);
    for step in 1..=20 {
        optimiser.zero_grad();
        // f = sum of x^4 / 4, whose gradient x^3 is clipped to length 2.
        (parameter.pow_tensor_scalar(4) / 4.0).sum(Kind::Double).backward();
        let length = optimiser.step(0.05, 2.0);
        let gradient = x.map(|x: f64| x.powi(3));
        let expected_length = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
        assert!((length - expected_length).abs() < 1e-4);
        let shorter = (2.0 / expected_length).min(1.0);
        for at in 0..3 {
            let g = gradient[at] * shorter;
            mean[at] = 0.9 * mean[at] + 0.1 * g;
            square[at] = 0.999 * square[at] + 0.001 * g * g;
            let root = (square[at] / (1.0 - 0.999_f64.powi(step))).sqrt() + 1e-8;
            x[at] -= 0.05 * (0.1 * x[at] + mean[at] / (1.0 - 0.9_f64.powi(step)) / root);
        }
        let got = Vec::<f64>::try_from(&parameter).unwrap();
        assert!(got.iter().zip(x).all(|(got, x)| (got - x).abs() < 1e-5), "{got:?} {x:?}");
    }
    let before = Vec::<f64>::try_from(&parameter).unwrap();
    optimiser.zero_grad();
    (&parameter * f64::NAN).sum(Kind::Double).backward();
    assert!(!optimiser.step(0.05, 2.0).is_finite());
    assert_eq!(Vec::<f64>::try_from(&parameter).unwrap(), before);
}

#[test]
fn batches_hold_needed_moves_of_their_own_part() {
    let (_folder, dataset) = dataset();
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
    let key = |batches: &[Batch]| batches.iter().flat_map(|batch| batch.position.clone()).collect::<Vec<_>>();
    assert_eq!(key(&first), key(&again));
    assert_ne!(key(&first), key(&other));
    for batch in &first {
        let cells = batch.inputs.canvas().cells();
        assert!(batch.inputs.len() <= 8 && batch.rivals.len() == cells * batch.inputs.len());
        for (at, &position) in batch.position.iter().enumerate() {
            assert!(!batch.rivals[at * cells + position as usize], "the truth is no rival of itself");
        }
    }
    let mut skipped = Batches::new(&dataset, Split::Train, &settings, 0);
    assert_eq!(skipped.skip_batches(5).unwrap(), 5);
    let rest: Vec<Batch> = skipped.collect::<Result<_, _>>().unwrap();
    assert_eq!(key(&rest), key(&first[5..]));
    let boundary =
        beadwork_learn::fusion::samples::SampleSettings { rivals: Rivals::Boundary, ..settings.clone() };
    assert!(
        Batches::new(&dataset, Split::Valid, &boundary, 0).all(|batch| batch.unwrap().rivals.contains(&true))
    );
}

/// Trains with a limit of steps after which it is cancelled, and notes the losses.
fn run(
    dataset: &Dataset,
    training: &Training,
    out: &Path,
    cancel_after: u64,
) -> (Result<End, TrainError>, Vec<f64>) {
    let cancel = AtomicBool::new(false);
    let mut losses = Vec::new();
    let mut observer = |event: &Event| {
        if let Event::Step { step, loss, .. } = event {
            losses.push(*loss);
            cancel.store(*step >= cancel_after, Ordering::Relaxed);
        }
    };
    let end =
        train(dataset, training, Run { device: Device::Cpu, out, cancel: &cancel, observer: &mut observer });
    (end, losses)
}

#[test]
fn a_run_that_was_stopped_goes_on_with_the_same_losses() {
    let _alone = alone();
    let (_folder, dataset) = dataset();
    let (whole, parts) = (tempdir().unwrap(), tempdir().unwrap());
    let training = small();
    let (end, losses) = run(&dataset, &training, whole.path(), u64::MAX);
    assert_eq!((end.unwrap(), losses.len()), (End::Done, 12));
    let mut joined = Vec::new();
    for (stop_at, expected) in [(4, End::Cancelled), (9, End::Cancelled), (u64::MAX, End::Done)] {
        let (end, losses) = run(&dataset, &training, parts.path(), stop_at);
        assert_eq!(end.unwrap(), expected);
        joined.extend(losses);
    }
    assert_eq!(joined, losses);
    let bytes = |folder: &TempDir| fs::read(Model::weights_file(folder.path())).unwrap();
    assert_eq!(bytes(&whole), bytes(&parts));
    let model = Model::open(whole.path(), Device::Cpu).unwrap();
    assert_eq!(model.training, training);
}

#[test]
fn what_can_not_be_trained_is_told_and_leaves_checkpoints_as_they_are() {
    let _alone = alone();
    let (_folder, dataset) = dataset();
    let out = tempdir().unwrap();
    let training = small();
    run(&dataset, &training, out.path(), u64::MAX).0.unwrap();
    let checkpoint = last_checkpoint(out.path());
    let before = fs::read(&checkpoint).unwrap();
    let fail =
        |training: &Training, out: &Path| run(&dataset, training, out, u64::MAX).0.unwrap_err().to_string();

    let error = fail(&Training { rate: 1e-3, ..training.clone() }, out.path());
    assert!(error.contains("another configuration"), "{error}");
    let error = fail(&Training { width: 24, ..training.clone() }, out.path());
    assert!(error.contains("'width' is 24"), "{error}");
    assert_eq!(fs::read(&checkpoint).unwrap(), before);

    // Steps so long that the weights overflow.
    let wild = tempdir().unwrap();
    let training = Training { rate: 1e30, warm_up: 0, evaluate_every: 1, ..training };
    let error = fail(&training, wild.path());
    assert!(error.contains("is no number"), "{error}");
    let saved = fs::read(last_checkpoint(wild.path())).unwrap();
    assert!(!saved.is_empty());
    let error = fail(&training, wild.path());
    assert!(error.contains("is no number"), "{error}");
    assert_eq!(fs::read(last_checkpoint(wild.path())).unwrap(), saved);

    fs::write(&checkpoint, &before[..before.len() / 2]).unwrap();
    let error = fail(&small(), out.path());
    assert!(error.contains("is no file of weights"), "{error}");
    fs::write(&checkpoint, fs::read(Model::weights_file(out.path())).unwrap()).unwrap();
    let error = fail(&small(), out.path());
    assert!(error.contains("is no checkpoint: it has no 'run.configuration'"), "{error}");
}

#[test]
fn a_folder_that_holds_no_model_is_told() {
    let _alone = alone();
    let folder = tempdir().unwrap();
    let open = || Model::open(folder.path(), Device::Cpu).unwrap_err();
    assert!(matches!(open(), ModelError::Unreadable { .. }));
    let config = Model::config_file(folder.path());
    fs::write(&config, "wide = 3\n").unwrap();
    assert!(open().to_string().contains("wide"), "{}", open());
    fs::write(&config, "width = -3\n").unwrap();
    assert!(open().to_string().contains("'width' is -3"), "{}", open());
    fs::write(&config, "width = 4\nhidden = 8\n").unwrap();
    assert!(matches!(open(), ModelError::Weights(_)));
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

#[test]
fn walks_make_better_paths_and_count_every_move() {
    let _alone = alone();
    tch::manual_seed(1);
    let training = small();
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), training.network());
    let layers: Vec<_> = (0..6).map(|seed| layer(12 + seed as u32 % 3, 10, seed)).collect();
    let starts: Vec<_> = layers.iter().map(|(region, ..)| Start::RowZigzag.path(region).unwrap()).collect();
    let mut tasks = Vec::new();
    for ((_, _, layer), start) in layers.iter().zip(&starts) {
        tasks.push(Task { layer, start, target: 5 });
    }
    let mut proposers: [Box<dyn Proposer>; 2] =
        [Box::new(Asked::new(&network, Device::Cpu)), Box::new(AllMoves::new(0))];
    for proposer in &mut proposers {
        for returns in [true, false] {
            let settings = WalkSettings { budget: 150, returns, ..WalkSettings::default() };
            let walked = walk(&tasks, proposer.as_mut(), &settings);
            for (((region, _, layer), start), walked) in layers.iter().zip(&starts).zip(&walked) {
                assert_eq!(verify(region, walked.path.order()), Ok(1));
                assert_eq!(walked.crossings, layer.crossings().count(&walked.path));
                assert_eq!(walked.initial, layer.crossings().count(start));
                assert!(walked.crossings <= walked.initial && walked.moves.len() <= walked.made);
                assert!(walked.perturbed <= walked.made && walked.made <= 150);
                assert_eq!(walked.stop == Stop::Optimal, walked.crossings <= 5);
                let mut path = start.clone();
                assert!(walked.moves.iter().all(|step| step.apply(&mut path)));
                assert_eq!(path.order(), walked.path.order());
            }
        }
    }
    let cancel = AtomicBool::new(true);
    let settings = WalkSettings { cancel: Some(&cancel), ..WalkSettings::default() };
    let walked = walk(&tasks, &mut AllMoves::new(0), &settings);
    assert!(walked.iter().all(|walked| walked.made == 0));
}

/// Layers asked about together get the proposals that each gets alone, whatever their sizes.
#[test]
fn proposals_do_not_depend_on_the_company() {
    let _alone = alone();
    tch::manual_seed(1);
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), small().network());
    let layers: Vec<_> = (0..5).map(|seed| layer(12 + 6 * (seed as u32 % 2), 10, seed)).collect();
    let links: Vec<_> =
        layers.iter().map(|(region, ..)| Links::new(&Start::RowZigzag.path(region).unwrap())).collect();
    let states: Vec<_> = layers
        .iter()
        .zip(&links)
        .map(|((.., layer), links)| State { layer, links, crossings: 9, initial: 10, made: &[] })
        .collect();
    let mut asked = Asked { places: 3, ..Asked::new(&network, Device::Cpu) };
    let together = asked.propose(&states);
    for (state, proposed) in states.iter().zip(&together) {
        let alone = asked.propose(std::slice::from_ref(state)).pop().unwrap();
        assert_eq!(alone.len(), proposed.len());
        assert!(proposed.is_sorted_by(|a, b| a.score >= b.score));
        for (one, other) in alone.iter().zip(proposed) {
            assert_eq!((one.placed, one.change), (other.placed, other.change));
            assert!((one.score - other.score).abs() < 1e-4);
            assert_eq!(one.change, state.layer.change(one.placed));
            assert!(state.links.allows_variant(one.placed));
        }
        let places: std::collections::HashSet<_> =
            proposed.iter().map(|one| (one.placed.x, one.placed.y)).collect();
        assert!(places.len() <= 3);
    }
}
