//! A pole on a cart, to be balanced: the task `CartPole-v1`.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::ppo::environment::{Environment, EpisodeEnd, Observation, Space, Step};

/// A pole on a cart, which a force of 10 N pushes left (action 0) or right (action 1).
///
/// Barto, Sutton and Anderson, "Neuronlike Adaptive Elements That Can Solve Difficult Learning
/// Control Problems" (1983), as the public task `CartPole-v1` defines it: Euler steps of 0.02 s, a
/// reward of 1 for each step, at most 500 steps.
/// The episode terminates when the pole leans by more than 12 degrees or the cart is more than 2.4
/// m off the centre, and is truncated after 500 steps.
///
/// Observation: position in m, speed in m/s, angle in radians, angular speed in 1/s.
#[derive(Clone, Debug, Default)]
pub struct CartPole {
    /// Position, speed, angle and angular speed.
    state: [f64; 4],
    steps: u32,
}

const GRAVITY: f64 = 9.8;
const CART_MASS: f64 = 1.0;
const POLE_MASS: f64 = 0.1;
/// Half the pole's length, in m.
const HALF_LENGTH: f64 = 0.5;
const FORCE: f64 = 10.0;
const SECONDS: f64 = 0.02;
const MAX_POSITION: f64 = 2.4;
const MAX_ANGLE: f64 = 12.0 * std::f64::consts::TAU / 360.0;
const MAX_STEPS: u32 = 500;

impl CartPole {
    fn observation(&self) -> Observation {
        Observation::vector(self.state.map(|value| value as f32).to_vec(), 2)
    }
}

impl Environment for CartPole {
    fn identity(&self) -> String {
        "task = \"CartPole-v1\"".into()
    }

    fn space(&self) -> Space {
        Space::vector(4, 2)
    }

    fn reset(&mut self, seed: u64) -> Observation {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        self.state = [(); 4].map(|()| rng.random_range(-0.05..0.05));
        self.steps = 0;
        self.observation()
    }

    fn step(&mut self, action: usize) -> Step {
        let [position, speed, angle, turn] = self.state;
        let force = if action == 1 { FORCE } else { -FORCE };
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let mass = CART_MASS + POLE_MASS;
        let push = (force + POLE_MASS * HALF_LENGTH * turn * turn * sin) / mass;
        let turning = (GRAVITY * sin - cos * push)
            / (HALF_LENGTH * (4.0 / 3.0 - POLE_MASS * cos * cos / mass));
        let acceleration = push - POLE_MASS * HALF_LENGTH * turning * cos / mass;
        self.state = [
            position + SECONDS * speed,
            speed + SECONDS * acceleration,
            angle + SECONDS * turn,
            turn + SECONDS * turning,
        ];
        self.steps += 1;
        let [position, _, angle, _] = self.state;
        let end = if position.abs() > MAX_POSITION || angle.abs() > MAX_ANGLE {
            Some(EpisodeEnd::Terminated)
        } else {
            (self.steps == MAX_STEPS).then_some(EpisodeEnd::Truncated)
        };
        Step { observation: self.observation(), reward: 1.0, end }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_upright_pole_starts_to_fall_as_its_equations_say() {
        let mut task = CartPole::default();
        let Step { observation, reward, end } = task.step(1);
        // At rest and upright: push = 10 / 1.1, turning = -push / (0.5 (4/3 - 0.1/1.1)).
        let push = 10.0 / 1.1;
        let turning = -push / (0.5 * (4.0 / 3.0 - 0.1 / 1.1));
        let expected = [0.0, 0.02 * (push - 0.05 * turning / 1.1), 0.0, 0.02 * turning];
        for (got, expected) in observation.tensors[0].iter().zip(expected) {
            assert!((f64::from(*got) - expected).abs() < 1e-6, "{got} for {expected}");
        }
        assert!((reward - 1.0).abs() < 1e-12 && end.is_none());
    }

    #[test]
    fn pushing_one_way_ends_soon() {
        let mut task = CartPole::default();
        task.reset(3);
        let steps = (1..=500).find(|_| task.step(1).end.is_some()).unwrap();
        assert!((8..=11).contains(&steps), "{steps}");
    }

    #[test]
    fn episodes_are_truncated_after_500_steps() {
        let mut task = CartPole::default();
        let mut seen = task.reset(1);
        // A controller that balances: it pushes towards where the pole falls.
        let end = (1..=500).find_map(|number| {
            let [x, speed, angle, turn] = <[f32; 4]>::try_from(seen.tensors[0].clone()).unwrap();
            let fall = angle + 0.5 * turn + 0.05 * x + 0.1 * speed;
            let step = task.step(usize::from(fall > 0.0));
            seen = step.observation;
            step.end.map(|end| (number, end))
        });
        assert_eq!(end, Some((500, EpisodeEnd::Truncated)));
    }
}
