"""Frames are found again as they were, also when they were packed, and the oldest are dropped."""

from cprm_gym.studio.watching import frame_store
from cprm_gym.studio.watching.frame_store import Frames


def test_frames_come_back_as_they_were_kept(monkeypatch):
    monkeypatch.setattr(frame_store, "RECENT", 3)
    monkeypatch.setattr(frame_store, "KEPT", 7)
    frames = Frames()
    assert frames.span() == [0, 0]
    for cycle in range(10):
        frames.put({"cycle": cycle, "text": f"o{cycle}", "none": None, "p": [0.25, 1]})
    assert list(frames) == [3, 4, 5, 6, 7, 8, 9]
    assert frames.span() == [3, 9]
    assert 2 not in frames
    assert all(frames[cycle] == {"cycle": cycle, "text": f"o{cycle}", "none": None, "p": [0.25, 1]} for cycle in frames)
    frames.put({"cycle": 4, "text": "again"})
    frames.put({"cycle": 9, "text": "again"})
    assert [frames[4]["text"], frames[9]["text"], len(frames)] == ["again", "again", 7]
    frames.drop_after(5)
    assert list(frames) == [3, 4, 5]
    frames.put({"cycle": 6})
    assert [frame["cycle"] for frame in frames.last(2)] == [5, 6]
    frames.clear()
    assert len(frames) == 0
