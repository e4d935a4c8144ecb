//! Scattering in a lens, in numbers and as a picture: `glare LENS F_NUMBER ROUGHNESS_NM CLEANLINESS VEIL WIDTH HEIGHT FILM_MM OUT.pfm`.
//!
//! The picture has a value of 1e6 in its middle and 1 on its left half.

use petzval_render::Rgb;
use petzval_render::camera::CameraDescription;
use petzval_render::stray::glare::{Glare, Scattering};
use std::io::Write;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let [lens, f_number, roughness, cleanliness, veil, width, height, film_mm, out] = given.as_slice() else {
        return Err("glare LENS F_NUMBER ROUGHNESS_NM CLEANLINESS VEIL WIDTH HEIGHT FILM_MM OUT.pfm".into());
    };
    let (width, height): (u32, u32) = (width.parse()?, height.parse()?);
    let film_width_mm: f64 = film_mm.parse()?;
    let scattering = Scattering {
        roughness_nm: roughness.parse()?,
        cleanliness: cleanliness.parse()?,
        veiling_index: veil.parse()?,
    };
    let f_number = (f_number != "-").then(|| f_number.parse()).transpose()?;
    let d = CameraDescription { lens_path: lens.into(), scattering, ..CameraDescription::default() }.with(|c| {
        c.lens.f_number = f_number;
        c.film.width_mm = film_width_mm;
        c.film.height_mm = film_width_mm;
    });
    let glare = Glare::new(&d, [width, height])?;
    let (w, h) = (width as usize, height as usize);
    let mut picture: Vec<Rgb> = (0..w * h).map(|i| if i % w < w / 2 { Rgb::ONE } else { Rgb::ZERO }).collect();
    picture[h / 2 * w + w / 2] = Rgb::splat(1e6);
    let start = Instant::now();
    let change = glare.change(&picture, None);
    let [red, green, blue] = glare.scattered();
    println!("scattered {red:.3e} {green:.3e} {blue:.3e}; spread in {:.2} s", start.elapsed().as_secs_f64());
    picture.iter_mut().zip(change).for_each(|(to, change)| *to += change);
    let mut file = std::io::BufWriter::new(std::fs::File::create(out)?);
    write!(file, "PF\n{width} {height}\n-1.0\n")?;
    for value in picture.iter().flat_map(|c| c.to_array()) {
        file.write_all(&value.to_le_bytes())?;
    }
    Ok(())
}
