//! Pictures made for the purpose.

use super::*;
use exr::prelude::*;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("petzval-pictures-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    /// Two by one pixels.
    fn picture(&self, name: &str, channels: &[(&str, [f32; 2])], attributes: &[(&str, &str)]) -> PathBuf {
        let list = channels.iter().map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.to_vec())));
        let mut layer =
            Layer::new((2, 1), LayerAttributes::default(), Encoding::FAST_LOSSLESS, AnyChannels::sort(list.collect()));
        for (name, value) in attributes {
            layer.attributes.other.insert((*name).into(), AttributeValue::Text((*value).into()));
        }
        let file = self.0.join(name);
        Image::from_layer(layer).write().to_file(&file).unwrap();
        file
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn read(file: &Path) -> PicturePart {
    PicturePart::read(file, u64::MAX).unwrap().0
}

#[test]
fn means_are_by_each_pixels_samples() {
    let folder = Folder::new("means");
    let part = |name: &str, n: [f32; 2], red: [f32; 2], depth: [f32; 2]| {
        let channels = [("View.1.Combined.R", red), ("View.1.Depth.Z", depth), ("View.1.Debug Sample Count.X", n)];
        folder.picture(name, &channels, &[])
    };
    let files =
        [part("a.exr", [1.0, 8.0], [4.0, 1.0], [3.0, 1e10]), part("b.exr", [3.0, 8.0], [8.0, 2.0], [1e10, 1e10])];
    let out = folder.0.join("out.exr");
    let merged = merge(&files, &out, u64::MAX).unwrap();
    assert_eq!(merged, Merged { samples: 10.0, is_exact: false });
    let whole = read(&out);
    assert_eq!(whole.channel("View.1.Combined.R").unwrap(), [7.0, 1.5]);
    // Most of the samples saw nothing.
    assert_eq!(whole.channel("View.1.Depth.Z").unwrap(), [1e10, 1e10]);
    let files = [files[0].clone(), part("c.exr", [1.0, 1.0], [0.0, 0.0], [5.0, 2.0])];
    merge(&files, &out, u64::MAX).unwrap();
    assert_eq!(read(&out).channel("View.1.Depth.Z").unwrap(), [4.0, 1e10]);
    assert_eq!(whole.channel("View.1.Debug Sample Count.X").unwrap(), [4.0, 16.0]);
}

#[test]
fn a_plain_picture_counts_as_its_metadata_says() {
    let folder = Folder::new("plain");
    let part =
        |name: &str, red: f32, attributes: &[(&str, &str)]| folder.picture(name, &[("R", [red, red])], attributes);
    let a = part("a.exr", 1.0, &[("petzval/samples", "16"), ("petzval/ranges", "7:0+16")]);
    let b = part("b.exr", 3.0, &[("petzval/samples", "48"), ("petzval/ranges", "7:16+48")]);
    let (ab, out) = (folder.0.join("ab.exr"), folder.0.join("out.exr"));
    assert_eq!(merge(&[a.clone(), b.clone()], &ab, u64::MAX).unwrap().samples, 64.0);
    assert_eq!(read(&ab).channel("R").unwrap(), [2.5, 2.5]);
    // What was joined knows what it holds.
    let said = merge(&[b.clone(), ab.clone()], &out, u64::MAX).unwrap_err().to_string();
    assert!(said.contains("samples 16 to 63 of seed 7 are in") && said.contains("b.exr too"), "{said}");
    let c = part("c.exr", 7.0, &[("petzval/samples", "64"), ("petzval/ranges", "7:64+64")]);
    assert_eq!(merge(&[ab, c], &out, u64::MAX).unwrap().samples, 128.0);
    assert_eq!(read(&out).channel("R").unwrap(), [4.75, 4.75]);
}

#[test]
fn what_cannot_be_joined_is_said() {
    let folder = Folder::new("refused");
    let count = [("petzval/samples", "16")];
    let a = folder.picture("a.exr", &[("R", [1.0; 2])], &count);
    let out = folder.0.join("out.exr");
    let said = |files: &[PathBuf]| merge(files, &out, u64::MAX).unwrap_err().to_string();
    assert!(said(std::slice::from_ref(&a)).contains("name two or more"));
    let other = folder.picture("b.exr", &[("R", [1.0; 2]), ("View.Depth.Z", [1.0; 2])], &count);
    assert!(said(&[a.clone(), other]).contains("the channel View.Depth.Z is in"));
    let silent = folder.picture("c.exr", &[("R", [1.0; 2])], &[]);
    assert!(said(&[a.clone(), silent]).contains("c.exr: it does not say how many samples"));
    let broken = folder.0.join("d.exr");
    std::fs::write(&broken, b"no picture").unwrap();
    assert!(said(&[a.clone(), broken]).contains("d.exr: cannot be read"));
    assert!(said(&[a, folder.0.join("none.exr")]).contains("none.exr: cannot be read"));
    assert!(!out.exists());
}

