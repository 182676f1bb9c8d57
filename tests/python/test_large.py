"""One mesh in tiles: the bits of the whole mesh, borders, workers that die, and work that is gone on with."""

import json
import os
import signal

import distributed
import numpy as np
import pytest

import planish as package
from planish import dask


def torus(around=400, across=256, noise=0.2, seed=1):
    """A bumpy torus with noise of so many edges: positions and triangles."""
    u, v = (np.arange(n) * 2 * np.pi / n for n in (around, across))
    u, v = np.meshgrid(u, v, indexing="ij")
    radius = 0.6 + 0.03 * np.sin(5 * u) * np.cos(3 * v)
    points = np.stack([(1.5 + radius * np.cos(v)) * np.cos(u), (1.5 + radius * np.cos(v)) * np.sin(u), radius * np.sin(v)], axis=-1)
    edge = 2 * np.pi * 0.6 / across
    points = points.reshape(-1, 3) + np.random.default_rng(seed).normal(0, noise * edge, (around * across, 3))
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    at = lambda di, dj: ((i + di) % around * across + (j + dj) % across).ravel()  # noqa: E731
    faces = np.concatenate([np.stack([at(0, 0), at(1, 0), at(1, 1)], 1), np.stack([at(0, 0), at(1, 1), at(0, 1)], 1)])
    # Neighbours in space are no neighbours in the file.
    order = np.random.default_rng(seed + 1).permutation(len(points))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return points[order], place[faces]


