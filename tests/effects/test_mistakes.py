"""Mistakes in an effect file that Python accepts: each is answered before a fit, with class, method and advice."""

from __future__ import annotations

import pytest

from ident.cli.starter import EFFECT
from ident.effects.probe import check_runs
from ident.effects.registry import built_in, registry
from ident.effects.written import check_written
from tests.effects.test_user_files import answer, line_of, write

SPRING = '''
"""A spring."""
import jax.numpy as jnp
import math
import numpy as np
from ident.effects import AbstractEffect, amplitude, shape


class Spring(AbstractEffect):
    """Force −k z."""

    name = "my-spring"
    k = amplitude("N/m", "stiffness")
    a = shape("m", "length", grid=(0.2, 1.0), scale="displacement")

    def force(self, state, drive, t):
        return -self.k * state.z
'''
LAW = "-self.k * state.z"
MEMORY = """
    hidden_units = ("m",)

    def state0(self):
        return (0.0,)

    def rate(self, state, drive, t):
        return (state.v,)
"""


@pytest.mark.parametrize("name", sorted(built_in()))
def test_every_effect_of_the_library_passes(name):
    check_written(built_in()[name])
    check_runs(built_in()[name], built_in())


@pytest.mark.parametrize(
    "law",
    [
        "-self.k * jnp.abs(state.z) * state.z / self.a",
        "-self.k * self.a * jnp.expm1(state.z / self.a)",
        "-self.k * jnp.maximum(state.z - self.a, 0.0) ** 1.5 / self.a**0.5",
        "-self.k * jnp.where(state.z > 0, jnp.sqrt(state.z * self.a), 0.0)",  # slopes go forward: none is missed
        "-self.k * jnp.sign(state.z) * self.a",
    ],
)
def test_laws_that_bend_or_jump_pass(tmp_path, law):
    assert "my-spring" in registry([write(tmp_path, SPRING.replace(LAW, law))])


def test_an_effect_with_a_memory_a_helper_and_a_start_passes(tmp_path):
    text = SPRING.replace(LAW, "self.forces(state.hidden[0])") + MEMORY
    text += "\n    def forces(self, x):\n        return -self.k * x\n"
    assert "my-spring" in registry([write(tmp_path, text)])
    assert "gas-drag" in registry([write(tmp_path, EFFECT)])


@pytest.mark.parametrize(
    ("law", "says"),
    [
        ("-self.k * state.z * jnp.abs(state.z) / jnp.abs(state.z)", "the value is nan where z = v = 0"),
        ("-self.k * jnp.sqrt(state.z**2)", "the slope by z is nan where z = v = 0"),
        ("-self.k * self.a * jnp.sqrt(jnp.abs(state.z / self.a))", "the slope by z is -inf where z = v = 0"),
        ("-self.k * self.a * jnp.log(state.z / self.a)", "where z = v = 0"),
        ("-self.k * self.a * jnp.log(1 + 1e6 * state.z)", "the value is nan where z = -1.2e-05 m"),
        ("self.k * jnp.tanh(state.z / self.k)", "where z = v = 0 and k = 0"),
    ],
)
def test_a_law_that_is_no_number_somewhere_is_named_with_the_point(tmp_path, law, says):
    error = answer(tmp_path, SPRING.replace(LAW, law))
    assert error.what.startswith("Spring.force: ") and says in error.what
    assert error.where.endswith(f"my_effect.py, line {line_of(SPRING, 'def force')}")
    assert "jnp.where on the argument too" in error.do


def test_a_rate_that_is_no_number_at_rest_is_named(tmp_path):
    text = SPRING.replace(LAW, "-self.k * state.hidden[0]") + MEMORY.replace("(state.v,)", "(state.v**2 / state.v,)")
    assert answer(tmp_path, text).what.startswith("Spring.rate: the value is nan where z = v = 0")


@pytest.mark.parametrize("misspelt", ["forces", "Force", "forc", "_force"])
def test_a_misspelt_law_is_told_the_right_name(tmp_path, misspelt):
    text = SPRING.replace("def force", f"def {misspelt}")
    error = answer(tmp_path, text)
    assert f"defines {misspelt}" in error.what and "none of force, drive, sensor" in error.what
    assert error.do == "did you mean force?"
    assert error.where.endswith(f"line {line_of(text, f'def {misspelt}')}")


def test_a_misspelt_method_beside_a_right_one_is_told(tmp_path):
    text = SPRING + MEMORY.replace("def rate", "def rates")
    assert answer(tmp_path, text).do == "did you mean rate?"


def test_an_effect_without_a_law_or_with_a_memory_that_never_moves_is_told(tmp_path):
    nothing = answer(tmp_path, SPRING.replace("def force", "def elongation"))
    assert "none of force, drive, sensor" in nothing.what and "def force(self, state, drive, t)" in nothing.do
    still = answer(tmp_path, SPRING + MEMORY[: MEMORY.index("    def rate")])
    assert "never change" in still.what


