//! Evaluations that reproduce and extend the tables of two papers, and benchmarks.
//!
//! The crate contains two commands of the binary `beadwork`, each with subcommands:
//! - [`eval`] compares methods and prints their results next to the figures of the papers.
//! - [`mod@bench`] measures run times, rates and memory on the machine at hand.
//!
//! Each subcommand prints Markdown tables to stdout, or one JSON document with `--json`.
//! Committed results, with the commands that produced them, are in `docs/results`.
//!
//! # Which command reproduces which table
//! | paper | table or figure | command |
//! |---|---|---|
//! | Aali et al. | Table 1, genetic algorithm | `eval zones` |
//! | Aali et al. | Table 2, FusionNet against annealing | `eval fusion` (feature `learn`) |
//! | Aali et al. | Tables 3 and 5, annealing | `eval zones`; with more seeds `eval zones --method anneal` |
//! | Aali et al. | Figure 4, heat maps of reductions | `eval zones`, `heat_map.svg` in its output folder |
//! | Aali et al. | open question: one-point or two-point crossover | `eval zones --method genetic` |
//! | Kim et al. 2026 | rewards and deviations of deposition patterns | `eval thermal` |
//! | ours | how often the fewest crossings are proven, and how fast | `eval zones --method exact` |
//! | ours | tool changes and lifts of whole parts with their bounds | `eval parts` |
//! | ORNL toolpath RL | shapes like the paper's | `eval beads` |
//! | ours | beads, lifts, travel and time of any slicer's program | `eval beads --program FILE` |
//! | ours | plans for even temperature | `eval heat` |
//! | ours | rank correlation of the proxy of temperatures with the solver | `bench heat` |
//! | ours | speed of annealing, of the genetic algorithm, of part and G-code, of the thermal solver, of the data factory, of training | `bench grid`, `zones`, `part`, `thermal`, `dataset`, `learn` |
//!
//! The figures of the papers are in `paper.rs` (Aali et al.) and `eval/thermal/tables.rs` (Kim et
//! al.).
//! `README.md` gives the titles of both.
//!
//! # Output folders and interrupted evaluations
//! Most subcommands only print their tables.
//! `eval zones` without `--method` and with `--method genetic` can take hours, and write to the
//! folder `--out` (by default `datasets/eval-zones` or `datasets/eval-crossovers`):
//! - `run.json`: settings, build and machine, on which all results depend;
//! - `parts/*.json`: the result of each finished job, one for each cell and seed;
//! - when all jobs are finished, tables (`*.md`), numbers (`*.json`) and figures (`*.svg`).
//!
//! Ctrl-C cancels every subcommand.
//! The same command resumes such an evaluation: it loads the results in `parts` and computes the
//! others (`eval/store.rs`).
//! It refuses a folder whose results have other settings or come from another build or machine.
//!
//! # Adding to the tables
//! - A **cell of `eval zones`** is an entry of the paper's tables, a
//!   [`Layout`](beadwork_grid::Layout) in one size: add it, with the paper's figures, to `cells` in
//!   `paper.rs`.
//! - A **row of `eval zones --method exact`** is a case in `eval/zones/exact_tables/cases.rs`.
//! - A **method of `eval zones`** is a [`Choice`](beadwork_console::search::Choice) of
//!   `beadwork-console`: run it in `every_method` (`eval/zones/paper_tables/solve.rs`), give it a
//!   `Column` in `runs.rs` and list the column in `columns` of `tables.rs`.
//! - A **part of `eval parts`** is a built-in example of `beadwork-mesh` or a file in
//!   `eval/parts/cases.rs`.
//! - A **shape of `eval beads`** is a variant of `Shape` in `eval/beads/shapes.rs`.
//! - A **part of `eval thermal`** and of `bench thermal` is a variant of `HeatPart` in
//!   `heat_parts.rs`; a **stepping method of `bench thermal`** is an entry of `METHODS` in
//!   `bench/thermal/parts.rs`.
//! - A **benchmark** is a module of `bench` with its arguments and a function `run`, listed in
//!   `bench/mod.rs`; `bench/timing.rs` measures the median of repeated runs.
//!
//! # Features
//! - `learn` (off by default): `eval fusion` and `bench learn`, which need libtorch.
//!
//! # Limits
//! Run times measured on different machines, or at different times, cannot be compared; compare
//! only ratios of figures that one run of a command measured.
//! The keys of JSON documents are stable; the wording and the layout of tables are not.

#![allow(clippy::print_stderr, reason = "a command line writes to its terminal")]
#![allow(
    clippy::doc_markdown,
    reason = "the comments on flags are their help, where backticks are noise"
)]

mod args;
pub mod bench;
pub mod eval;
mod heat_parts;
mod paper;
mod statistics;
