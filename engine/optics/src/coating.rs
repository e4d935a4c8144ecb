//! Reflection, transmission and absorption of a surface: bare, or under thin films.
//!
//! A coating's thickness belongs to the light's wavelength, not to the lens: a lens that is scaled keeps it.

mod films;
mod layers;
mod recipes;

use std::sync::Arc;

use petzval_files::one_line;
use serde::Deserialize;

use crate::glass::{Medium, line_nm};

pub use films::Film;
pub use layers::{Layer, Split};
pub use recipes::{RECIPES, Recipe};

/// Thin films on a surface; cheap to clone. None: bare.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Coating(Option<Arc<LayerStack>>);

#[derive(Debug, PartialEq)]
struct LayerStack {
    /// The text in a lens file.
    name: String,
    /// The outermost, beside the air, first.
    layers: Vec<Layer>,
}

impl TryFrom<String> for Coating {
    type Error = CoatingError;

    fn try_from(text: String) -> Result<Self, CoatingError> {
        Self::parse(&text)
    }
}

/// The index of the substrate of a mirror's layers; metal lets no light get there.
const BELOW_A_MIRROR: f64 = 1.5;

/// An error in the text of a coating.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CoatingError {
    /// The name of no recipe.
    #[error(
        "unknown coating '{0}'; name one of {known}, or write its layers from the outside as FILM:THICKNESSnm or FILM:PARTw@NM, joined by /",
        known = recipes::names()
    )]
    Recipe(String),
    /// A name that is no film's.
    #[error("unknown film '{0}'; name one of {known}, or an index from 0.01 to 100, as 1.38 or 2.3-0.01i", known = films::names())]
    Film(String),
    /// A text that is no thickness of a film.
    #[error(
        "'{0}' is no thickness of a film; write 100nm, or 0.25w@550 for a quarter of a wave of 550 nm inside of it"
    )]
    Thickness(String),
}

/// The coating of a surface of which nothing is known, by its name: that of most lenses since 1945, a single layer on glass in air.
pub const ASSUMED: &str = "MgF2";

/// A surface is coated where glass meets air: where the larger index is more than so many times the smaller.
const COATED: f64 = 1.25;

/// True if a surface between two media is one that is coated.
pub(crate) fn parts_glass_from_air(from: &Medium, to: &Medium) -> bool {
    let [a, b] = [from, to].map(|medium| medium.index(line_nm::D).abs());
    a.max(b) > COATED * a.min(b)
}

impl Coating {
    /// A bare surface, without thin films.
    pub const BARE: Self = Self(None);

    /// Layers, the outermost first.
    pub fn of(name: &str, layers: Vec<Layer>) -> Self {
        Self((!layers.is_empty()).then(|| Arc::new(LayerStack { name: name.to_owned(), layers })))
    }

    /// The coating of a text in a lens file: a recipe's name, with `@NM` behind it for another design wavelength, or layers.
    pub fn parse(text: &str) -> Result<Self, CoatingError> {
        if let Some(recipe) = Recipe::named(text) {
            return Ok(recipe.coating());
        }
        // A message has one line.
        if text.contains(char::is_control) {
            return Err(CoatingError::Recipe(one_line(text)));
        }
        if !text.contains(':') {
            return Err(CoatingError::Recipe(text.to_owned()));
        }
        let layers = text.split('/').map(Layer::parse).collect::<Result<_, _>>()?;
        Ok(Self::of(text, layers))
    }

    /// The text that [`Self::parse`] reads.
    pub fn name(&self) -> &str {
        self.0.as_ref().map_or("none", |stack| &stack.name)
    }

    /// True if there is none.
    pub fn is_bare(&self) -> bool {
        self.0.is_none()
    }

    /// The layers, the outermost first.
    pub fn layers(&self) -> &[Layer] {
        self.0.as_ref().map_or(&[], |stack| &stack.layers)
    }

    /// The split of light that comes through a medium of index `from` to a mirror under an angle with this cosine: light that is not
    /// reflected is absorbed in the layers or below them. Bare, a mirror is perfect.
    pub fn mirrored(&self, from: f64, wavelength_nm: f64, cos_incidence: f64) -> Split {
        let Some(stack) = &self.0 else { return Split::MIRROR };
        let reflected =
            layers::split(stack.layers.iter(), from, BELOW_A_MIRROR, wavelength_nm, cos_incidence).reflected;
        Split { reflected, transmitted: [0.0; 2] }
    }

    /// The split of light of a vacuum wavelength that comes from a medium of index `from` to one of index `to` under an angle with this
    /// cosine. The layers' outside is on the side of the medium with the smaller index.
    pub fn split(&self, from: f64, to: f64, wavelength_nm: f64, cos_incidence: f64) -> Split {
        match &self.0 {
            None => layers::split([].iter(), from, to, wavelength_nm, cos_incidence),
            Some(stack) if from <= to => layers::split(stack.layers.iter(), from, to, wavelength_nm, cos_incidence),
            Some(stack) => layers::split(stack.layers.iter().rev(), from, to, wavelength_nm, cos_incidence),
        }
    }
}
