// Cached distance fields. Reads the global nodes.

// Whether grid coordinates lie inside a grid.
fn grid_holds(grid: GroupGrid, u: vec3<f32>) -> bool {
    let last = vec3<f32>(f32(grid.size_x - 1u), f32(grid.size_y - 1u), f32(grid.size_z - 1u));
    return all(u >= vec3<f32>(0.0)) && all(u <= last);
}

// Raw distance (w) and its gradient (xyz) of a group's grid at grid coordinates u inside it; the caller checks bounds.
fn grid_sample(grid: GroupGrid, u: vec3<f32>) -> vec4<f32> {
    let x = min(u32(u.x), grid.size_x - 2u);
    let y = min(u32(u.y), grid.size_y - 2u);
    let z = min(u32(u.z), grid.size_z - 2u);
    let t = u - vec3<f32>(f32(x), f32(y), f32(z));
    let row = grid.size_x;
    let slab = grid.size_x * grid.size_y;
    let at = grid.offset + x + row * y + slab * z;
    let n00 = nodes[at] + (nodes[at + 1u] - nodes[at]) * t.x;
    let n10 = nodes[at + row] + (nodes[at + row + 1u] - nodes[at + row]) * t.x;
    let n01 = nodes[at + slab] + (nodes[at + slab + 1u] - nodes[at + slab]) * t.x;
    let n11 = nodes[at + slab + row] + (nodes[at + slab + row + 1u] - nodes[at + slab + row]) * t.x;
    let n0 = n00 + (n10 - n00) * t.y;
    let n1 = n01 + (n11 - n01) * t.y;
    return n0 + (n1 - n0) * t.z;
}
