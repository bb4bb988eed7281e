//! Names for messages: unique within a scene, and listed in one sentence where many share a fault.

use std::collections::{HashMap, HashSet};

use crate::model::{Finding, Severity};

/// Hands out each name once.
#[derive(Default)]
pub(super) struct UniqueNames {
    taken: HashSet<String>,
    next: HashMap<String, u32>,
}

impl UniqueNames {
    /// The wanted name, or the name with the first free number: `chair`, `chair.2`, `chair.3`.
    pub fn claim(&mut self, wanted: &str) -> String {
        if self.taken.insert(wanted.to_string()) {
            return wanted.to_string();
        }
        let next = self.next.entry(wanted.to_string()).or_insert(2);
        loop {
            let name = format!("{wanted}.{next}");
            *next += 1;
            if self.taken.insert(name.clone()) {
                return name;
            }
        }
    }
}

/// Findings that many elements share, each of which is to be said once with all their names.
#[derive(Default)]
pub(super) struct Roll {
    entries: Vec<Entry>,
}

struct Entry {
    severity: Severity,
    code: &'static str,
    kind: &'static str,
    names: Vec<String>,
    message: &'static str,
}

/// Names spelt out per finding.
const LISTED: usize = 8;

impl Roll {
    /// Adds the element `kind` `name`, such as material 'oak', to the finding `code`.
    pub fn note(&mut self, code: &'static str, kind: &'static str, name: &str, message: &'static str) {
        self.add(Severity::Note, code, kind, name, message);
    }

    /// The same for warnings.
    pub fn warn(&mut self, code: &'static str, kind: &'static str, name: &str, message: &'static str) {
        self.add(Severity::Warning, code, kind, name, message);
    }

    fn add(&mut self, severity: Severity, code: &'static str, kind: &'static str, name: &str, message: &'static str) {
        let entry = match self.entries.iter().position(|entry| entry.code == code) {
            Some(known) => &mut self.entries[known],
            None => {
                self.entries.push(Entry { severity, code, kind, names: Vec::new(), message });
                self.entries.last_mut().expect("an entry was just pushed")
            }
        };
        // Elements repeat in runs: the primitives of one mesh, the instances of one material.
        if !entry.names.iter().rev().take(64).any(|known| known == name) {
            entry.names.push(name.to_string());
        }
    }

    /// One finding per code, in order of first appearance.
    pub fn into_findings(self) -> Vec<Finding> {
        self.entries.into_iter().map(Entry::into_finding).collect()
    }
}

impl Entry {
    fn into_finding(mut self) -> Finding {
        let mut seen = HashSet::new();
        self.names.retain(|name| seen.insert(name.clone()));
        let listed: Vec<_> = self.names.iter().take(LISTED).map(|name| format!("'{name}'")).collect();
        let more = match self.names.len() {
            n if n > LISTED => format!(" and {} more", n - LISTED),
            _ => String::new(),
        };
        let plural = if self.names.len() == 1 { "" } else { "s" };
        let element = format!("{}{plural} {}{more}", self.kind, listed.join(", "));
        match self.severity {
            Severity::Note => Finding::note(self.code, element, self.message),
            Severity::Warning => Finding::warning(self.code, element, self.message),
            Severity::Error => Finding::error(self.code, element, self.message),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_even_when_suffixes_clash() {
        let mut names = UniqueNames::default();
        let claimed = ["a", "a.2", "a", "a", "b"].map(|name| names.claim(name));
        assert_eq!(claimed, ["a", "a.2", "a.3", "a.4", "b"]);
    }

    #[test]
    fn roll_lists_names_once() {
        let mut roll = Roll::default();
        for name in ["oak", "oak", "brass"] {
            roll.warn("metallic", "material", name, "are metals");
        }
        let found = roll.into_findings();
        assert_eq!(found, vec![Finding::warning("metallic", "materials 'oak', 'brass'", "are metals")]);
    }

    #[test]
    fn long_rolls_are_cut() {
        let mut roll = Roll::default();
        (0..10).for_each(|i| roll.note("x", "node", &i.to_string(), ""));
        assert!(roll.into_findings()[0].element.ends_with("'7' and 2 more"));
    }
}
