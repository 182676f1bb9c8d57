// From the samples in linear light to the pixels of the view.

struct Resolve {
    // Samples along a side of a pixel.
    supersampling: u32,
    // 1 if the view does not encode sRGB by itself.
    encode: u32,
    _pad0: u32,
    _pad1: u32,
}

@group(0) @binding(0) var samples: texture_2d<f32>;
@group(0) @binding(1) var<uniform> resolve: Resolve;

@fragment
fn fs_resolve(in: Screen) -> @location(0) vec4f {
    let n = i32(resolve.supersampling);
    let first = vec2i(in.clip.xy) * n;
    var sum = vec3f(0.0);
    for (var y = 0; y < n; y++) {
        for (var x = 0; x < n; x++) {
            sum += textureLoad(samples, first + vec2i(x, y), 0).rgb;
        }
    }
    let mean = sum / f32(n * n);
    if resolve.encode == 1u {
        return vec4f(srgb_from_linear(mean), 1.0);
    }
    return vec4f(mean, 1.0);
}
