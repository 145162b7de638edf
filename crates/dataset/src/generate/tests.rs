//! Runs in temporary folders: interrupted, divided, with damaged files.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use beadwork_base::{CancelToken, Control, Interrupted, Progress, Threads};
use rayon::ThreadPoolBuilder;

use super::shards::{BLOCK_BYTES, split_into_blocks};
use super::*;
use crate::{Config, Dataset, Factory, Trajectory};

const SMALL: &str = "\
count = 23
per_shard = 5
sizes = ['9x8']
presets = ['short']
layouts = [{ name = 'voronoi' }, { name = 'stripes' }]
";

fn factory(toml: &str) -> Factory {
    Factory::new(Config::from_toml(toml).unwrap(), Vec::new(), &Control::default()).unwrap()
}

/// Makes a range of shards; 1 thread stands for the calling thread.
fn run(toml: &str, folder: &Path, shards: &str, threads: usize) -> Result<Outcome, GenerateError> {
    let settings = Settings { shards: shards.parse().unwrap() };
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let control = Control::on(if threads > 1 { Threads::Pool(&pool) } else { Threads::One });
    generate(&factory(toml), folder, &settings, &control)
}

/// Name and bytes of every file that belongs to the dataset.
fn bytes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let named = files.map(|path| {
        (path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(&path).unwrap())
    });
    named.filter(|(name, _)| !name.ends_with(".ms.csv")).collect()
}

fn whole() -> (tempfile::TempDir, BTreeMap<String, Vec<u8>>) {
    let folder = tempfile::tempdir().unwrap();
    let generated = run(SMALL, folder.path(), "1/1", 1).unwrap();
    assert_eq!((generated.made, generated.kept, generated.missing_shards), (23, 0, 0));
    let files = bytes(folder.path());
    assert_eq!(files.len(), 6, "five shards and the manifest");
    (folder, files)
}

#[test]
fn the_dataset_holds_every_trajectory_in_order() {
    let (folder, _) = whole();
    let dataset = Dataset::open(folder.path()).unwrap();
    let records: Vec<Trajectory> = dataset.records().collect::<Result<_, _>>().unwrap();
    assert_eq!(records.iter().map(|it| it.index).collect::<Vec<_>>(), (0..23).collect::<Vec<_>>());
    assert_eq!(
        dataset.manifest().moves,
        records.iter().map(|it| it.moves.len() as u64).sum::<u64>()
    );
    assert_eq!(dataset.manifest().strata["voronoi/9x8/short"], 12);
    assert_eq!(dataset.manifest().fingerprint(), factory(SMALL).fingerprint());
    records.iter().for_each(|it| drop(it.replay(&Control::default()).unwrap()));
    let times = search_times(&folder.path().join("shard-00004.bws")).unwrap();
    assert!(times.len() == 3 && times.iter().all(|&milliseconds| milliseconds > 0.0), "{times:?}");
    assert_eq!(search_times(&folder.path().join("shard-00005.bws")), None);
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let (_whole, expected) = whole();
    for threads in [2, 5] {
        let folder = tempfile::tempdir().unwrap();
        run(SMALL, folder.path(), "1/1", threads).unwrap();
        assert_eq!(bytes(folder.path()), expected);
    }
}

#[test]
fn shard_ranges_equal_a_whole_run_in_any_order() {
    let (_whole, expected) = whole();
    for (parts, order) in [(2, vec![2, 1]), (3, vec![2, 3, 1]), (9, (1..=9).collect())] {
        let folder = tempfile::tempdir().unwrap();
        for (index, part) in order.iter().enumerate() {
            let generated = run(SMALL, folder.path(), &format!("{part}/{parts}"), 2).unwrap();
            let last = index + 1 == order.len();
            let finished = (generated.manifest.is_some(), generated.missing_shards == 0);
            assert_eq!(finished, (last, last));
        }
        assert_eq!(bytes(folder.path()), expected, "{parts} shard ranges");
    }
}

#[test]
fn concurrent_runs_equal_a_whole_run() {
    let (_whole, expected) = whole();
    for _ in 0..10 {
        let folder = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for part in 1..=3 {
                let folder = folder.path();
                scope.spawn(move || run(SMALL, folder, &format!("{part}/3"), 1).unwrap());
            }
        });
        assert_eq!(bytes(folder.path()), expected, "the last run to end writes the manifest");
    }
}

