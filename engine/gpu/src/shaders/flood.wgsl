// SPDX-License-Identifier: GPL-3.0-or-later
// Makes rays from film to pupil by number, traces them, and adds up what comes out: to be timed. No ray is uploaded.

/// By workgroup: rays that got through, and the sum of what they came to, as bits of an f32.
@group(0) @binding(5) var<storage, read_write> sums: array<vec2<u32>>;

var<workgroup> counts: array<u32, GROUP>;
var<workgroup> totals: array<f32, GROUP>;

/// A number that looks unlike its argument (PCG: Jarzynski and Olano, JCGT 9-3, 2020).
fn mixed(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

/// In [−1, 1), evenly.
fn even(bits: u32) -> f32 {
    return f32(bits >> 8u) * 1.1920928955078125e-7 - 1.0;
}

@compute @workgroup_size(GROUP)
fn flood(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    var count = 0u;
    var total: f32 = 0.0;
    for (var i = 0u; i < job.rays_each; i = i + 1u) {
        let a = mixed(id.x * job.rays_each + i + job.seed);
        let b = mixed(a);
        let c = mixed(b);
        let e = mixed(c);
        let film = vec3<real>(real(job.film.x * even(a)), real(job.film.y * even(b)), real(job.film.z));
        let pupil = vec3<real>(real(job.pupil.x * even(c)), real(job.pupil.x * even(e)), real(job.film.w));
        let way = (pupil - film) * select(real(-1.0), real(1.0), job.film.w < job.film.z);
        let d = way * (1.0 / sqrt(dot(way, way)));
        // Where it crosses the plane at the first vertex on its way.
        let p = film + d * (-film.z / d.z);
        let flight = trace_lens(vec3<real>(p.x, p.y, real(0.0)), d, 0u);
        if (flight.fate == 0u) {
            count = count + 1u;
            total = total + f32(flight.point.x + flight.point.y + flight.point.z + flight.direction.x + flight.direction.y);
        }
    }
    counts[local] = count;
    totals[local] = total;
    workgroupBarrier();
    for (var half = GROUP / 2u; half > 0u; half = half / 2u) {
        if (local < half) {
            counts[local] = counts[local] + counts[local + half];
            totals[local] = totals[local] + totals[local + half];
        }
        workgroupBarrier();
    }
    if (local == 0u) {
        let before = sums[group.x];
        sums[group.x] = vec2<u32>(before.x + counts[0], bitcast<u32>(bitcast<f32>(before.y) + totals[0]));
    }
}
