//! Faces by the groups and objects that a file puts them into.

use super::Obj;
use super::scan::{self, Statements};
use crate::mesh::jagged::Index;

/// The file has no group and no object of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("has no group and no object `{0}`")]
pub struct NoSuchGroup(pub String);

impl Obj {
    /// Marks the faces of groups (`g`, which may name several) and objects (`o`). #f
    ///
    /// # Errors
    /// With the first name that no statement has.
    pub fn faces_in(&self, names: &[&str]) -> Result<Vec<bool>, NoSuchGroup> {
        let mut found = vec![false; names.len()];
        let mut picked = Vec::with_capacity(self.data.faces().len());
        let [mut in_group, mut in_object] = [false; 2];
        let mut statements = Statements::new(&self.bytes).peekable();
        for face in 0..self.data.faces().len() as Index {
            let line = self.data.face_line(face).unwrap_or(u32::MAX);
            while let Some(statement) = statements.next_if(|statement| statement.line < line) {
                let is = match &self.bytes[statement.keyword.clone()] {
                    b"g" => &mut in_group,
                    b"o" => &mut in_object,
                    _ => continue,
                };
                *is = self.names(&statement, names, &mut found);
            }
            picked.push(in_group || in_object);
        }
        // Groups behind the last face have no faces, but exist.
        for statement in statements.filter(|s| matches!(&self.bytes[s.keyword.clone()], b"g" | b"o")) {
            self.names(&statement, names, &mut found);
        }
        match found.iter().position(|found| !found) {
            Some(absent) => Err(NoSuchGroup(names[absent].to_owned())),
            None => Ok(picked),
        }
    }

    /// Returns true if a statement has one of the names, alone or among others, and marks those that it has.
    fn names(&self, statement: &scan::Statement, names: &[&str], found: &mut [bool]) -> bool {
        let argument = String::from_utf8_lossy(scan::name(&self.bytes, statement));
        let is_group = &self.bytes[statement.keyword.clone()] == b"g";
        let has = |name: &str| *argument == *name || (is_group && argument.split_whitespace().any(|word| word == name));
        let mut any = false;
        for (name, found) in names.iter().zip(found) {
            if has(name) {
                (*found, any) = (true, true);
            }
        }
        any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_found_by_group_and_object() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no left eye\nf 1 2\nf 1 2 3\ng skin lid\nf 1 2 3\nf 1 2 \\\n 3\no rest\nf 1 2 3\ng\nf 1 2 3\ng last";
        let obj = Obj::parse(text.as_bytes().to_vec()).unwrap();
        let faces = |names: &[&str]| {
            let picked = obj.faces_in(names).unwrap();
            (0..).zip(picked).filter(|(_, picked)| *picked).map(|(f, _)| f).collect::<Vec<i32>>()
        };
        assert_eq!(obj.data().faces().len(), 6);
        assert_eq!(faces(&["left eye"]), [1, 2, 3]);
        assert_eq!(faces(&["lid"]), [2, 3, 4]);
        assert_eq!(faces(&["skin", "left eye"]), [1, 2, 3, 4]);
        assert_eq!(faces(&["skin lid", "rest"]), [2, 3, 4, 5]);
        assert_eq!(faces(&["last"]), [0; 0]);
        assert_eq!(obj.faces_in(&["rest", "left"]).unwrap_err(), NoSuchGroup("left".to_owned()));
    }
}
