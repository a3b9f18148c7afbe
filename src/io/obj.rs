//! Wavefront OBJ, one file per frame: the skin with texture coordinates and one group per part, or named meshes.

use crate::error::OutputError;
use crate::io::atomic::WholeFile;
use crate::rig::Character;
use glam::Vec3;
use std::fmt::Write;
use std::path::Path;

/// Writes one frame of a character to `path`, whole or not at all.
///
/// Positions and normals are posed, one per vertex of the character, in its vertex order; texture coordinates are turned
/// from glTF's upper-left origin to OBJ's lower-left one. `frame` is for messages.
///
/// # Errors
/// [`OutputError::PointCount`] and [`OutputError::NotFinite`], else as [`WholeFile`].
pub fn write_frame(
    path: &Path,
    frame: u32,
    character: &Character,
    positions: &[Vec3],
    normals: &[Vec3],
) -> Result<(), OutputError> {
    let expected = character.vertex_count();
    if let Some(got) = [positions.len(), normals.len()].into_iter().find(|&n| n != expected) {
        return Err(OutputError::PointCount { path: path.to_owned(), frame, got, expected });
    }
    if let Some(vertex) = (0..expected).find(|&v| !(positions[v].is_finite() && normals[v].is_finite())) {
        return Err(OutputError::NotFinite { path: path.to_owned(), frame, vertex });
    }
    let mut file = WholeFile::create(path)?;
    file.put(text(character, positions, normals).as_bytes())?;
    file.finish()
}

fn text(character: &Character, positions: &[Vec3], normals: &[Vec3]) -> String {
    let mut text = String::with_capacity(positions.len() * 110 + character.triangles.len() * 50);
    // Writing to a string cannot fail; f32 is printed with the digits that read back as the same number.
    for p in positions {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for uv in &character.uvs {
        let _ = writeln!(text, "vt {} {}", uv.x, 1.0 - uv.y);
    }
    for n in normals {
        let _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z);
    }
    for part in &character.parts {
        let _ = writeln!(text, "g {}", word(&part.name, "part"));
        for triangle in &character.triangles[part.triangles.start as usize..part.triangles.end as usize] {
            let [a, b, c] = triangle.map(|v| v + 1);
            let _ = writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}");
        }
    }
    text
}

/// A name as one word, as OBJ has them.
fn word(name: &str, nameless: &str) -> String {
    let name: String = name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect();
    if name.is_empty() { nameless.into() } else { name }
}

/// Several named meshes in one file, each an object (`o NAME`) with smooth normals.
#[derive(Debug)]
pub struct Objects {
    file: WholeFile,
    frame: u32,
    vertices: usize,
}

impl Objects {
    /// Opens a file that will become `path`; `frame` is for messages.
    ///
    /// # Errors
    /// As [`WholeFile::create`].
    pub fn create(path: &Path, frame: u32) -> Result<Objects, OutputError> {
        Ok(Objects { file: WholeFile::create(path)?, frame, vertices: 0 })
    }

    /// Adds a mesh; `normals` are one per position, `triangles` index them.
    ///
    /// # Errors
    /// [`OutputError::PointCount`] for another number of normals, [`OutputError::NotFinite`] with the vertex' number in
    /// the file, [`OutputError::Write`].
    pub fn add(
        &mut self,
        name: &str,
        positions: &[Vec3],
        normals: &[Vec3],
        triangles: &[[u32; 3]],
    ) -> Result<(), OutputError> {
        let (path, frame, expected) = (self.file.path().to_owned(), self.frame, positions.len());
        if normals.len() != expected {
            return Err(OutputError::PointCount { path, frame, got: normals.len(), expected });
        }
        if let Some(v) = (0..expected).find(|&v| !(positions[v].is_finite() && normals[v].is_finite())) {
            return Err(OutputError::NotFinite { path, frame, vertex: self.vertices + v });
        }
        let mut text = String::with_capacity(expected * 80 + triangles.len() * 40);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "o {}", word(name, "mesh"));
        for p in positions {
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        for n in normals {
            let _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z);
        }
        for triangle in triangles {
            let [a, b, c] = triangle.map(|v| self.vertices + v as usize + 1);
            let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}");
        }
        self.vertices += expected;
        self.file.put(text.as_bytes())
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// As [`WholeFile::finish`].
    pub fn finish(self) -> Result<(), OutputError> {
        self.file.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::Part;
    use glam::Vec2;

    fn triangle() -> Character {
        Character {
            positions_rest: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals_rest: vec![Vec3::Z; 3],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::new(0.25, 0.75)],
            triangles: vec![[0, 1, 2]],
            parts: vec![Part { name: "left arm".into(), node: 0, vertices: 0..3, triangles: 0..1, material: 0 }],
            ..Character::default()
        }
    }

    #[test]
    fn a_tiny_mesh_has_exactly_these_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame_0000.obj");
        let posed = [Vec3::new(0.1, -1e-7, 2.0), Vec3::X, Vec3::Y];
        write_frame(&path, 0, &triangle(), &posed, &[Vec3::Z; 3]).unwrap();
        let expected = "v 0.1 -0.0000001 2\nv 1 0 0\nv 0 1 0\nvt 0 1\nvt 1 1\nvt 0.25 0.25\n\
                        vn 0 0 1\nvn 0 0 1\nvn 0 0 1\ng left_arm\nf 1/1/1 2/2/2 3/3/3\n";
        assert_eq!(std::fs::read_to_string(&path).unwrap(), expected);
    }

    #[test]
    fn wrong_counts_and_non_finite_normals_are_refused_and_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame_0000.obj");
        let error = write_frame(&path, 0, &triangle(), &[Vec3::ZERO; 2], &[Vec3::Z; 3]).unwrap_err();
        assert!(matches!(error, OutputError::PointCount { got: 2, expected: 3, .. }));
        let normals = [Vec3::Z, Vec3::INFINITY, Vec3::Z];
        let error = write_frame(&path, 4, &triangle(), &[Vec3::ZERO; 3], &normals).unwrap_err();
        assert!(matches!(error, OutputError::NotFinite { frame: 4, vertex: 1, .. }));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn objects_have_exactly_these_bytes_and_bad_ones_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("muscles_0003.obj");
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let mut file = Objects::create(&path, 3).unwrap();
        file.add("long head", &corners, &[Vec3::Z; 3], &[[0, 1, 2]]).unwrap();
        file.add("", &corners, &[Vec3::Z; 3], &[[2, 1, 0]]).unwrap();
        file.finish().unwrap();
        let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n";
        let expected = format!("o long_head\n{mesh}f 1//1 2//2 3//3\no mesh\n{mesh}f 6//6 5//5 4//4\n");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), expected);
        let other = folder.path().join("other.obj");
        let mut file = Objects::create(&other, 3).unwrap();
        file.add("a", &corners, &[Vec3::Z; 3], &[[0, 1, 2]]).unwrap();
        let error = file.add("b", &[Vec3::ZERO, Vec3::NAN], &[Vec3::Z; 2], &[]).unwrap_err();
        assert!(matches!(error, OutputError::NotFinite { frame: 3, vertex: 4, .. }), "{error}");
        let error = file.add("b", &corners, &[Vec3::Z; 2], &[]).unwrap_err();
        assert!(matches!(error, OutputError::PointCount { got: 2, expected: 3, .. }), "{error}");
        drop(file);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
