//! Strongly connected components of a small graph.

use std::collections::BTreeMap;

/// Sets of at least two nodes that each lead to all others, largest first.
pub(super) fn circles<T>(nodes: usize, edges: &BTreeMap<(usize, usize), T>) -> Vec<Vec<usize>> {
    let mut next = vec![Vec::new(); nodes];
    for &(from, to) in edges.keys() {
        next[from].push(to);
    }
    // Graphs of a crate are small enough for all pairs.
    let reached: Vec<Vec<bool>> = (0..nodes).map(|start| reachable(start, &next)).collect();
    let mut is_done = vec![false; nodes];
    let mut circles = Vec::new();
    for node in 0..nodes {
        if is_done[node] {
            continue;
        }
        // An earlier node of the same circle would have marked this one as done.
        let members: Vec<usize> =
            (node..nodes).filter(|&other| reached[node][other] && reached[other][node]).collect();
        members.iter().for_each(|&member| is_done[member] = true);
        if members.len() > 1 {
            circles.push(members);
        }
    }
    circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
    circles
}

fn reachable(start: usize, next: &[Vec<usize>]) -> Vec<bool> {
    let mut is_reached = vec![false; next.len()];
    let mut open = vec![start];
    while let Some(node) = open.pop() {
        for &other in &next[node] {
            if !is_reached[other] {
                is_reached[other] = true;
                open.push(other);
            }
        }
    }
    is_reached
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_are_found_and_chains_are_none() {
        let edges = [(0, 1), (1, 2), (2, 0), (2, 3), (3, 4), (4, 3), (5, 0)];
        let edges: BTreeMap<(usize, usize), ()> = edges.into_iter().map(|e| (e, ())).collect();
        assert_eq!(circles(6, &edges), [vec![0, 1, 2], vec![3, 4]]);
    }
}
