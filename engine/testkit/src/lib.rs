//! Statistical checks for the tests of Petzval: whether samples follow the density that they claim.

pub mod chi_square;
