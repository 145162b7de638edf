//! A trajectory as `ndarray` arrays.

use beadwork_base::Control;
use beadwork_grid::{Links, Switch};
use beadwork_search::Move;
use ndarray::{Array1, Array2, Array3};

use super::record::Trajectory;
use super::replay::ReplayError;

/// A trajectory as arrays, for analyses and other learning frameworks.
///
/// Grid axes are `[y, x]`, with y from the top down.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrajectoryArrays {
    /// Zone of each cell, `[y, x]`; [`Zones::OUTSIDE`](beadwork_grid::Zones::OUTSIDE) outside the
    /// region.
    pub zones: Array2<u8>,
    /// Links of the start path, `[y, x, direction]`: whether it links a cell with its right
    /// neighbour (direction 0) and with the neighbour below (direction 1).
    pub start_links: Array3<bool>,
    /// Moves, `[move, column]`.
    ///
    /// Variants have three columns: class (0 to 11), x and y of the window's top-left cell.
    /// Pairs of switches have two: the codes of the first and the second switch, see
    /// [`Switch::code`].
    /// Without moves there are three columns and no rows.
    pub moves: Array2<u32>,
    /// Crossings of the start path and after each move, `[state]`: one more than there are moves.
    pub crossings: Array1<u32>,
}

impl Trajectory {
    /// The trajectory as arrays.
    ///
    /// The moves are not replayed; [`Trajectory::replay`] checks them.
    /// Linear in the cells of the grid and the moves, except for a start path that is a path cover,
    /// which `control` can interrupt.
    ///
    /// ```
    /// use beadwork_base::Control;
    /// use beadwork_dataset::{Config, Factory};
    ///
    /// let config = Config { count: 1, ..Config::preset("smoke").unwrap() };
    /// let factory = Factory::new(config, Vec::new(), &Control::default())?;
    /// let trajectory = factory.trajectory(0, &Control::default())?;
    /// let arrays = trajectory.arrays(&Control::default())?;
    /// assert_eq!(arrays.zones.dim(), (20, 20));
    /// assert_eq!(arrays.crossings[0], trajectory.initial);
    /// assert_eq!(arrays.crossings.len(), arrays.moves.nrows() + 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the instance or the start path cannot be drawn, or a move of the record is missing.
    pub fn arrays(&self, control: &Control<'_>) -> Result<TrajectoryArrays, ReplayError> {
        let (region, zones) = self.draw()?;
        let links = Links::new(&self.start.path(&region, &control.without_progress())?);
        let shape = (region.height() as usize, region.width() as usize, 2);
        let start_links = Array3::from_shape_fn(shape, |(y, x, direction)| {
            let (right, below) = links.right_and_below(x as u32, y as u32);
            if direction == 0 { right } else { below }
        });

        let mut columns = 3;
        let mut moves = Vec::new();
        let mut crossings = vec![self.initial];
        for step in self.steps() {
            match step.action {
                Move::Variant(placed) => {
                    let class = u32::from(placed.variant.class());
                    moves.extend([class, placed.x.into(), placed.y.into()]);
                }
                Move::Pair(switches) => {
                    columns = 2;
                    moves.extend(switches.map(Switch::code));
                }
            }
            crossings.push(step.after);
        }
        let count = crossings.len() - 1;
        if count < self.moves.len() {
            return Err(ReplayError::NoMove { index: count });
        }
        let moves = Array2::from_shape_vec((count, columns), moves);
        Ok(TrajectoryArrays {
            zones: zones.view(&region).to_owned(),
            start_links,
            moves: moves.expect("all moves of a trajectory are of one kind"),
            crossings: Array1::from_vec(crossings),
        })
    }
}
