#!/usr/bin/env bash
# Style, imports, types and tests. Arguments are passed on to pytest.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh all
ruff check .
ruff format --check .
lint-imports
mypy
exec python -m pytest -n 2 --dist loadfile -q "$@"
