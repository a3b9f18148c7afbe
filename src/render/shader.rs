//! The shaders of this room: which files make which module, and the structs they share with the host.

use super::mesh::MaterialParams;
use crate::math::GpuStruct;

crate::gpu_struct! {
    /// What every shader knows of a frame.
    pub struct ViewParams {
        /// World to clip space.
        pub view_projection: glam::Mat4,
        /// Position of the eye in `xyz`, metres.
        pub eye: glam::Vec4,
        /// Unit vector to the right of the picture in `xyz`.
        pub right: glam::Vec4,
        /// Unit vector to the top of the picture in `xyz`.
        pub up: glam::Vec4,
        /// Unit vector from the scene to the eye in `xyz`.
        pub toward: glam::Vec4,
        /// 1 for the studio's light, 0 for plain colours.
        pub lit: f32,
        /// Opacity of glass that faces the eye.
        pub ghost_facing: f32,
        /// Opacity of glass seen edge on.
        pub ghost_edge: f32,
        /// How late opacity rises towards the edge.
        pub ghost_power: f32,
    }
}

/// A shader module: its name, and its source put together from files.
pub struct Module {
    /// The main file's stem.
    pub name: &'static str,
    parts: &'static [&'static str],
}

const LIGHT: &str = include_str!("../../shaders/render/light.wgsl");
const VIEW_BINDING: &str = "@group(0) @binding(0) var<uniform> view: ViewParams;\n";

/// The backdrop.
pub const BACKGROUND: Module =
    Module { name: "background", parts: &[include_str!("../../shaders/render/background.wgsl")] };
/// Coloured meshes.
pub const SOLID: Module = Module { name: "solid", parts: &[LIGHT, include_str!("../../shaders/render/solid.wgsl")] };
/// Skin and rigid parts.
pub const SURFACE: Module =
    Module { name: "surface", parts: &[LIGHT, include_str!("../../shaders/render/surface.wgsl")] };
/// Every module of this room.
pub const MODULES: [Module; 3] = [BACKGROUND, SOLID, SURFACE];

impl Module {
    /// The whole WGSL text.
    pub fn source(&self) -> String {
        let mut source = ViewParams::wgsl();
        source += VIEW_BINDING;
        source += &MaterialParams::wgsl();
        for part in self.parts {
            source += part;
        }
        source
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::GpuField;

    fn validated(source: &str) -> Result<naga::Module, String> {
        let module = naga::front::wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
            .validate(&module)
            .map_err(|e| e.emit_to_string(source))?;
        Ok(module)
    }

    /// Members whose offset on the host is not the shader's, and whether the sizes agree.
    fn mismatches(module: &naga::Module, name: &str, fields: &[GpuField], size: usize) -> Vec<String> {
        let found = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name));
        let Some((_, naga::Type { inner: naga::TypeInner::Struct { members, span }, .. })) = found else {
            return vec![format!("{name} is missing")];
        };
        let mut wrong: Vec<String> = fields
            .iter()
            .filter(|f| !members.iter().any(|m| m.name.as_deref() == Some(f.name) && m.offset as usize == f.offset))
            .map(|f| f.name.to_string())
            .collect();
        if members.len() != fields.len() || *span as usize != size {
            wrong.push(format!("{name} has {span} bytes, the host {size}"));
        }
        wrong
    }

    #[test]
    fn every_module_is_valid_and_its_structs_are_the_hosts() {
        for module in &MODULES {
            let parsed = validated(&module.source()).unwrap_or_else(|e| panic!("{}: {e}", module.name));
            let view = mismatches(&parsed, ViewParams::NAME, ViewParams::FIELDS, size_of::<ViewParams>());
            assert_eq!(view, Vec::<String>::new(), "{}", module.name);
            let material =
                mismatches(&parsed, MaterialParams::NAME, MaterialParams::FIELDS, size_of::<MaterialParams>());
            assert_eq!(material, Vec::<String>::new(), "{}", module.name);
        }
    }

    #[test]
    fn a_broken_module_and_a_shifted_member_are_found() {
        let broken = SURFACE.source().replace("fn light_unit", "fn light_other");
        assert!(validated(&broken).is_err());
        let shifted = SOLID.source().replace("    lit: f32,", "    before: f32,\n    lit: f32,");
        let parsed = validated(&shifted).unwrap();
        let wrong = mismatches(&parsed, ViewParams::NAME, ViewParams::FIELDS, size_of::<ViewParams>());
        assert!(wrong.contains(&"lit".to_string()), "{wrong:?}");
    }

    #[test]
    fn every_file_of_the_folder_is_part_of_a_module() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/render");
        let sources: Vec<String> = MODULES.iter().map(Module::source).collect();
        let mut files = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
            assert!(sources.iter().any(|s| s.contains(&text)));
            files += 1;
        }
        assert_eq!(files, 4);
    }
}
