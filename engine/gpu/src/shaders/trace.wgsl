// SPDX-License-Identifier: GPL-3.0-or-later
// Traces the rays of a buffer, each in its own place.

@compute @workgroup_size(GROUP)
fn trace(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.x + id.y * (groups.x * GROUP);
    if (i >= job.rays) {
        return;
    }
    let ray = rays[i];
    let flight = trace_lens(vec3<real>(ray.x, ray.y, ray.z), vec3<real>(ray.dx, ray.dy, ray.dz), ray.word);
    let p = flight.point;
    let d = flight.direction;
    rays[i] = Ray(p.x, p.y, p.z, d.x, d.y, d.z, flight.fate, 0u);
}
