//! Coatings that are published.

use super::{Coating, Film, Layer};

/// A coating's plan: its films from the outside, each so many waves of the design wavelength thick.
#[derive(Debug, PartialEq)]
pub struct Recipe {
    /// The name in lens files and on the command line.
    pub name: &'static str,
    /// The title for panels.
    pub title: &'static str,
    /// The publication of the recipe.
    pub source: &'static str,
    /// Design wavelength: the middle of the range that it is for, nm.
    pub design_nm: f64,
    layers: &'static [(&'static str, f64)],
    /// The metal below the layers of a mirror, so thick that nothing passes.
    metal: Option<&'static str>,
}

/// The thickness of a metal that lets no light through, nm: exp(−4π k d / λ) is below 1e-6.
const OPAQUE_NM: f64 = 400.0;

/// The recipes that a lens file or a setting may name; the first is bare glass.
pub const RECIPES: [Recipe; 8] = [
    Recipe { name: "none", title: "None", source: "bare glass", design_nm: 550.0, layers: &[], metal: None },
    Recipe {
        name: "MgF2",
        title: "Single layer",
        source: "a quarter of a wave of magnesium fluoride: Macleod, Thin-Film Optical Filters, ch. 4",
        design_nm: 550.0,
        layers: &[("MgF2", 0.25)],
        metal: None,
    },
    Recipe {
        name: "double",
        title: "Two layers",
        source: "two quarter waves, a V coat for crown: Macleod, Thin-Film Optical Filters, ch. 4",
        design_nm: 550.0,
        layers: &[("MgF2", 0.25), ("Al2O3", 0.25)],
        metal: None,
    },
    Recipe {
        name: "triple",
        title: "Three layers",
        source: "quarter, half, quarter: Cox, Hass and Thelen, J. Opt. Soc. Am. 52, 965 (1962)",
        design_nm: 550.0,
        layers: &[("MgF2", 0.25), ("ZrO2", 0.5), ("Al2O3", 0.25)],
        metal: None,
    },
    Recipe {
        name: "V-coat",
        title: "V coat",
        source: "two layers that leave nothing of one wavelength on glass of index 1.52: Schuster, Ann. Phys. 439, 352 (1949); Macleod, ch. 4",
        design_nm: 550.0,
        layers: &[("MgF2", 0.319_637_1), ("ZrO2", 0.060_930_7)],
        metal: None,
    },
    Recipe {
        name: "aluminium",
        title: "Aluminium mirror",
        source: "bare: Rakić, Appl. Opt. 34, 4755 (1995)",
        design_nm: 550.0,
        layers: &[],
        metal: Some("Al"),
    },
    Recipe {
        name: "protected-aluminium",
        title: "Protected aluminium mirror",
        source: "half a wave of silica on aluminium: Hass, J. Opt. Soc. Am. 45, 945 (1955)",
        design_nm: 550.0,
        layers: &[("SiO2", 0.5)],
        metal: Some("Al"),
    },
    Recipe {
        name: "protected-silver",
        title: "Protected silver mirror",
        source: "half a wave of silica on silver: Hass, J. Opt. Soc. Am. 45, 945 (1955), with n and k of Johnson and Christy (1972)",
        design_nm: 550.0,
        layers: &[("SiO2", 0.5)],
        metal: Some("Ag"),
    },
];

/// The names of the recipes, for messages.
pub(super) fn names() -> String {
    RECIPES.iter().map(|recipe| recipe.name).collect::<Vec<_>>().join(", ")
}

/// A recipe for some wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Made {
    recipe: &'static Recipe,
    design_nm: f64,
}

impl Recipe {
    /// The recipe of a name, in any case, with another design wavelength behind it if there is one: `MgF2@500`.
    pub(super) fn named(text: &str) -> Option<Made> {
        let (name, design_nm) = match text.split_once('@') {
            Some((name, nm)) => (name, Some(nm.parse::<f64>().ok().filter(|nm| (100.0..20_000.0).contains(nm))?)),
            None => (text, None),
        };
        let recipe = RECIPES.iter().find(|recipe| recipe.name.eq_ignore_ascii_case(name))?;
        Some(Made { recipe, design_nm: design_nm.unwrap_or(recipe.design_nm) })
    }
}