def write_ply(path, points, faces):
    """A binary PLY with single precision and a property that planish does not know."""
    head = (
        f"ply\nformat binary_little_endian 1.0\ncomment made for a test\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
        f"property float z\nproperty uchar quality\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    vertices = np.zeros(len(points), [("p", "<f4", 3), ("q", "u1")])
    vertices["p"], vertices["q"] = points, np.arange(len(points)) % 251
    triangles = np.zeros(len(faces), [("n", "u1"), ("v", "<i4", 3)])
    triangles["n"], triangles["v"] = 3, faces
    path.write_bytes(head.encode() + vertices.tobytes() + triangles.tobytes())


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    path = tmp_path_factory.mktemp("large") / "torus.ply"
    write_ply(path, *torus())
    return path


@pytest.mark.parametrize("method", ["laplacian", "taubin", "hc", "bilateral-normals"])
def test_tiles_give_the_bits_of_the_whole_mesh(method, large, client, tmp_path):
    package.read(large).denoise(method).write(tmp_path / "whole.ply")
    report = dask.denoise_large(large, tmp_path / "tiles.ply", method, client=client, tiles=9)
    assert (tmp_path / "tiles.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes() != large.read_bytes()
    assert report["exact"] and report["borders"]["different"] == 0 and report["borders"]["vertices"] > 1000
    assert len(report["tiles"]) == 9 and sum(report["tiles"]) == report["vertices"] == 102_400
    assert max(report["tiles"]) < 1.2 * min(report["tiles"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tiles.ply", "whole.ply"]


def test_rounds_that_measure_the_whole_mesh_give_its_bits(client, tmp_path):
    """Each round of guided normals goes by the mean distance of all faces as they are then."""
    path = tmp_path / "mesh.ply"
    write_ply(path, *torus(200, 128))
    package.read(path).denoise("guided-normals", iterations=4).write(tmp_path / "whole.ply")

    def run(progress=None):
        settings = {"iterations": 4, "tiles": 4, "client": client, "progress": progress}
        return dask.denoise_large(path, tmp_path / "tiles.ply", "guided-normals", **settings)

    told = []

    def stop_in_the_third_round(stage, fraction):
        told.append((stage, fraction))
        return told.count(("measuring", 1.0)) < 4 or stage != "denoising"

    with pytest.raises(package.Interrupted):
        run(stop_in_the_third_round)
    # Rounds that are over have left their sum, and only the results of the last one.
    assert len(list((tmp_path / "tiles.ply.tiles").glob("tile-all.*"))) >= 2
    assert len(list((tmp_path / "tiles.ply.tiles").glob("tile-*.round-1"))) == 0
    report = run()
    assert (tmp_path / "tiles.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes() != path.read_bytes()
    assert report["exact"] and report["borders"]["different"] == 0 and report["halo"] < 40
    assert max(report["tiles"]) < report["vertices"] / 3


def test_limits_and_settings_hold_in_tiles(client, tmp_path):
    points, faces = torus(60, 40)
    path = tmp_path / "mesh.obj"
    package.Mesh(points, faces).write(path)
    mesh = package.read(path)
    random = np.random.default_rng(5)
    limits = {
        "fix": np.flatnonzero(random.random(len(points)) < 0.1),
        "mask": random.random(len(points)).astype("f4"),
        "direction": [0, 1, 2],
        "max_displacement": 0.05,
        "iterations": 4,
    }
    mesh.denoise("taubin", **limits).write(tmp_path / "whole.obj")
    report = dask.denoise_large(path, tmp_path / "tiles.obj", "taubin", client=client, tiles=5, **limits)
    assert (tmp_path / "tiles.obj").read_bytes() == (tmp_path / "whole.obj").read_bytes()
    assert report["method"]["iterations"] == 4 and report["halo"] == 13
    assert np.array_equal(package.read(tmp_path / "tiles.obj").vertices[limits["fix"]], points[limits["fix"]])


def test_tiles_of_auto_meet_without_a_step(client, tmp_path):
    path = tmp_path / "mesh.ply"
    write_ply(path, *torus(240, 64))
    noisy = package.read(path)
    whole = noisy.denoise()
    report = dask.denoise_large(path, tmp_path / "tiles.ply", client=client, tiles=2, halo=30)
    edge = 2 * np.pi * 0.6 / 64
    # The largest step is that of single vertices, which are outliers for one tile alone.
    assert report["borders"]["rms_jump_in_sigma"] < 0.01 < report["borders"]["gap"] / report["sigma"], report["borders"]
    assert report["sigma"] == pytest.approx(0.2 * edge, rel=0.3)
    assert not report["exact"] and len(report["choices"]) == 2
    # As good as the whole.
    found = package.read(tmp_path / "tiles.ply").vertices
    apart = np.linalg.norm(found - whole.vertices, axis=1)
    assert np.sqrt((apart**2).mean()) < 0.3 * report["sigma"], apart.max()


def test_tiles_of_map_meet_without_a_step(client, tmp_path):
    path = tmp_path / "mesh.ply"
    write_ply(path, *torus(160, 48))
    report = dask.denoise_large(path, tmp_path / "tiles.ply", "map", client=client, tiles=2, halo=20)
    sigma = 0.2 * 2 * np.pi * 0.6 / 48
    assert 0 < report["borders"]["jump"] < 0.01 * sigma, report["borders"]
    whole = package.read(path).denoise("map").vertices
    assert np.linalg.norm(package.read(tmp_path / "tiles.ply").vertices - whole, axis=1).max() < 0.1 * sigma


def test_a_worker_that_dies_is_replaced(large, tmp_path):
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            workers = list(client.run(os.getpid).values())
            killed = []

            def kill(stage, fraction):
                if stage == "denoising" and not killed:
                    killed.append(workers[0])
                    os.kill(workers[0], signal.SIGKILL)

            report = dask.denoise_large(large, tmp_path / "tiles.ply", "taubin", client=client, tiles=9, progress=kill)
            assert killed and workers[0] not in client.run(os.getpid).values()
    package.read(large).denoise("taubin").write(tmp_path / "whole.ply")
    assert (tmp_path / "tiles.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes()
    assert report["exact"]


def test_work_that_was_stopped_is_gone_on_with(large, client, tmp_path):
    def run(progress=None, **options):
        settings = {"iterations": 5, **options}
        return dask.denoise_large(large, tmp_path / "out.ply", "taubin", client=client, tiles=9, progress=progress, **settings)

    with pytest.raises(package.Interrupted, match="out.ply.tiles"):
        run(lambda stage, fraction: stage != "denoising" or fraction < 0.3)
    assert not (tmp_path / "out.ply").exists()
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "out.ply.tiles").glob("tile-*.result")}
    assert len(kept) >= 3
    with pytest.raises(package.Interrupted):
        run(lambda stage, fraction: stage != "merging")
    assert all(path.stat().st_mtime_ns == at for path, at in kept.items())
    report = run()
    assert report["tiles_kept"] == 9 and not (tmp_path / "out.ply.tiles").exists()
    package.read(large).denoise("taubin", iterations=5).write(tmp_path / "whole.ply")
    assert (tmp_path / "out.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes()


def test_results_of_other_settings_or_meshes_are_not_taken(client, tmp_path):
    path = tmp_path / "mesh.ply"
    write_ply(path, *torus(60, 40))
    told = lambda stage, fraction: stage != "merging"  # noqa: E731

    def run(progress=None, **options):
        return dask.denoise_large(path, tmp_path / "out.ply", "taubin", client=client, tiles=2, progress=progress, **options)

    with pytest.raises(package.Interrupted):
        run(told, iterations=3)
    with pytest.raises(package.Interrupted):
        run(told, iterations=4)
    write_ply(path, *torus(60, 40, seed=3))
    assert run(iterations=3)["tiles_kept"] == 0
    package.read(path).denoise("taubin", iterations=3).write(tmp_path / "whole.ply")
    assert (tmp_path / "out.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes()


def test_what_is_wrong_is_named(client, tmp_path):
    bad = tmp_path / "bad.obj"
    bad.write_text("v 0 0 0\nv 1 0 0\nv 0 x 0\nf 1 2 3\n")
    good = tmp_path / "good.obj"
    package.Mesh(*torus(8, 6)).write(good)
    stl = tmp_path / "mesh.stl"
    package.Mesh(*torus(8, 6)).write(stl)
    for path, options, message in [
        (bad, {}, "bad.obj: line 3"),
        (tmp_path / "none.obj", {}, "none.obj: No such file"),
        (stl, {}, "STL files cannot be read piece by piece"),
        (good, {"weld": 0.1}, "are not welded across tiles"),
        (good, {"tiles": 0}, "1 to 400 tiles, not 0"),
        (good, {"method": "magic"}, "there is no method `magic`"),
        (good, {"mask": [1.0]}, "`mask` has 1 weights, and the mesh has 48 vertices"),
        (good, {"fix": [48]}, "`fix` names vertex 48, and the mesh has 48"),
        (good, {"direction": [0, 0]}, "`direction` is three numbers"),
    ]:
        with pytest.raises(package.InputError, match=message):
            dask.denoise_large(path, tmp_path / "out.obj", **{"method": "laplacian", "client": client, **options})
    with pytest.raises(package.InputError, match="is an input"):
        dask.denoise_large(good, good, "laplacian", client=client)
    with pytest.raises(package.InputError, match="written as it was read"):
        dask.denoise_large(good, tmp_path / "out.ply", "laplacian", client=client)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.obj", "good.obj", "mesh.stl"]


def test_reports_are_json(client, tmp_path):
    path = tmp_path / "mesh.ply"
    write_ply(path, *torus(30, 20))
    report = dask.denoise_large(path, tmp_path / "out.ply", "map", client=client, tiles=2, halo=6)
    assert json.loads(json.dumps(report)) == report
    assert (report["halo"], report["exact"], report["method"]["name"]) == (6, False, "map")
    assert set(report["seconds"]) == {"spreading", "denoising", "merging", "writing"}
