//! Intensity of a luminaire by direction, from a file of the Illuminating Engineering Society (LM-63).

use std::f32::consts::PI;

/// Watts per steradian of a candela in daylight of 6500 K, times the whole sphere: the unit of Blender's lights.
const CANDELA: f32 = 4.0 * PI / 177.83;

/// Intensities over two angles, in degrees.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ies {
    /// Vertical angles from straight down, growing.
    vertical: Vec<f32>,
    /// Horizontal angles about the axis, growing, from 0 to 360.
    horizontal: Vec<f32>,
    /// Intensities by horizontal, then vertical angle.
    intensity: Vec<Vec<f32>>,
}

/// Numbers in a row, parted by blanks or commas.
struct NumberReader<'a>(std::str::SplitWhitespace<'a>);

impl NumberReader<'_> {
    fn next(&mut self) -> Result<f32, String> {
        let word = self.0.next().ok_or("its file ends too early")?;
        word.parse().map_err(|_| format!("its file has {word:?} where a number belongs"))
    }

    fn list(&mut self, count: usize) -> Result<Vec<f32>, String> {
        (0..count).map(|_| self.next()).collect()
    }

    fn count(&mut self) -> Result<usize, String> {
        let number = self.next()?;
        if (1.0..=100_000.0).contains(&number) {
            Ok(number as usize)
        } else {
            Err(format!("its file counts {number} angles"))
        }
    }
}

impl Ies {
    /// Reads a file's text.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let (line, rest) = text
            .lines()
            .zip(text.split_inclusive('\n').scan(0, |end, line| {
                *end += line.len();
                Some(*end)
            }))
            .find(|(line, _)| line.trim_start().starts_with("TILT="))
            .ok_or("its file has no line TILT=")?;
        let body = text[rest..].replace(',', " ");
        let mut numbers = NumberReader(body.split_whitespace());
        match line.trim().trim_start_matches("TILT=").trim() {
            "NONE" => {}
            "INCLUDE" => {
                // How the lamp's tilt dims it: it stands as it is meant to.
                numbers.next()?;
                let pairs = numbers.count()?;
                numbers.list(2 * pairs)?;
            }
            other => return Err(format!("its file keeps its tilt in another, {other}")),
        }
        // Lamps, lumens of each; then the factor.
        numbers.list(2)?;
        let multiplier = numbers.next()?;
        let (verticals, horizontals) = (numbers.count()?, numbers.count()?);
        let kind = numbers.next()?;
        // Units, three sizes.
        numbers.list(4)?;
        let (ballast, photometric) = (numbers.next()?, numbers.next()?);
        // Watts.
        numbers.next()?;
        let factor = multiplier * ballast * photometric * CANDELA;
        let (vertical, horizontal) = (numbers.list(verticals)?, numbers.list(horizontals)?);
        let mut intensity = Vec::with_capacity(horizontals);
        for _ in 0..horizontals {
            intensity.push(numbers.list(verticals)?.into_iter().map(|candela| candela * factor).collect());
        }
        let rises = |angles: &[f32]| angles.windows(2).all(|two| two[0] < two[1]);
        if !rises(&vertical) || !rises(&horizontal) {
            return Err("its file's angles do not rise".into());
        }
        let read = Self { vertical, horizontal, intensity };
        match kind as i32 {
            1 => read.about_the_axis(),
            other => {
                let name = ["B", "A"].get((other as usize).wrapping_sub(2)).unwrap_or(&"unknown");
                Err(format!("its file's photometry is of type {name}, of which only C is supported"))
            }
        }
    }

    /// Type C: planes that the file leaves out by symmetry are filled in.
    fn about_the_axis(mut self) -> Result<Self, String> {
        if self.horizontal[0] == 90.0 {
            self.horizontal.iter_mut().for_each(|angle| *angle -= 90.0);
        }
        if self.horizontal[0] != 0.0 {
            return Err(format!("its file's horizontal angles begin at {}", self.horizontal[0]));
        }
        if self.horizontal.len() == 1 {
            self.horizontal.push(360.0);
            self.intensity.push(self.intensity[0].clone());
        }
        for half in [90.0, 180.0] {
            if self.horizontal.last() == Some(&half) {
                self.mirror_at(half);
            }
        }
        // Some files leave out the last angle, which is the first.
        let n = self.horizontal.len();
        let next = 2.0 * self.horizontal[n - 1] - self.horizontal[n - 2];
        if (self.horizontal[n - 1] - 360.0).abs() > 1e-3 && (next - 360.0).abs() < 1e-2 {
            self.horizontal.push(360.0);
            self.intensity.push(self.intensity[0].clone());
        }
        Ok(self)
    }

    fn mirror_at(&mut self, last: f32) {
        for i in (0..self.horizontal.len() - 1).rev() {
            self.horizontal.push(2.0 * last - self.horizontal[i]);
            self.intensity.push(self.intensity[i].clone());
        }
    }

    /// Intensity at two angles; none beyond the file's angles.
    pub(crate) fn at(&self, horizontal_rad: f32, vertical_rad: f32) -> f32 {
        let Some((h, along_h)) = place(&self.horizontal, horizontal_rad.to_degrees()) else { return 0.0 };
        let Some((v, along_v)) = place(&self.vertical, vertical_rad.to_degrees()) else { return 0.0 };
        let last = self.horizontal.len() - 1;
        // The last angle is the first.
        let rows = [if h == 0 { last - 1 } else { h - 1 }, h, h + 1, if h + 2 > last { 1 } else { h + 2 }];
        let values = rows.map(|row| {
            let row = &self.intensity[row.min(last)];
            let end = row.len() - 1;
            // Across the pole it goes on as it came.
            cubic([if v == 0 { 1 } else { v - 1 }, v, v + 1, (v + 2).min(end)].map(|i| row[i.min(end)]), along_v)
        });
        cubic(values, along_h).max(0.0)
    }
}

