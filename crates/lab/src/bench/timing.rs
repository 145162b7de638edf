//! Times of repeated runs.

use std::time::Instant;

use crate::statistics::median;

/// Median time of `repeats` successful runs in seconds, after one run that is not measured.
///
/// `run` is called with the number of the run, from 0; the run that is not measured also gets 0.
pub(super) fn median_seconds(
    repeats: u64,
    mut run: impl FnMut(u64) -> anyhow::Result<()>,
) -> anyhow::Result<f64> {
    run(0)?;
    let mut seconds = Vec::new();
    for number in 0..repeats {
        let begin = Instant::now();
        run(number)?;
        seconds.push(begin.elapsed().as_secs_f64());
    }
    Ok(median(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_run_is_not_measured() {
        let mut numbers = Vec::new();
        let record = |number| {
            numbers.push(number);
            Ok(())
        };
        median_seconds(3, record).expect("no run fails");
        assert_eq!(numbers, [0, 0, 1, 2]);
    }
}
