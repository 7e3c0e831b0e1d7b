//! Kinematic chain of the arm for pictures and descriptions: parent, joint, position and shape of
//! each link.

use crate::{ArmModel, JointAngles, ToolBias};

/// Height of the shoulder's axis above the underside of the base, mm (model section 1).
const SHOULDER: f64 = 138.0;

/// Height of the rotating part below the shoulder, as drawn, mm. Not measured.
const TURRET: f64 = 60.0;

/// Shape of a link. It starts at the origin of the link's frame and extends along z after
/// [`Link::turn`]; a sphere is centred on the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A box; its size is x, y and z.
    Box,
    /// A cylinder; its size is its diameter twice, then its length.
    Cylinder,
    /// A sphere; its size is its diameter three times.
    Sphere,
}

impl Shape {
    /// Name in interfaces.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Cylinder => "cylinder",
            Self::Sphere => "sphere",
        }
    }
}

/// Joint that moves a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkJoint {
    /// The joint of this number, 1 to 4, by its angle.
    Joint(u8),
    /// The same joint backwards: a parallelogram keeps the link's direction when that joint moves.
    Against(u8),
    /// The rail, along the axis.
    Rail,
}

impl LinkJoint {
    /// Name in interfaces: `j1`, `-j2`, `l`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Joint(1) => "j1",
            Self::Joint(2) => "j2",
            Self::Joint(3) => "j3",
            Self::Joint(_) => "j4",
            Self::Against(2) => "-j2",
            Self::Against(_) => "-j3",
            Self::Rail => "l",
        }
    }

    /// Rotation of the link about its axis at these joints, deg; 0 for the rail.
    #[must_use]
    pub fn angle(self, joints: &JointAngles) -> f64 {
        let [j1, j2, j3, j4] = joints.to_array();
        let of = |number| match number {
            1 => j1,
            2 => j2,
            3 => j3,
            _ => j4,
        };
        match self {
            Self::Joint(number) => of(number),
            Self::Against(number) => -of(number),
            Self::Rail => 0.0,
        }
    }
}

/// A link. Its frame is its parent's, moved by [`at`](Self::at), then turned about
/// [`axis`](Self::axis) (right-handed) by its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Name of the link.
    pub name: &'static str,
    /// Link that carries this one; `None` for the first.
    pub parent: Option<&'static str>,
    /// Joint that moves the link; `None` if it is fixed to its parent.
    pub joint: Option<LinkJoint>,
    /// Axis in the link's own frame, a unit vector.
    pub axis: [f64; 3],
    /// Origin of the frame in the parent's frame, mm.
    pub at: [f64; 3],
    /// Shape of the link.
    pub shape: Shape,
    /// Size of the shape, mm.
    pub size: [f64; 3],
    /// Rotation of the shape in its frame: about x, then y, then z, deg.
    pub turn: [f64; 3],
    /// Colour, `#rrggbb`.
    pub color: &'static str,
}

const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
const DARK: &str = "#30343a";
const LIGHT: &str = "#d9dce0";
const RED: &str = "#c8332b";

