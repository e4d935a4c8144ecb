//! Writes inputs that are made by the engine into the kept corpora: whole films and pictures, of which a fuzzer would not think by itself.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let [checkpoint, share] = petzval_fuzz::films::seeds();
    for (target, inputs) in [checkpoint, share, ("merge", vec![petzval_fuzz::pictures::picture()])] {
        let folder = corpus.join(target);
        std::fs::create_dir_all(&folder)?;
        for (i, bytes) in inputs.iter().enumerate() {
            std::fs::write(folder.join(format!("whole-{i}")), bytes)?;
        }
    }
    Ok(())
}
