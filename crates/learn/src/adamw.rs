//! `AdamW` (Loshchilov and Hutter 2019), with a state that can be saved.
//!
//! The optimiser of libtorch keeps its moments to itself, and a run that begins anew without them
//! is another run.

use tch::{Kind, Tensor, no_grad};

/// Its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdamWSettings {
    /// Decay of the mean of gradients, 0..1.
    pub beta_1: f64,
    /// Decay of the mean of their squares, 0..1.
    pub beta_2: f64,
    /// Added to the root of that mean.
    pub epsilon: f64,
    /// Share of each parameter that is taken away at each step, times the learning rate.
    pub weight_decay: f64,
}

impl Default for AdamWSettings {
    fn default() -> Self {
        Self { beta_1: 0.9, beta_2: 0.999, epsilon: 1e-8, weight_decay: 1e-2 }
    }
}

/// The optimiser of a list of parameters.
#[derive(Debug)]
pub struct AdamW {
    settings: AdamWSettings,
    parameters: Vec<Tensor>,
    /// The means of all gradients and of their squares, one after the other.
    mean: Tensor,
    square: Tensor,
    steps: i64,
}

impl AdamW {
    /// For these parameters, which it changes in place.
    pub fn new(parameters: Vec<Tensor>, settings: AdamWSettings) -> Self {
        let count: i64 = parameters.iter().map(|parameter| parameter.numel() as i64).sum();
        let device = parameters.first().map_or(tch::Device::Cpu, Tensor::device);
        let zeros = || Tensor::zeros([count], (Kind::Float, device));
        Self { settings, parameters, mean: zeros(), square: zeros(), steps: 0 }
    }

    /// What is to be saved with the parameters: the means, and the number of steps made.
    pub fn state(&self) -> (&Tensor, &Tensor, i64) {
        (&self.mean, &self.square, self.steps)
    }

    /// Goes on from a state that was saved.
    ///
    /// # Panics
    /// If the means are those of other parameters.
    pub fn restore(&mut self, mean: &Tensor, square: &Tensor, steps: i64) {
        no_grad(|| {
            self.mean.copy_(mean);
            self.square.copy_(square);
        });
        self.steps = steps;
    }

    /// Forgets the gradients.
    pub fn zero_grad(&mut self) {
        self.parameters.iter_mut().for_each(Tensor::zero_grad);
    }

    /// Makes a step along the gradients, shortened to `clip` where they are longer together; gives
    /// their length.
    /// Where that is no number, nothing changes.
    pub fn step(&mut self, rate: f64, clip: f64) -> f64 {
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
            let length = gradient.norm().double_value(&[]);
            if !length.is_finite() {
                return length;
            }
            if length > clip {
                gradient *= clip / length;
            }
            self.steps += 1;
            let AdamWSettings { beta_1, beta_2, epsilon, weight_decay } = self.settings;
            self.mean *= beta_1;
            self.mean += &gradient * (1.0 - beta_1);
            self.square *= beta_2;
            self.square += gradient.square() * (1.0 - beta_2);
            let bias = |beta: f64| 1.0 - beta.powi(self.steps as i32);
            let root = (&self.square / bias(beta_2)).sqrt() + epsilon;
            let change = &self.mean / root * (rate / bias(beta_1));
            let sizes: Vec<i64> =
                self.parameters.iter().map(|parameter| parameter.numel() as i64).collect();
            for (parameter, change) in
                self.parameters.iter_mut().zip(change.split_with_sizes(sizes, 0))
            {
                *parameter *= 1.0 - rate * weight_decay;
                *parameter -= change.view_as(parameter);
            }
            length
        })
    }
}