/// Parts say which picture they are of; the first difference is named.
#[test]
fn parts_of_other_pictures_are_refused() {
    let folder = Folder::new("other");
    let of = |name: &str, told: &str| {
        let all = [("petzval/samples", "4"), ("petzval/picture", told)];
        let attributes = if told.is_empty() { &all[..1] } else { &all[..] };
        folder.picture(name, &[("R", [1.0, 2.0])], attributes)
    };
    let first = of("a.exr", "scene=1f; camera.f_number=2.8");
    let said = |other: &str| {
        let other = of("b.exr", other);
        merge(&[first.clone(), other], &folder.0.join("out.exr"), u64::MAX).map_err(|error| error.to_string())
    };
    assert!(said("scene=1f; camera.f_number=2.8").is_ok());
    assert!(said("scene=1f; camera.f_number=8").unwrap_err().contains("camera.f_number is 8, and 2.8 in"));
    assert!(said("scene=2e; camera.f_number=2.8").unwrap_err().contains("its scene is not that of"));
    assert!(said("").unwrap_err().contains("does not say of which picture it is"));
}

/// The files of two eyes have the metadata of both; their pixels say which is which, also once they are joined.
#[test]
fn views_are_not_joined_with_others() {
    let folder = Folder::new("views");
    let checksum = |red: [f32; 2]| format!("{:08x}", crc32fast::hash(red.map(f32::to_le_bytes).as_flattened()));
    let (left, right) = ([1.0, 2.0], [1.5, 2.0]);
    let of = |name: &str, red: [f32; 2]| {
        let told = [checksum(left), checksum(right)];
        let attributes = [
            ("petzval/samples", "4"),
            ("petzval/view/left/View Layer", told[0].as_str()),
            ("petzval/view/right/View Layer", told[1].as_str()),
        ];
        folder.picture(name, &[("View Layer.Combined.R", red)], &attributes)
    };
    let [a, b, c] = [("a.exr", left), ("b.exr", right), ("c.exr", left)].map(|(name, red)| of(name, red));
    let out = folder.0.join("out.exr");
    let said = merge(&[a.clone(), b.clone()], &out, u64::MAX).unwrap_err().to_string();
    assert!(said.contains("b.exr: it is the view 'right', and") && said.contains("a.exr is the view 'left'"), "{said}");
    // Pixels that are of no view, as a program may have changed them, say nothing.
    assert!(merge(&[of("d.exr", [3.0, 1.0]), b.clone()], &out, u64::MAX).is_ok());
    assert!(merge(&[a, c], &out, u64::MAX).is_ok());
    let said = merge(&[out.clone(), b], &folder.0.join("more.exr"), u64::MAX).unwrap_err().to_string();
    assert!(said.contains("is the view 'left'"), "{said}");
}

/// A header may claim any number of pixels: a file of another size is refused before it is read.
#[test]
fn pictures_that_do_not_fit_are_refused() {
    let folder = Folder::new("large");
    let files = ["a.exr", "b.exr"].map(|name| folder.picture(name, &[("R", [1.0, 2.0])], &[("petzval/samples", "4")]));
    // Of two pixels and a channel each.
    let out = folder.0.join("out.exr");
    assert!(merge(&files, &out, 16).is_ok());
    let said = merge(&files, &out, 15).unwrap_err().to_string();
    assert!(said.contains("b.exr: its 2 x 1 pixels need"), "{said}");
}

/// Numbers of samples that are none.
#[test]
fn counts_that_are_no_counts_are_refused() {
    let folder = Folder::new("counts");
    for bad in ["NaN", "-1", "inf", "1e300"] {
        let files = [("a.exr", "4"), ("b.exr", bad)]
            .map(|(name, n)| folder.picture(name, &[("R", [1.0; 2])], &[("petzval/samples", n)]));
        let said = merge(&files, &folder.0.join("out.exr"), u64::MAX).unwrap_err().to_string();
        assert!(said.contains("b.exr: it does not say how many samples"), "{bad}: {said}");
    }
}
