from __future__ import annotations

import math
from typing import Any, cast

import magician
import numpy as np
import pytest
from magician import Joints, Position, forward, inverse, is_reachable, reach
from magician.errors import InvalidInputError, UnreachableError


def test_one_pose_is_the_arms() -> None:
    with magician.Arm("sim") as arm:
        arm.move_joints(20, 30, 40, 10)
        pose, bias = arm.pose(), arm.bias()
        assert forward(pose.joints, tool=bias) == pytest.approx(pose.position, abs=1e-3)
        assert inverse(pose.position, tool=bias) == pytest.approx(pose.joints, abs=1e-3)
        assert inverse(pose, tool=bias) == inverse(pose.position, tool=bias)
        assert arm.is_reachable(*pose.position)
        assert not arm.is_reachable(600, 0, 0)
        assert arm.is_reachable(pose) and arm.is_reachable(pose.position)
        assert arm.is_reachable([pose.position, (600, 0, 0, 0)]).tolist() == [True, False]
        assert arm.forward(arm.joints()) == pytest.approx(pose.position, abs=1e-4)
        assert arm.forward([arm.joints()]).poses[0] == pytest.approx(pose.position, abs=1e-4)
        assert arm.inverse(pose) == pytest.approx(arm.joints(), abs=1e-4)
        assert arm.inverse(*pose.position) == arm.inverse(pose) == pytest.approx(arm.inverse([pose.position]).joints[0])


def test_values_of_one_pose_have_names() -> None:
    assert forward(0, 0, 0) == Position(147.0, 0.0, 135.0, 0.0)
    assert isinstance(inverse(200, 0, 50), Joints)
    assert forward(*inverse(200, 0, 50, 15), tool="none") == pytest.approx((200, 0, 50, 15))


def test_the_tool_counts_by_name_and_by_place() -> None:
    with_name, with_place = forward(0, 0, 0, tool="suction"), forward(0, 0, 0, tool=(59.7, 0, 0))
    assert with_name == with_place
    assert with_name.x == pytest.approx(147.0 + 59.7, abs=1e-4)
    with pytest.raises(InvalidInputError, match="unknown tool 'hammer'"):
        forward(0, 0, 0, tool=cast("Any", "hammer"))


def test_unreachable_pose_reports_value_and_limit() -> None:
    with pytest.raises(UnreachableError) as error:
        inverse(600, 0, 0)
    assert error.value.value is not None and error.value.limit is not None
    assert not is_reachable(600, 0, 0)


def test_arrays_agree_with_single_poses() -> None:
    generator = np.random.default_rng(3)
    joints = generator.uniform([-90, 0, -10, -90], [90, 85, 95, 90], (500, 4))
    poses, reachable = forward(joints)
    assert poses.shape == (500, 4) and reachable.dtype == np.bool_
    for row, pose in zip(joints[:50], poses[:50], strict=True):
        assert tuple(pose) == forward(*map(float, row))
    back, there = inverse(poses)
    assert (there == reachable).mean() > 0.99  # At a limit rounding decides.
    both = there & reachable
    assert np.allclose(back[both], joints[both], atol=1e-6)
    assert np.isnan(back[~there]).all()
    assert (is_reachable(poses) == there).all()


def test_rows_without_r_take_the_one_given() -> None:
    places = np.array([[200.0, 0.0, 50.0], [600.0, 0.0, 0.0]])
    joints, reachable = inverse(places, r=30)
    assert reachable.tolist() == [True, False]
    assert tuple(joints[0]) == inverse(200, 0, 50, 30)


def test_nan_is_unreachable() -> None:
    assert is_reachable(np.array([[math.nan, 0, 0], [math.inf, 0, 0], [200, 0, 50]])).tolist() == [False, False, True]
    poses, reachable = forward(np.array([[math.nan, 0, 0, 0]]))
    assert np.isnan(poses).all() and not reachable.any()
    with pytest.raises((InvalidInputError, TypeError)):
        forward(math.nan, 0, 0)
    with pytest.raises(InvalidInputError, match="shape"):
        forward(np.zeros((3, 3)))


def test_the_reach_is_where_poses_are_reachable() -> None:
    (ring,) = reach(0)
    corners = np.array(ring, dtype=np.float64)
    xs, ys = corners[:, 0], corners[:, 1]
    middle = math.atan2(ys.mean(), xs.mean())
    out = np.hypot(xs, ys).max()
    assert not is_reachable((out + 1) * math.cos(middle), (out + 1) * math.sin(middle), 0)
    assert is_reachable((out - 1) * math.cos(middle), (out - 1) * math.sin(middle), 0)
    assert reach(1000) == []
