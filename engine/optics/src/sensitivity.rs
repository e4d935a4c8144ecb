//! Spectral sensitivities of cameras' channels, red, green and blue of a raw picture, by wavelength.

use std::sync::OnceLock;

use serde::Deserialize;

/// The files that are shipped, in the order in which they are offered.
const FILES: [(&str, &str); 2] = [
    ("nikon-d700", include_str!("../../../lenses/sensors/nikon-d700.json")),
    ("sony-a7r2", include_str!("../../../lenses/sensors/sony-a7r2.json")),
];

/// The sensitivities of a camera, relative, evenly spaced in wavelength.
#[derive(Clone, Debug, Deserialize)]
pub struct Sensitivities {
    /// The camera.
    pub name: String,
    /// The source of the numbers.
    pub source: String,
    first_nm: f64,
    step_nm: f64,
    red: Vec<f64>,
    green: Vec<f64>,
    blue: Vec<f64>,
}

impl Sensitivities {
    /// The words by which shipped cameras are asked for.
    pub fn words() -> [&'static str; FILES.len()] {
        FILES.map(|(word, _)| word)
    }

    /// The text of a shipped camera's file by its word; `None`: there is none.
    pub fn file(word: &str) -> Option<&'static str> {
        FILES.into_iter().find(|(known, _)| *known == word).map(|(_, text)| text)
    }

    /// A shipped camera by its word; `None`: there is none.
    pub fn shipped(word: &str) -> Option<&'static Self> {
        static READ: OnceLock<Vec<(&str, Sensitivities)>> = OnceLock::new();
        let all = READ.get_or_init(|| {
            let read = |(word, text)| Some((word, serde_json::from_str(text).ok()?));
            FILES.into_iter().filter_map(read).collect()
        });
        all.iter().find(|(known, _)| *known == word).map(|(_, found)| found)
    }

    /// The wavelengths, nm, and the sensitivities of red, green and blue at each.
    pub fn samples(&self) -> impl Iterator<Item = (f64, [f64; 3])> {
        let channels = self.red.iter().zip(&self.green).zip(&self.blue);
        channels
            .enumerate()
            .map(|(i, ((red, green), blue))| (self.first_nm + self.step_nm * i as f64, [*red, *green, *blue]))
    }
}

#[cfg(test)]
mod tests {
    use super::Sensitivities;

    /// The middle of each channel lies where a camera's filters are: published curves peak at about 460, 530 and 600 nm; the light that the
    /// filters let through beside that draws red's middle down.
    #[test]
    fn channels_see_their_colours() {
        for word in Sensitivities::words() {
            let camera = Sensitivities::shipped(word).unwrap();
            assert_eq!(camera.samples().count(), 33, "{word}");
            let middle = |channel: usize| {
                let (sum, weighted) = camera
                    .samples()
                    .fold((0.0, 0.0), |(sum, at), (nm, see)| (sum + see[channel], at + nm * see[channel]));
                weighted / sum
            };
            let [red, green, blue] = [0, 1, 2].map(middle);
            assert!((580.0..630.0).contains(&red) && (520.0..550.0).contains(&green), "{word} {red} {green}");
            assert!((450.0..480.0).contains(&blue), "{word} {blue}");
        }
        assert!(Sensitivities::shipped("box-brownie").is_none());
    }
}
