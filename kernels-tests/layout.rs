//! Every assembled kernel against its Rust table, by naga's reflection; no adapter is needed.

use naga::{
    AddressSpace, ShaderStage, StorageAccess, TypeInner,
    front::wgsl,
    valid::{Capabilities, ValidationFlags, Validator},
};
use sinew::kernel::{Access, KERNELS, Kernel, SharedStruct, source::assemble};

fn parse(text: &str) -> Result<naga::Module, String> {
    let module = wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
    Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).map_err(|e| format!("{e:?}"))?;
    Ok(module)
}

fn parsed(kernel: &Kernel) -> naga::Module {
    parse(&assemble(kernel).text).unwrap_or_else(|e| panic!("{}: {e}", kernel.stem))
}

/// What a table says, compared with what naga finds; the first disagreement.
fn check_bindings(kernel: &Kernel, module: &naga::Module) -> Result<(), String> {
    let mut seen = 0;
    for (_, global) in module.global_variables.iter() {
        let Some(resource) = &global.binding else { continue };
        let name = global.name.clone().unwrap_or_default();
        let binding = kernel.bindings.get(resource.binding as usize).ok_or(format!("slot {}", resource.binding))?;
        if resource.group != 0 || binding.name != name {
            return Err(format!("slot {} is `{name}`, the table has `{}`", resource.binding, binding.name));
        }
        let access = match global.space {
            AddressSpace::Uniform => Access::Uniform,
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Access::Write,
            AddressSpace::Storage { .. } => Access::Read,
            other => return Err(format!("`{name}` is {other:?}")),
        };
        if access != binding.access {
            return Err(format!("`{name}` is {access:?}, the table has {:?}", binding.access));
        }
        seen += 1;
    }
    if seen != kernel.bindings.len() {
        return Err(format!("{seen} bindings, the table has {}", kernel.bindings.len()));
    }
    Ok(())
}

fn check_struct(shared: &SharedStruct, module: &naga::Module) -> Result<(), String> {
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(shared.name))
        .ok_or(format!("`{}` is not declared", shared.name))?;
    let TypeInner::Struct { members, span } = &ty.inner else { return Err(format!("`{}` is no struct", shared.name)) };
    let found: Vec<_> = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize)).collect();
    let wanted: Vec<_> = shared.fields.iter().map(|f| (f.name.to_owned(), f.offset)).collect();
    if found != wanted || *span as usize != shared.size {
        return Err(format!("`{}`: naga {found:?} span {span}, Rust {wanted:?} size {}", shared.name, shared.size));
    }
    Ok(())
}

/// Every override has a value from the host and no default of its own, and the other way round.
fn check_constants(constants: &[(&str, f64)], module: &naga::Module) -> Result<(), String> {
    let mut found: Vec<_> =
        module.overrides.iter().map(|(_, o)| (o.name.clone().unwrap_or_default(), o.init)).collect();
    if let Some((name, _)) = found.iter().find(|(_, init)| init.is_some()) {
        return Err(format!("`{name}` has a value in WGSL too"));
    }
    let mut wanted: Vec<_> = constants.iter().map(|(name, _)| ((*name).to_owned(), None)).collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    wanted.sort_by(|a, b| a.0.cmp(&b.0));
    if found == wanted { Ok(()) } else { Err(format!("overrides {found:?}, the table has {wanted:?}")) }
}

#[test]
fn kernels_are_valid_and_agree_with_their_tables() {
    for kernel in &KERNELS {
        let module = parsed(kernel);
        check_bindings(kernel, &module).unwrap_or_else(|e| panic!("{}: {e}", kernel.stem));
        for shared in kernel.structs {
            check_struct(shared, &module).unwrap_or_else(|e| panic!("{}: {e}", kernel.stem));
        }
        check_constants(&kernel.all_constants(0), &module).unwrap_or_else(|e| panic!("{}: {e}", kernel.stem));
        let [entry] = module.entry_points.as_slice() else { panic!("{}: one entry point each", kernel.stem) };
        assert_eq!((entry.name.as_str(), entry.stage), ("main", ShaderStage::Compute), "{}", kernel.stem);
        assert_eq!(entry.workgroup_size, [kernel.workgroup, 1, 1], "{}", kernel.stem);
        let storage = kernel.bindings.iter().filter(|b| b.access != Access::Uniform).count();
        assert!(storage <= 8, "{}: {storage} storage buffers are more than WebGPU promises", kernel.stem);
    }
}

#[test]
fn a_wrong_binding_or_member_is_found() {
    let kernel = &KERNELS[0];
    let module = parsed(kernel);
    let mut bindings = kernel.bindings.to_vec();
    bindings.swap(1, 2);
    let swapped = Kernel { bindings: bindings.leak(), ..*kernel };
    assert!(check_bindings(&swapped, &module).is_err());
    let fewer = Kernel { bindings: &kernel.bindings[..2], ..*kernel };
    assert!(check_bindings(&fewer, &module).is_err());
    let shared = kernel.structs[1];
    assert!(check_struct(&SharedStruct { size: shared.size + 16, ..shared }, &module).is_err());
    assert!(check_struct(&SharedStruct { fields: &shared.fields[1..], ..shared }, &module).is_err());
}

#[test]
fn a_missing_or_repeated_constant_is_found() {
    let kernel = sinew::kernel::kernel(sinew::schedule::KernelId::TrackMarch);
    let module = parsed(kernel);
    let constants = kernel.all_constants(0);
    assert!(check_constants(&constants, &module).is_ok());
    assert!(check_constants(&constants[1..], &module).is_err());
    let own = parse("override A: f32 = 1.0;").expect("valid");
    assert!(check_constants(&[("A", 1.0)], &own).is_err());
}

#[test]
fn a_padded_struct_would_be_found() {
    // A vec3 followed by a vec3 leaves a gap in WGSL that Rust's arrays of three floats do not have.
    let module =
        parse("struct S { a: vec3<f32>, b: vec3<f32> }\n@group(0) @binding(0) var<storage> s: S;").expect("valid");
    let field = |name, offset| sinew::math::GpuField { name, wgsl: "vec3<f32>", offset };
    let shared = SharedStruct {
        name: "S",
        wgsl: String::new,
        fields: Box::leak(Box::new([field("a", 0), field("b", 12)])),
        size: 24,
    };
    assert!(check_struct(&shared, &module).is_err());
}

#[test]
fn broken_wgsl_is_refused() {
    assert!(parse("fn main() { let x = ; }").is_err());
}
