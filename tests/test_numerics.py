import json
import os
import subprocess
import sys

import pytest

from dressing_sim import doctor, numerics
from dressing_sim.numerics import common_environment, common_to_children, unlike

SCRIPT = "import json; from dressing_sim.numerics import numerics; print(json.dumps(numerics()))"
VARIABLES = ("OPENBLAS_CORETYPE", "NPY_DISABLE_CPU_FEATURES", "GLIBC_TUNABLES")


def elsewhere(**environment):
    """Numerics of a process with these variables."""
    inherited = {k: v for k, v in os.environ.items() if k not in VARIABLES}
    told = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        capture_output=True,
        text=True,
        check=True,
        env=inherited | environment,
    )
    return json.loads(told.stdout)


@pytest.fixture(scope="module")
def plain():
    return elsewhere()


@pytest.mark.parametrize(
    "same",
    [
        {"OMP_NUM_THREADS": "2", "PYTHONHASHSEED": "7"},
        {"LC_ALL": "de_DE.UTF-8"},
        common_environment(),
    ],
)
def test_the_fingerprint_is_that_of_the_processor_alone(plain, same):
    assert elsewhere(**same)["fingerprint"] == plain["fingerprint"]


@pytest.mark.skipif(
    not {"avx2", "fma"} <= numerics._processor_flags(), reason="this processor has one kind only"
)
@pytest.mark.parametrize(
    ("other", "part"),
    [
        ({"OPENBLAS_CORETYPE": "Sandybridge"}, "blas"),
        ({"OPENBLAS_CORETYPE": "Prescott"}, "blas"),
        ({"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA"}, "fingerprint"),
    ],
)
def test_another_kind_of_processor_has_another_fingerprint(plain, other, part):
    found = elsewhere(**other)
    assert found["fingerprint"] != plain["fingerprint"]
    told = unlike(plain, found, "there", "here")
    assert f"{part} {plain[part]} there, {found[part]} here" in told
    assert "\n" not in told


def test_fingerprints_that_are_the_same_make_no_difference(plain):
    assert unlike(plain, {**plain, "blas": "a newer one"}, "there", "here") == ""


@pytest.mark.parametrize(
    ("flags", "expected"),
    [
        ((), set()),
        (("avx2",), set()),
        (("avx2", "fma"), {"OPENBLAS_CORETYPE"}),
        (("avx2", "fma", "avx512f"), {"OPENBLAS_CORETYPE", "NPY_DISABLE_CPU_FEATURES"}),
    ],
)
def test_what_all_processors_have_is_asked_for_where_this_one_has_it(monkeypatch, flags, expected):
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
    assert set(common_environment(frozenset(flags))) == expected


def test_what_doctor_says_does_not_hang_on_what_is_set(monkeypatch):
    # The command line has set them by then, and workers elsewhere need the same.
    wanted = numerics.common_settings()
    for name, value in wanted.items():
        monkeypatch.setenv(name, value)
    told = doctor._numerics()
    assert all(f"{name}='{value}'" in told for name, value in wanted.items())


def test_what_a_user_has_chosen_stays(monkeypatch):
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Zen")
    assert common_environment(frozenset({"avx2", "fma"})) == {}


def test_the_environment_is_for_children_only(monkeypatch):
    monkeypatch.setattr(numerics, "common_environment", lambda: {"DRESSING_SIM_TEST": "common"})
    with common_to_children():
        code = "import os; print(os.environ['DRESSING_SIM_TEST'])"
        told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        assert told.stdout.strip() == "common"
    assert "DRESSING_SIM_TEST" not in os.environ
