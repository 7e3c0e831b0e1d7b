"""pytest fixtures with a virtual arm, available once the package is installed.

* ``virtual_arm``: a :class:`magician.VirtualArm` for this test, in virtual time.
* ``arm``: a :class:`magician.Arm` that is connected to it.
* ``@pytest.mark.scenario(...)``: the world, as a path (beside the test file) or a text in TOML.

A whole test::

    @pytest.mark.scenario("cell.toml")
    def test_the_cube_gets_on_the_belt(arm, virtual_arm):
        sort(arm)
        assert virtual_arm.object("red cube").on_belt

The report of a failed test has the arm's state and its last events.
"""
