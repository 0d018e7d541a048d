# Sourced by the commands beside it: makes and enters the virtual environment .venv with the extras named in $1.
# A second run with nothing changed takes a moment; CPRM_GYM_VENV names another folder, PYTHON another interpreter.
extras="$1"
venv="${CPRM_GYM_VENV:-.venv}"
stamp="$venv/installed-$extras"
want="$(cat pyproject.toml constraints.txt | cksum)"
if [ ! -x "$venv/bin/python" ]; then
    "${PYTHON:-python3}" -m venv "$venv"
fi
if [ "$(cat "$stamp" 2>/dev/null || true)" != "$want" ]; then
    echo "installing cprm-gym[$extras] into $venv ..." >&2
    "$venv/bin/python" -m pip install --quiet --upgrade pip
    case "$extras" in
        *all*|*rl*) "$venv/bin/python" -m pip install --quiet -c constraints.txt torch ;;
    esac
    "$venv/bin/python" -m pip install --quiet -c constraints.txt -e ".[$extras]"
    echo "$want" > "$stamp"
fi
. "$venv/bin/activate"
