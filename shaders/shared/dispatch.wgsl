// Dispatches above 65535 workgroups are folded into rows; this finds a thread's place in the whole.
override DISPATCH_WORKGROUP: u32;

fn dispatch_index(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * DISPATCH_WORKGROUP + local;
}