#[test]
fn a_cancelled_run_can_be_continued() {
    let (_whole, expected) = whole();
    // After 22, the last one may already be under way on the other thread.
    for stop_after in [0, 1, 7, 12, 21] {
        let folder = tempfile::tempdir().unwrap();
        let cancel = CancelToken::new();
        let report = |progress: Progress| {
            assert_eq!(progress.total, 23);
            if progress.done >= stop_after {
                cancel.cancel();
            }
        };
        let pool = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let control = Control {
            threads: Threads::Pool(&pool),
            cancel: Some(&cancel),
            progress: Some(&report),
            ..Control::default()
        };
        let settings = Settings::default();
        let generated = generate(&factory(SMALL), folder.path(), &settings, &control).unwrap();
        assert_eq!(generated.interrupted, Some(Interrupted::Cancelled));
        assert!(generated.manifest.is_none());
        let kept = generated.made;
        let generated = run(SMALL, folder.path(), "1/1", 2).unwrap();
        assert_eq!((generated.kept, generated.made), (kept, 23 - kept));
        assert_eq!(bytes(folder.path()), expected);
    }
}

#[test]
fn a_time_limit_interrupts() {
    let folder = tempfile::tempdir().unwrap();
    let is_up = || true;
    let control = Control { time_is_up: Some(&is_up), ..Control::default() };
    let error = generate(&factory(SMALL), folder.path(), &Settings::default(), &control);
    let error = error.unwrap_err();
    assert!(matches!(error, GenerateError::Interrupted(Interrupted::TimeUp)), "{error}");
}

#[test]
fn running_again_changes_nothing() {
    let (folder, expected) = whole();
    let generated = run(SMALL, folder.path(), "1/1", 2).unwrap();
    assert_eq!((generated.made, generated.kept), (0, 23));
    assert_eq!(bytes(folder.path()), expected);
}

#[test]
fn a_missing_shard_is_made_again() {
    let (folder, expected) = whole();
    fs::remove_file(folder.path().join("shard-00002.bws")).unwrap();
    assert_eq!(run(SMALL, folder.path(), "1/1", 1).unwrap().made, 5);
    assert_eq!(bytes(folder.path()), expected);
}

#[test]
fn another_dataset_is_left_alone() {
    let (folder, expected) = whole();
    let other = SMALL.replace("count = 23", "count = 22");
    let error = run(&other, folder.path(), "1/1", 1).unwrap_err();
    assert!(
        matches!(&error, GenerateError::OtherDataset { path } if path.ends_with("manifest.json")),
        "{error}"
    );
    fs::remove_file(folder.path().join("manifest.json")).unwrap();
    let error = run(&other, folder.path(), "1/1", 1).unwrap_err();
    assert!(
        matches!(&error, GenerateError::OtherDataset { path } if path.ends_with("shard-00000.bws")),
        "{error}"
    );
    run(SMALL, folder.path(), "1/1", 1).unwrap();
    assert_eq!(bytes(folder.path()), expected);
}

#[test]
fn a_damaged_shard_is_named() {
    let (folder, _) = whole();
    let path = folder.path().join("shard-00001.bws");
    let mut damaged = fs::read(&path).unwrap();
    damaged[100] ^= 1;
    fs::write(&path, damaged).unwrap();
    let error = run(SMALL, folder.path(), "1/1", 1).unwrap_err().to_string();
    assert!(
        error.starts_with("cannot continue from '") && error.contains("shard-00001.bws"),
        "{error}"
    );
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let taken = folder.path().join("taken");
    fs::write(&taken, "a file").unwrap();
    let error = run(SMALL, &taken, "1/1", 1).unwrap_err().to_string();
    assert!(error.starts_with("cannot write '") && error.contains("taken"), "{error}");
}

#[test]
fn blocks_are_limited_by_number_and_size() {
    let lengths = |sizes: &[usize]| {
        split_into_blocks(sizes, |&size| size).iter().map(|block| block.len()).collect::<Vec<_>>()
    };
    assert!(lengths(&[]).is_empty());
    assert_eq!(lengths(&[1; 70]), [32, 32, 6]);
    assert_eq!(lengths(&[BLOCK_BYTES, 1, BLOCK_BYTES - 1, 1, 1]), [1, 2, 2]);
    assert_eq!(lengths(&[10 * BLOCK_BYTES; 3]), [1, 1, 1]);
}

#[test]
fn temporary_files_of_killed_runs_are_removed_with_the_last_shard() {
    let folder = tempfile::tempdir().unwrap();
    let left = folder.path().join(".shard-00001.bws.1.partial");
    fs::write(&left, "half a shard").unwrap();
    run(SMALL, folder.path(), "1/2", 1).unwrap();
    assert!(left.exists(), "another run may be writing it");
    run(SMALL, folder.path(), "2/2", 1).unwrap();
    assert!(!left.exists());
}
