//! No NaN leaves the tracer.

#[allow(unreachable_pub, clippy::module_inception)]
mod flood;

#[test]
fn ten_million_rays_end_as_they_should() {
    let flood = flood::flood(10_000_000);
    // A quarter of them pass: the rest would prove little.
    assert!(flood.passed > flood.rays / 10 && flood.lenses > 40, "{} of {}", flood.passed, flood.rays);
}
