use super::file::SensorFile;
use super::film::FilmSensor;
use super::mosaic::Mosaic;
use super::random::Stream;
use super::response::Response;
use crate::spectrum;
use glam::{DMat3, DVec3, Mat3};
use petzval_optics::sensitivity::Sensitivities;

fn shipped(name: &str) -> Response {
    Response::new(SensorFile::find(name).unwrap())
}

/// At each wavelength the electrons that the picture's colours stand for are in the ratio of the file's sensitivities, to 2 %: the bands'
/// middles miss some 1e-3 of the integral, which the film makes up for by mixing all wavelengths a little.
#[test]
fn the_film_sees_wavelengths_as_the_sensor_does() {
    for name in Sensitivities::words() {
        let response = shipped(name);
        let channels = response.electrons_per_lx_s(response.sensor().pixel_pitch_um);
        let curves: Vec<(f64, [f64; 3])> = Sensitivities::shipped(name).unwrap().samples().collect();
        for wavelength in FilmSensor::new(response).unwrap().visible_in(48).wavelengths() {
            let seen = channels * (wavelength.response.as_dmat3() * DVec3::ONE);
            let at = (wavelength.nm - curves[0].0) / 10.0;
            let (low, part) = (at as usize, at.fract());
            let published =
                DVec3::from_array([0, 1, 2].map(|i| curves[low].1[i] * (1.0 - part) + curves[low + 1].1[i] * part));
            let apart = (seen / seen.length() - published / published.length()).length();
            assert!(apart < 0.02, "{name} {} nm: {seen} {published}", wavelength.nm);
        }
    }
}

/// Colours of the scene are as they are where the lens parts no wavelengths.
#[test]
fn the_film_of_a_sensor_shifts_no_colour() {
    for name in Sensitivities::words() {
        let film = FilmSensor::new(shipped(name)).unwrap().visible_in(48);
        let list = film.wavelengths();
        let mean = list.iter().fold(Mat3::ZERO, |sum, w| sum + w.response) * (list.len() as f32).recip();
        assert!(mean.abs_diff_eq(Mat3::IDENTITY, 1e-5), "{name} {mean:?}");
    }
}

/// The matrix of a raw file makes the neutral channels of D65, whose X, Y and Z are published (CIE 015:2018): 0.95047, 1, 1.08883.
#[test]
fn white_is_neutral() {
    for name in Sensitivities::words() {
        let response = shipped(name);
        let white = response.channels_from_xyz().unwrap() * DVec3::new(0.950_47, 1.0, 1.088_83);
        assert!(white.abs_diff_eq(response.neutral().unwrap(), 1e-4), "{name} {white}");
    }
}

/// An observer with the CIE's curves as sensitivities has the response of the CIE's observer: the matrix is that from XYZ, to a factor by
/// row.
#[test]
fn the_observer_as_a_sensor_needs_no_matrix() {
    let column =
        |i: usize| -> Vec<f64> { (0..81).map(|k| spectrum::observer(380.0 + 5.0 * f64::from(k))[i]).collect() };
    let response = shipped("nikon-d700");
    let file = SensorFile {
        first_nm: 380.0,
        step_nm: 5.0,
        red: column(0),
        green: column(1),
        blue: column(2),
        ..response.sensor().clone()
    };
    let matrix = Response::new(file).channels_from_xyz().unwrap();
    let scale = matrix.y_axis.y;
    let expected = DMat3::IDENTITY * scale;
    // Mallett and Yuksel's spectra are rounded, a primary is off by 2e-4; and sums over the CIE's rows of 5 nm, of which the matrix of
    // Rec.709 is, differ by 1e-3 from integrals with straight lines between them. Two such differences, in a matrix with entries of 3.
    assert!(matrix.abs_diff_eq(expected, 3e-3 * scale), "{matrix:?}");
}

