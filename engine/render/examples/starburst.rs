//! The image of a point of light by a lens, as a picture and in seconds: `starburst LENS F_NUMBER BLADES WIDTH HEIGHT FILM_MM OUT.pfm
//! [SPIDER]`.
//!
//! The picture has one pixel of value 1e6 in its middle, or, with a place `X,Y` (fractions from the middle) behind OUT, there.
//! `SPIDER` is a number of vanes that are put into the diaphragm, each 3 % of it wide.

use petzval_optics::diaphragm::ApertureMask;
use petzval_render::Rgb;
use petzval_render::camera::CameraDescription;
use petzval_render::stray::diffraction::Diffraction;
use std::io::Write;
use std::sync::Arc;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let [lens, f_number, blades, width, height, film_mm, out, more @ ..] = given.as_slice() else {
        return Err("starburst LENS F_NUMBER BLADES WIDTH HEIGHT FILM_MM OUT.pfm [X,Y] [SPIDER]".into());
    };
    let (width, height): (u32, u32) = (width.parse()?, height.parse()?);
    let film_width_mm: f64 = film_mm.parse()?;
    let place = more
        .first()
        .and_then(|at| at.split_once(','))
        .map_or(Ok([0.0; 2]), |(x, y)| Ok::<_, std::num::ParseFloatError>([x.parse::<f64>()?, y.parse::<f64>()?]))?;
    let vanes = more.get(1).map_or(Ok(0), |n| n.parse::<u32>())?;
    let f_number = (f_number != "-").then(|| f_number.parse()).transpose()?;
    let blades = blades.parse()?;
    let aperture_mask = (vanes > 0).then(|| spider(vanes)).transpose()?;
    let d = CameraDescription { lens_path: lens.into(), ..CameraDescription::default() }.with(|c| {
        c.lens.f_number = f_number;
        c.lens.blades = blades;
        c.film.width_mm = film_width_mm;
        c.film.height_mm = film_width_mm;
        c.lens.aperture_mask = aperture_mask;
    });
    let start = Instant::now();
    let diffraction = Diffraction::new(&d, [width, height])?;
    let made = start.elapsed().as_secs_f64();
    let (w, h) = (width as usize, height as usize);
    let at = |part: f64, n: usize| (((part + 0.5) * n as f64) as usize).min(n - 1);
    let mut picture = vec![Rgb::ZERO; w * h];
    picture[at(place[1], h) * w + at(place[0], w)] = Rgb::splat(1e6);
    let start = Instant::now();
    let change = diffraction.change(&picture);
    let spread = start.elapsed().as_secs_f64();
    picture.iter_mut().zip(change).for_each(|(to, change)| *to += change);
    let least = picture.iter().map(|c| c.min_element()).fold(0.0, f32::min);
    let sum = picture.iter().map(|c| f64::from(c.y)).sum::<f64>() / 1e6;
    println!(
        "{} zones; made in {made:.2} s, spread in {spread:.2} s; sum {sum:.6}; least {:.1e} of the bright pixel",
        diffraction.zones(),
        least / 1e6
    );
    let mut file = std::io::BufWriter::new(std::fs::File::create(out)?);
    write!(file, "PF\n{width} {height}\n-1.0\n")?;
    for value in picture.iter().flat_map(|c| c.to_array()) {
        file.write_all(&value.to_le_bytes())?;
    }
    Ok(())
}

/// A round opening behind a spider.
fn spider(vanes: u32) -> Result<Arc<ApertureMask>, petzval_optics::diaphragm::MaskError> {
    const SIDE: usize = 1024;
    let value = |i: usize| {
        let at = |k: usize| (k as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
        let (x, y) = (at(i % SIDE), at(i / SIDE));
        let near = |vane: u32| {
            let (sin, cos) = (0.3 + vane as f32 / vanes as f32 * std::f32::consts::TAU).sin_cos();
            if x * cos + y * sin > 0.0 { (y * cos - x * sin).abs() } else { f32::INFINITY }
        };
        let off = (0..vanes).map(near).fold(f32::INFINITY, f32::min);
        // A soft step of eight values: interpolation puts the edge where it belongs.
        ((off - 0.03) * 0.0625 * SIDE as f32 + 0.5).clamp(0.0, 1.0)
    };
    ApertureMask::new(SIDE, &(0..SIDE * SIDE).map(value).collect::<Vec<f32>>()).map(Arc::new)
}
