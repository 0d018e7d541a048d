#!/usr/bin/env bash
# The documentation site, warnings are errors: docs/_build/html/index.html. Arguments are passed on to sphinx-build.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh all
exec python -m sphinx -W --keep-going -q -b html -d docs/_build/doctrees "$@" docs docs/_build/html
