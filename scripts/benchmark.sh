#!/usr/bin/env bash
# The main job: measures the controllers on the tasks. Arguments are passed on to `cprm-gym benchmark`.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh render,trees,policies
exec cprm-gym benchmark "$@"
