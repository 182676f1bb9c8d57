// Lines on the surface, over whatever it shows. Triangles are drawn without a vertex buffer: each corner looks up its
// wedge, and so knows which corner it is.
// Andreas Bærentzen et al. Single-pass wireframe rendering. SIGGRAPH 2006 sketches.

struct Overlay {
    // Linear RGB, and 1 if such lines are drawn.
    wireframe: vec4f,
    seams: vec4f,
    // Of the lines, pixels of the target.
    width: f32,
    _pad0: f32,
    _pad1: f32,
    _pad2: f32,
}

@group(3) @binding(0) var<storage, read> wedges: array<Wedge>;
@group(3) @binding(1) var<storage, read> indices: array<u32>;
// For each triangle bit k is set if the texture is cut along the edge opposite to corner k.
@group(3) @binding(2) var<storage, read> cuts: array<u32>;
@group(3) @binding(3) var<uniform> overlay: Overlay;

struct Line {
    @builtin(position) @invariant clip: vec4f,
    // Distances from the edges opposite to the corners, as shares of the heights.
    @location(0) edges: vec3f,
    @location(1) @interpolate(flat, either) cut: u32,
}

@vertex
fn vs_overlay(@builtin(vertex_index) i: u32) -> Line {
    let position = drawn_position(wedges[indices[i]]);
    var out: Line;
    out.clip = frame.clip_from_world * vec4f(position, 1.0);
    out.edges = vec3f(f32(i % 3u == 0u), f32(i % 3u == 1u), f32(i % 3u == 2u));
    out.cut = cuts[i / 3u];
    return out;
}

/// How much of a pixel the nearest line covers, a smooth ramp of one pixel at its border; on each side of the edge
/// lies half of the line.
fn coverage(pixels: f32) -> f32 {
    return clamp(0.5 * overlay.width + 0.5 - pixels, 0.0, 1.0);
}

@fragment
fn fs_overlay(in: Line) -> @location(0) vec4f {
    // A block of pixels that the triangle does not fill is extrapolated.
    let dx = dpdx(in.edges);
    let dy = dpdy(in.edges);
    let pixels = in.edges * inverseSqrt(max(dx * dx + dy * dy, vec3f(1e-30)));
    let cut = vec3f(f32(in.cut & 1u), f32((in.cut >> 1u) & 1u), f32((in.cut >> 2u) & 1u));
    let nearest = min(pixels.x, min(pixels.y, pixels.z));
    // Where there is no cut it is far away.
    let seams = pixels + (1.0 - cut) * 1e6;
    let seam = overlay.seams.a * coverage(min(seams.x, min(seams.y, seams.z)));
    let wire = overlay.wireframe.a * coverage(nearest);
    // Seams lie over wires.
    let alpha = seam + wire * (1.0 - seam);
    if alpha == 0.0 {
        discard;
    }
    let colour = overlay.seams.rgb * seam + overlay.wireframe.rgb * wire * (1.0 - seam);
    return vec4f(colour / alpha, alpha);
}
