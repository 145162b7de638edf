//! Logs of a run of PPO: CSV tables and TensorBoard events.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use beadwork_learn::ppo::{Event, Update};

use super::table::Table;
use super::tensorboard::{Events, events_in, now};

const EPISODES: &str = "steps,episode,return,length\n";
const UPDATES: &str = "steps,update,episodes,mean_return,learning_rate,epochs,policy_loss,\
                       value_loss,entropy,approximate_kl,clip_fraction,explained_variance,\
                       gradient_norm\n";
const EVALUATIONS: &str = "steps,episodes,mean_return,best\n";

/// The logs of one run.
pub(super) struct Log {
    episodes: Table,
    updates: Table,
    evaluations: Table,
    events: Events<BufWriter<File>>,
}

impl Log {
    /// Opens new logs, or those of the run that is resumed.
    pub(super) fn open(folder: &Path, resume: bool) -> anyhow::Result<Self> {
        Ok(Self {
            episodes: Table::open(folder.join("episodes.csv"), EPISODES, resume)?,
            updates: Table::open(folder.join("updates.csv"), UPDATES, resume)?,
            evaluations: Table::open(folder.join("evaluations.csv"), EVALUATIONS, resume)?,
            events: events_in(folder)?,
        })
    }

    pub(super) fn write(&mut self, event: &Event) -> anyhow::Result<()> {
        match event {
            Event::Started { steps, .. } => {
                for table in [&mut self.episodes, &mut self.updates, &mut self.evaluations] {
                    table.forget_after(*steps)?;
                }
            }
            Event::Episode { steps, episode, episode_return, length } => {
                self.episodes.write(format_args!("{steps},{episode},{episode_return},{length}"))?;
                let scalars = [("train/return", *episode_return), ("train/length", *length as f64)];
                self.events.write(*steps, &scalars, now())?;
            }
            Event::Kept { .. } => {}
            Event::Updated(update) => self.write_update(update)?,
            Event::Evaluated { steps, episodes, evaluation, best } => {
                let mean = evaluation.mean();
                self.evaluations
                    .write(format_args!("{steps},{episodes},{mean},{}", u8::from(*best)))?;
                self.events.write(*steps, &[("valid/return", mean)], now())?;
                self.events.flush()?;
            }
        }
        Ok(())
    }

    fn write_update(&mut self, update: &Update) -> anyhow::Result<()> {
        let Update { steps, episodes, learning_rate, policy_loss, value_loss, .. } = update;
        let Update { entropy, approximate_kl, clip_fraction, gradient_norm, .. } = update;
        // A cell is empty if there is no number.
        let cell = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
        self.updates.write(format_args!(
            "{steps},{},{episodes},{},{learning_rate},{},{policy_loss},{value_loss},{entropy},\
             {approximate_kl},{clip_fraction},{},{gradient_norm}",
            update.update,
            cell(update.mean_return),
            update.epochs,
            cell(update.explained_variance),
        ))?;
        let mut scalars = vec![
            ("train/rate", *learning_rate),
            ("train/policy_loss", *policy_loss),
            ("train/value_loss", *value_loss),
            ("train/entropy", *entropy),
            ("train/kl", *approximate_kl),
            ("train/clip_fraction", *clip_fraction),
            ("train/gradient", *gradient_norm),
        ];
        scalars.extend(update.mean_return.map(|mean| ("train/mean_return", mean)));
        scalars.extend(
            update.explained_variance.map(|explained| ("train/explained_variance", explained)),
        );
        self.events.write(*steps, &scalars, now())?;
        Ok(())
    }
}
