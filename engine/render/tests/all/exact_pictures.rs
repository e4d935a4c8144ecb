//! Photographs against pictures that exact rays make without the engine's help: from small lamps, through the lens one
//! by one, onto the film. Only the tracer is common to both, and the reference data hold that one to its digits.

mod bokeh;
mod colour;
mod exact;
mod flat;
mod hinge;
mod illumination;
mod noise;
mod spots;
mod studio;
