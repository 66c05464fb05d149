"""The run-time type checker of the tests: beartype, where an int passes for a float, as mypy reads it.

pytest puts `check` around every function of mixlight that carries types (`--jaxtyping-packages` in pyproject.toml),
so each test also checks shapes and types.
"""

from beartype import BeartypeConf, beartype

check = beartype(conf=BeartypeConf(is_pep484_tower=True))
