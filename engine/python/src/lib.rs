//! The Python module of Petzval.
