"""The WGSL on a GPU, or on a driver that computes like one: heights and positions are those of `planish apply`."""

import os

import numpy as np
import pytest

from baked import DUCK, SPOT
from clients import figures, missing, snippet
from conftest import REPO

# Of the range: the same formula in single precision, where the driver may fuse products with sums.
EXACT = 1e-6
INPUTS = """
struct Vertex { position: vec3f, normal: vec3f, uv: vec2f }
@group(0) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(1) var<storage, read_write> results: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if i < arrayLength(&vertices) {
        let v = vertices[i];
        results[i] = vec4f(PLACE, HEIGHT);
    }
}
"""
VERTEX = np.dtype(
    {"names": ["position", "normal", "uv"], "formats": ["3f4", "3f4", "2f4"], "offsets": [0, 16, 32], "itemsize": 48}
)


@pytest.fixture(scope="module")
def device():
    """A software driver where there is one: its results do not hang on the machine."""
    os.environ.setdefault("XDG_RUNTIME_DIR", "/tmp")
    import wgpu

    adapters = [a for a in wgpu.gpu.enumerate_adapters_sync() if a.info["backend_type"] == "Vulkan"]
    if not adapters:
        missing("there is no Vulkan driver")
    return min(adapters, key=lambda adapter: adapter.info["adapter_type"] != "CPU").request_device_sync()


def computed(device, code, vertices, texels, parameters):
    """What a compute shader makes of each vertex, n x 4."""
    import wgpu

    module = device.create_shader_module(code=code)
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "main"})
    if texels.ndim == 3:
        texels = np.concatenate([texels, np.ones_like(texels[..., :1])], axis=2)
    height, width, channels = (*texels.shape, 1)[:3]
    size = (width, height, 1)
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.create_texture(size=size, format="r32float" if channels == 1 else "rgba32float", usage=usage)
    layout = {"bytes_per_row": 4 * channels * width, "rows_per_image": height}
    device.queue.write_texture({"texture": texture}, np.ascontiguousarray(texels, dtype="f4"), layout, size)

    def buffer(data, usage):
        return {"buffer": device.create_buffer_with_data(data=data, usage=usage)}

    results = device.create_buffer(size=16 * len(vertices), usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    groups = [
        [buffer(vertices.tobytes(), wgpu.BufferUsage.STORAGE), {"buffer": results}],
        [texture.create_view(), buffer(np.array(parameters, dtype="f4"), wgpu.BufferUsage.UNIFORM)],
    ]
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    for index, resources in enumerate(groups):
        entries = [{"binding": binding, "resource": resource} for binding, resource in enumerate(resources)]
        compute.set_bind_group(
            index, device.create_bind_group(layout=pipeline.get_bind_group_layout(index), entries=entries)
        )
    compute.dispatch_workgroups(-(-len(vertices) // 64))
    compute.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(results), dtype="<f4").reshape(-1, 4).astype(float)


def displaced(device, case, code, place, height):
    """Displaced positions (n x 3) and heights (n) by WGSL."""
    vertices = np.zeros(len(case.positions), dtype=VERTEX)
    vertices["position"] = case.positions
    vertices["normal"] = case.normals
    vertices["uv"] = case.sampled_at
    code += INPUTS.replace("PLACE", place).replace("HEIGHT", height)
    entry = case.map
    parameters = [entry["bias"], entry["scale"], entry["lambda"], 0]
    results = computed(device, code, vertices, case.image, parameters)
    return results[:, :3], results[:, 3]


CASES = [
    pytest.param(DUCK, "uvs", ("--bits", "16"), id="duck-uv-16"),
    pytest.param(SPOT, "uvs", ("--bits", "32"), id="spot-uv-32"),
    pytest.param(DUCK, "uvs", ("--layout", "vertex", "--bits", "32"), id="duck-vertex-32"),
    pytest.param(DUCK, "folded", ("--layout", "auto", "--bits", "32"), id="folded-private-32"),
]


@pytest.mark.parametrize("mesh, uvs, options", CASES)
def test_displace(mesh, uvs, options, device, baked, request):
    """shaders/displace.wgsl"""
    case = baked(mesh, uvs, *options)
    code = (REPO / "shaders" / "displace.wgsl").read_text(encoding="utf-8")
    places, heights = displaced(device, case, code, "displaced_position(v.position, v.normal, height_at(v.uv))", "height_at(v.uv)")
    apart = case.errors(places, case.places)
    off = np.abs(heights - case.bilinear) / case.range
    figures(f"wgsl-{request.node.callspec.id}", positions=apart, heights=off)
    assert off.max() <= EXACT
    # A fused sum may round the position the other way.
    assert apart.max() <= EXACT + case.ulp / case.range


# What shaders/displace.wgsl is asked for, and the layout that it suits.
VECTORS = [
    pytest.param("offset_from_texel(texel_at(v.uv))", "uv", id="uv"),
    pytest.param("offset_from_texel(texel_of(i))", "vertex", id="vertex"),
]


@pytest.mark.parametrize("offset, layout", VECTORS)
def test_vectors(offset, layout, device, baked, request):
    """shaders/displace.wgsl with offsets in the axes of the model."""
    case = baked(DUCK, "uvs", "--map", "vector", "--bits", "32", "--layout", layout)
    code = (REPO / "shaders" / "displace.wgsl").read_text(encoding="utf-8")
    axes = "mat3x3f(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)"
    places, _ = displaced(device, case, code, f"displaced_by_vector(v.position, {axes}, {offset})", "0.0")
    apart = case.errors(places, case.places)
    figures(f"wgsl-{request.node.callspec.id}", positions=apart)
    assert apart.max() <= EXACT + case.ulp / case.range


@pytest.mark.parametrize("bits", ["8", "16", "32"])
def test_vertex_snippet(bits, device, baked):
    """The one of docs/clients.md, which needs no texture coordinates."""
    case = baked(DUCK, "bare", "--layout", "vertex", "--bits", bits)
    places, _ = displaced(device, case, snippet("wgsl-vertex"), "displaced(v.position, v.normal, i)", "v.uv.x")
    apart = case.errors(places, case.places)
    figures(f"wgsl-snippet-{bits}", positions=apart)
    assert apart.max() <= EXACT + case.ulp / case.range
