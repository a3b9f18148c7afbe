//! `bake --muscle-meshes`: the surfaces of all muscles, one OBJ file per frame.

use crate::bake::Sequence;
use crate::deform::Shaped;
use crate::failure::Failure;
use rayon::prelude::*;
use serde::Serialize;
use sinew::field::muscle::mesh::{Detail, Surface};
use sinew::io::atomic::FileSet;
use sinew::io::obj::Objects;
use sinew::rig::{Pose, Rig};
use sinew::schedule::Skinning;
use sinew::wrap;
use std::path::{Path, PathBuf};

/// Muscles whose surfaces are held at a time: hundreds of them make gigabytes.
const AT_ONCE: usize = 64;

/// What was written.
#[derive(Serialize)]
pub struct Written {
    folder: PathBuf,
    first_file: String,
    last_file: String,
    /// The objects of every file, in their order; fibres of a set are numbered.
    objects: Vec<String>,
    /// Vertices and triangles of every object.
    vertices: usize,
    triangles: usize,
}

/// Where the meshes go. Dropped before it is finished, it leaves nothing.
pub struct Sink {
    set: FileSet,
    place: Sequence,
    names: Vec<String>,
    files: Vec<String>,
}

impl Sink {
    /// Refuses what can have no muscles to write: a file without any, or a skinning that does not shape them.
    pub fn check(output: &Path, muscles: usize, skinning: Skinning) -> Result<Sequence, Failure> {
        let refuse = |why: &str| Err(Failure::Input(format!("--muscle-meshes {}: {why}", output.display())));
        if !skinning.follows_muscles() {
            return refuse(
                "only --skinning implicit, weighted and hybrid give muscles a shape; leave out one of the two",
            );
        }
        if muscles == 0 {
            return refuse("there are no muscles to write; give --muscles a file that has some");
        }
        Sequence::of(output, "muscles").ok_or_else(|| {
            let what = "is no OBJ file; give NAME.obj or a folder";
            Failure::Input(format!("--muscle-meshes {}: {what}", output.display()))
        })
    }

    /// Opens the folder.
    pub fn open(place: Sequence) -> Result<Sink, Failure> {
        let set = FileSet::open(&place.folder).map_err(Failure::input)?;
        Ok(Sink { set, place, names: Vec::new(), files: Vec::new() })
    }

    /// Writes one frame's muscles.
    pub fn frame(&mut self, number: u32, rig: &Rig, pose: &Pose, shaped: &Shaped) -> Result<(), Failure> {
        let name = self.place.file(number);
        let write = |path: &Path| {
            let mut file = Objects::create(path, number)?;
            for first in (0..shaped.muscles.len()).step_by(AT_ONCE) {
                let chunk = first..(first + AT_ONCE).min(shaped.muscles.len());
                let surfaces: Vec<Surface> =
                    chunk.clone().into_par_iter().map(|i| surface(rig, pose, shaped, i)).collect();
                for (name, mesh) in rig.muscle_names[chunk].iter().zip(&surfaces) {
                    file.add(name, &mesh.positions, &mesh.normals, &mesh.triangles)?;
                }
            }
            file.finish()
        };
        self.set.write(&name, write).map_err(Failure::input)?;
        self.names.clone_from(&rig.muscle_names);
        self.files.push(name);
        Ok(())
    }

    /// Gives the files their names.
    pub fn finish(self) -> Result<Written, Failure> {
        self.set.keep().map_err(Failure::input)?;
        let corners = Surface::collapsed(Detail::DISPLAY, Default::default());
        let file = |name: Option<&String>| name.cloned().unwrap_or_default();
        Ok(Written {
            folder: self.place.folder,
            first_file: file(self.files.first()),
            last_file: file(self.files.last()),
            objects: self.names,
            vertices: corners.positions.len(),
            triangles: corners.triangles.len(),
        })
    }
}

impl Written {
    /// In words, for results.
    pub fn describe(&self) -> String {
        let (folder, first, last) = (self.folder.display(), &self.first_file, &self.last_file);
        format!("\n{folder}: {} muscle meshes of {} vertices in {first} to {last}", self.objects.len(), self.vertices)
    }
}

fn surface(rig: &Rig, pose: &Pose, shaped: &Shaped, muscle: usize) -> Surface {
    let (frame, rest) = (&shaped.muscles[muscle], &rig.muscles[muscle]);
    let first = rest.first_point as usize;
    let points = &shaped.axes[first..=first + rest.segments as usize];
    wrap::posed_surface(frame, points, &pose.palette[rest.joint as usize], Detail::DISPLAY)
}
