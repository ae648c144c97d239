"""JAX is configured once, without taking anything from the user."""

import subprocess
import sys

CODE = """
import os
os.environ["XLA_FLAGS"] = "--xla_cpu_enable_fast_math=false"
{before}
from ident import runtime
runtime.configure()
runtime.configure()
import jax
print(os.environ["XLA_FLAGS"])
print(jax.numpy.zeros(1).dtype, runtime.cache_folder())
"""


def run(before: str = "", **environment: str) -> subprocess.CompletedProcess[str]:
    import os

    code = CODE.format(before=before)
    return subprocess.run(
        [sys.executable, "-W", "always", "-c", code], capture_output=True, text=True, env={**os.environ, **environment}
    )


def test_the_flag_is_appended_once_and_numbers_are_double():
    out = run(IDENT_CACHE="off").stdout.split("\n")
    assert out[0].startswith("--xla_cpu_enable_fast_math=false ")
    assert out[0].count("xla_cpu_small_while_loop_byte_threshold") == 1
    assert out[1] == "float64 None"


def test_the_cache_goes_where_the_user_says(tmp_path):
    assert str(tmp_path) in run(IDENT_CACHE=str(tmp_path)).stdout


def test_a_backend_that_runs_already_is_warned_about():
    done = run("import jax; jax.numpy.zeros(1).block_until_ready()", IDENT_CACHE="off")
    assert "JAX was already running when ident was imported" in done.stderr
    assert "float64" in done.stdout


def test_a_check_and_a_new_campaign_need_no_jax():
    code = "import sys, ident.cli.new, ident.report.check, ident.campaign.propose; print('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "False\n"
