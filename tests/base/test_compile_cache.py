"""A damaged file of the compile cache, or a full disk, costs the time to compile, and one line."""

import importlib.util
import logging
import pickle
import re
import subprocess
import sys
from pathlib import Path

import pytest
from numba import __version__
from own_process import RUN, ran

from cycloid_mj.base import compile_cache

resource = pytest.importorskip("resource", reason="limits of processes are of POSIX alone")

CODE = """
from numba import types
from cycloid_mj.base.compiling import cfunc, njit

@njit(cache=True)
def twice(x):
    return 2 * x

@cfunc(types.int64(types.int64), cache=True)
def thrice(x):
    return 3 * x
"""

GONE = b"cno_such_module\nGone\n."

DAMAGES = {
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "short": lambda content: content[:5],
}


@pytest.fixture
def kernels(tmp_path, monkeypatch, caplog):
    """Load two kernels as a process does that has just started; how often each was compiled, and what was said."""
    (tmp_path / "kernels.py").write_text(CODE)
    monkeypatch.setattr(compile_cache, "cache_folder", lambda: tmp_path)
    caplog.set_level(logging.INFO, logger="cycloid_mj")

    def used():
        monkeypatch.setattr(compile_cache, "_logged_topics", set())
        caplog.clear()
        spec = importlib.util.spec_from_file_location("kernels", tmp_path / "kernels.py")
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "kernels", module)
        spec.loader.exec_module(module)
        assert (module.twice(4), module.thrice.ctypes(5)) == (8, 15)
        loaded = sum(module.twice.stats.cache_hits.values()), module.thrice.cache_hits
        return loaded, [record.getMessage() for record in caplog.records]

    return used


def kept(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.suffix in (".nbi", ".nbc"))


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_cache_file_is_skipped_reported_once_and_replaced(damage, kernels, tmp_path):
    assert kernels() == ((0, 0), [])
    assert kernels() == ((1, 1), [])
    files = kept(tmp_path)
    assert len(files) == 4
    for path in files:
        path.write_bytes(DAMAGES[damage](path.read_bytes()))
    hits, said = kernels()
    assert hits == (0, 0)
    assert said == [f"the compile cache in {tmp_path} is damaged: compiling again, which takes some seconds"]
    assert kernels() == ((1, 1), [])


def test_only_what_is_damaged_is_compiled_anew(kernels, tmp_path):
    kernels()
    data = next(path for path in kept(tmp_path) if "twice" in path.name and path.suffix == ".nbc")
    data.write_bytes(b"")
    hits, said = kernels()
    assert (hits, len(said)) == ((0, 1), 1)


def test_a_cache_file_that_numba_cannot_rebuild_is_skipped(kernels, tmp_path):
    """The pickle of other data, and an index of types that are gone."""
    for suffix, content in ((".nbc", pickle.dumps(("nonsense",))), (".nbi", pickle.dumps(__version__) + GONE)):
        kernels()
        for path in kept(tmp_path):
            if path.suffix == suffix:
                path.write_bytes(content)
        hits, said = kernels()
        assert (hits, len(said)) == ((0, 0), 1)
        assert kernels() == ((1, 1), [])


def test_another_folder_is_used_when_any_source_of_compiled_code_changes(tmp_path, monkeypatch):
    source = tmp_path / "package" / "reducer" / "impact.py"
    source.parent.mkdir(parents=True)
    monkeypatch.setattr(compile_cache, "PACKAGE", tmp_path / "package")
    monkeypatch.setattr(compile_cache.config, "CACHE_DIR", str(tmp_path / "cache"))
    folders = []
    for number in (1, 1, 2, 3, 4):
        source.write_text(f"number = {number}\n")
        folders.append(compile_cache.cache_folder.__wrapped__())
    assert folders[0] == folders[1]
    assert len(set(folders)) == 4
    assert {path.name for path in (tmp_path / "cache").iterdir()} == {path.name for path in folders[2:]}


def test_the_folder_depends_on_every_file_with_compiled_functions() -> None:
    """Except three whose kernels no other file calls: numba compares their own file."""
    package = compile_cache.PACKAGE
    files = {
        path for path in package.rglob("*.py") if re.search(r"^@(compiling\.)?njit\b", path.read_text("utf-8"), re.M)
    }
    listed = {path for pattern in compile_cache.SOURCES for path in package.glob(pattern)}
    assert {path.relative_to(package).as_posix() for path in files - listed} == {
        "bench/overlay.py",
        "statics/load_sharing.py",
        "statics/locked.py",
    }


def test_nothing_is_cached_without_a_home_or_a_writable_folder(tmp_path, monkeypatch):
    (tmp_path / "__pycache__").write_text("")
    monkeypatch.setattr(compile_cache, "PACKAGE", tmp_path)
    monkeypatch.setattr(compile_cache.config, "CACHE_DIR", "")
    monkeypatch.delenv("HOME")
    monkeypatch.setitem(sys.modules, "pwd", None)
    assert compile_cache.cache_folder.__wrapped__() is None


def test_a_full_disk_is_reported_once_and_does_not_stop_the_run(kernels, tmp_path):
    limit, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, most))
    try:
        hits, said = kernels()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
    assert hits == (0, 0)
    assert len(said) == 1
    assert "cannot be stored" in said[0]
    assert "File too large" in said[0]
    assert kept(tmp_path) == []


def test_a_folder_with_the_name_of_a_cache_file_is_skipped(kernels, tmp_path):
    kernels()
    for path in kept(tmp_path):
        path.unlink()
        path.mkdir()
    hits, said = kernels()
    assert hits == (0, 0)
    assert len(said) == 2


@pytest.mark.slow
def test_a_damaged_cache_is_reported_in_one_line(tmp_path):
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    first = ran(tmp_path, *RUN, **cache)
    assert first.returncode == 0, first.stderr
    files = kept(tmp_path / "cache")
    assert files
    for path, damage in zip(files, [*DAMAGES.values()] * len(files), strict=False):
        path.write_bytes(damage(path.read_bytes()))
    second, third = (ran(tmp_path, *RUN, "--force", **cache) for _ in range(2))
    assert (second.returncode, third.returncode) == (0, 0), second.stderr
    said = [line for line in second.stderr.splitlines() if "compil" in line]
    assert len(said) == 1, said
    assert "is damaged" in said[0]
    assert "compil" not in third.stderr


@pytest.mark.slow
def test_statics_does_not_import_the_linear_algebra_of_scipy() -> None:
    """numba imports it for compiled functions that multiply matrices, and only then."""
    code = (
        "import sys, numba, numpy as np\n"
        "import cycloid_mj as cm\n"
        "cm.statics('pin')\n"
        "assert 'scipy.linalg' not in sys.modules\n"
        "assert numba.njit(lambda a: a @ a)(2.0 * np.eye(2))[1, 1] == 4.0\n"
        "assert 'scipy.linalg' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)
