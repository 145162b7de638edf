//! The results of all methods on the instances of one cell, and selections of them.

use beadwork_console::search::Row;
use beadwork_search::anneal::Preset;
use beadwork_search::genetic;
use serde::{Deserialize, Serialize};

use crate::eval::zones::cell_table::distinct;
use crate::paper::{AVERAGED, Cell};
use crate::statistics;

/// The results of all methods on the instances of one cell.
pub(super) struct Runs {
    pub(super) cell: Cell,
    pub(super) rows: Vec<InstanceRow>,
}

/// The result of one search, with the seed of its instance.
#[derive(Serialize, Deserialize)]
pub(super) struct InstanceRow {
    pub(super) instance_seed: u64,
    #[serde(flatten)]
    pub(super) row: Row,
}

/// A column of the tables: a selection of searches.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Column {
    Zigzag,
    /// Annealing by one preset.
    Anneal(Preset),
    /// Annealing by any preset of the paper.
    AnnealPaper,
    /// Annealing by the presets [`AVERAGED`].
    AnnealAveraged,
    /// Annealing by any preset.
    AnnealAny,
    /// The genetic algorithm by one preset.
    Genetic(genetic::Preset),
    /// The genetic algorithm by any preset.
    GeneticAny,
    Exact,
}

impl Column {
    fn covers(self, row: &Row) -> bool {
        let (method, preset) = (row.method.as_str(), row.preset.as_deref().unwrap_or_default());
        match self {
            Self::Zigzag => method == "zigzag",
            Self::Anneal(wanted) => method == "anneal" && preset == wanted.name(),
            Self::AnnealPaper => method == "anneal" && preset != Preset::Fast.name(),
            Self::AnnealAveraged => {
                AVERAGED.iter().any(|&averaged| Self::Anneal(averaged).covers(row))
            }
            Self::AnnealAny => method == "anneal",
            Self::Genetic(wanted) => method == "genetic" && preset == wanted.name(),
            Self::GeneticAny => method == "genetic",
            Self::Exact => method == "exact",
        }
    }
}

impl Runs {
    /// The rows of a column.
    pub(super) fn column(&self, column: Column) -> impl Iterator<Item = &Row> {
        self.rows.iter().map(|tagged| &tagged.row).filter(move |row| column.covers(row))
    }

    /// Largest reduction in a column, in %; NaN if the column is empty.
    pub(super) fn best(&self, column: Column) -> f64 {
        self.column(column).map(Row::reduction).fold(f64::NAN, f64::max)
    }

    /// Mean of a value over a column; NaN if the column is empty.
    pub(super) fn mean(&self, column: Column, value: impl Fn(&Row) -> f64) -> f64 {
        statistics::mean(self.column(column).map(value))
    }

    /// Mean of the crossings in a column.
    pub(super) fn mean_crossings(&self, column: Column) -> f64 {
        self.mean(column, |row| f64::from(row.crossings))
    }

    /// Mean over the instances of the proven lower bounds on the crossings.
    pub(super) fn mean_bound(&self) -> f64 {
        self.mean(Column::Exact, bound)
    }

    /// Number of different instances.
    pub(super) fn instances(&self) -> usize {
        distinct(self.rows.iter().map(|row| row.instance_seed))
    }
}

fn bound(row: &Row) -> f64 {
    row.bound.unwrap_or_default()
}

/// Crossings above the proven lower bound.
pub(super) fn gap(row: &Row) -> f64 {
    f64::from(row.crossings) - bound(row)
}
