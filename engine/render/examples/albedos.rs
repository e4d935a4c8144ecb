//! Computes the tables of albedos that are part of the program: `albedos OUT`; `engine/render/data/albedos.bin` is its output.

use petzval_render::shading::energy;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).ok_or("albedos OUT")?;
    let numbers = energy::compute().flat_map(|table| table.numbers().collect::<Vec<_>>());
    std::fs::write(out, numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())?;
    Ok(())
}
