//! Whole runs in temporary folders: interrupted, split, disturbed.

use std::collections::BTreeMap;

use super::*;
use crate::{Config, Dataset};

const SMALL: &str = "count = 23\nper_shard = 5\nsizes = ['9x8']\npresets = ['short']\nlayouts = [{ name = 'voronoi' }, { name = 'stripes' }]";

fn factory(toml: &str) -> Factory {
    Factory::new(Config::from_toml(toml).unwrap(), Vec::new()).unwrap()
}

fn run(toml: &str, folder: &Path, slice: &str, threads: usize) -> Result<Generated, GenerateError> {
    let cancel = AtomicBool::new(false);
    let settings = GenerateSettings {
        slice: slice.parse().unwrap(),
        threads,
        cancel: &cancel,
        observer: &|_| {},
    };
    generate(&factory(toml), folder, &settings)
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
    assert_eq!((generated.made, generated.kept, generated.missing), (23, 0, 0));
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
    records.iter().for_each(|it| drop(it.replay().unwrap()));
    let times = search_times(&folder.path().join("shard-00004.bws")).unwrap();
    assert!(times.len() == 3 && times.iter().all(|&milliseconds| milliseconds > 0.0), "{times:?}");
    assert_eq!(search_times(&folder.path().join("shard-00005.bws")), None);
}

#[test]
fn threads_do_not_change_a_byte() {
    let (_whole, expected) = whole();
    for threads in [2, 5] {
        let folder = tempfile::tempdir().unwrap();
        run(SMALL, folder.path(), "1/1", threads).unwrap();
        assert_eq!(bytes(folder.path()), expected);
    }
}

#[test]
fn slices_equal_a_whole_run_in_any_order() {
    let (_whole, expected) = whole();
    for (of, order) in [(2, vec![2, 1]), (3, vec![2, 3, 1]), (9, (1..=9).collect())] {
        let folder = tempfile::tempdir().unwrap();
        for (place, part) in order.iter().enumerate() {
            let generated = run(SMALL, folder.path(), &format!("{part}/{of}"), 2).unwrap();
            let last = place + 1 == order.len();
            assert_eq!((generated.manifest.is_some(), generated.missing == 0), (last, last));
        }
        assert_eq!(bytes(folder.path()), expected, "{of} slices");
    }
}

#[test]
fn slices_at_work_together_equal_a_whole_run() {
    let (_whole, expected) = whole();
    for _ in 0..10 {
        let folder = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for part in 1..=3 {
                let folder = folder.path();
                scope.spawn(move || run(SMALL, folder, &format!("{part}/3"), 1).unwrap());
            }
        });
        assert_eq!(bytes(folder.path()), expected, "the last one to end writes the manifest");
    }
}

#[test]
fn a_cancelled_run_goes_on() {
    let (_whole, expected) = whole();
    for stop_after in [0, 1, 7, 12, 22] {
        let folder = tempfile::tempdir().unwrap();
        let cancel = AtomicBool::new(stop_after == 0);
        let observer = |progress: GenerateProgress| {
            cancel.store(progress.done >= stop_after, Ordering::Relaxed)
        };
        let settings = GenerateSettings {
            slice: Slice::WHOLE,
            threads: 2,
            cancel: &cancel,
            observer: &observer,
        };
        let generated = generate(&factory(SMALL), folder.path(), &settings).unwrap();
        assert!(generated.cancelled && generated.manifest.is_none());
        let kept = generated.made;
        let generated = run(SMALL, folder.path(), "1/1", 2).unwrap();
        assert_eq!((generated.kept, generated.made), (kept, 23 - kept));
        assert_eq!(bytes(folder.path()), expected);
    }
}

#[test]
fn running_again_changes_nothing() {
    let (folder, expected) = whole();
    let generated = run(SMALL, folder.path(), "1/1", 2).unwrap();
    assert_eq!((generated.made, generated.kept), (0, 23));
    assert_eq!(bytes(folder.path()), expected);
}

#[test]
fn a_lost_shard_is_made_again() {
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
        error.starts_with("cannot go on from '") && error.contains("shard-00001.bws"),
        "{error}"
    );
}

#[test]
fn a_folder_that_can_not_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let taken = folder.path().join("taken");
    fs::write(&taken, "a file").unwrap();
    let error = run(SMALL, &taken, "1/1", 1).unwrap_err().to_string();
    assert!(error.starts_with("cannot write '") && error.contains("taken"), "{error}");
}

#[test]
fn blocks_are_cut_by_number_and_size() {
    let lengths = |sizes: &[usize]| {
        chunks(sizes, |&size| size).iter().map(|chunk| chunk.len()).collect::<Vec<_>>()
    };
    assert!(lengths(&[]).is_empty());
    assert_eq!(lengths(&[1; 70]), [32, 32, 6]);
    assert_eq!(lengths(&[BLOCK_BYTES, 1, BLOCK_BYTES - 1, 1, 1]), [1, 2, 2]);
    assert_eq!(lengths(&[10 * BLOCK_BYTES; 3]), [1, 1, 1]);
}

#[test]
fn leftovers_of_killed_runs_go_with_the_manifest() {
    let folder = tempfile::tempdir().unwrap();
    let left = folder.path().join(".shard-00001.bws.1.partial");
    fs::write(&left, "half a shard").unwrap();
    run(SMALL, folder.path(), "1/2", 1).unwrap();
    assert!(left.exists(), "another slice may be writing it");
    run(SMALL, folder.path(), "2/2", 1).unwrap();
    assert!(!left.exists());
}

#[test]
fn slices_are_read_and_refused() {
    assert_eq!("1/1".parse(), Ok(Slice::WHOLE));
    assert_eq!("2/5".parse::<Slice>().unwrap().to_string(), "2/5");
    for text in ["0/2", "3/2", "1/0", "1", "a/b", "1/2/3", "-1/2"] {
        assert_eq!(text.parse::<Slice>(), Err(SliceError(text.to_owned())));
    }
    let covered: Vec<u32> = (1..=4).flat_map(|part| Slice { part, of: 4 }.shards(10)).collect();
    assert_eq!(covered, (0..10).collect::<Vec<_>>());
}