@pytest.mark.parametrize(
    ("part", "instead", "says", "do"),
    [
        (LAW, "-self.k * (state.z if state.z > 0 else 0.0)", "Python asks", "jnp.where(condition, a, b)"),
        (LAW, "-self.k * max(state.z, 0.0)", "Python asks", "jnp.maximum"),
        (LAW, "-self.k * np.sin(state.z / self.a)", "numpy or math", "import jax.numpy as jnp"),
        (LAW, "-self.k * math.exp(state.z / self.a)", "numpy or math", "import jax.numpy as jnp"),
        (LAW, "-self.k * state.x", "no attribute 'x'", "state.z, state.v, state.hidden"),
        (LAW, "-self.kk * state.z", "no attribute 'kk'", "self.k, self.a"),
        ('scale="displacement"', 'scale="displ"', "'displ'", '"displacement", "velocity", "voltage"'),
        ("grid=(0.2, 1.0)", "grid=()", "no values to try", "grid=(0.1, 0.3, 1.0)"),
    ],
)  # fmt: skip
def test_a_mistake_has_its_own_line_and_words_without_jax(tmp_path, part, instead, says, do):
    text = SPRING.replace(part, instead)
    error = answer(tmp_path, text)
    assert says in error.what and do in error.do
    assert error.where.endswith(f"line {line_of(text, instead)}")
    assert "racer" not in error.what


@pytest.mark.parametrize(
    ("law", "says"),
    [
        ("jnp.array([state.z, state.v])", "returns an array of the shape (2,)"),
        ("(self.k * state.z, 0.0)", "returns a tuple"),
        ("None", "returns nothing"),
    ],
)
def test_a_law_returns_one_number(tmp_path, law, says):
    error = answer(tmp_path, SPRING.replace(LAW, law))
    assert "Spring.force must return one number" in error.what and says in error.what
    assert error.where.endswith(f"line {line_of(SPRING, 'def force')}")


def test_rates_are_a_tuple(tmp_path):
    error = answer(tmp_path, SPRING + MEMORY.replace("(state.v,)", "state.v"))
    assert "Spring.rate must return a tuple" in error.what


def test_an_effect_declares_what_switches_it_off(tmp_path):
    error = answer(tmp_path, SPRING.replace('amplitude("N/m", "stiffness")', "3.0"))
    assert "declares no amplitude" in error.what
    assert error.where.endswith(f"line {line_of(SPRING, 'class Spring')}")


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('mistaken_for = ("cubic-stiffness")', "Spring.mistaken_for is no tuple of names"),
        ("alike = SAME_LOSS", "Spring.alike is no tuple of likenesses"),
        ('alike = ("same loss",)', "Spring.alike is no tuple of likenesses"),
    ],
)
def test_one_word_in_brackets_is_told_to_need_its_comma(tmp_path, line, says):
    text = SPRING.replace("    k = ", f"    {line}\n    k = ", 1)
    text = text.replace("import math\n", "import math\nfrom ident.effects.likeness import SAME_LOSS\n")
    error = answer(tmp_path, text)
    assert error.what == says and "with the comma" in error.do
    assert "my-spring" in registry([write(tmp_path, text.replace(line, 'mistaken_for = ["cubic-stiffness"]'))])


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("further_mode = 7", "Spring is a further mode with other parameters than travel, period, quality"),
        ("is_constant = True", "Spring is a constant of 2 numbers"),
        ('gains = ("travel",)', "Spring.gains names travel, which it does not have"),
    ],
)
def test_what_it_says_that_it_is_fits_its_parameters(tmp_path, line, says):
    assert answer(tmp_path, SPRING.replace("    k = ", f"    {line}\n    k = ", 1)).what == says


def test_wrong_arguments_are_told_the_right_ones(tmp_path):
    error = answer(tmp_path, SPRING.replace("force(self, state, drive, t)", "force(self, state)"))
    assert "def force(self, state, drive, t):" in error.do


def test_an_inertia_needs_its_force_its_argument_and_its_unit(tmp_path):
    whole = SPRING + "\n    def inertia(self, z):\n        return self.k * z\n"
    assert "inertia" in answer(tmp_path, whole).what  # a force is no mass
    text = SPRING.replace('amplitude("N/m"', 'amplitude("kg/m"').replace(LAW, "-self.k / 2 * state.v**2")
    good = text + "\n    def inertia(self, z):\n        return self.k * z\n"
    assert "my-spring" in registry([write(tmp_path, good)])
    alone = answer(tmp_path, good.replace("def force", "def helper").replace("self.k * z\n", "self.helper(z, 0, 0)\n"))
    assert "none of force" in alone.what
    assert (
        "does not take the arguments" in answer(tmp_path, good.replace("inertia(self, z)", "inertia(self, z, v)")).what
    )
    sensor = good.replace("def force(self, state, drive, t):\n        return -self.k / 2 * state.v**2",
                          "def sensor(self, state, drive, t):\n        return self.k * 0.0 * state.z")  # fmt: skip
    assert "an inertia and no force" in answer(tmp_path, sensor).what
