"""What was computed is kept: saved, loaded, pickled and copied, with the same bytes in another process."""

import copy
import json
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest

import radgrad as rg

POINTS = np.array([[0.5, 0.5, 0.0], [0.2, 0.7, 0.0], [0.3, 0.3, 0.4]])


@pytest.fixture(scope="module")
def solved(room):
    return room.solve(error=0.01)


@pytest.fixture(scope="module")
def factors(data):
    scene = rg.Scene.read(data / "scenes/two_blocks.obj", need_materials=False)
    return scene.factors(tolerance=0.1)


@pytest.fixture(scope="module")
def report():
    return rg.verify(cases=40, families=["generic", "far"])


def elsewhere(program, *arguments):
    """What a program prints in another process."""
    run = subprocess.run([sys.executable, "-c", program, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()


def answers(solution):
    found, slopes = solution.gather(POINTS, [0, 0, 1]), solution.gradient(POINTS, [0, 0, 1])
    parts = [found.radiosity, found.estimate, found.irradiance, found.irradiance_estimate, found.face]
    parts += [slopes.radiosity, slopes.radiosity_estimate, slopes.irradiance, slopes.irradiance_estimate]
    return b"".join(part.tobytes() for part in parts)


KEPT = {
    "save": lambda of, file: (of.save(file), type(of).load(file))[1],
    "pickle": lambda of, file: pickle.loads(pickle.dumps(of)),
    "pickle in a file": lambda of, file: (file.write_bytes(pickle.dumps(of, 2)), pickle.loads(file.read_bytes()))[1],
    "deepcopy": lambda of, file: copy.deepcopy(of),
}


@pytest.mark.parametrize("how", KEPT)
def test_a_solution_is_kept(solved, tmp_path, how):
    again = KEPT[how](solved, tmp_path / "s.npz")
    assert again == solved and again.digest == solved.digest and answers(again) == answers(solved)
    assert again.summary == solved.summary and again.scene == solved.scene
    a, b = (of.certify(width=0.2, seed=3) for of in (again, solved))
    assert a == b


@pytest.mark.parametrize("how", KEPT)
def test_factors_are_kept(factors, tmp_path, how):
    again = KEPT[how](factors, tmp_path / "f.npz")
    assert again == factors and again.tobytes() == factors.tobytes() and again.unmet == factors.unmet
    assert (again.closure, again.reciprocity, again.bound) == (factors.closure, factors.reciprocity, factors.bound)


@pytest.mark.parametrize("how", KEPT)
def test_a_report_is_kept(report, tmp_path, how):
    again = KEPT[how](report, tmp_path / "r.npz")
    assert again == report and all(again.csv(of) == report.csv(of) for of in ("outcomes", "errors", "figures", "histogram"))


@pytest.mark.parametrize("marking", ["residual", "gradient", "shadows"])
def test_a_divided_room_is_kept_with_its_shadows(data, tmp_path, marking):
    scene = rg.Scene.read(data / "scenes/two_blocks.obj")
    solution = scene.solve(error=0.2, divide=marking)
    solution.save(tmp_path / "s.npz")
    again = rg.Solution.load(tmp_path / "s.npz")
    points, up = np.array([[2.0, 0.5, 0.0], [1.0, 1.0, 0.0]]), [0, 0, 1]
    assert again.digest == solution.digest and again.gather(points, up) == solution.gather(points, up)
    assert again.gradient(points, up) == solution.gradient(points, up)


def test_it_is_loaded_without_solving(solved, tmp_path, monkeypatch):
    solved.save(tmp_path / "s.npz")
    monkeypatch.setattr(rg.Solution, "_made", lambda *_: pytest.fail("it was solved again"))
    again = [rg.Solution.load(tmp_path / "s.npz"), pickle.loads(pickle.dumps(solved))]
    assert all(of.digest == solved.digest for of in again)


def test_repaired_factors_are_kept_as_they_are(room, tmp_path):
    repaired = room.factors().repaired()
    repaired.save(tmp_path / "f.npz")
    again = rg.Factors.load(tmp_path / "f.npz")
    assert again.tobytes() == repaired.tobytes() and again.moved == repaired.moved


def test_a_solution_is_answered_in_another_process_with_the_same_bytes(solved, tmp_path):
    solved.save(tmp_path / "s.npz")
    program = """if True:
        import hashlib, sys, radgrad as rg
        s = rg.Solution.load(sys.argv[1])
        points = [[0.5, 0.5, 0.0], [0.2, 0.7, 0.0], [0.3, 0.3, 0.4]]
        found, slopes = s.gather(points, [0, 0, 1]), s.gradient(points, [0, 0, 1])
        parts = [found.radiosity, found.estimate, found.irradiance, found.irradiance_estimate, found.face]
        parts += [slopes.radiosity, slopes.radiosity_estimate, slopes.irradiance, slopes.irradiance_estimate]
        print(b"".join(part.tobytes() for part in parts).hex())
    """
    assert elsewhere(program, tmp_path / "s.npz") == answers(solved).hex()


def test_factors_have_the_same_bytes_in_another_process(factors, tmp_path):
    factors.save(tmp_path / "f.npz")
    program = "import hashlib, sys, radgrad as rg; print(hashlib.sha256(rg.Factors.load(sys.argv[1]).tobytes()).hexdigest())"
    import hashlib

    assert elsewhere(program, tmp_path / "f.npz") == hashlib.sha256(factors.tobytes()).hexdigest()


def test_a_file_has_the_same_bytes_each_time(solved, tmp_path):
    for name in ("a.npz", "b.npz"):
        solved.save(tmp_path / name)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_copies_are_the_same_object(solved, factors, room):
    for of in (solved, factors, room):
        assert copy.copy(of) is of


def test_joblib_keeps_them(factors, tmp_path):
    joblib = pytest.importorskip("joblib", reason="joblib is not installed")
    joblib.dump(factors, tmp_path / "f.joblib")
    assert joblib.load(tmp_path / "f.joblib") == factors


@pytest.fixture(scope="module")
def files(solved, factors, report, tmp_path_factory):
    folder, kept = tmp_path_factory.mktemp("kept"), {}
    for name, of in (("Solution", solved), ("Factors", factors), ("AuditReport", report)):
        of.save(folder / f"{name}.npz")
        kept[name] = (folder / f"{name}.npz").read_bytes()
    return kept


@pytest.mark.parametrize("kind", ["Solution", "Factors", "AuditReport"])
def test_a_damaged_file_is_refused_and_named(files, tmp_path, kind):
    file, whole = tmp_path / "damaged.npz", files[kind]
    random = np.random.default_rng(1)
    header = whole.index(b"NUMPY")
    for trial in range(120):
        wrong = bytearray(whole)
        if trial % 4 == 0:
            wrong = wrong[: random.integers(len(wrong))]
        elif trial % 4 == 1:
            wrong[random.integers(len(wrong))] ^= int(random.integers(1, 256))
        else:
            wrong[header + random.integers(128)] ^= int(random.integers(1, 256))
        file.write_bytes(wrong)
        try:
            read = getattr(rg, kind).load(file)
        except ValueError as refusal:
            assert "damaged.npz" in str(refusal)
        else:
            # A byte of the archive that means nothing, as a time of day.
            file.write_bytes(whole)
            assert read == getattr(rg, kind).load(file)


@pytest.mark.parametrize("kind", ["Solution", "Factors", "AuditReport"])
def test_what_is_no_such_file_is_refused(files, tmp_path, kind):
    load = getattr(rg, kind).load
    with pytest.raises(OSError, match="none.npz"):
        load(tmp_path / "none.npz")
    for other in files:
        if other != kind:
            (tmp_path / "other.npz").write_bytes(files[other])
            with pytest.raises(ValueError, match="other.npz.*radgrad"):
                load(tmp_path / "other.npz")
    np.savez(tmp_path / "arrays.npz", a=np.zeros(3))
    with pytest.raises(ValueError, match="lacks"):
        load(tmp_path / "arrays.npz")
    np.savez_compressed(tmp_path / "bomb.npz", about=np.zeros(1 << 20, dtype=np.uint8), digest=np.zeros(1))
    with pytest.raises(ValueError, match="compressed"):
        load(tmp_path / "bomb.npz")
    with pytest.raises(OSError, match="budget"):
        (tmp_path / "own.npz").write_bytes(files[kind])
        load(tmp_path / "own.npz", budget=100)
    np.savez(tmp_path / "evil.npz", about=np.array([print], dtype=object), digest=np.zeros(1), scene=np.zeros(1))
    with pytest.raises(ValueError):
        load(tmp_path / "evil.npz")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes here")
def test_a_pipe_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe.npz")
    with pytest.raises(OSError, match="pipe.npz"):
        rg.Solution.load(tmp_path / "pipe.npz")


def test_a_file_that_cannot_be_written_is_as_it_was(solved, tmp_path):
    with pytest.raises(OSError, match="cannot be written"):
        solved.save(tmp_path / "none/s.npz")
    with pytest.raises(ValueError, match="ending in .npz"):
        solved.save(tmp_path / "s.txt")


@pytest.mark.parametrize("ending", ["csv", "mtx", "txt", "out", "idf"])
def test_factors_are_written_as_the_program_writes_them(factors, data, tmp_path, ending):
    factors.write(tmp_path / f"ours.{ending}")
    command = [sys.executable, "-m", "radgrad._program", "factors", str(data / "scenes/two_blocks.obj"), "--tolerance", "0.1"]
    # The same effort and the same estimates as Scene.factors asks for.
    command += ["--cells", "40000", "--out", str(tmp_path / f"its.{ending}")]
    subprocess.run(command, check=False, capture_output=True)
    ours, its = [(tmp_path / f"{of}.{ending}").read_text().splitlines() for of in ("ours", "its")]
    assert len(ours) == len(its) and ours[0].split()[:1] == its[0].split()[:1]


def test_a_table_has_what_is_open_where_that_is_asked(factors, tmp_path):
    factors.write(tmp_path / "f.csv", open=True)
    lines = (tmp_path / "f.csv").read_text().splitlines()
    assert len(lines) == 1 + factors.data.size + len(factors._core.faces)
    with pytest.raises(OSError, match="csv"):
        factors.write(tmp_path / "f.mtx", open=True)
    with pytest.raises(OSError, match="ending in"):
        factors.write(tmp_path / "f.xls")


def test_a_mutated_block_of_factors_is_refused_or_whole(factors):
    from radgrad import _radgrad

    whole = factors._pairs()
    random = np.random.default_rng(7)
    for _ in range(300):
        wrong = bytearray(whole)
        for _ in range(random.integers(1, 4)):
            wrong[random.integers(len(wrong))] = int(random.integers(256))
        try:
            block = _radgrad.FactorBlock.from_bytes(bytes(wrong))
            core = factors.scene._core.join(factors._settings, [block])
        except ValueError:
            continue
        _, _, values = core.csr()
        lower, upper, _ = core.brackets()
        assert np.all(np.isfinite(values)) and np.all(lower <= values) and np.all(values <= upper) and np.all(lower >= 0)


def test_the_description_is_json(solved, tmp_path):
    solved.save(tmp_path / "s.npz")
    about = json.loads(np.load(tmp_path / "s.npz")["about"].tobytes())
    assert about["kind"] == "Solution" and about["request"]["error"] == 0.01
