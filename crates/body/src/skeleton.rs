//! The 52 joints of SMPL+H: their indices and parents.
//!
//! # Source
//! Romero, Tzionas, Black: *Embodied Hands* (SIGGRAPH Asia 2017). Joints 0..22 are the body's,
//! 22..37 the left hand's, 37..52 the right hand's; a hand has index, middle, pinky, ring and thumb
//! in this order, three joints each from the knuckle outwards.

/// Number of joints.
pub const JOINTS: usize = 52;
/// Joints of the body, before those of the hands.
pub const BODY_JOINTS: usize = 22;
/// Right collar bone.
pub const RIGHT_COLLAR: usize = 14;
/// Right shoulder.
pub const RIGHT_SHOULDER: usize = 17;
/// Right elbow.
pub const RIGHT_ELBOW: usize = 19;
/// Left wrist.
pub const LEFT_WRIST: usize = 20;
/// Right wrist: the joint whose pose EventHands estimates.
pub const RIGHT_WRIST: usize = 21;
/// First of the 15 joints of the left hand.
pub const LEFT_HAND: usize = 22;
/// First of the 15 joints of the right hand.
pub const RIGHT_HAND: usize = 37;
/// Joints of one hand.
pub const HAND_JOINTS: usize = 15;

/// Parents of the body's joints.
const BODY_PARENTS: [Option<usize>; BODY_JOINTS] = {
    let p = Some::<usize>;
    [
        None,
        p(0),
        p(0),
        p(0),
        p(1),
        p(2),
        p(3),
        p(4),
        p(5),
        p(6),
        p(7),
        p(8),
        p(9),
        p(9),
        p(9),
        p(12),
        p(13),
        p(14),
        p(16),
        p(17),
        p(18),
        p(19),
    ]
};

/// The parent of every joint; parents come before their children.
pub fn parents() -> [Option<usize>; JOINTS] {
    std::array::from_fn(|joint| match joint {
        0..LEFT_HAND => BODY_PARENTS[joint],
        _ => {
            let (wrist, first) = if joint < RIGHT_HAND {
                (LEFT_WRIST, LEFT_HAND)
            } else {
                (RIGHT_WRIST, RIGHT_HAND)
            };
            Some(if (joint - first) % 3 == 0 { wrist } else { joint - 1 })
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_right_arm_is_one_chain_from_the_pelvis() {
        let parents = parents();
        let mut chain = vec![RIGHT_WRIST];
        while let Some(parent) = chain.last().and_then(|&joint| parents[joint]) {
            chain.push(parent);
        }
        assert_eq!(chain, [21, 19, 17, 14, 9, 6, 3, 0]);
    }

    #[test]
    fn parents_come_first_and_knuckles_hang_on_their_wrist() {
        let parents = parents();
        for (joint, parent) in parents.iter().enumerate().skip(1) {
            assert!(parent.is_some_and(|parent| parent < joint), "{joint}");
        }
        assert_eq!(parents[22], Some(20));
        assert_eq!([37, 40, 43, 46, 49].map(|j| parents[j]), [Some(21); 5]);
        assert_eq!(parents[51], Some(50));
    }
}
