//! Sends random rays through every shipped lens both ways, as many as are asked for: see the module.
//!
//! `cargo run --release -p petzval-optics --example flood [RAYS]`

#[path = "../tests/all/flood/flood.rs"]
#[allow(unreachable_pub)]
mod flood;

use std::time::Instant;

fn main() {
    let rays: f64 = std::env::args().nth(1).map_or(1e8, |text| text.parse().expect("the number of rays"));
    let start = Instant::now();
    let flood::Flood { rays, passed, lenses } = flood::flood(rays as u64);
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{rays} rays through {lenses} lenses in {seconds:.0} s: {passed} passed, the rest lost for named reasons; none was no number"
    );
}
