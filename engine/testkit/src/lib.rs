//! Statistical checks and generators for the tests of Petzval.
