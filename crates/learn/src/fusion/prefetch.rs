//! Batches made ahead of time, on a thread of their own, while libtorch computes.

use std::sync::mpsc;
use std::thread::Scope;

use beadwork_dataset::Dataset;

use super::samples::{Batch, Batches, SampleError, Settings, Split};

/// An endless stream of training batches, one epoch after the other.
///
/// The thread that makes them ends soon after the prefetcher is dropped.
pub(super) struct Prefetcher {
    receiver: mpsc::Receiver<Result<Prefetched, SampleError>>,
}

/// A batch, and where the stream continues after it.
pub(super) struct Prefetched {
    /// Epoch of the batch.
    pub(super) epoch: u64,
    /// Batches of that epoch taken so far, this one included.
    pub(super) batches: u64,
    pub(super) batch: Batch,
}

/// Maximum number of batches that wait in the channel.
const CAPACITY: usize = 4;

impl Prefetcher {
    /// Starts at a batch of an epoch; the batches before it are skipped.
    pub(super) fn spawn<'scope>(
        scope: &'scope Scope<'scope, '_>,
        dataset: &'scope Dataset,
        settings: &'scope Settings,
        (epoch, batches): (u64, u64),
    ) -> Self {
        let (sender, receiver) = mpsc::sync_channel(CAPACITY);
        scope.spawn(move || {
            // Sending fails once the prefetcher is dropped; then there is nothing left to do.
            if let Err(error) = send_epochs(dataset, settings, (epoch, batches), &sender) {
                let _ = sender.send(Err(error));
            }
        });
        Self { receiver }
    }

    /// Waits for the next batch.
    /// Must not be called again after an error, which ends the thread.
    pub(super) fn next(&self) -> Result<Prefetched, SampleError> {
        self.receiver.recv().expect("the thread sends until it fails")
    }
}

/// Sends batches until the receiver is dropped or the dataset cannot be read.
fn send_epochs(
    dataset: &Dataset,
    settings: &Settings,
    (first_epoch, skipped): (u64, u64),
    sender: &mpsc::SyncSender<Result<Prefetched, SampleError>>,
) -> Result<(), SampleError> {
    for epoch in first_epoch.. {
        let mut stream = Batches::new(dataset, Split::Train, settings, epoch);
        let start = if epoch == first_epoch { skipped } else { 0 };
        stream.skip_batches(start)?;
        let mut batches = start;
        for batch in stream {
            let batch = batch?;
            batches += 1;
            if sender.send(Ok(Prefetched { epoch, batches, batch })).is_err() {
                return Ok(());
            }
        }
        if batches == 0 {
            return Err(SampleError::NoExamples { split: Split::Train });
        }
    }
    Ok(())
}
