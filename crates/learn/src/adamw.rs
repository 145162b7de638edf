//! `AdamW` (Loshchilov and Hutter 2019), with a state that can be saved and restored.
//!
//! libtorch's own optimiser does not expose its moments, so a run could not be resumed exactly with
//! it.

use tch::{Kind, Tensor, no_grad};

/// Hyperparameters of [`AdamW`].
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Decay of the running mean of gradients, 0..1.
    pub beta_1: f64,
    /// Decay of the running mean of squared gradients, 0..1.
    pub beta_2: f64,
    /// Added to the root of the mean of squares, against division by zero.
    pub epsilon: f64,
    /// Decoupled weight decay: each step multiplies all parameters by
    /// `1 - learning_rate * weight_decay`.
    pub weight_decay: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { beta_1: 0.9, beta_2: 0.999, epsilon: 1e-8, weight_decay: 1e-2 }
    }
}

/// The optimiser of a list of parameters.
#[derive(Debug)]
pub struct AdamW {
    settings: Settings,
    parameters: Vec<Tensor>,
    /// Running mean of the gradients: all parameters flattened and concatenated.
    mean: Tensor,
    /// Running mean of the squared gradients, in the same layout.
    square: Tensor,
    /// Steps completed.
    steps: i64,
}

impl AdamW {
    /// An optimiser that changes these parameters in place.
    pub fn new(parameters: Vec<Tensor>, settings: Settings) -> Self {
        let count: i64 = parameters.iter().map(|parameter| parameter.numel() as i64).sum();
        let device = parameters.first().map_or(tch::Device::Cpu, Tensor::device);
        let zeros = || Tensor::zeros([count], (Kind::Float, device));
        Self { settings, parameters, mean: zeros(), square: zeros(), steps: 0 }
    }

    /// The state to save with the parameters: mean of the gradients, mean of their squares, steps
    /// completed.
    pub fn state(&self) -> (&Tensor, &Tensor, i64) {
        (&self.mean, &self.square, self.steps)
    }

    /// Restores a saved state.
    ///
    /// # Panics
    /// If the means have the wrong length for the parameters.
    pub fn restore(&mut self, mean: &Tensor, square: &Tensor, steps: i64) {
        no_grad(|| {
            self.mean.copy_(mean);
            self.square.copy_(square);
        });
        self.steps = steps;
    }

    /// Sets all gradients to zero.
    pub fn zero_grad(&mut self) {
        self.parameters.iter_mut().for_each(Tensor::zero_grad);
    }

    /// Updates the parameters with their gradients, scaled down to `max_grad_norm` if the norm of
    /// all of them together is larger.
    /// Returns the norm before scaling; if it is not finite, nothing changes.
    pub fn step(&mut self, learning_rate: f64, max_grad_norm: f64) -> f64 {
        no_grad(|| {
            let gradients = self.parameters.iter().map(|parameter| {
                let gradient = parameter.grad();
                if gradient.defined() {
                    gradient.flatten(0, -1)
                } else {
                    parameter.zeros_like().flatten(0, -1)
                }
            });
            let mut gradient = Tensor::cat(&gradients.collect::<Vec<_>>(), 0);
            let norm = gradient.norm().double_value(&[]);
            if !norm.is_finite() {
                return norm;
            }
            if norm > max_grad_norm {
                gradient *= max_grad_norm / norm;
            }
            self.steps += 1;
            let Settings { beta_1, beta_2, epsilon, weight_decay } = self.settings;
            self.mean *= beta_1;
            self.mean += &gradient * (1.0 - beta_1);
            self.square *= beta_2;
            self.square += gradient.square() * (1.0 - beta_2);
            // The means start at 0; dividing by the sum of their weights corrects that bias.
            let correction = |beta: f64| 1.0 - beta.powi(self.steps as i32);
            let root = (&self.square / correction(beta_2)).sqrt() + epsilon;
            let change = &self.mean / root * (learning_rate / correction(beta_1));
            let sizes: Vec<i64> =
                self.parameters.iter().map(|parameter| parameter.numel() as i64).collect();
            for (parameter, change) in
                self.parameters.iter_mut().zip(change.split_with_sizes(sizes, 0))
            {
                *parameter *= 1.0 - learning_rate * weight_decay;
                *parameter -= change.view_as(parameter);
            }
            norm
        })
    }
}
