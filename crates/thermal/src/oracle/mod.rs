//! Slow, obvious solutions of the heat equation and of elasticity, to test the methods of
//! [`Simulation`](crate::Simulation) and the [warpage](crate::warpage) estimate against; only with
//! the cargo feature `oracle`.

pub mod analytic;
pub mod elastic;
pub mod scalar;
