//! Options of nodes: Blender's words as closed enums.

/// An option that is one of a list of words.
pub(crate) trait Choice: Sized {
    /// The choice that Blender calls by this word.
    fn named(word: &str) -> Option<Self>;
}

/// Declares an enum together with Blender's words for its variants.
macro_rules! choices {
    ($(#[$about:meta])* $visibility:vis $name:ident { $($(#[$each:meta])* $variant:ident = $($word:literal)|+),* $(,)? }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $visibility enum $name { $($(#[$each])* $variant),* }
        impl $name {
            /// All choices, in the order of their declaration.
            #[allow(dead_code, reason = "of most enums nobody asks")]
            $visibility const ALL: &[Self] = &[$(Self::$variant),*];
        }
        impl $crate::choice::Choice for $name {
            fn named(word: &str) -> Option<Self> {
                match word {
                    $($($word)|+ => Some(Self::$variant),)*
                    _ => None,
                }
            }
        }
    };
}
pub(crate) use choices;
