"""Work of the Python package: progress, Ctrl-C, threads, forks, and many meshes on several workers."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import planish as package
from conftest import reference_meshes
from packaged import command, sphere


def test_progress_is_told_and_stops_the_work():
    vertices, faces = sphere(5)
    told = []
    package.denoise(vertices, faces, "taubin", iterations=2000, progress=lambda stage, fraction: told.append((stage, fraction)))
    assert {stage for stage, _ in told} & {"denoising", "connecting"}
    assert all(0 <= fraction <= 1 for _, fraction in told)
    with pytest.raises(package.Interrupted):
        package.denoise(vertices, faces, "taubin", iterations=2000, progress=lambda stage, fraction: False)

    def fails(stage, fraction):
        raise KeyError(stage)

    with pytest.raises(KeyError):
        package.denoise(vertices, faces, "taubin", iterations=2000, progress=fails)


def test_ctrl_c_stops_the_work():
    vertices, faces = sphere(5)
    # A process that was started in the background ignores the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    begun = threading.Event()
    thread = threading.Thread(target=lambda: begun.wait(60) and os.kill(os.getpid(), signal.SIGINT))
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        begun.set()
        package.denoise(vertices, faces, "taubin", iterations=100_000)
    thread.join()
    signal.signal(signal.SIGINT, before)


def test_other_threads_run_meanwhile():
    """Each of two calls waits in its progress for the other one, so that neither ends unless they work at the same time."""
    vertices, faces = sphere(5)
    both = threading.Barrier(2, timeout=60)
    results = [None, None]

    def work(i):
        waited = []

        def progress(stage, fraction):
            if not waited:
                waited.append(both.wait())

        results[i] = package.denoise(vertices, faces, "taubin", iterations=200, progress=progress).vertices

    workers = [threading.Thread(target=work, args=[i]) for i in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert np.array_equal(*results)


def test_the_interpreter_is_free_while_a_call_works():
    """Another thread ends a call that would go on for hours, and could not if the call held the interpreter."""
    vertices, faces = sphere(5)
    begun, stop = threading.Event(), threading.Event()
    thread = threading.Thread(target=lambda: begun.wait(60) and stop.set())
    thread.start()

    def progress(stage, fraction):
        begun.set()
        return not stop.is_set()

    with pytest.raises(package.Interrupted):
        package.denoise(vertices, faces, "taubin", iterations=100_000, progress=progress)
    thread.join()


def test_a_forked_process_can_work_as_well():
    script = (
        "import os, planish, numpy as np\n"
        "v = np.random.default_rng(1).random((50, 3)); f = np.arange(48).reshape(-1, 3)\n"
        "planish.denoise(v, f)\n"
        "pid = os.fork()\n"
        "if pid == 0:\n"
        "    planish.denoise(v, f); os._exit(7)\n"
        "print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.stdout == "7\n", done.stderr




def test_any_number_of_workers_gives_the_files_of_the_command_line(planish, tmp_path):
    import distributed
    from planish import dask

    paths = [path for path in reference_meshes() if path.stem in ("torus", "two_scales", "noisy_grid")]
    bad = tmp_path / "bad.obj"
    bad.write_text("v 0 0 x\n")
    for workers in (1, 2):
        results = dask.denoise_files([*paths, bad], tmp_path / str(workers), "taubin", workers=workers)
        assert [result["ok"] for result in results] == [True, True, True, False]
        assert "line 1" in results[3]["error"]
    # A client of the caller's own.
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster, distributed.Client(cluster) as client:
        results = dask.bake_files(paths, tmp_path / "maps", "taubin", client=client, size=64)
    assert [Path(result["output"]).name for result in results] == [f"{path.stem}-planish" for path in paths]
    for path in paths:
        command(planish, "denoise", path, "-o", tmp_path / "one.obj", "--method", "taubin")
        for workers in ("1", "2"):
            assert (tmp_path / workers / path.name).read_bytes() == (tmp_path / "one.obj").read_bytes()
        folder = tmp_path / "maps" / f"{path.stem}-planish"
        command(planish, "bake", path, "-o", tmp_path / "maps" / "one", "--method", "taubin", "--size", "64")
        for file in folder.iterdir():
            assert file.read_bytes() == (tmp_path / "maps" / "one" / file.name).read_bytes()
    with pytest.raises(package.InputError, match="would have the same result"):
        dask.denoise_files([paths[0], tmp_path / paths[0].name], tmp_path)


def test_every_method_gives_the_same_bytes_everywhere(planish, tmp_path):
    """The command line, the package, a batch, and Dask with 1, 2 and 4 workers."""
    import distributed
    from planish import dask

    paths = [path for path in reference_meshes() if path.stem in ("dented_sphere", "noisy_grid", "slivers", "torus", "two_scales")]
    assert len(paths) == 5
    expected = {}
    for method in package.methods():
        for path in paths:
            out = tmp_path / "line.obj"
            command(planish, "denoise", path, "-o", out, "--method", method)
            expected[method, path.stem] = out.read_bytes()
            package.read(path).denoise(method).write(tmp_path / "package.obj")
            assert (tmp_path / "package.obj").read_bytes() == expected[method, path.stem], (method, path.stem)
        done = subprocess.run([planish, "batch", *paths, "-o", tmp_path / "batch" / method, "--method", method], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    assert len(set(expected.values())) > 4 * len(package.methods())
    for workers in (1, 2, 4):
        with distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
            with distributed.Client(cluster) as client:
                for method in package.methods():
                    dask.denoise_files(paths, tmp_path / str(workers) / method, method, client=client)
    for (method, stem), written in expected.items():
        for place in ("batch", "1", "2", "4"):
            found = list((tmp_path / place / method).rglob(f"{stem}.obj"))
            assert [file.read_bytes() for file in found] == [written], (place, method, stem)