/// Mean and variance of Poisson's distribution are the mean; skewness is one over its root. Of a million numbers, to five standard errors.
#[test]
fn counts_have_the_moments_of_their_distribution() {
    const COUNT: u64 = 1_000_000;
    for mean in [0.05, 1.0, 9.99, 10.0, 37.5, 1234.5, 5e6] {
        let [mut first, mut second, mut third] = [0.0_f64; 3];
        for place in 0..COUNT {
            let apart = Stream::new(7, Some(3), place).poisson(mean) - mean;
            first += apart;
            second += apart * apart;
            third += apart.powi(3);
        }
        let [first, second, third] = [first, second, third].map(|sum| sum / COUNT as f64);
        let error = 5.0 / (COUNT as f64).sqrt();
        assert!(first.abs() < error * mean.sqrt(), "{mean}: {first}");
        assert!((second - mean).abs() < error * (mean + 2.0 * mean * mean).sqrt(), "{mean}: {second}");
        // Sixth central moment: 15 m³ + 25 m² + m.
        let spread = (15.0 * mean.powi(3) + 25.0 * mean * mean + mean).sqrt();
        assert!((third - mean).abs() < error * spread, "{mean}: {third}");
    }
}

#[test]
fn photosites_have_streams_of_their_own() {
    let first = |seed, frame, place| Stream::new(seed, frame, place).uniform();
    assert_eq!(first(1, Some(2), 3), first(1, Some(2), 3));
    let others = [first(2, Some(2), 3), first(1, Some(3), 3), first(1, Some(2), 4), first(1, None, 3)];
    assert!(others.iter().all(|other| *other != first(1, Some(2), 3)));
}

#[test]
fn mosaics_repeat() {
    let bayer = Mosaic::by_word("grbg").unwrap();
    let channels = |y: usize| [0, 1, 2, 3].map(|x| bayer.channel(x, y, 0));
    assert_eq!((channels(0), channels(1), channels(2)), ([1, 0, 1, 0], [2, 1, 2, 1], [1, 0, 1, 0]));
    // Fujifilm's has 20 green, 8 red and 8 blue filters of 36, all three in every row and every column.
    let trans = Mosaic::by_word("X-Trans").unwrap();
    let all: Vec<usize> = (0..36).map(|i| trans.channel(i % 6, i / 6, 0)).collect();
    assert_eq!([0, 1, 2].map(|c| all.iter().filter(|one| **one == c).count()), [8, 20, 8]);
    for line in 0..6 {
        for colour in 0..3 {
            assert!(
                (0..6).any(|i| trans.channel(i, line, 0) == colour)
                    && (0..6).any(|i| trans.channel(line, i, 0) == colour)
            );
        }
    }
    for bad in ["rgbw", "rggbb", ""] {
        assert!(Mosaic::by_word(bad).is_err(), "{bad}");
    }
    assert!(Mosaic::of_rows(&["RG", "G"]).is_err() && Mosaic::of_rows(&["RG", "GG"]).is_err());
}

/// A file's own words may hold line ends; a message has one line.
#[test]
fn a_message_about_a_file_has_one_line() {
    for text in [r#"{"a\nb": 1}"#, r#"{"name": "x", "mosaic": "a\nb"}"#, r#"{"curves_per": "a\nb"}"#] {
        let message = SensorFile::parse(text, "x.json").unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
    }
}

/// A sensor that sees no visible light has no film speed: an error, not a number that is none.
#[test]
fn a_sensor_sees_light() {
    let text = |first_nm: f64| {
        let mut file: serde_json::Value = serde_json::from_str(Sensitivities::file("nikon-d700").unwrap()).unwrap();
        file["first_nm"] = first_nm.into();
        file["base_iso"] = serde_json::Value::Null;
        file["peak_quantum_efficiency"] = 0.5.into();
        file.to_string()
    };
    let of = |first_nm: f64| {
        super::report::report(&Response::new(SensorFile::parse(&text(first_nm), "x.json").unwrap()), None)
    };
    assert!(of(400.0).unwrap().dynamic_range_stops.is_finite());
    let message = of(1900.0).unwrap_err().to_string();
    assert!(
        message.ends_with("see nothing of visible light: give base_iso and peak_quantum_efficiency both"),
        "{message}"
    );
}
