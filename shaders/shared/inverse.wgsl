// The inverse of an affine map, and its volume factor; the identity where there is none.
override INVERSE_FLAT: f32;

struct Inverse {
    matrix: mat4x4<f32>,
    volume: f32,
}

fn inverse_affine(m: mat4x4<f32>) -> Inverse {
    let x = m[0].xyz;
    let y = m[1].xyz;
    let z = m[2].xyz;
    let yz = math_cross(y, z);
    let volume = math_dot(x, yz);
    if abs(volume) < INVERSE_FLAT {
        return Inverse(mat4x4<f32>(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), volume);
    }
    let scale = 1.0 / volume;
    let a = yz * scale;
    let b = math_cross(z, x) * scale;
    let c = math_cross(x, y) * scale;
    let t = m[3].xyz;
    return Inverse(
        mat4x4<f32>(
            vec4<f32>(a.x, b.x, c.x, 0.0),
            vec4<f32>(a.y, b.y, c.y, 0.0),
            vec4<f32>(a.z, b.z, c.z, 0.0),
            vec4<f32>(-math_dot(a, t), -math_dot(b, t), -math_dot(c, t), 1.0),
        ),
        volume,
    );
}
