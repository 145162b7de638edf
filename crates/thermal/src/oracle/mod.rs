//! Slow, obvious solutions of the heat equation, to test the methods of
//! [`Simulation`](crate::Simulation) against; only with the cargo feature `oracle`.

pub mod analytic;
pub mod scalar;
