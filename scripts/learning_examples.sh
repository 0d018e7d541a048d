#!/usr/bin/env bash
# Makes an environment for each library of multi-agent learning (their versions exclude each other), tests its bridge there and runs its
# example, shortened. Arguments: the bridges, all if none are given; VENVS: the folder of the environments.
set -euo pipefail
cd "$(dirname "$0")/.."
root="${VENVS:-.venvs}"
export OMP_NUM_THREADS=1
for bridge in "${@:-torchrl benchmarl rllib rl}"; do
  for name in $bridge; do
    case "$name" in
      torchrl) example="torchrl_ppo.py --iterations 3"; tests=test_torchrl_env.py ;;
      benchmarl) example="benchmarl_mappo.py --frames 3000"; tests=test_benchmarl_task.py ;;
      rllib) example="rllib_ppo.py --iterations 2 --steps 1000"; tests=test_rllib_env.py ;;
      rl) example="flat_buffers.py --iterations 3"; tests=test_buffers.py ;;
      *) echo "unknown bridge '$name': torchrl, benchmarl, rllib, rl" >&2; exit 2 ;;
    esac
    if [ ! -x "$root/$name/bin/python" ]; then
      python3 -m venv "$root/$name"
      "$root/$name/bin/pip" install -q -e ".[$name]" "pytest>=8" "hypothesis>=6.100"
    fi
    "$root/$name/bin/python" -m pytest -q -p no:cacheprovider "tests/bridges/$tests"
    "$root/$name/bin/python" examples/learning/$example
  done
done
