"""What holds for every net that ships."""

import pytest

from cprm_gym.agents.catalogue import shipped_nets
from cprm_gym.architecture.analysis.modules.composition import check_composition

NETS = shipped_nets()


@pytest.mark.parametrize("name", NETS)
def test_modules_are_used_as_their_contracts_assume_in_every_environment(name):
    report = check_composition(NETS[name])
    assert report.complete
    assert report.holds, str(report)
