"""One way to read a net, whatever it lies in."""

import json

import pytest
from orient_module import ORIENT, TWICE

from cprm_gym.architecture.petri.files.json import net_to_dict, save_net
from cprm_gym.architecture.petri.files.load import load_net, net_names
from cprm_gym.architecture.petri.files.pnml_writer import write_pnml
from cprm_gym.errors import FormatError


def test_every_format_is_read_whatever_the_file_is_called(tmp_path):
    save_net(ORIENT, tmp_path / "a.json")
    write_pnml(ORIENT, tmp_path / "a.pnml")
    save_net(ORIENT, tmp_path / "json")
    write_pnml(ORIENT, tmp_path / "pnml.txt")
    for name in ("a.json", "a.pnml", "json", "pnml.txt"):
        assert load_net(tmp_path / name) == load_net(str(tmp_path / name)) == ORIENT
    assert load_net(ORIENT) is ORIENT
    (tmp_path / "net.txt").write_text("no net")
    with pytest.raises(FormatError, match="neither JSON nor PNML"):
        load_net(tmp_path / "net.txt")
    with pytest.raises(FormatError, match="nothing: cannot be read"):
        load_net(tmp_path / "nothing")
    with pytest.raises(FormatError, match="cannot be read"):
        load_net("a\0b")


def test_a_definition_of_a_json_file_can_be_named(tmp_path):
    (tmp_path / "twice.json").write_text(json.dumps(net_to_dict(TWICE)))
    assert net_names(tmp_path / "twice.json") == ("orient", "twice")
    assert load_net(tmp_path / "twice.json", net="orient") == ORIENT
    with pytest.raises(FormatError, match=r"no net 'oriemt', which is not defined\. Did you mean 'orient'"):
        load_net(tmp_path / "twice.json", net="oriemt")


def test_a_module_is_imported_only_when_that_is_allowed():
    with pytest.raises(FormatError, match="nets in modules are read with imports=True, which runs the module's code"):
        load_net("orient_module:ORIENT")
    assert load_net("orient_module:ORIENT", imports=True) is ORIENT
    with pytest.raises(FormatError, match=r"has no 'ORIEMT'\. Did you mean 'ORIENT'"):
        load_net("orient_module:ORIEMT", imports=True)
    with pytest.raises(FormatError, match="no module 'orient_modulez'"):
        load_net("orient_modulez:x", imports=True)


def test_a_name_in_a_module_is_never_called():
    for name in ("os:abort", "contract_modules:turn_to_ball"):
        with pytest.raises(FormatError, match=f"{name} is no net, it is a"):
            load_net(name, imports=True)


def test_files_that_are_too_large_are_refused_before_they_are_read(tmp_path):
    with (tmp_path / "large.pnml").open("wb") as file:
        file.truncate(2**26 + 1)
    with pytest.raises(FormatError, match="larger than the 67,108,864 bytes that are read"):
        load_net(tmp_path / "large.pnml")
