"""What `planish bake --layout unwrap` says in a build without the feature; tests of the feature itself are in Rust."""

import subprocess

from conftest import REPO


def test_a_build_without_it_says_how_to_get_it(tmp_path):
    command = [REPO / "target/release/planish", "bake", REPO / "data/duck_noisy.obj", "-o", tmp_path / "out"]
    run = subprocess.run([*command, "--layout", "unwrap"], capture_output=True, text=True)
    assert run.returncode == 2 and "--features unwrap" in run.stderr, run.stderr
    assert not (tmp_path / "out").exists()
