//! Path tracing through a camera.
