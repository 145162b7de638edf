//! Logs of a training run: CSV tables and TensorBoard events.

use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Context;
use beadwork_learn::fusion::evaluate::Evaluation;
use beadwork_learn::fusion::train::Event;

use super::tensorboard::Events;

const STEPS: &str = "step,examples,loss,rate,gradient\n";
const EVALUATIONS: &str = "step,loss,layout,examples,top_1,top_5,action\n";

/// The logs of one run.
///
/// An event is in the tables when `write` returns, so the tables are never behind a checkpoint.
pub(super) struct Log {
    folder: PathBuf,
    steps: BufWriter<File>,
    evaluations: BufWriter<File>,
    events: Events<BufWriter<File>>,
}

impl Log {
    /// Opens new logs, or those of the run that is resumed.
    pub(super) fn open(folder: &Path, resume: bool) -> anyhow::Result<Self> {
        let events = OpenOptions::new()
            .create(true)
            .write(true)
            .truncate(true)
            .open(folder.join(events_name()));
        let events = events.with_context(|| format!("cannot write to '{}'", folder.display()))?;
        Ok(Self {
            steps: table(&folder.join("steps.csv"), STEPS, resume)?,
            evaluations: table(&folder.join("evaluations.csv"), EVALUATIONS, resume)?,
            events: Events::new(BufWriter::new(events), now())?,
            folder: folder.into(),
        })
    }

    pub(super) fn write(&mut self, event: &Event) -> anyhow::Result<()> {
        match event {
            Event::Started { steps } => self.forget_after(*steps)?,
            Event::Step { step, examples, loss, learning_rate, gradient_norm } => {
                writeln!(self.steps, "{step},{examples},{loss},{learning_rate},{gradient_norm}")?;
                self.steps.flush()?;
                let scalars = [
                    ("train/loss", *loss),
                    ("train/rate", *learning_rate),
                    ("train/gradient", *gradient_norm),
                ];
                self.events.write(*step, &scalars, now())?;
            }
            Event::Evaluated { step, evaluation, .. } => {
                self.write_evaluation(*step, evaluation)?;
                self.evaluations.flush()?;
                self.events.flush()?;
            }
        }
        Ok(())
    }

    fn write_evaluation(&mut self, step: u64, evaluation: &Evaluation) -> anyhow::Result<()> {
        let all = [("all", &evaluation.all)];
        let layouts = evaluation.by_layout.iter().map(|(name, (hits, _))| (name.as_str(), hits));
        for (layout, hits) in all.into_iter().chain(layouts) {
            let (loss, count) = (evaluation.loss, hits.count);
            writeln!(
                self.evaluations,
                "{step},{loss},{layout},{count},{},{},{}",
                hits.top_1, hits.top_5, hits.action
            )?;
        }
        let share = |hits: u64| hits as f64 / evaluation.all.count.max(1) as f64;
        let scalars = [
            ("valid/loss", evaluation.loss),
            ("valid/position_top_1", share(evaluation.all.top_1)),
            ("valid/position_top_5", share(evaluation.all.top_5)),
            ("valid/action", share(evaluation.all.action)),
        ];
        self.events.write(step, &scalars, now())?;
        Ok(())
    }

    /// Removes a partial last line and the lines of all steps after `steps`, which the resumed run
    /// repeats.
    fn forget_after(&mut self, steps: u64) -> anyhow::Result<()> {
        for (name, table) in
            [("steps.csv", &mut self.steps), ("evaluations.csv", &mut self.evaluations)]
        {
            table.flush()?;
            let path = self.folder.join(name);
            let text = fs::read_to_string(&path)?;
            let made = |line: &&str| {
                line.split(',')
                    .next()
                    .and_then(|step| step.parse().ok())
                    .is_none_or(|step: u64| step <= steps)
            };
            let text = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
            let kept: String = text.split_inclusive('\n').filter(made).collect();
            beadwork_dataset::write_atomic(&path, |out| out.write_all(kept.as_bytes()))?;
            *table = BufWriter::new(OpenOptions::new().append(true).open(&path)?);
        }
        Ok(())
    }
}

/// Opens a table to append to, or a new one with its header.
fn table(path: &Path, header: &str, resume: bool) -> anyhow::Result<BufWriter<File>> {
    let open = || -> std::io::Result<File> {
        if !(resume && path.exists()) {
            fs::write(path, header)?;
        }
        OpenOptions::new().append(true).open(path)
    };
    Ok(BufWriter::new(open().with_context(|| format!("cannot write '{}'", path.display()))?))
}

/// TensorBoard reads all files with `tfevents` in their names, in this order.
fn events_name() -> String {
    format!("events.out.tfevents.{:010}.beadwork", now() as u64)
}

/// Seconds since 1970-01-01.
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}
