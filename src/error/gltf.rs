//! Why a glTF file cannot be read.

use thiserror::Error;

/// Longest piece of a file's own text that is repeated in a message, in characters.
const QUOTED: usize = 160;

/// Whether a character is a terminal's command rather than something to be seen: control characters, line ends, and
/// those that turn the direction of the text after them.
pub(crate) fn is_unprintable(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{2028}' | '\u{2029}' | '\u{200E}' | '\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}')
}

/// Text from outside made fit for a one-line message: control characters and line separators become spaces,
/// and what is longer than a line is cut.
pub(crate) fn one_line(text: &str) -> String {
    let mut line: String = text.chars().take(QUOTED).map(|c| if is_unprintable(c) { ' ' } else { c }).collect();
    if text.chars().nth(QUOTED).is_some() {
        line.push('…');
    }
    line
}

/// Why [`io::gltf`](crate::io::gltf) refused a file. Every message is one line that names the file, the element
/// and what to do.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum GltfError {
    /// The file itself cannot be opened or read.
    #[error("{file}: cannot be read: {reason}; check the path and its permissions")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system said.
        reason: String,
    },
    /// The bytes are neither a GLB nor a glTF text.
    #[error("{file}: not a glTF file: {what}; give a .glb or .gltf file")]
    NotGltf {
        /// The file.
        file: String,
        /// What was found.
        what: String,
    },
    /// A GLB ends before its own header says, or its chunks are out of order.
    #[error("{file}: damaged GLB: {what}; copy or export the file again")]
    Framing {
        /// The file.
        file: String,
        /// What was found.
        what: String,
    },
    /// A version of glTF other than 2.0.
    #[error("{file}: needs glTF {version}, and only 2.0 is read; export it as glTF 2.0")]
    Version {
        /// The file.
        file: String,
        /// The version that it asks for.
        version: String,
    },
    /// The JSON is not JSON, or not what the glTF schema says.
    #[error("{file}: {element}: {what}; export the file again or check it with a glTF validator")]
    Json {
        /// The file.
        file: String,
        /// The element, or `JSON` where the text as a whole is broken.
        element: String,
        /// What the parser said.
        what: String,
    },
    /// The file cannot be shown right without an extension that is not read.
    #[error("{file}: requires the extension {extension}, which is not read; export the file without {extension}")]
    Extension {
        /// The file.
        file: String,
        /// The extension's name.
        extension: String,
    },
    /// A buffer's bytes are not there, or fewer than declared.
    #[error("{file}: {element}: {what}; keep the file's buffers beside it, or export a self-contained .glb")]
    Buffer {
        /// The file.
        file: String,
        /// The buffer.
        element: String,
        /// What is wrong with its bytes.
        what: String,
    },
    /// An element breaks a rule of glTF in a way that leaves its meaning open.
    #[error("{file}: {element}: {what}; {remedy}")]
    Malformed {
        /// The file.
        file: String,
        /// The element.
        element: String,
        /// Which rule it breaks.
        what: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// A number that the result depends on is NaN or infinite.
    #[error("{file}: {element}: {what} is not a finite number; repair it in the modelling program and export again")]
    NonFinite {
        /// The file.
        file: String,
        /// Mesh and primitive, skin or animation.
        element: String,
        /// Which number: vertex, joint or key.
        what: String,
    },
    /// A vertex names a joint that its skin does not have.
    #[error(
        "{file}: {element}: vertex {vertex} uses joint {joint}, and the skin has {joints} joints; export the file again"
    )]
    JointRange {
        /// The file.
        file: String,
        /// Mesh and primitive.
        element: String,
        /// Vertex in the primitive.
        vertex: usize,
        /// The joint asked for, counted in the skin.
        joint: u32,
        /// How many joints the skin has.
        joints: usize,
    },
    /// The file asks for more memory than any character needs.
    #[error("{file}: {element}: {asked} numbers where at most {allowed} are left to read; split or simplify the file")]
    TooLarge {
        /// The file.
        file: String,
        /// What asked for them.
        element: String,
        /// Numbers asked for.
        asked: u64,
        /// Numbers allowed.
        allowed: u64,
    },
    /// The scene shows no triangles at all.
    #[error("{file}: the scene has no mesh with triangles; export the character's mesh together with its armature")]
    NoMesh {
        /// The file.
        file: String,
    },
    /// The scene has meshes, but none of them is skinned.
    #[error(
        "{file}: the scene has no skinned mesh; bind the mesh to an armature and export it with skinning switched on"
    )]
    NoSkin {
        /// The file.
        file: String,
    },
}