/// The last angle of a list that is not above one, and how far on the way to the next that is.
fn place(angles: &[f32], angle: f32) -> Option<(usize, f32)> {
    let last = angles.len() - 1;
    if last == 0 || !(angles[0] <= angle && angle <= angles[last] + 1e-3) {
        return None;
    }
    let i = angles.partition_point(|a| *a <= angle).saturating_sub(1).min(last - 1);
    Some((i, ((angle - angles[i]) / (angles[i + 1] - angles[i])).clamp(0.0, 1.0)))
}

/// Catmull's and Rom's curve from the second to the third.
fn cubic([a, b, c, d]: [f32; 4], x: f32) -> f32 {
    0.5 * (((d + 3.0 * (b - c) - a) * x + (2.0 * a - 5.0 * b + 4.0 * c - d)) * x + (c - a)) * x + b
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAMP: &str =
        "IESNA:LM-63-2002\n[TEST] none\nTILT=NONE\n1 1000 2.0 3 1 1 2 0.1 0.1 0\n1.0 0.5 60\n0 45 90\n0\n100 50 0\n";

    #[test]
    fn a_file_is_read_between_its_angles() {
        let ies = Ies::parse(LAMP).unwrap();
        let at = |vertical: f32| ies.at(1.0, vertical.to_radians()) / CANDELA;
        assert!((at(0.0) - 100.0).abs() < 1e-3 && (at(45.0) - 50.0).abs() < 1e-3 && at(90.0).abs() < 1e-3);
        assert!(at(20.0) < 100.0 && at(20.0) > 50.0);
        assert_eq!(at(100.0), 0.0);
    }

    #[test]
    fn symmetry_fills_the_circle() {
        let text = LAMP.replace("2.0 3 1 1", "1.0 3 2 1").replace("\n0\n100 50 0\n", "\n0 90\n100 50 0\n100 10 0\n");
        let ies = Ies::parse(&text.replace("0.5 60", "1.0 60")).unwrap();
        assert_eq!(ies.horizontal, [0.0, 90.0, 180.0, 270.0, 360.0]);
        let at = |turn: f32| ies.at(turn.to_radians(), 45f32.to_radians()) / CANDELA;
        for (turn, candela) in [(0.0, 50.0), (90.0, 10.0), (180.0, 50.0), (270.0, 10.0)] {
            assert!((at(turn) - candela).abs() < 1e-2, "{turn}: {}", at(turn));
        }
    }

    #[test]
    fn what_is_no_file_is_refused_by_name() {
        for (text, word) in [("", "TILT"), ("TILT=NONE\n1 2", "early"), ("TILT=NONE\n1 2 x", "number")] {
            assert!(Ies::parse(text).unwrap_err().contains(word), "{text}");
        }
    }
}
