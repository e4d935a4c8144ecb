//! The exact tracer against independent truths.

mod reference;
mod sensitivity;
mod shapes;