impl ArmModel {
    /// Links of the arm with this tool, from the base to the tool. The origin of the last link is
    /// the tool tip.
    ///
    /// The first link is placed in the arm's frame, whose origin is the shoulder. Lengths between
    /// axes and the height of the shoulder are those of the arm; thicknesses are not measured.
    ///
    /// ```
    /// use magician_motion::{ArmModel, ToolBias};
    ///
    /// let links = ArmModel::MAGICIAN.links(ToolBias::SUCTION, false);
    /// assert_eq!(links[2].name, "rear_arm");
    /// assert_eq!(links[2].size[2], 135.0);
    /// ```
    #[must_use]
    pub fn links(&self, tool: ToolBias, on_rail: bool) -> [Link; 8] {
        let (rear, fore) = (self.geometry.rear_arm, self.geometry.forearm);
        let link = |name, parent, joint, at| Link {
            name,
            parent: Some(parent),
            joint: Some(joint),
            axis: Y,
            at,
            shape: Shape::Cylinder,
            size: [34.0, 34.0, 34.0],
            turn: [0.0; 3],
            color: LIGHT,
        };
        [
            Link {
                name: "base",
                parent: None,
                joint: on_rail.then_some(LinkJoint::Rail),
                axis: Y,
                at: [0.0, 0.0, -TURRET],
                shape: Shape::Box,
                size: [158.0, 158.0, SHOULDER - TURRET],
                // Extends from below the turret down to the table.
                turn: [180.0, 0.0, 0.0],
                color: DARK,
            },
            Link {
                axis: Z,
                size: [110.0, 110.0, TURRET],
                turn: [180.0, 0.0, 0.0],
                ..link("turret", "base", LinkJoint::Joint(1), [0.0, 0.0, TURRET])
            },
            Link {
                shape: Shape::Box,
                size: [44.0, 44.0, rear],
                ..link("rear_arm", "turret", LinkJoint::Joint(2), [0.0; 3])
            },
            Link {
                shape: Shape::Sphere,
                size: [46.0; 3],
                color: RED,
                ..link("elbow", "rear_arm", LinkJoint::Against(2), [0.0, 0.0, rear])
            },
            Link {
                shape: Shape::Box,
                size: [36.0, 36.0, fore],
                turn: [0.0, 90.0, 0.0],
                ..link("forearm", "elbow", LinkJoint::Joint(3), [0.0; 3])
            },
            Link {
                shape: Shape::Sphere,
                size: [38.0; 3],
                color: RED,
                ..link("wrist", "forearm", LinkJoint::Against(3), [fore, 0.0, 0.0])
            },
            Link {
                joint: None,
                shape: Shape::Box,
                // Renderers reject a size of 0.
                size: [30.0, 30.0, tool.x.abs().max(1.0)],
                turn: [0.0, if tool.x < 0.0 { -90.0 } else { 90.0 }, 0.0],
                ..link("bracket", "wrist", LinkJoint::Joint(4), [0.0; 3])
            },
            Link {
                axis: Z,
                size: [16.0, 16.0, tool.z.abs().max(30.0)],
                color: DARK,
                ..link(
                    "tool",
                    "bracket",
                    LinkJoint::Joint(4),
                    [tool.x, tool.y, -tool.z],
                )
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Geometry;

    /// Product of two rotations.
    fn times(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let cell = |row: usize, column: usize| (0..3).map(|at| a[row][at] * b[at][column]).sum();
        [0, 1, 2].map(|row| [0, 1, 2].map(|column| cell(row, column)))
    }

    fn about(axis: [f64; 3], degrees: f64) -> [[f64; 3]; 3] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        if axis == Z {
            return [[cos, -sin, 0.0], [sin, cos, 0.0], Z];
        }
        assert_eq!(axis, Y);
        [[cos, 0.0, sin], Y, [-sin, 0.0, cos]]
    }

    #[test]
    fn the_chain_of_links_ends_at_the_pose() {
        let tool = ToolBias::new(59.7, -8.0, 12.0);
        let geometry = Geometry::magician(tool);
        for joints in [
            [0.0, 45.0, 45.0, 0.0],
            [-70.0, 10.0, 60.0, 30.0],
            [110.0, 80.0, 40.0, -140.0],
        ] {
            let joints = JointAngles::from(joints);
            let (mut turned, mut at) = (about(Z, 0.0), [0.0; 3]);
            let mut parent = None;
            for link in ArmModel::MAGICIAN.links(tool, false) {
                assert_eq!(link.parent, parent);
                parent = Some(link.name);
                let moved = |row: usize| (0..3).map(|i| turned[row][i] * link.at[i]).sum::<f64>();
                let by = [moved(0), moved(1), moved(2)];
                for (at, by) in at.iter_mut().zip(by) {
                    *at += by;
                }
                let angle = link.joint.map_or(0.0, |joint| joint.angle(&joints));
                turned = times(turned, about(link.axis, angle));
            }
            let pose = geometry.forward(&joints);
            let r = turned[1][0].atan2(turned[0][0]).to_degrees();
            for (value, wanted) in at.into_iter().zip([pose.x, pose.y, pose.z]) {
                assert!((value - wanted).abs() < 1e-9, "{joints:?}: {at:?} {pose:?}");
            }
            assert!(((r - pose.r).rem_euclid(360.0)).min((pose.r - r).rem_euclid(360.0)) < 1e-9);
            // The tool stays level.
            assert!((turned[2][2] - 1.0).abs() < 1e-9);
        }
    }
}
