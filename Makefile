# What a change must pass, one word each: make format, make type, make imports, make test, make docs.
# They run what is on the path: activate the environment first (pip install -e '.[test,dev]').
.PHONY: all format check type imports test docs mutants

all: check type imports test

format:
	ruff check --fix
	ruff format

check:
	ruff check
	ruff format --check

type:
	mypy

imports:
	lint-imports

test:
	python -m pytest

docs:
	python scripts/fill_tables.py --check
	python -m pytest -q tests/pages

# How much of the code the tests watch: make mutants where=dressing_sim/episode
where ?= dressing_sim/learning
mutants:
	python scripts/mutants.py $(where)
