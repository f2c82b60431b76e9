# What a change must pass, one word each: make format, make type, make imports, make test, make docs,
# make site.
# They run what is on the path: activate the environment first (pip install -e '.[test,dev]').
.PHONY: all format check type imports test docs site links spelling release mutants

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

# The pages as HTML, in build/site, with the references to Python and to the commands; a warning is an
# error. Open build/site/index.html: it needs no server and no network. (pip install -e '.[docs]')
site:
	python -m sphinx -W --keep-going -b html -d build/site-cache docs build/site

# Asks every address outside whether it is there; needs a network, so no test does.
links:
	python -m sphinx -b linkcheck -d build/site-cache docs build/links

spelling:
	codespell

# Whether what is here can be released: versions, changelog, packages, a fresh installation.
release:
	python scripts/check_release.py

# How much of the code the tests watch: make mutants where=dressing_sim/episode
where ?= dressing_sim/learning
mutants:
	python scripts/mutants.py $(where)
