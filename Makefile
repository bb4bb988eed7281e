# Everything happens in .venv and viewer/node_modules, which are made on first use. Needs Rust, Python 3.11 or newer, and
# Node.js 20 or newer.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
TOOLS := $(VENV)/.tools-installed
NATIVE := $(VENV)/.extension-built
PAGE := python/radiosity/viewer/bundle/index.html
PACKAGES := viewer/node_modules/.package-lock.json
PAGE_SOURCES := $(addprefix viewer/,index.html tsconfig.json vite.config.ts package-lock.json) $(shell find viewer/src -type f)
RUST_SOURCES := Cargo.toml Cargo.lock $(shell find crates -name '*.rs' -o -name Cargo.toml)
TESTED_CRATES := --workspace --exclude radiosity-python  # an extension module cannot be linked into a test program

# The same interpreter for every build, so that Rust does not rebuild what knows about Python.
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python

.PHONY: help setup viewer demo gallery test test-rust test-viewer test-python check bench validate dist lock clean

help: ## Show this list.
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-12s %s\n", $$1, $$2}'

setup: $(NATIVE) $(PAGE) ## Make .venv with pinned tools, build the extension into it, and the viewer's page.

viewer: $(PAGE) ## Build the page of the viewer.

demo: $(NATIVE) $(PAGE) ## Light the Cornell box: model, picture and table in out/.
	$(BIN)/radiosity demo

gallery: $(NATIVE) ## Remake the pictures of docs/gallery, in some ten minutes.
	$(BIN)/python docs/gallery/make.py

test: test-rust test-viewer test-python ## Run all tests: Rust, the viewer's page, Python, examples and the fast part of validation/.

test-rust: $(TOOLS)
	cargo test --locked --quiet $(TESTED_CRATES)

test-viewer: $(PACKAGES)
	npm --prefix viewer run --silent test

test-python: $(NATIVE) $(PAGE)
	$(BIN)/pytest -m "not slow" tests validation

check: $(TOOLS) $(PACKAGES) ## Check formats, lints and types.
	cargo fmt --all --check
	cargo clippy --locked --quiet --workspace --all-targets -- -D warnings
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	npm --prefix viewer run --silent check

validate: $(NATIVE) ## Run all of validation/: is it true?
	$(BIN)/pytest validation

bench: $(NATIVE) ## Time it beside other programs (see benchmarks/README.md).
	$(BIN)/python benchmarks/cornell.py

dist: $(TOOLS) $(PAGE) ## Make a source distribution and a wheel in dist/.
	$(BIN)/maturin sdist --out dist
	$(BIN)/maturin build --release --locked --out dist

lock: ## Pin the newest tools that pyproject.toml allows in requirements-dev.lock.
	@folder=$$(mktemp -d) && trap 'rm -rf "$$folder"' EXIT && $(PYTHON) -m venv "$$folder" \
	  && "$$folder/bin/pip" install --quiet --upgrade 'pip>=25.1' \
	  && "$$folder/bin/python" -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["dependencies"], sep="\n")' > "$$folder/runtime.txt" \
	  && "$$folder/bin/pip" install --quiet --group dev -r "$$folder/runtime.txt" \
	  && { echo "# Written by make lock."; "$$folder/bin/pip" freeze; } > requirements-dev.lock

clean: ## Remove everything that was built, .venv included.
	rm -rf target $(VENV) out validation/out dist .mypy_cache .pytest_cache .ruff_cache .hypothesis
	rm -rf viewer/node_modules python/radiosity/viewer/bundle
	find python -name '*.so' -delete
	find python tests validation examples -name __pycache__ -type d -prune -exec rm -rf {} +

$(TOOLS): requirements-dev.lock
	@command -v cargo > /dev/null || { echo "Rust is needed: see https://rustup.rs"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Python 3.11 or newer is needed, and $(PYTHON) is not: say make PYTHON=python3.12, or the like"; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --upgrade 'pip>=25.1'
	$(BIN)/pip install --quiet --requirement requirements-dev.lock
	touch $@

$(NATIVE): $(TOOLS) pyproject.toml $(RUST_SOURCES)
	PIP_QUIET=1 $(BIN)/maturin develop --release --locked --quiet
	touch $@

$(PACKAGES): viewer/package.json viewer/package-lock.json
	@command -v npm > /dev/null || { echo "Node.js 20 or newer is needed for the viewer: see https://nodejs.org"; exit 1; }
	npm --prefix viewer ci --no-fund --no-audit --loglevel=error
	touch $@

$(PAGE): $(PACKAGES) $(PAGE_SOURCES)
	npm --prefix viewer run --silent build
