// Unit quaternions xyzw as rotations.
fn quaternion_matrix(q: vec4<f32>) -> mat3x3<f32> {
    let x2 = q.x + q.x;
    let y2 = q.y + q.y;
    let z2 = q.z + q.z;
    let xx = q.x * x2;
    let xy = q.x * y2;
    let xz = q.x * z2;
    let yy = q.y * y2;
    let yz = q.y * z2;
    let zz = q.z * z2;
    let wx = q.w * x2;
    let wy = q.w * y2;
    let wz = q.w * z2;
    return mat3x3<f32>(
        vec3<f32>(1.0 - (yy + zz), xy + wz, xz - wy),
        vec3<f32>(xy - wz, 1.0 - (xx + zz), yz + wx),
        vec3<f32>(xz + wy, yz - wx, 1.0 - (xx + yy)),
    );
}

// normalize(q + (omega, 0) q / 2).
fn quaternion_turned(q: vec4<f32>, omega: vec3<f32>) -> vec4<f32> {
    let half = omega * 0.5;
    let sum = vec4<f32>(q.xyz + half * q.w + math_cross(half, q.xyz), q.w - math_dot(half, q.xyz));
    return sum / sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z + sum.w * sum.w);
}
