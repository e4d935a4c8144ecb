//! Proofs about rays through a lens: of all rays of a cell, not of samples.
//!
//! [`Taylor`] models enclose functions of four variables; with them [`prove`] cuts all rays between film and lens into cells, of which
//! each is proved to pass, proved to be stopped at a surface, or undecided. docs/proofs.md lists the theorems and their assumptions.
//!
//! A module uses only those that stand before it here: [`table`] → [`taylor`] → [`cross`] → [`passage`] → [`index`] → [`chart`] →
//! [`column`] → [`partition`] → [`landing`] → [`certificate`].

// A comparison that NaN fails, written `!(x >= 0.0)`, is how a model that means nothing proves nothing.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod certificate;
mod chart;
mod column;
mod cross;
mod index;
mod landing;
mod partition;
mod passage;
mod table;
mod taylor;

pub use certificate::{Certificate, CertificateError, CertificateOptions, FORMAT, certificate};
pub use chart::{Centre, Chart, Floor};
pub use column::{CUT_POWERS, CUT_TERMS, Cell, Column, Cut, cut_value};
pub use landing::{Landing, LandingFinder};
pub use partition::{Proof, ProofError, ProofOptions, prove};
pub use passage::{Beam, Fate, StopReason};
pub use table::{COUNTS, VARIABLES};
pub use taylor::{Bounds, Taylor};
