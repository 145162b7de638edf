//! Logs of a run of FusionNet: CSV tables and TensorBoard events.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use beadwork_learn::fusion::evaluate::Evaluation;
use beadwork_learn::fusion::train::Event;

use super::table::Table;
use super::tensorboard::{Events, events_in, now};

const STEPS: &str = "step,examples,loss,rate,gradient\n";
const EVALUATIONS: &str = "step,loss,layout,examples,top_1,top_5,action\n";

/// The logs of one run.
///
/// An event is in the tables when `write` returns, so the tables are never behind a checkpoint.
pub(super) struct Log {
    steps: Table,
    evaluations: Table,
    events: Events<BufWriter<File>>,
}

impl Log {
    /// Opens new logs, or those of the run that is resumed.
    pub(super) fn open(folder: &Path, resume: bool) -> anyhow::Result<Self> {
        Ok(Self {
            steps: Table::open(folder.join("steps.csv"), STEPS, resume)?,
            evaluations: Table::open(folder.join("evaluations.csv"), EVALUATIONS, resume)?,
            events: events_in(folder)?,
        })
    }

    pub(super) fn write(&mut self, event: &Event) -> anyhow::Result<()> {
        match event {
            Event::Started { steps } => {
                self.steps.forget_after(*steps)?;
                self.evaluations.forget_after(*steps)?;
            }
            Event::Step { step, examples, loss, learning_rate, gradient_norm } => {
                self.steps.write(format_args!(
                    "{step},{examples},{loss},{learning_rate},{gradient_norm}"
                ))?;
                let scalars = [
                    ("train/loss", *loss),
                    ("train/rate", *learning_rate),
                    ("train/gradient", *gradient_norm),
                ];
                self.events.write(*step, &scalars, now())?;
            }
            Event::Evaluated { step, evaluation, .. } => {
                self.write_evaluation(*step, evaluation)?;
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
            self.evaluations.write(format_args!(
                "{step},{loss},{layout},{count},{},{},{}",
                hits.top_1, hits.top_5, hits.action
            ))?;
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
}
