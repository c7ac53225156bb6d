//! Greedy assembly of connections to people.

use super::connections::Connection;
use super::model::Limb;
use super::peaks::Peak;

/// Candidates that were put together.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Assembly {
    /// Index of each part's candidate.
    pub(super) parts: Vec<Option<usize>>,
    /// Sum of the scores of candidates and connections.
    pub(super) score: f32,
}

impl Assembly {
    /// Number of parts.
    pub(super) fn len(&self) -> usize {
        self.parts.iter().flatten().count()
    }
}

/// Puts connections together, those of the highest score first: two free candidates begin a person, a
/// free one joins the person of the other unless that has the part, and two people without a common part
/// become one.
///
/// # Source
/// OpenPose, `pafVectorIntoPeopleVector` of `bodyPartConnectorBase.cpp`.
pub(super) fn assemble(
    mut connections: Vec<Connection>,
    limbs: &[Limb],
    peaks: &[Vec<Peak>],
) -> Vec<Assembly> {
    // The sort is stable, so that connections of equal scores keep the order of limbs.
    connections.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut people: Vec<Assembly> = Vec::new();
    for connection in connections {
        let [part_a, part_b] = limbs[connection.limb].parts;
        let [a, b] = connection.peaks;
        let owner = |part: usize, peak: usize| {
            people.iter().position(|person| person.parts[part] == Some(peak))
        };
        let score_of = |part: usize, peak: usize| peaks[part][peak].score;
        match (owner(part_a, a), owner(part_b, b)) {
            (None, None) => {
                let mut parts = vec![None; peaks.len()];
                (parts[part_a], parts[part_b]) = (Some(a), Some(b));
                let score = score_of(part_a, a) + score_of(part_b, b) + connection.score;
                people.push(Assembly { parts, score });
            }
            (Some(person), None) if people[person].parts[part_b].is_none() => {
                people[person].parts[part_b] = Some(b);
                people[person].score += score_of(part_b, b) + connection.score;
            }
            (None, Some(person)) if people[person].parts[part_a].is_none() => {
                people[person].parts[part_a] = Some(a);
                people[person].score += score_of(part_a, a) + connection.score;
            }
            // Both ends are of one person already: its limbs form a loop.
            (Some(one), Some(other)) if one == other => people[one].score += connection.score,
            (Some(one), Some(other)) => {
                // The later one is removed, so that the index of the earlier one stays valid.
                merge(&mut people, one.min(other), one.max(other), connection.score);
            }
            // A connection of a higher score has taken the part.
            _ => {}
        }
    }
    people
}

/// Makes two people one, unless both have a part.
fn merge(people: &mut Vec<Assembly>, first: usize, second: usize, score: f32) {
    let both = people[first].parts.iter().zip(&people[second].parts);
    if both.into_iter().any(|(a, b)| a.is_some() && b.is_some()) {
        return;
    }
    let other = people.remove(second);
    let person = &mut people[first];
    for (part, of_other) in person.parts.iter_mut().zip(other.parts) {
        *part = part.or(of_other);
    }
    person.score += other.score + score;
}
