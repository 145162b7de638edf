//! Records of real searches, and forged records.

use beadwork_base::Control;
use beadwork_grid::{Crossings, Links, Path, Switch, verify};
use beadwork_search::Move;

use super::*;
use crate::config::Config;
use crate::factory::Factory;

fn make(toml: &str) -> Trajectory {
    let config = Config::from_toml(toml).unwrap();
    let factory = Factory::new(config, Vec::new(), &Control::default()).unwrap();
    factory.trajectory(0, &Control::default()).unwrap()
}

fn replay(trajectory: &Trajectory) -> Result<Path, ReplayError> {
    trajectory.replay(&Control::default())
}

fn of_variants() -> Trajectory {
    make("count = 1\nlayouts = [{ name = 'stripes' }]\nsizes = ['16x12']\npresets = ['paper']")
}

fn of_pairs() -> Trajectory {
    make("count = 1\nlayouts = [{ name = 'stripes' }]\nsizes = ['16x12']\npresets = ['fast']")
}

#[test]
fn a_replay_gives_the_recorded_path() {
    for trajectory in [of_variants(), of_pairs()] {
        let path = replay(&trajectory).unwrap();
        let (region, zones) = trajectory.draw().unwrap();
        assert_eq!(verify(&region, path.order()), Ok(1));
        assert_eq!(Crossings::new(&region, &zones).count(&path), trajectory.best);
        assert!(
            trajectory.best < trajectory.initial && trajectory.bound.unwrap() <= trajectory.best
        );
    }
}

#[test]
fn steps_are_consecutive_and_mark_new_bests() {
    let trajectory = of_variants();
    let steps: Vec<Step> = trajectory.steps().collect();
    assert_eq!(steps.len(), trajectory.moves.len());
    assert_eq!(
        (steps[0].before, steps.last().unwrap().after),
        (trajectory.initial, trajectory.best)
    );
    assert!(steps.windows(2).all(|pair| pair[0].after == pair[1].before));
    let mut best = trajectory.initial;
    for step in steps {
        assert_eq!(step.effective, step.after < best);
        best = best.min(step.after);
    }
}

#[test]
fn forged_numbers_are_found() {
    let forge = |change: &dyn Fn(&mut Trajectory)| {
        let mut forged = of_variants();
        change(&mut forged);
        replay(&forged).unwrap_err()
    };
    let number = |error: &ReplayError| matches!(error, ReplayError::Number { .. });
    assert!(number(&forge(&|it| it.initial += 1)));
    assert!(number(&forge(&|it| it.best -= 1)));
    assert!(number(&forge(&|it| it.zones += 1)));
    assert!(number(&forge(&|it| it.pieces = 2)));
    assert!(number(&forge(&|it| it.bound = Some(3))));
    assert!(matches!(forge(&|it| it.width = 0), ReplayError::Draw(_)));
    assert!(matches!(
        forge(&|it| it.width += 1),
        ReplayError::Number { .. } | ReplayError::Refused { .. }
    ));
}

#[test]
fn forged_moves_are_found() {
    let length = of_variants().moves.len();
    let mut kinds = [0; 3];
    for index in 0..length {
        for shift in [1, 5] {
            let mut forged = of_variants();
            let Moves::Variants { class, change, .. } = &mut forged.moves else {
                panic!("the paper's annealer uses variants")
            };
            match shift {
                1 => class[index] = (class[index] + 1) % 12,
                _ => change[index] += 1,
            }
            match replay(&forged).unwrap_err() {
                ReplayError::Refused { index: at } if at >= index => kinds[0] += 1,
                ReplayError::Crossings { index: at, .. } if at >= index => kinds[1] += 1,
                error => panic!("move {index}: {error}"),
            }
        }
        let mut forged = of_variants();
        let Moves::Variants { class, .. } = &mut forged.moves else { unreachable!() };
        class[index] = 12;
        assert_eq!(replay(&forged).unwrap_err(), ReplayError::NoMove { index });
        kinds[2] += 1;
    }
    assert!(kinds.iter().all(|&count| count > 10), "{kinds:?}");
}

#[test]
fn columns_of_different_lengths_and_moves_past_the_best_are_found() {
    let mut forged = of_pairs();
    let Moves::Pairs { first, .. } = &mut forged.moves else {
        panic!("the free annealer uses pairs")
    };
    let last = first.len() - 1;
    first.pop();
    assert_eq!(replay(&forged).unwrap_err(), ReplayError::NoMove { index: last });

    let mut forged = of_pairs();
    let Moves::Pairs { first, second, change } = &mut forged.moves else { unreachable!() };
    // The last move undone and applied again.
    let undo = [Switch::from_code(second[last]), Switch::from_code(first[last])]
        .map(|switch| switch.inverse().code());
    let back = (first[last], second[last], change[last]);
    for (a, b, c) in [(undo[0], undo[1], -back.2), back] {
        first.push(a);
        second.push(b);
        change.push(c);
    }
    assert_eq!(replay(&forged).unwrap_err(), ReplayError::PastTheBest);
}

#[test]
fn a_record_contains_its_picture() {
    let ids = vec![0, 0, 255, 1, 1, 0];
    let instance = Instance::Picture { name: "small".to_owned(), ids };
    let (region, zones) = instance.draw(3, 2).unwrap();
    assert_eq!((region.cell_count(), zones.count(), zones.id(4)), (5, 2, 1));
    assert!(matches!(instance.draw(2, 2), Err(DrawError::Region(_))));
}

#[test]
fn arrays_agree_with_the_record() {
    for trajectory in [of_variants(), of_pairs()] {
        let arrays = trajectory.arrays(&Control::default()).unwrap();
        let (region, zones) = trajectory.draw().unwrap();
        assert_eq!(arrays.zones, zones.view(&region));
        assert_eq!(arrays.zones.dim(), (12, 16));
        let mut links = Links::new(&trajectory.start.path(&region, &Control::default()).unwrap());
        for ((y, x, direction), &linked) in arrays.start_links.indexed_iter() {
            let (right, below) = links.right_and_below(x as u32, y as u32);
            assert_eq!(linked, [right, below][direction]);
        }
        let steps: Vec<Step> = trajectory.steps().collect();
        assert_eq!(arrays.moves.nrows(), steps.len());
        assert_eq!(arrays.crossings.len(), steps.len() + 1);
        for (index, step) in steps.iter().enumerate() {
            assert_eq!(arrays.crossings[index], step.before);
            assert_eq!(arrays.crossings[index + 1], step.after);
            let row = arrays.moves.row(index).to_vec();
            match step.action {
                Move::Variant(placed) => {
                    let (class, x, y) = (placed.variant.class(), placed.x, placed.y);
                    assert_eq!(row, [u32::from(class), u32::from(x), u32::from(y)]);
                    assert!(links.apply_variant(placed));
                }
                Move::Pair(switches) => assert_eq!(row, switches.map(Switch::code)),
            }
        }
    }
    let mut forged = of_variants();
    let Moves::Variants { x, .. } = &mut forged.moves else { unreachable!() };
    x.pop();
    let index = x.len();
    let error = forged.arrays(&Control::default()).unwrap_err();
    assert_eq!(error, ReplayError::NoMove { index });
}
