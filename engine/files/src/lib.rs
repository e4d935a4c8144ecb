//! Files that are replaced only by complete ones, and files that are read only up to a bound.
//!
//! A [`Replacement`] is a temporary file in the folder of the file that it is to replace. It is written, brought to the disk, and
//! renamed into place. A full disk, an error or the end of the process at any moment leaves the old file as it was. Modules use
//! only those before them: [`message`] → [`identity`] → [`bounded`] → [`replacement`].

pub mod bounded;
pub mod identity;
pub mod message;
pub mod replacement;

pub use bounded::{read_bounded, read_text_bounded};
pub use identity::Identity;
pub use message::one_line;
pub use replacement::{Replacement, check_place, write};