impl Made {
    pub(super) fn coating(self) -> Coating {
        let Self { recipe, design_nm } = self;
        let layer =
            |(film, waves): &(&str, f64)| Film::named(film).map(|film| Layer::of_waves(film, *waves, design_nm));
        let name = match design_nm == recipe.design_nm {
            true => recipe.name.to_owned(),
            false => format!("{}@{design_nm}", recipe.name),
        };
        let metal = recipe.metal.and_then(Film::named).map(|film| Layer { film, thickness_nm: OPAQUE_NM });
        Coating::of(&name, recipe.layers.iter().filter_map(layer).chain(metal).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Split;
    use super::*;

    /// Every film of every recipe is known, and every recipe reduces reflections: on glass of index 1.52 the mean over the visible is less
    /// the more layers there are; a single layer of MgF2 leaves about 1.5 %, three layers about 0.5 % (Macleod, ch. 4).
    #[test]
    fn more_layers_reflect_less() {
        let mean = |recipe: &Recipe| {
            let coating = Coating::parse(recipe.name).unwrap();
            assert_eq!(coating.layers().len(), recipe.layers.len() + usize::from(recipe.metal.is_some()));
            let nm = |i: i32| 430.0 + 10.0 * f64::from(i);
            (0..24).map(|i| coating.split(1.0, 1.52, nm(i), 1.0).mean_reflected()).sum::<f64>() / 24.0
        };
        let [none, single, _, triple, ..] = RECIPES.each_ref().map(mean);
        assert!(
            (none - 0.0426).abs() < 1e-4 && (single - 0.0145).abs() < 1.5e-3 && triple < 0.006,
            "{none} {single} {triple}"
        );
    }

    /// A V coat reflects nothing at the wavelength that it is made for.
    #[test]
    fn a_v_coat_leaves_nothing() {
        let coating = Coating::parse("V-coat").unwrap();
        let left = |nm| coating.split(1.0, 1.52, nm, 1.0).mean_reflected();
        assert!(left(550.0) < 1e-9 && left(430.0) > 0.01 && left(700.0) > 0.01, "{}", left(550.0));
    }

    /// Aluminium reflects 91 to 92 % of green light and 87 % at 800 nm, silver 98 % (Bass, Handbook of Optics, vol. IV, ch. 4).
    #[test]
    fn mirrors_reflect_as_measured() {
        let left = |name, nm| Coating::parse(name).unwrap().mirrored(1.0, nm, 1.0);
        assert!((left("aluminium", 550.0).mean_reflected() - 0.916).abs() < 0.006);
        assert!((left("aluminium", 800.0).mean_reflected() - 0.868).abs() < 0.01);
        assert!((left("protected-silver", 550.0).mean_reflected() - 0.98).abs() < 0.01);
        assert_eq!(left("protected-silver", 550.0).mean_transmitted(), 0.0);
        assert_eq!(Coating::BARE.mirrored(1.0, 550.0, 0.3), Split::MIRROR);
    }

    #[test]
    fn names_are_read() {
        assert!(Coating::parse("NONE").unwrap().is_bare());
        assert_eq!(Coating::parse("mgf2").unwrap().name(), "MgF2");
        assert_eq!(Coating::parse("MgF2@500").unwrap().name(), "MgF2@500");
        let own = Coating::parse("MgF2:99.6nm/2.1:0.5w@550/Al2O3:78nm").unwrap();
        assert_eq!(own.layers().len(), 3);
        assert!((own.layers()[1].thickness_nm - 0.5 * 550.0 / 2.1).abs() < 1e-9);
        for bad in ["magic", "MgF2:", "glue:100nm", "MgF2:100", "MgF2:-3nm", "MgF2@0"] {
            assert!(Coating::parse(bad).is_err(), "{bad}");
        }
    }
}
